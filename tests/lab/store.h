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
    // fresh: forgets what is there, but for how long it took.
    Store(const Recipe& recipe, const std::string& folder, bool fresh);
    [[nodiscard]] std::optional<nlohmann::json> find(const Case& c) const; // what was measured of it
    // seconds: what measuring it took.
    void add(const Case& c, const nlohmann::json& measured, double seconds);
    // How long cases that are not measured yet will take: what each took the last time, and otherwise its share of what
    // the recipe says.
    [[nodiscard]] double expected_s() const;

private:
    Recipe recipe_;
    std::string file_;
    std::map<std::string, nlohmann::json> measured_; // by key_of
    std::map<std::string, double> seconds_;          // by the same
};

} // namespace fjell::lab
