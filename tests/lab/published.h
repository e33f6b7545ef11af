// Numbers that others have published, for the same pictures as ours: what they are is said beside them.
//
// Failure: io::Failure with exit code 1, one line with the file and the series.
#pragma once

#include <string>
#include <vector>

namespace fjell::lab {

// A table of the thesis. Frame rates are those of whole frames, drawing included.
struct Published {
    std::string name, where;
    std::vector<double> thresholds_px, frames_a_second, vertices;
};
// In the order asked for.
[[nodiscard]] std::vector<Published> read_published(const std::string& file, const std::vector<std::string>& names);

} // namespace fjell::lab
