// Pictures: what is drawn is what was refined, and what was refined looks like the terrain.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <set>

#include <sys/resource.h>

#include <csignal>

#include "fjell/gl/image.h"
#include "fjell/gl/palette.h"
#include "gl/window.h"
#include "picture_scene.h"
#include "shared/terrain_data.h"
#include "support/dem.h"

using namespace pictures;

namespace {

// --- 1 px of displacement
// ---------------------------------------------------------------------------------------------
//
// A pixel p of picture A *agrees* with picture B of the same view when what A shows at p lies within one pixel of
// something that B shows, across the screen and in depth:
//   - A shows sky at p: some pixel of B in the 3 x 3 around p is sky;
//   - A shows terrain at p, d metres away: B shows terrain somewhere in the 3 x 3 around p, and
//       least - t <= d <= most + t,
//     with least and most the nearest and farthest terrain in those 9 pixels, and t = d / lambda + d / 2^20.
// d / lambda is the size of a pixel at distance d: the same one pixel, in the direction across which the 3 x 3 cannot
// look (seen from above, a vertical error moves nothing on the screen but changes the depth). d / 2^20 bounds rounding:
// a stored depth z = near (far - d) / (d (far - near)) off by k ulps is a distance off by at most k d / 2^24 (when far
// >> d), and the vertex' position, the two products of clip space and the rasteriser's interpolation take fewer
// than 16. A pixel within one pixel of displacement agrees in both directions. The share is of the pixels that are
// terrain in either picture; sky alone would only flatter it.
bool agrees(const Picture& a, const Picture& b, std::int32_t x, std::int32_t y, double focal_length_px) {
    const auto wide = static_cast<std::int32_t>(a.colour.width), high = static_cast<std::int32_t>(a.colour.height);
    const auto at = [wide](std::int32_t px, std::int32_t py) { return static_cast<std::size_t>(py * wide + px); };
    bool sky = false, terrain = false;
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::int32_t j = std::max(0, y - 1); j <= std::min(high - 1, y + 1); ++j)
        for (std::int32_t i = std::max(0, x - 1); i <= std::min(wide - 1, x + 1); ++i) {
            const double d = b.distance_m[at(i, j)];
            if (std::isinf(d)) {
                sky = true;
                continue;
            }
            terrain = true;
            least = std::min(least, d);
            most = std::max(most, d);
        }
    const double d = a.distance_m[at(x, y)];
    if (std::isinf(d)) return sky;
    const double tolerance = d / focal_length_px + d / (1 << 20);
    return terrain && d >= least - tolerance && d <= most + tolerance;
}

struct Agreement {
    std::uint64_t pixels = 0, within = 0;
    [[nodiscard]] double share() const { return static_cast<double>(within) / static_cast<double>(pixels); }
};

Agreement compare(const Picture& a, const Picture& b, double focal_length_px) {
    Agreement result;
    const auto wide = static_cast<std::int32_t>(a.colour.width), high = static_cast<std::int32_t>(a.colour.height);
    for (std::int32_t y = 0; y < high; ++y)
        for (std::int32_t x = 0; x < wide; ++x) {
            const auto p = static_cast<std::size_t>(y * wide + x);
            if (std::isinf(a.distance_m[p]) && std::isinf(b.distance_m[p])) continue;
            ++result.pixels;
            if (agrees(a, b, x, y, focal_length_px) && agrees(b, a, x, y, focal_length_px)) ++result.within;
        }
    return result;
}

struct NamedView {
    const char* name;
    View view;
    bool has_sky;
};

// At 0.5 px nearly everything agrees; at 20 px it must not, or the measure could not tell.
void check_against_full_resolution(Scene& scene, const char* terrain, const std::vector<NamedView>& views) {
    const OwnMesh full = full_resolution(scene.loaded.terrain);
    for (const NamedView& v : views) {
        scene.target = gl::Target::create({v.view.width_px, v.view.height_px, 1});
        const Picture reference = scene.draw(full.view(), v.view);
        const MeshView fine = scene.refined(v.view, 0.5);
        const std::size_t triangles = fine.indices.size() / 3;
        const Agreement good = compare(scene.draw(fine, v.view), reference, focal_length_px(v.view));
        const Agreement bad =
            compare(scene.draw(scene.refined(v.view, 20), v.view), reference, focal_length_px(v.view));
        std::printf("%s, %s: %zu triangles at 0.5 px; within 1 px of full resolution: %.4f%% of %llu terrain pixels "
                    "(at 20 px: %.2f%%)\n",
                    terrain, v.name, triangles, 100 * good.share(), static_cast<unsigned long long>(good.pixels),
                    100 * bad.share());
        INFO(terrain << ", " << v.name);
        const bool sky = std::any_of(reference.depth.begin(), reference.depth.end(), [](float d) { return d == 0; });
        CHECK(sky == v.has_sky);
        REQUIRE(good.pixels > std::uint64_t{v.view.width_px} * v.view.height_px / 4);
        CHECK(good.share() >= 0.999);
        CHECK(bad.share() < 0.999);
    }
}

