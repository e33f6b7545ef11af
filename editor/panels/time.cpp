// What frames and updates take, how the threshold holds, and what changes.
#include <algorithm>
#include <cstdio>

#include "editor/panels/graph.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

constexpr ImU32 blue = IM_COL32(125, 175, 235, 255), teal = IM_COL32(95, 200, 190, 255),
                orange = IM_COL32(235, 160, 90, 255), violet = IM_COL32(185, 150, 230, 255);
constexpr double frame_budget_ms = 1000.0 / 60;

// A row of the table: its quantiles in milliseconds.
void quantiles(const char* label, const State& state, Series series, const char* about) {
    const Quantiles q = state.measures.ring(series).quantiles();
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(label);
    ui::tip(about);
    for (const float us : {q.p50, q.p99, q.max, q.last}) {
        ImGui::TableNextColumn();
        char text[24];
        std::snprintf(text, sizeof text,
                      us >= 99950  ? "%.0f"
                      : us >= 9995 ? "%.1f"
                                   : "%.2f",
                      static_cast<double>(us) / 1000);
        const float width = ImGui::CalcTextSize(text).x;
        ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(0.0F, ImGui::GetContentRegionAvail().x - width));
        ImGui::TextUnformatted(text);
    }
}

void right_aligned(const char* text) {
    ImGui::TableNextColumn();
    const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(text).x;
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(0.0F, room));
    ImGui::PushStyleColor(ImGuiCol_Text, ui::quiet);
    ImGui::TextUnformatted(text);
    ImGui::PopStyleColor();
}

void draw_table(const State& state) {
    if (!ImGui::BeginTable("times", 5, ImGuiTableFlags_SizingStretchProp)) return;
    ImGui::TableSetupColumn("name", 0, 1.6F);
    for (const char* name : {"p50", "p99", "max", "last"}) ImGui::TableSetupColumn(name, 0, 1);
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::quiet), "ms");
    for (const char* name : {"p50", "p99", "max", "last"}) right_aligned(name);
    quantiles("Frame", state, Series::frame_us,
              "From one swap of the picture to the next; with vertical sync, whole refresh intervals.");
    quantiles("Update", state, Series::update_us, "The method's update on the CPU.");
    if (state.measures.last().prepare_us > 0 || state.measures.ring(Series::refine_us).quantiles().max > 0) {
        quantiles("  prepare", state, Series::prepare_us,
                  "Part of the update: views, arrived pages, and which groups have work.");
        quantiles("  refine", state, Series::refine_us,
                  "Part of the update: evaluating, activating and deactivating vertices.");
        quantiles("  output", state, Series::output_us, "Part of the update: writing triangles and draw ranges.");
    }
    if (state.scene.streamed)
        quantiles("Stream", state, Series::stream_us, "Accepting arrived pages and mips, and requesting others.");
    quantiles("Draw", state, Series::draw_us,
              "Upload and drawing, the CPU's part; with a software renderer, all of it.");
    quantiles("Editor", state, Series::editor_us,
              "The editor's own code: panels, commands and measures. Should stay below 1 ms.");
    ImGui::EndTable();
}

} // namespace

void draw_time(const State& state, Commands&) {
    if (!state.scene.open()) {
        ImGui::TextWrapped("No terrain is open.");
        return;
    }
    const Measures& m = state.measures;
    const auto ring = [&](Series series) { return &m.ring(series); };
    const double budget_us = state.document.profile().cut.budget_us;
    const bool limited = state.document.profile().method == flight::Method::incremental && budget_us > 0;
    ui::graph({"update", "ms", 7, limited ? budget_us / 1000 : 0, "budget", false},
              {{ring(Series::update_us), blue, "update", 1e-3F, true}});
    ui::graph({"frame", "ms", 7, frame_budget_ms, "16.7 ms: 60 Hz", false},
              {{ring(Series::frame_us), teal, "frame", 1e-3F, true},
               {ring(Series::draw_us), orange, "draw", 1e-3F, false},
               {ring(Series::editor_us), violet, "editor", 1e-3F, false}});
    draw_table(state);
    ui::heading("Threshold");
    ui::graph({"threshold", "px", 6.5, 0, "", true}, {{ring(Series::effective_px), orange, "effective", 1, false},
                                                      {ring(Series::requested_px), blue, "requested", 1, false}});
    ui::heading("Changes per frame");
    ui::graph({"changes", "vertices", 6.5, 0, "", false},
              {{ring(Series::activations), teal, "activated", 1, true},
               {ring(Series::deactivations), orange, "deactivated", -1, true}});
    ui::heading("Upload per frame");
    ui::graph({"upload", "kB", 5.5, 0, "", false}, {{ring(Series::uploaded_bytes), violet, "mesh", 1e-3F, true}});
}

} // namespace fjell::editor
