// The camera path over its time: how fast it flies, where its points are, and where it is being played. All three are
// dragged: the playhead, a point's mark between its neighbours, and the curve of the speed up and down. Keys choose a
// point, and do to it what a hand does; the playhead's are those of the slider above.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "editor/number_text.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"
#include "editor/strings.h"

namespace fjell::editor {

namespace {

constexpr std::size_t most_speeds = 192, most_marked = 64;
constexpr ImU32 timeline_paper = IM_COL32(28, 31, 37, 255), timeline_lane = IM_COL32(38, 42, 50, 255),
                timeline_tick = IM_COL32(255, 255, 255, 26), timeline_path = IM_COL32(255, 120, 200, 255),
                timeline_speed = IM_COL32(125, 175, 235, 255), timeline_target = IM_COL32(235, 190, 80, 200);
constexpr float timeline_drag_px = 3; // a click may tremble

// Speeds of as many equal stretches of time.
struct Speeds {
    std::array<float, most_speeds> m_s;
    std::size_t count = 0;
    float most = 0;

    [[nodiscard]] float at(double share) const {
        const double i = share * static_cast<double>(count);
        return m_s[std::min(static_cast<std::size_t>(std::max(i, 0.0)), count - 1)];
    }
};

Speeds speeds_of(const Route& route) {
    Speeds speeds;
    const auto& poses = route.poses();
    speeds.count = std::min(poses.size() - 1, most_speeds);
    for (std::size_t i = 0; i < speeds.count; ++i) {
        const std::size_t from = i * (poses.size() - 1) / speeds.count,
                          to = (i + 1) * (poses.size() - 1) / speeds.count;
        const double way_m = length(poses[to].position_m - poses[from].position_m);
        speeds.m_s[i] =
            static_cast<float>(way_m * poses_a_second / static_cast<double>(std::max<std::size_t>(to - from, 1)));
        speeds.most = std::max(speeds.most, speeds.m_s[i]);
    }
    return speeds;
}

// Where times and speeds lie. While something is held it stays, or what is held would run from under the pointer.
struct TimelineScale {
    ImVec2 low, high;
    float em = 1, head = 0, foot = 0; // of the curve; below it is the lane of the points
    double seconds = 1, m_s = 1;      // over the width, and at the head

