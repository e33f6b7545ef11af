// Views: their sides, and what culling by them leaves out.
#include <catch2/catch.hpp>

#include <set>

#include "shared/terrain_data.h"
#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

std::set<std::uint32_t> drawn_tiles(Cut& cut) {
    std::set<std::uint32_t> tiles;
    for (const TileRange& range : cut_mesh(cut.cut).mesh.tiles) tiles.insert(range.tile);
    return tiles;
}

bool in_front(Cut& cut, const View& view, std::uint32_t tile) {
    const TileList& list = cut.state().mesh.tiles[tile];
    const Vec3 middle = list.centre_m;
    return dot(middle - view.eye_m, view.forward) > list.radius_m;
}

} // namespace

TEST_CASE("off-centre halves of a view draw exactly the tiles of the whole view") {
    Random random(491);
    std::size_t compared = 0, culled = 0;
    for (int round = 0; round < rounds(30, 200); ++round) {
        const auto pack = bake_and_load(random_dem(random, 100, 90, Shape::fractal), small_bake(3));
        const Terrain& terrain = pack.terrain;
        View whole = random_view(random, terrain);
        whole.far_m = 1e8;
        Cut one(terrain, ample_cut(terrain)), two(terrain, ample_cut(terrain, 2));
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        (void)one.update({&whole, 1}, settings);
        for (const bool across : {false, true}) {
            View halves[2] = {whole, whole};
            double& end = across ? halves[0].right : halves[0].top;
            const double low = across ? whole.left : whole.bottom;
            end = low + (end - low) * 0.5;
            (across ? halves[1].left : halves[1].bottom) = end;
            for (View& half : halves) (across ? half.width_px : half.height_px) /= 2;
            REQUIRE(validate(halves[0]).ok());
            (void)two.update(halves, settings);
            const auto all = drawn_tiles(one), parts = drawn_tiles(two);
            CAPTURE(round, across);
            for (const std::uint32_t tile : all) REQUIRE(parts.count(tile) == 1);
            // The planes of a half also let through spheres that reach behind the eye.
            for (const std::uint32_t tile : parts)
                if (in_front(one, whole, tile)) REQUIRE(all.count(tile) == 1);
            compared += all.size();
            culled += terrain.tile_count() - all.size();
        }
        // Half as many pixels for half the tangent: the same scale, so the same vertices.
        REQUIRE(active_set(one) == active_set(two));
    }
    REQUIRE(compared > 1000);
    REQUIRE(culled > 1000);
}

TEST_CASE("however wide a view is, no tile that it sees is left out") {
    Random random(492);
    std::size_t seen = 0;
    for (int round = 0; round < rounds(60, 400); ++round) {
        const auto pack = bake_and_load(random_dem(random, 70, 60, Shape::fractal), small_bake(3));
        const Terrain& terrain = pack.terrain;
        View view = random_view(random, terrain);
        const double fov = uniform(random, 0.2, 3.05);
        view = make_view(view.eye_m, view.forward, view.up, fov, 1280, 720, terrain.spacing_x_m() * 0.01, 1e8);
        if (round % 2) view.left = uniform(random, -9, 0.9) * view.right, view.bottom *= uniform(random, -0.9, 9);
        REQUIRE(validate(view).ok());
        Cut cut(terrain, ample_cut(terrain));
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        (void)cut.update({&view, 1}, settings);
        const auto drawn = drawn_tiles(cut);
        const Vec3 right = cross(view.forward, view.up);
        for (std::int32_t y = 0; y < data_of(terrain).tree.rows(); ++y)
            for (std::int32_t x = 0; x < data_of(terrain).tree.columns(); ++x) {
                const double height_m = static_cast<double>(data_of(terrain).height_m(SampleIndex{x, y}));
                const Vec3 p = Vec3{terrain.x_m(x), height_m, terrain.z_m(y)} - view.eye_m;
                const double ahead = dot(p, view.forward), u = dot(p, right), v = dot(p, view.up);
                if (ahead < view.near_m || u < view.left * ahead || u > view.right * ahead) continue;
                if (v < view.bottom * ahead || v > view.top * ahead) continue;
                const auto tile = static_cast<std::uint32_t>(y / 8) * terrain.header().tiles_x + x / 8u;
                if (x % 8 == 0 || y % 8 == 0) continue; // of two tiles
                CAPTURE(round, x, y, fov);
                REQUIRE(drawn.count(tile) == 1);
                ++seen;
            }
    }
    REQUIRE(seen > 10'000);
}

TEST_CASE("a view's scale is that of its finer side, and its corner factor that of its farthest corner") {
    View view;
    CHECK(focal_length_px(view) == 869.1168824543142);
    view.left = -2, view.right = 1, view.bottom = 0, view.top = 1, view.width_px = 3000, view.height_px = 1000;
    CHECK(focal_length_px(view) == 1000);
    CHECK(corner_factor(view) == 3.375); // sqrt(6), up to the next power of 1.5
    view.forward = {0, -1, 0}, view.up = {0, 0, -1};
    CHECK(corner_factor(view) == 6); // sqrt(5 * 6), but never more than 6
    view.forward = {0, 0, -1}, view.up = {0, 1, 0};
    view.width_px = 6000;
    CHECK(focal_length_px(view) == 2000);
    for (const auto side : {&View::left, &View::right, &View::bottom, &View::top}) {
        View bad = view;
        bad.*side = std::nan("");
        CHECK_FALSE(validate(bad).ok());
        bad.*side = side == &View::left || side == &View::bottom ? 1.5 : -3;
        CHECK_FALSE(validate(bad).ok());
    }
}
