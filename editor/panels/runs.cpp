// What was flown: the curve of a tuning, and runs of benchmarks.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>

#include "editor/jobs/threshold_search.h"
#include "editor/number_text.h"
#include "editor/panels/graph.h"
#include "editor/panels/keyboard.h"
#include "editor/panels/panels.h"
#include "editor/panels/ui.h"
#include "session/log.h"

namespace fjell::editor {

namespace {

constexpr ImU32 p99_colour = IM_COL32(235, 160, 90, 255), p50_colour = IM_COL32(110, 170, 240, 255),
                vertex_colour = IM_COL32(150, 210, 140, 255), budget_colour = IM_COL32(240, 105, 95, 255),
                line_colour = IM_COL32(70, 76, 88, 255), frame_colour = IM_COL32(24, 26, 31, 255),
                best_colour = IM_COL32(255, 255, 255, 110);

using Value = double (*)(const TunePoint&);

// Both axes are logarithmic: cost spans three decades over the thresholds of a run.
struct Axes {
    ImVec2 low, high; // of the plot's inside, in pixels
    double least_px = 0, most_px = 1, least = 1, most = 10;
    double label = 1; // what a value is multiplied by where it is written

    [[nodiscard]] float x(double error_px) const {
        const double share = std::log(error_px / least_px) / std::log(most_px / least_px);
        return high.x - static_cast<float>(std::clamp(share, 0.0, 1.0)) * (high.x - low.x); // coarse on the left
    }
    [[nodiscard]] float y(double value) const {
        const double share = std::log(std::max(value, least) / least) / std::log(most / least);
        return high.y - static_cast<float>(std::clamp(share, 0.0, 1.0)) * (high.y - low.y);
    }
};

// 950, 12k, 3.4M.
void short_number(char (&text)[16], double value) {
    if (value >= 9.995e5)
        std::snprintf(text, sizeof text, "%.3gM", value * 1e-6);
    else if (value >= 9995)
        std::snprintf(text, sizeof text, "%.3gk", value * 1e-3);
    else if (value >= 100)
        std::snprintf(text, sizeof text, "%.0f", value);
    else
        std::snprintf(text, sizeof text, "%.3g", value);
}

Axes axes_of(const JobView& job, Value smaller, Value larger, double also, ImVec2 low, ImVec2 high) {
    Axes a{low, high, job.curve.back().error_px, job.curve.front().error_px, 0, 0, 1};
    if (a.most_px <= a.least_px) a.most_px = 2 * a.least_px;
    a.least = a.most = also > 0 ? also : smaller(job.curve.front());
    for (const TunePoint& p : job.curve) {
        a.least = std::min(a.least, smaller(p));
        a.most = std::max(a.most, larger(p));
    }
    a.least = std::pow(10, std::floor(std::log10(std::max(a.least, 0.1)) * 2) / 2); // to half decades
    a.most = std::max(std::pow(10, std::ceil(std::log10(a.most * 1.05) * 2) / 2), 3 * a.least);
    return a;
}

void draw_grid(ImDrawList& list, const Axes& a, bool x_labels) {
    const float font = ImGui::GetFontSize();
    list.AddRectFilled(a.low, a.high, frame_colour);
    char text[16];
    for (double decade = std::pow(10, std::floor(std::log10(a.least))); decade <= a.most; decade *= 10) {
        if (decade < a.least * 0.999) continue;
        const float y = a.y(decade);
        list.AddLine({a.low.x, y}, {a.high.x, y}, line_colour);
        short_number(text, decade * a.label);
        list.AddText({a.low.x - ImGui::CalcTextSize(text).x - font * 0.4F, y - font / 2}, ui::quiet, text);
    }
    const double octaves = std::log2(a.most_px / a.least_px);
    const double step = octaves > 8 ? 4 : octaves > 1.5 ? 2 : 1.25;
    for (double e = 1.0 / 1024; e <= a.most_px * 1.001; e *= step) {
        if (e < a.least_px * 0.999) continue;
        const float x = a.x(e);
        list.AddLine({x, a.low.y}, {x, a.high.y}, line_colour);
        if (!x_labels) continue;
        std::snprintf(text, sizeof text, "%.3g", e);
        list.AddText({x - ImGui::CalcTextSize(text).x / 2, a.high.y + font * 0.15F}, ui::quiet, text);
    }
    list.AddRect(a.low, a.high, line_colour);
}

void draw_line(ImDrawList& list, const Axes& a, const JobView& job, Value value, ImU32 colour) {
    const float thick = ImGui::GetFontSize() / 8;
    for (std::size_t i = 0; i < job.curve.size(); ++i) {
        const TunePoint& p = job.curve[i];
        const ImVec2 at{a.x(p.error_px), a.y(value(p))};
        if (i > 0) {
            const TunePoint& before = job.curve[i - 1];
            list.AddLine({a.x(before.error_px), a.y(value(before))}, at, colour, thick);
        }
        list.AddCircleFilled(at, thick * 1.7F, colour);
    }
}

// Its own place in a row of entries; returns where the next one goes.
float draw_legend(ImDrawList& list, float x, float y, ImU32 colour, const char* text) {
    const float font = ImGui::GetFontSize();
    list.AddLine({x, y + font * 0.55F}, {x + font, y + font * 0.55F}, colour, font / 6);
    list.AddText({x + font * 1.3F, y}, ui::quiet, text);
    return x + font * 2.2F + ImGui::CalcTextSize(text).x;
}

// The threshold nearest to the mouse, when that is over one of the plots; null: none.
const TunePoint* hovered(const JobView& job, const Axes& a, float top, float bottom) {
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    if (!ImGui::IsItemHovered() || mouse.x < a.low.x || mouse.x > a.high.x || mouse.y < top || mouse.y > bottom)
        return nullptr;
    return &*std::ranges::min_element(job.curve, {},
                                      [&](const TunePoint& p) { return std::abs(a.x(p.error_px) - mouse.x); });
}

void draw_hover(ImDrawList& list, const TunePoint& p, const Axes& time, const Axes& vertices) {
    for (const Axes* a : {&time, &vertices})
        list.AddLine({a->x(p.error_px), a->low.y}, {a->x(p.error_px), a->high.y}, best_colour);
    ImGui::BeginTooltip();
    ImGui::Text("%.3g px", p.error_px);
    ImGui::Text("p50 %s ms, p99 %s ms, max %s ms", fine_ms_text(p.p50_us).text, fine_ms_text(p.p99_us).text,
                fine_ms_text(p.max_us).text);
    ImGui::Text("%s vertices; %u flights of %u frames", count_text(p.vertices).text, p.flights, p.frames);
    if (p.reached < 0.9999) ImGui::Text("%.1f%% of the frames reached the threshold", 100 * p.reached);
    if (const LimitingPart limit = limiting_part(p.dearest_us); limit.name != nullptr)
        ImGui::Text("slowest frames: %.0f%% %s", 100 * limit.share, limit.name);
    ImGui::TextUnformatted(p.keeps ? "within the budget" : "over the budget");
    ImGui::EndTooltip();
}

} // namespace

void draw_tune_curve(const JobView& job, float height) {
    if (job.curve.empty()) return ui::note("The curve appears here, flight by flight.");
    const float width = ImGui::GetContentRegionAvail().x, font = ImGui::GetFontSize();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::InvisibleButton("curve", {std::max(width, 1.0F), std::max(height, 1.0F)});
    ui::mark("job", "curve");
    ImDrawList& list = *ImGui::GetWindowDrawList();
    // From the top: a legend, the times, a legend, the vertices, labels of the thresholds, their name.
    const float left = at.x + font * 3.2F, right = at.x + width - font * 0.8F;
    const float plots = std::max(height - font * 5.5F, 20.0F), split = at.y + font * 1.4F + plots * 0.62F;
    Axes times = axes_of(
        job, [](const TunePoint& p) { return p.p50_us; }, [](const TunePoint& p) { return p.p99_us; },
        job.tuned.budget_us, {left, at.y + font * 1.4F}, {right, split});
    times.label = 1e-3; // milliseconds
    const Axes& time = times;
    const Value vertices_of = [](const TunePoint& p) { return p.vertices; };
    const Axes vertices = axes_of(job, vertices_of, vertices_of, 0, {left, split + font * 1.7F},
                                  {right, split + font * 1.7F + plots * 0.38F});
    draw_grid(list, time, false);
    draw_grid(list, vertices, true);
    float x = draw_legend(list, left, at.y, p99_colour, "p99, ms");
    x = draw_legend(list, x, at.y, p50_colour, "p50, ms");
    (void)draw_legend(list, x, at.y, budget_colour, "budget");
    (void)draw_legend(list, left, split + font * 0.35F, vertex_colour, "vertices");
    const float budget_y = time.y(job.tuned.budget_us);
    list.AddLine({left, budget_y}, {right, budget_y}, budget_colour, font / 8);
    if (job.best_px > 0)
        for (const Axes* a : {&time, &vertices})
            list.AddLine({a->x(job.best_px), a->low.y}, {a->x(job.best_px), a->high.y}, best_colour, font / 10);
    draw_line(
        list, time, job, [](const TunePoint& p) { return p.p50_us; }, p50_colour);
    draw_line(
        list, time, job, [](const TunePoint& p) { return p.p99_us; }, p99_colour);
    draw_line(list, vertices, job, vertices_of, vertex_colour);
    constexpr const char* name = "threshold, px (finer to the right)";
    list.AddText({(left + right - ImGui::CalcTextSize(name).x) / 2, vertices.high.y + font * 1.2F}, ui::quiet, name);
    if (const TunePoint* const p = hovered(job, time, time.low.y, vertices.high.y))
        draw_hover(list, *p, time, vertices);
}

// --- Benchmarks that were flown: charted along their path, compared, and their worst places listed.

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
// Measured, where it was: bounds lie at the threshold wherever it is kept.
float px_of(const FlownPlace& p) {
    return p.measured_px >= 0 ? p.measured_px : p.error_px;
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
    ui::right_text(text, colour);
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
        ui::control("run", name, "Removes this run from the panel. Its CSV file is kept.");
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
                  place.exhausted != 0 ? "  budget exhausted" : "");
    ImGui::PushID(static_cast<int>(at));
    const bool chosen = state.runs.chosen && state.runs.chosen->run == index && state.runs.chosen->place == at;
    if (ImGui::Selectable(text, chosen)) commands.push(ChoosePlace{index, run.share_of(at)});
    ui::tip("Position on the path, time of the update, and largest error. Click to look from this place.");
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
        ui::control(
            "heat", heat_names[i],
            "Colours the latest run's path on the overview (View > Overview). Time: blue is fast, red the run's "
            "p99, white above. Error: blue is the least that was measured, red the largest, white above the "
            "threshold.");
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
    const bool measured = !latest.places.empty() && latest.places.front().measured_px >= 0;
    ui::note(measured
                 ? "The error is measured at every sample; the line across is the threshold. Red below: a budget is "
                   "exhausted."
                 : "The error is its bound: the terrain is too large to be measured. Red below: a budget is "
                   "exhausted.");
    draw_heat_choice(state, commands);
    draw_worst(state, commands);
}

