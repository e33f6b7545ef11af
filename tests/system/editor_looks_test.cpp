// What the editor shows at the sizes of desktops and with large text, looked at by what it has drawn: no text is cut by
// an edge that nothing scrolls, and none lies over another. The built editor without a window.
#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "support/editor_pack.h"
#include "support/editor_sights.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/temporary_folder.h"

using namespace fjell::test;
using nlohmann::json;

namespace {

struct Desktop {
    const char *size, *scale;
};

// A script that shows each sight in turn at each size and dumps it; what takes a flight is left to full rounds.
std::string script_of(const std::vector<Desktop>& desktops, const std::vector<Sight>& panels,
                      const std::vector<Sight>& overlays, const std::string& folder) {
    std::string script;
    std::size_t dumps = 0;
    const auto show = [&](const std::vector<std::string>& commands) {
        for (const std::string& c : commands) script += c + "\n";
    };
    const auto dump = [&](const std::vector<Sight>& sights) {
        for (const Sight& sight : sights) {
            show(sight.commands);
            show({"frames 4", "dump " + folder + "/" + std::to_string(dumps++) + ".json", "frames 1"});
        }
    };
    const auto resize = [&](const Desktop& d) {
        show({std::string("resize ") + d.size, std::string("scale ") + d.scale, "frames 3"});
    };
    show({"home", "wait", "add-point", "jump 9000 9000", "add-point",
          "compare " FJELL_SOURCE_DIR "/profiles/laptop.toml", "freeze on"});
    for (const Desktop& d : desktops) {
        resize(d);
        dump(panels);
    }
    show({"dialog none", "freeze off", "navigate fly"});
    show(flown_runs(folder, rounds(60, 600)));
    show(compared_picture);
    for (const Desktop& d : desktops) {
        for (const char* panel : fjell::editor::panel_names) show({std::string("float ") + panel + " off"});
        for (const char* overlay : fjell::editor::overlay_names) show({std::string("overlay ") + overlay + " off"});
        resize(d);
        dump(overlays);
    }
    return script;
}

} // namespace

TEST_CASE("at the sizes of desktops and with large text no text is cut, and none lies over another") {
    std::vector<Desktop> desktops{{"1280 720", "1"}, {"1280 720", "2"}};
    if (full_rounds())
        desktops.insert(desktops.end(), {{"1920 1080", "1"}, {"2560 1440", "1"}, {"2560 1440", "2"}, {"640 480", "1"}});
    const std::vector<Sight> panels = panels_and_dialogs(), overlays = overlays_in_turn();
    const TemporaryFolder folder;
    // What software draws fastest: the picture is not what is looked at.
    spit(folder / "profile.toml", "[view]\nsamples = 1\n[refine]\nmax_error_px = 8\n"
                                  "[light]\nair = \"simple\"\ndetail = false\ndither = false\n");
    spit(folder / "script", script_of(desktops, panels, overlays, folder.path));
    const Run run = run_in(folder.path, no_pixels +
                                            "ASAN_OPTIONS=detect_leaks=0 " FJELL_BIN_DIR
                                            "/fjell-editor --headless --profile profile.toml --size 1280x720 "
                                            "--scale 1 '" +
                                            small_pack() + "' --script script");
    INFO(run.err);
    REQUIRE(run.code == 0);
    std::size_t dumps = 0;
    for (const std::vector<Sight>* sights : {&panels, &overlays})
        for (const Desktop& d : desktops)
            for (const Sight& sight : *sights) {
                INFO(d.size << " at " << d.scale << ", " << sight.name);
                const json state = json::parse(slurp(folder / (std::to_string(dumps++) + ".json")));
                CHECK(state["illegible"] == json::array());
            }
}
