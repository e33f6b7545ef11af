// What was measured of a recipe's cases, to look numbers up in. Immutable; O(cases) a look.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "lab/published.h"
#include "lab/recipe.h"
#include "lab/store.h"

namespace fjell::lab {

struct Result {
    Case c;
    nlohmann::json measured; // empty object: not yet
    [[nodiscard]] std::optional<double> value(const std::string& measure) const {
        const auto at = measured.find(measure);
        return at == measured.end() ? std::nullopt : std::optional(at->get<double>());
    }
};

struct Results {
    Recipe recipe;
    std::vector<Published> published;
    std::vector<Result> all; // in the recipe's order
    [[nodiscard]] std::size_t done() const;
    // Which fields of Case differ among them, in the order that tables have; always the method.
    [[nodiscard]] std::vector<std::string> varying() const;
};
[[nodiscard]] Results results_of(const Recipe& recipe, const Store& store, std::vector<Published> published);

// Two or three sentences, as the numbers have them.
[[nodiscard]] std::string conclusion_of(const Results& results);

} // namespace fjell::lab
