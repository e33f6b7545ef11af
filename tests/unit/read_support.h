// A slope that every reader must give back, with and without holes.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "baker/georeference/open_source.h"
#include "raster.h"

namespace fjell::test {

using namespace baker;

inline ReadOptions spaced(double spacing_m) {
    ReadOptions o;
    o.spacing_m = spacing_m;
    return o;
}
inline ReadOptions with(NoData nodata) {
    ReadOptions o;
    o.nodata = nodata;
    return o;
}
inline ReadOptions filling() {
    return with(NoData::fill);
}
inline constexpr NoData every_nodata[] = {NoData::automatic, NoData::hole, NoData::fill, NoData::refuse};
// What a refusal of heights that may be voids has to offer.
inline const std::vector<std::string> remedies{"--nodata hole to leave them open", "--nodata fill to fill them"};
inline Refusal refused(const std::string& path, const ReadOptions& options = {}) {
    return refusal([&] { (void)read_dem(path, options); });
}
inline double slope(int x, int y) {
    return 100 + 3 * x + 7 * y;
}
// Touches a border and is no mirror image of itself, so that a flip cannot hide.
inline bool in_hole(int x, int y) {
    return std::hypot(x - 10, y - 4) < 6 || (x == 30 && y > 20 && y < 25);
}
inline Raster slope_with(double nothing) {
    return raster(41, 31, [=](int x, int y) { return in_hole(x, y) ? nothing : slope(x, y); });
}
// "N of 1271": what a refusal counts.
inline std::string holes_of_all() {
    const Raster r = slope_with(-9999);
    const auto holes = std::count(r.values.begin(), r.values.end(), -9999);
    return std::to_string(holes) + " of " + std::to_string(r.values.size());
}
inline void tag(Raster& r, double nothing) {
    r.more = [=](GDALDataset& file) { file.GetRasterBand(1)->SetNoDataValue(nothing); };
}

inline void check_slope(const Dem& dem, int columns, int rows) {
    REQUIRE(dem.columns == columns);
    REQUIRE(dem.rows == rows);
    int wrong = 0;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) wrong += dem.at(x, y) != static_cast<float>(slope(x, y));
    CHECK(wrong == 0);
}

// Holes where in_hole says and nowhere else, the slope around them, and ground of the same kind under them.
inline void check_holes(const Dem& dem) {
    REQUIRE(dem.columns == 41);
    REQUIRE(dem.rows == 31);
    REQUIRE(dem.voids.size() == dem.heights_m.size());
    std::uint64_t holes = 0;
    int misplaced = 0, wrong = 0;
    for (int y = 0; y < 31; ++y)
        for (int x = 0; x < 41; ++x) {
            const float height = dem.at(x, y);
            holes += in_hole(x, y);
            misplaced += dem.is_void(x, y) != in_hole(x, y);
            if (in_hole(x, y)) // means of neighbours lie between the lowest and the highest, on the source's step
                wrong += !(height >= slope(0, 0) && height <= slope(40, 30)) || height != std::round(height);
            else
                wrong += height != static_cast<float>(slope(x, y));
        }
    CHECK(misplaced == 0);
    CHECK(wrong == 0);
    CHECK(void_count(dem) == holes);
    CHECK(dem.native_quantum_m == 1);
}

} // namespace fjell::test
