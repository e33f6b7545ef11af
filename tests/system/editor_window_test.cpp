// The real window, driven as by hand. Every process has its own X server, so cases may run side by side.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <memory>
#include <set>

#include "support/editor_pack.h"
#include "support/editor_window.h"
#include "support/program.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;
using nlohmann::json;

namespace {

bool no_windows() {
    const std::string why = why_no_windows();
    if (!why.empty()) WARN("skipped: " << why);
    return !why.empty();
}

const VirtualDisplay& display() {
    static const VirtualDisplay shared(1920, 1080);
    return shared;
}

// As small as two columns and a picture between them can be, at half the size of text and controls: a software driver
// draws every pixel of every frame.
constexpr const char *small_window = "600x320", *half_scale = "0.5";

// An editor over the small terrain, in a home of its own. Cases that leave it as they found it share one: each begins
// without a dialog, with the panel Tune, and tells changes from the state that it finds.
struct SmallTerrain {
    explicit SmallTerrain(Pixels pixels, const char* size = "600x360") // so high that the budgets need no scrolling
        : editor(screen, home.path, {small_pack(), "--size", size, "--scale", half_scale}, pixels) {}
    static SmallTerrain& shared(Pixels pixels) {
        static std::map<Pixels, std::unique_ptr<SmallTerrain>> all;
        std::unique_ptr<SmallTerrain>& terrain = all[pixels];
        if (!terrain) terrain = std::make_unique<SmallTerrain>(pixels);
        EditorWindow& editor = terrain->editor;
        while (editor.state()["interface"]["dialog"] != "none") editor.key("Escape");
        if (editor.state()["interface"]["left"] != "tune") editor.click("panel.tune");
        return *terrain;
    }
    VirtualDisplay screen{1920, 1080}; // of its own, which no other editor takes the focus of
    TemporaryFolder home;
    EditorWindow editor;

    // Into a field of the panel.
    void enter(const std::string& key, const std::string& text) {
        editor.click("field." + key);
        editor.key("ctrl+a");
        editor.type(text);
        editor.key("Return");
    }
};

bool converged(const json& s) {
    return s["measures"]["converged"] == true;
}

auto shows_dialog(const char* name) {
    return [name](const json& s) { return s["interface"]["dialog"] == name; };
}

bool has_message(const json& s, const char* severity, const char* part) {
    for (const json& m : s["messages"])
        if (m["severity"] == severity && m["text"].get<std::string>().find(part) != std::string::npos) return true;
    return false;
}

std::size_t colours_in(const gl::Image& image, const Place& p) {
    std::set<std::uint32_t> seen;
    for (auto y = static_cast<std::uint32_t>(p.y); y < static_cast<std::uint32_t>(p.y + p.height); y += 2)
        for (auto x = static_cast<std::uint32_t>(p.x); x < static_cast<std::uint32_t>(p.x + p.width); x += 2) {
            const std::uint8_t* c = image.pixel(x, y);
            seen.insert(c[0] | c[1] << 8 | c[2] << 16);
        }
    return seen.size();
}

} // namespace

TEST_CASE("dragging the threshold's slider coarsens the mesh at once, and one undo takes it all back") {
    if (no_windows()) return;
    SmallTerrain& terrain = SmallTerrain::shared(Pixels::drawn);
    EditorWindow& editor = terrain.editor;
    const json before = editor.until("a converged mesh", converged);
    const gl::Image fine = terrain.screen.picture();
    CHECK(colours_in(fine, view_of(before)) > 500); // a landscape, not a blank
    editor.drag("refine.max_error_px", 0.42, 0.8);
    const json after = editor.until("a coarser mesh", [&](const json& s) {
        return s["profile"]["refine.max_error_px"] > 4 && s["measures"]["converged"] == true &&
               s["measures"]["vertices"] < before["measures"]["vertices"];
    });
    CHECK(after["document"]["unsaved"] == true);
    CHECK(after["document"]["undo"] == before["document"]["undo"].get<int>() + 1);
    CHECK(after["measures"]["error_px_asked"] == after["profile"]["refine.max_error_px"]);
    CHECK(changed(fine, terrain.screen.picture(), view_of(after)) > 0.01);
    editor.key("ctrl+z");
    const json back = editor.until("the old mesh", [&](const json& s) {
        return s["document"]["undo"] == before["document"]["undo"] && s["measures"]["converged"] == true &&
               s["measures"]["vertices"] == before["measures"]["vertices"];
    });
    CHECK(back["profile"] == before["profile"]);
    CHECK(back["document"]["unsaved"] == false);
}

