#include "baker/place/crs_label.h"

#include <cstdlib>
#include <string_view>

#include <fmt/format.h>
#include <ogr_spatialref.h>

#include "baker/read/gdal_file.h"

namespace fjell::baker {

CrsLabel crs_label(const std::string& wkt) {
    const GdalMessages quiet;
    OGRSpatialReference crs;
    if (wkt.empty() || crs.importFromWkt(wkt.c_str()) != OGRERR_NONE) return {};
    CrsLabel label;
    if (const char* name = crs.GetName()) label.name = name;
    const char* const authority = crs.GetAuthorityName(nullptr);
    const char* const code = crs.GetAuthorityCode(nullptr);
    if (authority && code && std::string_view(authority) == "EPSG") label.epsg = std::atoi(code);
    return label;
}

std::string crs_text(const CrsLabel& label) {
    return label.epsg ? fmt::format("{} (EPSG:{})", label.name, label.epsg) : label.name;
}

} // namespace fjell::baker
