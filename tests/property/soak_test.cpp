// A long flight that teleports: no frame ever does more than its items, and the mesh stays whole.
#include <catch2/catch.hpp>

#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

TEST_CASE("in a long flight with random teleports no frame exceeds its items, its capacities or its mesh") {
    Random random(401);
    const auto pack = rich_terrain(random, 257, 6);
    const Terrain& terrain = pack.terrain;
    CutBudget budget = ample_cut(terrain);
    budget.vertices = 6'000; // too few now and then
    Cut cut(terrain, budget);
    CutSettings settings;
    settings.max_error_px = 2;
    View view = random_view(random, terrain);
    const auto frames = rounds<std::uint64_t>(20'000, 100'000);
    std::uint64_t converged = 0, governed = 0, changes = 0;
    for (std::uint64_t frame = 0; frame < frames; ++frame) {
        if (pick(random, 0, 60) == 0) view = random_view(random, terrain);
        if (pick(random, 0, 400) == 0) settings.max_work = static_cast<std::uint32_t>(pick(random, 1, 600));
        if (pick(random, 0, 900) == 0) settings.max_error_px = std::pow(10.0, uniform(random, -0.5, 1));
        view = moved(random, view, terrain.spacing_x_m() * 0.5);
        const CutReport report = cut.update({&view, 1}, settings);
        if (report.work > settings.max_work || report.vertices > budget.vertices)
            REQUIRE(report.work <= settings.max_work);
        converged += report.converged;
        governed += report.threshold_px > report.error_px_requested;
        changes += report.activations + report.deactivations;
        if (frame % 2'500 == 0) {
            CAPTURE(frame);
            REQUIRE(check_cut(cut) == "");
            REQUIRE(check_mesh(terrain, cut.mesh()) == "");
        }
    }
    CHECK(converged > frames / 10); // all of it was visited: lag, rest, a governed threshold
    CHECK(converged < frames / 20 * 19);
    CHECK(governed > frames / 1000);
    CHECK(changes > 10 * frames);
}
