// How many of the triangles that are drawn are of which level.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/graph.h"
#include "editor/panels/panels.h"
#include "fjell/gl/palette.h"

namespace fjell::editor {

namespace {

// "0  64 cells": a bar as long as its share of the fullest level.
void level_bar(const LevelHistogram& levels, std::uint32_t level, int tile_log2, double cell_m) {
    const float em = ImGui::GetFontSize(), names = 6 * em, numbers = 4.8F * em;
    const ImVec2 from = ImGui::GetCursorScreenPos();
    const float width = std::max(ImGui::GetContentRegionAvail().x, names + numbers + em);
    const float room = width - names - numbers;
    const std::uint32_t count = levels.triangles[level];
    ImDrawList& list = *ImGui::GetWindowDrawList();
    char text[32];
    // Legs of level 2 k are 2^(tile_log2 - k) cells long.
    const double leg_m = cell_m * std::exp2(tile_log2 - level / 2.0);
    if (leg_m >= 1000)
        std::snprintf(text, sizeof text, "%2u  %.3g km", level, leg_m / 1000);
    else
        std::snprintf(text, sizeof text, "%2u  %.3g m", level, leg_m);
    list.AddText(from, ImGui::GetColorU32(ImGuiCol_Text), text);
    const float share = levels.most > 0 ? static_cast<float>(count) / static_cast<float>(levels.most) : 0;
    const float x = from.x + names;
    list.AddRectFilled({x, from.y + 0.1F * em}, {x + std::max(share * room, count > 0 ? 1.0F : 0.0F), from.y + em},
                       ui::colour(gl::level_rgb(static_cast<int>(level), tile_log2)));
    const NumberText shown = count_text(count);
    const char* const number = shown.text;
    list.AddText({from.x + width - ImGui::CalcTextSize(number).x, from.y}, ImGui::GetColorU32(ImGuiCol_Text), number);
    ImGui::Dummy({width, 1.15F * em});
    char about[96];
    std::snprintf(about, sizeof about, "level %u: %s triangles with legs of %.4g m", level, number, leg_m);
    ui::tip(about);
}

} // namespace

void draw_levels(const State& state, Commands& commands) {
    if (!state.scene.open()) {
        ImGui::TextWrapped("No terrain is open.");
        return;
    }
    const LevelHistogram& levels = state.measures.levels();
    const int tile_log2 = static_cast<int>(std::bit_width(state.scene.tile_cells)) - 1;
    std::uint64_t all = 0;
    for (const std::uint32_t count : levels.triangles) all += count;
    ui::heading("Triangles drawn, by level");
    ui::tip("Level 0: the two base triangles of a tile; each further level halves them. Legs are a triangle's two "
            "equal sides.");
    for (std::uint32_t i = 0; i < levels.levels; ++i)
        level_bar(levels, i, tile_log2, std::min(state.scene.spacing_m[0], state.scene.spacing_m[1]));
    ui::row("Total", "%s", count_text(static_cast<double>(all)).text);
    bool shown = state.interface.mode == flight::PictureMode::levels;
    if (ImGui::Checkbox("Colour the picture by level", &shown))
        commands.push(SetPictureMode{shown ? flight::PictureMode::levels : flight::PictureMode::shaded});
    ui::mark("levels", "colour");
    ui::tip("Every triangle in its level's colour, as here. Costs almost nothing.");
}

} // namespace fjell::editor
