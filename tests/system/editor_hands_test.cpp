// What the hand takes hold of in the picture and in the timeline, in the real window: commands have tests of their own.
#include <catch2/catch.hpp>

#include <cmath>
#include <csignal>
#include <filesystem>

#include "support/editor_pack.h"
#include "support/editor_window.h"
#include "support/program.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;
using nlohmann::json;

namespace {

// In brief rounds the commands' tests stand for these.
bool skipped() {
    if (!full_rounds()) return true;
    const std::string why = why_no_windows();
    if (!why.empty()) WARN("skipped: " << why);
    return !why.empty();
}

struct Hand {
    explicit Hand(const std::vector<std::string>& more = {}) : editor(display, home.path, arguments(more)) {}

    static std::vector<std::string> arguments(const std::vector<std::string>& more) {
        std::vector<std::string> all{small_pack(), "--size", "600x480", "--scale", "0.5"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }

    // The state of a settled mesh, whose picture is on the screen.
    json settled() {
        return editor.until("a converged mesh", [](const json& s) { return s["measures"]["converged"] == true; });
    }

    VirtualDisplay display{640, 512};
    TemporaryFolder home;
    EditorWindow editor;
};

bool same_camera(const json& a, const json& b) {
    return a["camera"]["position_m"] == b["camera"]["position_m"] &&
           a["camera"]["heading_rad"] == b["camera"]["heading_rad"];
}

} // namespace

TEST_CASE("the divider follows the pointer, the camera stays, and each side shows its own threshold") {
    if (skipped()) return;
    Hand hand({"--do", "compare-picture 40"});
    EditorWindow& editor = hand.editor;
    const json before =
        editor.until("both pictures", [](const json& s) { return s["compared_picture"]["there"] == true; });
    (void)hand.settled();
    const gl::Image middle = hand.display.picture();
    const Place view = view_of(before), divider = editor.place("handle.divider");
    const double y = view.y + 0.6 * view.height, share = 0.25;
    editor.drag_at(divider.x + divider.width / 2, y, view.x + share * view.width, y);
    const json after = editor.state();
    // Pointers move by whole pixels.
    CHECK(after["compared_picture"]["divider"].get<double>() == Approx(share).margin(1.5 / view.width));
    CHECK(same_camera(after, before));
    const gl::Image moved = hand.display.picture();
    const Place passed{view.x + 0.3 * view.width, view.y + 0.3 * view.height, 0.15 * view.width, 0.6 * view.height};
    const Place left{view.x + 0.02 * view.width, passed.y, 0.18 * view.width, passed.height};
    CHECK(changed(middle, moved, passed) > 0.02); // now the other threshold
    CHECK(changed(middle, moved, left) == 0);
    CHECK(after["document"]["undo"] == before["document"]["undo"]); // a way of looking, no setting
}

TEST_CASE("with L held a drag moves the sun and not the camera, and one undo takes it back") {
    if (skipped()) return;
    Hand hand;
    EditorWindow& editor = hand.editor;
    const json before = hand.settled();
    const gl::Image lit = hand.display.picture();
    const Place view = view_of(before);
    const double x = view.x + 0.3 * view.width, y = view.y + 0.6 * view.height;
    bool dragged = false;
    editor.hold("l", "the sun elsewhere", [&](const json& s) {
        if (!dragged) editor.drag_at(x, y, x + 0.5 * view.width, y);
        dragged = true;
        return s["profile"]["light.azimuth_deg"] != before["profile"]["light.azimuth_deg"];
    });
    const json after = hand.settled();
    CHECK(after["profile"]["light.elevation_deg"] == before["profile"]["light.elevation_deg"]);
    CHECK(after["document"]["undo"] == 1); // however many frames the drag took
    CHECK(same_camera(after, before));
    CHECK(changed(lit, hand.display.picture(), view) > 0.05);
    editor.key("ctrl+z");
    CHECK(editor.state()["profile"] == before["profile"]);
}

TEST_CASE("two clicks with the probe mark two places and the profile between them is drawn over the picture") {
    if (skipped()) return;
    Hand hand;
    EditorWindow& editor = hand.editor;
    const json before = hand.settled();
    const gl::Image bare = hand.display.picture();
    const Place view = view_of(before);
    editor.key("i");
    editor.click_at(view.x + 0.3 * view.width, view.y + 0.9 * view.height);
    editor.click_at(view.x + 0.7 * view.width, view.y + 0.8 * view.height);
    const json after = editor.until("two places", [](const json& s) { return s["probe"]["marks"].size() == 2; });
    const json& marks = after["probe"]["marks"];
    const double across_m = marks[1][0].get<double>() - marks[0][0].get<double>();
    const double along_m = marks[1][2].get<double>() - marks[0][2].get<double>();
    CHECK(after["probe"]["profile"]["length_m"].get<double>() == Approx(std::hypot(across_m, along_m)));
    CHECK(same_camera(after, before));
    CHECK(changed(bare, hand.display.picture(), view) > 0.005);
}

TEST_CASE("a drag along the timeline seeks as it goes, and a press on a point's mark selects that point") {
    if (skipped()) return;
    Hand hand({"--path", FJELL_SOURCE_DIR "/content/paths/flythrough.json", "--do", "panel pictures", "--do",
               "float pictures on", "--do",
               "place-panel pictures 240 40 400 860"}); // where all of the timeline is seen
    EditorWindow& editor = hand.editor;
    const json before = hand.settled();
    const gl::Image first = hand.display.picture();
    const Place line = editor.place("path.timeline");
    editor.drag("path.timeline", 0.2, 0.6);
    const json sought = hand.settled();
    CHECK(sought["route"]["share"].get<double>() == Approx(0.6).margin(1.5 / line.width));
    CHECK(sought["camera"]["navigation"] == "path");
    CHECK(sought["camera"]["position_m"] != before["camera"]["position_m"]);
    CHECK(changed(first, hand.display.picture(), view_of(before)) > 0.05);
    CHECK(sought["route"]["selected"].is_null());
    editor.click_at(line.x + 1, line.y + line.height - 3); // the first point's mark
    const json chosen = editor.state();
    CHECK(chosen["route"]["selected"] == 0);
    CHECK(chosen["route"]["share"] == sought["route"]["share"]);
    CHECK(chosen["route"]["unsaved"] == false);
}

TEST_CASE("a brush digs where it is dragged, undo takes it back, and what was dug outlives a kill") {
    const std::string why = why_no_windows();
    if (!why.empty()) {
        WARN("skipped: " << why);
        return;
    }
    const TemporaryFolder folder;
    const std::string pack = folder / "dug.fjell";
    std::filesystem::copy(small_pack(), pack);
    const std::vector<std::string> arguments{pack, "--size", "600x480", "--scale", "0.5", "--do", "panel ground"};
    const VirtualDisplay display(640, 512);
    const TemporaryFolder home;
    const auto stamps = [](const json& s) {
        return s["ground"]["layers"].empty() ? 0 : s["ground"]["layers"][0]["stamps"].get<int>();
    };
    const auto at_rest = [&](EditorWindow& editor) {
        return editor.until("ground at rest", [](const json& s) {
            return s["measures"]["converged"] == true && s["ground"]["waiting"] == 0;
        });
    };
    int dug = 0;
    {
        EditorWindow editor(display, home.path, arguments);
        const json before = at_rest(editor);
        CHECK(stamps(before) == 0);
        const gl::Image bare = display.picture();
        const Place view = view_of(before);
        const double x = view.x + 0.3 * view.width, y = view.y + 0.7 * view.height;
        editor.key("b");
        editor.click("brush.raise");
        editor.move(x, y);
        json now = editor.until("a brush over the ground", [](const json& s) { return !s["ground"]["at"].is_null(); });
        const double radius_m = now["ground"]["brush"]["radius_m"];
        editor.wheel(8);
        now = editor.state();
        CHECK(now["ground"]["brush"]["radius_m"].get<double>() > 2 * radius_m);
        CHECK(now["camera"]["speed_m_s"] == before["camera"]["speed_m_s"]);
        editor.drag_at(x, y, x + 0.3 * view.width, y);
        now = editor.until("a stroke", [&](const json& s) { return stamps(s) > 0; });
        dug = stamps(now);
        CHECK(same_camera(now, before)); // the button was the brush's
        now = at_rest(editor);
        CHECK(now["ground"]["blocks"] > 0);
        CHECK(changed(bare, display.picture(), view) > 0.01);
        CHECK(std::filesystem::exists(pack + ".journal"));
        editor.key("ctrl+z");
        CHECK(stamps(editor.until("undone", [&](const json& s) { return stamps(s) == 0; })) == 0);
        CHECK(at_rest(editor)["ground"]["blocks"] == 0);
        editor.key("ctrl+shift+z");
        CHECK(stamps(editor.until("redone", [&](const json& s) { return stamps(s) > 0; })) == dug);
        editor.click("brush.road"); // all of a drag is one stamp
        editor.drag_at(x, y, x + 0.3 * view.width, y + 0.1 * view.height);
        CHECK(stamps(editor.until("a road", [&](const json& s) { return stamps(s) > dug; })) == dug + 1);
        at_rest(editor);
        editor.key("ctrl+z");
        CHECK(stamps(editor.until("undone", [&](const json& s) { return stamps(s) == dug; })) == dug);
        editor.signal(SIGKILL);
        CHECK(editor.exit_code() == 128 + SIGKILL);
    }
    EditorWindow editor(display, home.path, arguments);
    const json after = at_rest(editor);
    CHECK((stamps(after) == dug && after["ground"]["problem"] == "" && after["ground"]["blocks"] > 0));
    editor.click("layers.on.0");
    CHECK(editor.until("the pack's ground",
                       [](const json& s) { return s["ground"]["blocks"] == 0; })["ground"]["layers"][0]["on"] == false);
}
