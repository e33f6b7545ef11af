// How the picture is drawn, what lies over it, and how large the interface is.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/graph.h"
#include "editor/panels/panels.h"
#include "fjell/gl/palette.h"
#include "fjell/profile.h"

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
static_assert(std::size(modes) == session::picture_modes, "a mode was added: say what it shows");
constexpr Choice overlay_choices[] = {
    {"Wireframe", "Edges of all triangles."},
    {"Tile borders", "Borders of tiles, on the ground and in the overview."},
    {"Page borders", "Borders of pages, which are loaded and evicted as a whole."},
    {"Bounding spheres", "The spheres around vertices that refinement uses."},
    {"Culled", "With refinement frozen: culled tiles, and the frustum of the frozen camera."},
    {"True error",
     "The distance of the mesh from the full-resolution terrain, in pixels. It is hatched above the bound. "
     "It replaces the picture; all heights are read first."},
    {"Camera path", "The path, its points and the recording in progress; hidden during playback."},
    {"Contours", "Lines of equal height, every fifth one wider."},
    {"Slope", "Steep ground in bands that begin at 15, 25, 35 and 45 degrees."},
};
static_assert(std::size(overlay_choices) == overlays, "an overlay was added: say what it shows");

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
        ui::note("This pack has no maps.");
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
    case session::PictureMode::levels: step_legend(state.scene, tile_log2, true); break;
    case session::PictureMode::residency: step_legend(state.scene, tile_log2, false); break;
    case session::PictureMode::mips: mip_legend(static_cast<int>(state.scene.mips)); break;
    default: break;
    }
}

void explain_relief(const State& state) {
    char text[80];
    if (state.shows(Overlay::contours)) {
        const double every_m = contour_interval_m(state);
        std::snprintf(text, sizeof text, "Contours every %.4g m, wider every %.4g m.", every_m, 5 * every_m);
        ui::note(text);
    }
    if (!state.shows(Overlay::slope)) return;
    ui::note("Slope, degrees:");
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
        ui::note("Culled tiles are out of view: freeze refinement (F), and look from elsewhere.");
    if (!state.shows(Overlay::error)) return;
    if (state.heights_share < 0) return ui::note("The full-resolution heights cannot be read; see Help > Messages.");
    if (state.heights_share < 1) {
        char text[48];
        std::snprintf(text, sizeof text, "Reading heights: %.0f%%", 100 * state.heights_share);
        return ui::note(text);
    }
    ui::note("True error:");
    error_legend(state.document.profile().refine.max_error_px);
}

void draw_interval(const State& state, Commands& commands) {
    double every_m = state.interface.contour_m;
    ImGui::SetNextItemWidth(7 * ImGui::GetFontSize());
    const bool entered = ImGui::InputDouble("m between contours", &every_m, 0, 0, every_m > 0 ? "%.6g" : "auto",
                                            ImGuiInputTextFlags_EnterReturnsTrue);
    ui::control("overlay", "contour_m", "Metres between contours, 0.01 to 10,000. 0: as suits the terrain.");
    if (entered) commands.push(SetContours{every_m > 0 ? std::clamp(every_m, least_contour_m, most_contour_m) : 0});
}

// Two stand side by side: what explains them below is seen on small screens too.
void second_column(int i) {
    if (i % 2 != 0) ImGui::SameLine(0.5F * ImGui::GetContentRegionMax().x);
}

} // namespace

const char* label_of(session::PictureMode mode) {
    return modes[static_cast<std::size_t>(mode)].label;
}

const char* label_of(Overlay overlay) {
    return overlay_choices[static_cast<std::size_t>(overlay)].label;
}

void draw_modes(const State& state, PanelState&, Commands& commands) {
    for (int i = 0; i < session::picture_modes; ++i) {
        const auto mode = static_cast<session::PictureMode>(i);
        second_column(i);
        if (ImGui::RadioButton(modes[i].label, state.interface.mode == mode)) commands.push(SetPictureMode{mode});
        ui::control("mode", session::picture_mode_names[i], modes[i].about);
    }
    ui::note(modes[static_cast<int>(state.interface.mode)].about);
    const bool hidden = state.shows(Overlay::error) && state.heights_share >= 1;
    if (state.scene.open() && !hidden) draw_legend(state);
}

