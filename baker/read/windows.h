// How a raster lies in blocks, and windows cut along them so that every block is decoded once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "baker/read/source.h"

namespace fjell::baker {

// Borders of blocks are at x + k * columns and y + k * rows, for every whole k.
struct Blocks {
    std::int32_t columns = 1, rows = 1, x = 0, y = 0;
};

// Windows of about `most` samples that cover the area once, in reading order: bands over its whole width where a row of
// blocks is not more than that (or a block is as wide as the area), else runs of blocks of one row. Only blocks that
// are wider than the area and larger than `most` are cut, between rows. O(windows).
[[nodiscard]] std::vector<Window> cut_along(const Window& area, const Blocks& blocks, std::size_t most);

} // namespace fjell::baker
