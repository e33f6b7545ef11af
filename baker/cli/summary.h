// What the commands that bake have in common: inputs by their recipe, and what they say in the end.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "baker/bake/bake.h"
#include "baker/bake/recipe.h"
#include "baker/pack/notes.h"
#include "baker/pack/write_set.h"
#include "io/file.h"

namespace fjell::baker {

// A summary for scripts, opened before the work so that a missing folder does not cost a bake.
class JsonOutput {
public:
    explicit JsonOutput(const std::string& path) : to_stdout_(path == "-") {
        if (!path.empty() && !to_stdout_) file_.emplace(path);
    }
    void write(const nlohmann::json& value);

private:
    bool to_stdout_;
    std::optional<io::AtomicFile> file_;
};

[[nodiscard]] nlohmann::json summary_json(const BakeSummary& summary);
void print_summary(const BakeSummary& summary, const std::string& output);
// A line on the packs of a set.
void print_set(const SetSummary& set, const std::string& folder);

// The command line, completed from --recipe.
[[nodiscard]] Recipe complete(const Recipe& given, const std::string& recipe_path);

// What a bake made of its source, in words and as JSON.

// Several lines: heights and their unit, holes, CRS, where it was reprojected from.
// source_known: false where a pack is too old to say what its file was.
[[nodiscard]] std::string describe(const BakeSummary& summary, bool source_known = true);

// The keys that say the same: height_m, height_unit, height_unit_m, ground_error_m, spacing_m, crs_name, epsg,
// driver, type, band, voids, coarse (null: not told), images, locks, ground_scale, resampled, reprojected_from (null,
// or its crs_name, axes, spacing and unit).
void add_description(nlohmann::json& to, const BakeSummary& summary);
// What a pack says of it: ground_error_m, read, height_unit, height_unit_m, reprojected_from; null where it does not.
void add_notes(nlohmann::json& to, const std::optional<PackNotes>& notes);

// A progress bar with rate and time left, on a terminal only; also where Ctrl-C is noticed.

class ProgressBar {
public:
    explicit ProgressBar(bool quiet); // quiet, or stderr not a terminal: draws nothing
    ~ProgressBar();                   // leaves the terminal's line clean
    // Throws Failure when the process was asked to stop, so that destructors remove what is half-written.
    void operator()(const char* stage, std::uint64_t done, std::uint64_t total);

private:
    bool draws_;
    bool drawn_ = false;
    std::string stage_;
    std::chrono::steady_clock::time_point start_, last_;
};

} // namespace fjell::baker
