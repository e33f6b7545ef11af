// All heights of a pack, read from its file. The renderer's error mode compares with them (HeightGrid in
// fjell/gl/renderer.h).
//
// The heights are those of a terrain that is loaded whole, bit for bit. A terrain may have more samples than the caller
// has room for. Then every 2^step_log2-th sample is read, with the smallest step that fits. If the last one would be
// beyond the rim, it is at the rim. Memory: 4 bytes a sample, and the pages of one tile, 4 bytes a vertex. Thread: any,
// but not the frame's, because it reads the file. O(samples), some 0.04 us each. Throws Failure with exit code 1 for a
// pack that is damaged or has more tiles than fit, and with 3 if the disk fails.
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

// Every 2^step_log2-th sample of a terrain.
struct FullHeights {
    std::int32_t columns = 0, rows = 0;
    std::uint32_t step_log2 = 0;
    std::vector<float> heights_m; // row by row; NaN: a hole
};

// Called after every tile with the share that is done. Return false to stop.
using GoOn = std::function<bool(double share)>;

// Reads at most max_samples heights. Returns nothing if go_on stopped it.
[[nodiscard]] std::optional<FullHeights> read_heights(const PackFile& file, std::uint64_t max_samples,
                                                      const GoOn& go_on = {});
// The same for a pack whose bytes are in memory. path: for messages.
[[nodiscard]] std::optional<FullHeights> read_heights(const Pack& pack, const std::string& path,
                                                      std::uint64_t max_samples, const GoOn& go_on = {});

} // namespace fjell::io
FJELL_API_END
