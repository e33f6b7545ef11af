// Borders of tiles and pages on the surface: where they must be, as wide as promised, and nowhere else.
#include <cmath>
#include <optional>
#include <vector>

#include "fjell/gl/palette.h"
#include "picture_scene.h"
#include "shared/terrain_data.h"
#include "support/dem.h"
#include "support/rounds.h"

using namespace pictures;

namespace {

constexpr double border_spacing_m = 30;

baker::Dem ground(std::int32_t columns, std::int32_t rows, double step_m = 0) {
    baker::Dem dem;
    dem.columns = columns;
    dem.rows = rows;
    dem.spacing_m[0] = dem.spacing_m[1] = border_spacing_m;
    for (std::int32_t y = 0; y < rows; ++y) // pyramids that repeat every 8 samples
        for (std::int32_t x = 0; x < columns; ++x)
            dem.heights_m.push_back(static_cast<float>(step_m * std::min({x & 7, 8 - (x & 7), y & 7, 8 - (y & 7)})));
    return dem;
}

// Where a pixel's middle, moved by some pixels, meets level ground at height 0; in samples.
struct Place {
    double column, row;
};
Place place_of(const View& view, double x_px, double y_px) {
    const Vec3 right = cross(view.forward, view.up);
    const Vec3 ray = view.forward * focal_length_px(view) + right * (x_px + 0.5 - width_px / 2.0) +
                     view.up * (height_px / 2.0 - y_px - 0.5);
    const double t = -view.eye_m.y / ray.y;
    return {(view.eye_m.x + t * ray.x) / border_spacing_m, (view.eye_m.z + t * ray.z) / border_spacing_m};
}

// Pixels from a place to the nearest of the lines k * apart, and to one at `end`; and between two such lines.
struct Reach {
    double near_px = 1e9, apart_px = 1e9;
    void add(double at, double samples_a_pixel, double apart, double end) {
        const double to_line = std::abs(at - std::round(at / apart) * apart);
        const double px = std::min(to_line, std::abs(end - at)) / samples_a_pixel;
        if (px < near_px) near_px = px, apart_px = apart / samples_a_pixel;
    }
};

double srgb(double light) {
    return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

struct Looked {
    std::size_t on_tile = 0, on_page = 0, off = 0, wrong = 0;
};

// Some of the pixels of a picture with borders against the same without.
Looked look(const Scene& scene, const View& view, const gl::Image& with, const gl::Image& without, bool tiles,
            bool pages) {
    const Tree& tree = data_of(scene.loaded.terrain).tree;
    const double side = tree.side(), page = std::min(side, 64.0);
    Looked seen;
    const auto every = test::rounds<std::uint32_t>(23, 11);
    for (std::uint32_t i = 0; i < width_px * height_px; i += every) {
        const std::uint32_t x = i % width_px, y = i / width_px;
        const Place at = place_of(view, x, y), east = place_of(view, x + 0.5, y), west = place_of(view, x - 0.5, y),
                    south = place_of(view, x, y + 0.5), north = place_of(view, x, y - 0.5);
        const double a_pixel_x = std::hypot(east.column - west.column, south.column - north.column),
                     a_pixel_y = std::hypot(east.row - west.row, south.row - north.row);
        Reach tile, block;
        tile.add(at.column, a_pixel_x, side, tree.columns() - 1);
        tile.add(at.row, a_pixel_y, side, tree.rows() - 1);
        block.add(at.column, a_pixel_x, page, 1e9);
        block.add(at.row, a_pixel_y, page, 1e9);
        if (at.column < 0 || at.row < 0 || at.column > tree.columns() - 1 || at.row > tree.rows() - 1) continue;
        const std::uint8_t *is = with.pixel(x, y), *was = without.pixel(x, y);
        const auto shows = [&](const gl::Rgb8& rgb, double opacity) {  // in linear light; sRGB rounds three times
            const double ground = (1 - 0.6 * opacity) * (1 - opacity); // through the line's dark rim and the line
            bool good = true;
            for (std::size_t k = 0; k < 3; ++k)
                good = good && std::abs(is[k] - srgb(linear(was[k]) * ground + linear(rgb[k]) * opacity)) <= 2;
            return good;
        };
        // 1.25 and 0.75 pixels to each side, one of dark rim, and half of one for the soft edge.
        if (tiles && tile.near_px < 0.5 && tile.apart_px > 20) {
            ++seen.on_tile;
            seen.wrong += !shows(gl::tile_border_rgb, 1);
        } else if (pages && block.near_px < 0.2 && block.apart_px > 20 && !(tiles && tile.near_px < 3)) {
            ++seen.on_page;
            seen.wrong += !shows(gl::page_border_rgb, 0.8);
        } else if (!(tiles && tile.near_px < 3) && !(pages && block.near_px < 2.5)) {
            ++seen.off;
            seen.wrong += !std::equal(is, is + 3, was);
        }
    }
    return seen;
}

View from_above(const Scene& scene, double above_m, double pitch_deg) {
    return scene.camera(0.45, pitch_deg < -80 ? 0.5 : 0.95, above_m, 7, pitch_deg);
}

} // namespace

TEST_CASE("borders of tiles and pages lie where they are, over every mode, and change nothing else", "[picture]") {
    Scene scene(ground(700, 601), 8); // neither extent is of whole tiles
    for (const gl::Mode mode :
         {gl::Mode::shaded, gl::Mode::levels, gl::Mode::distance, gl::Mode::tiles, gl::Mode::mips, gl::Mode::residency})
        for (const View& view : {from_above(scene, 20'000, -90), from_above(scene, 3000, -25)}) {
            const MeshView mesh = scene.refined(view, 1); // level: nothing but the tiles' corners
            gl::DrawOptions drawing{.mode = mode, .sky = false, .lit = false, .haze = false};
            const Picture without = scene.draw(mesh, view, drawing);
            for (int which = 1; which <= 3; ++which) {
                drawing.tile_borders = (which & 1) != 0;
                drawing.page_borders = (which & 2) != 0;
                const Picture with = scene.draw(mesh, view, drawing);
                CHECK((with.depth == without.depth));
                const Looked seen =
                    look(scene, view, with.colour, without.colour, drawing.tile_borders, drawing.page_borders);
                CAPTURE(static_cast<int>(mode), view.eye_m.y, which, seen.on_tile, seen.on_page, seen.off);
                CHECK(seen.wrong == 0);
                CHECK((seen.on_tile > test::rounds<std::size_t>(5, 20)) == drawing.tile_borders);
                CHECK((seen.on_page > test::rounds<std::size_t>(5, 20)) == drawing.page_borders);
                CHECK(seen.off > test::rounds<std::size_t>(2'500, 10'000));
            }
        }
}

TEST_CASE("borders that would lie closer than six pixels are not drawn", "[picture]") {
    Scene scene(ground(2049, 2049), 7);
    const MeshView coarse = scene.refined(from_above(scene, 600'000, -90), 100);
    // A page is 64 x 30 m: below 6 pixels beyond 1,920 m x lambda / 6.
    const View far_off = from_above(scene, 1920 * focal_length_px(from_above(scene, 1000, -90)) / 5.5, -90);
    const View nearer = from_above(scene, 1920 * focal_length_px(far_off) / 20, -90);
    const auto differs = [&](const View& view) {
        const Picture without = scene.draw(coarse, view), with = scene.draw(coarse, view, {.page_borders = true});
        return without.colour.rgb != with.colour.rgb;
    };
    CHECK_FALSE(differs(far_off));
    CHECK(differs(nearer));
}

TEST_CASE("a pack in linear order has borders of tiles and none of pages", "[picture]") {
    Scene scene(ground(257, 257), 7, PageOrder::linear);
    const OwnMesh mesh = full_resolution(scene.loaded.terrain);
    const View view = from_above(scene, 6000, -90);
    const Picture plain = scene.draw(mesh.view(), view);
    CHECK((scene.draw(mesh.view(), view, {.page_borders = true}).colour.rgb == plain.colour.rgb));
    CHECK((scene.draw(mesh.view(), view, {.tile_borders = true}).colour.rgb != plain.colour.rgb));
}

TEST_CASE("borders far from the origin are bit for bit those near it", "[picture]") {
    Scene scene(ground(8193, 129, 20), 7);
    const OwnMesh mesh = full_resolution(scene.loaded.terrain);
    const auto picture = [&](double column, bool borders) {
        const View view = make_view({column * border_spacing_m, 1500, 64 * border_spacing_m}, {0.6, -0.8, 0},
                                    {0.8, 0.6, 0}, pi / 8, width_px, height_px, 1, 1e5);
        return scene.draw(mesh.view(), view, {.tile_borders = borders, .page_borders = borders, .haze = false}).colour;
    };
    const gl::Image near_by = picture(100.125, true), far_away = picture(100.125 + 128 * 60, true);
    CHECK((near_by.rgb == far_away.rgb));
    CHECK((near_by.rgb != picture(100.125, false).rgb));
}
