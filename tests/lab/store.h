// What was measured, a line of JSON for each case, appended as it comes: an interrupted run goes on where it was.
//
// One file for each recipe, NAME.jsonl. A line that is not whole, as a kill leaves it, is dropped; one whose case the
// recipe does not have now stays. Thread: one. Failure: io::Failure, 3 for a disk that fails.
#pragma once

#include <map>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "lab/recipe.h"

namespace fjell::lab {

class Store {
public:
    // fresh: forgets what is there.
    Store(const Recipe& recipe, const std::string& folder, bool fresh);
    [[nodiscard]] std::optional<nlohmann::json> find(const Case& c) const; // what was measured of it
    void add(const Case& c, const nlohmann::json& measured);

private:
    Recipe recipe_;
    std::string file_;
    std::map<std::string, nlohmann::json> measured_; // by key_of
};

} // namespace fjell::lab