std::string data_folder() {
    const char* given = FJELL_DATA_DIR;
    return given[0] == '\0' ? FJELL_SOURCE_DIR "/../shared/data" : given;
}

baker::Dem crop(const baker::Dem& dem, std::int32_t x0, std::int32_t y0, std::int32_t columns, std::int32_t rows) {
    baker::Dem part = dem;
    part.columns = columns;
    part.rows = rows;
    part.heights_m.clear();
    for (std::int32_t y = 0; y < rows; ++y)
        for (std::int32_t x = 0; x < columns; ++x) part.heights_m.push_back(dem.at(x0 + x, y0 + y));
    return part;
}

} // namespace

TEST_CASE("a frame at half a pixel shows synthetic mountains within one pixel of full resolution", "[picture]") {
    Scene scene(mountains(1025), 8);
    check_against_full_resolution(scene, "mountains",
                                  {{"low, into the ranges", scene.camera(0.5, 0.9, 150, 0, -2), true},
                                   {"low, along a ridge", scene.camera(0.2, 0.5, 60, 80, 3), true},
                                   {"high, looking down", scene.camera(0.5, 0.95, 5000, 10, -40), false},
                                   {"straight down", scene.camera(0.5, 0.5, 9000, 0, -90), false}});
}

TEST_CASE("a frame at half a pixel shows the Grand Canyon within one pixel of full resolution", "[picture]") {
    const std::string path = data_folder() + "/dem/grand_canyon_60m_4097x2049_u8.png";
    if (!std::filesystem::exists(path)) {
        WARN("skipped: there is no " << path << " (set FJELL_DATA to the folder of real height fields)");
        return;
    }
    baker::ReadOptions options;
    options.spacing_m = 60;
    options.zscale = 14.4;
    options.zoffset_m = 127;
    Scene scene(crop(baker::read_dem(path, options), 1024, 512, 1025, 1025), 8);
    // Silhouettes, a pixel wide, are more than a thousandth of a small picture that is full of them.
    View low = scene.camera(0.5, 0.9, 200, 0, -3);
    low.width_px *= 2, low.height_px *= 2;
    check_against_full_resolution(
        scene, "Grand Canyon",
        {{"high, looking down", scene.camera(0.5, 0.95, 8000, 0, -35), false}, {"low, over the plateau", low, true}});
}

TEST_CASE("the strip and the list of one frame give the same picture", "[picture]") {
    Scene scene(mountains(513), 6);
    for (const View& view : {scene.camera(0.5, 0.9, 150, 0, -5), scene.camera(0.3, 0.6, 3000, 40, -45)})
        for (const gl::Mode mode : {gl::Mode::shaded, gl::Mode::levels}) {
            const gl::DrawOptions drawing{.mode = mode};
            const Picture list = scene.draw(scene.refined(view, 2), view, drawing);
            const MeshView mesh = scene.refined(view, 2, Topology::strip);
            REQUIRE(mesh.topology == Topology::strip);
            const Picture strip = scene.draw(mesh, view, drawing);
            // A strip names a triangle's corners from another one than a list does, so its planes of interpolation are
            // rounded elsewhere: one step of a colour for that and one for the sampler, whose weights have 8 bits (a
            // 256th of two texels' contrast), and some ulps of depth - more where a triangle is seen edge-on, so depth
            // is held to the measure above instead. What is covered must not differ at all.
            std::size_t coverage = 0, colour = 0;
            for (std::size_t i = 0; i < list.depth.size(); ++i)
                coverage += (list.depth[i] == 0) != (strip.depth[i] == 0);
            for (std::size_t i = 0; i < list.colour.rgb.size(); ++i)
                colour += std::abs(list.colour.rgb[i] - strip.colour.rgb[i]) > 2;
            CHECK(coverage == 0);
            CHECK(colour == 0);
            const Agreement agreement = compare(strip, list, focal_length_px(view));
            CHECK(agreement.within == agreement.pixels);
        }
}

