// fjell-lab: runs the experiments of content/experiments and writes one report. ./dev experiments calls it.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "lab/charts.h"
#include "lab/measure.h"
#include "lab/report.h"
#include "session/path.h"
#include "support/times.h"

namespace {

using namespace fjell;

struct Options {
    std::string recipes = FJELL_SOURCE_DIR "/content/experiments", out, machine;
    std::string draw;  // docs/plots.json: only draws it
    std::string count; // RECIPE:NUMBER: only flies that case, for whoever counts its instructions
    bool quick = false, fresh = false;
    std::size_t cases = std::numeric_limits<std::size_t>::max();
};

std::vector<std::string> recipe_files(const std::string& folder) {
    std::vector<std::string> files;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
        if (entry.path().extension() == ".json") files.push_back(entry.path().string());
    if (files.empty()) throw io::Failure(1, folder + ": no recipes; give a folder with files *.json");
    std::sort(files.begin(), files.end());
    return files;
}

std::string duration_text(double seconds) {
    return seconds < 90 ? fmt::format("{:.0f} s", std::ceil(seconds)) : fmt::format("{:.0f} minutes", seconds / 60);
}

// This program again, on the same experiments.
lab::Counting counting_by(const Options& options) {
    lab::Counting counting{
        {std::filesystem::read_symlink("/proc/self/exe").string(), "--recipes", options.recipes, "--out", options.out},
        options.out + "/counting.log"};
    if (options.quick) counting.command.emplace_back("--quick");
    return counting;
}

int fly_counted(const Options& options, const std::string& real_folder) {
    const std::size_t colon = options.count.rfind(':');
    const std::string file = options.recipes + "/" + options.count.substr(0, colon) + ".json";
    const lab::Recipe recipe = lab::read_recipe(file, real_folder, options.quick);
    const std::vector<lab::Case> cases = lab::cases_of(recipe);
    const std::size_t number =
        colon == std::string::npos ? 0 : std::strtoul(options.count.c_str() + colon + 1, nullptr, 10);
    if (!recipe.counts() || number < 1 || number > cases.size())
        throw io::Failure(2,
                          "--count: there is no such case; give RECIPE:NUMBER of one whose instructions are counted");
    lab::World world(recipe.site, FJELL_SOURCE_DIR, real_folder, options.out + "/packs");
    lab::fly_counted(recipe, cases[number - 1], world);
    return 0;
}

// Measures what is not measured yet, as far as `left` goes.
lab::Results run_recipe(const lab::Recipe& recipe, lab::Store& store, const Options& options,
                        const std::string& real_folder, std::size_t& left) {
    const double expected_s = store.expected_s();
    lab::World world(recipe.site, FJELL_SOURCE_DIR, real_folder, options.out + "/packs");
    const std::vector<lab::Case> cases = lab::cases_of(recipe);
    std::size_t number = 0, measured = 0;
    double took_s = 0;
    for (const lab::Case& c : cases) {
        ++number;
        if (store.find(c) || left == 0) continue;
        fmt::print(stderr, "fjell-lab: {}: {} of {}\n", recipe.name, number, cases.size());
        const auto start = test::Clock::now();
        const nlohmann::json of_case = lab::measure_case(recipe, c, number, world, counting_by(options), options.out);
        const double seconds = test::us_since(start) * 1e-6;
        store.add(c, of_case, seconds);
        took_s += seconds;
        --left;
        ++measured;
    }
    const lab::Results results = lab::results_of(
        recipe, store, lab::read_published(options.recipes + "/published/thesis.json", recipe.published));
    fmt::print("{}: {} cases measured now, {} of {} in all\n", recipe.name, measured, results.done(), cases.size());
    if (measured > 0)
        fmt::print(stderr, "fjell-lab: {}: took {:.0f} s, expected {:.0f} s for all that was missing\n", recipe.name,
                   took_s, expected_s);
    return results;
}

int run(const Options& options) {
    io::catch_interrupts();
    if (!options.draw.empty()) {
        for (const auto& [name, svg] : lab::read_charts(options.draw)) {
            io::AtomicFile file(options.out + "/" + name + ".svg");
            file.write(std::as_bytes(std::span(svg)));
            file.commit();
        }
        return 0;
    }
    const char* const data = std::getenv("FJELL_DATA");
    const std::string real_folder = data ? data : "";
    if (!options.count.empty()) return fly_counted(options, real_folder);
    std::vector<lab::Recipe> recipes; // all of them are read before any is run
    for (const std::string& file : recipe_files(options.recipes)) {
        (void)lab::read_recipe(file, real_folder, !options.quick); // its other form
        recipes.push_back(lab::read_recipe(file, real_folder, options.quick));
        (void)session::read_path(FJELL_SOURCE_DIR "/" + recipes.back().site.path);
        (void)lab::read_published(options.recipes + "/published/thesis.json", recipes.back().published);
    }
    std::vector<lab::Store> stores;
    double expected_s = 0;
    for (const lab::Recipe& recipe : recipes)
        expected_s += stores.emplace_back(recipe, options.out, options.fresh).expected_s();
    // Packs that are not baked yet are in what a recipe says, and not in what a run took that found them.
    if (expected_s > 0) fmt::print(stderr, "fjell-lab: this will take about {}\n", duration_text(expected_s));
    std::vector<lab::Results> results;
    std::size_t left = options.cases;
    for (std::size_t i = 0; i < recipes.size(); ++i)
        results.push_back(run_recipe(recipes[i], stores[i], options, real_folder, left));
    const std::string machine =
        options.machine.empty() ? fmt::format("{} cores", std::thread::hardware_concurrency()) : options.machine;
    lab::write_report(results, machine, options.out);
    fmt::print("{}/experiments.md and experiments.html\n", options.out);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    CLI::App app(
        "Runs the experiments of a folder of recipes and writes one report. What is measured already is kept.");
    app.add_option("--recipes", options.recipes, "Folder of recipes")->capture_default_str();
    app.add_option("-o,--out", options.out,
                   "Folder of results, packs and the report (build/experiments, of the quick form its quick)");
    app.add_flag("--quick", options.quick, "Small synthetic terrain, few thresholds: seconds");
    app.add_flag("--fresh", options.fresh, "Measure again what was measured before");
    app.add_option("--cases", options.cases, "Stop after so many cases, and report what there is");
    app.add_option("--machine", options.machine, "What the report says of the machine");
    app.add_option("--draw", options.draw, "Only draw the plots of this file (docs/plots.json) into the folder --out");
    app.add_option("--count", options.count,
                   "RECIPE:NUMBER: only fly this case, as is done under callgrind to count its instructions");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? 0 : 2;
    }
    if (options.out.empty()) options.out = options.quick ? "build/experiments/quick" : "build/experiments";
    return io::run_tool("fjell-lab", [&] { return run(options); });
}