void draw_overlays(const State& state, PanelState&, Commands& commands) {
    for (int i = 0; i < overlays; ++i) {
        bool on = state.interface.overlay[static_cast<std::size_t>(i)];
        second_column(i);
        if (ImGui::Checkbox(overlay_choices[i].label, &on)) commands.push(SetOverlay{static_cast<Overlay>(i), on});
        ui::control("overlay", overlay_names[i], overlay_choices[i].about);
    }
    if (state.shows(Overlay::contours)) draw_interval(state, commands);
    if (state.scene.open()) explain_overlays(state);
}

void draw_scale(const State& state, PanelState&, Commands& commands) {
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
        ui::control("scale", names[i], "Size of text and controls.");
        if (!on) ImGui::PopStyleColor();
    }
}

// --- Two profiles in one picture: what is compared, and the divider between them.

namespace {

void draw_choice(const State& state, PanelState& own, Commands& commands) {
    const ComparedPicture& c = state.compared;
    constexpr const char *labels[] = {"off", "threshold", "half the triangles", "profile"},
                         *abouts[] = {
                             "The profile alone.", "This profile at another threshold, in the same picture.",
                             "This profile at the threshold that draws half the triangles, in the same picture.",
                             "The profile chosen with File > Compare profiles, in the same picture."};
    for (int i = 0; i < 4; ++i) {
        const auto with = static_cast<CompareWith>(i);
        second_column(i);
        const bool can = with != CompareWith::profile || state.document.compared() != nullptr;
        ImGui::BeginDisabled(!can);
        if (ImGui::RadioButton(labels[i], c.with == with)) commands.push(ComparePictures{with, own.compared_px});
        ImGui::EndDisabled();
        ui::control("compare-picture", compare_with_names[i],
                    can ? abouts[i] : "First choose a profile with File > Compare profiles.");
    }
    if (c.with != CompareWith::threshold) return;
    double px = c.error_px;
    ImGui::SetNextItemWidth(7 * ImGui::GetFontSize());
    if (ImGui::InputDouble("px", &px, 0, 0, "%.4g", ImGuiInputTextFlags_EnterReturnsTrue)) {
        own.compared_px = std::clamp(px, ranges::least_threshold_px, ranges::most_threshold_px);
        commands.push(ComparePictures{CompareWith::threshold, own.compared_px});
    }
    ui::control("compare-picture", "error_px", "The other threshold, in pixels. Enter applies it.");
}

// Its text with room around it; where there is too little on the divider's side, as near as it fits.
ui::Rect side_plate(const char* text, bool right_aligned, float x, const ui::Rect& room) {
    const float em = ImGui::GetFontSize();
    const ImVec2 size = ImGui::CalcTextSize(text);
    const float width = size.x + em, least = room.x + 0.3F * em, most = room.x + room.width - width - 0.3F * em;
    const float wanted = right_aligned ? x - 0.5F * em - width : x + 0.5F * em;
    return {std::max(std::min(wanted, most), least), room.y + 0.6F * em, width, size.y + 0.5F * em};
}

void draw_side(ImDrawList& list, const ui::Rect& at, const char* text, ImU32 colour) {
    const float em = ImGui::GetFontSize();
    list.AddRectFilled({at.x, at.y}, {at.x + at.width, at.y + at.height}, IM_COL32(12, 14, 18, 205), 0.25F * em);
    list.AddText({at.x + 0.5F * em, at.y + 0.25F * em}, colour, text);
}

// "laptop.toml", what was asked of it and kept, and what it took.
struct Side {
    char text[256] = "";
    ImU32 colour = IM_COL32_WHITE;
};

Side side_of(const char* name, double asked_px, double kept_px, std::uint32_t exhausted, std::uint32_t triangles) {
    Side side;
    char kept[32] = "unbounded";
    if (kept_px < 1e6) std::snprintf(kept, sizeof kept, "%.3g px", kept_px);
    const char* const budget = exhausted_budget(exhausted);
    std::snprintf(side.text, sizeof side.text, "%.60s\n%.3g px asked, %s kept%s%s%s\n%s triangles", name, asked_px,
                  kept, *budget != '\0' ? ",\n" : "", budget, *budget != '\0' ? " exhausted" : "",
                  count_text(triangles).text);
    if (kept_px > 1.001 * asked_px) side.colour = ui::warning_colour;
    return side;
}

// How many pixels differ, and in the picture of the difference what its colours say.
void tell_difference(const State& state, const ui::Rect& view, ImDrawList& list) {
    const ComparedPicture& c = state.compared;
    if (c.differing < 0) return;
    const float em = ImGui::GetFontSize();
    char text[64];
    std::snprintf(text, sizeof text, "%.*f%% of the pixels differ visibly", c.differing < 0.1 ? 2 : 1,
                  100 * c.differing);
    constexpr struct {
        ImU32 colour;
        const char* text;
    } steps[] = {{IM_COL32(0, 0, 0, 255), "0"},
                 {IM_COL32(38, 77, 204, 255), "11"},
                 {IM_COL32(245, 214, 51, 255), "21"},
                 {IM_COL32(255, 255, 255, 255), "32 of 255 and more"}};
    const bool legend = c.view == CompareView::difference;
    float width = ImGui::CalcTextSize(text).x, row = 0;
    for (const auto& step : steps) row += 1.6F * em + ImGui::CalcTextSize(step.text).x;
    if (legend) width = std::max(width, row);
    const float height = (legend ? 2.9F : 1.5F) * em;
    const ImVec2 at{view.x + view.width / 2 - width / 2, view.y + view.height - height - 3 * em};
    list.AddRectFilled({at.x - 0.5F * em, at.y - 0.25F * em}, {at.x + width + 0.5F * em, at.y + height - 0.25F * em},
                       IM_COL32(12, 14, 18, 205), 0.25F * em);
    list.AddText(at, IM_COL32_WHITE, text);
    if (!legend) return;
    float x = at.x;
    const float y = at.y + 1.4F * em;
    for (const auto& step : steps) {
        list.AddRectFilled({x, y}, {x + em, y + em}, step.colour);
        list.AddRect({x, y}, {x + em, y + em}, ui::quiet);
        list.AddText({x + 1.2F * em, y}, IM_COL32_WHITE, step.text);
        x += 1.6F * em + ImGui::CalcTextSize(step.text).x;
    }
}

const char* name_of_other(const State& state) {
    const ComparedPicture& c = state.compared;
    if (c.with == CompareWith::half) return "half the triangles";
    if (c.with == CompareWith::threshold) return "another threshold";
    const std::string& path = state.document.compared_path();
    return path.empty() ? "as it was saved" : file_name(path);
}

void name_sides(const State& state, const ui::Rect& view, float x) {
    const ComparedPicture& c = state.compared;
    const session::FrameEntry& e = state.measures.last();
    const Side mine = side_of(state.files.profile_name.c_str(), state.document.profile().refine.max_error_px,
                              e.error_bound_px, e.exhausted, e.triangles_drawn);
    Side theirs;
    if (c.there)
        theirs = side_of(name_of_other(state), c.asked_px, c.kept_px, c.exhausted, c.triangles);
    else
        std::snprintf(theirs.text, sizeof theirs.text, "%.60s\nopening", name_of_other(state));
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const float em = ImGui::GetFontSize();
    ui::Rect room = beside_probe(state, view);
    if (room.height < 12 * em) return;      // the probe's plate and others at the bottom take all there is
    if (state.eye.frozen) room.y += 2 * em; // below the plate that says so
    list.PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height});
    const ui::Rect left = side_plate(mine.text, true, x, room);
    ui::Rect right = side_plate(theirs.text, false, x, room);
    if (right.x < left.x + left.width) right.y += left.height + 0.3F * em;
    draw_side(list, left, mine.text, mine.colour);
    draw_side(list, right, theirs.text, theirs.colour);
    tell_difference(state, view, list);
    list.PopClipRect();
}

} // namespace

