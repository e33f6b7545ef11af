#include "lab/plot.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include <fmt/format.h>

namespace fjell::lab {

namespace {

constexpr double width = 960, left = 80, right = 600, top = 20, bottom = 360, line_height = 17;
// Colours of equal weight, told apart by those who do not see all of them too, then repeated.
constexpr const char* colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00",
                                   "#56b4e9", "#7a5195", "#444444", "#9a6324", "#808000"};

struct Axis {
    double low = std::numeric_limits<double>::max(), high = 0, from = 0, to = 0; // from, to: where on the picture

    void take(double v) {
        low = std::min(low, v);
        high = std::max(high, v);
    }
    [[nodiscard]] double at(double v) const {
        const double span = std::log(high / low);
        return span > 0 ? from + (to - from) * std::log(v / low) / span : (from + to) / 2;
    }
    // 1, 2 and 5 of every power of ten, as far as they lie within; where those are few, more.
    [[nodiscard]] std::vector<double> ticks() const {
        const std::vector<double> few = ticks({1, 2, 5});
        return few.size() >= 4 ? few : ticks({1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9});
    }

private:
    [[nodiscard]] std::vector<double> ticks(std::initializer_list<double> digits) const {
        std::vector<double> found;
        for (double power = std::pow(10, std::floor(std::log10(low))); power <= high * 1.001; power *= 10)
            for (const double digit : digits)
                if (digit * power >= low * 0.999 && digit * power <= high * 1.001) found.push_back(digit * power);
        return found;
    }
};

void draw_axes(std::string& svg, const Axis& x, const Axis& y, const std::string& x_label, const std::string& y_label) {
    for (const double v : x.ticks())
        svg += fmt::format("<line x1='{0:.1f}' y1='{1}' x2='{0:.1f}' y2='{2}' stroke='#ddd'/>"
                           "<text x='{0:.1f}' y='{3}' text-anchor='middle'>{4:.4g}</text>\n",
                           x.at(v), top, bottom, bottom + 18, v);
    for (const double v : y.ticks())
        svg += fmt::format("<line x1='{1}' y1='{0:.1f}' x2='{2}' y2='{0:.1f}' stroke='#ddd'/>"
                           "<text x='{3}' y='{4:.1f}' text-anchor='end'>{5:.12g}</text>\n",
                           y.at(v), left, right, left - 6, y.at(v) + 4, v);
    svg += fmt::format("<text x='{}' y='{}' text-anchor='middle'>{}</text>\n", (left + right) / 2, bottom + 38,
                       escaped(x_label));
    svg += fmt::format("<text transform='translate(16,{}) rotate(-90)' text-anchor='middle'>{}</text>\n",
                       (top + bottom) / 2, escaped(y_label));
}

void draw_line(std::string& svg, const Axis& x, const Axis& y, const Line& line, std::size_t number) {
    const char* const colour = colours[number % std::size(colours)];
    // Dotted where the colours come again.
    const char* const dash = line.dashed                    ? " stroke-dasharray='6 4'"
                             : number >= std::size(colours) ? " stroke-dasharray='2 3'"
                                                            : "";
    std::string points;
    for (const auto& [px, py] : line.points)
        if (px > 0 && py > 0) points += fmt::format("{:.1f},{:.1f} ", x.at(px), y.at(py));
    svg += fmt::format("<polyline points='{}' fill='none' stroke='{}' stroke-width='2'{}/>\n", points, colour, dash);
    for (const auto& [px, py] : line.points)
        if (px > 0 && py > 0)
            svg += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='2.5' fill='{}'/>", x.at(px), y.at(py), colour);
    const double at = top + 10 + line_height * static_cast<double>(number);
    svg += fmt::format("\n<line x1='{0}' y1='{1:.1f}' x2='{2}' y2='{1:.1f}' stroke='{3}' stroke-width='2'{4}/>"
                       "<text x='{5}' y='{6:.1f}'>{7}</text>\n",
                       right + 15, at, right + 45, colour, dash, right + 52, at + 4, escaped(line.label));
}

} // namespace

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) switch (c) {
        case '&': out += "&amp;"; break;
        case '<': out += "&lt;"; break;
        case '>': out += "&gt;"; break;
        case '"': out += "&quot;"; break;
        case '\'': out += "&#39;"; break;
        default: out += c;
        }
    return out;
}

std::string plot_svg(const std::string& x_label, const std::string& y_label, const std::vector<Line>& lines) {
    Axis x, y;
    for (const Line& line : lines)
        for (const auto& [px, py] : line.points) {
            if (px <= 0 || py <= 0) continue;
            x.take(px);
            y.take(py);
        }
    const double height = std::max(bottom + 50, top + 20 + line_height * static_cast<double>(lines.size()));
    std::string svg = fmt::format("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}' width='{0}' "
                                  "height='{1}' font-family='sans-serif' font-size='12'>\n"
                                  "<rect width='100%' height='100%' fill='white'/>\n",
                                  width, height);
    if (x.high > 0) { // otherwise nothing is measured yet
        x.from = left + 10, x.to = right - 10;
        y.from = bottom - 10, y.to = top + 10;
        draw_axes(svg, x, y, x_label, y_label);
        for (std::size_t i = 0; i < lines.size(); ++i) draw_line(svg, x, y, lines[i], i);
    }
    svg += fmt::format("<rect x='{}' y='{}' width='{}' height='{}' fill='none' stroke='#444'/>\n</svg>\n", left, top,
                       right - left, bottom - top);
    return svg;
}

} // namespace fjell::lab
