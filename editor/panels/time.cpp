// What frames and updates take, how the threshold holds, and what changes.
#include <algorithm>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/graph.h"
#include "editor/panels/panels.h"
#include "editor/strings.h"

namespace fjell::editor {

namespace {

constexpr ImU32 blue = IM_COL32(125, 175, 235, 255), teal = IM_COL32(95, 200, 190, 255),
                orange = IM_COL32(235, 160, 90, 255), violet = IM_COL32(185, 150, 230, 255);
constexpr ImU32 yellow = IM_COL32(225, 205, 110, 255), green = IM_COL32(120, 190, 120, 255),
                grey = IM_COL32(140, 146, 158, 255);
constexpr double frame_budget_ms = 1000.0 / 60;
constexpr const char *upload_about = strings::time::about_upload, *draw_about = strings::time::about_draw,
                     *present_about = strings::time::about_present, *other_about = strings::time::about_other;

// A row of the table: its quantiles in milliseconds.
void quantiles(const char* label, const State& state, Series series, const char* about) {
    const Quantiles q = state.measures.ring(series).quantiles();
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(label);
    ui::tip(about);
    for (const float us : {q.p50, q.p99, q.max, q.last}) {
        ImGui::TableNextColumn();
        const NumberText ms = ms_text(static_cast<double>(us));
        const char* const text = ms.text;
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
    for (const char* name : {"p50", "p99", strings::common::max, strings::time::last})
        ImGui::TableSetupColumn(name, 0, 1);
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::quiet), "ms");
    for (const char* name : {"p50", "p99", strings::common::max, strings::time::last}) right_aligned(name);
    quantiles(strings::time::frame, state, Series::frame_us, strings::time::about_frame);
    quantiles(strings::time::update, state, Series::update_us, strings::time::about_update);
    if (state.measures.last().prepare_us > 0 || state.measures.ring(Series::refine_us).quantiles().max > 0) {
        quantiles(strings::time::prepare, state, Series::prepare_us, strings::time::about_prepare);
        quantiles(strings::time::refine, state, Series::refine_us, strings::time::about_refine);
        quantiles(strings::time::output, state, Series::output_us, strings::time::about_output);
    }
    if (state.scene.streamed) quantiles(strings::common::stream, state, Series::stream_us, strings::time::about_stream);
    quantiles(strings::time::upload, state, Series::upload_us, upload_about);
    quantiles(strings::time::draw, state, Series::draw_us, draw_about);
    quantiles(strings::time::present, state, Series::present_us, present_about);
    quantiles(strings::time::editor, state, Series::editor_us, strings::time::about_editor);
    quantiles(strings::time::other, state, Series::other_us, other_about);
    if (state.measures.ring(Series::gpu_us).size() != 0)
        quantiles(strings::time::gpu, state, Series::gpu_us, strings::time::about_gpu);
    ImGui::EndTable();
    if (!state.software) return;
    ImGui::PushStyleColor(ImGuiCol_Text, ui::quiet);
    ImGui::TextWrapped(strings::time::no_gpu);
    ImGui::PopStyleColor();
}

// The clicked frame, or the mean of all.
void draw_parts(const State& state) {
    const Measures& m = state.measures;
    const auto mean = [&](Series series) { return m.ring(series).mean(); };
    double update_us = mean(Series::update_us) + mean(Series::stream_us);
    FrameTimes t{mean(Series::frame_us), mean(Series::upload_us), mean(Series::draw_us), mean(Series::present_us),
                 mean(Series::editor_us)};
    if (state.chosen) {
        t = state.chosen->times;
        update_us = state.chosen->entry.update_us + state.chosen->entry.stream_us;
    }
    const double parts_us = update_us + t.upload_us + t.draw_us + t.present_us + t.editor_us;
    const ui::Share shares[] = {{strings::time::update_part, update_us, blue, strings::time::about_update_part},
                                {strings::time::upload_part, t.upload_us, yellow, upload_about},
                                {strings::time::draw_part, t.draw_us, orange, draw_about},
                                {strings::time::present_part, t.present_us, green, present_about},
                                {strings::time::editor_part, t.editor_us, violet, strings::time::about_editor_part},
                                {strings::time::other_part, std::max(t.frame_us - parts_us, 0.0), grey, other_about}};
    char value[64];
    std::snprintf(value, sizeof value, "%s ms", ms_text(t.frame_us).text);
    char label[48];
    if (state.chosen)
        std::snprintf(label, sizeof label, strings::time::frame);
    else
        std::snprintf(label, sizeof label, strings::time::mean_of_frames, m.ring(Series::frame_us).size());
    ui::row(label, "%s", value);
    ui::stacked_bar("frame", shares);
}

// What the clicked frame reported, and the way to where it was drawn from.
void draw_report(const State& state, Commands& commands) {
    const MeasuredFrame& f = *state.chosen;
    const flight::FrameEntry& e = f.entry;
    ui::heading(strings::time::this_frame);
    const std::uint64_t ago = state.measures.recorded() - f.number;
    ui::row(strings::time::before_the_newest, strings::time::frames, count_text(static_cast<double>(ago)).text);
    if (e.error_px_effective < 1e6)
        ui::row(strings::time::threshold, strings::time::threshold_of, e.error_px_effective, e.error_px_requested);
    else
        ui::row(strings::time::threshold, strings::common::unbounded);
    ui::row(strings::common::work_items, "%s", count_text(e.items).text);
    ui::row(strings::time::changes, "%s, %s", count_text(e.activations).text, count_text(e.deactivations).text);
    ui::row(strings::time::triangles_drawn, "%s", count_text(e.triangles_drawn).text);
    ui::row(strings::time::uploaded, "%s", byte_text(static_cast<double>(e.upload_bytes)).text);
    const Vec3& p = f.pose.position_m;
    ui::row(strings::common::camera, "%s", place_text(p.x, p.y, p.z).text);
    if (ImGui::Button(strings::time::go_to_its_camera)) {
        const flight::FreeCamera camera = flight::free_camera(f.pose, state.eye.free.speed_m_s);
        commands.push(PlayPath{false});
        commands.push(PlaceCamera{camera.position_m, camera.heading, camera.pitch});
    }
    ui::mark("frame", "camera");
    ui::tip(strings::time::about_go_to_its_camera);
    ImGui::SameLine();
    if (ImGui::Button(strings::time::all_frames)) commands.push(ChooseFrame{});
    ui::mark("frame", "all");
    ui::tip(strings::time::about_all_frames);
    const auto step = [&](const char* label, const char* name, bool can, std::size_t to, const char* about) {
        ImGui::SameLine();
        ImGui::BeginDisabled(!can);
        if (ImGui::Button(label)) commands.push(ChooseFrame{true, to});
        ImGui::EndDisabled();
        ui::mark("frame", name);
        ui::tip(about);
    };
    const std::size_t size = state.measures.ring(Series::frame_us).size();
    step("<", "older", ago + 1 < size, ago + 1, strings::time::about_older);
    step(">", "newer", ago > 0, ago - 1, strings::time::about_newer);
}

// Half of the frames that are shown, around the chosen one or else the newest.
void zoom_in(const State& state, Commands& commands) {
    const GraphSpan& shown = state.graphs;
    const std::size_t half = std::max((shown.oldest - shown.newest + 1) / 2, least_graph_span);
    std::size_t middle = shown.newest + half / 2;
    if (state.chosen) middle = static_cast<std::size_t>(state.measures.recorded() - state.chosen->number);
    const std::size_t newest = middle > half / 2 ? middle - half / 2 : 0;
    commands.push(ZoomGraphs{std::min(newest + half - 1, measured_frames - 1), newest});
}

// Above everything, so that it stays under the hand.
void draw_hold(const State& state, Commands& commands) {
    const bool held = state.measures.held();
    if (ImGui::Button(held ? strings::time::continue_ : strings::time::pause)) commands.push(HoldMeasures{!held});
    ui::mark("graphs", "hold");
    ui::tip(held ? strings::time::about_continue : strings::time::about_pause);
    ImGui::SameLine();
    ImGui::BeginDisabled(state.graphs.whole());
    if (ImGui::Button(strings::time::zoom_out)) commands.push(ZoomGraphs{measured_frames - 1, 0});
    ImGui::EndDisabled();
    ui::mark("graphs", "whole");
    ui::tip(strings::time::about_zoom_out);
    ImGui::SameLine();
    if (ImGui::Button(strings::time::zoom_in)) zoom_in(state, commands);
    ui::mark("graphs", "zoom-in");
    ui::tip(strings::time::about_zoom_in);
    if (!held) return;
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::warning_colour), strings::time::paused);
}

} // namespace

