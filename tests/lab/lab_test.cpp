// The lab (fjell-lab, ./dev experiments) in its quick form: what its report says is what its files say, read here
// independently; what was measured before an interruption is not measured again.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "lab/pages.h"
#include "support/program.h"
#include "support/temporary_folder.h"

namespace {

using namespace fjell;
using fjell::test::run_in;
using fjell::test::slurp;
using fjell::test::spit;
using fjell::test::TemporaryFolder;
using nlohmann::json;

namespace fs = std::filesystem;
const std::string lab_program = FJELL_BIN_DIR "/fjell-lab --quick ";
const fs::path recipes = FJELL_SOURCE_DIR "/content/experiments";

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

std::vector<std::string> cells_of(const std::string& row) {
    std::vector<std::string> cells;
    std::istringstream in(row.substr(1));
    for (std::string cell; std::getline(in, cell, '|');) cells.push_back(cell.substr(1, cell.size() - 2));
    return cells;
}

std::vector<json> stored(const fs::path& file) {
    std::vector<json> all;
    for (const std::string& line : lines_of(slurp(file))) all.push_back(json::parse(line));
    return all;
}

std::vector<fs::path> recipe_files() {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(recipes))
        if (entry.path().extension() == ".json") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

// One run for all cases: stopped after five, left with half a line as by a kill, and run again.
struct LabRun {
    TemporaryFolder folder;
    std::string before, after, first_out, second_out, second_err;
    LabRun() {
        const std::string command = lab_program + "--out out";
        const auto first = run_in(folder.path, command + " --cases 5");
        INFO(first.err);
        REQUIRE(first.code == 0);
        first_out = first.out;
        const fs::path file = folder.path / "out/1-tilings.jsonl";
        before = slurp(file);
        spit(file, before + R"({"case": {"error_px": 4}, "key)");
        const auto second = run_in(folder.path, command);
        INFO(second.err);
        REQUIRE(second.code == 0);
        second_out = second.out;
        second_err = second.err;
        after = slurp(file);
    }
    [[nodiscard]] fs::path out() const { return folder.path / "out"; }
};
const LabRun& lab_run() {
    static const LabRun run;
    return run;
}

// The tables of the report, by title.
std::map<std::string, std::vector<std::vector<std::string>>> tables(const std::string& markdown) {
    std::map<std::string, std::vector<std::vector<std::string>>> found;
    std::string title;
    for (const std::string& line : lines_of(markdown)) {
        if (line.starts_with("## ")) title = line.substr(3);
        if (line.starts_with("### ")) title = line; // a table besides that of all cases
        if (line.starts_with("| ") && !line.starts_with("| ---")) found[title].push_back(cells_of(line));
    }
    return found;
}

// One line that names the program, the file and what is wrong.
void refused_recipe(const std::string& change, const json& to, const std::string& says) {
    const TemporaryFolder folder;
    json recipe = json::parse(slurp(recipes / "1-tilings.json"));
    recipe[json::json_pointer(change)] = to;
    spit(folder.path / "bad.json", recipe.dump());
    const auto r = run_in(folder.path, lab_program + "--recipes . --out out");
    CAPTURE(change, r.err);
    CHECK(r.code == 1);
    CHECK(r.err.starts_with("fjell-lab: ./bad.json: "));
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    CHECK(r.err.find(says) != std::string::npos);
    CHECK_FALSE(fs::exists(folder.path / "out"));
}

} // namespace

TEST_CASE("an interrupted run of experiments goes on where it was, and a third measures nothing") {
    const LabRun& run = lab_run();
    CHECK(lines_of(run.before).size() == 5);
    CHECK(run.first_out.find("1-tilings: 5 cases measured now, 5 of 21 in all") != std::string::npos);
    CHECK(run.second_out.find("1-tilings: 16 cases measured now, 21 of 21 in all") != std::string::npos);
    CHECK(run.after.starts_with(run.before)); // times too: they would differ
    CHECK(stored(run.out() / "1-tilings.jsonl").size() == 21);
    const auto third = run_in(run.folder.path, lab_program + "--out out");
    CHECK(third.code == 0);
    CHECK(third.err.empty()); // nothing is estimated, and nothing said to be under way
    for (const std::string& line : lines_of(third.out))
        if (line.find("cases measured") != std::string::npos)
            CHECK(line.find(": 0 cases measured now") != std::string::npos);
    CHECK(slurp(run.out() / "1-tilings.jsonl") == run.after);
}

