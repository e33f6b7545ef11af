// A pack taken apart into a pack set: its chunks as they are, in packs of rectangles of its tiles.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace fjell::baker {

struct SplitOptions {
    std::uint32_t packs_x = 2, packs_y = 2; // as many as there are tiles at most
};
struct SplitSummary {
    std::uint32_t packs = 0, left_out = 0; // left out: without any ground
    std::uint64_t file_bytes = 0;
};
// Writes the folder's packs, and set.json last. The set then is the pack, chunk for chunk; rectangles without any
// ground are left out of it. progress(done, total): tiles. Throws Failure as PackFile and AtomicFile do, 2 for more
// packs than tiles, 1 for a set that is given.
[[nodiscard]] SplitSummary split_pack(const std::string& pack, const std::string& folder, const SplitOptions& options,
                                      const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

} // namespace fjell::baker
