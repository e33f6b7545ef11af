// What was found in the files that the dialog bakes, in pictures and figures, and below what will happen, in words,
// size and time.
#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <string>

#include "editor/number_text.h"
#include "editor/panels/bake_form.h"
#include "editor/panels/ui.h"

namespace fjell::editor::bake_dialog {

namespace {

constexpr double bytes_a_sample[] = {1.3, 3.0}; // of packs: smooth large fields, rough small ones; with maps
constexpr double samples_a_second = 6e6, warped_a_second = 3e6; // on two cores; about
// What maps add a sample, in the order of their names: docs/notes/horizons.md and materials.md.
constexpr double control_bytes[] = {9.9, 2.6, 0.7}, control_a_second[] = {2e6, 6e6, 2e7};
constexpr double horizon_bytes[] = {0, 2.7, 0.7}, horizons_a_second[] = {0, 6e6, 1.3e7};
constexpr float picture_em = 10.5F; // high

void draw_strip(const HeightFacts& f) {
    const float em = ImGui::GetFontSize();
    const ImVec2 from = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x, high = 0.6F * em;
    for (std::size_t i = 0; i < ramp_strip; ++i) {
        const float x0 = from.x + width * static_cast<float>(i) / ramp_strip;
        const float x1 = from.x + width * static_cast<float>(i + 1) / ramp_strip;
        ImGui::GetWindowDrawList()->AddRectFilled({x0, from.y}, {x1, from.y + high}, ui::colour(f.strip[i]));
    }
    ImGui::Dummy({width, high});
    ui::tip("The ramp's colours, from the lowest height to the highest.");
}

// As large as there is room for it; the room is there before it is.
void draw_pictures(const BakeDraft& draft) {
    const float room = ImGui::GetContentRegionAvail().x, most = picture_em * ImGui::GetFontSize();
    const float top = ImGui::GetCursorPosY();
    const HeightFacts& f = draft.facts;
    if (draft.texture != 0) {
        const auto w = static_cast<float>(f.width_px), h = static_cast<float>(f.height_px);
        const float scale = std::min(room / w, most / h);
        ImGui::Image(reinterpret_cast<ImTextureID>(std::uintptr_t{draft.texture}), {w * scale, h * scale});
        ui::mark("bake", "picture");
        ui::tip(f.image_px != 0 ? "The heights in the colours of the ramp, and beside them the texture."
                                : "The heights in the colours that the terrain will have; where rules lay materials, "
                                  "in the colours of the list below.");
    }
    ImGui::SetCursorPosY(top + most + ImGui::GetStyle().ItemSpacing.y);
}

// "label   value", the value on the right.
void fact(const char* label, const char* format, ...) IM_FMTARGS(2);
void fact(const char* label, const char* format, ...) {
    char value[96];
    va_list arguments;
    va_start(arguments, format);
    (void)std::vsnprintf(value, sizeof value, format, arguments);
    va_end(arguments);
    ImGui::TextUnformatted(label);
    ImGui::SameLine();
    const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(value).x;
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(room, 0.0F));
    ImGui::TextUnformatted(value);
}

// What the rules lay, the most first, in the picture's colours.
void draw_layers(const HeightFacts& f) {
    if (f.rules == 0) return;
    constexpr std::size_t most = 5;
    fact("Rules", "%zu, %zu materials", f.rules, f.layers.size());
    for (std::size_t i = 0; i < std::min(f.layers.size(), most); ++i) {
        ui::swatch(ui::colour(f.layers[i].rgb));
        fact(f.layers[i].name.c_str(), "%s%.0f%%", "about ", 100 * f.layers[i].share);
    }
    double rest = 0;
    for (std::size_t i = most; i < f.layers.size(); ++i) rest += f.layers[i].share;
    if (f.layers.size() > most) fact("others", "%s%.0f%%", "about ", 100 * rest);
    if (f.bare_share >= 0.005) fact("without a material", "%s%.0f%%", "about ", 100 * f.bare_share);
}

} // namespace

