// How the picture is drawn, what lies over it, and how large the interface is.
#include <bit>
#include <cmath>
#include <cstdio>

#include "editor/panels/graph.h"
#include "editor/panels/panels.h"
#include "fjell/gl/palette.h"

namespace fjell::editor {

namespace {

struct Choice {
    const char *label, *about;
};
constexpr Choice modes[] = {
    {"Shaded", "Colours and light, as in a game."},
    {"Wire", "Shaded, with the edges of all triangles."},
    {"Levels", "Every triangle in its level's colour: coarse ones violet and blue, fine ones orange and red."},
    {"Tiles", "Every tile in a colour different from its neighbours."},
    {"Mips",
     "Coloured by the mip that is drawn: the pack's finest is red, the smallest violet. Black: not loaded yet."},
    {"Residency", "Coloured by the finest geometry in memory, whether it is drawn or not."},
    {"Distance", "White at the near plane, black beyond the terrain; logarithmic."},
};
static_assert(std::size(modes) == flight::picture_modes, "a mode was added: say what it shows");
constexpr Choice overlay_choices[] = {
    {"Wireframe", "Edges of all triangles."},
    {"Tile borders", "Borders of tiles, on the ground and in the overview."},
    {"Page borders", "Borders of pages, which are loaded and evicted as a whole."},
    {"Bounding spheres", "Around vertices, as refinement uses them."},
    {"Culled", "With refinement frozen: culled tiles, and the frustum of the frozen camera."},
    {"True error", "How far the mesh is from the full-resolution terrain, in pixels; hatched where it exceeds the "
                   "bound. Takes the picture's place; all heights are read first."},
    {"Camera path", "The path, its points and the recording in progress; hidden during playback."},
    {"Contours", "Lines of equal height, every fifth one wider."},
    {"Slope", "Steep ground in bands that begin at 15, 25, 35 and 45 degrees."},
};
static_assert(std::size(overlay_choices) == overlays, "an overlay was added: say what it shows");

void note(const char* text) {
    ImGui::PushStyleColor(ImGuiCol_Text, ui::quiet);
    ImGui::TextWrapped("%s", text);
    ImGui::PopStyleColor();
}

// One entry after the other, in as many lines as it takes.
class Legend {
public:
    void entry(ImU32 square, const char* text) {
        const float em = ImGui::GetFontSize();
        const float width = ImGui::CalcTextSize(text).x + 0.9F * em + 2 * ImGui::GetStyle().ItemSpacing.x;
        if (!first_) {
            ImGui::SameLine();
            if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
        }
        first_ = false;
        ui::swatch(square);
        ImGui::TextUnformatted(text);
    }

private:
    bool first_ = true;
};

void step_legend(const Scene& scene, int tile_log2, bool levels) {
    Legend legend;
    char text[24];
    for (int i = 0; i <= (levels ? 2 * tile_log2 : tile_log2); ++i) {
        const double step_m = scene.spacing_m[0] * (1u << i);
        if (levels)
            std::snprintf(text, sizeof text, "%d", i);
        else
            std::snprintf(text, sizeof text, step_m < 10000 ? "%.4g m" : "%.3g km",
                          step_m < 10000 ? step_m : step_m / 1000);
        legend.entry(ui::colour(levels ? gl::level_rgb(i, tile_log2) : gl::step_rgb(i, tile_log2)), text);
    }
}

// 0 is the pack's finest.
void mip_legend(int mips) {
    if (mips == 0) {
        note("This pack has no maps.");
        return;
    }
    Legend legend;
    char text[16];
    for (int i = 0; i < mips; ++i) {
        std::snprintf(text, sizeof text, "%d", i);
        legend.entry(ui::colour(gl::mip_rgb(i, mips)), text);
    }
}

// In pixels: what is promised is red.
void error_legend(double promised_px) {
    Legend legend;
    char text[40];
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        std::snprintf(text, sizeof text, share < 1 ? "%.3g" : "%.3g px: the bound", share * promised_px);
        legend.entry(ui::colour(gl::error_rgb(share)), text);
    }
    legend.entry(ui::colour(gl::error_stops[4]), "hatched: above the bound");
    legend.entry(ui::colour(gl::error_stops[5]), "nothing to compare with");
}

void draw_legend(const State& state) {
    const int tile_log2 = static_cast<int>(std::bit_width(state.scene.tile_cells)) - 1;
    switch (state.interface.mode) {
    case flight::PictureMode::levels: step_legend(state.scene, tile_log2, true); break;
    case flight::PictureMode::residency: step_legend(state.scene, tile_log2, false); break;
    case flight::PictureMode::mips: mip_legend(static_cast<int>(state.scene.mips)); break;
    default: break;
    }
}

void explain_relief(const State& state) {
    char text[80];
    if (state.shows(Overlay::contours)) {
        const double every_m = contour_interval_m(state.scene);
        std::snprintf(text, sizeof text, "Contours every %.4g m, wider every %.4g m.", every_m, 5 * every_m);
        note(text);
    }
    if (!state.shows(Overlay::slope)) return;
    note("Slope, degrees:");
    Legend legend;
    for (std::size_t i = 0; i < std::size(gl::slope_rgb); ++i) {
        std::snprintf(text, sizeof text, i + 1 < std::size(gl::slope_rgb) ? "from %d" : "%d and steeper",
                      gl::slope_bands_deg[i]);
        legend.entry(ui::colour(gl::slope_rgb[i]), text);
    }
}

void explain_overlays(const State& state) {
    explain_relief(state);
    if (state.shows(Overlay::culled) && !state.eye.frozen)
        note("Culled tiles are out of view: freeze refinement (F), and look from elsewhere.");
    if (!state.shows(Overlay::error)) return;
    if (state.heights_share < 0) return note("The heights to compare with cannot be read; see Help > Messages.");
    if (state.heights_share < 1) {
        char text[48];
        std::snprintf(text, sizeof text, "Reading heights: %.0f%%", 100 * state.heights_share);
        return note(text);
    }
    note("True error:");
    error_legend(state.document.profile().refine.error_px);
}

// Two stand side by side: what explains them below is seen on small screens too.
void second_column(int i) {
    if (i % 2 != 0) ImGui::SameLine(0.5F * ImGui::GetContentRegionMax().x);
}

void draw_scale(const State& state, Commands& commands) {
    ui::heading("Interface");
    constexpr double scales[] = {0.75, 1, 1.25, 1.5, 2, 2.5, 3};
    constexpr const char* names[] = {"75%", "100%", "125%", "150%", "200%", "250%", "300%"};
    for (std::size_t i = 0; i < std::size(scales); ++i) {
        const float width = ImGui::CalcTextSize(names[i]).x + 2 * ImGui::GetStyle().FramePadding.x;
        if (i > 0) {
            ImGui::SameLine();
            if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
        }
        const bool on = std::abs(state.interface.scale - scales[i]) < 0.01;
        if (!on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
        if (ImGui::Button(names[i])) commands.push(SetScale{scales[i]});
        ui::mark("scale", names[i]);
        ui::tip("Size of text and controls.");
        if (!on) ImGui::PopStyleColor();
    }
}

} // namespace

const char* label_of(flight::PictureMode mode) {
    return modes[static_cast<std::size_t>(mode)].label;
}

const char* label_of(Overlay overlay) {
    return overlay_choices[static_cast<std::size_t>(overlay)].label;
}

void draw_picture(const State& state, Commands& commands) {
    ui::heading("Picture mode (M: next)");
    for (int i = 0; i < flight::picture_modes; ++i) {
        const auto mode = static_cast<flight::PictureMode>(i);
        second_column(i);
        if (ImGui::RadioButton(modes[i].label, state.interface.mode == mode)) commands.push(SetPictureMode{mode});
        ui::mark("mode", flight::picture_mode_names[i]);
        ui::tip(modes[i].about);
    }
    note(modes[static_cast<int>(state.interface.mode)].about);
    const bool hidden = state.shows(Overlay::error) && state.heights_share >= 1;
    if (state.scene.open() && !hidden) draw_legend(state);
    ui::heading("Overlays");
    for (int i = 0; i < overlays; ++i) {
        bool on = state.interface.overlay[static_cast<std::size_t>(i)];
        second_column(i);
        if (ImGui::Checkbox(overlay_choices[i].label, &on)) commands.push(SetOverlay{static_cast<Overlay>(i), on});
        ui::mark("overlay", overlay_names[i]);
        ui::tip(overlay_choices[i].about);
    }
    if (state.scene.open()) explain_overlays(state);
    if (state.scene.open()) draw_compare_picture(state, commands);
    draw_scale(state, commands);
}

} // namespace fjell::editor