TEST_CASE("a number is typed beside the slider: one out of range is clamped with a message, and words change nothing") {
    if (no_windows()) return;
    SmallTerrain& terrain = SmallTerrain::shared(Pixels::unseen);
    EditorWindow& editor = terrain.editor;
    const int undo = editor.state()["document"]["undo"];
    terrain.enter("refine.max_error_px", "7.5");
    editor.until("7.5 px", [](const json& s) {
        return s["profile"]["refine.max_error_px"] == 7.5 && s["measures"]["error_px_asked"] == 7.5;
    });
    terrain.enter("refine.max_error_px", "123456");
    const json largest =
        editor.until("the mesh of it", [](const json& s) { return s["measures"]["error_px_asked"] > 8; });
    CHECK(largest["profile"]["refine.max_error_px"] == 1000);
    CHECK(has_message(largest, "warning", "1000"));
    CHECK(largest["document"]["undo"] == undo + 2);
    const std::uint64_t before = largest["input"]["characters"];
    terrain.enter("refine.max_error_px", "nonsense");
    const json after = editor.state();
    CHECK(after["input"]["characters"] == before + 8); // they did arrive
    CHECK(after["profile"]["refine.max_error_px"] == 1000);
    CHECK(after["document"]["undo"] == undo + 2);
    for (int i = 0; i < 2; ++i) editor.key("ctrl+z");
}

TEST_CASE(
    "between two slow frames nothing is lost: two redos, a click where it was made, letters for its field alone") {
    if (no_windows()) return;
    SmallTerrain& terrain = SmallTerrain::shared(Pixels::unseen);
    EditorWindow& editor = terrain.editor;
    const json before = editor.until("a picture", converged);
    const double first = before["profile"]["refine.max_error_px"];
    for (const char* px : {"5", "6"}) terrain.enter("refine.max_error_px", px);
    for (int i = 0; i < 2; ++i) editor.key("ctrl+z");
    CHECK(editor.state()["profile"]["refine.max_error_px"] == first);
    editor.between_frames({"key ctrl+y", "key ctrl+y"}, "keys", 8);
    CHECK(editor.state()["profile"]["refine.max_error_px"] == 6);
    // Letters are shortcuts of the picture: M turns to another mode, F freezes, 3 looks for a path.
    const Place field = editor.place("field.refine.max_error_px");
    const auto at = [](double x, double y) {
        return "mousemove " + std::to_string(static_cast<int>(x)) + " " + std::to_string(static_cast<int>(y));
    };
    const Place view = view_of(before);
    editor.between_frames({at(field.x + field.width / 2, field.y + field.height / 2), "mousedown 1", "mouseup 1",
                           at(view.x + view.width / 2, view.y + view.height / 2), "key --clearmodifiers ctrl+a",
                           "type --delay 0 3.5mf", "key BackSpace", "key BackSpace", "key Return"},
                          "characters", 5);
    const json after =
        editor.until("the value", [](const json& s) { return s["profile"]["refine.max_error_px"] == 3.5; });
    CHECK(after["interface"]["mode"] == before["interface"]["mode"]);
    CHECK(after["camera"]["frozen"] == false);
    CHECK_FALSE(has_message(after, "error", "path"));
    // Two clicks, on different panels' tabs: the later one is what is shown.
    const Place view_tab = editor.place("panel.view"), tune_tab = editor.place("panel.tune");
    std::vector<std::string> clicks;
    for (const Place& tab : {view_tab, tune_tab})
        clicks.insert(clicks.end(), {at(tab.x + 3, tab.y + 3), "mousedown 1", "mouseup 1"});
    clicks.push_back(at(view.x + 9, view.y + 9));
    editor.between_frames(clicks, "buttons", 4);
    CHECK(editor.state()["interface"]["left"] == "tune");
    for (int i = 0; i < 3; ++i) editor.key("ctrl+z");
    editor.until("as it was", [&](const json& s) { return s["profile"]["refine.max_error_px"] == first; });
}

