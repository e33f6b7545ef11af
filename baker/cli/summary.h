// What the commands that bake have in common: inputs by their recipe, and what they say in the end.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "baker/bake/bake.h"
#include "baker/bake/recipe.h"
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
// Files of heights, or one of content/terrain: mountains are made as they are asked for.
[[nodiscard]] std::unique_ptr<HeightSource> open_inputs(const Recipe& recipe);

} // namespace fjell::baker
