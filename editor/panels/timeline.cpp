// The camera path over its time: where its points are, and where it is being played. A drag moves the playhead, a press
// on a mark selects its point, and so do keys; the playhead's keys are those of the slider above.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

constexpr std::size_t most_marked = 64;

// Where times lie.
struct TimelineScale {
    float left, right, em;
    [[nodiscard]] float x(double share) const { return left + static_cast<float>(share) * (right - left); }
    [[nodiscard]] double share(float x) const {
        return std::clamp(static_cast<double>((x - left) / (right - left)), 0.0, 1.0);
    }
};

// The point whose mark lies under the pointer.
std::optional<std::size_t> timeline_point(const Route& route, const TimelineScale& scale) {
    std::optional<std::size_t> found;
    float away = 0.7F * scale.em;
    for (std::size_t i = 0; i < route.points().size(); ++i) {
        const float at = std::abs(scale.x(route.share_of(i)) - ImGui::GetMousePos().x);
        if (at > away) continue;
        away = at;
        found = i;
    }
    return found;
}

// Keys are at the timeline.
void follow_keys(const Route& route, bool enter, Commands& commands) {
    const auto struck = [](ImGuiKey key, bool repeats) {
        return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key), repeats);
    };
    const int right = struck(ImGuiKey_RightArrow, true) - struck(ImGuiKey_LeftArrow, true);
    const std::size_t n = route.points().size();
    const auto selected = route.selected();
    if (n == 0) return;
    if (right != 0) {
        std::size_t to = right > 0 ? 0 : n - 1; // when none is selected
        if (selected) to = right > 0 ? std::min(*selected + 1, n - 1) : *selected - std::min<std::size_t>(*selected, 1);
        commands.push(SelectPoint{to, false});
    }
    if (struck(ImGuiKey_Insert, false)) commands.push(InsertPoint{});
    if (!selected || *selected >= n) return;
    if (struck(ImGuiKey_Delete, false)) commands.push(RemovePoint{*selected});
    if (enter) commands.push(SelectPoint{*selected, true});
}

} // namespace

void draw_timeline(const State& state, Commands& commands) {
    static bool seeks = false;
    const Route& route = state.route;
    if (route.poses().size() < 2) return;
    const float em = ImGui::GetFontSize(), width = std::max(ImGui::GetContentRegionAvail().x, 4 * em);
    const ImVec2 low = ImGui::GetCursorScreenPos(), high{low.x + width, low.y + 2.6F * em};
    const float lane = low.y + 1.2F * em; // of the points, below it
    ImGui::InvisibleButton("timeline", {width, high.y - low.y});
    const float edge = std::min(0.7F * em, width / 4); // where half of the first and the last mark have room
    ui::mark("path", "timeline", {low.x + edge, low.y, width - 2 * edge, high.y - low.y});
    const bool at_it = ImGui::IsItemFocused() && ImGui::GetIO().NavVisible, pressed = ImGui::IsItemActivated(),
               by_hand = pressed && ImGui::IsMouseDown(ImGuiMouseButton_Left);
    if (at_it) keyboard::keep_arrows();
    if (at_it) follow_keys(route, pressed && !by_hand, commands);
    if (!ImGui::IsItemVisible() && !ImGui::IsItemActive()) return;
    const TimelineScale scale{low.x + edge, high.x - edge, em};
    const ImVec2 mouse = ImGui::GetMousePos();
    const double share = scale.share(mouse.x);
    std::optional<std::size_t> under;
    if (ImGui::IsItemHovered() && mouse.y >= lane && !seeks) under = timeline_point(route, scale);
    if (by_hand) {
        const bool twice = ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
        seeks = !under && !twice;
        if (under)
            commands.push(SelectPoint{*under, twice});
        else if (twice && mouse.y >= lane)
            commands.push(InsertPoint{share});
        else
            commands.push(SeekPath{share});
    } else if (seeks && ImGui::IsItemActive() && ImGui::GetIO().MouseDelta.x != 0) {
        commands.push(SeekPath{share});
    }
    if (!ImGui::IsItemActive()) seeks = false;

    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.PushClipRect(low, high, true);
    list.AddRectFilled(low, high, IM_COL32(28, 31, 37, 255));
    list.AddRectFilled({low.x, lane}, high, IM_COL32(38, 42, 50, 255));
    // Of many points the marks are smaller, or they would be one bar.
    const auto n = static_cast<float>(std::max<std::size_t>(route.points().size(), 1));
    const float r = std::clamp((scale.right - scale.left) / n / 2.4F, 0.15F * em, 0.5F * em), y = (lane + high.y) / 2;
    for (std::size_t i = 0; i < route.points().size(); ++i) {
        const float x = scale.x(route.share_of(i)), reach = under == i ? 1.25F * r : r;
        list.AddQuadFilled({x - reach, y}, {x, y - reach}, {x + reach, y}, {x, y + reach},
                           route.selected() == i ? IM_COL32_WHITE : IM_COL32(255, 120, 200, 255));
        if (!ui::recording_marks() || i >= most_marked) continue;
        char name[32];
        std::snprintf(name, sizeof name, "point.%zu", i);
        ui::mark_at("timeline", name, {x - r, y - r, 2 * r, 2 * r});
    }
    const float x = scale.x(route.share());
    list.AddLine({x, low.y + 0.2F * em}, {x, high.y}, IM_COL32_WHITE, std::max(1.0F, em / 10));
    list.PopClipRect();
    (void)keyboard::outline();
    if (!ui::begin_tip()) return;
    if (under)
        ImGui::Text("Point %zu at %.1f s. Click: select it; twice: look from there. Keys: left and right select a "
                    "point; Enter: look from there; Delete: remove it.",
                    *under, route.share_of(*under) * route.seconds());
    else
        ImGui::Text("%.1f s. Click or drag: go there. Click twice on the lower edge: a new point there.",
                    share * route.seconds());
    ui::end_tip();
}

} // namespace fjell::editor
