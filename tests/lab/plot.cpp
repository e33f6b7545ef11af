#include "lab/plot.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include <fmt/format.h>

namespace fjell::lab {

namespace {

constexpr double font_px = 14, least_width = 520, plot_width = 300, line_height = 18, margin = 10;
constexpr double letter_px = 0.58 * font_px; // the mean of a wide sans serif
// Colours of equal weight, told apart by those who do not see all of them too, then repeated.
constexpr const char* colours[] = {"#00508a", "#3b93d3", "#d55e00", "#009e73", "#b0568e",
                                   "#b77d00", "#7a5195", "#444444", "#9a6324", "#808000"};

double text_width(const std::string& text) {
    const auto letters = std::count_if(text.begin(), text.end(), [](unsigned char c) { return (c & 0xC0) != 0x80; });
    return letter_px * static_cast<double>(letters);
}

std::string number_text(double v) { // 1,000 or 0.06
    std::string text = fmt::format("{:.4g}", v);
    if (v < 1000) return text;
    text = fmt::format("{:.0f}", v);
    for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, ",");
    return text;
}

struct Axis {
    double low = std::numeric_limits<double>::max(), high = 0, from = 0, to = 0; // from, to: where on the picture
    bool logarithmic = true;

    void take(double v) {
        low = std::min(low, v);
        high = std::max(high, v);
    }
    [[nodiscard]] double at(double v) const {
        if (!(high > low)) return (from + to) / 2;
        const double part = logarithmic ? std::log(v / low) / std::log(high / low) : (v - low) / (high - low);
        return from + (to - from) * part;
    }
    // Powers of ten; where those are few, 2 and 5 times each too, or still more.
    [[nodiscard]] std::vector<double> ticks() const {
        for (const auto& digits : {std::vector<double>{1}, {1, 2, 5}})
            if (auto found = ticks(digits); found.size() >= 3) return found;
        return ticks({1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9});
    }

private:
    [[nodiscard]] std::vector<double> ticks(const std::vector<double>& digits) const {
        std::vector<double> found;
        for (double power = std::pow(10, std::floor(std::log10(low))); power <= high * 1.001; power *= 10)
            for (const double digit : digits)
                if (digit * power >= low * 0.999 && digit * power <= high * 1.001) found.push_back(digit * power);
        return found;
    }
};

class Picture {
public:
    Picture(double width, double height, const std::string& title)
        : text_(fmt::format("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' "
                            "height='{1:.0f}' font-family='sans-serif' font-size='{2:g}' fill='#222'>\n"
                            "<rect width='100%' height='100%' fill='white'/>\n",
                            width, height, font_px)) {
        if (!title.empty()) text(margin, 20, "start", title, " font-weight='bold'");
    }
    void text(double x, double y, const char* anchor, const std::string& what, const std::string& style = {}) {
        text_ += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='{}'{}>{}</text>\n", x, y, anchor, style,
                             escaped(what));
    }
    void line(double x1, double y1, double x2, double y2, const std::string& style) {
        text_ += fmt::format("<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' {}/>\n", x1, y1, x2, y2, style);
    }
    void dot(double x, double y, const char* colour) {
        text_ += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='{}'/>\n", x, y, colour);
    }
    void polyline(const std::string& points, const std::string& style) {
        text_ += fmt::format("<polyline points='{}' fill='none' {}/>\n", points, style);
    }
    void frame(double left, double top, double right, double bottom) {
        text_ += fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' fill='none' stroke='#444'/>\n",
                             left, top, right - left, bottom - top);
    }
    [[nodiscard]] std::string done() const { return text_ + "</svg>\n"; }

private:
    std::string text_;
};

constexpr const char* grid = "stroke='#ddd'";

// The names of lines beside their ends, in the order of these, and far enough from each other.
std::vector<double> label_places(const std::vector<double>& ends, double top, double bottom) {
    std::vector<std::size_t> order(ends.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return ends[a] < ends[b]; });
    std::vector<double> places(ends.size());
    double least = top;
    for (const std::size_t i : order) {
        places[i] = std::max(ends[i], least);
        least = places[i] + line_height;
    }
    double most = bottom;
    for (auto i = order.rbegin(); i != order.rend(); ++i) {
        places[*i] = std::min(places[*i], most);
        most = places[*i] - line_height;
    }
    return places;
}

