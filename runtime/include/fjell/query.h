// Heights and rays for gameplay and physics, from any thread while the frame's thread updates.
//
// Answers come from the finest ground that is loaded, whatever the mesh shows: the full-resolution
// surface of right isosceles triangles, or a coarser level of it where pages are missing. Every answer says how far
// the original ground may be from it; with estimate max (PackHeader::estimate) that is a bound, else a likely size, and
// a ray may pass a peak that no error speaks of. With all pages loaded the surface has no gaps; where some are missing,
// answers on both sides of a page's border may differ by their errors.
// Positions: scene axes, metres. Threads: any number, beside the one that loads and unloads pages (load_page,
// insert_page, unload_page, update_stream); nothing waits, nothing is locked. The terrain must outlive the call.
// Allocates nothing. Complexity: O(levels) for a height; for a ray O(levels) a crossing or near miss.
// How it works, and what it costs: docs/notes/queries.md.
#pragma once

#include <cstdint>
#include <span>

#include "fjell/export.h"
#include "fjell/sample_index.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell {

// What ground_height() answers.
struct GroundHeight {
    bool inside = false; // the position is over the terrain; otherwise the rest is of the nearest point of its rim
    bool hole = false;   // no ground there; the height is what the ground around it suggests
    bool finest = false; // of the full resolution, or no different from it
    double height_m = 0;
    Vec3 normal{0, 1, 0}; // of the triangle, unit length
    float error_m = 0; // the original ground is within this of height_m: 0 at the full resolution, plus half a quantum
};
// accurate_m: good enough; a larger one is a little cheaper. Positions that are no numbers are not inside.
// Example:
//     const fjell::GroundHeight below = fjell::ground_height(ground.terrain(), eye_m.x, eye_m.z);
//     const double clearance_m = below.inside && !below.hole ? eye_m.y - below.height_m : 1e9;
[[nodiscard]] GroundHeight ground_height(const Terrain& terrain, double x_m, double z_m, float accurate_m = 0);

// What cast_ray() answers.
struct GroundHit {
    bool hit = false;
    bool finest = false;
    double distance_m = 0; // along the ray
    Vec3 position_m;
    Vec3 normal{0, 1, 0};
    float error_m = 0; // vertical, as above
};
// The first place at which the ray meets the ground, from above or below; holes let it through. direction: any length
// but 0. most_m: how far to look, infinity if need be. A vertical ray works too; an origin on the ground is a hit at 0,
// and one outside the terrain enters it through its sides. Numbers that are none meet nothing. Uses some 12 KB of
// stack.
// Example:
//     const fjell::GroundHit hit = fjell::cast_ray(ground.terrain(), eye_m, view.forward, 10'000);
//     if (hit.hit) std::printf("ground %.1f m away, to %.2f m\n", hit.distance_m, hit.error_m);
[[nodiscard]] GroundHit cast_ray(const Terrain& terrain, Vec3 origin_m, Vec3 direction, double most_m,
                                 float accurate_m = 0);

inline constexpr std::uint32_t max_patch_side = 4097;
// What ground_patch() answers.
struct GroundPatch {
    float error_m = 0;   // at the samples: the largest; between them a coarse step differs more
    bool finest = false; // every sample is the pack's own
};
// Heights of side x side samples, 2^step_log2 apart, from `first` on, row by row: 33 or 65 a side suit most physics
// engines, any from 2 to max_patch_side works. Samples beyond the rim are the rim's. holes: one a sample, or empty.
// At step_log2 0 the full-resolution surface is two triangles a cell: divided from north-west to south-east where the
// column and the row of the cell's north-western sample have an even sum, and from north-east to south-west elsewhere.
// There is no ground in a triangle with a corner that is a hole.
// step_log2: 0 to 12. What does not fit, spans that are too short among it, leaves them alone: error_m is infinite
// then.
// Example:
//     std::vector<float> heights_m(33 * 33);
//     const fjell::GroundPatch patch = fjell::ground_patch(ground.terrain(), {32, 64}, 0, 33, heights_m);
GroundPatch ground_patch(const Terrain& terrain, SampleIndex first, int step_log2, std::uint32_t side,
                         std::span<float> heights_m, std::span<bool> holes = {});

} // namespace fjell
FJELL_API_END
