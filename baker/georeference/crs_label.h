// A CRS by its name and EPSG code, for display.
#pragma once

#include <string>

namespace fjell::baker {

struct CrsLabel {
    std::string name; // empty: none
    int epsg = 0;     // 0: not known
};
// wkt: as packs and sources have it.
[[nodiscard]] CrsLabel crs_label(const std::string& wkt);
// "WGS 84 / UTM zone 30N (EPSG:32630)"; empty: none.
[[nodiscard]] std::string crs_text(const CrsLabel& label);

// Of a CRS that says what heights count from, its name for it: "EGM96 height"; empty: it does not say.
[[nodiscard]] std::string vertical_name(const std::string& wkt);

} // namespace fjell::baker
