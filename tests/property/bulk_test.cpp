// The bulk pass: the whole cut at once.
#include <catch2/catch.hpp>

#include "support/cut_scene.h"

using namespace fjell;
using namespace fjell::test;

TEST_CASE("a cut built at once is the same as one refined step by step, and lives on alike") {
    Random random(102);
    for (int round = 0; round < 150; ++round) {
        const auto pack = random_terrain(random, round % 5 == 4 ? 300 : 140, round % 5 == 4 ? 8 : 6);
        const Terrain& terrain = pack.terrain;
        Cut cut(terrain, ample_cut(terrain));
        View view = random_view(random, terrain);
        for (int frame = 0; frame < 8; ++frame) {
            if (pick(random, 0, 2) == 0) view = random_view(random, terrain);
            view = moved(random, view, random_step_m(random, terrain));
            CutSettings settings;
            settings.error_px = random_threshold(random);
            const CutReport report =
                frame % 2 == 0 ? cut.rebuild({&view, 1}, settings) : cut.update({&view, 1}, settings);
            CAPTURE(round, frame, settings.error_px, terrain.tree.tile_log2, terrain.tree.columns(),
                    terrain.tree.rows());
            REQUIRE(check_cut(cut) == "");
            REQUIRE(report.converged);
            REQUIRE(triangles_of(cut.mesh()) == recursive_triangles(terrain, view, settings.error_px));
        }
    }
}
