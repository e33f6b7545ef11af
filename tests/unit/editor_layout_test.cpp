// Where panels and picture are in windows of all sizes, and what the commands that move them do.
#include <catch2/catch.hpp>

#include <vector>

#include "editor/command.h"
#include "editor/handlers/handlers.h"
#include "editor/panels/panels.h"

using namespace fjell::editor;
using ui::Rect;

namespace {

struct Ui {
    Ui() { ImGui::CreateContext(); }
    ~Ui() { ImGui::DestroyContext(); }
};

bool overlap(const Rect& a, const Rect& b) {
    constexpr float rounding = 0.01F;
    return a.x + a.width > b.x + rounding && b.x + b.width > a.x + rounding && a.y + a.height > b.y + rounding &&
           b.y + b.height > a.y + rounding;
}

// Everything that is drawn, beside the menu and the status line.
std::vector<Rect> places(const ui::Layout& l) {
    std::vector<Rect> all{l.view};
    for (const ui::ColumnLayout& c : l.column) {
        if (!c.there) continue;
        all.push_back(c.strip);
        for (int i = 0; i < c.sections; ++i) all.push_back(c.section[i].rect);
        if (c.sections == 2) all.push_back(c.split);
    }
    return all;
}

unsigned groups_of(const ui::Layout& l) {
    unsigned groups = 0;
    for (const ui::ColumnLayout& c : l.column)
        for (int i = 0; c.there && i < c.sections; ++i) {
            CHECK((groups & c.section[i].groups) == 0); // no panel twice
            groups |= c.section[i].groups;
        }
    return groups;
}

struct Size {
    float width, height;
};
constexpr Size sizes[] = {{1280, 720}, {1920, 1080}, {2560, 1440}, {600, 320}, {900, 1600}, {3840, 2160}};

} // namespace

TEST_CASE("at any size, scale and arrangement nothing overlaps, all of it is in the window, and no panel is lost") {
    const Ui ui;
    for (const Size& size : sizes)
        for (const double scale : {0.5, 1.0, 2.0})
            for (const float width_px : {least_column_px, 325.0F, most_column_px})
                for (const bool folded : {false, true}) {
                    CAPTURE(size.width, size.height, scale, width_px, folded);
                    Interface i;
                    i.scale = scale;
                    i.arrangement.width_px = {width_px, width_px};
                    i.arrangement.folded[0] = folded;
                    const ui::Layout l = ui::layout(size.width, size.height, i);
                    const std::vector<Rect> all = places(l);
                    for (std::size_t a = 0; a < all.size(); ++a) {
                        CHECK(all[a].x >= 0);
                        CHECK(all[a].x + all[a].width <= size.width + 0.01F);
                        CHECK(all[a].y + all[a].height <= size.height - l.status_height + 0.01F);
                        for (std::size_t b = a + 1; b < all.size(); ++b) CHECK_FALSE(overlap(all[a], all[b]));
                    }
                    if (!folded) CHECK(groups_of(l) == (left_groups | right_groups));
                    CHECK(l.view.width >= 0.29F * size.width);
                }
}

TEST_CASE("by default the picture has two thirds of the width at a desktop's sizes; tall windows stack sections") {
    const Ui ui;
    for (const Size& size : {sizes[0], sizes[1], sizes[2]}) {
        const ui::Layout l = ui::layout(size.width, size.height, {});
        CAPTURE(size.width);
        CHECK(l.view.width >= 0.65F * size.width);
        CHECK(l.column[1].there == (size.width > 1900));
        CHECK(l.column[0].sections == (size.height > 1000 ? 2 : 1));
    }
    Interface large;
    large.scale = 2; // 200% of twice the size is the same
    CHECK(ui::layout(2560, 1440, large).view.width >= 0.65F * 2560);
    Interface bare;
    bare.arrangement.panels = false;
    CHECK(ui::layout(1280, 720, bare).view.width == 1280);
    CHECK(ui::layout(1280, 720, bare).view.y > 0);
    bare.picture_only = true;
    const ui::Layout only = ui::layout(1280, 720, bare);
    CHECK(only.view.height == 720);
    CHECK(only.menu_height == 0);
}

