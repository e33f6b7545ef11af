// Smaller buffers on the GPU: 16 bytes a vertex instead of the 28 of MeshVertex and MorphVertex, and indices of 16
// bits. A host converts the runs of CutChanges while it stages them; the cut's own buffers stay as they are.
//
// What does not fit is rounded so that a vertex is drawn nearer to its full height than the cut thinks, never farther
// from it. The full height is exact: a vertex that has arrived is where it was. compact_share() says what the rounding
// adds to the error on screen.
//
// Units: metres and seconds, of the cut's clock. Arrays are the host's. Thread: any. Nanoseconds a record. Allocates
// nothing, and never fails: what is too large becomes the largest there is, and arrays of different lengths are
// converted as far as the shortest goes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/cut.h"
#include "fjell/export.h"
#include "fjell/mesh.h"

FJELL_API_BEGIN
namespace fjell {

// content/hosts/vulkan/terrain.glsl takes it apart.
struct CompactVertex {
    std::uint16_t column, row;   // the low 16 bits: who draws knows the tile, and so the rest
    float height_m;              // as it is
    std::uint16_t rise;          // an IEEE half: from the full height to the flat one; rounded towards 0
    std::uint16_t activated;     // when, in compact_steps_s-ths of a second, rounded up; or compact_activated_long_ago
    std::uint16_t error, radius; // 5 bits of exponent and 11 of mantissa, from 2^-10 m on; rounded up
};
static_assert(sizeof(CompactVertex) == 16, "CompactVertex is uploaded: change terrain.glsl of content/hosts/vulkan");

inline constexpr std::uint16_t compact_activated_long_ago = 0xffff; // activated_long_ago_s
inline constexpr float compact_steps_s = 64;                        // 65,536 steps are a turn of the cut's clock
inline constexpr float compact_late_s = 0x1p-5f; // a vertex rises up to so much later: shaders take it off morph_s
static_assert(morph_clock_s * compact_steps_s == 65536);

// The slots of a run: subspans of CutMesh::mesh.vertices and CutMesh::morph.
void compact_vertices(std::span<const MeshVertex> vertices, std::span<const MorphVertex> morphs,
                      std::span<CompactVertex> to);

// Bytes that an index needs, 2 or 4. It names a slot of the cut's vertex buffer, so 65,536 of them are the most that 16
// bits hold, and the budget decides.
[[nodiscard]] constexpr std::uint32_t index_bytes(const CutBudget& budget) {
    return budget.vertices <= 65'536 ? 2 : 4;
}
// Indices of a cut whose index_bytes() are 2. Of others the low 16 bits.
void compact_indices(std::span<const std::uint32_t> indices, std::span<std::uint16_t> to);

// So much of the threshold, at most, is a vertex that morphs by distance off on screen: 0.6% at the nesting of most
// packs. Add it to CutReport::error_bound_px, in shares of CutReport::threshold_px. Metres below 2^-10 aside.
[[nodiscard]] double compact_share(const MorphView& view);

// What a shader makes of the fields, in metres.
[[nodiscard]] float compact_rise_m(std::uint16_t rise);
[[nodiscard]] float compact_length_m(std::uint16_t error_or_radius);

} // namespace fjell
FJELL_API_END
