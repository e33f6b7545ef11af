#include "baker/place/crs_label.h"

#include <cstdlib>
#include <string_view>

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

} // namespace fjell::baker