TEST_CASE("groups fold and unfold by hand and are remembered, and the search shows what is looked for alone") {
    if (no_windows()) return;
    const TemporaryFolder home;
    const std::vector<std::string> arguments{small_pack(), "--size", "600x400", "--scale", half_scale};
    {
        EditorWindow editor(display(), home.path, arguments, Pixels::unseen);
        editor.until("a picture", converged);
        const auto has = [&](const char* mark) { return editor.state()["marks"].contains(mark); };
        CHECK(has("refine.max_error_px"));
        CHECK_FALSE(has("refine.metric")); // for the recursive method alone: advanced
        editor.click("group.tune.refinement");
        CHECK_FALSE(has("refine.max_error_px"));
        editor.click("group.tune.budgets");
        editor.click("group.tune.screen");
        CHECK(has("view.fov_deg"));
        // Ctrl+F, and letters go into its field: neither the camera's keys nor a shortcut.
        editor.key("ctrl+f");
        editor.type("metric");
        CHECK(has("refine.metric.isotropic"));
        CHECK_FALSE(has("view.fov_deg"));
        CHECK_FALSE(has("group.tune.screen"));
        const json found = editor.state();
        CHECK(found["interface"]["mode"] == "shaded"); // M is of another
        for (int i = 0; i < 6; ++i) editor.key("BackSpace");
        editor.type("contour");
        editor.key("Escape");
        editor.key("ctrl+q");
        CHECK(editor.exit_code() == 0);
    }
    EditorWindow editor(display(), home.path, arguments, Pixels::unseen);
    const json next = editor.until("a picture", converged);
    const auto is_open = [&](const char* name) {
        const json& open = next["interface"]["groups"];
        return std::find(open.begin(), open.end(), name) != open.end();
    };
    CHECK_FALSE(is_open("tune.refinement"));
    CHECK(is_open("tune.screen"));
    CHECK(next["messages"].empty());
}

TEST_CASE("clicks turn to panels, pictures and overlays, which show in the picture and nowhere else") {
    if (no_windows()) return;
    SmallTerrain& terrain = SmallTerrain::shared(Pixels::drawn);
    EditorWindow& editor = terrain.editor;
    editor.click("panel.view");
    json state = editor.until("the panel", [](const json& s) { return s["interface"]["left"] == "view"; });
    const Place view = view_of(state);
    editor.move(view.x + view.width / 2, view.y + view.height / 2); // no tip over the picture
    gl::Image before = terrain.screen.picture();
    editor.click("overlay.wireframe");
    editor.until("wires", [](const json& s) { return s["interface"]["overlay"]["wireframe"] == true; });
    editor.move(view.x + view.width / 2, view.y + view.height / 2);
    gl::Image after = terrain.screen.picture();
    CHECK(changed(before, after, view) > 0.05);
    CHECK(changed(before, after, {0, view.y, view.x, view.height}) < 0.02); // a tick, no more
    editor.click("overlay.wireframe");
    editor.click("mode.levels");
    editor.until("levels", [](const json& s) { return s["interface"]["mode"] == "levels"; });
    editor.move(view.x + view.width / 2, view.y + view.height / 2);
    CHECK(changed(before, terrain.screen.picture(), view) > 0.3);
    editor.click("mode.shaded");
}