void draw_lines(Picture& picture, const LinePlot& plot, const Axis& x, const Axis& y, double right) {
    std::vector<double> ends_x, ends; // of each line, where it is farthest to the right
    for (const Line& line : plot.lines) {
        ends_x.push_back(x.from);
        ends.push_back((y.from + y.to) / 2);
        for (const auto& [px, py] : line.points)
            if (px > 0 && py > 0 && x.at(px) >= ends_x.back()) ends_x.back() = x.at(px), ends.back() = y.at(py);
    }
    const std::vector<double> places = label_places(ends, y.to, y.from);
    for (std::size_t i = 0; i < plot.lines.size(); ++i) {
        const Line& line = plot.lines[i];
        const char* const colour = line.dashed ? "#555" : colours[i % std::size(colours)];
        // Dotted where the colours come again.
        const char* const dash = line.dashed               ? " stroke-dasharray='6 4'"
                                 : i >= std::size(colours) ? " stroke-dasharray='2 3'"
                                                           : "";
        std::string points;
        for (const auto& [px, py] : line.points)
            if (px > 0 && py > 0) points += fmt::format("{:.1f},{:.1f} ", x.at(px), y.at(py));
        picture.polyline(points, fmt::format("stroke='{}' stroke-width='2'{}", colour, dash));
        if (!line.dashed)
            for (const auto& [px, py] : line.points)
                if (px > 0 && py > 0) picture.dot(x.at(px), y.at(py), colour);
        picture.line(ends_x[i] + 4, ends[i], right + 10, places[i],
                     fmt::format("stroke='{}' stroke-width='0.7'", colour));
        picture.text(right + 14, places[i] + font_px * 0.36, "start", line.label, fmt::format(" fill='{}'", colour));
    }
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

std::string plot_svg(const LinePlot& plot) {
    Axis x, y;
    x.logarithmic = plot.x_names.empty();
    double longest = 0, widest = 0;
    for (const Line& line : plot.lines) {
        longest = std::max(longest, text_width(line.label));
        for (const auto& [px, py] : line.points) {
            if (px <= 0 || py <= 0) continue;
            x.take(px);
            y.take(py);
        }
    }
    const bool any = y.high > 0; // otherwise nothing is measured yet
    if (any)
        for (const double v : y.ticks()) widest = std::max(widest, text_width(number_text(v)));
    const double left = margin + widest + 6, top = plot.title.empty() ? 30 : 54;
    const double width = std::max(least_width, left + plot_width + longest + 24), right = width - longest - 24;
    const double bottom = top + std::max(240.0, line_height * static_cast<double>(plot.lines.size()) + 2 * margin);
    Picture picture(width, bottom + 50, plot.title);
    picture.text(margin, top - 10, "start", plot.y_label);
    picture.text((left + right) / 2, bottom + 42, "middle", plot.x_label);
    if (any) {
        x.from = left + margin, x.to = right - margin;
        y.from = bottom - margin, y.to = top + margin;
        for (const double v : y.ticks()) {
            picture.line(left, y.at(v), right, y.at(v), grid);
            picture.text(left - 6, y.at(v) + font_px * 0.36, "end", number_text(v));
        }
        const auto tick_x = [&](double v, const std::string& name) {
            picture.line(x.at(v), top, x.at(v), bottom, grid);
            picture.text(x.at(v), bottom + 20, "middle", name);
        };
        if (x.logarithmic)
            for (const double v : x.ticks()) tick_x(v, number_text(v));
        for (std::size_t i = 0; i < plot.x_names.size(); ++i) tick_x(static_cast<double>(i + 1), plot.x_names[i]);
        draw_lines(picture, plot, x, y, right);
    }
    picture.frame(left, top, right, bottom);
    return picture.done();
}

std::string plot_svg(const RowPlot& plot) {
    Axis x;
    double longest = 0, rows = 0;
    for (const RowPlot::Group& group : plot.groups) {
        rows += 1 + static_cast<double>(group.rows.size());
        for (const Row& row : group.rows) {
            x.take(row.value);
            longest = std::max(longest, text_width(row.label));
        }
    }
    constexpr double row_height = 24, values_width = 24 * letter_px;
    const double left = margin + longest + 8, top = plot.title.empty() ? margin : 34, bottom = top + rows * row_height;
    const double width = std::max(least_width, left + plot_width / 2 + values_width), right = width - margin;
    Picture picture(width, bottom + 50, plot.title);
    x.low = std::pow(10, std::floor(std::log10(x.low))); // dots are as far from the left as values say
    x.from = left, x.to = right - values_width;
    for (const double v : x.ticks()) picture.text(x.at(v), bottom + 20, "middle", number_text(v));
    picture.text((x.from + x.to) / 2, bottom + 42, "middle", plot.x_label);
    double y = top;
    for (const RowPlot::Group& group : plot.groups) {
        y += row_height;
        picture.text(margin, y - 7, "start", group.heading, " font-weight='bold'");
        const double end = y + row_height * static_cast<double>(group.rows.size());
        for (const double v : x.ticks()) picture.line(x.at(v), y, x.at(v), end, grid);
        picture.line(x.from, y, x.from, end, "stroke='#444'");
        std::size_t number = 0;
        for (const Row& row : group.rows) {
            y += row_height;
            const char* const colour = colours[number == 0 ? 0 : 1 + number % (std::size(colours) - 1)];
            ++number;
            const double middle = y - row_height / 2, at = x.at(row.value), times = row.value / group.rows[0].value;
            picture.text(left - 8, middle + font_px * 0.36, "end", row.label);
            picture.line(x.from, middle, at, middle, fmt::format("stroke='{}' stroke-width='2'", colour));
            picture.dot(at, middle, colour);
            picture.text(at + 10, middle + font_px * 0.36, "start",
                         times > 1.05 ? fmt::format("{} ({:.1f} times)", number_text(row.value), times)
                                      : number_text(row.value));
        }
    }
    return picture.done();
}

} // namespace fjell::lab