void draw_heat(const State& state, ImDrawList& list, ImVec2 from, ImVec2 size) {
    if (state.runs.heat == Heat::none || state.runs.all.empty()) return;
    const FlownRun& run = *state.runs.all[0];
    const bool time = state.runs.heat == Heat::time;
    // Errors lie close below the threshold: from the least to the largest that was measured.
    double least = 0, most = time ? run.p99_us : run.error_px;
    if (!time && !run.places.empty() && run.places.front().measured_px >= 0) {
        const auto [low, high] = std::ranges::minmax(run.places, {}, &FlownPlace::measured_px);
        least = static_cast<double>(low.measured_px);
        most = static_cast<double>(high.measured_px);
    }
    const double span = std::max(most - least, 1e-9);
    const float radius = 0.32F * ImGui::GetFontSize();
    const ui::PlainEdges one_over_the_other(list);
    for (const FlownPlace& p : run.places) {
        const double value = static_cast<double>(time ? p.update_us : px_of(p));
        const ImVec2 at{from.x + static_cast<float>(p.pose.position_m.x / state.scene.width_m()) * size.x,
                        from.y + static_cast<float>(p.pose.position_m.z / state.scene.depth_m()) * size.y};
        const bool beyond = value > (time ? most : run.error_px * (1 + 1e-6));
        list.AddCircleFilled(at, radius, heat_colour(beyond ? 2 : std::min((value - least) / span, 1.0)), 8);
    }
}

} // namespace fjell::editor
