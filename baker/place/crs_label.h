// A CRS by its name and EPSG code, for display.
#pragma once

#include <string>

namespace fjell::baker {

struct CrsLabel {
    std::string name; // empty: none
    int epsg = 0;     // 0: not known
};
[[nodiscard]] CrsLabel crs_label(const std::string& wkt);

} // namespace fjell::baker