    [[nodiscard]] float x(double time_s) const {
        return low.x + static_cast<float>(time_s / seconds) * (high.x - low.x);
    }
    [[nodiscard]] double time_s(float x) const { return static_cast<double>((x - low.x) / (high.x - low.x)) * seconds; }
    [[nodiscard]] float y(double speed) const { return foot - static_cast<float>(speed / m_s) * (foot - head); }
    [[nodiscard]] double speed(float y) const { return static_cast<double>((foot - y) / (foot - head)) * m_s; }
};

enum class TimelinePart : std::uint8_t { nothing, playhead, point, speed };
// What of it is under the pointer, or held; point: of a stretch the one where it begins.
struct TimelineGrip {
    TimelinePart part = TimelinePart::nothing;
    std::size_t point = 0;
    ImVec2 from;                    // where it was pressed
    double seconds = 1, most = 1;   // of the scale then
    double value = 0, mean_m_s = 0; // the point's time, or the curve's speed there and the stretch's mean
    bool moved = false;
};
TimelineGrip timeline_held;

float mark_radius(const Route& route, const TimelineScale& scale) {
    // Of many points the marks are smaller, or they would be one bar.
    const auto n = static_cast<float>(std::max<std::size_t>(route.points().size(), 1));
    return std::clamp((scale.high.x - scale.low.x) / n / 2.4F, 0.15F * scale.em, 0.5F * scale.em);
}

TimelineGrip under_pointer(const Route& route, const TimelineScale& scale, const Speeds& speeds) {
    const ImVec2 mouse = ImGui::GetMousePos();
    TimelineGrip grip{TimelinePart::playhead, 0, mouse, scale.seconds, scale.m_s, 0, 0, false};
    const std::size_t n = route.points().size();
    if (mouse.y >= scale.foot) {
        float away = 0.7F * scale.em;
        for (std::size_t i = 0; i < n; ++i) {
            const float at = std::abs(scale.x(route.share_of(i) * route.seconds()) - mouse.x);
            if (at > away) continue;
            away = at;
            grip = {TimelinePart::point, i, mouse, scale.seconds, scale.m_s, route.time_of(i), 0, false};
        }
        return grip;
    }
    const double share = std::clamp(scale.time_s(mouse.x) / route.seconds(), 0.0, 1.0);
    const double m_s = static_cast<double>(speeds.at(share));
    if (n < 2 || !(m_s > 0) || std::abs(scale.y(m_s) - mouse.y) > 0.6F * scale.em) return grip;
    std::size_t stretch = 0;
    while (stretch + 2 < n && route.share_of(stretch + 1) <= share) ++stretch;
    const double mean_m_s = route.mean_speed_m_s(stretch);
    if (mean_m_s > 0) grip = {TimelinePart::speed, stretch, mouse, scale.seconds, scale.m_s, m_s, mean_m_s, false};
    return grip;
}

// A round number of seconds, so that lines are at least three letters' heights apart.
double tick_s(const TimelineScale& scale) {
    const double least = scale.time_s(scale.low.x + 3 * scale.em);
    for (double power = 0.01; power < 1e4; power *= 10)
        for (const double step : {1.0, 2.0, 5.0})
            if (step * power >= least) return step * power;
    return scale.seconds;
}

double snapped_to(double value, double to, double within) {
    return std::abs(value - to) <= within ? to : value;
}

// Where the hand has it: at a line or the playhead, if that is near; with Shift anywhere.
double held_time_s(const Route& route, const TimelineScale& scale) {
    const ImVec2 mouse = ImGui::GetMousePos();
    const double moved_s = scale.time_s(mouse.x) - scale.time_s(timeline_held.from.x);
    double time_s = timeline_held.value + moved_s;
    if (!ImGui::GetIO().KeyShift) {
        const double within = scale.time_s(scale.low.x + 0.35F * scale.em), tick = tick_s(scale);
        time_s = snapped_to(time_s, tick * std::round(time_s / tick), within);
        time_s = snapped_to(time_s, route.share() * route.seconds(), within);
    }
    const Route::Range range = route.time_range(timeline_held.point);
    return std::clamp(time_s, range.least, range.most);
}

// Of the stretch behind that point: it lasts no longer than a path may, and no less than a stretch may.
double possible_speed_m_s(const Route& route, std::size_t point, double mean_m_s) {
    const double lasts_s = route.time_of(point + 1) - route.time_of(point),
                 rest_s = route.time_of(route.points().size() - 1) - lasts_s;
    const double way_m = route.mean_speed_m_s(point) * lasts_s;
    return std::clamp(mean_m_s, way_m / (flight::max_path_seconds - rest_s), way_m * poses_a_second);
}

// The mean speed of the stretch that keeps its curve at the pointer; like a neighbour's, if that is near.
double held_speed_m_s(const Route& route, const TimelineScale& scale) {
    const double slowest = timeline_held.value / 50;
    const double m_s = std::max(
        timeline_held.value + scale.speed(ImGui::GetMousePos().y) - scale.speed(timeline_held.from.y), slowest);
    double mean = timeline_held.mean_m_s * m_s / timeline_held.value;
    if (!ImGui::GetIO().KeyShift) {
        const double within = scale.speed(scale.foot - 0.3F * scale.em);
        if (timeline_held.point > 0) mean = snapped_to(mean, route.mean_speed_m_s(timeline_held.point - 1), within);
        if (timeline_held.point + 2 < route.points().size())
            mean = snapped_to(mean, route.mean_speed_m_s(timeline_held.point + 1), within);
    }
    return possible_speed_m_s(route, timeline_held.point, mean);
}

void press_timeline(const Route& route, const TimelineGrip& grip, const TimelineScale& scale, Commands& commands) {
    timeline_held = grip;
    const double share = std::clamp(scale.time_s(grip.from.x) / route.seconds(), 0.0, 1.0);
    const bool twice = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    if (grip.part == TimelinePart::point) {
        commands.push(SelectPoint{grip.point, twice});
    } else if (grip.part == TimelinePart::playhead && twice && grip.from.y >= scale.foot) {
        commands.push(InsertPoint{share});
    } else if (grip.part == TimelinePart::playhead) {
        commands.push(SeekPath{share});
    }
    if (twice) timeline_held.part = TimelinePart::nothing; // nothing is dragged by it
}

// Of what is held, while it moves and when it is let go.
void follow_hand(const Route& route, const TimelineScale& scale, bool ends, Commands& commands) {
    const ImVec2 mouse = ImGui::GetMousePos(), delta = ImGui::GetIO().MouseDelta;
    timeline_held.moved = timeline_held.moved || std::abs(mouse.x - timeline_held.from.x) >= timeline_drag_px ||
                          std::abs(mouse.y - timeline_held.from.y) >= timeline_drag_px;
    if (!timeline_held.moved || timeline_held.point >= route.points().size()) return;
    if (!ends && delta.x == 0 && delta.y == 0) return;
    if (timeline_held.part == TimelinePart::playhead && !ends)
        commands.push(SeekPath{std::clamp(scale.time_s(mouse.x) / route.seconds(), 0.0, 1.0)});
    if (timeline_held.part == TimelinePart::point && timeline_held.point > 0)
        commands.push(TimePoint{timeline_held.point, held_time_s(route, scale), !ends});
    if (timeline_held.part == TimelinePart::speed)
        commands.push(PaceStretch{timeline_held.point, held_speed_m_s(route, scale), !ends});
}

// What keys are changing, from the first press until they are let go: one step of undo.
struct TimelineNudge {
    TimelinePart part = TimelinePart::nothing;
    std::size_t point = 0;
    double value = 0; // its time, or the mean speed behind it
};
TimelineNudge timeline_nudge;

bool timeline_key(ImGuiKey key, bool repeats = true) {
    return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key), repeats);
}

