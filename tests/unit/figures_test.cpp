// The figures of the documents: the plots are drawn from docs/plots.json, and show its values.
#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "lab/charts.h"
#include "lab/plot.h"
#include "support/program.h"

namespace {

namespace fs = std::filesystem;
using fjell::test::slurp;
const fs::path repository = FJELL_SOURCE_DIR;

// All pairs of numbers that a pattern with two groups finds.
std::vector<std::pair<double, double>> numbers_in(const std::string& text, const char* pattern) {
    std::vector<std::pair<double, double>> found;
    const std::regex regex(pattern);
    for (std::sregex_iterator at(text.begin(), text.end(), regex), end; at != end; ++at)
        found.emplace_back(std::stod((*at)[1]), std::stod((*at)[2]));
    return found;
}

// What a place on a logarithmic axis means, by two of its ticks.
double value_at(double place, const std::pair<double, double>& a, const std::pair<double, double>& b) {
    const double part = (place - a.first) / (b.first - a.first);
    return std::exp(std::log(a.second) + part * (std::log(b.second) - std::log(a.second)));
}

} // namespace

TEST_CASE("the README's plots are those of docs/plots.json") {
    const auto charts = fjell::lab::read_charts((repository / "docs/plots.json").string());
    CHECK(charts.size() == 3);
    for (const auto& [name, svg] : charts) {
        INFO(name << ": ./dev plots draws it");
        CHECK(slurp(repository / "docs/pictures" / (name + ".svg")) == svg);
    }
}

TEST_CASE("a plot's points lie where its axes say, and its lines' names are beside their ends, apart from each other") {
    const std::vector<std::pair<double, double>> points{{0.06, 31}, {0.5, 800}, {10, 12'000}};
    const std::string svg = fjell::lab::plot_svg(fjell::lab::LinePlot{
        "Times & places", "speed", "us", {}, {{"one", points}, {"two", {{1, 11'900}, {10, 11'900}}}}});
    const auto x_ticks = numbers_in(svg, "<text x='([0-9.]+)' y='[0-9.]+' text-anchor='middle'>([0-9.]+)<"),
               y_ticks = numbers_in(std::regex_replace(svg, std::regex(",(?=[0-9]{3})"), ""),
                                    "y='([0-9.]+)' text-anchor='end'>([0-9.]+)<"),
               dots = numbers_in(svg, "<circle cx='([0-9.]+)' cy='([0-9.]+)'"),
               names = numbers_in(svg, "<text x='([0-9.]+)' y='([0-9.]+)' text-anchor='start' fill");
    REQUIRE(x_ticks.size() >= 2);
    REQUIRE(y_ticks.size() >= 2);
    REQUIRE(dots.size() == 5);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CHECK(value_at(dots[i].first, x_ticks.front(), x_ticks.back()) == Approx(points[i].first).epsilon(0.01));
        const double baseline_px = 5.04; // text stands so much below the line that it names
        CHECK(value_at(dots[i].second + baseline_px, y_ticks.front(), y_ticks.back()) ==
              Approx(points[i].second).epsilon(0.02));
    }
    REQUIRE(names.size() == 2);
    CHECK(std::abs(names[0].second - names[1].second) >= 17);
    CHECK(names[0].first > dots[2].first);
    CHECK(svg.find("Times &amp; places") != std::string::npos);
    for (const auto& row : {"33,000 (3.3 times)", ">10,000<"})
        CHECK(fjell::lab::plot_svg(fjell::lab::RowPlot{"", "n", {{"of", {{"a", 10'000}, {"b", 33'000}}}}}).find(row) !=
              std::string::npos);
}