void draw_compare_picture(const State& state, PanelState& own, Commands& commands) {
    draw_choice(state, own, commands);
    if (state.compared.with == CompareWith::nothing) return;
    constexpr const char* labels[] = {"side by side", "difference"};
    for (int i = 0; i < 2; ++i) {
        if (i > 0) ImGui::SameLine();
        const auto view = static_cast<CompareView>(i);
        if (ImGui::RadioButton(labels[i], state.compared.view == view)) commands.push(SetCompareView{view});
        ui::control("compare-picture", compare_view_names[i],
                    i == 0
                        ? "On the left the profile, on the right the other one; drag the divider in the picture."
                        : "Black where both pictures are the same, through blue and yellow to white where they differ "
                          "by an eighth of full brightness or more.");
    }
    if (state.compared.view == CompareView::difference) return;
    auto percent = static_cast<float>(100 * state.compared.divider);
    ImGui::SetNextItemWidth(7 * ImGui::GetFontSize());
    if (ImGui::SliderFloat("Divider", &percent, 0, 100, "%.0f%%", ImGuiSliderFlags_NoInput))
        commands.push(SetDivider{static_cast<double>(percent) / 100});
    ui::control("compare-picture", "divider",
                "The place of the divider, in percent of the picture's width. Or drag it.");
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
