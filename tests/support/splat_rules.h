// A file of rules for splat maps, for tests that bake one.
#pragma once

#include <fstream>
#include <string>

#include "support/temporary_folder.h"

namespace fjell::test {

// All kinds of ranges, five materials.
inline constexpr const char* splat_rules = R"({"rules": [
  {"layer": "grass"},
  {"layer": "soil", "aspect_deg": [300, 80], "aspect_soft_deg": 40, "opacity": 0.7},
  {"layer": "gravel", "wetness": [6, null], "wetness_soft": 2},
  {"layer": "scree", "curvature_per_km": [null, -2], "curvature_soft_per_km": 4, "noise": [0.4, 1], "noise_m": 300},
  {"layer": "rock", "slope_deg": [30, null], "slope_soft_deg": 20, "ragged": 1}
]})";

class RulesFile {
public:
    explicit RulesFile(const std::string& rules = splat_rules) { std::ofstream(path()) << rules; }
    [[nodiscard]] std::string path() const { return folder_ / "rules.json"; }
    // A file beside it.
    [[nodiscard]] std::string beside(const std::string& name) const { return folder_ / name; }

private:
    TemporaryFolder folder_;
};

} // namespace fjell::test
