// Benchmarks that were flown: charted along their path, compared, and their worst places listed.
#include "editor/panels/runs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/graph.h"
#include "editor/panels/keyboard.h"
#include "flight/log.h"

namespace fjell::editor {

namespace {

// Told apart with any kind of colour vision (Okabe and Ito), light enough for the panels.
constexpr ImU32 run_colours[most_runs] = {IM_COL32(86, 180, 233, 255),  IM_COL32(230, 159, 0, 255),
                                          IM_COL32(0, 178, 135, 255),   IM_COL32(240, 228, 66, 255),
                                          IM_COL32(204, 121, 167, 255), IM_COL32(213, 110, 40, 255),
                                          IM_COL32(120, 150, 255, 255), IM_COL32(200, 200, 200, 255)};
constexpr ImU32 strip_paper = IM_COL32(28, 31, 37, 255), strip_grid = IM_COL32(255, 255, 255, 26);
constexpr float unbounded_px = 1e6F;

using PlaceValue = float (*)(const FlownPlace&);
float ms_of(const FlownPlace& p) {
    return p.update_us / 1000;
}
float px_of(const FlownPlace& p) {
    return p.error_px;
}

// What the scale reaches to: without the dearest hundredth of all places, which get a mark at the rim.
float usual_most(const State& state, PlaceValue value) {
    std::array<float, most_places> sorted;
    float most = 0;
    for (const auto& run : state.runs.all) {
        const std::size_t n = std::min(run->places.size(), most_places);
        if (n == 0) continue;
        for (std::size_t i = 0; i < n; ++i) sorted[i] = value(run->places[i]);
        const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(n - 1 - n / 100);
        std::nth_element(sorted.begin(), at, sorted.begin() + static_cast<std::ptrdiff_t>(n));
        if (*at < unbounded_px) most = std::max(most, *at);
    }
    return most;
}

struct Strip {
    const char *name, *unit;
    PlaceValue value;
    double line; // across: a budget or the threshold; 0: none
    float height_em;
};

void draw_run_curve(ImDrawList& list, const FlownRun& run, const Strip& strip, ImVec2 low, ImVec2 high, double most,
                    ImU32 colour, bool latest) {
    std::array<ImVec2, most_places> points;
    const std::size_t n = std::min(run.places.size(), most_places);
    const float em = ImGui::GetFontSize(), w = 0.22F * em;
    float marked = low.x - 4 * w; // the last mark: none over another
    for (std::size_t i = 0; i < n; ++i) {
        const double share = static_cast<double>(strip.value(run.places[i])) / most;
        points[i] = {low.x + static_cast<float>(run.share_of(i)) * (high.x - low.x),
                     high.y - static_cast<float>(std::min(share, 1.0)) * (high.y - low.y)};
        if (share > 1.0001 && latest && points[i].x >= marked + 2 * w) {
            const float x = marked = points[i].x;
            list.AddTriangleFilled({x, low.y}, {x - w, low.y + 2 * w}, {x + w, low.y + 2 * w}, ui::warning_colour);
        }
    }
    list.AddPolyline(points.data(), static_cast<int>(n), colour, 0, std::max(1.0F, em / (latest ? 9.0F : 14.0F)));
}

// Where budgets were exhausted, along the foot of a strip.
void draw_exhausted(ImDrawList& list, const FlownRun& run, ImVec2 low, ImVec2 high) {
    const float em = ImGui::GetFontSize();
    const float wide =
        std::max((high.x - low.x) / static_cast<float>(std::max<std::size_t>(run.places.size(), 1)), 1.0F);
    for (std::size_t i = 0; i < run.places.size(); ++i) {
        if (run.places[i].exhausted == 0) continue;
        const float x = low.x + static_cast<float>(run.share_of(i)) * (high.x - low.x);
        list.AddRectFilled({x - wide / 2, high.y}, {x + wide / 2, high.y + 0.35F * em}, ui::bad);
    }
}

void tell_place(const State& state, double share, const Strip& strip) {
    ImGui::BeginTooltip();
    ImGui::Text("%.0f%% of the path", 100 * share);
    for (std::size_t r = 0; r < state.runs.all.size(); ++r) {
        const FlownRun& run = *state.runs.all[r];
        const float value = strip.value(run.places[run.place_at(share)]);
        ImGui::PushStyleColor(ImGuiCol_Text, run_colours[r]);
        if (value >= unbounded_px)
            ImGui::Text("%.24s: unbounded", run.name.c_str());
        else
            ImGui::Text("%.24s: %.3g %s", run.name.c_str(), static_cast<double>(value), strip.unit);
        ImGui::PopStyleColor();
    }
    ImGui::TextDisabled("click: look from there");
    ImGui::EndTooltip();
}

void draw_strip(const Strip& strip, const State& state, Commands& commands) {
    const float em = ImGui::GetFontSize(), width = std::max(ImGui::GetContentRegionAvail().x, 6 * em);
    const ImVec2 from = ImGui::GetCursorScreenPos();
    const keyboard::PointerOnly by_hand; // keys have the lists of places below
    const bool clicked = ImGui::InvisibleButton(strip.name, {width, strip.height_em * em});
    ui::mark("run", strip.name);
    if (!ImGui::IsItemVisible()) return;
    const ImVec2 low{from.x + 3.6F * em, from.y + 1.5F * em},
        high{from.x + width - 1, from.y + (strip.height_em - 0.6F) * em};
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(low, high, strip_paper);
    const double most = ui::round_up(std::max(static_cast<double>(usual_most(state, strip.value)), 1.15 * strip.line));
    char text[16];
    for (int i = 0; i <= 2; ++i) {
        const float y = high.y - static_cast<float>(i) / 2 * (high.y - low.y);
        list.AddLine({low.x, y}, {high.x, y}, strip_grid);
        ui::short_number(text, most * i / 2);
        list.AddText({low.x - ImGui::CalcTextSize(text).x - 0.3F * em, y - em / 2}, ui::quiet, text);
    }
    std::snprintf(text, sizeof text, "%s, %s", strip.name, strip.unit);
    list.AddText({from.x, from.y}, ui::quiet, text);
    if (strip.line > 0) {
        const float y = high.y - static_cast<float>(strip.line / most) * (high.y - low.y);
        list.AddLine({low.x, y}, {high.x, y}, ui::warning_colour, std::max(1.0F, em / 10));
    }
    for (std::size_t r = state.runs.all.size(); r-- > 0;) // the latest over all others
        draw_run_curve(list, *state.runs.all[r], strip, low, high, most, run_colours[r], r == 0);
    draw_exhausted(list, *state.runs.all[state.runs.chosen ? state.runs.chosen->run : 0], low, high);
    if (state.runs.chosen) {
        const FlownRun& run = *state.runs.all[state.runs.chosen->run];
        const float x = low.x + static_cast<float>(run.share_of(state.runs.chosen->place)) * (high.x - low.x);
        list.AddLine({x, low.y}, {x, high.y}, IM_COL32_WHITE, std::max(1.0F, em / 10));
    }
    const double at = static_cast<double>(std::clamp((ImGui::GetMousePos().x - low.x) / (high.x - low.x), 0.0F, 1.0F));
    if (clicked) commands.push(ChoosePlace{state.runs.chosen ? state.runs.chosen->run : 0, at});
    if (ImGui::IsItemHovered()) tell_place(state, at, strip);
}

void run_column(const char* text, ImU32 colour) {
    ImGui::TableNextColumn();
    const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(text).x;
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(0.0F, room));
    ImGui::PushStyleColor(ImGuiCol_Text, colour);
    ImGui::TextUnformatted(text);
    ImGui::PopStyleColor();
}

void about_run(const FlownRun& run) {
    if (!ui::begin_tip()) return;
    ImGui::Text("%s at %.3g px: %s frames, %.1f%% of them converged; %s vertices; p99 of the error %.3g px",
                run.profile.c_str(), run.error_px, count_text(static_cast<double>(run.frames)).text,
                100 * run.converged, count_text(run.vertices).text, run.error_p99_px);
    ui::end_tip();
}

void draw_run_table(const State& state, Commands& commands) {
    if (!ImGui::BeginTable("runs", 6, ImGuiTableFlags_SizingStretchProp)) return;
    ImGui::TableSetupColumn("run", 0, 2);
    for (const char* name : {"px", "p50", "p99", "max"}) ImGui::TableSetupColumn(name, 0, 1);
    ImGui::TableSetupColumn("x", ImGuiTableColumnFlags_WidthFixed,
                            ImGui::CalcTextSize("x").x + 2 * ImGui::GetStyle().FramePadding.x);
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(ImColor(ui::quiet).Value, "update, ms");
    for (const char* name : {"px", "p50", "p99", "max"}) run_column(name, ui::quiet);
    const ImU32 text_colour = ImGui::GetColorU32(ImGuiCol_Text);
    for (std::size_t r = 0; r < state.runs.all.size(); ++r) {
        const FlownRun& run = *state.runs.all[r];
        ImGui::PushID(static_cast<int>(r));
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ui::swatch(run_colours[r]);
        ImGui::Text("%.20s", run.name.c_str());
        about_run(run);
        char px[16];
        std::snprintf(px, sizeof px, "%.3g", run.error_px);
        run_column(px, text_colour);
        for (const double us : {run.p50_us, run.p99_us, run.max_us}) run_column(ms_text(us).text, text_colour);
        ImGui::TableNextColumn();
        if (ImGui::SmallButton("x")) commands.push(ForgetRun{r});
        char name[32];
        std::snprintf(name, sizeof name, "forget.%zu", r);
        ui::mark("run", name);
        ui::tip("Removes this run from the panel; its CSV stays.");
        ImGui::PopID();
    }
    ImGui::EndTable();
}

void draw_flown_place(const FlownPlace& place, const FlownRun& run, std::size_t index, std::size_t at,
                      const State& state, Commands& commands) {
    char text[96], error[24];
    if (place.error_px >= unbounded_px)
        std::snprintf(error, sizeof error, "unbounded");
    else
        std::snprintf(error, sizeof error, "%.3g px", static_cast<double>(place.error_px));
    std::snprintf(text, sizeof text, "%3.0f%%  %s ms  %s%s", 100 * run.share_of(at),
                  ms_text(static_cast<double>(place.update_us)).text, error,
                  place.exhausted != 0 ? "  budget spent" : "");
    ImGui::PushID(static_cast<int>(at));
    const bool chosen = state.runs.chosen && state.runs.chosen->run == index && state.runs.chosen->place == at;
    if (ImGui::Selectable(text, chosen)) commands.push(ChoosePlace{index, run.share_of(at)});
    ui::tip("How far along the path, the update's time, and the largest error there. Click: look from there.");
    ImGui::PopID();
}

void draw_worst(const State& state, Commands& commands) {
    const std::size_t index = state.runs.chosen ? state.runs.chosen->run : 0;
    const FlownRun& run = *state.runs.all[index];
    constexpr const char* kinds[] = {"Slowest places", "Places beyond the threshold"};
    for (std::size_t by = 0; by < 2; ++by) {
        ui::heading(kinds[by]);
        if (run.worst[by].empty()) ImGui::TextColored(ImColor(ui::good).Value, "none");
        ImGui::PushID(kinds[by]);
        for (std::size_t i = 0; i < run.worst[by].size(); ++i) {
            const std::size_t at = run.worst[by][i];
            draw_flown_place(run.places[at], run, index, at, state, commands);
            char name[40];
            std::snprintf(name, sizeof name, "%s.%zu", by == 0 ? "dearest" : "beyond", i);
            ui::mark("run", name);
        }
        ImGui::PopID();
    }
}

void draw_heat_choice(const State& state, Commands& commands) {
    constexpr const char* labels[] = {"nothing", "time", "error"};
    ImGui::TextUnformatted("Path on the overview coloured by");
    for (int i = 0; i < 3; ++i) {
        if (i > 0) ImGui::SameLine();
        if (ImGui::RadioButton(labels[i], static_cast<int>(state.runs.heat) == i))
            commands.push(SetHeat{static_cast<Heat>(i)});
        ui::mark("heat", heat_names[i]);
        ui::tip("Colours the latest run's path on the overview in the Camera panel: blue is fast or exact, red the "
                "run's p99 time or its threshold, white beyond that.");
    }
}

// The colours of errors in as many steps as a screen tells apart: each takes nine powers, and a path has 512 places.
// Above the bound it is the last one.
ImU32 heat_colour(double share) {
    constexpr std::size_t steps = 256;
    static const std::array<ImU32, steps + 2> colours = [] {
        std::array<ImU32, steps + 2> all{};
        for (std::size_t i = 0; i <= steps; ++i)
            all[i] = ui::colour(gl::error_rgb(static_cast<double>(i) / static_cast<double>(steps)));
        all[steps + 1] = ui::colour(gl::error_rgb(2));
        return all;
    }();
    if (share > 1) return colours[steps + 1];
    return colours[static_cast<std::size_t>(std::max(share, 0.0) * static_cast<double>(steps) + 0.5)];
}

} // namespace

