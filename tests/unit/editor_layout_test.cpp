// Where panels and picture are in windows of all sizes, and what the commands that move them do.
#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include "editor/command.h"
#include "editor/handlers/handlers.h"
#include "editor/panels/panels.h"
#include "editor/panels/tune.h"

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

unsigned sections_of(const ui::Layout& l) {
    unsigned bits = 0;
    for (const ui::ColumnLayout& c : l.column)
        for (int i = 0; c.there && i < c.sections; ++i) {
            CHECK((bits & c.section[i].bits) == 0); // no panel twice
            bits |= c.section[i].bits;
        }
    return bits;
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
                    if (!folded) CHECK(sections_of(l) == (left_sections | right_sections));
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
    run("panel cost");
    CHECK(i.arrangement.panels);
    CHECK_FALSE(i.picture_only);
    CHECK_FALSE(i.arrangement.folded[0]);
    CHECK(i.arrangement.shown(right_sections) == Panel::cost);
    CHECK(i.arrangement.shown(left_sections) == Panel::tune);
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
    run("float cost on");
    CHECK(a.floats(Panel::cost));
    CHECK(a.panels); // it is seen
    CHECK(a.shown(left_sections | right_sections) != Panel::cost);
    run("place-panel cost 40 50 300 400");
    CHECK(a.floating[static_cast<std::size_t>(Panel::cost)] == FloatingPanel{true, 40, 50, 300, 400});
    run("float cost off");
    CHECK(a.shown(right_sections) == Panel::cost); // turned to where it belongs
    state.interface.view_x_px = 300;
    state.interface.view_y_px = 20;
    for (const char* panel : {"auto-tune", "light"}) run((std::string("float ") + panel + " on").c_str());
    const FloatingPanel &one = a.floating[static_cast<std::size_t>(Panel::auto_tune)],
                        &two = a.floating[static_cast<std::size_t>(Panel::light)];
    CHECK(one.x_px > 300); // over the picture, where no hand has put them
    CHECK(one.y_px > 20);
    CHECK(two.x_px > one.x_px + 20); // and each can be taken by its title
    CHECK(two.y_px > one.y_px + 20);
    run("float cost on");
    CHECK(a.floating[static_cast<std::size_t>(Panel::cost)] == FloatingPanel{true, 40, 50, 300, 400}); // where it was
    run("float cost off");
    const ui::Layout tall = at(1920, 1080);
    CHECK(tall.column[1].sections == 1); // the lower one's panel is elsewhere
    CHECK((sections_of(tall) & section_bit(Panel::auto_tune)) == 0);
    run("float cost on");
    CHECK_FALSE(at(1920, 1080).column[1].there);
    CHECK(at(1920, 1080).column[0].there);
    for (const Panel panel : {Panel::tune, Panel::view, Panel::pictures, Panel::ground})
        run((std::string("float ") + panel_names[static_cast<std::size_t>(panel)] + " on").c_str());
    CHECK(at(1280, 720).view.width == 1280);
    CHECK_THROWS(parse_command("place-panel time 1 1 2 2"));
}

TEST_CASE(
    "seven panels hold all groups: one that is unfolded turns to its panel, and former panels' names lead to groups") {
    State state;
    Engine engine;
    Jobs jobs;
    const auto run = [&](const char* line) { apply(*parse_command(line), {state, engine, jobs}); };
    const Arrangement& a = state.interface.arrangement;
    const auto is_open = [&](Group group) { return a.open[static_cast<std::size_t>(group)]; };
    CHECK(panels == 7);
    CHECK_FALSE(is_open(Group::tune_advanced)); // for the few
    CHECK_FALSE(is_open(Group::cost_time));
    run("panel time");
    CHECK(is_open(Group::cost_time));
    CHECK(a.shown(right_sections) == Panel::cost);
    run("group view.position on");
    CHECK(is_open(Group::view_position));
    CHECK(a.shown(left_sections) == Panel::view);
    run("panel tune");
    run("group view.position off");
    CHECK_FALSE(is_open(Group::view_position));
    CHECK(a.shown(left_sections) == Panel::tune); // who folds stays
    CHECK_THROWS(parse_command("panel sound"));
    CHECK_THROWS(parse_command("group cost.sound on"));
}

TEST_CASE("every key of the profile has its group; those of the recursive method alone are advanced") {
    for (const fjell::ProfileKey& key : fjell::profile_keys()) {
        INFO(key.table << "." << key.name);
        CHECK((group_of(key) == Group::tune_advanced) == (key.used_by == fjell::UsedBy::recursive));
    }
    const auto group = [](const char* name) { return group_of(*fjell::find_profile_key(name)); };
    CHECK(group("refine.max_error_px") == Group::tune_refinement);
    CHECK(group("light.hour_utc") == Group::light_sun);
    CHECK(group("light.dither") == Group::light_air);
    CHECK(group("light.water") == Group::light_ground);
    CHECK(group("layers.tint") == Group::light_materials);
}

TEST_CASE("what has no effect says why: the sun's place, the exposure, water, shadows without horizons, materials") {
    State state;
    Engine engine;
    Jobs jobs;
    const auto run = [&](const char* line) { apply(*parse_command(line), {state, engine, jobs}); };
    const auto why = [&](const char* name) {
        const char* const text = why_idle(*fjell::find_profile_key(name), state);
        return std::string(text != nullptr ? text : "");
    };
    CHECK(why("light.azimuth_deg") == "");
    CHECK(why("light.day") == "only with the sun by time");
    run("set light.sun time");
    CHECK(why("light.azimuth_deg") == "only with the sun by direction");
    CHECK(why("light.day") == "");
    CHECK(why("light.ev100") == "only with a fixed exposure");
    run("set light.exposure fixed");
    CHECK(why("light.ev100") == "");
    CHECK(why("light.water_level_m") == "only with water");
    CHECK(why("layers.tint") == "only with materials");
    state.scene.materials = true;
    CHECK(why("layers.tint") == "");
    run("set layers.on false");
    CHECK(why("layers.tint") == "only with materials on");
    CHECK(why("layers.on") == "");
    CHECK(why("light.shadows") == ""); // nothing is open
    state.scene.path = "a.fjell";
    CHECK(why("light.shadows") == "this pack was baked without horizons");
    state.scene.horizons = true;
    CHECK(why("light.shadows") == "");
}

TEST_CASE("a preset of light is one step, and changes nothing but light") {
    State state;
    Engine engine;
    Jobs jobs;
    const auto run = [&](const char* line) { apply(*parse_command(line), {state, engine, jobs}); };
    run("set refine.max_error_px 7");
    for (const char* preset : light_preset_names) {
        run((std::string("light ") + preset).c_str());
        for (const fjell::ProfileKey* key : fjell::differing_keys(state.document.profile(), {}))
            CHECK((key->table == std::string("light") || key->name == std::string("max_error_px")));
    }
    run("set light.sun time");
    const std::size_t steps = state.document.undo_steps();
    run("light evening");
    CHECK(state.document.undo_steps() == steps + 1);
    CHECK(state.document.profile().light.elevation_deg == 9);
    run("undo");
    CHECK(state.document.profile().light.sun == fjell::gl::SunBy::time);
    CHECK_THROWS(parse_command("light disco"));
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
