#include "editor/panels/tune_curve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>

#include "editor/jobs/threshold_search.h"
#include "editor/number_text.h"
#include "editor/panels/ui.h"

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
    ImGui::TextUnformatted(p.keeps ? "keeps the budget" : "does not keep the budget");
    ImGui::EndTooltip();
}

} // namespace

void draw_tune_curve(const JobView& job, float height) {
    const float width = ImGui::GetContentRegionAvail().x, font = ImGui::GetFontSize();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::InvisibleButton("curve", {std::max(width, 1.0F), std::max(height, 1.0F)});
    ui::mark("job", "curve");
    ImDrawList& list = *ImGui::GetWindowDrawList();
    if (job.curve.empty()) {
        list.AddText({at.x, at.y + height / 2}, ui::quiet, "The curve appears here, flight by flight.");
        return;
    }
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

} // namespace fjell::editor
