// A picture of lines over two logarithmic axes, as SVG that stands by itself. Complexity: O(points).
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace fjell::lab {

struct Line {
    std::string label;
    std::vector<std::pair<double, double>> points; // x, y; those that are not above 0 are left out
    bool dashed = false;                           // somebody else's numbers
};

[[nodiscard]] std::string plot_svg(const std::string& x_label, const std::string& y_label,
                                   const std::vector<Line>& lines);
// For text between tags and in attributes.
[[nodiscard]] std::string escaped(const std::string& text);

} // namespace fjell::lab