TEST_CASE("the report of the experiments has every number of its files, and no other") {
    const LabRun& run = lab_run();
    const std::string markdown = slurp(run.out() / "experiments.md"), html = slurp(run.out() / "experiments.html");
    const auto found = tables(markdown);
    std::size_t expected = 0, pictures = 0;
    bool counted = true;
    for (const fs::path& file : recipe_files()) {
        const json recipe = json::parse(slurp(file));
        const std::string title = recipe.at("title"), name = file.stem().string();
        CAPTURE(name);
        REQUIRE(found.contains(title));
        expected += recipe.at("conclusion") == "rivals" ? 2 : 1; // and that of a row each
        CHECK(html.find(title) != std::string::npos);
        const auto& table = found.at(title);
        const std::vector<json> lines = stored(run.out() / (name + ".jsonl"));
        REQUIRE(table.size() == lines.size() + 1);
        const std::size_t measures = recipe.at("measures").size(), fields = table[0].size() - measures;
        for (std::size_t i = 0; i < lines.size(); ++i) {
            const json &c = lines[i].at("case"), &measured = lines[i].at("measured");
            const std::vector<std::string>& row = table[i + 1];
            REQUIRE(row.size() == table[0].size());
            CHECK(row[0] == c.at("method").get<std::string>());
            for (std::size_t m = 0; m < measures; ++m) {
                const std::string key = recipe["measures"][m], cell = row[fields + m];
                CAPTURE(key, cell);
                CHECK((cell == "-") == !measured.contains(key));
                if (cell != "-") CHECK(std::stod(cell) == measured[key].get<double>());
                CHECK((cell == "-" || html.find("<td>" + cell + "</td>") != std::string::npos));
            }
        }
        for (const json& plot : recipe.at("plots")) {
            const std::string y = plot.at("y");
            const bool drawn = std::any_of(lines.begin(), lines.end(),
                                           [&](const json& line) { return line.at("measured").contains(y); });
            if (!drawn) { // instructions, where nothing counts them
                CHECK(y == "instructions");
                counted = false;
                continue;
            }
            const std::string picture = name + "-" + y + ".svg";
            CHECK(markdown.find("](" + picture + ")") != std::string::npos);
            const std::string svg = slurp(run.out() / picture);
            CHECK(svg.find("<polyline") != std::string::npos);
            CHECK(html.find(svg) != std::string::npos);
            ++pictures;
        }
    }
    CHECK(found.size() == expected);
    for (const auto& entry : fs::directory_iterator(run.out())) { // meshes of rivals
        if (entry.path().filename().string().find("-mesh-") == std::string::npos) continue;
        CHECK(markdown.find("](" + entry.path().filename().string() + ")") != std::string::npos);
        CHECK(html.find(slurp(entry.path())) != std::string::npos);
        pictures += 2; // one within the other
    }
    for (std::size_t at = 0; (at = html.find("<svg", at)) != std::string::npos; ++at) --pictures;
    CHECK(pictures == 0);
    CHECK((markdown.find("Too few cases") == std::string::npos || !counted));
    CHECK(html.find("src=") == std::string::npos); // it needs nothing else
    CHECK(html.find("href=") == std::string::npos);
}

TEST_CASE("a lower threshold takes more vertices, and what is measured keeps to it where errors are true") {
    int steps = 0, kept = 0, exceeded = 0;
    for (const fs::path& file : recipe_files()) {
        std::map<json, std::map<double, double>> vertices; // by everything but the threshold
        for (const json& line : stored(lab_run().out() / (file.stem().string() + ".jsonl"))) {
            json c = line.at("case");
            const double error_px = c.at("error_px");
            if (line.at("measured").contains("true_error_px")) {
                const bool within = line["measured"]["true_error_px"].get<double>() <= error_px;
                const std::set<std::string> unbounded{"blocks", "cdlod-doubling", "progressive-mesh", "skirted-tiles"};
                if (c.at("estimate") == "true" && !unbounded.contains(c.at("method"))) CHECK(within);
                (within ? kept : exceeded) += 1;
            }
            if (!line.at("measured").contains("vertices")) continue; // rivals have one threshold
            c.erase("error_px");
            vertices[c][error_px] = line.at("measured").at("vertices");
        }
        for (const auto& [c, by_threshold] : vertices) {
            double more = 1e300;
            for (const auto& [error_px, count] : by_threshold) {
                CAPTURE(file, c.dump(), error_px);
                CHECK(count <= more);
                steps += more < 1e300;
                more = count;
            }
        }
    }
    CHECK(steps >= 20);
    CHECK(kept >= 9);
    CHECK(exceeded >= 1); // mid-point errors bound nothing: that is what is shown
}

