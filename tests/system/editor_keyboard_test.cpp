// The editor without a mouse, in the real window: whole tasks, and every control of a dialog and a panel.
#include <catch2/catch.hpp>

#include <filesystem>
#include <set>

#include "support/editor_pack.h"
#include "support/editor_window.h"
#include "support/program.h"
#include "support/rounds.h"

using namespace fjell::test;
using nlohmann::json;

namespace {

bool has_no_windows() {
    const std::string why = why_no_windows();
    if (!why.empty()) WARN("skipped: " << why);
    return !why.empty();
}

auto dialog_is(const std::string& name) {
    return [name](const json& s) { return s["interface"]["dialog"] == name; };
}

struct Keyboard {
    explicit Keyboard(std::vector<std::string> more = {})
        : editor(display, home.path, with_size(std::move(more)), Pixels::unseen) {}

    static std::vector<std::string> with_size(std::vector<std::string> more) {
        more.insert(more.end(), {"--size", "600x480", "--scale", "0.5"});
        return more;
    }
    void choose(const std::string& menu_keys, const std::string& item) {
        editor.key(menu_keys);
        editor.go_to(item, "Down");
        editor.key("Return");
    }
    // No test of this file has touched it.
    void no_mouse() {
        const json input = editor.state()["input"];
        CHECK(input["buttons"] == 0);
        CHECK(input["scrolls"] == 0);
    }

    VirtualDisplay display{640, 512};
    TemporaryFolder home;
    EditorWindow editor;
};

// Controls of these groups that the window shows, without what only tells of something.
std::set<std::string> controls(const json& state, const std::set<std::string>& groups) {
    // Or is grey as long as nothing has been typed or compared.
    static const std::set<std::string> tell{"bake.plan",          "bake.picture",
                                            "job.progress",       "bake.start",
                                            "browse.choose",      "bake.splat",
                                            "export.error_px",    "compare-picture.profile",
                                            "export.destination", "screenshot.destination"};
    std::set<std::string> found;
    for (const auto& [name, place] : state["marks"].items())
        if (groups.contains(name.substr(0, name.find('.'))) && !tell.contains(name)) found.insert(name);
    return found;
}

// Whatever Tab comes by until it is where it began.
std::set<std::string> tabbed(EditorWindow& editor) {
    std::set<std::string> seen;
    std::string first;
    for (int i = 0; i < 120; ++i) {
        editor.key("Tab");
        const std::string at = editor.state()["interface"]["focus"];
        if (i > 0 && at == first && !at.empty()) break;
        if (first.empty()) first = at;
        seen.insert(at);
    }
    return seen;
}

} // namespace

TEST_CASE("by keyboard alone a pack is opened, a threshold changed, the profile saved and the mesh exported") {
    if (has_no_windows()) return;
    Keyboard k;
    EditorWindow& editor = k.editor;
    namespace fs = std::filesystem;
    fs::copy_file(small_pack(), k.home / "hills.fjell");
    editor.until("the welcome", dialog_is("start"));
    editor.go_to("start.open");
    editor.key("Return");
    editor.until("a dialog", dialog_is("open"));
    CHECK(editor.state()["interface"]["focus"] == "browse.name"); // its first field
    const std::string begun = editor.state()["files"]["folder"];
    editor.type(k.home / ".."); // a folder is gone to, and typing goes on
    editor.key("Return");
    editor.until("another folder", [&](const json& s) { return s["files"]["folder"] != begun; });
    CHECK(editor.state()["interface"]["focus"] == "browse.name");
    editor.type(k.home / "hills.fjell");
    editor.key("Return");
    editor.until("a converged mesh", [](const json& s) { return s["measures"]["converged"] == true; });
    editor.key("F6");
    editor.go_to("field.refine.max_error_px");
    editor.key("ctrl+a");
    editor.type("7.5");
    editor.key("Return");
    editor.until("7.5 px", [](const json& s) { return s["profile"]["refine.max_error_px"] == 7.5; });
    editor.key("Escape"); // the camera's again
    CHECK(editor.state()["interface"]["panel_keys"] == false);
    editor.key("ctrl+s");
    editor.until("a dialog", dialog_is("save-profile"));
    editor.key("ctrl+a");
    editor.type(k.home / "mine.toml");
    editor.key("Return");
    editor.until("a saved profile", [](const json& s) { return s["document"]["unsaved"] == false; });
    CHECK(slurp(k.home / "mine.toml").find("max_error_px = 7.5") != std::string::npos);
    k.choose("alt+f", "menu.export");
    editor.until("a dialog", dialog_is("export"));
    CHECK(editor.state()["marks"].contains("export.destination")); // of the name that is proposed
    editor.key("ctrl+a");
    editor.type(k.home / "hills.glb");
    CHECK_FALSE(editor.state()["marks"].contains("export.destination")); // which tells its folder itself
    editor.key("Return");
    editor.until("the export", [&](const json&) { return fs::exists(k.home / "hills.glb"); });
    CHECK(slurp(k.home / "hills.glb").substr(0, 4) == "glTF");
    editor.key("Escape");
    editor.until("no dialog", dialog_is("none"));
    k.no_mouse();
    editor.key("ctrl+q");
    CHECK(editor.exit_code() == 0);
}

