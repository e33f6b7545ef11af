#include "baker/read/placement.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <cpl_string.h>
#include <fmt/format.h>
#include <ogr_spatialref.h>

namespace fjell::baker {

namespace {

bool near_zero(double v, double beside) {
    return std::abs(v) <= 1e-9 * std::abs(beside);
}

// netCDF: an axis in degrees_east, or one that is called a longitude without a unit, as GMT writes both.
bool names_degrees(GDALDataset& file) {
    constexpr std::array<const char*, 4> words{"units=degree", "standard_name=longitude", "long_name=longitude",
                                               "[degrees_east]"};
    const char* const* metadata = file.GetMetadata();
    for (const char* const* entry = metadata; entry && *entry; ++entry)
        if (std::any_of(words.begin(), words.end(),
                        [line = CPLString(*entry)](const char* word) { return line.ifind(word) != std::string::npos; }))
            return true;
    return false;
}

// No CRS, but every place is a latitude and longitude, and no pixel is larger than 5 degrees: an ASCII grid of a globe.
bool looks_like_degrees(const double* t, int columns, int rows) {
    const double west = std::min(t[0], t[0] + columns * t[1]), east = std::max(t[0], t[0] + columns * t[1]);
    const double south = std::min(t[3], t[3] + rows * t[5]), north = std::max(t[3], t[3] + rows * t[5]);
    return west >= -181 && east <= 361 && south >= -91 && north <= 91 && std::abs(t[1]) <= 5 && std::abs(t[5]) <= 5;
}

} // namespace

std::string wkt_of(const OGRSpatialReference& crs) {
    char* text = nullptr;
    const bool exported = crs.exportToWkt(&text) == OGRERR_NONE && text;
    std::string wkt = exported ? text : "";
    CPLFree(text);
    return wkt;
}

void crs_step_of(const double (&spacing_m)[2], const std::string& crs_wkt, double (&step)[2]) {
    step[0] = step[1] = 0;
    OGRSpatialReference crs;
    if (crs_wkt.empty() || crs.importFromWkt(crs_wkt.c_str()) != OGRERR_NONE) return;
    if (!crs.IsProjected() && !crs.IsLocal()) return;
    const double unit_m = crs.GetLinearUnits();
    for (const int axis : {0, 1})
        if (unit_m > 0) step[axis] = spacing_m[axis] / unit_m;
}

Placement place(GDALDataset& file, const std::string& path) {
    Placement p;
    p.columns = file.GetRasterXSize();
    p.rows = file.GetRasterYSize();
    std::array<double, 6> t{};
    if (file.GetGeoTransform(t.data()) != CE_None) return p;
    if (!std::all_of(t.begin(), t.end(), [](double v) { return std::isfinite(v); }) || t[1] == 0 || t[5] == 0 ||
        !near_zero(t[2], t[1]) || !near_zero(t[4], t[5]))
        throw Failure(1, fmt::format("{}: its grid is rotated or sheared; straighten it first with gdalwarp", path));
    const OGRSpatialReference* const crs = file.GetSpatialRef();
    p.axes = Axes::metres;
    if (crs ? crs->IsGeographic() != 0 : names_degrees(file))
        p.axes = Axes::degrees;
    else if (!crs && looks_like_degrees(t.data(), p.columns, p.rows))
        p.axes = Axes::perhaps_degrees;
    if (crs && p.axes == Axes::metres) p.unit_m = crs->GetLinearUnits();
    p.flip_x = t[1] < 0;
    p.flip_y = t[5] > 0;
    p.step[0] = std::abs(t[1]);
    p.step[1] = std::abs(t[5]);
    p.origin[0] = t[0] + t[1] * (p.flip_x ? p.columns - 0.5 : 0.5);
    // Longitudes count from anywhere, but projections know no more than a turn to each side.
    if (p.axes == Axes::degrees && (p.origin[0] >= 360 || p.east(p.columns - 1) <= -360))
        p.origin[0] -= 360 * std::floor((p.origin[0] + 180) / 360);
    p.origin[1] = t[3] + t[5] * (p.flip_y ? p.rows - 0.5 : 0.5);
    // A local frame says nothing about where on Earth it is; other programs could do nothing with it.
    if (crs && !crs->IsLocal()) p.crs_wkt = wkt_of(*crs);
    return p;
}

} // namespace fjell::baker
