// The error mode: every pixel's colour is the error that is drawn there, measured by other means.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "baker/georeference/open_source.h"
#include "fjell/gl/palette.h"
#include "fjell/io/heights.h"
#include "fjell/measure.h"
#include "picture_scene.h"
#include "shared/terrain_data.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace pictures;
using test::pick;
using test::uniform;

namespace {

baker::Dem mountains(int columns, int rows) {
    return baker::synthesise_text(R"({"columns": )" + std::to_string(columns) + R"(, "rows": )" + std::to_string(rows) +
                                  R"(, "spacing_m": 30, "seed": 7, "base_m": 0, "relief_m": 2500, "feature_m": 9000})");
}

io::FullHeights heights_of(const Scene& scene, std::uint64_t most = ~std::uint64_t{0}) {
    auto heights = io::read_heights(scene.loaded.pack, scene.loaded.path, most);
    REQUIRE(heights);
    return std::move(*heights);
}
gl::HeightGrid grid_of(const io::FullHeights& heights) {
    return {heights.columns, heights.rows, heights.step_log2, heights.heights_m};
}
void give(Scene& scene, const io::FullHeights& heights) {
    scene.renderer->set_heights(grid_of(heights));
}

// The grid's surface at a place, in samples; NaN over holes. Which way a square is cut is the tree's to say.
double surface_m(const Tree& tree, const io::FullHeights& g, double column, double row) {
    const std::int32_t step = 1 << g.step_log2;
    const std::int32_t x = std::clamp(static_cast<std::int32_t>(std::floor(column)) >> g.step_log2, 0, g.columns - 2),
                       y = std::clamp(static_cast<std::int32_t>(std::floor(row)) >> g.step_log2, 0, g.rows - 2);
    const SampleIndex nw{x * step, y * step};
    const bool falls = step == 1 ? (x + y) % 2 == 0 : diamond(tree, nw + SampleIndex{step / 2, step / 2}).ends[0] == nw;
    const double u = (column - nw.column) / (std::min(nw.column + step, tree.columns() - 1) - nw.column),
                 v = (row - nw.row) / (std::min(nw.row + step, tree.rows() - 1) - nw.row);
    const auto h = [&](std::int32_t i, std::int32_t j) {
        return static_cast<double>(g.heights_m[static_cast<std::size_t>((y + j) * g.columns + x + i)]);
    };
    if (falls)
        return v >= u ? h(0, 0) + (h(0, 1) - h(0, 0)) * v + (h(1, 1) - h(0, 1)) * u
                      : h(0, 0) + (h(1, 0) - h(0, 0)) * u + (h(1, 1) - h(1, 0)) * v;
    return u + v <= 1 ? h(0, 0) + (h(1, 0) - h(0, 0)) * u + (h(0, 1) - h(0, 0)) * v
                      : h(1, 1) + (h(0, 1) - h(1, 1)) * (1 - u) + (h(1, 0) - h(1, 1)) * (1 - v);
}

bool close(const std::uint8_t* is, const gl::Rgb8& expected) {
    return std::abs(is[0] - expected[0]) <= 3 && std::abs(is[1] - expected[1]) <= 3 &&
           std::abs(is[2] - expected[2]) <= 3;
}

struct Compared {
    std::size_t pixels = 0, wrong = 0, blue = 0, white = 0, grey = 0;
};

// What the picture's depths say was drawn, against the grid.
Compared compare(const Scene& scene, const Picture& picture, const View& view, const gl::DrawOptions& drawing,
                 const io::FullHeights& heights) {
    const Terrain& terrain = scene.loaded.terrain;
    const double lambda = drawing.error_lambda_px > 0 ? drawing.error_lambda_px : focal_length_px(view);
    const Vec3 eye = drawing.error_eye_m.value_or(view.eye_m), right = cross(view.forward, view.up);
    Compared result;
    const auto every = test::rounds<std::uint32_t>(31, 1); // pixel
    for (std::uint32_t i = 0; i < width_px * height_px; i += every) {
        const std::uint32_t x = i % width_px, y = i / width_px;
        const double d = picture.distance_m[i];
        if (std::isinf(d)) continue;
        const std::uint8_t* const is = picture.colour.pixel(x, y);
        const Vec3 ray = view.forward + right * ((x + 0.5 - width_px / 2.0) / focal_length_px(view)) +
                         view.up * ((height_px / 2.0 - y - 0.5) / focal_length_px(view));
        ++result.pixels;
        result.blue += close(is, gl::error_rgb(0));
        result.white += close(is, gl::error_rgb(2));
        result.grey += close(is, gl::error_stops[5]);
        // A depth is rounded by d / 2^20 (render_test.cpp), to either side; and a place on a diagonal or a cell's
        // border may be seen on either side of it.
        bool good = heights.step_log2 > 0 && close(is, gl::error_stops[5]); // drawn as finely as the grid
        double least = INFINITY, most = 0;
        for (const double off : {-1.0, 0.0, 1.0})
            for (const Vec3 beside :
                 {Vec3{}, Vec3{0.02, 0, 0}, Vec3{-0.02, 0, 0}, Vec3{0, 0, 0.02}, Vec3{0, 0, -0.02}}) {
                const Vec3 p = view.eye_m + ray * (d * (1 + off * 0x1p-20)), q = p + beside;
                const double full_m = surface_m(data_of(terrain).tree, heights, q.x / terrain.header().spacing_m[0],
                                                q.z / terrain.header().spacing_m[1]);
                if (std::isnan(full_m)) {
                    good = good || close(is, gl::error_stops[5]);
                    continue;
                }
                const double share =
                    std::abs(p.y - full_m) * lambda / length(Vec3{p.x, full_m, p.z} - eye) / drawing.error_full_px;
                least = std::min(least, share);
                most = std::max(most, share);
            }
        // What is subtracted for rounding is 2^-20 of heights and ranges below 20,000 m in all.
        const double slack = 0.02 * lambda / length(view.eye_m + ray * d - eye) / drawing.error_full_px;
        least = std::max(least - slack, 0.0);
        for (int k = 0; k <= 1024 && !good && most >= least; ++k)
            good = close(is, gl::error_rgb(least + (most - least) * k / 1024));
        result.wrong += !good;
    }
    return result;
}

// Round ones, of up to a tenth of the terrain.
void make_holes(test::Random& random, baker::Dem& dem) {
    for (int n = 0; n < 8; ++n) {
        const double x = uniform(random, 0, dem.columns), y = uniform(random, 0, dem.rows),
                     radius = uniform(random, 1, dem.columns / 10.0);
        for (std::int32_t j = 0; j < dem.rows; ++j)
            for (std::int32_t i = 0; i < dem.columns; ++i)
                if (std::hypot(i - x, j - y) < radius)
                    dem.heights_m[static_cast<std::size_t>(j * dem.columns + i)] = std::nanf("");
    }
}

gl::DrawOptions bare(double full_px) {
    gl::DrawOptions drawing{.mode = gl::Mode::error, .sky = false, .lit = false, .haze = false};
    drawing.error_full_px = static_cast<float>(full_px);
    return drawing;
}

} // namespace

