#include "baker/cli/summary.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <fmt/format.h>

#include "baker/cli/describe.h"
#include "baker/georeference/open_source.h"
#include "baker/synth/synth.h"

namespace fjell::baker {

using nlohmann::json;

void JsonOutput::write(const json& value) {
    const std::string text = value.dump(2) + "\n";
    if (to_stdout_) fmt::print("{}", text);
    if (!file_) return;
    file_->write(std::as_bytes(std::span(text)));
    file_->commit();
}

namespace {

// The most memory that this program was resident with; 0 where the system does not say.
double most_resident_mb() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmHWM:")) return std::strtod(line.c_str() + 6, nullptr) / 1024;
    return 0;
}

// Heights that many samples share: null for none.
json repeated_json(const RepeatedHeight& r) {
    if (r.share == 0) return {};
    return {{"height_m", r.height_m}, {"number", r.number}, {"share", r.share}, {"first", {r.column, r.row}}};
}

} // namespace

json summary_json(const BakeSummary& s) {
    json j{{"columns", s.columns},
           {"rows", s.rows},
           {"tiles", {s.tree.tiles_x, s.tree.tiles_y}},
           {"tile_cells", s.tree.side()},
           {"quantum_m", s.quantum_m},
           {"quantum_range_m", s.quantum_range_m},
           {"max_error_m", s.max_error_m},
           {"file_bytes", s.file_bytes},
           {"geometry_bytes", s.geometry_bytes},
           {"directory_bytes", s.directory_bytes},
           {"holes", s.voids},
           {"repeated_lowest", repeated_json(s.lowest)},
           {"repeated_highest", repeated_json(s.highest)},
           {"texture_bytes", s.texture_bytes},
           {"horizon_bytes", s.horizon_bytes},
           {"control_bytes", s.control_bytes},
           {"resumed", s.resumed},
           {"resident_mb_max", most_resident_mb()},
           {"seconds_read", s.seconds_read},
           {"seconds_textures", s.seconds_textures},
           {"seconds_horizons", s.seconds_horizons},
           {"seconds_control", s.seconds_control},
           {"seconds_errors", s.seconds_errors},
           {"seconds_write", s.seconds_write},
           {"seconds_total", s.seconds_total}};
    add_description(j, s);
    return j;
}

void print_summary(const BakeSummary& s, const std::string& output) {
    if (s.work_damaged) fmt::print("what an earlier bake had left in its work folder was damaged; baked anew\n");
    fmt::print("{}: {} x {} samples in {} x {} tiles of {} cells, quantum {:.4g} m, largest error {:.4g} m\n", output,
               s.columns, s.rows, s.tree.tiles_x, s.tree.tiles_y, s.tree.side(), s.quantum_m, s.ground_error_m);
    fmt::print("{}", describe(s));
    if (const auto tiles = std::int64_t{s.tree.tiles_x} * s.tree.tiles_y; tiles > 1024)
        fmt::print("its {} tiles need as many page_slots in a profile that streams it; a larger --tile needs fewer\n",
                   tiles);
    const double samples = static_cast<double>(s.columns) * s.rows;
    fmt::print("{:.1f} MB ({:.2f} bytes a sample of geometry) in {:.1f} s ({:.1f} M samples/s; errors {:.1f} s)\n",
               static_cast<double>(s.file_bytes) / 1e6, static_cast<double>(s.geometry_bytes) / samples,
               s.seconds_total, samples / s.seconds_total / 1e6, s.seconds_errors);
    for (const std::string& line : remarks(s)) fmt::print("{}\n", line);
}

void print_set(const SetSummary& s, const std::string& folder) {
    fmt::print("{}: {} packs, {:.1f} MB{}\n", folder, s.packs, static_cast<double>(s.file_bytes) / 1e6,
               s.left_out ? fmt::format("; {} without any ground are left out", s.left_out) : "");
}

Recipe complete(const Recipe& given, const std::string& recipe_path) {
    return recipe_path.empty() ? given : merged(given, load_recipe(recipe_path));
}

std::unique_ptr<HeightSource> open_inputs(const Recipe& recipe) {
    if (recipe.inputs.size() == 1 && recipe.inputs[0].ends_with(".json")) return open_synth(recipe.inputs[0]);
    return open_source(recipe.inputs, read_options(recipe));
}

} // namespace fjell::baker
