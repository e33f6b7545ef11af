#include "baker/georeference/crs_label.h"

#include <cstdlib>
#include <string_view>

#include <fmt/format.h>

namespace fjell::baker {

// As GDAL writes it: KEYWORD["name",...,AUTHORITY["EPSG","code"]], or with ID["EPSG",code] at its end where it takes
// the second version of WKT, for projections that the first does not have. GDAL itself takes a tenth of a second to be
// loaded.
CrsLabel crs_label(const std::string& wkt) {
    const std::size_t name = wkt.find('"') + 1, end = wkt.find('"', name);
    if (name == 0 || end == std::string::npos) return {};
    CrsLabel label{wkt.substr(name, end - name)};
    for (const std::string_view authority : {"AUTHORITY[\"EPSG\",\"", "ID[\"EPSG\","}) {
        const std::size_t last = wkt.rfind(authority);
        if (last == std::string::npos) continue;
        const std::string code = wkt.substr(last + authority.size());
        if (code.find_first_not_of("0123456789\"") == code.rfind("]]")) label.epsg = std::atoi(code.c_str());
    }
    return label;
}

std::string crs_text(const CrsLabel& label) {
    return label.epsg ? fmt::format("{} (EPSG:{})", label.name, label.epsg) : label.name;
}

std::string vertical_name(const std::string& wkt) {
    for (const std::string_view keyword : {"VERT_CS[\"", "VERTCRS[\""})
        if (const std::size_t at = wkt.find(keyword); at != std::string::npos) {
            const std::size_t name = at + keyword.size();
            return wkt.substr(name, wkt.find('"', name) - name);
        }
    return {};
}

} // namespace fjell::baker
