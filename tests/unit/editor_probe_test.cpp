// The probe against the obvious ways to know the same: queries, and every triangle of the mesh looked at.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "editor/contours.h"
#include "editor/measures.h"
#include "editor/probe.h"
#include "fjell/query.h"
#include "session/camera.h"
#include "session/session.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::editor;
using namespace fjell::test;

namespace {

// A session over random ground, its mesh as a random camera above it wants it.
struct ProbedTerrain {
    ProbedTerrain(Random& random, fjell::Method method) {
        (void)baker::bake(random_dem(random, pick(random, 70, 190), pick(random, 70, 190), Shape::fractal),
                          small_bake(5), folder / "t.fjell");
        session::FlightOptions options;
        options.pack = folder / "t.fjell";
        options.profile.method = method;
        options.profile.refine.max_error_px = 3;
        options.profile.width_px = 640;
        options.profile.height_px = 360;
        session::open_session(options, session);
        const session::Ground ground = session.ground();
        const double x = uniform(random, 0, ground.extent_x_m), z = uniform(random, 0, ground.extent_z_m);
        session::FreeCamera camera;
        camera.position_m = {x, ground.height_m(x, z) + uniform(random, 0.02, 0.4) * ground.longer_m(), z};
        session::look(camera, uniform(random, -3, 3), uniform(random, -1.2, -0.1));
        view = session::view_of(camera.pose(), session.terrain(), options.profile);
        for (int i = 0; i < 3; ++i) (void)session::update_frame(session, view, options.profile, i * 0.1);
    }
    TemporaryFolder folder;
    session::Session session;
    View view;
};

// Levels of all triangles that hold the place, on their edges too.
std::vector<int> levels_over(const session::Session& session, const Vec3& place) {
    const MeshView mesh = session.mesh();
    const PackHeader& h = session.terrain().header();
    const double column = place.x / h.spacing_m[0], row = place.z / h.spacing_m[1];
    const std::size_t step = mesh.topology == Topology::strip ? 1 : 3;
    std::vector<int> levels;
    for (const TileRange& range : mesh.tiles)
        for (std::size_t i = 0; i + 3 <= range.index_count; i += step) {
            const auto vertex = [&](std::size_t k) { return mesh.vertices[mesh.indices[range.first_index + i + k]]; };
            const MeshVertex corners[] = {vertex(0), vertex(1), vertex(2)};
            const int level = triangle_level(corners[0], corners[1], corners[2], h.tile_log2);
            if (level < 0) continue;
            int left = 0, right = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const MeshVertex &a = corners[k], &b = corners[(k + 1) % 3];
                const double side = (b.column - a.column) * (row - a.row) - (b.row - a.row) * (column - a.column);
                left += side > -1e-6;
                right += side < 1e-6;
            }
            if (left == 3 || right == 3) levels.push_back(level);
        }
    return levels;
}

void check_place(ProbedTerrain& terrain, Probe& probe, double x, double y) {
    const session::Session& session = terrain.session;
    CAPTURE(x, y);
    probe.pointer = std::array{x, y};
    update_probe(probe, session, terrain.view, terrain.view, false);
    if (!probe.ground) return;
    const ProbedGround g = *probe.ground;
    const auto back = place_in(terrain.view, g.position_m);
    REQUIRE(back);
    CHECK((*back)[0] == Approx(x).margin(1e-6));
    CHECK((*back)[1] == Approx(y).margin(1e-6));
    const GroundHeight plain = ground_height(session.terrain(), g.position_m.x, g.position_m.z);
    CHECK(g.position_m.y == Approx(plain.height_m).margin(1e-3));
    CHECK(g.finest);
    CHECK(g.distance_m == Approx(length(g.position_m - terrain.view.eye_m)));
    CHECK(g.slope_rad >= 0);
    const PackHeader& h = session.terrain().header();
    CHECK(std::abs(g.sample.column * h.spacing_m[0] - g.position_m.x) <= 0.5001 * h.spacing_m[0]);
    CHECK(std::abs(g.sample.row * h.spacing_m[1] - g.position_m.z) <= 0.5001 * h.spacing_m[1]);
    CHECK(g.tile_x < h.tiles_x);
    CHECK(g.tile_y < h.tiles_y);
    for (int i = 0; i < 100 && probe.looking; ++i) update_probe(probe, session, terrain.view, terrain.view, false);
    REQUIRE_FALSE(probe.looking);
    const std::vector<int> levels = levels_over(session, g.position_m);
    REQUIRE(probe.ground->mesh.has_value() == !levels.empty());
    if (levels.empty()) return;
    CHECK(std::find(levels.begin(), levels.end(), probe.ground->mesh->level) != levels.end());
    CHECK(probe.ground->mesh->error_px <= 3.001); // what the session was asked to keep
    CHECK(probe.ground->mesh->error_px == Approx(focal_length_px(terrain.view) / g.distance_m *
                                                 std::abs(probe.ground->mesh->height_m - g.position_m.y)));
}

} // namespace

