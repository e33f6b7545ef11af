// The report of all experiments: Markdown with pictures beside it, and one HTML file that needs nothing else.
#pragma once

#include <string>
#include <vector>

#include "lab/results.h"

namespace fjell::lab {

// Writes experiments.md, experiments.html and a picture in SVG for each plot. machine: a line about it. Throws
// io::Failure, 3 when the disk fails.
void write_report(const std::vector<Results>& experiments, const std::string& machine, const std::string& folder);

} // namespace fjell::lab
