// Baking by hand in the real window: a file is chosen, what is missing is proposed, and the terrain that is flown stays
// until the user agrees.
#include <catch2/catch.hpp>

#include "support/editor_pack.h"
#include "support/editor_window.h"
#include "support/program.h"

using namespace fjell::test;
using nlohmann::json;

namespace {

// Numbers without coordinates: a binary grey map.
std::string grey_map() {
    std::string text = "P5\n65 65\n255\n";
    for (int i = 0; i < 65 * 65; ++i) text += static_cast<char>(40 + i % 65 * 2 + i / 65);
    return text;
}

} // namespace

TEST_CASE("heights are baked by browsing: what is missing is marked and proposed, and the flown terrain stays until "
          "asked for another") {
    if (const std::string why = why_no_windows(); !why.empty()) {
        WARN("skipped: " << why);
        return;
    }
    const VirtualDisplay display(600, 320);
    const TemporaryFolder home;
    spit(home / "hills_30m.png", grey_map());
    spit(home / "rules.json", R"({"rules": [{"layer": "grass"}]})");
    EditorWindow editor(display, home.path,
                        {small_pack(), "--size", "600x320", "--scale", "0.5", "--do", "browse " + home.path.string()},
                        Pixels::unseen);
    const auto baking = [](const json& s) { return s["files"]["bake"]; };
    editor.click("menu.file");
    editor.click("menu.bake");
    editor.click("browse.heights");
    editor.click("file.hills_30m.png");
    editor.key("Return");
    const json looked = editor.until("a look at the heights", [&](const json& s) {
        return baking(s)["known"] == true && baking(s)["looking"] == false;
    });
    CHECK(baking(looked)["columns"] == 65);
    CHECK(baking(looked)["field"] == "spacing");
    CHECK(baking(looked)["pictured"] == true);
    CHECK(baking(looked)["output"] == home / "hills_30m.fjell");
    editor.key("Return"); // nothing to bake yet
    CHECK(editor.state()["job"]["kind"] == "none");
    editor.click("propose.spacing");
    editor.until("no problem", [&](const json& s) {
        return baking(s)["spacing_m"] == 30 && baking(s)["looking"] == false && baking(s)["problem"] == "";
    });
    // Enter in the browser chooses a file, and does not reach the button beneath, which could bake now.
    editor.click("browse.rules");
    editor.click("file.rules.json");
    editor.key("Return");
    editor.until("a look at the rules", [&](const json& s) {
        return baking(s)["rule_count"] == 1 && baking(s)["looking"] == false && baking(s)["problem"] == "";
    });
    CHECK(editor.state()["job"]["kind"] == "none");
    CHECK(baking(editor.state())["layers"]["grass"] == 1.0);
    editor.click("bake.start");
    const json ready = editor.until("the question", [](const json& s) { return s["interface"]["dialog"] == "baked"; });
    CHECK(ready["scene"]["path"] == small_pack());
    editor.click("baked.open");
    editor.until("the new terrain", [&](const json& s) {
        return s["scene"]["path"] == home / "hills_30m.fjell" && s["scene"]["columns"] == 65 &&
               s["interface"]["dialog"] == "none";
    });
}
