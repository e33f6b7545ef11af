// The camera path under the mouse, in the real window: its points in the timeline, in the picture and on the overview.
#include <catch2/catch.hpp>

#include <cmath>
#include <string>
#include <vector>

#include "support/editor_pack.h"
#include "support/editor_window.h"
#include "support/program.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;
using nlohmann::json;

namespace {

// In brief rounds the commands' tests stand for these.
bool left_out() {
    if (!full_rounds()) return true;
    const std::string why = why_no_windows();
    if (!why.empty()) WARN("skipped: " << why);
    return !why.empty();
}

// Over the small pack's 30 km, above its highest summit; all stretches are as long.
constexpr const char* zigzag = R"({"points": [
  {"position": [6000, 4000, 15000], "direction": [1, -0.2, 0]},
  {"position": [11000, 4000, 19000], "direction": [1, -0.2, 0]},
  {"position": [16000, 4000, 15000], "direction": [1, -0.2, 0]},
  {"position": [21000, 4000, 19000], "direction": [1, -0.2, 0]},
  {"position": [26000, 4000, 15000], "direction": [1, -0.2, 0]}]})";

struct PathWindow {
    explicit PathWindow(Pixels pixels) : editor(display, home.path, arguments(home), pixels) {
        state = editor.until("a converged mesh", [](const json& s) { return s["measures"]["converged"] == true; });
        camera = state["camera"];
    }

    static std::vector<std::string> arguments(const TemporaryFolder& home) {
        spit(home / "zigzag.json", zigzag);
        return {
            small_pack(),        "--size", "1000x840",       "--scale", "0.7", "--path", home / "zigzag.json", "--do",
            "group view.map on", "--do",   "panel pictures", "--do",    "home"};
    }
    // The overview is in another panel than the timeline.
    void show(const std::string& panel) {
        if (editor.state()["interface"]["left"] != panel) editor.click("panel." + panel);
    }
    // The middle of what has that mark. What is in the picture can be taken while the pointer is there.
    [[nodiscard]] std::array<double, 2> middle(const std::string& mark) {
        const Place view = view_of(state);
        if (mark.starts_with("map.")) show("view");
        if (mark.starts_with("timeline.")) show("pictures");
        if (mark.starts_with("view.")) editor.move(view.x + 5, view.y + 5);
        const Place p = editor.place(mark);
        return {p.x + p.width / 2, p.y + p.height / 2};
    }
    // That many steps more than at first, and the camera where it was.
    void check_steps(int steps) {
        state = editor.state();
        CHECK(state["route"]["undo"] == steps);
        CHECK(state["camera"]["position_m"] == camera["position_m"]);
        CHECK(state["camera"]["heading_rad"] == camera["heading_rad"]);
    }

    VirtualDisplay display{1024, 860};
    TemporaryFolder home;
    EditorWindow editor;
    json state, camera; // camera: at first
};

} // namespace

TEST_CASE("a point is dragged in the picture: level under the pointer, with Shift up and down, and the camera stays") {
    if (left_out()) return;
    PathWindow w(Pixels::drawn);
    const gl::Image bare = w.display.picture();
    const auto at = w.middle("view.point.1");
    const double to_x = at[0] + 50, to_y = at[1] + 15;
    w.editor.drag_at(at[0], at[1], to_x, to_y);
    w.check_steps(1);
    const json level = w.state["route"]["selected_m"];
    CHECK(w.state["route"]["selected"] == 1);
    CHECK(level[1] == 4000);
    CHECK(level[0].get<double>() > 11500);
    CHECK(level[2].get<double>() > 19000);
    const auto moved = w.middle("view.point.1");
    CHECK(std::abs(moved[0] - to_x) < 1.5); // pointers move by whole pixels
    CHECK(std::abs(moved[1] - to_y) < 1.5);
    CHECK(changed(bare, w.display.picture(), view_of(w.state)) > 0.001);
    bool dragged = false;
    w.editor.hold("shift", "the point elsewhere", [&](const json& s) {
        if (!dragged) w.editor.drag_at(moved[0], moved[1], moved[0], moved[1] - 40);
        dragged = true;
        return s["route"]["selected_m"] != level;
    });
    w.check_steps(2);
    const json high = w.state["route"]["selected_m"];
    CHECK(high[0] == level[0]);
    CHECK(high[2] == level[2]);
    CHECK(high[1].get<double>() > 4100);
    CHECK(std::abs(w.middle("view.point.1")[1] - (moved[1] - 40)) < 1.5);
    w.editor.key("ctrl+z");
    CHECK(w.editor.state()["route"]["selected_m"] == level);
    w.editor.key("ctrl+z");
    w.check_steps(0);
    CHECK(w.state["route"]["unsaved"] == false);
}

TEST_CASE("a point is dragged on the overview, selected by a click in all three places, removed and inserted by keys") {
    if (left_out()) return;
    PathWindow w(Pixels::unseen);
    const auto at = w.middle("map.point.3");
    w.editor.drag_at(at[0], at[1], at[0] - 12, at[1] + 9);
    w.check_steps(1);
    CHECK(w.state["route"]["selected"] == 3);
    CHECK(w.state["route"]["selected_m"][0].get<double>() < 21000);
    CHECK(w.state["route"]["selected_m"][2].get<double>() > 19000);
    for (const auto& [mark, point] : {std::pair{"timeline.point.4", 4}, {"view.point.0", 0}, {"map.point.2", 2}}) {
        const auto there = w.middle(mark);
        w.editor.click_at(there[0], there[1]);
        w.check_steps(1); // and the camera has not moved
        CHECK(w.state["route"]["selected"] == point);
    }
    w.editor.key("Delete");
    w.state = w.editor.state();
    CHECK(w.state["route"]["points"] == 4);
    w.show("pictures");
    const Place line = w.editor.place("path.timeline");
    w.editor.click_at(line.x + 0.5 * line.width, line.y + 0.72 * line.height); // the playhead
    w.editor.key("Insert");
    w.state = w.editor.state();
    CHECK(w.state["route"]["points"] == 5);
    CHECK(w.state["route"]["selected"] == 2);
    CHECK(w.state["route"]["selected_m"][0].get<double>() == Approx(16000).margin(30000 * 1.5 / line.width));
    for (int i = 0; i < 3; ++i) w.editor.key("ctrl+z");
    CHECK(w.editor.state()["route"]["undo"] == 0);
}

TEST_CASE("by keys alone a point is selected in the timeline, looked from and removed") {
    if (left_out()) return;
    PathWindow w(Pixels::unseen);
    for (int pane = 0; !w.editor.state()["marks"].contains("path.timeline") || pane == 0; ++pane) {
        REQUIRE(pane < 6);
        w.editor.key("F6");
        if (w.editor.state()["interface"]["focus"] == "navigate.fly") break;
    }
    w.editor.go_to("path.timeline");
    for (int i = 0; i < 3; ++i) w.editor.key("Right"); // none is selected: the first, then the next
    w.check_steps(0);
    CHECK(w.state["route"]["selected"] == 2);
    w.editor.key("Left");
    w.editor.key("Right");
    CHECK(w.state["interface"]["focus"] == "path.timeline");
    w.editor.key("Return");
    w.state = w.editor.state();
    CHECK(w.state["camera"]["position_m"][0] == Approx(16000));
    w.editor.key("Delete");
    CHECK(w.editor.state()["route"]["points"] == 4);
    CHECK(w.editor.state()["input"]["buttons"] == 0);
}
