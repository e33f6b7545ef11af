// Pictures of measured numbers as SVG that stands by itself: lines over two axes, and rows of values.
//
// Values are on logarithmic axes. A line has its name at its end, not in a legend. Sizes are such that text can be read
// where the picture is 400 pixels wide. Complexity: O(points).
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace fjell::lab {

struct Line {
    std::string label;
    std::vector<std::pair<double, double>> points; // x, y; those that are not above 0 are left out
    bool dashed = false;                           // somebody else's numbers, or a limit
};
struct LinePlot {
    std::string title, x_label, y_label;
    std::vector<std::string> x_names; // of x = 1, 2, ..., at equal distances; empty: a logarithmic axis
    std::vector<Line> lines;
};
[[nodiscard]] std::string plot_svg(const LinePlot& plot);

struct Row {
    std::string label;
    double value = 0; // above 0
};
struct RowPlot {
    std::string title, x_label;
    struct Group {
        std::string heading;
        std::vector<Row> rows; // each value also as a multiple of the first
    };
    std::vector<Group> groups;
};
[[nodiscard]] std::string plot_svg(const RowPlot& plot);

// For text between tags and in attributes.
[[nodiscard]] std::string escaped(const std::string& text);

} // namespace fjell::lab
