// Heights, rays and patches of heights for gameplay and physics, on any thread, while the frame's thread updates.
//
// The surface is the full-resolution surface of right isosceles triangles. Where pages are missing it is a coarser
// level of that surface. The answers do not depend on the mesh that is drawn. Every answer has an error in metres,
// error_m. With estimate max (PackHeader::estimate) that is a bound: the original ground is not farther away. With
// estimate midpoint it is a likely size only, and a ray may miss a peak whose error is too small. With all pages loaded
// the surface has no gaps. While pages are missing, answers on the two sides of a page's border may differ by their
// errors.
// Positions: scene axes, metres. Threads: any number, beside the one that loads and unloads pages (load_page,
// insert_page, unload_page, update_stream). No call locks or waits. The terrain must outlive the call. Nothing is
// allocated. Complexity: O(levels) for a height, and O(levels) for each crossing or near miss of a ray.
// docs/notes/queries.md says how it works and what it costs.
#pragma once

#include <cstdint>
#include <span>

#include "fjell/export.h"
#include "fjell/sample_index.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell {

// The answer of ground_height().
struct GroundHeight {
    // The position is over the terrain. If not, the answer is that of the nearest point of the rim.
    bool inside = false;
    // The ground has a hole here. height_m continues the ground around the hole.
    bool hole = false;
    // The surface is that of the full resolution, or equal to it.
    bool finest = false;
    double height_m = 0;
    Vec3 normal{0, 1, 0}; // unit normal of the triangle
    // The original ground is within this of height_m. At the full resolution that is half a quantum.
    float error_m = 0;
};
// The height of the ground at a place. accurate_m: an error that is good enough; a larger one makes the call a little
// cheaper. NaN and infinite positions are not inside.
// Example:
//     const fjell::GroundHeight below = fjell::ground_height(ground.terrain(), eye_m.x, eye_m.z);
//     const double clearance_m = below.inside && !below.hole ? eye_m.y - below.height_m : 1e9;
[[nodiscard]] GroundHeight ground_height(const Terrain& terrain, double x_m, double z_m, float accurate_m = 0);

// The answer of cast_ray().
struct GroundHit {
    bool hit = false;
    bool finest = false;
    double distance_m = 0; // along the ray
    Vec3 position_m;
    Vec3 normal{0, 1, 0};
    float error_m = 0; // vertical, as in GroundHeight
};
// Finds the first place at which a ray meets the ground, from above or below. A ray passes through holes. direction: of
// any length but 0. most_m: how far to look; infinity is allowed. A vertical ray works. An origin on the ground is a
// hit at distance 0. A ray from outside the terrain enters it through its sides. With NaN in the arguments nothing is
// hit. Uses some 12 KB of stack.
// Example:
//     const fjell::GroundHit hit = fjell::cast_ray(ground.terrain(), eye_m, view.forward, 10'000);
//     if (hit.hit) std::printf("ground %.1f m away, to %.2f m\n", hit.distance_m, hit.error_m);
[[nodiscard]] GroundHit cast_ray(const Terrain& terrain, Vec3 origin_m, Vec3 direction, double most_m,
                                 float accurate_m = 0);

inline constexpr std::uint32_t max_patch_side = 4097;
// The answer of ground_patch().
struct GroundPatch {
    // The largest error at the samples. Between the samples of a coarse step the ground differs more.
    float error_m = 0;
    // Every height is the pack's own.
    bool finest = false;
};
// Heights of side x side samples, row by row from `first` on. Neighbours are 2^step_log2 samples apart, with step_log2
// 0 to 12. side: 2 to max_patch_side; 33 and 65 suit most physics engines. A sample beyond the terrain's rim gets the
// height at the rim. heights_m: side * side values. holes: as many, or empty when they are not wanted.
// With step_log2 0 the full-resolution surface has two triangles in each cell. If the sum of column and row of the
// cell's north-western sample is even, the cell is divided from north-west to south-east; otherwise from north-east to
// south-west. A triangle with a corner in a hole is no ground.
// With arguments out of range, or spans that are too short, the spans stay as they are and error_m is infinite.
// Example:
//     std::vector<float> heights_m(33 * 33);
//     const fjell::GroundPatch patch = fjell::ground_patch(ground.terrain(), {32, 64}, 0, 33, heights_m);
GroundPatch ground_patch(const Terrain& terrain, SampleIndex first, int step_log2, std::uint32_t side,
                         std::span<float> heights_m, std::span<bool> holes = {});

} // namespace fjell
FJELL_API_END
