// The figures of the documents: those of docs/figures.toml are the same wherever they are named; the plots are drawn
// from docs/plots.json, show its values, and measured.md has them in a table.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <toml++/toml.h>

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

// A file as a reader reads it: comments of several lines, literals and paragraphs in one line.
std::string flowing(const fs::path& file) {
    std::string text = slurp(file);
    for (const auto& [from, to] : {std::pair{"\"\\s*\n\\s*\"", ""}, {"\n[ \t]*(?://|#) ?", " "}, {"\\s+", " "}})
        text = std::regex_replace(text, std::regex(from), to);
    return text;
}

// What users read, by the path from the root.
const std::map<std::string, std::string>& read_by_users() {
    static const std::map<std::string, std::string> all = [] {
        std::map<std::string, std::string> found;
        const auto take = [&](const fs::path& file) {
            const std::string end = file.extension().string();
            if (end == ".md" || end == ".h" || end == ".cpp" || (end == ".toml" && file.stem() != "figures"))
                found[fs::relative(file, repository).string()] = flowing(file);
        };
        take(repository / "README.md");
        for (const char* folder :
             {"docs", "profiles", "content", "runtime/include", "runtime/profile", "editor/panels"})
            for (const auto& entry : fs::recursive_directory_iterator(repository / folder)) take(entry.path());
        return found;
    }();
    return all;
}

} // namespace

TEST_CASE("a figure that several documents and comments name is that of docs/figures.toml in all of them") {
    const toml::table table = toml::parse_file((repository / "docs/figures.toml").string());
    std::size_t checked = 0;
    for (const toml::node& node : *table["figure"].as_array()) {
        const toml::table& figure = *node.as_table();
        const auto text = [&](const char* key) { return figure[key].value<std::string>().value(); };
        const std::string about = text("about"), value = text("value");
        CHECK_FALSE(text("command").empty());
        const std::regex pattern(text("pattern"));
        std::map<std::string, int> says;
        for (const auto& [file, words] : read_by_users())
            for (std::sregex_iterator at(words.begin(), words.end(), pattern), end; at != end; ++at, ++checked) {
                INFO(file << ": " << about << ": docs/figures.toml has " << value);
                CHECK((*at)[1].str() == value);
                ++says[file];
            }
        for (const toml::node& place : *figure["places"].as_array()) {
            INFO(about << ": " << text("pattern") << " is not found in this place; mend the pattern or the place");
            CHECK(says.count(place.value<std::string>().value()) == 1);
        }
    }
    CHECK(checked > 20);
}

TEST_CASE("measured.md has the plots' values in its tables, and as many terrains are drawn as credited") {
    const std::string page = slurp(repository / "docs/measured.md"), gallery = slurp(repository / "docs/gallery.md");
    const auto plots = nlohmann::json::parse(slurp(repository / "docs/plots.json"));
    CHECK(page.find(", on " + plots["measured"]["date"].get<std::string>()) != std::string::npos);
    const auto has = [&](double value) {
        std::ostringstream text;
        text << std::setprecision(10) << value;
        std::string digits = text.str();
        if (value >= 1000)
            for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
        INFO(digits << ": ./dev plots writes it");
        CHECK(page.find("| " + digits + " |") != std::string::npos);
    };
    for (const auto& plot : plots["plots"]) {
        for (const auto& line : plot.value("lines", nlohmann::json::array()))
            for (const auto& point : line["points"]) has(point[1]);
        for (const auto& group : plot.value("groups", nlohmann::json::array()))
            for (const auto& row : group["rows"]) has(row["value"]);
    }
    const std::string credits = gallery.substr(gallery.find("## Where the data come from"));
    const auto terrains = std::count(credits.begin(), credits.end(), '\n') - 2; // a line each, below the heading
    CHECK(terrains == 7);
    CHECK(gallery.find("The seven\nterrains") != std::string::npos);
}

TEST_CASE("the README's plots and times are those of docs/plots.json") {
    const auto charts = fjell::lab::read_charts((repository / "docs/plots.json").string());
    CHECK(charts.size() == 4);
    const auto plots = nlohmann::json::parse(slurp(repository / "docs/plots.json"));
    const auto ms = [&](const std::string& method) { // at a quarter of a cell a frame
        for (const auto& line : plots["plots"][0]["lines"])
            if (line["label"] == method)
                for (const auto& point : line["points"])
                    if (point[0] == 0.25) return point[1].get<double>() / 1000;
        return 0.0;
    };
    const auto told = numbers_in(slurp(repository / "README.md"), "takes ([0-9.]+) ms of one core; .* ([0-9.]+) ms");
    REQUIRE(told.size() == 1);
    CHECK(std::abs(told[0].first - ms("Fjell, all around")) < 0.006); // two decimals
    CHECK(std::abs(told[0].second - ms("recursion")) < 0.006);
    for (const auto& [name, svg] : charts) {
        INFO(name << ": ./dev plots draws it");
        CHECK(slurp(repository / "docs/pictures" / (name + ".svg")) == svg);
    }
}

TEST_CASE("a plot's points lie where its axes say, and its lines' names are beside their ends, apart from each other") {
    const std::vector<std::pair<double, double>> points{{0.06, 31}, {0.5, 800}, {10, 12'000}};
    const std::string svg = fjell::lab::plot_svg(fjell::lab::LinePlot{
        "Times & places", "speed", "us", {}, {{"one", points}, {"two", {{10, 11'900}, {1, 11'900}}}}});
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
    for (const auto& leader : numbers_in(svg, "<line x1='([0-9.]+)' y1='([0-9.]+)'[^>]* stroke-width='0.7'"))
        CHECK(leader.first == Approx(dots[2].first + 4)); // from the right end, whichever way a line runs
    CHECK(svg.find("Times &amp; places") != std::string::npos);
    for (const auto& row : {"33,000 (3.3 times)", ">10,000<"})
        CHECK(fjell::lab::plot_svg(fjell::lab::RowPlot{"", "n", {{"of", {{"a", 10'000}, {"b", 33'000}}}}}).find(row) !=
              std::string::npos);
}
