#include "baker/cli/describe.h"

#include <fmt/format.h>

#include "baker/georeference/crs_label.h"
#include "io/json.h"

namespace fjell::baker {

namespace {

using nlohmann::json;

// One number for square cells.
std::string spacing_text(const double (&step)[2]) {
    const std::string x = fmt::format("{:.6g}", step[0]), y = fmt::format("{:.6g}", step[1]);
    return x == y ? x : x + " x " + y;
}

void add_source(json& to, const SourceFacts& f) {
    to["height_unit"] = f.height_unit.empty() ? json() : json(f.height_unit);
    to["height_unit_m"] = f.height_unit_m;
    to["reprojected_from"] = json();
    if (!f.reprojected_from.empty())
        to["reprojected_from"] = {
            {"crs_name", f.reprojected_from}, {"spacing", {f.from_step[0], f.from_step[1]}}, {"unit", f.from_unit}};
}

} // namespace

std::string describe(const BakeSummary& s) {
    const SourceFacts& f = s.source;
    std::string text = fmt::format("heights {:.6g} to {:.6g} m (", s.min_m, s.max_m);
    text += f.height_unit.empty() ? "the file names no unit" : "in the file in " + f.height_unit;
    text += fmt::format(": 1 is {:.7g} m)", f.height_unit_m);
    const double samples = static_cast<double>(s.columns) * s.rows;
    text += s.voids ? fmt::format("; {} samples are holes ({:.2g}%)\n", s.voids,
                                  100 * static_cast<double>(s.voids) / samples)
                    : "; no holes\n";
    const std::string crs = crs_text(crs_label(s.crs_wkt));
    text += fmt::format("samples {} m apart, {}", spacing_text(s.spacing_m), crs.empty() ? "no CRS" : "in " + crs);
    if (!f.reprojected_from.empty())
        text += fmt::format("; reprojected from {}, where they are {} {} apart", f.reprojected_from,
                            spacing_text(f.from_step), f.from_unit);
    return text + "\n";
}

void add_description(json& to, const BakeSummary& s) {
    const CrsLabel crs = crs_label(s.crs_wkt);
    to["height_m"] = {s.min_m, s.max_m};
    to["ground_error_m"] = s.ground_error_m;
    to["spacing_m"] = {s.spacing_m[0], s.spacing_m[1]};
    to["crs_name"] = crs.name.empty() ? json() : json(crs.name);
    to["epsg"] = crs.epsg ? json(crs.epsg) : json();
    add_source(to, s.source);
}

void add_notes(json& to, const std::optional<PackNotes>& notes) {
    for (const char* key : {"ground_error_m", "read", "height_unit", "height_unit_m", "reprojected_from"})
        to[key] = json();
    if (!notes) return;
    if (notes->ground_error_m) to["ground_error_m"] = *notes->ground_error_m;
    if (!notes->read.empty()) to["read"] = io::parse_json(notes->read, "notes");
    add_source(to, notes->source);
}

} // namespace fjell::baker