void push_nudge(bool goes_on, Commands& commands) {
    const TimelineNudge& n = timeline_nudge;
    if (n.part == TimelinePart::point) commands.push(TimePoint{n.point, n.value, goes_on});
    if (n.part == TimelinePart::speed) commands.push(PaceStretch{n.point, n.value, goes_on});
}

void nudge_point(const Route& route, std::size_t point, int right, int up, Commands& commands) {
    if (right != 0 && point > 0) {
        const Route::Range range = route.time_range(point);
        const double step_s = ImGui::GetIO().KeyCtrl ? 1 : 0.1;
        timeline_nudge = {TimelinePart::point, point,
                          std::clamp(route.time_of(point) + right * step_s, range.least, range.most)};
        push_nudge(true, commands);
    } else if (up != 0 && route.mean_speed_m_s(point) > 0) { // there is a stretch behind it
        const double m_s = route.mean_speed_m_s(point) * (up > 0 ? 1.05 : 1 / 1.05);
        timeline_nudge = {TimelinePart::speed, point, possible_speed_m_s(route, point, m_s)};
        push_nudge(true, commands);
    }
}

// Keys are at the timeline.
void follow_keys(const Route& route, bool enter, Commands& commands) {
    const int right = timeline_key(ImGuiKey_RightArrow) - timeline_key(ImGuiKey_LeftArrow),
              up = timeline_key(ImGuiKey_UpArrow) - timeline_key(ImGuiKey_DownArrow);
    const std::size_t n = route.points().size();
    const auto selected = route.selected();
    if (n == 0) return;
    if (!ImGui::GetIO().KeyShift && right != 0) {
        std::size_t to = right > 0 ? 0 : n - 1; // when none is selected
        if (selected) to = right > 0 ? std::min(*selected + 1, n - 1) : *selected - std::min<std::size_t>(*selected, 1);
        commands.push(SelectPoint{to, false});
    }
    if (timeline_key(ImGuiKey_Insert, false)) commands.push(InsertPoint{});
    if (!selected || *selected >= n) return;
    if (ImGui::GetIO().KeyShift) nudge_point(route, *selected, right, up, commands);
    if (timeline_key(ImGuiKey_Delete, false)) commands.push(RemovePoint{*selected});
    if (enter) commands.push(SelectPoint{*selected, true});
}

void end_nudge(bool at_it, Commands& commands) {
    if (timeline_nudge.part == TimelinePart::nothing || (at_it && ImGui::GetIO().KeyShift)) return;
    push_nudge(false, commands);
    timeline_nudge = {};
}