TEST_CASE("budgets rebuild the cut under the same view, and one that is impossible is reverted") {
    if (no_windows()) return;
    SmallTerrain& terrain = SmallTerrain::shared(Pixels::unseen);
    EditorWindow& editor = terrain.editor;
    const json before = editor.until("a picture", converged);
    terrain.enter("budget.vertices", "3000");
    const json small = editor.until("a smaller block", [&](const json& s) {
        return s["profile"]["budget.vertices"] == 3000 && s["scene"]["method_bytes"] < before["scene"]["method_bytes"];
    });
    CHECK(small["camera"]["position_m"] == before["camera"]["position_m"]);
    editor.until("the budget to tell", [](const json& s) { return s["measures"]["error_px_effective"] > 1.0; });
    terrain.enter("budget.vertices", "16"); // not even the corners of its tiles
    const json refused = editor.until("a message", [](const json& s) { return has_message(s, "error", "reverted"); });
    CHECK(refused["profile"]["budget.vertices"] == 3000);
    CHECK(refused["document"]["undo"] == before["document"]["undo"].get<int>() + 1);
    CHECK(refused["measures"]["triangles"] > 0);
    editor.key("ctrl+z");
    editor.until("all of it again", [&](const json& s) {
        return s["profile"] == before["profile"] && s["measures"]["converged"] == true &&
               s["measures"]["vertices"] == before["measures"]["vertices"];
    });
}

TEST_CASE("keys and the mouse move the camera, but not while a number is typed or a panel is under the pointer") {
    if (no_windows()) return;
    SmallTerrain& terrain = SmallTerrain::shared(Pixels::unseen);
    EditorWindow& editor = terrain.editor;
    const json before = editor.until("a picture", converged);
    const Place view = view_of(before);
    const double x = view.x + view.width / 2, y = view.y + view.height / 2;
    const auto position = [](const json& s, int i) {
        return s["camera"]["position_m"][static_cast<std::size_t>(i)].get<double>();
    };
    editor.move(x, y);
    const auto flown = [&](const json& s, int i) { return position(s, i) - position(before, i); };
    const json forward =
        editor.hold("w", "a metre of flight", [&](const json& s) { return std::hypot(flown(s, 0), flown(s, 2)) > 1; });
    // Where it looks: clockwise from north, where -z is.
    const double heading = before["camera"]["heading_rad"], far_m = std::hypot(flown(forward, 0), flown(forward, 2));
    CHECK(flown(forward, 0) == Approx(far_m * std::sin(heading)).margin(0.01));
    CHECK(flown(forward, 2) == Approx(-far_m * std::cos(heading)).margin(0.01));
    editor.wheel(3);
    const json faster = editor.until("more speed", [&](const json& s) {
        return s["camera"]["speed_m_s"].get<double>() > 1.5 * before["camera"]["speed_m_s"].get<double>();
    });
    // Dragging to the right and down looks to the right and down.
    editor.drag_at(x, y, x + 80, y + 20);
    const json looked = editor.state();
    CHECK(looked["camera"]["heading_rad"] > faster["camera"]["heading_rad"]);
    CHECK(looked["camera"]["pitch_rad"] < faster["camera"]["pitch_rad"]);
    // A panel's wheel scrolls, and letters that are typed steer nothing.
    editor.move(view.x / 2, view.y + view.height / 2);
    editor.wheel(-2);
    CHECK(editor.state()["camera"]["speed_m_s"] == looked["camera"]["speed_m_s"]);
    editor.wheel(4);
    editor.click("field.refine.max_error_px");
    editor.type("wwwdddeee");
    editor.key("Escape");
    CHECK(editor.state()["camera"]["position_m"] == looked["camera"]["position_m"]);
    editor.move(x, y);
    editor.key("f");
    editor.until("frozen", [](const json& s) { return s["camera"]["frozen"] == true; });
    editor.key("f");
    editor.until("free again", [](const json& s) { return s["camera"]["frozen"] == false; });
}

