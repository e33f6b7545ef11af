// One case flown and measured.
//
// Times are what this thread works in the update alone, of every frame once, after eight updates of the first view.
// Numbers are rounded to five digits, so that a table and a file say the same. Thread: one. Failure: io::Failure, 1
// when a budget does not suffice, 130 when interrupted.
#pragma once

#include <nlohmann/json.hpp>

#include "lab/count.h"
#include "lab/world.h"

namespace fjell::lab {

// The recipe's measures by key; those that a method does not have are absent. And frames, how many were flown,
// and flown_cells_a_frame.
// number: the case's place among the recipe's. out: a folder for pictures of rivals' meshes.
[[nodiscard]] nlohmann::json measure_case(const Recipe& recipe, const Case& c, std::size_t number, World& world,
                                          const Counting& counting, const std::string& out);

} // namespace fjell::lab
