// What the whole terrain says before its vertices are looked at: the vertical height scale, and the scales that errors
// and radii are counted on. All of them from bounds that one look at every sample gives, so that a vertex can be
// encoded without knowing the others (docs/notes/baking.md).
#pragma once

#include <cstdint>

#include "fjell/order.h"
#include "fjell/pack.h"
#include "fjell/record.h"
#include "fjell/tree.h"

namespace fjell::baker {

// Of any set of whole tiles; adding up in any order gives the same.
struct Survey {
    float least_m = HUGE_VALF, most_m = -HUGE_VALF;
    float tile_range_m = 0;   // the largest difference of heights within one tile
    float step_m[2] = {0, 0}; // the largest between neighbours along a row and along a column
    std::uint64_t voids = 0;  // samples that are holes; counted by whose tile they lie in, once each
    void add(const Survey& other);
};

// One tile's samples, borders included: columns x rows of them, `stride` floats from row to row.
[[nodiscard]] Survey survey_tile(const float* heights_m, std::int32_t columns, std::int32_t rows,
                                 std::ptrdiff_t stride);

// The vertical height scale: the source's own step when 65,536 of it span every tile (lossless); otherwise the smallest
// that does, but not less than a centimetre or a hundredth of the spacing. asked_m: 0, or the step to use; a Failure
// says the least possible one.
struct HeightScaleWish {
    double spacing_m[2] = {1, 1};
    double native_quantum_m = 0; // 0: not known
    double asked_m = 0;
};
[[nodiscard]] HeightScale choose_height_scale(const Survey& survey, const HeightScaleWish& wish);

// HeightScale steps of heights, to the nearest; halves upwards.
void quantise(const float* heights_m, std::size_t count, const HeightScale& height_scale, std::int32_t* steps);

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
    Survey survey;
    double nesting = 0.05;
};
[[nodiscard]] Scales choose_scales(const ScaleInput& input);

// A parent's sphere is larger by this factor than containment asks for: more than the roundings of a distance in float,
// so that spheres that touch nest in float arithmetic too.
inline constexpr double sphere_margin = 1 + 0x1p-16;

} // namespace fjell::baker