TEST_CASE("the window is resized: columns, picture and controls stay inside it, and the mesh keeps its promise") {
    if (no_windows()) return;
    SmallTerrain& terrain = SmallTerrain::shared(Pixels::drawn);
    EditorWindow& editor = terrain.editor;
    for (const auto& [width, height] : {std::pair{1700u, 900u}, {820u, 600u}, {1280u, 720u}}) {
        editor.resize(width, height);
        const json state = editor.until("its mesh", converged);
        const Place view = view_of(state);
        CAPTURE(width, height);
        CHECK(view.x + view.width <= width);
        CHECK(view.y + view.height <= height);
        CHECK(view.width > 200);
        int controls = 0;
        for (const auto& [name, m] : state["marks"].items()) {
            if (name.starts_with("panel.") || name.starts_with("menu.")) {
                INFO(name << " " << m.dump());
                CHECK(m[0].get<double>() + m[2].get<double>() <= width + 0.5);
                ++controls;
            }
        }
        CHECK(controls >= 12); // 7 panels, 5 menus
        CHECK(colours_in(terrain.screen.picture(), view) > 300);
    }
    editor.resize(600, 360);
}

TEST_CASE("quitting asks about unsaved changes, and a crash does not lose them") {
    if (no_windows()) return;
    const TemporaryFolder home;
    const std::string profile = home / "mine.toml";
    spit(profile, slurp(FJELL_SOURCE_DIR "/profiles/tiny.toml"));
    const std::string original = slurp(profile);
    const std::vector<std::string> arguments{small_pack(), "--profile", profile,   "--size",
                                             small_window, "--scale",   half_scale};
    const auto change = [](EditorWindow& editor) {
        editor.key("bracketright");
        return editor.until("a change", [](const json& s) { return s["document"]["unsaved"] == true; });
    };
    {
        EditorWindow editor(display(), home.path, arguments, Pixels::unseen);
        const json changed = change(editor)["profile"]["refine.max_error_px"];
        editor.key("ctrl+q");
        editor.until("the question", shows_dialog("unsaved"));
        editor.key("Escape");
        editor.until("no question", shows_dialog("none"));
        CHECK(slurp(profile) == original);
        editor.key("ctrl+q");
        editor.until("the question", shows_dialog("unsaved"));
        editor.key("Return"); // saves
        CHECK(editor.exit_code() == 0);
        CHECK(slurp(profile).find("max_error_px = " + changed.dump()) != std::string::npos);
    }
    const std::string saved = slurp(profile);
    CHECK(saved != original);
    json lost;
    {
        EditorWindow editor(display(), home.path, arguments, Pixels::unseen);
        lost = change(editor)["profile"]["refine.max_error_px"];
        editor.until("changes kept for a crash", [](const json& s) { return s["files"]["recovery_file"] != ""; });
        editor.signal(SIGKILL);
        CHECK(editor.exit_code() == 128 + SIGKILL);
        CHECK(slurp(profile) == saved);
    }
    EditorWindow editor(display(), home.path, arguments, Pixels::unseen);
    editor.until("what an earlier run left", shows_dialog("recover"));
    editor.click("answer.restore");
    editor.until("the change again", [&](const json& s) {
        return s["document"]["unsaved"] == true && s["profile"]["refine.max_error_px"] == lost;
    });
    editor.key("ctrl+q");
    editor.click("answer.discard");
    CHECK(editor.exit_code() == 0);
    CHECK(slurp(profile) == saved);
}