TEST_CASE("the error mode colours every pixel by the error that is drawn there", "[picture]") {
    test::Random random(81);
    std::size_t grey = 0;
    for (int round = 0; round < 8; ++round) {
        const int log2 = pick(random, 4, 7);
        baker::Dem dem = round % 2 == 0 ? mountains(pick(random, 150, 400), pick(random, 150, 400))
                                        : test::random_dem(random, pick(random, 60, 300), pick(random, 60, 300),
                                                           round % 4 == 1 ? test::Shape::fractal : test::Shape::noise);
        const bool holes = round % 3 == 2;
        if (holes) make_holes(random, dem);
        Scene scene(std::move(dem), log2);
        // Every third with heights for some of its samples.
        const bool coarse = round % 3 == 1;
        const std::size_t samples =
            std::size_t{scene.loaded.terrain.header().columns} * scene.loaded.terrain.header().rows;
        const io::FullHeights heights = heights_of(scene, coarse ? samples / 5 : samples);
        REQUIRE((heights.step_log2 > 0) == coarse);
        give(scene, heights);
        const double extent_m = std::hypot(scene.loaded.terrain.x_m(data_of(scene.loaded.terrain).tree.columns() - 1),
                                           scene.loaded.terrain.z_m(data_of(scene.loaded.terrain).tree.rows() - 1));
        const View view =
            scene.camera(uniform(random, 0.3, 0.7), uniform(random, 0.5, 0.9), extent_m * uniform(random, 0.02, 0.2),
                         uniform(random, -40, 40), uniform(random, -50, -10));
        const double error_px = uniform(random, 4, 20);
        const MeshView mesh = scene.refined(view, error_px, Topology::triangles, false);
        gl::DrawOptions drawing = bare(error_px * uniform(random, 0.4, 1.2));
        if (round % 2 == 1) {
            drawing.error_eye_m = view.eye_m + Vec3{0.1 * extent_m, 0.02 * extent_m, -0.05 * extent_m};
            drawing.error_lambda_px = 500;
        }
        const Picture picture = scene.draw(mesh, view, drawing);
        const Compared seen = compare(scene, picture, view, drawing, heights);
        CAPTURE(round, log2, coarse, seen.pixels, seen.blue, seen.white, seen.grey);
        CHECK(seen.pixels > test::rounds<std::size_t>(1'100, 20'000));
        CHECK(seen.wrong == 0);
        if (!coarse && !holes) CHECK(seen.grey == 0); // a coarse rim may reach over a hole, where there is no height
        grey += seen.grey;
        CHECK(seen.blue + seen.grey + test::rounds<std::size_t>(450, 2000) < seen.pixels); // or there was little to see
    }
    CHECK(grey > test::rounds<std::size_t>(220, 1000));
}

