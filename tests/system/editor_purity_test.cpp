// A steady frame of the editor's own code - panels, commands, measures - allocates nothing: counted in the whole
// program, headless, panel by panel and dialog by dialog. Drivers and the terrain's update are not the editor's
// own.
#include <catch2/catch.hpp>

#include <algorithm>
#include <string>
#include <vector>

#include "editor/app.h"
#include "support/count_allocations.h"
#include "support/editor_pack.h"
#include "support/editor_sights.h"
#include "support/rounds.h"
#include "support/temporary_folder.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr std::size_t settling = 16; // of the frames of a sight, until it is steady

std::vector<long> by_frame; // allocations
const editor::App* watched = nullptr;

void watch(bool begins) {
    if (begins) {
        allocations = 0;
        counting = true;
    } else {
        counting = false;
        by_frame.at(watched->state().frame) += allocations;
    }
}

// Flies through a list of sights; the worst frame of each once it is steady.
std::vector<long> worst_of(const TemporaryFolder& folder, const std::vector<Sight>& sights,
                           const std::vector<std::string>& first) {
    const std::size_t shown = rounds<std::size_t>(24, 60); // frames of each sight
    for (const char* name : {"XDG_CONFIG_HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME"})
        setenv(name, folder.path.c_str(), 1);
    setenv("LP_NO_RAST", "1", 1); // as no_pixels (support/program.h)
    editor::Options options;
    options.headless = true;
    options.pack = small_pack();
    options.path = FJELL_SOURCE_DIR "/content/paths/flythrough.json";
    options.commands = first;
    // Until all graphs have their full length: they grow, and ImGui's buffers with them. In a small window with small
    // text, because software draws it.
    options.scale = 0.5;
    options.commands.push_back("resize 320 320");
    options.commands.push_back("frames " + std::to_string(editor::measured_frames));
    options.commands.push_back("resize 320 360");
    options.commands.push_back("frames 16");
    for (const Sight& sight : sights) {
        options.commands.insert(options.commands.end(), sight.commands.begin(), sight.commands.end());
        options.commands.push_back("frames " + std::to_string(shown));
    }
    by_frame.assign(1 << 20, 0);
    editor::App app(options);
    watched = &app;
    app.watch_own_code(watch);
    REQUIRE(app.run() == 0);
    const std::size_t frames = app.state().frame;
    REQUIRE(frames > sights.size() * shown);
    REQUIRE(*std::max_element(by_frame.begin(), by_frame.end()) >
            0); // building the mesh was counted, so counting works
    std::vector<long> worst;
    for (std::size_t i = 0; i < sights.size(); ++i) { // the last ones of each sight
        const auto end = by_frame.begin() + static_cast<std::ptrdiff_t>(frames - (sights.size() - 1 - i) * shown - 2);
        worst.push_back(*std::max_element(end - (shown - settling - 4), end));
    }
    return worst;
}

// No pixel is looked at: the light that software draws fastest.
const std::vector<std::string> plain_light{"set light.air simple", "set light.detail false", "set light.dither false",
                                           "set refine.max_error_px 50"};

void check_nothing(const std::vector<Sight>& sights, const std::vector<long>& worst) {
    for (std::size_t i = 0; i < sights.size(); ++i) {
        INFO(sights[i].name);
        CHECK(worst[i] == 0);
    }
}

} // namespace

TEST_CASE("with any panel or dialog open, a steady frame of the editor's own code allocates nothing") {
    if (!interposed) {
        WARN("skipped: a sanitizer has malloc to itself");
        return;
    }
    const TemporaryFolder folder;
    const std::vector<Sight> sights = panels_and_dialogs();
    std::vector<std::string> first = plain_light;
    first.insert(first.end(), {"play-path on", "interface probe on", "probe 0.5 0.9", "mark 500 500", "mark 1500 900"});
    check_nothing(sights, worst_of(folder, sights, first));
}

TEST_CASE("with runs, heat, probe, marks and a compared picture shown, and with everything, it allocates nothing") {
    if (!interposed) {
        WARN("skipped: a sanitizer has malloc to itself");
        return;
    }
    const TemporaryFolder folder;
    const std::vector<Sight> sights = overlays_in_turn();
    std::vector<std::string> first = plain_light;
    const std::vector<std::string> runs = flown_runs(folder.path.string(), rounds(60, 600));
    first.insert(first.end(), runs.begin(), runs.end());
    first.insert(first.end(), compared_picture.begin(), compared_picture.end());
    first.push_back("play-path on");
    check_nothing(sights, worst_of(folder, sights, first));
}