TEST_CASE("the conclusions of the experiments are those of their numbers") {
    std::map<std::string, double> times; // of recursion, by threshold and tile
    std::map<std::string, double> lean;
    double least = 1e300, largest = 0;
    const std::vector<json> lines = stored(lab_run().out() / "1-tilings.jsonl");
    for (const json& line : lines)
        if (line["case"]["method"] == "lean") lean[line["case"]["error_px"].dump()] = line["measured"]["median_us"];
    for (const json& line : lines) {
        if (line["case"]["method"] != "recursive") continue;
        const double ratio = lean.at(line["case"]["error_px"].dump()) / line["measured"]["median_us"].get<double>();
        least = std::min(least, ratio);
        largest = std::max(largest, ratio);
    }
    char text[200];
    std::snprintf(text, sizeof text, "The leanest recursion takes %.2f to %.2f times the recursive method's", least,
                  largest);
    INFO(text);
    CHECK(slurp(lab_run().out() / "experiments.md").find(text) != std::string::npos);
}

// A quick run knows two thresholds that any mesh is far from, and one at which it is the finest mesh.
TEST_CASE("pictures come nearer to the finest mesh's as thresholds fall, and are equal where meshes are") {
    const std::string name = GENERATE("8-drawing", "8-drawing-norway");
    std::map<json, std::map<double, json>> drawn; // by everything but the threshold
    std::map<json, std::set<json>> of_method;     // pictures' differences, by everything but the method
    for (const json& line : stored(lab_run().out() / (name + ".jsonl"))) {
        json c = line.at("case");
        const double error_px = c.at("error_px");
        const json& measured = line.at("measured");
        if (!measured.contains("image_difference")) {
            WARN("no OpenGL here: nothing was drawn");
            return;
        }
        CHECK(measured.at("frame_ms").get<double>() > 0);
        CHECK(std::abs(measured["frames_a_second"].get<double>() * measured["frame_ms"].get<double>() - 1000) < 0.1);
        CHECK(measured.at("finest_px") == 0.01);
        json same = c;
        same.erase("method");
        of_method[same].insert(measured["image_difference"]);
        c.erase("error_px");
        drawn[c][error_px] = measured;
    }
    CHECK(drawn.size() >= 1);
    for (const auto& [c, by_threshold] : drawn) {
        CAPTURE(c.dump());
        CHECK(by_threshold.at(0.01).at("image_difference") == 0);
        CHECK_FALSE(by_threshold.at(0.01).contains("psnr_db"));
        double last = 0;
        for (const auto& [error_px, measured] : by_threshold) {
            if (error_px == 0.01) continue;
            CHECK(measured.at("image_difference").get<double>() > last);
            last = measured["image_difference"];
            // The mean absolute difference is no larger than the root of the mean squared one.
            if (by_threshold.size() > 1) CHECK(measured["psnr_db"].get<double>() <= 20 * std::log10(255 / last) + 0.01);
        }
    }
    for (const auto& [c, differences] : of_method) CHECK(differences.size() == 1); // they show one mesh
}

// What a quick run is expected to take, in whole seconds, as it says first.
double announced_s(const std::string& err) {
    const std::string says = "fjell-lab: this will take about ";
    CAPTURE(err);
    REQUIRE(err.starts_with(says));
    return std::stod(err.substr(says.size()));
}