void draw_measured_graph(ui::Graph graph, std::initializer_list<ui::GraphLine> lines, const State& state,
                         Commands& commands) {
    const Measures& m = state.measures;
    if (state.chosen) graph.chosen = static_cast<std::size_t>(m.recorded() - state.chosen->number);
    graph.shown = state.graphs;
    const ui::GraphInput input = ui::graph(graph, lines);
    if (input.clicked < m.ring(Series::frame_us).size()) {
        commands.push(ChooseFrame{true, input.clicked});
        commands.push(ShowPanel{Panel::time});
    }
    const std::size_t size = m.ring(Series::frame_us).size();
    if (input.oldest == ui::no_frame || input.newest >= size) return; // there are no frames yet
    if (input.drags && !m.held()) commands.push(HoldMeasures{true});
    if (input.released) commands.push(ZoomGraphs{std::min(input.oldest, size - 1), input.newest});
}

void draw_time(const State& state, Commands& commands) {
    if (!state.scene.open()) {
        ImGui::TextWrapped(strings::common::no_terrain_is_open);
        return;
    }
    const Measures& m = state.measures;
    const auto ring = [&](Series series) { return &m.ring(series); };
    if (ring(Series::frame_us)->size() == 0) {
        ImGui::TextWrapped(strings::time::nothing_measured);
        return;
    }
    const auto graph = [&](const ui::Graph& g, std::initializer_list<ui::GraphLine> lines) {
        draw_measured_graph(g, lines, state, commands);
    };
    const double budget_us = state.document.profile().cut.budget_us;
    const bool limited = flight::facts_of(state.document.profile()).keeps_mesh && budget_us > 0;
    draw_hold(state, commands);
    draw_parts(state);
    if (state.chosen) draw_report(state, commands);
    graph({"update", "ms", 7, limited ? budget_us / 1000 : 0, strings::common::budget},
          {{ring(Series::update_us), blue, strings::time::update_part, 1e-3F, true}});
    graph({"frame", "ms", 7, frame_budget_ms, strings::time::frame_at_60_hz},
          {{ring(Series::frame_us), teal, strings::time::frame_part, 1e-3F, true},
           {ring(Series::draw_us), orange, strings::time::draw_part, 1e-3F, false},
           {ring(Series::editor_us), violet, strings::time::editor_part, 1e-3F, false}});
    draw_table(state);
    ui::heading(strings::time::threshold);
    graph({"threshold", "px", 6.5, 0, "", true},
          {{ring(Series::effective_px), orange, strings::time::effective, 1, false},
           {ring(Series::requested_px), blue, strings::time::requested, 1, false}});
    ui::heading(strings::time::changes_per_frame);
    graph({"changes", strings::common::vertices_unit, 6.5},
          {{ring(Series::activations), teal, strings::time::activated, 1, true},
           {ring(Series::deactivations), orange, strings::time::deactivated, -1, true}});
    ui::heading(strings::common::upload_per_frame);
    graph({"upload", "kB", 5.5}, {{ring(Series::uploaded_bytes), violet, strings::time::mesh, 1e-3F, true}});
}

} // namespace fjell::editor
