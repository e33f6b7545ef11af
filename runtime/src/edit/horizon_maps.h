// Horizon maps over ground that stamps have moved. The pack's horizons stand; where moved ground is near, or has moved
// under a texel, they rise to what the ground shows now. They never sink below the pack's: how much of one is due to
// ground that is gone, nobody knows. Units: samples.
#pragma once

#include <cstddef>
#include <cstdint>

#include "shared/stamp.h"
#include "shared/terrain_data.h"

namespace fjell::edit {

// Farther away moved ground counts for nothing: d metres of it turn a horizon by d / (128 * spacing) radians at most.
inline constexpr std::int32_t horizon_reach = 128;

// The frame's thread: bounds all edited samples that horizons of a tile may see.
[[nodiscard]] Rect edited_near(const TerrainData& terrain, std::uint32_t tile);

// Any thread. Raises the horizons of a mip as the pack stores it, and dims its sky. edited: edited_near(). Pages that
// are not loaded hide nothing.
void raise_horizons(const TerrainData& terrain, const Rect& edited, std::uint32_t tile, std::uint32_t side_log2,
                    std::byte* blocks);

} // namespace fjell::edit
