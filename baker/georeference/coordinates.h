// Places of a pack's terrain in the coordinates of its CRS, and in degrees of the same datum.
//
// Units: terrain in metres east and south of sample (0, 0); the CRS in its own units, east and north; degrees north and
// east. Thread: one at a time. Memory: PROJ's, some 100 kB. Complexity: in_crs() is two products, degrees() a
// transformation, some microseconds. Failure: io::Failure 3 where GDAL is missing; what a CRS cannot say is none.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "fjell/pack.h"

class OGRCoordinateTransformation;

namespace fjell::baker {

class Coordinates {
public:
    // crs_wkt: the pack's; empty: it has no coordinates.
    Coordinates(const PackHeader& header, const std::string& crs_wkt);
    ~Coordinates();
    Coordinates(const Coordinates&) = delete;
    Coordinates& operator=(const Coordinates&) = delete;

    [[nodiscard]] const std::string& crs() const { return crs_; }     // "NAD83 / UTM zone 10N (EPSG:26910)"; or empty
    [[nodiscard]] const std::string& datum() const { return datum_; } // of the degrees: "NAD83"; empty: there are none
    [[nodiscard]] bool projected() const { return !unit_.empty(); }
    [[nodiscard]] const std::string& unit() const { return unit_; } // of a projected CRS: "m", "US survey foot"
    [[nodiscard]] std::array<double, 2> in_crs(double x_m, double z_m) const;
    [[nodiscard]] std::optional<std::array<double, 2>> degrees(double x_m, double z_m) const; // latitude, longitude

private:
    double origin_[2] = {}, step_[2] = {1, 1}, spacing_m_[2] = {1, 1};
    std::string crs_, datum_, unit_;
    struct Free {
        void operator()(OGRCoordinateTransformation* transformation) const;
    };
    std::unique_ptr<OGRCoordinateTransformation, Free> to_degrees_; // null: the CRS' axes are degrees, or not on Earth
};

} // namespace fjell::baker