TEST_CASE("the largest error in a picture is the one that is measured", "[picture]") {
    Scene scene(mountains(513, 401), 7);
    const io::FullHeights heights = heights_of(scene);
    give(scene, heights);
    for (const double error_px : {2.0, 8.0})
        for (const View& view : {scene.camera(0.5, 0.95, 900, 0, -20), scene.camera(0.5, 0.5, 6000, 0, -90)}) {
            const MeshView mesh = scene.refined(view, error_px, Topology::triangles, false);
            const Frustum frustum = make_frustum(view);
            const double all_px = measure_error(scene.loaded.terrain, mesh, view).max_px,
                         seen_px = measure_error(scene.loaded.terrain, mesh, view, &frustum).max_px;
            CAPTURE(error_px, all_px, seen_px);
            CHECK(all_px <= error_px);
            // Errors are linear between samples, the nearest of which is a cell's diagonal, 43 m and what rises in it,
            // farther at most: from d away e pixels at the sample are up to e (1 + cell / d) in the cell.
            const Picture promised = scene.draw(mesh, view, bare(error_px));
            const double nearest_m = *std::min_element(promised.distance_m.begin(), promised.distance_m.end());
            const View& v = view;
            const double bound_px = all_px * (1 + 120 / nearest_m);
            CHECK(compare(scene, scene.draw(mesh, v, bare(bound_px)), v, bare(bound_px), heights).white == 0);
            CHECK(compare(scene, scene.draw(mesh, v, bare(seen_px / 4)), v, bare(seen_px / 4), heights).white >
                  test::rounds<std::size_t>(20, 100));
        }
}

TEST_CASE("a mesh of the full resolution has no error anywhere, multisampled or not, and a wrong height shows",
          "[picture]") {
    Scene scene(mountains(321, 257), 6); // whole tiles: nothing is drawn beyond the rim
    io::FullHeights heights = heights_of(scene);
    const OwnMesh mesh = full_resolution(scene.loaded.terrain);
    const View views[] = {scene.camera(0.5, 0.9, 40, 0, -5), scene.camera(0.4, 0.5, 3000, 30, -50)};
    for (const std::uint32_t samples : {1u, 4u}) {
        scene.target = gl::Target::create({width_px, height_px, samples});
        give(scene, heights);
        for (const View& view : views) {
            const gl::Image image = scene.draw(mesh.view(), view, bare(0.01)).colour;
            std::size_t coloured = 0;
            for (std::size_t i = 0; i < image.rgb.size(); i += 3) // blue, or blended with a black sky
                coloured += image.rgb[i] > gl::error_stops[0][0] + 1 || image.rgb[i + 1] > gl::error_stops[0][1] + 1;
            CAPTURE(samples, coloured);
            CHECK(coloured == 0);
        }
    }
    scene.target = gl::Target::create({width_px, height_px, 1});
    const View& view = views[1];
    const Vec3 right = cross(view.forward, view.up);
    const Picture plain = scene.draw(mesh.view(), view, bare(1));
    const SampleIndex planted{161, 60};
    float& height_m = heights.heights_m[static_cast<std::size_t>(planted.row * heights.columns + planted.column)];
    const float right_m = height_m;
    for (const bool hole : {false, true}) {
        height_m = hole ? std::nanf("") : right_m + 40;
        give(scene, heights);
        const gl::Image wrong = scene.draw(mesh.view(), view, bare(1)).colour;
        std::size_t shown = 0, elsewhere = 0;
        for (std::uint32_t i = 0; i < width_px * height_px; ++i) {
            const std::uint32_t x = i % width_px, y = i / width_px;
            const Vec3 ray = view.forward + right * ((x + 0.5 - width_px / 2.0) / focal_length_px(view)) +
                             view.up * ((height_px / 2.0 - y - 0.5) / focal_length_px(view));
            const Vec3 at = view.eye_m + ray * static_cast<double>(plain.distance_m[i]);
            const bool beside =
                std::abs(at.x / 30 - planted.column) <= 1.01 && std::abs(at.z / 30 - planted.row) <= 1.01;
            const std::uint8_t* const is = wrong.pixel(x, y);
            shown += close(is, hole ? gl::error_stops[5] : gl::error_rgb(2));
            elsewhere += !beside && !std::equal(is, is + 3, plain.colour.pixel(x, y));
        }
        CAPTURE(hole, shown);
        CHECK(shown > 12);
        CHECK(elsewhere == 0);
    }
}

