// fjell-lab: runs the experiments of content/experiments and writes one report. ./dev experiments calls it.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "flight/path.h"
#include "lab/measure.h"
#include "lab/report.h"

namespace {

using namespace fjell;

struct Options {
    std::string recipes = FJELL_SOURCE_DIR "/content/experiments", out, machine;
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

// Measures what is not measured yet, as far as `left` goes.
lab::Results run_recipe(const lab::Recipe& recipe, const Options& options, const std::string& real_folder,
                        std::size_t& left) {
    lab::Store store(recipe, options.out, options.fresh);
    lab::World world(recipe.site, FJELL_SOURCE_DIR, real_folder, options.out + "/packs");
    const std::vector<lab::Case> cases = lab::cases_of(recipe);
    std::size_t number = 0, measured = 0;
    for (const lab::Case& c : cases) {
        ++number;
        if (store.find(c) || left == 0) continue;
        fmt::print(stderr, "fjell-lab: {}: {} of {}\n", recipe.name, number, cases.size());
        store.add(c, lab::measure_case(recipe, c, world, options.out));
        --left;
        ++measured;
    }
    const lab::Results results = lab::results_of(
        recipe, store, lab::read_published(options.recipes + "/published/thesis.json", recipe.published));
    fmt::print("{}: {} cases measured now, {} of {} in all\n", recipe.name, measured, results.done(), cases.size());
    return results;
}

int run(const Options& options) {
    io::catch_interrupts();
    const char* const data = std::getenv("FJELL_DATA");
    const std::string real_folder = data ? data : "";
    std::vector<lab::Recipe> recipes; // all of them are read before any is run
    for (const std::string& file : recipe_files(options.recipes)) {
        (void)lab::read_recipe(file, real_folder, !options.quick); // its other form
        recipes.push_back(lab::read_recipe(file, real_folder, options.quick));
        (void)flight::read_path(FJELL_SOURCE_DIR "/" + recipes.back().site.path);
        (void)lab::read_published(options.recipes + "/published/thesis.json", recipes.back().published);
    }
    std::vector<lab::Results> results;
    std::size_t left = options.cases;
    for (const lab::Recipe& recipe : recipes) results.push_back(run_recipe(recipe, options, real_folder, left));
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
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? 0 : 2;
    }
    if (options.out.empty()) options.out = options.quick ? "build/experiments/quick" : "build/experiments";
    return io::run_tool("fjell-lab", [&] { return run(options); });
}
