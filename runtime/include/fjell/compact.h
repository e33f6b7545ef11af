// Smaller buffers on the GPU: 16 bytes a vertex instead of the 28 of MeshVertex and MorphVertex, and indices of 16
// bits. A host converts the runs of CutChanges while it copies them. The cut's own buffers stay as they are.
//
// Values are rounded so that a vertex is never drawn farther from its full height than the cut assumes. The full height
// itself is exact. compact_share() says what the rounding adds to the error on screen.
//
// Units: metres, and seconds of the cut's clock. The arrays are the host's. Thread: any. Takes nanoseconds a record.
// Allocates nothing and never fails: a value that is too large becomes the largest that the format has, and arrays of
// different lengths are converted up to the shortest length.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/cut.h"
#include "fjell/export.h"
#include "fjell/mesh.h"

FJELL_API_BEGIN
namespace fjell {

// A vertex and its morphing data. content/hosts/vulkan/terrain.glsl decodes it.
struct CompactVertex {
    std::uint16_t column, row; // the low 16 bits: the tile's place has the rest
    float height_m;            // unchanged
    // An IEEE half: from the full height to the height on the split edge, rounded towards 0.
    std::uint16_t rise;
    // Time of activation in steps of 1 / compact_steps_s seconds, rounded up, or compact_activated_long_ago.
    std::uint16_t activated;
    // 5 bits of exponent and 11 of mantissa, from 2^-10 m on, rounded up.
    std::uint16_t error, radius;
};
static_assert(sizeof(CompactVertex) == 16, "CompactVertex is uploaded: change terrain.glsl of content/hosts/vulkan");

inline constexpr std::uint16_t compact_activated_long_ago = 0xffff; // activated_long_ago_s
inline constexpr float compact_steps_s = 64;                        // 65,536 steps are a turn of the cut's clock
// A vertex may rise later by this much because of the rounding. Shaders subtract it from morph_s.
inline constexpr float compact_late_s = 0x1p-5f;
static_assert(morph_clock_s * compact_steps_s == 65536);

// Converts the slots of a run: the same part of CutMesh::mesh.vertices and of CutMesh::morph, which may be empty.
void compact_vertices(std::span<const MeshVertex> vertices, std::span<const MorphVertex> morphs,
                      std::span<CompactVertex> to);

// Bytes that an index needs, 2 or 4. An index names a slot of the cut's vertex buffer, and 16 bits can name 65,536 of
// them.
[[nodiscard]] constexpr std::uint32_t index_bytes(const CutBudget& budget) {
    return budget.vertices <= 65'536 ? 2 : 4;
}
// Converts the indices of a cut whose index_bytes() is 2. Of larger indices only the low 16 bits are kept.
void compact_indices(std::span<const std::uint32_t> indices, std::span<std::uint16_t> to);

// The largest error on screen that the rounding adds to a vertex that morphs by distance, as a share of the threshold:
// 0.6% with the nesting of most packs. Add this share of CutReport::threshold_px to CutReport::error_bound_px. Lengths
// below 2^-10 m are not included.
[[nodiscard]] double compact_share(const MorphView& view);

// What a shader decodes the fields to, in metres.
[[nodiscard]] float compact_rise_m(std::uint16_t rise);
[[nodiscard]] float compact_length_m(std::uint16_t error_or_radius);

} // namespace fjell
FJELL_API_END
