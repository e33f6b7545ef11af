#include "baker/cli/summary.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

#include "baker/georeference/crs_label.h"
#include "fjell/io/failure.h"
#include "io/json.h"

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
           {"splat_bytes", s.splat_bytes},
           {"always_drawn", s.always_drawn},
           {"kept_bytes", s.kept_bytes},
           {"kept_nothing", s.kept_nothing},
           {"resumed", s.resumed},
           {"resident_mb_max", most_resident_mb()},
           {"seconds_read", s.seconds_read},
           {"seconds_textures", s.seconds_textures},
           {"seconds_horizons", s.seconds_horizons},
           {"seconds_splat", s.seconds_splat},
           {"seconds_errors", s.seconds_errors},
           {"seconds_write", s.seconds_write},
           {"seconds_total", s.seconds_total}};
    add_description(j, s);
    return j;
}

void print_summary(const BakeSummary& s, const std::string& output) {
    if (s.work_damaged) fmt::print("the work files of an earlier bake were damaged; this bake began anew\n");
    fmt::print("{}: {} x {} samples in {} x {} tiles of {} cells, quantum {:.4g} m; the coarsest mesh is off by up to "
               "{:.4g} m\n",
               output, s.columns, s.rows, s.tree.tiles_x, s.tree.tiles_y, s.tree.side(), s.quantum_m, s.ground_error_m);
    fmt::print("{}", describe(s));
    if (const auto tiles = std::int64_t{s.tree.tiles_x} * s.tree.tiles_y; tiles > 1024)
        fmt::print("its {} tiles need as many page_slots in a profile that streams it; a larger --tile needs fewer\n",
                   tiles);
    const double samples = static_cast<double>(s.columns) * s.rows;
    fmt::print("{:.1f} MB ({:.2f} bytes a sample of geometry) in {:.1f} s ({:.1f} M samples/s; errors {:.1f} s)\n",
               static_cast<double>(s.file_bytes) / 1e6, static_cast<double>(s.geometry_bytes) / samples,
               s.seconds_total, samples / s.seconds_total / 1e6, s.seconds_errors);
    if (s.kept_bytes != 0)
        fmt::print("no stamp reaches {:.1f} MB of it: those are the pack's own\n",
                   static_cast<double>(s.kept_bytes) / 1e6);
    if (!s.kept_nothing.empty()) fmt::print("all of it was baked: {}\n", s.kept_nothing);
    for (const std::string& line : remarks(s)) fmt::print("{}\n", line);
}

void print_set(const SetSummary& s, const std::string& folder) {
    fmt::print("{}: {} packs, {:.1f} MB{}\n", folder, s.packs, static_cast<double>(s.file_bytes) / 1e6,
               s.left_out ? fmt::format("; {} without any ground are left out", s.left_out) : "");
}

Recipe complete(const Recipe& given, const std::string& recipe_path) {
    if (recipe_path.empty()) return given;
    std::vector<std::string> renamed;
    const Recipe below = load_recipe(recipe_path, &renamed);
    for (const std::string& line : renamed) fmt::print(stderr, "fjell-bake: {}\n", line);
    return merged(given, below);
}

namespace {

using nlohmann::json;

// One number for square cells.
std::string spacing_text(const double (&step)[2]) {
    const std::string x = fmt::format("{:.6g}", step[0]), y = fmt::format("{:.6g}", step[1]);
    return x == y ? x : x + " x " + y;
}

void add_source(json& to, const SourceFacts& f) {
    for (const auto& [key, text] : {std::pair{"driver", &f.driver},
                                    {"type", &f.type},
                                    {"voids", &f.voids},
                                    {"band", &f.band},
                                    {"coarse", &f.coarse},
                                    {"height_unit", &f.height_unit},
                                    {"resampled", &f.resampled}})
        to[key] = text->empty() ? json() : json(*text);
    to["height_unit_m"] = f.height_unit_m;
    to["ground_scale"] = f.ground_scale[0] > 0 ? json{f.ground_scale[0], f.ground_scale[1]} : json();
    to["reprojected_from"] = json();
    if (!f.reprojected_from.empty())
        to["reprojected_from"] = {{"crs_name", f.reprojected_from},
                                  {"axes", f.axes.empty() ? "east, north" : f.axes},
                                  {"spacing", {f.from_step[0], f.from_step[1]}},
                                  {"unit", f.from_unit}};
}

} // namespace

