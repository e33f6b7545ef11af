// How far the metres of a projected CRS are from metres of the ground, where its axes point, and its degrees.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <ogr_spatialref.h>

namespace fjell::baker {

using CrsPlace = std::array<double, 2>; // in units of a CRS, as GDAL orders its axes in rasters: x first

struct CrsBox {
    double west = 0, south = 0, east = 0, north = 0;
    // Its corners, the middles of its edges and its own.
    [[nodiscard]] std::vector<CrsPlace> nine_places() const;
};

// Metres of the plane that a metre of ground becomes, over all directions at all places that were asked about.
struct GroundScale {
    double least = 1, most = 1;
    [[nodiscard]] double off() const; // 0.01: lengths are wrong by 1%
};

// Places that the CRS does not know are left out; nothing when none is left. Not for one that is not projected.
[[nodiscard]] std::optional<GroundScale> ground_scale(const OGRSpatialReference& crs,
                                                      const std::vector<CrsPlace>& places);

// Longitude and latitude of the same datum and meridian, in degrees: France counts grads from Paris.
[[nodiscard]] OGRSpatialReference degrees_of(const OGRSpatialReference& crs);

// False: x grows to the west, y to the south, or they stand for each other. Axes about a pole point nowhere and count.
[[nodiscard]] bool points_east_and_north(const OGRSpatialReference& crs);
// Where x and y of its rasters point: "west, south".
[[nodiscard]] std::string axes_text(const OGRSpatialReference& crs);

} // namespace fjell::baker