TEST_CASE("the probe tells the ground under the pointer, its tile, and the triangle that is drawn there") {
    std::size_t found = 0;
    for (unsigned seed = 0; seed < rounds<unsigned>(6, 60); ++seed) {
        INFO("seed " << seed);
        Random random(seed);
        ProbedTerrain terrain(random, seed % 3 == 2 ? fjell::Method::recursive : fjell::Method::incremental);
        Probe probe;
        update_probe(probe, terrain.session, terrain.view, terrain.view, true);
        CHECK_FALSE(probe.ground); // it is off, and costs nothing
        probe.on = true;
        for (int i = 0; i < 40; ++i) {
            check_place(terrain, probe, uniform(random, 0, 1), uniform(random, 0, 1));
            found += probe.ground && probe.ground->mesh;
        }
        check_place(terrain, probe, 0.5, 0.5);
        const std::optional<ProbedGround> before = probe.ground;
        update_probe(probe, terrain.session, terrain.view, terrain.view, false);
        CHECK_FALSE(probe.looking); // nothing has changed: an editor at rest stays so
        CHECK(probe.ground.has_value() == before.has_value());
        probe.on = false;
        update_probe(probe, terrain.session, terrain.view, terrain.view, true);
        CHECK_FALSE(probe.ground);
    }
    CHECK(found > 40);
}

TEST_CASE("two marks give the heights on the way from one to the other, and a third one goes on from there") {
    Random random(3);
    const ProbedTerrain terrain(random, fjell::Method::incremental);
    const session::Ground ground = session::ground_of(terrain.session.terrain());
    Probe probe;
    const double ax = 0.1 * ground.extent_x_m, az = 0.8 * ground.extent_z_m, bz = 0.2 * ground.extent_z_m;
    set_mark(probe, terrain.session, ax, az);
    CHECK(probe.marks == 1);
    CHECK(probe.mark_m[0].y == ground_height(terrain.session.terrain(), ax, az).height_m);
    set_mark(probe, terrain.session, 1e9, bz); // clamped to the terrain
    REQUIRE(probe.marks == 2);
    CHECK(probe.mark_m[1].x == ground.extent_x_m);
    const HeightProfile& p = probe.profile;
    CHECK(p.length_m == Approx(std::hypot(ground.extent_x_m - ax, bz - az)));
    for (std::size_t i = 0; i < p.samples; ++i) {
        const double t = static_cast<double>(i) / (p.samples - 1);
        const double x = ax + t * (ground.extent_x_m - ax), z = az + t * (bz - az);
        CHECK(p.height_m[i] == static_cast<float>(ground_height(terrain.session.terrain(), x, z).height_m));
        CHECK(p.height_m[i] >= p.lowest_m);
        CHECK(p.height_m[i] <= p.highest_m);
    }
    const double first_m = p.length_m, ground_m = p.ground_length_m;
    CHECK(ground_m >= first_m);
    CHECK(p.area_m2 == 0);
    set_mark(probe, terrain.session, 1, 1);
    CHECK(probe.marks == 3);
    CHECK(p.length_m == Approx(first_m + std::hypot(ground.extent_x_m - 1, bz - 1)));
    CHECK(p.ground_length_m > ground_m);
    // Half the cross product of two of its edges.
    CHECK(p.area_m2 == Approx(std::abs((ground.extent_x_m - ax) * (1 - az) - (bz - az) * (1 - ax)) / 2));
    CHECK(p.ground_area_m2 > p.area_m2);
    remove_mark(probe, terrain.session);
    CHECK(probe.marks == 2);
    CHECK(p.length_m == first_m);
    CHECK(p.ground_length_m == ground_m);
    CHECK(p.area_m2 == 0);
    for (std::size_t i = 0; i < 2 * most_marks; ++i) set_mark(probe, terrain.session, 5.0 * static_cast<double>(i), az);
    CHECK(probe.marks == most_marks);
}

TEST_CASE("a number beside a contour is the height of the ground there, and none is shown while the view moves") {
    std::size_t labels = 0;
    for (unsigned seed = 0; seed < rounds<unsigned>(4, 40); ++seed) {
        INFO("seed " << seed);
        Random random(seed);
        const ProbedTerrain terrain(random, fjell::Method::incremental);
        const PackHeader& h = terrain.session.terrain().header();
        const double every_m = std::max(static_cast<double>(h.max_m - h.min_m) / 40, 0.01);
        ContourLabels found;
        update_contour_labels(found, terrain.session.terrain(), terrain.view, every_m, false, 40);
        CHECK(found.count == 0); // the view has only just come here
        update_contour_labels(found, terrain.session.terrain(), terrain.view, every_m, false, 40);
        labels += found.count;
        for (std::size_t i = 0; i < found.count; ++i) {
            const ContourLabel& l = found.all[i];
            CHECK(std::abs(std::remainder(l.height_m, every_m)) < 1e-6 * std::max(std::abs(l.height_m), 1.0));
            const GroundHit hit = cast_ray(terrain.session.terrain(), terrain.view.eye_m,
                                           direction_at(terrain.view, l.x, l.y), terrain.view.far_m);
            REQUIRE(hit.hit);
            CHECK(hit.position_m.y == Approx(l.height_m).margin(0.1001 * every_m));
        }
        View moved = terrain.view;
        moved.eye_m.y += 1;
        update_contour_labels(found, terrain.session.terrain(), moved, every_m, false, 40);
        CHECK(found.count == 0);
    }
    CHECK(labels > 4);
}