std::string describe(const BakeSummary& s, bool source_known) {
    const SourceFacts& f = s.source;
    std::string text = fmt::format("heights {:.6g} to {:.6g} m", s.min_m, s.max_m);
    if (source_known) {
        text += " (";
        if (!f.driver.empty()) text += f.driver + ", " + f.type + "; ";
        if (!f.band.empty()) text += "band " + f.band + "; ";
        text += f.height_unit.empty() ? "the file names no unit" : "the file's unit is " + f.height_unit;
        text += fmt::format("; 1 in it is {:.7g} m)", f.height_unit_m);
    }
    const double samples = static_cast<double>(s.columns) * s.rows;
    text += s.voids
                ? fmt::format("; {} samples are holes ({:.2g}%)", s.voids, 100 * static_cast<double>(s.voids) / samples)
                : "; no holes";
    text += f.voids.empty() ? "\n" : "; voids by " + f.voids + "\n";
    const std::string crs = crs_text(crs_label(s.crs_wkt));
    text += fmt::format("samples {} m apart, {}", spacing_text(s.spacing_m), crs.empty() ? "no CRS" : "in " + crs);
    if (!f.reprojected_from.empty())
        text += fmt::format("; reprojected from {}{}, where they are {} {} apart{}", f.reprojected_from,
                            f.axes.empty() ? "" : " (axes " + f.axes + ")", spacing_text(f.from_step), f.from_unit,
                            f.resampled.empty() ? "" : ": " + f.resampled);
    const auto& [least, most] = f.ground_scale;
    if (least > 0) text += fmt::format("; a metre of ground is {:.4f} to {:.4f} m in it", least, most);
    text += "\n";
    for (const std::string& image : s.images) text += "image " + image + "\n";
    if (!f.coarse.empty()) text += "less detail: " + f.coarse + "\n";
    if (!s.locks.empty()) text += "locks: " + s.locks + "\n";
    return text;
}

void add_description(json& to, const BakeSummary& s) {
    const CrsLabel crs = crs_label(s.crs_wkt);
    to["height_m"] = {s.min_m, s.max_m};
    to["ground_error_m"] = s.ground_error_m;
    to["spacing_m"] = {s.spacing_m[0], s.spacing_m[1]};
    to["crs_name"] = crs.name.empty() ? json() : json(crs.name);
    to["epsg"] = crs.epsg ? json(crs.epsg) : json();
    to["images"] = s.images;
    to["locks"] = s.locks.empty() ? json() : json(s.locks);
    add_source(to, s.source);
}

void add_notes(json& to, const std::optional<PackNotes>& notes) {
    for (const char* key : {"images", "locks", "driver", "type", "voids", "ground_error_m", "read", "band", "coarse",
                            "height_unit", "height_unit_m", "ground_scale", "reprojected_from", "resampled"})
        to[key] = json();
    if (!notes) return;
    if (notes->ground_error_m) to["ground_error_m"] = *notes->ground_error_m;
    if (!notes->read.empty()) to["read"] = io::parse_json(notes->read, "notes");
    to["images"] = notes->images;
    if (!notes->locks.empty()) to["locks"] = notes->locks;
    add_source(to, notes->source);
}

namespace {
constexpr int bar_cells = 30;
}

ProgressBar::ProgressBar(bool quiet) : draws_(!quiet && isatty(STDERR_FILENO)) {}

ProgressBar::~ProgressBar() {
    if (drawn_) std::fputs("\r\033[K", stderr);
}

void ProgressBar::operator()(const char* stage, std::uint64_t done, std::uint64_t total) {
    io::check_interrupt();
    if (!draws_ || total == 0) return;
    const auto now = std::chrono::steady_clock::now();
    if (stage_ != stage) {
        stage_ = stage;
        start_ = now;
        last_ = {};
    }
    if (done < total && now - last_ < std::chrono::milliseconds(50)) return;
    last_ = now;
    drawn_ = true;
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const double share = static_cast<double>(done) / static_cast<double>(total);
    const double rate = elapsed > 0 ? static_cast<double>(done) / elapsed : 0;
    const auto full = static_cast<std::size_t>(share * bar_cells);
    const std::string bar = std::string(full, '#') + std::string(bar_cells - full, '.');
    const double left = rate > 0 ? static_cast<double>(total - done) / rate : 0;
    const std::string speed = rate >= 1e6 ? fmt::format("{:.1f} M/s", rate / 1e6) : fmt::format("{:.0f} /s", rate);
    fmt::print(stderr, "\r\033[K{:<8} [{}] {:3.0f}%  {}  {:.0f} s left", stage, bar, share * 100, speed, left);
    std::fflush(stderr);
}

} // namespace fjell::baker
