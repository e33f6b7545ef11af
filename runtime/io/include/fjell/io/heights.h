// All heights of a pack, read from its file: what the renderer's error mode compares with (HeightGrid in
// fjell/gl/renderer.h).
//
// The same heights as of a terrain that is loaded whole, bit for bit. Of a terrain with more samples than the caller
// has room for, every 2^step_log2-th, with the least step that suffices; where the last one would lie beyond the rim it
// stands at the rim. Memory: 4 bytes a sample, and the pages of one tile, 4 bytes a vertex. Thread: any;
// it reads the file, so not the frame's. O(samples), some 0.04 us each. Throws Failure with exit code 1 for a pack that
// is damaged or has more tiles than fit, 3 for a disk that fails.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "fjell/export.h"
#include "fjell/io/pack_file.h"
#include "fjell/pack.h"

FJELL_API_BEGIN
namespace fjell::io {

// Every 2^step_log2-th sample.
struct FullHeights {
    std::int32_t columns = 0, rows = 0;
    std::uint32_t step_log2 = 0;
    std::vector<float> heights_m; // row by row; NaN: a hole
};

// Called after every tile with the share that is done; false: stop.
using GoOn = std::function<bool(double share)>;

// Nothing when it was stopped.
[[nodiscard]] std::optional<FullHeights> read_heights(const PackFile& file, std::uint64_t max_samples,
                                                      const GoOn& go_on = {});
// Of a pack whose bytes are in memory; path: for messages.
[[nodiscard]] std::optional<FullHeights> read_heights(const Pack& pack, const std::string& path,
                                                      std::uint64_t max_samples, const GoOn& go_on = {});

} // namespace fjell::io
FJELL_API_END