TEST_CASE("an off-centre view draws its part of the whole picture", "[picture]") {
    Scene scene(mountains(513), 6);
    const View whole = scene.camera(0.5, 0.9, 200, 10, -10);
    View quarter = whole; // the upper right one, at twice the scale
    quarter.left = quarter.bottom = 0;
    const MeshView mesh = scene.refined(whole, 1);
    const Picture all = scene.draw(mesh, whole), part = scene.draw(mesh, quarter);
    std::size_t good = 0, bad = 0;
    for (std::size_t y = 0; y < height_px / 2; y += 3)
        for (std::size_t x = width_px / 2; x < width_px; x += 3) {
            const float a = all.distance_m[y * width_px + x],
                        b = part.distance_m[2 * y * width_px + 2 * (x - width_px / 2)];
            if (!(a > 0 && a < 1e5f) && !(b > 0 && b < 1e5f)) continue; // sky
            (std::abs(a - b) < 0.03f * a ? good : bad)++;
        }
    CHECK(good > 2'500);
    CHECK(bad < good / 20); // ridges
}

TEST_CASE("a picture that is drawn in bands is the picture, and a band leaves the rest alone", "[picture]") {
    Scene scene(mountains(257), 6);
    const View view = scene.camera(0.5, 0.9, 200, 10, -10), other = scene.camera(0.4, 0.8, 3000, 200, -60);
    const MeshView mesh = scene.refined(view, 1);
    const Picture whole = scene.draw(mesh, view), before = scene.draw(mesh, other);
    REQUIRE(whole.colour.rgb != before.colour.rgb);
    const std::uint32_t rows[] = {0, 1, height_px / 3, height_px / 2 + 1, height_px};
    for (std::size_t i = 1; i < std::size(rows); ++i) {
        const Picture bands = scene.draw(mesh, view, {.first_row = rows[i - 1], .end_row = rows[i]});
        const auto limit = [&](std::size_t size) { return static_cast<std::ptrdiff_t>(size / height_px * rows[i]); };
        // Rows of what is read count from above.
        const auto depths = limit(whole.depth.size()), colours = limit(whole.colour.rgb.size());
        CHECK(std::equal(bands.depth.rbegin(), bands.depth.rbegin() + depths, whole.depth.rbegin()));
        CHECK(std::equal(bands.depth.rbegin() + depths, bands.depth.rend(), before.depth.rbegin() + depths));
        CHECK(std::equal(bands.colour.rgb.rbegin(), bands.colour.rgb.rbegin() + colours, whole.colour.rgb.rbegin()));
        CHECK(std::equal(bands.colour.rgb.rbegin() + colours, bands.colour.rgb.rend(),
                         before.colour.rgb.rbegin() + colours));
    }
}

TEST_CASE("no background shows between or inside tiles", "[picture]") {
    Scene scene(mountains(513), 5); // 16 x 16 tiles
    const auto holes = [](const Picture& picture) {
        return std::count(picture.depth.begin(), picture.depth.end(), 0.0f);
    };
    std::vector<View> views;
    views.reserve(12);
    for (int i = 0; i < 12; ++i) // all rays end inside the terrain
        views.push_back(scene.camera(0.4 + 0.017 * i, 0.45 + 0.011 * i, 300 + 170.0 * i, 31.0 * i, -60 - 2.5 * i));
    std::int64_t with_a_crack = 0;
    for (const View& view : views)
        for (const double error_px : {0.5, 3.0, 15.0}) {
            const MeshView mesh = scene.refined(view, error_px);
            INFO("error_px " << error_px << ", eye " << view.eye_m.x << ' ' << view.eye_m.y << ' ' << view.eye_m.z);
            CHECK(holes(scene.draw(mesh, view)) == 0);
            if (error_px != 3.0) continue;
            // The same with one tile's border 30 m lower than its neighbours': the test must see that.
            OwnMesh cracked = copy_of(mesh);
            const std::int32_t side = data_of(scene.loaded.terrain).tree.side(),
                               tiles_x = data_of(scene.loaded.terrain).tree.tiles_x;
            for (const TileRange& range : cracked.tiles) {
                if (range.tile % 2) continue;
                const std::int32_t east = (static_cast<std::int32_t>(range.tile) % tiles_x + 1) * side;
                std::set<std::uint32_t> used(cracked.indices.begin() + range.first_index,
                                             cracked.indices.begin() + range.first_index + range.index_count);
                for (const std::uint32_t v : used)
                    if (cracked.vertices[v].column == east) cracked.vertices[v].height_m -= 30;
            }
            with_a_crack += holes(scene.draw(cracked.view(), view));
        }
    CHECK(with_a_crack > 100);
}

TEST_CASE("every triangle has the colour of its level", "[picture]") {
    Scene scene(mountains(257), 6);
    const Terrain& terrain = scene.loaded.terrain;
    const View view = scene.camera(0.5, 0.5, 7000, 0, -90);
    const MeshView mesh = scene.refined(view, 4);
    const Picture picture =
        scene.draw(mesh, view, {.mode = gl::Mode::levels, .sky = false, .lit = false, .haze = false});
    const Vec3 right = cross(view.forward, view.up);
    std::set<int> seen;
    std::size_t looked_at = 0, wrong = 0;
    for (const TileRange& range : mesh.tiles)
        for (std::uint32_t i = range.first_index; i < range.first_index + range.index_count; i += 3) {
            SampleIndex corner[3];
            Vec3 centre;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const MeshVertex& v = mesh.vertices[mesh.indices[i + k]];
                corner[k] = {v.column, v.row};
                const Vec3 p{terrain.x_m(v.column), v.height_m, terrain.z_m(v.row)};
                centre = centre + (p - view.eye_m) * (1.0 / 3);
            }
            // How often a base triangle, of half a tile's area, was halved.
            const SampleIndex a = corner[1] - corner[0], b = corner[2] - corner[0];
            const int doubled_area = std::abs(a.column * b.row - a.row * b.column);
            const int level = 2 * static_cast<int>(terrain.header().tile_log2) -
                              static_cast<int>(std::lround(std::log2(doubled_area)));
            const double d = dot(centre, view.forward);
            const double x = width_px / 2.0 + focal_length_px(view) * dot(centre, right) / d;
            const double y = height_px / 2.0 - focal_length_px(view) * dot(centre, view.up) / d;
            if (doubled_area < 4 || x < 1 || y < 1 || x >= width_px - 1 || y >= height_px - 1) continue;
            const std::uint8_t* pixel =
                picture.colour.pixel(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
            const gl::Rgb8 expected = gl::level_rgb(level, static_cast<int>(terrain.header().tile_log2));
            ++looked_at;
            seen.insert(level);
            for (std::size_t k = 0; k < 3; ++k)
                if (std::abs(pixel[k] - expected[k]) > 1) { // sRGB -> linear -> sRGB may round once
                    ++wrong;
                    break;
                }
        }
    CHECK(looked_at > 500);
    CHECK(seen.size() >= 5);
    CHECK(wrong == 0);
    // Neighbouring levels must be told apart at a glance.
    for (int level = 1; level <= 2 * 9; ++level) {
        const gl::Rgb8 a = gl::level_rgb(level - 1, 9), b = gl::level_rgb(level, 9);
        CHECK(std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]) > 60);
    }
}

