// The plots of docs/plots.json, which ./dev plots measures: a picture for each, by its name.
//
// Failure: io::Failure with exit code 1, one line with the file and the plot at fault.
#pragma once

#include <map>
#include <string>

namespace fjell::lab {

[[nodiscard]] std::map<std::string, std::string> read_charts(const std::string& file);

} // namespace fjell::lab