void draw_facts(const BakeDraft& draft) {
    draw_pictures(draft);
    const HeightFacts& f = draft.facts;
    if (!f.known) {
        ImGui::PushTextWrapPos(0);
        ImGui::TextDisabled("%s", draft.looking ? "Reading the heights..."
                                                : "Size, heights and coordinates of the file are shown here.");
        ImGui::PopTextWrapPos();
        return;
    }
    draw_strip(f);
    const char* const about = f.all_read ? "" : "about ";
    fact("Heights", "%s%s to %s m", about, metre_text(f.least_m).text, metre_text(f.most_m).text);
    fact("Samples", "%s x %s", grouped(f.columns).c_str(), grouped(f.rows).c_str());
    if (f.has_spacing) {
        if (f.spacing_m[0] == f.spacing_m[1])
            fact("Spacing", "%.4g m", f.spacing_m[0]);
        else
            fact("Spacing", "%.4g x %.4g m", f.spacing_m[0], f.spacing_m[1]);
        fact("Extents", "%s x %s m", metre_text((f.columns - 1) * f.spacing_m[0]).text,
             metre_text((f.rows - 1) * f.spacing_m[1]).text);
    } else { // the rows are there already, or a click that takes what is proposed would move the buttons
        fact("Spacing", "-");
        fact("Extents", "-");
    }
    fact("No data", "%s%.3g%%", about, 100 * f.void_share);
    if (!f.image.empty()) fact("Texture", "%s", f.image.c_str());
    draw_layers(f);
    ImGui::PushTextWrapPos(0);
    if (!f.unit_named) ImGui::TextColored(ImColor(ui::quiet).Value, "No unit is named: heights are taken as metres");
    ImGui::TextColored(ImColor(ui::quiet).Value, "%s%s%s",
                       f.crs.empty() ? "No coordinate reference system" : f.crs.c_str(),
                       f.reprojected_from.empty() ? "" : ", reprojected from ", f.reprojected_from.c_str());
    ImGui::PopTextWrapPos();
}

const char* name_in(const std::string& path) {
    const std::size_t slash = path.rfind('/');
    return path.c_str() + (slash == std::string::npos ? 0 : slash + 1);
}

namespace {

// What control maps and horizons add to the pack, a sample.
double maps_bytes(const BakePack& b) {
    double bytes = 0;
    if (!b.rules.empty()) bytes += control_bytes[index_of(b.control, control_names)];
    if (!b.horizons.empty()) bytes += horizon_bytes[index_of(b.horizons, horizon_names)];
    return bytes;
}

double seconds_a_sample(const BakeDraft& d) {
    const BakePack& b = d.pack;
    double seconds = 1 / (d.facts.reprojected_from.empty() ? samples_a_second : warped_a_second);
    if (!b.rules.empty()) seconds += 1 / control_a_second[index_of(b.control, control_names)];
    if (!b.horizons.empty()) seconds += 1 / horizons_a_second[index_of(b.horizons, horizon_names)];
    return seconds;
}

} // namespace

void draw_plan(const State& state) {
    const BakeDraft& d = state.bake;
    const HeightFacts& f = d.facts;
    ImGui::PushTextWrapPos(0);
    if (d.looking) {
        ImGui::TextDisabled("Reading the files...");
    } else if (d.pack.inputs.empty()) {
        ImGui::TextDisabled("Choose a file of heights: browse, type, or drop it on the window.");
    } else if (!f.problem.empty() || !d.output_problem.empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, ui::warning_colour);
        if (f.problem.empty())
            ImGui::TextUnformatted(d.output_problem.c_str());
        else if (f.proposed.empty() || f.because.empty())
            ImGui::TextUnformatted(f.problem.c_str());
        else
            ImGui::Text("%s. Proposed: %s, %s.", f.problem.c_str(), f.proposed.c_str(), f.because.c_str());
        ImGui::PopStyleColor();
    } else {
        const double samples = static_cast<double>(f.columns) * f.rows;
        const double seconds = samples * seconds_a_sample(d);
        char time[48];
        if (seconds > 8)
            (void)std::snprintf(time, sizeof time, "about %.0f %s", seconds < 90 ? seconds : seconds / 60,
                                seconds < 90 ? "seconds" : "minutes");
        else
            (void)std::snprintf(time, sizeof time, "a few seconds");
        ImGui::Text("Writes %s: %s to %s, in %s, in the background.%s %s%s%s", name_in(d.pack.output),
                    byte_text(samples * (bytes_a_sample[0] + maps_bytes(d.pack))).text,
                    byte_text(samples * (bytes_a_sample[1] + maps_bytes(d.pack))).text, time,
                    d.output_exists ? " A pack of that name is there; you are asked before it is replaced." : "",
                    state.scene.open() ? "When it is done, you are asked whether to leave " : "Then it is opened.",
                    state.scene.open() ? name_in(state.scene.path) : "", state.scene.open() ? "." : "");
    }
    ImGui::PopTextWrapPos();
    ui::mark("bake", "plan");
}

} // namespace fjell::editor::bake_dialog
