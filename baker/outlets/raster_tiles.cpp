#include "baker/outlets/raster_tiles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "baker/outlets/encode_image.h"
#include "baker/outlets/texel_places.h"
#include "gltf/glb.h"

namespace fjell::baker {

namespace {

struct HeightCode {
    double base_m, step_m;
};
HeightCode code_of(HeightColours colours) {
    return colours == HeightColours::terrain_rgb ? HeightCode{-10000, 0.1} : HeightCode{-32768, 1.0 / 256};
}

// 0 at the map's northern rim, 1 at its southern.
double mercator_down(double latitude) {
    return 0.5 - std::asinh(std::tan(latitude * std::numbers::pi / 180)) / (2 * std::numbers::pi);
}
double latitude_of(double down) {
    return std::atan(std::sinh((1 - 2 * down) * std::numbers::pi)) * 180 / std::numbers::pi;
}

// The pixels of a tile and one more on each side, as numbers of steps.
class Pixels {
public:
    Pixels(const GroundSurface& surface, const SampleFinder& finder, TileId id, const RasterRules& rules)
        : code_(code_of(rules.colours)), side_(rules.side_px + 2),
          across_(static_cast<double>(rules.side_px) * tiles_across(Tiling::mercator, id.level)),
          first_x_(static_cast<double>(rules.side_px) * id.x - 1),
          first_y_(static_cast<double>(rules.side_px) * (tiles_down(id.level) - 1 - id.y) - 1) {
        numbers_.reserve(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
        constexpr double most = 0xff'ffff;
        constexpr double accuracy = 1.0 / 4096; // of a pixel: on a slope of 45 degrees less than a step of colours
        // Numbers of the whole map may be too large, so they begin at a square of places before the tile.
        const auto numbers_from = [&](std::int32_t tile) {
            return std::int64_t{rules.side_px} * tile & -std::int64_t{TexelPlaces::side};
        };
        const std::int32_t row = tiles_down(id.level) - 1 - id.y;
        const std::int64_t from_x = numbers_from(id.x), from_y = numbers_from(row);
        const auto x0 = static_cast<std::int32_t>(std::int64_t{rules.side_px} * id.x - from_x) - 1,
                   y0 = static_cast<std::int32_t>(std::int64_t{rules.side_px} * row - from_y) - 1;
        const TexelPlaces places({x0, y0, side_, side_}, accuracy, [&](double x, double y) -> TexelPlaces::Place {
            const double right = (static_cast<double>(from_x) + x + 0.5) / across_,
                         down = std::clamp((static_cast<double>(from_y) + y + 0.5) / across_, 0.0, 1.0);
            std::array<double, 2> place{};
            if (!finder.find({near_longitude(360 * right - 180, 0), latitude_of(down)}, place[0], place[1])) return {};
            return place;
        });
        for (int y = 0; y < side_; ++y)
            for (int x = 0; x < side_; ++x) {
                const TexelPlaces::Place place = places.at(x0 + x, y0 + y);
                const double height_m = place ? surface.height_m((*place)[0], (*place)[1]) : 0;
                const double number = std::round((height_m - code_.base_m) / code_.step_m);
                if (!(number >= 0 && number <= most))
                    throw Failure(1,
                                  fmt::format("{} m is a height that these colours cannot say; they go from {} to {} m",
                                              height_m, code_.base_m, code_.base_m + most * code_.step_m));
                numbers_.push_back(static_cast<std::uint32_t>(number));
            }
    }
    [[nodiscard]] double height_m(int x, int y) const { return code_.base_m + number(x, y) * code_.step_m; }

    // How far a height lies from what is between four pixels, at most: with the pixels of neighbours, and without.
    [[nodiscard]] double error_m(double longitude, double latitude, double height) const {
        const double x = (longitude + 180) / 360 * across_ - 0.5 - first_x_,
                     y = mercator_down(latitude) * across_ - 0.5 - first_y_;
        return std::max(between(std::clamp(x, 0.0, side_ - 1.0), std::clamp(y, 0.0, side_ - 1.0), height),
                        between(std::clamp(x, 1.0, side_ - 2.0), std::clamp(y, 1.0, side_ - 2.0), height));
    }

    void finish(bool webp, RasterTile& tile) const {
        std::vector<std::byte> rgb;
        tile.low_m = tile.high_m = height_m(1, 1);
        for (int y = 1; y < side_ - 1; ++y)
            for (int x = 1; x < side_ - 1; ++x) {
                const std::uint32_t n = number(x, y);
                for (const int shift : {16, 8, 0}) rgb.push_back(static_cast<std::byte>(n >> shift & 0xff));
                tile.low_m = std::min(tile.low_m, height_m(x, y)), tile.high_m = std::max(tile.high_m, height_m(x, y));
            }
        const auto side = static_cast<std::uint32_t>(side_ - 2);
        constexpr int channels = 3;
        tile.image = webp ? encode_image("WEBP", {side_ - 2, side_ - 2, GDT_Byte, rgb.data(), channels},
                                         {"LOSSLESS=YES"}, "a picture of heights")
                          : gltf::encode_png(side, side, rgb);
    }

private:
    [[nodiscard]] double between(double x, double y, double height) const {
        const int i = std::min(static_cast<int>(x), side_ - 2), j = std::min(static_cast<int>(y), side_ - 2);
        const double s = x - i, t = y - j;
        const double a = height_m(i, j), b = height_m(i + 1, j), c = height_m(i, j + 1), d = height_m(i + 1, j + 1);
        const double bilinear = (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d);
        const double falling = s > t ? a + s * (b - a) + t * (d - b) : a + t * (c - a) + s * (d - c),
                     rising = s + t < 1 ? a + s * (b - a) + t * (c - a) : d + (1 - s) * (c - d) + (1 - t) * (b - d);
        return std::max({std::abs(bilinear - height), std::abs(falling - height), std::abs(rising - height)});
    }
    [[nodiscard]] std::uint32_t number(int x, int y) const {
        return numbers_[static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(x)];
    }
    HeightCode code_;
    int side_;
    double across_, first_x_, first_y_; // pixels: of the whole map, and of it before ours
    std::vector<std::uint32_t> numbers_;
};

// The largest error in a tile of any level, part by part.
double measure(const GroundSurface& surface, const Pixels& pixels, TileId id, int finest_level,
               std::vector<GroundPiece>& ground) {
    const DegreeBox box = box_of(Tiling::mercator, id);
    double worst = 0;
    if (id.level < finest_level) {
        for (int child = 0; child < 4; ++child) {
            const TileId part = child_of(id, child);
            if (surface.touches(box_of(Tiling::mercator, part)))
                worst = std::max(worst, measure(surface, pixels, part, finest_level, ground));
        }
        return worst;
    }
    ground.clear();
    constexpr double every_sample = -1;
    surface.collect(box, every_sample, ground);
    for (const GroundPiece& g : ground)
        worst = std::max(worst, pixels.error_m(box.west + (box.east - box.west) * static_cast<double>(g.u),
                                               box.south + (box.north - box.south) * static_cast<double>(g.v),
                                               static_cast<double>(g.low)));
    return worst;
}

} // namespace

RasterTile make_raster_tile(const GroundSurface& surface, const SampleFinder& finder, TileId id,
                            const RasterRules& rules) {
    const Pixels pixels(surface, finder, id, rules);
    RasterTile tile;
    pixels.finish(rules.webp, tile);
    std::vector<GroundPiece> ground;
    constexpr double digits = 1e3; // rounded up: also what the places of samples are rounded to
    tile.error_m = std::ceil(measure(surface, pixels, id, rules.finest_level, ground) * digits + 0.5) / digits;
    return tile;
}

} // namespace fjell::baker
