// Places on the globe: WGS 84, the grids of tiles that globes are cut into, and where a terrain's samples lie on them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <ogr_spatialref.h>

#include "baker/read/source.h"

namespace fjell::baker {

inline constexpr double globe_radius_m = 6378137; // at the equator, as WGS 84 has it
inline constexpr double globe_polar_radius_m = 6356752.314245179;

// Earth-centred, metres: x through longitude 0, z through the north pole.
using GlobePlace = std::array<double, 3>;
struct LonLat {
    double longitude = 0, latitude = 0;
};
[[nodiscard]] GlobePlace on_globe(LonLat at, double height_m);
// The unit vector that points up there.
[[nodiscard]] GlobePlace up_at(LonLat at);
// Of a place on the ellipsoid, or nearly on it.
[[nodiscard]] LonLat lon_lat_of(const GlobePlace& place);

// The larger angle's way round: longitude within half a turn of `middle`.
[[nodiscard]] double near_longitude(double longitude, double middle);

struct DegreeBox {
    double west = 0, south = 0, east = 0, north = 0;
    [[nodiscard]] LonLat middle() const { return {(west + east) / 2, (south + north) / 2}; }
};

struct TileId {
    std::int32_t level = 0, x = 0, y = 0; // y from the south, as TMS counts
    friend bool operator==(const TileId&, const TileId&) = default;
};

[[nodiscard]] constexpr TileId parent_of(TileId t) {
    return {t.level - 1, t.x >> 1, t.y >> 1};
}
// child: 0 to 3, eastwards first.
[[nodiscard]] constexpr TileId child_of(TileId t, int child) {
    return {t.level + 1, 2 * t.x + (child & 1), 2 * t.y + (child >> 1)};
}

// Quad trees of tiles. A tile's edges are the same numbers as its neighbours', bit for bit.
enum class Tiling : std::uint8_t { geographic, mercator }; // EPSG:4326 with two roots, EPSG:3857 with one
[[nodiscard]] std::int32_t tiles_across(Tiling tiling, std::int32_t level);
[[nodiscard]] std::int32_t tiles_down(std::int32_t level);
[[nodiscard]] DegreeBox box_of(Tiling tiling, TileId tile);
// What CesiumJS takes a tile's error for, whatever the tile says of itself: 77,067 m / 2^level where level 0 has two
// tiles, and twice as much where it has one.
[[nodiscard]] double assumed_error_m(Tiling tiling, std::int32_t level);

// Where the samples of a height field lie: exact at nodes of a coarse grid, Lagrange's cubic between them, to within
// 1e-5 of the samples' spacing, which is measured. Thread: immutable.
class SamplePlaces {
public:
    // Throws Failure 1: no CRS, or one that leads to no place on Earth.
    explicit SamplePlaces(const HeightSource& source, const std::string& name);
    // Height 0. Any place inside the field, also between samples.
    [[nodiscard]] GlobePlace at(double column, double row) const;

private:
    bool fill(const HeightSource& source, double nodes_apart);
    std::int32_t nodes_x_ = 0, nodes_y_ = 0;
    double step_x_ = 1, step_y_ = 1; // samples between nodes
    std::vector<GlobePlace> nodes_;
};

// The way back. One thread.
class SampleFinder {
public:
    explicit SampleFinder(const HeightSource& source);
    // False: the height field's CRS has no such place.
    [[nodiscard]] bool find(LonLat at, double& column, double& row) const;

private:
    struct Free {
        void operator()(OGRCoordinateTransformation* t) const { OGRCoordinateTransformation::DestroyCT(t); }
    };
    double origin_[2], step_[2];
    std::int32_t columns_, rows_;
    std::unique_ptr<OGRCoordinateTransformation, Free> to_field_, to_globe_;
};

} // namespace fjell::baker
