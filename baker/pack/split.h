// A pack taken apart into a pack set: its chunks as they are, in packs of rectangles of its tiles.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "baker/pack/write_set.h"

namespace fjell::baker {

// Writes the folder's packs, and set.json last (write_set.h). The set then is the pack, chunk for chunk; rectangles
// without any ground are left out of it. progress(done, total): tiles. Throws Failure as PackFile and AtomicFile do, 2
// for more packs than tiles, 1 for a set that is given.
[[nodiscard]] SetSummary split_pack(const std::string& pack, const std::string& folder, const SetGrid& grid,
                                    const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

} // namespace fjell::baker