TEST_CASE("a run of experiments says first what it will take: what it took, and of what is new what recipes say") {
    // Five of the first recipe's cases are done; the rest of it and all others' are not.
    double expected = 0;
    for (const fs::path& file : recipe_files()) {
        const double about_s = json::parse(slurp(file)).at("quick").at("about_s");
        expected += file.stem() == "1-tilings" ? about_s * 16 / 21 : about_s;
    }
    CHECK(announced_s(lab_run().second_err) == std::ceil(expected));
    // Measured anew: the seconds beside the cases, here made up.
    const TemporaryFolder folder;
    fs::create_directories(folder.path / "recipes");
    fs::copy(recipes / "4-methods.json", folder.path / "recipes/methods.json");
    fs::create_directories(folder.path / "recipes/published");
    fs::copy(recipes / "published/thesis.json", folder.path / "recipes/published/thesis.json");
    const std::string command = lab_program + "--recipes recipes --out out";
    REQUIRE(run_in(folder.path, command).code == 0);
    std::string longer;
    double sum = 0;
    for (json line : stored(folder.path / "out/methods.jsonl")) {
        CHECK(line.at("seconds").get<double>() > 0);
        line["seconds"] = 1 + sum;
        sum += 1 + sum;
        longer += line.dump() + "\n";
        if (sum > 50) break;
    }
    const json recipe = json::parse(slurp(recipes / "4-methods.json"));
    const auto cases = static_cast<double>(stored(folder.path / "out/methods.jsonl").size()),
               known = static_cast<double>(lines_of(longer).size());
    spit(folder.path / "out/methods.jsonl", longer);
    const auto again = run_in(folder.path, command + " --fresh --cases 1");
    REQUIRE(again.code == 0);
    CHECK(announced_s(again.err) ==
          std::ceil(sum + recipe.at("quick").at("about_s").get<double>() * (cases - known) / cases));
}

TEST_CASE("instructions a frame are some, and not more than a mesh built anew would take") {
    for (const json& line : stored(lab_run().out() / "9-instructions.jsonl")) {
        const json& measured = line.at("measured");
        CHECK(measured.at("triangles").get<double>() > 100);
        if (!measured.contains("instructions")) { // then it was said why
            const std::string& said = lab_run().second_err;
            CHECK((said.find("instructions are not counted: valgrind is not installed") != std::string::npos ||
                   said.find("instructions are not counted: valgrind does not know all") != std::string::npos));
            WARN("skipped: no valgrind that runs here, so nothing was counted");
            continue;
        }
        // A frame at rest does hardly anything, one that builds its mesh anew a thousand or two a triangle.
        CHECK(measured["instructions"].get<double>() > 500);
        CHECK(measured["instructions"].get<double>() < 2000 * measured["triangles"].get<double>());
    }
}

TEST_CASE("the table of the rivals has a row for each, with the numbers of its cases") {
    const std::string name = GENERATE("5-rivals", "6-rivals-real");
    const json recipe = json::parse(slurp(recipes / (name + ".json")));
    const auto found = tables(slurp(lab_run().out() / "experiments.md"));
    const auto& table = found.at("### The rivals in one table: " + recipe.at("title").get<std::string>());
    REQUIRE(table.size() == recipe.at("methods").size() + 1);
    const auto column = [&](const std::string& heading) {
        const auto at = std::find(table[0].begin(), table[0].end(), heading);
        REQUIRE(at != table[0].end());
        return static_cast<std::size_t>(at - table[0].begin());
    };
    const auto about = [](const std::string& cell, double v) {
        return std::abs(std::stod(cell) - v) <= 6e-4 * std::abs(v); // four digits
    };
    std::map<std::string, double> worst;
    const std::vector<json> lines = stored(lab_run().out() / (name + ".jsonl"));
    CHECK(lines.size() == recipe.at("methods").size() * recipe.at("quick").at("cells_a_frame").size());
    for (const json& line : lines) {
        const std::string method = line.at("case").at("method");
        const json& measured = line.at("measured");
        const auto row = std::find_if(table.begin(), table.end(), [&](const auto& r) { return r[0] == method; });
        REQUIRE(row != table.end());
        CAPTURE(method);
        char heading[100];
        std::snprintf(heading, sizeof heading, "median [us] at %g cells a frame, and times lean",
                      line["case"]["cells_a_frame"].get<double>());
        CHECK(about((*row)[column(heading)], measured.at("median_us")));
        CHECK(measured.at("low_us") <= measured.at("median_us"));
        CHECK(measured.at("median_us") <= measured.at("high_us"));
        worst[method] = std::max(worst[method], measured.at("worst_us").get<double>());
        if (!measured.contains("memory_mb")) continue; // looked at on the first flight alone
        CHECK(about((*row)[column("memory [MB]")], measured["memory_mb"]));
        CHECK(about((*row)[column("popping, largest [px]")], measured.at("popping_px")));
        CHECK(about((*row)[column("true error, largest [px]")], measured.at("true_error_px")));
        CHECK(measured.at("open_edges") == 0);
    }
    for (const auto& row : table)
        if (worst.contains(row[0])) CHECK(about(row[column("update, worst [us]")], worst[row[0]]));
}