void draw_point_marks(ImDrawList& list, const Route& route, const TimelineScale& scale, const TimelineGrip& shown) {
    const float r = mark_radius(route, scale), y = (scale.foot + scale.high.y) / 2;
    for (std::size_t i = 0; i < route.points().size(); ++i) {
        const float x = scale.x(route.share_of(i) * route.seconds());
        const bool selected = route.selected() == i, lit = shown.part == TimelinePart::point && shown.point == i;
        const float reach = lit ? 1.25F * r : r;
        list.AddQuadFilled({x - reach, y}, {x, y - reach}, {x + reach, y}, {x, y + reach},
                           selected ? IM_COL32_WHITE : timeline_path);
        if (!ui::recording_marks() || i >= most_marked) continue;
        char name[32];
        std::snprintf(name, sizeof name, "point.%zu", i);
        ui::mark_at("timeline", name, {x - r, y - r, 2 * r, 2 * r});
    }
}

void draw_speed_curve(ImDrawList& list, const Route& route, const TimelineScale& scale, const Speeds& speeds,
                      const TimelineGrip& shown) {
    std::array<ImVec2, most_speeds> line;
    for (std::size_t i = 0; i < speeds.count; ++i)
        line[i] = {scale.x((static_cast<double>(i) + 0.5) / static_cast<double>(speeds.count) * route.seconds()),
                   scale.y(static_cast<double>(speeds.m_s[i]))};
    const float thick = std::max(1.0F, scale.em / 10);
    list.AddPolyline(line.data(), static_cast<int>(speeds.count), timeline_speed, 0, thick);
    for (std::size_t i = 0; ui::recording_marks() && i + 1 < route.points().size() && i < most_marked; ++i) {
        const double share = (route.share_of(i) + route.share_of(i + 1)) / 2;
        char name[32];
        std::snprintf(name, sizeof name, "speed.%zu", i);
        ui::mark_at("timeline", name,
                    {scale.x(share * route.seconds()) - 2, scale.y(static_cast<double>(speeds.at(share))) - 2, 4, 4});
    }
    if (shown.part != TimelinePart::speed) return;
    const auto at = [&](std::size_t point) {
        return std::min(static_cast<std::size_t>(route.share_of(point) * static_cast<double>(speeds.count)),
                        speeds.count - 1);
    };
    const std::size_t from = at(shown.point), to = at(shown.point + 1);
    list.AddPolyline(line.data() + from, static_cast<int>(to - from + 1), IM_COL32_WHITE, 0, 2 * thick);
}

// The lines that points are drawn to, and where the camera keeps to a target.
void draw_paper(ImDrawList& list, const Route& route, const TimelineScale& scale) {
    const double tick = tick_s(scale);
    for (int i = 1; i * tick < scale.seconds; ++i)
        list.AddLine({scale.x(i * tick), scale.head}, {scale.x(i * tick), scale.high.y}, timeline_tick);
    const auto& targets = route.targets();
    for (std::size_t i = 1; i < targets.size(); ++i) {
        if (!targets[i - 1] || !targets[i] || length(*targets[i] - *targets[i - 1]) != 0) continue;
        const float from = scale.x(route.share_of(i - 1) * route.seconds()),
                    to = scale.x(route.share_of(i) * route.seconds());
        list.AddRectFilled({from, scale.foot - 0.1F * scale.em}, {to, scale.foot + 0.1F * scale.em}, timeline_target);
    }
}

// What is held, by a hand or by keys, or how fast the fastest is.
void write_head(ImDrawList& list, const Route& route, const TimelineScale& scale, const Speeds& speeds, bool by_keys) {
    char text[80];
    TimelinePart part = timeline_held.moved ? timeline_held.part : TimelinePart::nothing;
    std::size_t point = timeline_held.point;
    if (part == TimelinePart::nothing && by_keys && route.selected()) {
        part = timeline_nudge.part == TimelinePart::speed ? TimelinePart::speed : TimelinePart::point;
        point = *route.selected();
    }
    const bool holds = part != TimelinePart::nothing && point < route.points().size();
    if (holds && part == TimelinePart::point)
        std::snprintf(text, sizeof text, strings::timeline::point, point, route.time_of(point));
    else if (holds && part == TimelinePart::speed)
        std::snprintf(text, sizeof text, strings::timeline::stretch, point,
                      speed_text(route.mean_speed_m_s(point)).text);
    else
        std::snprintf(text, sizeof text, strings::timeline::speed_up_to,
                      speed_text(static_cast<double>(speeds.most)).text);
    list.AddText({scale.low.x, scale.low.y}, holds ? IM_COL32_WHITE : ui::quiet, text);
}

