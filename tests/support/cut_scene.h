// Terrains, views and page arrivals for tests of the live cut.
#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "shared/terrain_data.h"
#include "support/cut_check.h"

namespace fjell::test {

// At rest within these frames or never: without item limits one update is enough, with a limit a host waits longer.
inline constexpr int patience_frames = 200'000;

[[nodiscard]] inline double random_threshold(Random& random) {
    return std::pow(10.0, uniform(random, -1.5, 2));
}

// Any shape, extent, tiling, order and nesting; holes in a quarter of them.
[[nodiscard]] inline io::LoadedPack random_terrain(Random& random, int most_samples, int most_log2) {
    const auto shape = static_cast<Shape>(pick(random, 0, static_cast<int>(Shape::count) - 1));
    const int log2 = pick(random, 1, most_log2);
    const int most = std::min(most_samples, 24 << log2);
    baker::Dem dem = random_dem(random, pick(random, 2, most), pick(random, 2, most), shape);
    if (pick(random, 0, 3) == 0) add_random_holes(random, dem, log2);
    baker::BakeOptions options = small_bake(log2, pick(random, 0, 3) ? 0.05 : 0.001);
    options.order = pick(random, 0, 3) == 0 ? PageOrder::hierarchical_z : PageOrder::planar;
    return bake_and_load(std::move(dem), options);
}

// A fractal without holes on which a frame has much to do.
[[nodiscard]] inline io::LoadedPack rich_terrain(Random& random, int samples, int tile_log2) {
    return bake_and_load(random_dem(random, samples, samples, Shape::fractal), small_bake(tile_log2));
}

// The same view somewhat further.
[[nodiscard]] inline View moved(Random& random, View view, double metres) {
    view.eye_m = view.eye_m + Vec3{uniform(random, -1, 1), uniform(random, -0.3, 0.3), uniform(random, -1, 1)} * metres;
    return view;
}
// And turned about a random axis.
[[nodiscard]] inline View turned(Random& random, View view, double most_rad) {
    const auto way = [&] {
        return Vec3{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)} * most_rad;
    };
    const View straight = make_view(view.eye_m, view.forward + way(), view.up + way(), 1, 4, 3, 1, 2);
    view.forward = straight.forward;
    view.up = straight.up;
    return view;
}
[[nodiscard]] inline double random_step_m(Random& random, const Terrain& terrain) {
    return terrain.spacing_x_m() * std::pow(10.0, uniform(random, -2, 1.5));
}

// Straight down from `height` extents above the middle.
[[nodiscard]] inline View view_from_above(const Terrain& terrain, double height) {
    const double x = terrain.x_m(data_of(terrain).tree.columns() - 1),
                 z = terrain.z_m(data_of(terrain).tree.rows() - 1);
    const double extent = std::max(x, z);
    return make_view({x / 2, terrain.header().max_m + height * extent, z / 2}, {0, -1, 0.01}, {0, 1, 0}, 1, 800, 600,
                     extent * 1e-4, extent * 1e3);
}

// Updates until nothing is left to do or, when a limit is given, at most so often.
inline CutReport settle(Cut& cut, std::span<const View> views, const CutSettings& settings,
                        int most_frames = patience_frames) {
    CutReport report;
    for (int frame = 0; frame < most_frames; ++frame) {
        report = cut.update(views, settings);
        if (report.converged) return report;
    }
    return report;
}

[[nodiscard]] inline std::vector<Triangle> recursive_triangles(const Terrain& terrain, const View& view,
                                                               double error_px, bool corner_safe = false) {
    Recursive method(terrain, ample_budget(terrain));
    RefineSettings settings;
    settings.max_error_px = error_px;
    settings.cull = false;
    settings.corner_safe = corner_safe;
    (void)method.update(view, settings);
    return triangles_of(method.mesh());
}

// As the vertex shader places them.
[[nodiscard]] inline std::vector<MeshVertex> drawn_vertices(const Terrain& terrain, const CutMesh& live) {
    std::vector<MeshVertex> drawn(live.mesh.vertices.begin(), live.mesh.vertices.end());
    for (std::size_t i = 0; i < live.morph.size(); ++i)
        drawn[i].height_m = morphed_height_m(terrain, live.mesh.vertices[i], live.morph[i], live.frame);
    return drawn;
}

// Everything that must hold after any frame whatever.
[[nodiscard]] inline std::string check_frame(Cut& cut, const Terrain& full, const CutReport& report,
                                             const CutSettings& settings) {
    if (std::string wrong = check_cut(cut); !wrong.empty()) return wrong;
    if (std::string wrong = check_surface(cut, full); !wrong.empty()) return wrong;
    if (report.work > settings.max_work) return "more items than allowed";
    if (report.error_px_requested != settings.max_error_px) return "the report asks for another threshold";
    if (report.error_bound_px < report.error_px_requested) return "the effective threshold is below the requested one";
    if (report.blocked > report.waiting) return "more is blocked than waits";
    const bool rests =
        report.waiting == 0 && report.morphing == 0 && report.error_bound_px <= report.error_px_requested;
    if (report.converged != rests) return "converged does not say what the rest does";
    return {};
}

} // namespace fjell::test