TEST_CASE("a recipe of an experiment that is none is refused in one line that names file and key") {
    refused_recipe("/quick/tile_cells", json::array({100}), "tile_cells: must be powers of two");
    refused_recipe("/quick/thresholds_px", "low", "thresholds_px: must be a list");
    refused_recipe("/quick/thresholds_px", json::array({-1}), "thresholds_px: must be numbers from");
    refused_recipe("/quick/tile_cells", json::array(), "tile_cells: must be a list");
    refused_recipe("/orders", json::array({"linear"}), "orders: the incremental method does not take linear");
    refused_recipe("/methods", json::array({"fastest"}),
                   "methods: \"fastest\" is none of recursive, incremental, lean");
    refused_recipe("/measures", json::array({"speed"}), "measures: \"speed\" is none of");
    refused_recipe("/methods", json::array({"roam"}), "methods: roam is for the conclusions rivals and instructions");
    refused_recipe("/measures/2", "instructions", "measures: instructions and the conclusion instructions");
    refused_recipe("/about_s", "long", "about_s: must be numbers from");
    refused_recipe("/conclusion", "rivals", "tile_cells: rivals take one tile as large as the terrain");
    refused_recipe("/repetitions", 3, "repetitions: unknown key; remove it");
    refused_recipe("/quick", 1, "quick: is missing");
    refused_recipe("/texture_cells", json::array({3}), "texture_cells: must be 0 or powers of two");
    refused_recipe("/measures/2", "frame_ms", "measures: what is measured of pictures and the conclusion drawing");
    refused_recipe("/conclusion", "drawing", "methods: lean has no mesh that is drawn");
    refused_recipe("/colour", 1, "colour: unknown key; remove it");
    refused_recipe("/quick/terrain", json::object(), "terrain.synthetic: is missing");
    refused_recipe("/quick/terrain/synthetic/landscape/colums", 9, "terrain.synthetic.landscape: ");
    refused_recipe("/tile_cells", json::array({3}), "tile_cells: must be powers of two"); // of the other form
    refused_recipe("/plots", json::array({{{"x", "error_px"}, {"y", "worst_us"}}}), "worst_us is not among");
}

TEST_CASE("the thesis' tables have twelve thresholds each, and vertices that grow as thresholds fall") {
    const json root = json::parse(slurp(recipes / "published/thesis.json"));
    CHECK(root.at("series").size() == 11);
    for (const json& series : root["series"]) {
        CAPTURE(series.at("name").get<std::string>());
        const auto thresholds = series.at("thresholds_px").get<std::vector<double>>(),
                   vertices = series.at("vertices").get<std::vector<double>>(),
                   rates = series.at("frames_a_second").get<std::vector<double>>();
        CHECK((thresholds.size() == 12 && vertices.size() == 12 && rates.size() == 12));
        CHECK(std::is_sorted(thresholds.rbegin(), thresholds.rend()));
        CHECK(std::is_sorted(vertices.begin(), vertices.end()));
    }
}

TEST_CASE("places in a tile are told apart in every order, and level by level without gaps but in linear order") {
    constexpr std::uint32_t side = 16;
    for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear}) {
        std::set<std::uint64_t> places, inner;
        for (std::uint32_t y = 0; y <= side; ++y)
            for (std::uint32_t x = 0; x <= side; ++x) {
                const std::uint64_t place = lab::place_in_tile(order, side, x, y);
                places.insert(place);
                if (x < side && y < side) inner.insert(place);
                if (order != PageOrder::linear && x % 4 == 0 && y % 4 == 0 && x < side && y < side)
                    CHECK(place < 16); // of step 4 and coarser there are sixteen, and they come first
            }
        CHECK(places.size() == (side + 1) * (side + 1));
        if (order != PageOrder::linear) CHECK(*inner.rbegin() == side * side - 1);
    }
}
