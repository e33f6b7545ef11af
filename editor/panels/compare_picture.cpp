// Two profiles in one picture: what is compared, and the divider between them.
#include <algorithm>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/panels.h"
#include "flight/profile.h"

namespace fjell::editor {

namespace {

void draw_choice(const State& state, Commands& commands) {
    static double other_px = 4;
    const ComparedPicture& c = state.compared;
    constexpr const char* labels[] = {"off", "threshold", "profile"};
    for (int i = 0; i < 3; ++i) {
        const auto with = static_cast<CompareWith>(i);
        if (i > 0) ImGui::SameLine();
        const bool can = with != CompareWith::profile || state.document.compared() != nullptr;
        ImGui::BeginDisabled(!can);
        if (ImGui::RadioButton(labels[i], c.with == with)) commands.push(ComparePictures{with, other_px});
        ImGui::EndDisabled();
        ui::mark("compare-picture", compare_with_names[i]);
        ui::tip(i == 0   ? "The profile alone."
                : i == 1 ? "This profile at another threshold, in the same picture."
                : can    ? "The profile chosen with File > Compare profiles, in the same picture."
                         : "First choose a profile with File > Compare profiles.");
    }
    if (c.with != CompareWith::threshold) return;
    double px = c.error_px;
    ImGui::SetNextItemWidth(7 * ImGui::GetFontSize());
    if (ImGui::InputDouble("px", &px, 0, 0, "%.4g", ImGuiInputTextFlags_EnterReturnsTrue)) {
        other_px = std::clamp(px, flight::min_error_px, flight::max_error_px);
        commands.push(ComparePictures{CompareWith::threshold, other_px});
    }
    ui::mark("compare-picture", "error_px");
    ui::tip("The other threshold, in pixels. Enter applies it.");
}

// Its text with room around it; where there is too little on the divider's side, as near as it fits.
ui::Rect side_plate(const char* text, bool right_aligned, float x, const ui::Rect& room) {
    const float em = ImGui::GetFontSize();
    const ImVec2 size = ImGui::CalcTextSize(text);
    const float width = size.x + em, least = room.x + 0.3F * em, most = room.x + room.width - width - 0.3F * em;
    const float wanted = right_aligned ? x - 0.5F * em - width : x + 0.5F * em;
    return {std::max(std::min(wanted, most), least), room.y + 0.6F * em, width, size.y + 0.5F * em};
}

void draw_side(ImDrawList& list, const ui::Rect& at, const char* text) {
    const float em = ImGui::GetFontSize();
    list.AddRectFilled({at.x, at.y}, {at.x + at.width, at.y + at.height}, IM_COL32(12, 14, 18, 205), 0.25F * em);
    list.AddText({at.x + 0.5F * em, at.y + 0.25F * em}, IM_COL32_WHITE, text);
}

void name_sides(const State& state, const ui::Rect& view, float x) {
    const ComparedPicture& c = state.compared;
    const flight::Profile* const other = state.document.compared();
    const double px = c.with == CompareWith::profile && other != nullptr ? other->refine.error_px : c.error_px;
    char mine[64], theirs[64];
    std::snprintf(mine, sizeof mine, "%.3g px, %s triangles", state.document.profile().refine.error_px,
                  count_text(state.measures.last().triangles_drawn).text);
    if (c.there)
        std::snprintf(theirs, sizeof theirs, "%.3g px, %s triangles", px, count_text(c.triangles).text);
    else
        std::snprintf(theirs, sizeof theirs, "%.3g px: opening", px);
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const float em = ImGui::GetFontSize();
    ui::Rect room = beside_probe(state, view);
    if (room.height < 9 * em) return;       // the probe's plate and others at the bottom take all there is
    if (state.eye.frozen) room.y += 2 * em; // below the plate that says so
    list.PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height});
    const ui::Rect left = side_plate(mine, true, x, room);
    ui::Rect right = side_plate(theirs, false, x, room);
    if (right.x < left.x + left.width) right.y += left.height + 0.3F * em;
    draw_side(list, left, mine);
    draw_side(list, right, theirs);
    list.PopClipRect();
}

} // namespace

void draw_compare_picture(const State& state, Commands& commands) {
    ui::heading("Compare in the picture");
    draw_choice(state, commands);
    if (state.compared.with == CompareWith::nothing) return;
    constexpr const char* labels[] = {"side by side", "difference"};
    for (int i = 0; i < 2; ++i) {
        if (i > 0) ImGui::SameLine();
        const auto view = static_cast<CompareView>(i);
        if (ImGui::RadioButton(labels[i], state.compared.view == view)) commands.push(SetCompareView{view});
        ui::mark("compare-picture", compare_view_names[i]);
        ui::tip(i == 0 ? "On the left the profile, on the right the other one; drag the divider in the picture."
                       : "Black where both pictures are the same, through blue and yellow to white where they differ "
                         "by an eighth of full brightness or more.");
    }
    if (state.compared.view == CompareView::difference) return;
    auto percent = static_cast<float>(100 * state.compared.divider);
    ImGui::SetNextItemWidth(7 * ImGui::GetFontSize());
    if (ImGui::SliderFloat("Divider", &percent, 0, 100, "%.0f%%", ImGuiSliderFlags_NoInput))
        commands.push(SetDivider{static_cast<double>(percent) / 100});
    ui::mark("compare-picture", "divider");
    ui::tip("Where the divider stands, in percent of the picture's width. Or drag it.");
}

void draw_divider(const State& state, const ui::Rect& view, Commands& commands) {
    if (state.compared.with == CompareWith::nothing || !state.scene.open()) return;
    if (state.compared.view == CompareView::difference && state.compared.there)
        return name_sides(state, view, view.x + view.width / 2);
    const float em = ImGui::GetFontSize(), wide = 0.8F * em;
    const float x = view.x + static_cast<float>(state.compared.divider) * view.width;
    name_sides(state, view, x);
    const ui::Rect handle{std::clamp(x - wide / 2, view.x, view.x + view.width - wide), view.y, wide, view.height};
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
    ui::begin_column("divider", handle,
                     ImGuiWindowFlags_NoNavInputs | ImGuiWindowFlags_NoNavFocus | ImGuiWindowFlags_NoBackground);
    ImGui::PopStyleVar(2);
    ImGui::InvisibleButton("divider", {handle.width, handle.height});
    ui::mark("handle", "divider");
    if (ImGui::IsItemHovered() || ImGui::IsItemActive()) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const float middle = std::clamp(x, view.x + 1, view.x + view.width - 1);
    list.AddLine({middle, view.y}, {middle, view.y + view.height}, IM_COL32_WHITE, std::max(1.0F, em / 9));
    list.AddCircleFilled({handle.x + wide / 2, view.y + view.height / 2}, 0.38F * em, IM_COL32_WHITE);
    const ImGuiIO& io = ImGui::GetIO();
    if (ImGui::IsItemActive() && io.MouseDelta.x != 0)
        commands.push(SetDivider{static_cast<double>(std::clamp((io.MousePos.x - view.x) / view.width, 0.0F, 1.0F))});
    ui::tip("Drag: the profile on the left, the one it is compared with on the right.");
    ImGui::End();
}

} // namespace fjell::editor
