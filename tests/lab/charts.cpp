#include "lab/charts.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/json.h"
#include "lab/plot.h"

namespace fjell::lab {

namespace {

using nlohmann::json;

std::string svg_of(const json& plot) {
    if (plot.contains("groups")) {
        RowPlot rows{plot.at("title"), plot.at("x_label"), {}};
        for (const json& group : plot["groups"]) {
            rows.groups.push_back({group.at("heading"), {}});
            for (const json& row : group.at("rows"))
                rows.groups.back().rows.push_back({row.at("label"), row.at("value").get<double>()});
        }
        return plot_svg(rows);
    }
    LinePlot lines{plot.at("title"),
                   plot.at("x_label"),
                   plot.at("y_label"),
                   plot.value("x_names", std::vector<std::string>{}),
                   {}};
    for (const json& line : plot.at("lines"))
        lines.lines.push_back({line.at("label"), line.at("points").get<std::vector<std::pair<double, double>>>(),
                               line.value("dashed", false)});
    return plot_svg(lines);
}

} // namespace

std::map<std::string, std::string> read_charts(const std::string& file) {
    const json root = io::parse_json(io::read_text(file), file, io::JsonComments::no);
    std::map<std::string, std::string> pictures;
    std::string name = "plots";
    try {
        for (const json& plot : root.at("plots")) {
            name = plot.at("name");
            pictures[name] = svg_of(plot);
        }
    } catch (const json::exception& e) {
        throw io::Failure(1, fmt::format("{}: {}: {}; ./dev plots writes it anew", file, name, e.what()));
    }
    return pictures;
}

} // namespace fjell::lab