TEST_CASE("Tab comes to every control of a dialog and of a panel, and back to where it began") {
    if (has_no_windows()) return;
    Keyboard k({small_pack()});
    EditorWindow& editor = k.editor;
    editor.until("a picture", [](const json& s) { return s["measures"]["converged"] == true; });
    struct Case {
        const char* name; // in the file menu
        std::set<std::string> groups;
    };
    editor.key("F6");
    for (int turned = 0; editor.state()["interface"]["left"] != "view"; ++turned) {
        REQUIRE(turned < 5);
        editor.key("ctrl+Next");
    }
    const std::set<std::string> seen_in_panel = tabbed(editor);
    for (const std::string& control : controls(editor.state(), {"mode", "overlay", "compare-picture"})) {
        INFO(control);
        CHECK(seen_in_panel.contains(control));
    }
    editor.key("Escape");
    std::vector<Case> dialogs{{"export", {"export"}}, {"bake", {"bake", "browse"}}};
    if (full_rounds()) dialogs.insert(dialogs.end(), {{"open", {"browse"}}, {"screenshot", {"screenshot"}}});
    for (const Case& c : dialogs) {
        INFO("dialog " << c.name);
        k.choose("alt+f", std::string("menu.") + c.name);
        editor.until("the dialog", dialog_is(c.name));
        const std::set<std::string> seen = tabbed(editor);
        const json state = editor.state();
        std::size_t there = 0;
        for (const std::string& control : controls(state, c.groups)) {
            INFO(control);
            CHECK(seen.contains(control));
            ++there;
        }
        CHECK(there >= 3);
        editor.key("Escape");
        editor.until("no dialog", dialog_is("none"));
    }
    k.no_mouse();
}

TEST_CASE(
    "menus, lists and panels by keys: Enter chooses, arrows name files, F6 goes around, and nothing beneath reacts") {
    if (has_no_windows()) return;
    Keyboard k({small_pack()});
    EditorWindow& editor = k.editor;
    spit(k.home / "a.toml", "");
    const json before = editor.until("a picture", [](const json& s) { return s["measures"]["converged"] == true; });
    // A menu is open: letters, brackets and Tab are not the window's.
    editor.key("F10");
    CHECK(editor.state()["interface"]["focus"] == "menu.open");
    editor.key("bracketright");
    editor.key("Tab");
    editor.key("Right");
    editor.key("Escape");
    const json after = editor.state();
    CHECK(after["profile"] == before["profile"]);
    CHECK(after["interface"]["panels"] == before["interface"]["panels"]);
    // The camera has the keys: Tab hides the panels; with F6 it moves in them.
    editor.key("Tab");
    CHECK(editor.state()["interface"]["panels"] == false);
    editor.key("F6");
    const json in_panels = editor.state();
    CHECK(in_panels["interface"]["panels"] == true);
    CHECK(in_panels["interface"]["panel_keys"] == true);
    CHECK_FALSE(in_panels["interface"]["focus"] == "");
    editor.key("Tab");
    CHECK(editor.state()["interface"]["panels"] == true);
    editor.key("f"); // no letter is the camera's now
    CHECK(editor.state()["camera"]["frozen"] == false);
    editor.key("shift+F6"); // before the first panel
    CHECK(editor.state()["interface"]["panel_keys"] == false);
    editor.key("shift+F6");
    CHECK(editor.state()["interface"]["panel_keys"] == true); // the last one
    editor.key("F6");
    CHECK(editor.state()["interface"]["panel_keys"] == false);
    // The probe looks where the camera does, and Enter marks the place.
    editor.key("i");
    editor.until("ground under the probe", [](const json& s) { return s["probe"].contains("ground"); });
    editor.key("Return");
    CHECK(editor.state()["probe"]["marks"].size() == 1);
    editor.key("Escape");
    // A modal dialog: its list is entered, and F, Tab and brackets reach nothing beneath.
    editor.key("ctrl+o");
    editor.key("shift+Tab");
    CHECK(editor.state()["interface"]["focus"] == "file...");
    editor.key("f");
    editor.key("bracketright");
    editor.key("F11");
    const json modal = editor.state();
    CHECK(modal["camera"]["frozen"] == false);
    CHECK(modal["profile"] == before["profile"]);
    CHECK(modal["interface"]["picture_only"] == false);
    const std::string folder = modal["files"]["folder"];
    editor.key("Return"); // up a folder
    editor.until("the folder above", [&](const json& s) { return s["files"]["folder"] != folder; });
    CHECK(editor.state()["interface"]["dialog"] == "open");
    CHECK(editor.state()["interface"]["focus"] == "file..."); // where it was: the list goes on by keys
    editor.key("Escape");
    editor.until("no dialog", dialog_is("none"));
}
