// One rival measured on its own flight, and its picture; and the table that has all of them in a row each.
//
// Every method flies the recipe's straight line `repetitions` times, in turns with the leanest recursion, so that what
// neighbours do to the machine they do to both. Quality is measured at the first speed alone: it needs hundreds of
// meshes, looked at from outside (rivals/look.h). Thread: one. Failure: io::Failure, 1 for a terrain that rivals do not
// take, 130 when interrupted.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "lab/results.h"
#include "lab/world.h"

namespace fjell::lab {

// Until its mesh stands.
void settle(rivals::Rival& rival, const View& view, double error_px);
// picture: a file; empty: none wanted.
[[nodiscard]] nlohmann::json measure_rival(const Recipe& recipe, const Case& c, World& world,
                                           const std::string& picture);
// Heading and rows: quality, then medians over all speeds; "-": not measured.
[[nodiscard]] std::vector<std::vector<std::string>> rivals_table(const Results& results);

} // namespace fjell::lab
