// DESIGN invariants 1 and 4 to 8 on the live cut: random terrains, views, thresholds, budgets, pages.
#include <catch2/catch.hpp>

#include <cmath>

#include "fjell/measure.h"
#include "support/cut_check.h"

using namespace fjell;
using namespace fjell::test;

namespace {

double random_threshold(Random& random) {
    return std::pow(10.0, uniform(random, -1.5, 2));
}

host::LoadedPack random_terrain(Random& random, bool large = false) {
    const auto shape = static_cast<Shape>(pick(random, 0, static_cast<int>(Shape::count) - 1));
    const int log2 = pick(random, 1, large ? 8 : 6);
    const int most = std::min(large ? 300 : 140, 24 << log2);
    baker::Dem dem = random_dem(random, pick(random, 2, most), pick(random, 2, most), shape);
    if (pick(random, 0, 3) == 0) add_random_holes(random, dem, log2);
    baker::BakeOptions options = small_bake(log2, pick(random, 0, 3) ? 0.05 : 0.001);
    options.order = pick(random, 0, 3) == 0 ? Order::hierarchical_z : Order::planar;
    return bake_and_load(dem, options);
}

std::vector<Triangle> recursive_triangles(const Terrain& terrain, const View& view, double error_px) {
    Recursive method(terrain, ample_budget(terrain));
    RefineSettings settings;
    settings.error_px = error_px;
    settings.cull = false;
    (void)method.update(view, settings);
    return triangles_of(method.mesh());
}

View moved(Random& random, View view, double metres) {
    view.eye_m = view.eye_m + Vec3{uniform(random, -1, 1), uniform(random, -0.3, 0.3), uniform(random, -1, 1)} * metres;
    return view;
}

} // namespace

TEST_CASE("at rest the live cut is the recursive method's mesh, triangle for triangle") {
    Random random(101);
    for (int round = 0; round < 150; ++round) {
        const auto pack = random_terrain(random, round % 10 == 9);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        View view = random_view(random, terrain);
        double error_px = random_threshold(random);
        for (int frame = 0; frame < 12; ++frame) {
            switch (pick(random, 0, 5)) {
            case 0: view = random_view(random, terrain); break;
            case 1: error_px = random_threshold(random); break;
            default: view = moved(random, view, terrain.spacing_x_m * std::pow(10.0, uniform(random, -2, 1.5)));
            }
            CutSettings settings;
            settings.error_px = error_px;
            const CutReport report = cut.update({&view, 1}, settings);
            CAPTURE(round, frame, error_px, terrain.tree.tile_log2, terrain.tree.columns(), terrain.tree.rows());
            REQUIRE(check_cut(cut) == "");
            REQUIRE(report.converged);
            REQUIRE(triangles_of(cut.mesh()) == recursive_triangles(terrain, view, error_px));
            if (!terrain.has_voids()) REQUIRE(check_mesh(terrain, cut.mesh()) == "");
        }
    }
}
