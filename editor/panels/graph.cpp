#include "editor/panels/graph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/keyboard.h"

namespace fjell::editor::ui {

namespace {

constexpr double least_logarithmic = 1e-3;
constexpr ImU32 paper = IM_COL32(28, 31, 37, 255), grid = IM_COL32(255, 255, 255, 26);

// Values to pixels.
struct Scale {
    ImVec2 low, high; // of the plot on screen; low: left and top
    double least = 0, most = 1;
    bool logarithmic = false;

    [[nodiscard]] float y(double value) const {
        double share = 0;
        if (logarithmic)
            share = std::log(std::max(value, least_logarithmic) / least) / std::log(most / least);
        else
            share = (value - least) / (most - least);
        return high.y - static_cast<float>(std::clamp(share, 0.0, 1.0)) * (high.y - low.y);
    }
    // The newest frame is at the right rim, and a frame as wide as if the ring were full.
    [[nodiscard]] float x(std::size_t i, std::size_t size) const {
        const float ago = static_cast<float>(size - 1 - i) - static_cast<float>(shown.newest);
        return high.x - ago / static_cast<float>(shown.oldest - shown.newest) * (high.x - low.x);
    }
    [[nodiscard]] std::size_t ago(float at_x) const {
        const float from_right = std::clamp((high.x - at_x) / (high.x - low.x), 0.0F, 1.0F);
        return shown.newest +
               static_cast<std::size_t>(std::lround(from_right * static_cast<float>(shown.oldest - shown.newest)));
    }
    // Those of a ring that are shown: from the first-th oldest to before the end-th.
    [[nodiscard]] std::size_t first(std::size_t size) const { return size - std::min(size, shown.oldest + 1); }
    [[nodiscard]] std::size_t end(std::size_t size) const { return size - std::min(size, shown.newest); }
    GraphSpan shown;
};

Scale scale_of(const Graph& graph, std::initializer_list<GraphLine> lines) {
    Scale s;
    s.logarithmic = graph.logarithmic;
    s.shown = graph.shown;
    double least = graph.budget > 0 ? graph.budget : 1e9, most = graph.budget > 0 ? 1.15 * graph.budget : 0;
    bool down = false;
    for (const GraphLine& line : lines) {
        down = down || line.factor < 0;
        const std::size_t first = s.first(line.values->size()), end = s.end(line.values->size());
        if (s.shown.whole())
            most = std::max(most, static_cast<double>(line.values->usual_most() * std::abs(line.factor)));
        for (std::size_t i = first; i < end && !s.shown.whole(); ++i) // a spike that was zoomed to is seen whole
            most = std::max(most, static_cast<double>(std::abs(line.values->value(i) * line.factor)));
        if (!graph.logarithmic) continue;
        for (std::size_t i = first; i < end; ++i)
            least = std::min(least, static_cast<double>(line.values->value(i) * std::abs(line.factor)));
    }
    if (graph.logarithmic && most <= 0) { // there is nothing yet
        s.least = 0.1;
        s.most = 10;
    } else if (graph.logarithmic) {
        s.least = std::pow(10.0, std::floor(std::log10(std::max(least, least_logarithmic))));
        s.most = std::max(std::pow(10.0, std::ceil(std::log10(std::max(most, least_logarithmic)))), 10 * s.least);
    } else {
        s.most = round_up(most);
        s.least = down ? -s.most : 0;
    }
    return s;
}

void draw_grid(ImDrawList& list, const Graph& graph, const Scale& s, float left) {
    constexpr int steps = 4;
    const int lines = s.logarithmic ? static_cast<int>(std::lround(std::log10(s.most / s.least))) : steps;
    const float text_height = ImGui::GetFontSize();
    const int every =
        std::max(1, static_cast<int>(std::ceil(static_cast<float>(lines) * text_height * 1.1F / (s.high.y - s.low.y))));
    char text[16];
    for (int i = 0; i <= lines; i += every) {
        const double share = static_cast<double>(i) / lines;
        const double value =
            s.logarithmic ? s.least * std::pow(s.most / s.least, share) : s.least + (s.most - s.least) * share;
        const float y = s.y(value);
        list.AddLine({s.low.x, y}, {s.high.x, y}, grid);
        short_number(text, std::abs(value));
        const float width = ImGui::CalcTextSize(text).x;
        list.AddText({s.low.x - width - 0.3F * text_height, y - text_height / 2}, quiet, text);
    }
    list.AddText({left, s.low.y - 1.75F * text_height}, quiet, graph.unit);
}

void draw_line(ImDrawList& list, const Scale& s, const GraphLine& line) {
    const std::size_t all = line.values->size(), first = s.first(all), end = s.end(all);
    if (first >= end) return;
    const std::size_t size = end - first;
    std::array<ImVec2, measured_frames> points;
    const float zero = s.logarithmic ? s.high.y : s.y(0);
    for (std::size_t i = 0; i < size; ++i)
        points[i] = {s.x(first + i, all), s.y(static_cast<double>(line.values->value(first + i) * line.factor))};
    if (line.filled) {
        const PlainEdges under_the_line(list);
        const ImU32 fill = (line.colour & ~IM_COL32_A_MASK) | (70u << IM_COL32_A_SHIFT);
        for (std::size_t i = 1; i < size; ++i)
            list.AddQuadFilled({points[i - 1].x, zero}, points[i - 1], points[i], {points[i].x, zero}, fill);
    }
    list.AddPolyline(points.data(), static_cast<int>(size), line.colour, 0, std::max(1.0F, ImGui::GetFontSize() / 12));
}

// Triangles at the rim that values go beyond.
void draw_beyond(ImDrawList& list, const Scale& s, const GraphLine& line) {
    const float w = 0.22F * ImGui::GetFontSize();
    for (std::size_t i = s.first(line.values->size()); i < s.end(line.values->size()); ++i) {
        const auto v = static_cast<double>(line.values->value(i) * line.factor);
        if (std::abs(v) <= s.most * (1 + 1e-9)) continue;
        const float x = s.x(i, line.values->size()), rim = v > 0 ? s.low.y : s.high.y, in = v > 0 ? 2 * w : -2 * w;
        list.AddTriangleFilled({x, rim}, {x - w, rim + in}, {x + w, rim + in}, warning_colour);
    }
}

void draw_budget(ImDrawList& list, const Graph& graph, const Scale& s) {
    if (!(graph.budget > 0)) return;
    const float y = s.y(graph.budget);
    list.AddLine({s.low.x, y}, {s.high.x, y}, warning_colour, std::max(1.0F, ImGui::GetFontSize() / 10));
    const float height = ImGui::GetFontSize(); // on the left, where the older frames are
    const bool above = y - height > s.low.y;
    const ImVec2 at{s.low.x + 0.3F * height, above ? y - height - 1 : y + 1};
    const ImVec2 size = ImGui::CalcTextSize(graph.budget_label); // lines may run under it
    list.AddRectFilled({at.x - 0.15F * height, at.y}, {at.x + size.x + 0.15F * height, at.y + height},
                       IM_COL32(25, 28, 36, 200));
    list.AddText(at, warning_colour, graph.budget_label);
}

// The line above the plot: the unit on its left, what the lines are on its right.
void draw_legend(ImDrawList& list, const Scale& s, std::initializer_list<GraphLine> lines) {
    const float em = ImGui::GetFontSize();
    float x = s.high.x;
    for (auto line = std::rbegin(lines); line != std::rend(lines); ++line) {
        x -= ImGui::CalcTextSize(line->label).x;
        list.AddText({x, s.low.y - 1.75F * em}, line->colour | IM_COL32_A_MASK, line->label);
        x -= 0.9F * em;
    }
}

// What the frame under the pointer had.
void hover(ImDrawList& list, const Graph& graph, const Scale& s, std::initializer_list<GraphLine> lines) {
    const float x = std::clamp(ImGui::GetMousePos().x, s.low.x, s.high.x);
    const std::size_t ago = s.ago(x);
    list.AddLine({x, s.low.y}, {x, s.high.y}, IM_COL32(255, 255, 255, 90));
    ImGui::BeginTooltip();
    ImGui::Text("%zu frames ago", ago);
    for (const GraphLine& line : lines) {
        const std::size_t size = line.values->size();
        if (ago >= size) continue;
        ImGui::PushStyleColor(ImGuiCol_Text, line.colour | IM_COL32_A_MASK);
        const auto value = static_cast<double>(line.values->value(size - 1 - ago) * std::abs(line.factor));
        if (value >= 1000)
            ImGui::Text("%s %s %s", line.label, count_text(value).text, graph.unit);
        else
            ImGui::Text("%s %.3g %s", line.label, value, graph.unit);
        ImGui::PopStyleColor();
    }
    ImGui::TextDisabled("click: its report; drag: zoom in");
    ImGui::EndTooltip();
}

// The frame of the largest value among those that are shown: what keys choose, which point at none.
std::size_t highest(const Ring& values, const GraphSpan& shown) {
    std::size_t best = no_frame;
    float most = 0;
    for (std::size_t ago = shown.newest; ago <= shown.oldest && ago < values.size(); ++ago)
        if (const float value = values.value(values.size() - 1 - ago); best == no_frame || value > most) {
            best = ago;
            most = value;
        }
    return best;
}

// Of the graph's button, which is the last item: a click chooses a frame, a drag over some of them zooms.
GraphInput follow_mouse(ImDrawList& list, const Scale& s, bool clicked) {
    const ImGuiIO& io = ImGui::GetIO();
    const float begin = std::clamp(io.MouseClickedPos[ImGuiMouseButton_Left].x, s.low.x, s.high.x);
    const float now = std::clamp(io.MousePos.x, s.low.x, s.high.x);
    const bool dragged = std::abs(now - begin) > 0.4F * ImGui::GetFontSize();
    GraphInput input;
    if (clicked && !dragged) input.clicked = s.ago(now);
    input.drags = dragged && ImGui::IsItemActive();
    input.released = dragged && ImGui::IsItemDeactivated();
    if (!input.drags && !input.released) return input;
    input.oldest = s.ago(std::min(begin, now));
    input.newest = s.ago(std::max(begin, now));
    if (input.drags)
        list.AddRectFilled({std::min(begin, now), s.low.y}, {std::max(begin, now), s.high.y},
                           IM_COL32(255, 255, 255, 45));
    return input;
}

} // namespace

GraphInput graph(const Graph& graph, std::initializer_list<GraphLine> lines) {
    const float em = ImGui::GetFontSize(), width = std::max(ImGui::GetContentRegionAvail().x, 6 * em);
    const auto height = static_cast<float>(graph.height_em) * em;
    const ImVec2 from = ImGui::GetCursorScreenPos();
    const bool clicked = ImGui::InvisibleButton(graph.name, {width, height});
    mark("graph", graph.name);
    const bool by_keys = keyboard::outline();
    if (!ImGui::IsItemVisible()) return {};
    Scale s = scale_of(graph, lines);
    s.low = {from.x + 3.6F * em, from.y + 1.9F * em};
    s.high = {from.x + width - 1, from.y + height - 0.6F * em};
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(s.low, s.high, paper);
    draw_grid(list, graph, s, from.x);
    draw_legend(list, s, lines);
    list.PushClipRect(s.low, s.high, true);
    for (const GraphLine& line : lines) draw_line(list, s, line);
    for (const GraphLine& line : lines) draw_beyond(list, s, line);
    if (graph.chosen >= s.shown.newest && graph.chosen <= s.shown.oldest) {
        const float x = s.x(0, graph.chosen + 1);
        list.AddLine({x, s.low.y}, {x, s.high.y}, IM_COL32_WHITE, std::max(1.0F, em / 10));
    }
    list.PopClipRect();
    draw_budget(list, graph, s);
    if (by_keys) {
        GraphInput input;
        if (clicked) input.clicked = highest(*lines.begin()->values, s.shown);
        tip("Enter: the report of its highest frame.");
        return input;
    }
    const GraphInput input = follow_mouse(list, s, clicked);
    if (ImGui::IsItemHovered() && !input.drags) hover(list, graph, s, lines);
    return input;
}

void stacked_bar(const char* name, std::span<const Share> shares) {
    const float em = ImGui::GetFontSize(), width = ImGui::GetContentRegionAvail().x, height = 0.9F * em;
    const ImVec2 from = ImGui::GetCursorScreenPos();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    double sum = 0;
    for (const Share& share : shares) sum += share.us;
    list.AddRectFilled(from, {from.x + width, from.y + height}, paper);
    float x = from.x;
    for (const Share& share : shares) {
        const float wide = sum > 0 ? static_cast<float>(share.us / sum) * width : 0;
        list.AddRectFilled({x, from.y}, {x + wide, from.y + height}, share.colour);
        x += wide;
    }
    ImGui::Dummy({width, height});
    mark("bar", name);
    bool first = true;
    for (const Share& share : shares) {
        char text[48];
        std::snprintf(text, sizeof text, "%s %s", share.label, ms_text(share.us).text);
        const float needs = ImGui::CalcTextSize(text).x + 1.2F * em + ImGui::GetStyle().ItemSpacing.x;
        if (!first) {
            ImGui::SameLine(0, 0.7F * em);
            if (ImGui::GetContentRegionAvail().x < needs) ImGui::NewLine();
        }
        first = false;
        swatch(share.colour);
        ImGui::TextUnformatted(text);
        tip(share.about);
    }
}

double round_up(double value) {
    if (!(value > 0)) return 1;
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    for (const double step : {1.0, 2.0, 5.0})
        if (step * power >= value * (1 - 1e-9)) return step * power;
    return 10 * power;
}

void short_number(char (&text)[16], double value) {
    if (value >= 1e9)
        std::snprintf(text, sizeof text, "%.3g G", value / 1e9);
    else if (value >= 1e6)
        std::snprintf(text, sizeof text, "%.3g M", value / 1e6);
    else if (value >= 1e4)
        std::snprintf(text, sizeof text, "%.3g k", value / 1e3);
    else if (value >= 999.5)
        std::snprintf(text, sizeof text, "%.15s", count_text(value).text);
    else
        std::snprintf(text, sizeof text, "%.4g", value);
}

void bar(const char* label, const char* value, double share, double mark, ImU32 colour) {
    row(label, "%s", value);
    const float em = ImGui::GetFontSize(), width = ImGui::GetContentRegionAvail().x, height = 0.45F * em;
    const ImVec2 from = ImGui::GetCursorScreenPos();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const auto x = [&](double at) { return from.x + static_cast<float>(std::clamp(at, 0.0, 1.0)) * width; };
    list.AddRectFilled(from, {from.x + width, from.y + height}, paper);
    if (share > 0) list.AddRectFilled(from, {std::max(x(share), from.x + 1), from.y + height}, colour);
    if (mark >= 0) list.AddRectFilled({x(mark) - 1, from.y - 1}, {x(mark) + 1, from.y + height + 1}, IM_COL32_WHITE);
    ImGui::Dummy({width, height + 0.25F * em});
}

void swatch(ImU32 colour) {
    const float em = ImGui::GetFontSize();
    const ImVec2 from = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddRectFilled({from.x, from.y + 0.1F * em}, {from.x + 0.9F * em, from.y + 0.95F * em},
                                              colour);
    ImGui::Dummy({0.9F * em, em});
    ImGui::SameLine();
}

} // namespace fjell::editor::ui