TEST_CASE("commands hide, fold, resize and turn to panels, and a panel that is asked for is seen") {
    State state;
    Engine engine;
    Jobs jobs;
    const auto run = [&](const char* line) { apply(*parse_command(line), {state, engine, jobs}); };
    const Interface& i = state.interface;
    run("column right width 500");
    run("column right split 0.99");
    run("column left folded on");
    run("interface panels off");
    CHECK(i.arrangement.width_px[1] == 500);
    CHECK(i.arrangement.split[1] == most_split);
    CHECK(i.arrangement.folded[0]);
    CHECK_FALSE(i.arrangement.panels);
    run("interface picture-only on");
    CHECK(i.picture_only);
    run("panel budgets");
    CHECK(i.arrangement.panels);
    CHECK_FALSE(i.picture_only);
    CHECK_FALSE(i.arrangement.folded[0]);
    CHECK(i.arrangement.shown(right_groups) == Panel::budgets);
    CHECK(i.arrangement.shown(left_groups) == Panel::tune);
    run("interface panel-keys on");
    CHECK(i.panel_keys);
    run("interface panels off"); // nobody would see where the keys go
    CHECK_FALSE(i.panel_keys);
    run("frame-report 3");
    CHECK(state.messages.all.back().severity == Severity::error); // none has been measured
}

TEST_CASE("panels float and come back, and columns give the room of those that float to the others or to the picture") {
    const Ui ui;
    State state;
    Engine engine;
    Jobs jobs;
    const auto run = [&](const char* line) { apply(*parse_command(line), {state, engine, jobs}); };
    const Arrangement& a = state.interface.arrangement;
    const auto at = [&](float width, float height) { return ui::layout(width, height, state.interface); };
    run("interface panels off");
    run("float time on");
    CHECK(a.floats(Panel::time));
    CHECK(a.panels); // it is seen
    CHECK(a.shown(left_groups | right_groups) != Panel::time);
    run("place-panel time 40 50 300 400");
    CHECK(a.floating[static_cast<std::size_t>(Panel::time)] == FloatingPanel{true, 40, 50, 300, 400});
    run("float time off");
    CHECK(a.shown(right_groups) == Panel::time); // turned to where it belongs
    state.interface.view_x_px = 300;
    state.interface.view_y_px = 20;
    for (const char* panel : {"budgets", "streaming"}) run((std::string("float ") + panel + " on").c_str());
    const FloatingPanel &one = a.floating[static_cast<std::size_t>(Panel::budgets)],
                        &two = a.floating[static_cast<std::size_t>(Panel::streaming)];
    CHECK(one.x_px > 300); // over the picture, where no hand has put them
    CHECK(one.y_px > 20);
    CHECK(two.x_px > one.x_px + 20); // and each can be taken by its title
    CHECK(two.y_px > one.y_px + 20);
    run("float time on");
    CHECK(a.floating[static_cast<std::size_t>(Panel::time)] == FloatingPanel{true, 40, 50, 300, 400}); // where it was
    run("float time off");
    const ui::Layout tall = at(1920, 1080);
    CHECK(tall.column[1].sections == 1); // the lower one's panels are elsewhere
    CHECK((groups_of(tall) & group_bit(Panel::budgets)) == 0);
    for (const Panel panel : {Panel::time, Panel::levels, Panel::auto_tune, Panel::benchmark})
        run((std::string("float ") + panel_names[static_cast<std::size_t>(panel)] + " on").c_str());
    CHECK_FALSE(at(1920, 1080).column[1].there);
    CHECK(at(1920, 1080).column[0].there);
    for (const Panel panel : {Panel::tune, Panel::camera, Panel::show, Panel::pictures})
        run((std::string("float ") + panel_names[static_cast<std::size_t>(panel)] + " on").c_str());
    CHECK(at(1280, 720).view.width == 1280);
    CHECK_THROWS(parse_command("place-panel time 1 1 2 2"));
}

TEST_CASE("graphs are held while they show some of the frames only, and show all of them when they go on") {
    State state;
    Engine engine;
    Jobs jobs;
    const auto run = [&](const char* line) { apply(*parse_command(line), {state, engine, jobs}); };
    CHECK(state.graphs.whole());
    run("zoom-graphs 300 200");
    CHECK(state.measures.held());
    CHECK(state.graphs.oldest == 300);
    CHECK(state.graphs.newest == 200);
    run("zoom-graphs 40 90"); // either way round
    CHECK(state.graphs.oldest == 90);
    CHECK(state.graphs.newest == 40);
    for (const char* narrow : {"zoom-graphs 0 0", "zoom-graphs 3 3", "zoom-graphs 511 510"}) {
        run(narrow);
        CHECK(state.graphs.oldest - state.graphs.newest + 1 == least_graph_span);
        CHECK(state.graphs.newest < state.graphs.oldest);
        CHECK(state.graphs.oldest < measured_frames);
    }
    run("hold-graphs off");
    CHECK_FALSE(state.measures.held());
    CHECK(state.graphs.whole());
}
