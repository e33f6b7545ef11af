// The camera path over its time: how fast it flies, where its points are, and where it is being played.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/panels.h"
#include "editor/strings.h"

namespace fjell::editor {

namespace {

constexpr std::size_t most_speeds = 192;
constexpr ImU32 timeline_paper = IM_COL32(28, 31, 37, 255), timeline_path = IM_COL32(255, 120, 200, 255);

// Speeds of as many equal stretches.
std::size_t speeds_of(const Route& route, std::array<float, most_speeds>& speeds, float& most) {
    const auto& poses = route.poses();
    const std::size_t count = std::min(poses.size() - 1, most_speeds);
    most = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t from = i * (poses.size() - 1) / count, to = (i + 1) * (poses.size() - 1) / count;
        const double way_m = length(poses[to].position_m - poses[from].position_m);
        speeds[i] =
            static_cast<float>(way_m * poses_a_second / static_cast<double>(std::max<std::size_t>(to - from, 1)));
        most = std::max(most, speeds[i]);
    }
    return count;
}

void draw_points_of(ImDrawList& list, const Route& route, ImVec2 low, ImVec2 high) {
    // Of many points the marks are smaller, or they would be one bar.
    const float apart = (high.x - low.x) / static_cast<float>(std::max<std::size_t>(route.points().size(), 1));
    const float r = std::clamp(apart / 2.4F, 0.12F * ImGui::GetFontSize(), 0.3F * ImGui::GetFontSize());
    for (std::size_t i = 0; i < route.points().size(); ++i) {
        const float x = low.x + static_cast<float>(route.share_of(i)) * (high.x - low.x), y = high.y - r;
        const bool selected = route.selected() == i;
        list.AddQuadFilled({x - r, y}, {x, y - r}, {x + r, y}, {x, y + r}, selected ? IM_COL32_WHITE : timeline_path);
    }
}

// The point whose mark is there; none: no_point.
constexpr std::size_t no_point = ~std::size_t{0};
std::size_t point_at(const Route& route, float low_x, float high_x, float x) {
    std::size_t nearest = no_point;
    float away = 0.4F * ImGui::GetFontSize();
    for (std::size_t i = 0; i < route.points().size(); ++i) {
        const float at = low_x + static_cast<float>(route.share_of(i)) * (high_x - low_x);
        if (std::abs(at - x) > away) continue;
        away = std::abs(at - x);
        nearest = i;
    }
    return nearest;
}

} // namespace

void draw_timeline(const State& state, Commands& commands) {
    const Route& route = state.route;
    if (route.poses().size() < 2) return;
    const float em = ImGui::GetFontSize(), width = std::max(ImGui::GetContentRegionAvail().x, 4 * em);
    const ImVec2 low = ImGui::GetCursorScreenPos(), high{low.x + width, low.y + 3.2F * em};
    ImGui::InvisibleButton("timeline", {width, high.y - low.y});
    ui::mark("path", "timeline");
    if (!ImGui::IsItemVisible()) return;
    std::array<float, most_speeds> speeds;
    float most = 0;
    const std::size_t count = speeds_of(route, speeds, most);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(low, high, timeline_paper);
    std::array<ImVec2, most_speeds> line;
    const float foot = high.y - 0.8F * em, head = low.y + 1.1F * em;
    for (std::size_t i = 0; i < count; ++i)
        line[i] = {low.x + (static_cast<float>(i) + 0.5F) / static_cast<float>(count) * width,
                   foot - (most > 0 ? speeds[i] / most : 0) * (foot - head)};
    list.AddPolyline(line.data(), static_cast<int>(count), IM_COL32(125, 175, 235, 255), 0, std::max(1.0F, em / 10));
    char text[64];
    std::snprintf(text, sizeof text, strings::timeline::speed_up_to, speed_text(static_cast<double>(most)).text);
    list.AddText({low.x + 0.3F * em, low.y}, ui::quiet, text);
    draw_points_of(list, route, low, high);
    const float x = low.x + static_cast<float>(route.share()) * width;
    list.AddLine({x, low.y}, {x, high.y}, IM_COL32_WHITE, std::max(1.0F, em / 10));
    const float mouse = ImGui::GetMousePos().x;
    const std::size_t point = point_at(route, low.x, high.x, mouse);
    const double share = static_cast<double>(std::clamp((mouse - low.x) / width, 0.0F, 1.0F));
    if (ImGui::IsItemActivated() && point != no_point && ImGui::GetMousePos().y > foot - 0.4F * em)
        commands.push(SelectPoint{point});
    else if (ImGui::IsItemActivated() || (ImGui::IsItemActive() && ImGui::GetIO().MouseDelta.x != 0))
        commands.push(SeekPath{share});
    if (!ui::begin_tip()) return;
    const std::size_t at = std::min(static_cast<std::size_t>(share * static_cast<double>(count)), count - 1);
    ImGui::Text(strings::timeline::s_click_go_there_a, share * route.seconds(),
                speed_text(static_cast<double>(speeds[at])).text);
    ui::end_tip();
}

} // namespace fjell::editor
