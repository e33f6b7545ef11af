// JSON files as our programs read them, on top of nlohmann's: what is wrong is said with its line, in our words, and a
// key that is given twice is refused instead of taken once. Its parser is compiled once, in json.cpp: it is the dearest
// of all that our sources include.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "fjell/pack.h"

namespace fjell::io {

// name: of the file, for messages. line: which one of the file the text begins with. Comments are skipped where they
// are allowed. Throws Failure (1), "NAME:LINE: what".
enum class JsonComments : bool { no, yes };
[[nodiscard]] nlohmann::json parse_json(std::string_view text, const std::string& name,
                                        JsonComments comments = JsonComments::no, std::size_t line = 1);

// The line on which an item of a list begins that stands in the outermost object, of a text that parse_json() takes;
// 1 when there is none. For what is wrong with an item. O(text).
[[nodiscard]] std::size_t line_of_item(std::string_view text, std::string_view list, std::size_t item);

// Where a terrain lies: spacing_m, and origin_m of sample (0, 0) along the CRS' axes; crs_origin and crs_step say the
// same in units of the CRS, which may be feet or degrees. crs_step is null where it is not known.
[[nodiscard]] inline nlohmann::json place_json(const PackHeader& h) {
    const bool known = h.crs_step[0] > 0 && h.crs_step[1] > 0;
    const auto unit_m = [&](int axis) { return known ? h.spacing_m[axis] / h.crs_step[axis] : 1; };
    return {{"spacing_m", {h.spacing_m[0], h.spacing_m[1]}},
            {"origin_m", {h.crs_origin[0] * unit_m(0), h.crs_origin[1] * unit_m(1)}},
            {"crs_origin", {h.crs_origin[0], h.crs_origin[1]}},
            {"crs_step", known ? nlohmann::json{h.crs_step[0], h.crs_step[1]} : nlohmann::json()}};
}

} // namespace fjell::io