TEST_CASE("every mode draws, multisampled too, and the driver reports no error", "[picture]") {
    Scene scene(mountains(257), 6);
    const View view = scene.camera(0.5, 0.9, 150, 0, -5);
    const MeshView mesh = scene.refined(view, 2);
    std::vector<gl::Image> images;
    for (const gl::Mode mode :
         {gl::Mode::shaded, gl::Mode::levels, gl::Mode::distance, gl::Mode::tiles, gl::Mode::mips, gl::Mode::residency})
        for (const bool wireframe : {false, true})
            images.push_back(scene.draw(mesh, view, {.mode = mode, .wireframe = wireframe}).colour);
    for (std::size_t i = 0; i < images.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) CHECK((images[i].rgb != images[j].rgb));

    scene.target = gl::Target::create({width_px, height_px, 4});
    const Picture smooth = scene.draw(mesh, view);
    std::size_t far_off = 0;
    for (std::size_t i = 0; i < smooth.colour.rgb.size(); ++i)
        far_off += std::abs(smooth.colour.rgb[i] - images[0].rgb[i]) > 64;
    CHECK(far_off < smooth.colour.rgb.size() / 100);
    CHECK(context().log().errors == 0);
}

TEST_CASE("what cannot be drawn is refused with the number to change", "[picture]") {
    Scene scene(mountains(129), 5);
    const View view = scene.camera(0.5, 0.9, 150, 0, -5);
    OwnMesh mesh = copy_of(scene.refined(view, 2));
    const auto small = gl::Renderer::create(scene.loaded.terrain, scene.loaded.pack, {.vertices = 16, .indices = 16});
    scene.make_cut();
    scene.follow(view, 2);
    const CutMesh cut = cut_mesh(scene.cut);
    CHECK_THROWS_WITH(small->draw(cut, cut_take_changes(scene.cut), view, {}, *scene.target),
                      Catch::Contains("RendererOptions::vertices"));
    gl::RendererOptions slots{.vertices = static_cast<std::uint32_t>(cut.mesh.vertices.size()),
                              .indices = static_cast<std::uint32_t>(cut.mesh.indices.size())};
    const auto few = gl::Renderer::create(scene.loaded.terrain, scene.loaded.pack, slots);
    REQUIRE(cut.mesh.tiles.size() > scene.loaded.terrain.tile_count());
    CHECK_THROWS_WITH(few->draw(cut, cut_take_changes(scene.cut), view, {}, *scene.target),
                      Catch::Contains("RendererOptions::ranges"));
    CHECK_THROWS_WITH(few->upload(cut, cut_take_changes(scene.cut)), Catch::Contains("RendererOptions::morph"));
    CHECK_THROWS_WITH(few->draw_uploaded(mesh.view(), view, {}, *scene.target), Catch::Contains("upload()"));
    CHECK_THROWS_WITH(small->draw(mesh.view(), view, {}, *scene.target), Catch::Contains("RendererOptions::vertices"));
    CHECK_THROWS_WITH(gl::Target::create({0, 10, 1}), Catch::Contains("each side must be"));
    CHECK_THROWS_AS(gl::Target::create({10, 1u << 24, 1}), io::Failure);
    View broken = view;
    broken.top = broken.bottom;
    CHECK_THROWS_AS(scene.renderer->draw(mesh.view(), broken, {}, *scene.target), io::Failure);
    mesh.tiles[0].index_count = 1u << 30;
    CHECK_THROWS_AS(scene.renderer->draw(mesh.view(), view, {}, *scene.target), io::Failure);
    CHECK(context().log().errors == 0);
    CHECK_THROWS_WITH(gl::Headless::create({.debug = false, .device = 999}),
                      Catch::Contains("device") && !Catch::Contains("\n"));
    REQUIRE(context().make_current());

    const char* display = std::getenv("DISPLAY");
    const std::string before = display ? display : "";
    unsetenv("DISPLAY");
    CHECK_THROWS_WITH(gl::Window::create({}), Catch::Contains("--headless") && !Catch::Contains("\n"));
    if (display) setenv("DISPLAY", before.c_str(), 1);
}