void draw_runs(const State& state, Commands& commands) {
    if (state.runs.all.empty()) return;
    ui::heading("Runs");
    draw_run_table(state, commands);
    const FlownRun& latest = *state.runs.all[0];
    draw_strip({"update", "ms", ms_of, latest.budget_us / 1000, 6}, state, commands);
    draw_strip({"error", "px", px_of, latest.error_px, 6}, state, commands);
    ImGui::TextColored(ImColor(ui::quiet).Value, "red below: a budget is spent");
    draw_heat_choice(state, commands);
    draw_worst(state, commands);
}

void draw_heat(const State& state, ImDrawList& list, ImVec2 from, ImVec2 size) {
    if (state.runs.heat == Heat::none || state.runs.all.empty()) return;
    const FlownRun& run = *state.runs.all[0];
    const bool time = state.runs.heat == Heat::time;
    const double full = std::max(time ? run.p99_us : run.error_px, 1e-9);
    const float radius = 0.32F * ImGui::GetFontSize();
    const ui::PlainEdges one_over_the_other(list);
    for (const FlownPlace& p : run.places) {
        const double value = static_cast<double>(time ? p.update_us : p.error_px);
        const ImVec2 at{from.x + static_cast<float>(p.pose.position_m.x / state.scene.width_m()) * size.x,
                        from.y + static_cast<float>(p.pose.position_m.z / state.scene.depth_m()) * size.y};
        list.AddCircleFilled(at, radius, heat_colour(value / (time ? full : full * (1 + 1e-6))), 8);
    }
}

} // namespace fjell::editor
