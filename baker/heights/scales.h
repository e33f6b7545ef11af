// The vertical height scale, and the scales that errors and radii are counted on. All of them follow from bounds, so
// that a vertex can be encoded without knowing the others (docs/notes/baking.md).
#pragma once

#include <cstddef>
#include <cstdint>

#include "baker/heights/statistics.h"
#include "fjell/pack.h"
#include "shared/order.h"
#include "shared/record.h"
#include "shared/tree.h"

namespace fjell::baker {

// The vertical height scale: the source's own step when 65,536 of it span every tile (lossless); otherwise the smallest
// that does, but not less than a centimetre or a hundredth of the spacing. asked_m: 0, or the step to use; a Failure
// says the least possible one.
struct HeightScaleRequest {
    double spacing_m[2] = {1, 1};
    double native_quantum_m = 0; // 0: not known
    double asked_m = 0;
    std::int32_t tile_cells = 0; // for the message; 0: not known
};
// The coarsest step that the largest range of heights within a tile needs.
[[nodiscard]] double least_quantum_m(const HeightStatistics& heights);
[[nodiscard]] HeightScale choose_height_scale(const HeightStatistics& heights, const HeightScaleRequest& request);

// HeightScale steps of heights, to the nearest; halves upwards.
void quantise(const float* heights_m, std::size_t count, const HeightScale& height_scale, std::int32_t* steps);
// Whether these steps give the heights that they were made from, bit for bit.
[[nodiscard]] bool lie_on(const HeightScale& height_scale, const float* heights_m, const std::int32_t* steps,
                          std::size_t count);

// The scales of a pack.
struct Scales {
    HeightScale height_scale;
    float floor_m = 1, ratio = 1.05f; // of errors
    std::uint32_t nesting_steps = 1;
    ErrorScale errors;
    RadiusScale radii = RadiusScale::make();
    float level_radius_m[2 * max_tile_log2] = {};
    // What a distance between two vertices may be larger by where the runtime places them, in float: along the ground
    // and in height; and by how much heights were off before.
    double ground_pad_m = 0, height_pad_m = 0, half_quantum_m = 0;
};
struct ScaleInput {
    Tree tree;
    double spacing_m[2] = {1, 1};
    HeightScale height_scale;
    HeightStatistics heights;
    double nesting = 0.05;
    bool room_for_holes = false; // even if there are none
    bool room_for_locks = false; // errors have codes for vertices that are always drawn
    double sharpest_lock = 1;    // how much more than they are errors may count
};
[[nodiscard]] Scales choose_scales(const ScaleInput& input);

} // namespace fjell::baker