TEST_CASE("a PNG is complete or absent", "[picture]") {
    namespace fs = std::filesystem;
    const fs::path folder = fs::temp_directory_path() / ("fjell-png-" + std::to_string(getpid()));
    fs::create_directory(folder);
    gl::Image image{61, 37, {}};
    for (std::uint32_t i = 0; i < 61 * 37 * 3; ++i)
        image.rgb.push_back(static_cast<std::uint8_t>(i * 2654435761u >> 24));
    const std::string path = folder / "picture.png";
    gl::write_png(image, path);
    gl::Image back = gl::read_png(path);
    CHECK(back.width == 61);
    CHECK((back.rgb == image.rgb));
    CHECK_THROWS_WITH(gl::write_png(image, folder / "no" / "such.png"), Catch::Contains("no/such.png"));
    CHECK_THROWS_AS(gl::write_png(image, folder), io::Failure); // a folder has that name
    CHECK_THROWS_AS(gl::write_png({10, 10, {}}, folder / "empty.png"), io::Failure);

    // A disk that fills up: writes beyond a kilobyte fail.
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit tight{1024, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &tight);
    image.rgb[0] ^= 0xff;
    CHECK_THROWS_AS(gl::write_png(image, path), io::Failure);
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    back = gl::read_png(path); // the older picture is still there
    CHECK(back.rgb[0] == (image.rgb[0] ^ 0xff));
    CHECK(std::distance(fs::directory_iterator(folder), fs::directory_iterator()) == 1);
    fs::remove_all(folder);
}