TEST_CASE("the error mode measures morphing vertices where they are drawn", "[picture]") {
    Scene scene(mountains(513, 513), 6);
    scene.make_cut();
    const io::FullHeights heights = heights_of(scene);
    give(scene, heights);
    const View from = scene.camera(0.5, 0.9, 200, 0, -10), view = scene.camera(0.5, 0.88, 210, 5, -10);
    const CutMesh live = scene.half_way(from, view, 6);
    const Picture picture = scene.draw(live, view, bare(6));
    CHECK(compare(scene, picture, view, bare(6), heights).wrong == 0);
    const Picture risen = scene.draw(copy_of(live.mesh).view(), view, bare(6));
    CHECK((risen.colour.rgb != picture.colour.rgb));
}

TEST_CASE("heights wider than a texture give the same picture", "[picture]") {
    Scene scene(mountains(300, 257), 6);
    const io::FullHeights heights = heights_of(scene);
    give(scene, heights);
    const View view = scene.camera(0.5, 0.9, 400, 0, -15);
    const OwnMesh mesh = copy_of(scene.refined(view, 5));
    const Picture whole = scene.draw(mesh.view(), view, bare(5));
    for (const std::uint32_t side : {37u, 128u, 299u}) {
        scene.renderer = gl::Renderer::create(scene.loaded.terrain, scene.loaded.pack,
                                              {.vertices = 1u << 18, .indices = 1u << 20, .texture_side = side});
        give(scene, heights);
        CHECK((scene.draw(mesh.view(), view, bare(5)).colour.rgb == whole.colour.rgb));
    }
}

TEST_CASE("the error mode says what it lacks", "[picture]") {
    Scene scene(mountains(129, 100), 5);
    const View view = scene.camera(0.5, 0.9, 150, 0, -5);
    const MeshView mesh = scene.refined(view, 2);
    const auto draw = [&](double full_px) { scene.renderer->draw(mesh, view, bare(full_px), *scene.target); };
    CHECK_THROWS_WITH(draw(1), Catch::Contains("set_heights()"));
    const io::FullHeights heights = heights_of(scene);
    gl::HeightGrid grid = grid_of(heights);
    grid.columns = 128;
    CHECK_THROWS_WITH(scene.renderer->set_heights(grid), Catch::Contains("129 columns"));
    grid = grid_of(heights);
    grid.step_log2 = 6;
    CHECK_THROWS_WITH(scene.renderer->set_heights(grid), Catch::Contains("step_log2"));
    grid.step_log2 = 1;
    CHECK_THROWS_WITH(scene.renderer->set_heights(grid), Catch::Contains("65 columns and 51 rows"));
    CHECK_THROWS_AS(draw(1), io::Failure); // none of these counts
    give(scene, heights);
    draw(1);
    CHECK_THROWS_WITH(draw(0), Catch::Contains("error_full_px"));
    scene.renderer->set_heights({});
    CHECK_THROWS_WITH(draw(1), Catch::Contains("set_heights()"));
    CHECK(context().log().errors == 0);
}
