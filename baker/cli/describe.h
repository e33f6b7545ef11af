// What a bake made of its source, in words and as JSON.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "baker/bake/bake.h"
#include "baker/pack/notes.h"

namespace fjell::baker {

// Several lines: heights and their unit, holes, CRS, where it was reprojected from.
[[nodiscard]] std::string describe(const BakeSummary& summary);

// The keys that say the same: height_m, height_unit, height_unit_m, ground_error_m, spacing_m, crs_name, epsg,
// reprojected_from (null, or its crs_name, spacing and unit).
void add_description(nlohmann::json& to, const BakeSummary& summary);
// What a pack says of it: ground_error_m, read, height_unit, height_unit_m, reprojected_from; null where it does not.
void add_notes(nlohmann::json& to, const std::optional<PackNotes>& notes);

} // namespace fjell::baker