void explain_timeline(const Route& route, const TimelineScale& scale, const Speeds& speeds, const TimelineGrip& shown) {
    if (!ui::begin_tip()) return;
    const double share = std::clamp(scale.time_s(ImGui::GetMousePos().x) / route.seconds(), 0.0, 1.0);
    const NumberText speed = speed_text(static_cast<double>(speeds.at(share)));
    if (shown.part == TimelinePart::point && shown.point == 0)
        ImGui::Text(strings::timeline::about_first_point, shown.point);
    else if (shown.part == TimelinePart::point)
        ImGui::Text(strings::timeline::about_point, shown.point, route.time_of(shown.point));
    else if (shown.part == TimelinePart::speed)
        ImGui::Text(strings::timeline::about_speed, speed.text, speed_text(route.mean_speed_m_s(shown.point)).text,
                    shown.point, shown.point + 1);
    else
        ImGui::Text(strings::timeline::about_playhead, share * route.seconds(), speed.text);
    ui::end_tip();
}

} // namespace

void draw_timeline(const State& state, Commands& commands) {
    const Route& route = state.route;
    if (route.poses().size() < 2) {
        timeline_held = {};
        timeline_nudge = {};
        return;
    }
    const float em = ImGui::GetFontSize(), width = std::max(ImGui::GetContentRegionAvail().x, 4 * em);
    const ImVec2 low = ImGui::GetCursorScreenPos(), high{low.x + width, low.y + 5.4F * em};
    ImGui::InvisibleButton("timeline", {width, high.y - low.y});
    const float edge = std::min(0.7F * em, width / 4); // where half of the first and the last mark have room
    ui::mark("path", "timeline", {low.x + edge, low.y, width - 2 * edge, high.y - low.y});
    const bool at_it = ImGui::IsItemFocused() && ImGui::GetIO().NavVisible, pressed = ImGui::IsItemActivated(),
               by_hand = pressed && ImGui::IsMouseDown(ImGuiMouseButton_Left);
    if (at_it) keyboard::keep_arrows();
    if (at_it) follow_keys(route, pressed && !by_hand, commands);
    end_nudge(at_it, commands);
    const bool ends = ImGui::IsItemDeactivated();
    if (!ImGui::IsItemVisible() && !ImGui::IsItemActive() && !ends) return;
    const Speeds speeds = speeds_of(route);
    const bool holds = timeline_held.part != TimelinePart::nothing && (ImGui::IsItemActive() || ends) && !pressed;
    TimelineScale scale{{low.x + edge, low.y}, {high.x - edge, high.y}, em, low.y + 1.3F * em,
                        high.y - 1.4F * em,    route.seconds(),         1};
    scale.m_s = std::max(static_cast<double>(speeds.most), 1e-6);
    if (holds) scale.seconds = timeline_held.seconds, scale.m_s = timeline_held.most;
    TimelineGrip shown = timeline_held;
    if (!holds) shown = ImGui::IsItemHovered() ? under_pointer(route, scale, speeds) : TimelineGrip{};
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.PushClipRect(low, high, true);
    list.AddRectFilled(low, high, timeline_paper);
    list.AddRectFilled({low.x, scale.foot}, high, timeline_lane);
    draw_paper(list, route, scale);
    draw_speed_curve(list, route, scale, speeds, shown);
    draw_point_marks(list, route, scale, shown);
    const float x = scale.x(route.share() * route.seconds());
    list.AddLine({x, scale.head - 0.2F * em}, {x, high.y}, IM_COL32_WHITE, std::max(1.0F, em / 10));
    if (holds)
        follow_hand(route, scale, ends, commands);
    else if (by_hand)
        press_timeline(route, shown, scale, commands);
    write_head(list, route, scale, speeds, at_it);
    list.PopClipRect();
    (void)keyboard::outline();
    if (shown.part == TimelinePart::point) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    if (shown.part == TimelinePart::speed) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeNS);
    if (ends || (!holds && !ImGui::IsItemActive())) timeline_held = {};
    explain_timeline(route, scale, speeds, shown);
}

} // namespace fjell::editor