TEST_CASE("a corrupt pack, a folder that takes nothing and a lost graphics context are messages, and work goes on") {
    if (no_windows()) return;
    const TemporaryFolder home;
    std::string damaged = slurp(small_pack());
    for (std::size_t i = 0; i < 64; ++i) damaged[i * 7 + 8] ^= 0x55;
    spit(home / "damaged.fjell", damaged);
    EditorWindow editor(display(), home.path,
                        {small_pack(), "--size", small_window, "--scale", half_scale, "--do", "frames 2", "--do",
                         "open " + home / "damaged.fjell", "--do", "set refine.max_error_px 3", "--do",
                         "save-profile /proc/none.toml", "--do", "lose-graphics", "--do", "wait"});
    const json state = editor.until("the script's end", [](const json& s) {
        return s["messages"].size() >= 3 && s["measures"]["converged"] == true;
    });
    const std::string messages = state["messages"].dump();
    INFO(messages);
    CHECK(messages.find("damaged.fjell") != std::string::npos);
    CHECK(messages.find("/proc/none.toml") != std::string::npos);
    CHECK(messages.find("recreated") != std::string::npos);
    CHECK(state["scene"]["path"] == small_pack());
    CHECK(state["document"]["unsaved"] == true);
    CHECK(state["measures"]["error_px_asked"] == 3);
    // And there is a window, which shows the terrain and listens.
    editor.find();
    editor.move(5, 5);
    CHECK(colours_in(display().picture(), view_of(state)) > 500);
    editor.key("ctrl+z");
    editor.until("undone", [](const json& s) { return s["profile"]["refine.max_error_px"] == 1; });
}

TEST_CASE("a dialog has the keyboard, nothing beneath it reacts, and escape closes it, but first what is typed") {
    if (no_windows()) return;
    SmallTerrain& terrain = SmallTerrain::shared(Pixels::unseen);
    EditorWindow& editor = terrain.editor;
    editor.key("F1");
    editor.until("the keys", shows_dialog("keys"));
    editor.key("Escape");
    const json before = editor.until("no dialog", shows_dialog("none"));
    const Place panel = editor.place("panel.view");
    editor.key("ctrl+o");
    editor.until("the file dialog", shows_dialog("open"));
    editor.click_at(panel.x + panel.width / 2, panel.y + panel.height / 2);
    editor.wheel(2);
    editor.key("bracketright");
    json beneath = editor.state();
    CHECK(beneath["interface"]["left"] == "tune");
    CHECK(beneath["interface"]["dialog"] == "open");
    CHECK(beneath["profile"] == before["profile"]);
    CHECK(beneath["camera"]["speed_m_s"] == before["camera"]["speed_m_s"]);
    const std::string folder = beneath["files"]["folder"];
    editor.click_twice("file..."); // both clicks between two frames, most likely
    editor.until("the folder above", [&](const json& s) { return s["files"]["folder"] != folder; });
    editor.key("Escape");
    editor.until("no dialog", shows_dialog("none"));
    editor.key("ctrl+o"); // its first field has the keyboard
    editor.key("a");
    editor.key("Escape");
    CHECK(editor.state()["interface"]["dialog"] == "open");
    editor.key("Escape");
    editor.until("no dialog", shows_dialog("none"));
}

TEST_CASE("panels hide, fold and are resized by hand, and the next run looks as this one did") {
    if (no_windows()) return;
    const TemporaryFolder home;
    json last;
    {
        EditorWindow editor(display(), home.path, {small_pack(), "--size", small_window, "--scale", half_scale},
                            Pixels::unseen);
        const json before = editor.until("a picture", converged);
        const Place view = view_of(before), strip = editor.place("handle.left-column");
        CHECK(view.width >= 0.65 * 600);
        editor.key("Tab");
        editor.until("no panels", [](const json& s) { return s["interface"]["view_px"][2] == 600; });
        editor.key("Tab");
        editor.key("F11");
        editor.until("the picture alone", [](const json& s) { return s["interface"]["view_px"][3] == 320; });
        editor.key("Escape");
        const json again = editor.until(
            "all of it", [&](const json& s) { return s["interface"]["view_px"] == before["interface"]["view_px"]; });
        const double x = strip.x + strip.width / 2, y = strip.y + strip.height / 2;
        editor.drag_at(x, y, x + 40, y);
        last = editor.until("a wider column", [&](const json& s) {
            return s["interface"]["columns"][0]["width_px"] > 325 + 70 && view_of(s).width < view.width - 35;
        });
        editor.key("m");
        editor.click_at(x + 40, y);
        editor.until("a folded column", [&](const json& s) { return view_of(s).width > view.width; });
        editor.resize(640, 330);
        editor.click_at(3, y); // unfolded
        const Place tab = editor.place("panel.cost");
        editor.drag_at(tab.x + tab.width / 2, tab.y + tab.height / 2, 420, 60);
        last = editor.until("a floating panel", [](const json& s) {
            return s["interface"]["floating"].contains("cost") && s["marks"].contains("floating.cost") &&
                   !s["marks"].contains("panel.cost");
        });
        editor.click("handle.left-column");
        last = editor.until("a folded column", [&](const json& s) { return view_of(s).width > view.width; });
        editor.key("ctrl+q");
        CHECK(editor.exit_code() == 0);
    }
    EditorWindow editor(display(), home.path, {small_pack(), "--scale", half_scale}, Pixels::unseen);
    const json next = editor.until("a picture", converged);
    for (const char* key : {"columns", "floating", "window_px", "view_px", "mode"})
        CHECK(next["interface"][key] == last["interface"][key]);
    editor.click("handle.left-column");
    const Place title = editor.place("floating.cost"); // it is dropped back into its column
    editor.drag_at(title.x + title.width / 2, title.y + title.height / 2, 60, 160);
    editor.until("a tab again",
                 [](const json& s) { return s["interface"]["floating"].empty() && s["marks"].contains("panel.cost"); });
    CHECK(next["messages"].empty());
}

