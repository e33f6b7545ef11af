// The real window, driven as by hand. Every case has its own X server, so cases may run side by side.
#include <catch2/catch.hpp>

#include <chrono>
#include <cmath>
#include <csignal>
#include <set>
#include <thread>

#include "support/editor_window.h"
#include "support/program.h"

using namespace fjell;
using namespace fjell::test;
using nlohmann::json;

namespace {

const TemporaryFolder& packs() {
    static const TemporaryFolder folder;
    static const bool made = [] {
        const Run r =
            run_in(folder.path, FJELL_BIN_DIR "/fjell-bake " FJELL_SOURCE_DIR
                                              "/content/terrain/mountains-small.json -o small.fjell --tile 64");
        INFO(r.err);
        REQUIRE(r.code == 0);
        return true;
    }();
    (void)made;
    return folder;
}

bool no_windows() {
    const std::string why = why_no_windows();
    if (!why.empty()) WARN("skipped: " << why);
    return !why.empty();
}

// An editor over the small terrain, in a home of its own.
struct Desk {
    VirtualDisplay display;
    TemporaryFolder home;
    EditorWindow editor;

    explicit Desk(std::vector<std::string> more = {}, std::uint32_t width = 1280, std::uint32_t height = 720)
        : display(1920, 1080), editor(display, home.path, [&] {
              std::vector<std::string> all{packs() / "small.fjell", "--size",
                                           std::to_string(width) + "x" + std::to_string(height)};
              all.insert(all.end(), more.begin(), more.end());
              return all;
          }()) {}
};

Place view_of(const json& state) {
    const json& v = state["interface"]["view_px"];
    return {v[0], v[1], v[2], v[3]};
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

// Share of the pixels of a place that differ by more than a little.
double changed(const gl::Image& a, const gl::Image& b, const Place& p) {
    std::size_t differ = 0, all = 0;
    for (auto y = static_cast<std::uint32_t>(p.y); y < static_cast<std::uint32_t>(p.y + p.height); ++y)
        for (auto x = static_cast<std::uint32_t>(p.x); x < static_cast<std::uint32_t>(p.x + p.width); ++x, ++all) {
            const std::uint8_t *c = a.pixel(x, y), *d = b.pixel(x, y);
            differ += std::abs(c[0] - d[0]) + std::abs(c[1] - d[1]) + std::abs(c[2] - d[2]) > 24;
        }
    return static_cast<double>(differ) / static_cast<double>(all);
}

} // namespace

TEST_CASE("dragging the threshold's slider coarsens the mesh at once, as one step that can be undone") {
    if (no_windows()) return;
    Desk desk;
    const json before =
        desk.editor.until("a converged mesh", [](const json& s) { return s["measures"]["converged"] == true; });
    const gl::Image fine = desk.display.picture();
    CHECK(colours_in(fine, view_of(before)) > 500); // a landscape, not a blank
    desk.editor.drag("refine.error_px", 0.42, 0.8);
    const json after = desk.editor.until("a coarser mesh", [&](const json& s) {
        return s["profile"]["refine.error_px"] > 4 && s["measures"]["converged"] == true &&
               s["measures"]["vertices"] < before["measures"]["vertices"];
    });
    CHECK(after["document"]["unsaved"] == true);
    CHECK(after["document"]["undo"] == 1);
    CHECK(after["measures"]["error_px_asked"] == after["profile"]["refine.error_px"]);
    CHECK(changed(fine, desk.display.picture(), view_of(after)) > 0.01);
    desk.editor.key("ctrl+z");
    const json back = desk.editor.until("the old mesh", [&](const json& s) {
        return s["document"]["undo"] == 0 && s["measures"]["converged"] == true &&
               s["measures"]["vertices"] == before["measures"]["vertices"];
    });
    CHECK(back["profile"] == before["profile"]);
    CHECK(back["document"]["unsaved"] == false);
}

TEST_CASE("a number is typed beside the slider, and one out of range does no harm") {
    if (no_windows()) return;
    Desk desk;
    const auto enter = [&](const std::string& text) {
        desk.editor.click("field.refine.error_px");
        desk.editor.key("ctrl+a");
        desk.editor.type(text);
        desk.editor.key("Return");
    };
    enter("7.5");
    desk.editor.until("7.5 px", [](const json& s) {
        return s["profile"]["refine.error_px"] == 7.5 && s["measures"]["error_px_asked"] == 7.5;
    });
    enter("123456");
    desk.editor.until("the largest there is, or what it was", [](const json& s) {
        return s["profile"]["refine.error_px"] == 1000 || s["profile"]["refine.error_px"] == 7.5;
    });
    enter("nonsense");
    const json after = desk.editor.state();
    CHECK(after["profile"]["refine.error_px"].get<double>() >= 7.5);
    CHECK(desk.editor.runs());
}

TEST_CASE("clicks turn to panels, pictures and overlays, which show in the picture and nowhere else") {
    if (no_windows()) return;
    Desk desk;
    desk.editor.click("panel.show");
    json state = desk.editor.until("the panel", [](const json& s) { return s["interface"]["left"] == "show"; });
    const Place view = view_of(state);
    desk.editor.move(view.x + view.width / 2, view.y + view.height / 2); // no tip over the picture
    gl::Image before = desk.display.picture();
    desk.editor.click("overlay.wireframe");
    desk.editor.until("wires", [](const json& s) { return s["interface"]["overlay"]["wireframe"] == true; });
    desk.editor.move(view.x + view.width / 2, view.y + view.height / 2);
    gl::Image after = desk.display.picture();
    CHECK(changed(before, after, view) > 0.05);
    CHECK(changed(before, after, {0, view.y, view.x, view.height}) < 0.02); // a tick, no more
    desk.editor.click("overlay.wireframe");
    desk.editor.click("mode.levels");
    desk.editor.until("levels", [](const json& s) { return s["interface"]["mode"] == "levels"; });
    desk.editor.move(view.x + view.width / 2, view.y + view.height / 2);
    CHECK(changed(before, desk.display.picture(), view) > 0.3);
}

TEST_CASE("keys and the mouse move the camera, but not while a number is typed or a panel is under the pointer") {
    if (no_windows()) return;
    Desk desk;
    const json before =
        desk.editor.until("a picture", [](const json& s) { return s["measures"]["converged"] == true; });
    const Place view = view_of(before);
    const double x = view.x + view.width / 2, y = view.y + view.height / 2;
    const auto position = [](const json& s, int i) {
        return s["camera"]["position_m"][static_cast<std::size_t>(i)].get<double>();
    };
    desk.editor.move(x, y);
    desk.editor.hold("w", 0.6);
    const json forward = desk.editor.state();
    CHECK(position(forward, 2) < position(before, 2) - 1); // north is -z
    desk.editor.wheel(3);
    const json faster = desk.editor.until("more speed", [&](const json& s) {
        return s["camera"]["speed_m_s"].get<double>() > 1.5 * before["camera"]["speed_m_s"].get<double>();
    });
    // Looking: to the right turns right.
    desk.editor.drag_at(x, y, x + 80, y + 20);
    const json looked = desk.editor.state();
    CHECK(looked["camera"]["heading_rad"] != faster["camera"]["heading_rad"]);
    CHECK(looked["camera"]["pitch_rad"] != faster["camera"]["pitch_rad"]);
    // A panel's wheel scrolls, and letters that are typed steer nothing.
    desk.editor.move(view.x / 2, view.y + view.height / 2);
    desk.editor.wheel(-2);
    CHECK(desk.editor.state()["camera"]["speed_m_s"] == looked["camera"]["speed_m_s"]);
    desk.editor.wheel(4);
    desk.editor.click("field.refine.error_px");
    desk.editor.type("wwwdddeee");
    desk.editor.key("Escape");
    CHECK(desk.editor.state()["camera"]["position_m"] == looked["camera"]["position_m"]);
    desk.editor.move(x, y);
    desk.editor.key("f");
    desk.editor.until("frozen", [](const json& s) { return s["camera"]["frozen"] == true; });
    desk.editor.key("f");
    desk.editor.until("free again", [](const json& s) { return s["camera"]["frozen"] == false; });
}

TEST_CASE("the window is resized: columns, picture and controls stay inside it, and the mesh keeps its promise") {
    if (no_windows()) return;
    Desk desk;
    for (const auto& [width, height] : {std::pair{1700u, 900u}, {820u, 600u}, {1280u, 720u}}) {
        desk.editor.resize(width, height);
        const json state = desk.editor.until("the new size", [&](const json& s) {
            return s["interface"]["window_px"] == json{width, height} && s["measures"]["converged"] == true;
        });
        const Place view = view_of(state);
        CAPTURE(width, height);
        CHECK(view.x + view.width <= width);
        CHECK(view.y + view.height <= height);
        CHECK(view.width > 200);
        for (const auto& [name, m] : state["marks"].items()) {
            if (name.starts_with("panel.") || name.starts_with("menu.")) {
                INFO(name << " " << m.dump());
                CHECK(m[0].get<double>() + m[2].get<double>() <= width + 0.5);
            }
        }
        CHECK(colours_in(desk.display.picture(), view) > 300);
    }
}

TEST_CASE("budgets and methods are made anew under the same view, and what cannot be had is taken back") {
    if (no_windows()) return;
    Desk desk;
    const json before =
        desk.editor.until("a picture", [](const json& s) { return s["measures"]["converged"] == true; });
    const auto enter = [&](const std::string& field, const std::string& text) {
        desk.editor.click("field." + field);
        desk.editor.key("ctrl+a");
        desk.editor.type(text);
        desk.editor.key("Return");
    };
    enter("budget.vertices", "3000");
    const json small = desk.editor.until("a smaller block", [&](const json& s) {
        return s["profile"]["budget.vertices"] == 3000 && s["scene"]["method_bytes"] < before["scene"]["method_bytes"];
    });
    CHECK(small["camera"]["position_m"] == before["camera"]["position_m"]);
    desk.editor.until("the budget to tell", [](const json& s) { return s["measures"]["error_px_effective"] > 1.0; });
    enter("budget.vertices", "16"); // not even the corners of its tiles
    const json refused = desk.editor.until("a message", [](const json& s) { return !s["messages"].empty(); });
    CHECK(refused["profile"]["budget.vertices"] == 3000);
    CHECK(refused["measures"]["triangles"] > 0);
    desk.editor.key("ctrl+z");
    desk.editor.until("all of it again", [&](const json& s) {
        return s["profile"] == before["profile"] && s["measures"]["converged"] == true &&
               s["measures"]["vertices"] == before["measures"]["vertices"];
    });
}

TEST_CASE("unsaved changes are asked about, saved, or recovered after a crash") {
    if (no_windows()) return;
    const TemporaryFolder home;
    const VirtualDisplay display(1280, 800);
    const std::string profile = home / "mine.toml";
    spit(profile, slurp(FJELL_SOURCE_DIR "/profiles/tiny.toml"));
    const std::string original = slurp(profile);
    const std::vector<std::string> arguments{packs() / "small.fjell", "--profile", profile};
    const auto change = [](EditorWindow& editor) {
        editor.key("bracketright");
        editor.until("a change", [](const json& s) { return s["document"]["unsaved"] == true; });
    };
    {
        EditorWindow editor(display, home.path, arguments);
        change(editor);
        editor.key("ctrl+q");
        editor.until("the question", [](const json& s) { return s["interface"]["dialog"] == "unsaved"; });
        editor.click("answer.cancel");
        editor.until("no question", [](const json& s) { return s["interface"]["dialog"] == "none"; });
        editor.key("ctrl+q");
        editor.click("answer.save");
        CHECK(editor.exit_code() == 0);
        CHECK(slurp(profile) != original);
    }
    const std::string saved = slurp(profile);
    {
        EditorWindow editor(display, home.path, arguments);
        change(editor);
        std::this_thread::sleep_for(std::chrono::seconds(4)); // it notes changes every 2 s
        editor.signal(SIGKILL);
        (void)editor.exit_code();
        CHECK(slurp(profile) == saved);
    }
    EditorWindow editor(display, home.path, arguments);
    editor.until("what an earlier run left", [](const json& s) { return s["interface"]["dialog"] == "recover"; });
    editor.click("answer.restore");
    editor.until("the change again", [](const json& s) { return s["document"]["unsaved"] == true; });
    editor.key("ctrl+q");
    editor.click("answer.discard");
    CHECK(editor.exit_code() == 0);
    CHECK(slurp(profile) == saved);
}

TEST_CASE("a corrupt pack, a folder that takes nothing and a lost graphics context are messages, and work goes on") {
    if (no_windows()) return;
    const TemporaryFolder home;
    const VirtualDisplay display(1280, 800);
    std::string damaged = slurp(packs() / "small.fjell");
    for (std::size_t i = 0; i < 64; ++i) damaged[i * 7 + 8] ^= 0x55;
    spit(home / "damaged.fjell", damaged);
    EditorWindow editor(display, home.path,
                        {packs() / "small.fjell", "--do", "frames 80", "--do", "open " + home / "damaged.fjell", "--do",
                         "set refine.error_px 3", "--do", "save-profile /proc/none.toml", "--do", "lose-graphics",
                         "--do", "wait"});
    const json state = editor.until("the script's end", [](const json& s) {
        return s["messages"].size() >= 3 && s["measures"]["converged"] == true;
    });
    const std::string messages = state["messages"].dump();
    INFO(messages);
    CHECK(messages.find("damaged.fjell") != std::string::npos);
    CHECK(messages.find("/proc/none.toml") != std::string::npos);
    CHECK(messages.find("made anew") != std::string::npos);
    CHECK(state["scene"]["path"] == packs() / "small.fjell");
    CHECK(state["document"]["unsaved"] == true);
    CHECK(state["measures"]["error_px_asked"] == 3);
    // And there is a window, which shows the terrain and listens.
    editor.find();
    editor.move(5, 5);
    CHECK(colours_in(display.picture(), view_of(state)) > 500);
    editor.key("ctrl+z");
    editor.until("undone", [](const json& s) { return s["profile"]["refine.error_px"] == 1; });
}

TEST_CASE("escape closes a dialogue, but first what is being typed in it") {
    if (no_windows()) return;
    Desk desk;
    const auto dialog = [](const char* name) {
        return [name](const json& s) { return s["interface"]["dialog"] == name; };
    };
    desk.editor.key("F1");
    desk.editor.until("the keys", dialog("keys"));
    desk.editor.key("Escape");
    desk.editor.until("no dialogue", dialog("none"));
    desk.editor.key("ctrl+o");
    desk.editor.until("the file dialogue", dialog("open"));
    desk.editor.click("browse.name");
    desk.editor.key("a");
    desk.editor.key("Escape");
    CHECK(desk.editor.state()["interface"]["dialog"] == "open");
    desk.editor.key("Escape");
    desk.editor.until("no dialogue", dialog("none"));
}

TEST_CASE("a click on the map jumps there") {
    if (no_windows()) return;
    Desk desk;
    desk.editor.click("panel.camera");
    const json before = desk.editor.until("the map", [](const json& s) { return s["marks"].contains("map.overview"); });
    const Place map = desk.editor.place("map.overview");
    desk.editor.click_at(map.x + 0.25 * map.width, map.y + 0.75 * map.height);
    const json after = desk.editor.until(
        "a jump", [&](const json& s) { return s["camera"]["position_m"] != before["camera"]["position_m"]; });
    const double width_m = 512 * after["scene"]["spacing_m"][0].get<double>();
    CHECK(after["camera"]["position_m"][0].get<double>() == Approx(0.25 * width_m).margin(0.02 * width_m));
    CHECK(after["camera"]["position_m"][2].get<double>() == Approx(0.75 * width_m).margin(0.02 * width_m));
    CHECK(after["camera"]["heading_rad"] == before["camera"]["heading_rad"]);
}
