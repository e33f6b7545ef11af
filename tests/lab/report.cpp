#include "lab/report.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "io/file.h"
#include "lab/plot.h"
#include "lab/rivals.h"

namespace fjell::lab {

namespace {

using nlohmann::json;

std::string text_of(const json& value) {
    return value.is_string() ? value.get<std::string>() : fmt::format("{}", value.get<double>());
}

std::string row(const std::vector<std::string>& cells, bool html, const char* tag) {
    std::string out = html ? "<tr>" : "|";
    for (const std::string& cell : cells)
        out += html ? fmt::format("<{0}>{1}</{0}>", tag, escaped(cell)) : fmt::format(" {} |", cell);
    return out + (html ? "</tr>\n" : "\n");
}

// A row a case; "-": the method has no such number. Cases that are not measured yet have no row.
std::string table(const Results& results, bool html) {
    const std::vector<std::string> fields = results.varying();
    std::vector<std::string> head, rule;
    for (const auto* keys : {&fields, &results.recipe.measures})
        for (const std::string& key : *keys) {
            head.emplace_back(heading_of(key));
            rule.emplace_back("---");
        }
    std::string out = (html ? "<table>\n" : "") + row(head, html, "th");
    if (!html) out += row(rule, false, "");
    for (const Result& r : results.all) {
        if (r.measured.empty()) continue;
        const json fields_of = r.c.json();
        std::vector<std::string> cells;
        for (const std::string& key : fields) {
            const bool none = r.c.way == Way::lean && (key == "tile_cells" || key == "order");
            cells.push_back(none ? "-" : text_of(fields_of.at(key)));
        }
        for (const std::string& key : results.recipe.measures)
            cells.push_back(r.measured.contains(key) ? text_of(r.measured[key]) : "-");
        out += row(cells, html, "td");
    }
    return out + (html ? "</table>\n" : "");
}

// A line for each combination of what varies but the plot's x; then what others have published.
std::vector<Line> lines_of(const Results& results, const Plot& plot) {
    std::vector<std::string> fields = results.varying();
    std::erase(fields, plot.x);
    std::vector<Line> lines;
    for (const Result& r : results.all) {
        const auto y = r.value(plot.y);
        if (!y) continue;
        const json fields_of = r.c.json();
        std::string label = fields_of.at("method").get<std::string>();
        for (const std::string& key : fields) {
            const bool none = r.c.way == Way::lean && (key == "tile_cells" || key == "order");
            if (none || key == "method" || (key == "offscreen_factor" && r.c.way != Way::incremental)) continue;
            const std::string value = text_of(fields_of.at(key));
            label += key == "tile_cells"         ? fmt::format(", tiles of {}", value)
                     : key == "offscreen_factor" ? fmt::format(", offscreen factor {}", value)
                     : key == "error_px"         ? fmt::format(", {} px", value)
                     : key == "texture_cells"    ? fmt::format(", {} cells a texel", value)
                                                 : ", " + value;
        }
        auto at = std::find_if(lines.begin(), lines.end(), [&](const Line& line) { return line.label == label; });
        if (at == lines.end()) at = lines.insert(lines.end(), Line{label, {}, false});
        at->points.emplace_back(fields_of.at(plot.x).get<double>(), *y);
    }
    const bool time = plot.y == "median_us", rate = plot.y == "frames_a_second";
    if (plot.x != "error_px" || (!time && !rate && plot.y != "vertices")) return lines;
    for (const Published& p : results.published) {
        Line line{"thesis: " + p.name + (time ? ", whole frames" : ""), {}, true};
        for (std::size_t i = 0; i < p.thresholds_px.size(); ++i)
            line.points.emplace_back(p.thresholds_px[i], time   ? 1e6 / p.frames_a_second[i]
                                                         : rate ? p.frames_a_second[i]
                                                                : p.vertices[i]);
        lines.push_back(line);
    }
    return lines;
}

std::string terrain_text(const Results& results) {
    const Recipe& r = results.recipe;
    const std::string over = r.site.file.empty() ? "a synthetic terrain" : "real heights, " + r.site.file;
    const bool straight = std::any_of(r.cells_a_frame.begin(), r.cells_a_frame.end(), [](double v) { return v > 0; });
    return fmt::format("Over {}; {} frames at most of 1280 x 960 pixels{}, along {}; {} of {} cases measured.", over,
                       r.frames, r.draws() ? ", drawn with half as many a side" : "",
                       straight ? "a straight line" : r.site.path, results.done(), results.all.size());
}

void write_text(const std::string& path, const std::string& text) {
    io::AtomicFile file(path);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
}

struct Pages {
    std::string markdown, html;
    void paragraph(const std::string& text) {
        markdown += text + "\n\n";
        html += "<p>" + escaped(text) + "</p>\n";
    }
    void heading(int depth, const std::string& text) {
        markdown += std::string(static_cast<std::size_t>(depth), '#') + " " + text + "\n\n";
        html += fmt::format("<h{0}>{1}</h{0}>\n", depth, escaped(text));
    }
};

// A row a method, and pictures of their meshes.
void add_rivals(Pages& pages, const Results& results, const std::string& folder) {
    pages.heading(3, "The rivals in one table: " + results.recipe.title);
    const auto rows = rivals_table(results);
    pages.html += "<table>\n";
    for (std::size_t i = 0; i < rows.size(); ++i) {
        pages.markdown += row(rows[i], false, "");
        if (i == 0) pages.markdown += row(std::vector<std::string>(rows[0].size(), "---"), false, "");
        pages.html += row(rows[i], true, i == 0 ? "th" : "td");
    }
    pages.markdown += "\n";
    pages.html += "</table>\n";
    std::set<std::string> shown;
    for (const Result& r : results.all) {
        const std::string name = picture_name(results.recipe, r.c), path = folder + "/" + name;
        if (!shown.insert(name).second || !std::filesystem::exists(path)) continue;
        pages.markdown += fmt::format("![Mesh of {}]({})\n\n", r.c.json().at("method").get<std::string>(), name);
        pages.html += io::read_text(path);
    }
}

void add_experiment(Pages& pages, const Results& results, const std::string& folder) {
    const Recipe& r = results.recipe;
    pages.heading(2, r.title);
    pages.paragraph(r.question);
    pages.paragraph(terrain_text(results));
    pages.paragraph("Found: " + conclusion_of(results));
    for (const Plot& plot : r.plots) {
        const std::vector<Line> lines = lines_of(results, plot);
        if (lines.empty()) continue; // nothing was measured
        const std::string svg = plot_svg(LinePlot{{}, heading_of(plot.x), heading_of(plot.y), {}, lines}),
                          name = fmt::format("{}-{}.svg", r.name, plot.y);
        write_text(folder + "/" + name, svg);
        pages.markdown += fmt::format("![{} over {}]({})\n\n", heading_of(plot.y), heading_of(plot.x), name);
        pages.html += svg;
    }
    for (const Published& p : results.published)
        pages.paragraph(
            fmt::format("{}: the thesis, {}. Another machine and another path; its times are those of whole "
                        "frames, drawing included.",
                        p.name, p.where));
    pages.markdown += table(results, false) + "\n";
    pages.html += table(results, true);
    if (r.conclusion == "rivals") add_rivals(pages, results, folder);
}

} // namespace

std::size_t Results::done() const {
    return static_cast<std::size_t>(
        std::count_if(all.begin(), all.end(), [](const Result& r) { return !r.measured.empty(); }));
}

std::vector<std::string> Results::varying() const {
    std::vector<std::string> found;
    for (const char* key : {"method", "tile_cells", "order", "estimate", "cells_a_frame", "offscreen_factor",
                            "texture_cells", "error_px"}) {
        std::set<json> values;
        for (const Result& r : all)
            if (r.c.way != Way::lean || (std::string(key) != "tile_cells" && std::string(key) != "order"))
                values.insert(r.c.json().at(key));
        if (values.size() > 1 || std::string(key) == "method") found.emplace_back(key);
    }
    return found;
}

Results results_of(const Recipe& recipe, const Store& store, std::vector<Published> published) {
    Results results{recipe, std::move(published), {}};
    for (const Case& c : cases_of(recipe)) results.all.push_back({c, store.find(c).value_or(json::object())});
    return results;
}

void write_report(const std::vector<Results>& experiments, const std::string& machine, const std::string& folder) {
    Pages pages;
    pages.html = "<!doctype html>\n<html lang='en'><meta charset='utf-8'><title>Fjell: experiments</title>\n"
                 "<style>body{font-family:sans-serif;max-width:70em;margin:2em auto;padding:0 1em}"
                 "table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:.2em .6em;text-align:right}"
                 "svg{max-width:100%;height:auto}</style>\n";
    pages.heading(1, "Experiments");
    pages.paragraph(
        "Written by ./dev experiments. Machine: " + machine +
        ". Times are what a thread works in an update, without drawing unless they are said to be whole frames', each "
        "flight flown once. Neighbours that take "
        "the core are not in them; what neighbours take of the caches is. Vertices, errors and pages are "
        "the same in every run.");
    for (const Results& each : experiments) add_experiment(pages, each, folder);
    write_text(folder + "/experiments.md", pages.markdown);
    write_text(folder + "/experiments.html", pages.html + "</html>\n");
}

} // namespace fjell::lab