TEST_CASE("a pack that is opened over another one compiles no shader on the frame's thread, and looks the same") {
    if (no_windows()) return;
    const TemporaryFolder home;
    const std::string other = home / "other.fjell";
    std::filesystem::copy_file(small_pack(), other);
    EditorWindow editor(display(), home.path,
                        {small_pack(),
                         "--size",
                         small_window,
                         "--scale",
                         half_scale,
                         "--do",
                         "wait",
                         "--do",
                         "screenshot " + home / "first.png" + " terrain",
                         "--do",
                         "dump " + home / "first.json",
                         "--do",
                         "open " + other,
                         "--do",
                         "wait",
                         "--do",
                         "screenshot " + home / "second.png" + " terrain",
                         "--do",
                         "dump " + home / "second.json",
                         "--do",
                         "quit discard"});
    CHECK(editor.exit_code() == 0);
    const json first = json::parse(slurp(home / "first.json")), second = json::parse(slurp(home / "second.json"));
    CHECK(second["scene"]["path"] == other);
    CHECK(second["terrain_draws"] > first["terrain_draws"]);
    CHECK(first["programs"] > 0); // the first one is waited for: nothing else is there to be shown
    CHECK(second["programs"] == first["programs"]);
    CHECK(slurp(home / "second.png") == slurp(home / "first.png"));
}

TEST_CASE("an editor at rest draws nothing, and what moves in its panels alone draws no terrain") {
    if (no_windows()) return;
    SmallTerrain& terrain = SmallTerrain::shared(Pixels::unseen);
    EditorWindow& editor = terrain.editor;
    editor.until("a picture", converged);
    const json at_rest = editor.until("rest", [](const json& s) { return s["rested_s"] > 0.05; });
    editor.click("panel.view");
    editor.key("F1");
    const json after = editor.until("the keys", shows_dialog("keys"));
    CHECK(after["frame"] > at_rest["frame"]);
    CHECK(after["terrain_draws"] == at_rest["terrain_draws"]);
    editor.until("rest again", [&](const json& s) { return s["rested_s"] > after["rested_s"]; });
    editor.key("Escape");
    editor.key("m"); // another mode is another picture
    editor.until("a picture of it", [&](const json& s) { return s["terrain_draws"] > at_rest["terrain_draws"]; });
    editor.key("shift+m");
}

