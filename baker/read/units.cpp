#include "baker/read/units.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>

#include <cpl_string.h>
#include <fmt/format.h>
#include <ogr_spatialref.h>

namespace fjell::baker {

double unit_in_metres(const char* name) {
    std::string unit(name ? name : "");
    std::transform(unit.begin(), unit.end(), unit.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    struct Unit {
        std::string_view name;
        double metres;
    };
    constexpr double survey_foot = 1200.0 / 3937;
    constexpr std::array<Unit, 30> units{{{"", 1},
                                          {"m", 1},
                                          {"metre", 1},
                                          {"metres", 1},
                                          {"meter", 1},
                                          {"meters", 1},
                                          {"ft", 0.3048},
                                          {"foot", 0.3048},
                                          {"feet", 0.3048},
                                          {"international foot", 0.3048},
                                          {"international feet", 0.3048},
                                          {"us survey foot", survey_foot},
                                          {"us survey feet", survey_foot},
                                          {"us_survey_foot", survey_foot},
                                          {"foot_us", survey_foot},
                                          {"ftus", survey_foot},
                                          {"us-ft", survey_foot},
                                          {"usft", survey_foot},
                                          {"sfoot", survey_foot},
                                          {"survey foot", survey_foot},
                                          {"km", 1000},
                                          {"kilometre", 1000},
                                          {"kilometer", 1000},
                                          {"dm", 0.1},
                                          {"decimetre", 0.1},
                                          {"decimeter", 0.1},
                                          {"cm", 0.01},
                                          {"centimetre", 0.01},
                                          {"centimeter", 0.01},
                                          {"mm", 0.001}}};
    const auto found = std::find_if(units.begin(), units.end(), [&](const Unit& u) { return u.name == unit; });
    return found == units.end() ? 0 : found->metres;
}

namespace {

// Metres in one unit of the CRS' vertical axis; 0: it has none.
double vertical_unit(const OGRSpatialReference* crs, std::string& name) {
    if (!crs || (!crs->IsCompound() && !crs->IsVertical())) return 0;
    const char* text = nullptr;
    const double metres = crs->GetTargetLinearUnits("VERT_CS", &text);
    name = text ? text : "";
    return metres > 0 ? metres : 0;
}

double unit_of(GDALRasterBand& band, const OGRSpatialReference* crs, const ReadOptions& options,
               const std::string& path) {
    const std::string named = band.GetUnitType() ? band.GetUnitType() : "";
    const double unit = unit_in_metres(named.c_str());
    std::string axis;
    const double vertical = vertical_unit(crs, axis);
    if (unit == 0 && !options.zscale)
        throw Failure(1,
                      fmt::format("{}: heights are in \"{}\", which is not known here; give --zscale S (metres a unit)",
                                  path, named));
    if (unit == 0) return 1;                                                // --zscale says what a unit is
    if (vertical == 0 || std::abs(vertical / unit - 1) < 1e-5) return unit; // feet of two kinds differ by 2e-6
    if (named.empty()) return vertical;
    throw Failure(1,
                  fmt::format("{}: its band says that heights are in \"{}\", its CRS in \"{}\"; give it the CRS that "
                              "is right (gdal_edit.py -a_srs)",
                              path, named, axis));
}

} // namespace

std::string unit_name(GDALRasterBand& band, const OGRSpatialReference* crs) {
    std::string name = band.GetUnitType() ? band.GetUnitType() : "";
    if (name.empty()) (void)vertical_unit(crs, name);
    return name;
}

namespace {

// Depths: what netCDF calls positive downwards, or by a standard name of the sea floor's depth.
bool counts_downwards(GDALRasterBand& band) {
    const auto has = [&](const char* key, const char* word) {
        const char* const value = band.GetMetadataItem(key);
        return value && CPLString(value).ifind(word) != std::string::npos;
    };
    return has("positive", "down") || has("standard_name", "sea_floor_depth");
}

} // namespace

Scaling scaling_of(GDALRasterBand& band, const OGRSpatialReference* crs, const ReadOptions& options,
                   const std::string& path) {
    const double unit = unit_of(band, crs, options, path);
    int known = 0;
    const double scale = band.GetScale(&known), offset = band.GetOffset(&known);
    if (!options.zscale && counts_downwards(band))
        throw Failure(1,
                      fmt::format("{}: says that its numbers are depths; give --zscale -1 to make heights of them, or "
                                  "--zscale 1 if they are heights already",
                                  path));
    const Scaling s{scale * unit, offset * unit, options.zscale.value_or(1), options.zoffset_m};
    if (!std::isfinite(s.file_scale) || s.file_scale == 0 || !std::isfinite(s.file_offset_m))
        throw Failure(1,
                      fmt::format("{}: its band has scale {} and offset {}; set them right with gdal_edit.py -scale 1 "
                                  "-offset 0",
                                  path, scale, offset));
    return s;
}

} // namespace fjell::baker