TEST_CASE("a click on the overview jumps there") {
    if (no_windows()) return;
    SmallTerrain& terrain = SmallTerrain::shared(Pixels::unseen);
    EditorWindow& editor = terrain.editor;
    editor.click("panel.view");
    const json before = editor.until("the overview", [](const json& s) { return s["marks"].contains("map.overview"); });
    const Place overview = editor.place("map.overview");
    editor.click_at(overview.x + 0.25 * overview.width, overview.y + 0.75 * overview.height);
    const json after = editor.until(
        "a jump", [&](const json& s) { return s["camera"]["position_m"] != before["camera"]["position_m"]; });
    const double width_m = 512 * after["scene"]["spacing_m"][0].get<double>();
    CHECK(after["camera"]["position_m"][0].get<double>() == Approx(0.25 * width_m).margin(0.02 * width_m));
    CHECK(after["camera"]["position_m"][2].get<double>() == Approx(0.75 * width_m).margin(0.02 * width_m));
    CHECK(after["camera"]["heading_rad"] == before["camera"]["heading_rad"]);
}

TEST_CASE("the probe follows the pointer, clicks mark two places and move no camera, and escape ends it") {
    if (!full_rounds() || no_windows()) return; // what it tells is tested without a window
    SmallTerrain& terrain = SmallTerrain::shared(Pixels::unseen);
    EditorWindow& editor = terrain.editor;
    const json before = editor.until("a converged mesh", converged);
    editor.key("i");
    const Place view = view_of(before);
    const auto mesh_there = [](const json& s) {
        return s["probe"].contains("ground") && s["probe"]["ground"].contains("mesh");
    };
    editor.move(view.x + 0.3 * view.width, view.y + 0.9 * view.height);
    const json first = editor.until("the ground there", mesh_there);
    CHECK(first["probe"]["ground"]["mesh"]["error_px"] <= before["measures"]["error_px_effective"]);
    editor.click_at(view.x + 0.3 * view.width, view.y + 0.9 * view.height);
    CHECK(editor.state()["probe"]["marks"].size() == 1);
    editor.click_at(view.x + 0.7 * view.width, view.y + 0.8 * view.height);
    const json second = editor.until("another place", [](const json& s) { return s["probe"]["marks"].size() == 2; });
    CHECK(second["probe"]["marks"][0][0] == first["probe"]["ground"]["position_m"][0]);
    CHECK(second["probe"]["profile"]["length_m"] > 0);
    CHECK(second["camera"]["position_m"] == before["camera"]["position_m"]);
    CHECK(second["camera"]["heading_rad"] == before["camera"]["heading_rad"]);
    CHECK(second["terrain_draws"] == first["terrain_draws"]); // it lies over the picture that is there
    editor.key("Escape");
    CHECK(editor.state()["probe"]["on"] == false);
}

TEST_CASE("a drag over a graph zooms and holds it, a click on it reports a frame, and a key goes on") {
    if (!full_rounds() || no_windows()) return; // what the commands do is tested without a window
    SmallTerrain terrain(Pixels::unseen, "600x600");
    EditorWindow& editor = terrain.editor;
    editor.until("a converged mesh", converged);
    editor.click("panel.cost");
    editor.click("group.cost.budgets"); // folded
    editor.click("group.cost.time");
    editor.hold("d", "some measured frames", [](const json& s) { return s["measures"]["recorded"] > 24; });
    editor.until("a converged mesh", converged);
    editor.drag("graph.update", 0.6, 0.3); // no frame is there yet
    CHECK(editor.state()["measures"]["held"] == false);
    editor.drag("graph.update", 0.998, 0.5);
    const json zoomed = editor.state();
    CHECK(zoomed["measures"]["held"] == true);
    CHECK(zoomed["measures"]["graphs"][0] == zoomed["measures"]["recorded"].get<int>() - 1);
    CHECK(zoomed["measures"]["graphs"][1] < 8);
    CHECK(zoomed["measures"]["chosen"].is_null());
    editor.click("graphs.whole");
    CHECK(editor.state()["measures"]["graphs"] == json({511, 0}));
    editor.key("t");
    CHECK(editor.state()["measures"]["held"] == false);
    const Place graph = editor.place("graph.update");
    editor.click_at(graph.x + 0.99 * graph.width, graph.y + 0.6 * graph.height);
    CHECK(editor.state()["measures"]["chosen"]["ago"] <= 12);
}
