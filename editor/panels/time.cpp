// What frames and updates take, how the threshold holds, and what changes.
#include <algorithm>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/graph.h"
#include "editor/panels/panels.h"
#include "session/methods/method.h"

namespace fjell::editor {

namespace {

constexpr ImU32 blue = IM_COL32(125, 175, 235, 255), teal = IM_COL32(95, 200, 190, 255),
                orange = IM_COL32(235, 160, 90, 255), violet = IM_COL32(185, 150, 230, 255);
constexpr ImU32 yellow = IM_COL32(225, 205, 110, 255), green = IM_COL32(120, 190, 120, 255),
                grey = IM_COL32(140, 146, 158, 255);
constexpr double frame_budget_ms = 1000.0 / 60;
constexpr const char *upload_about = "Passing the changes of the mesh to the driver.",
                     *draw_about = "Passing the draw calls to the driver.",
                     *present_about =
                         "Copying the picture, drawing the panels, swapping buffers. The GPU or the software "
                         "renderer finishes its work here; with vertical sync the frame waits here.",
                     *other_about = "Input, the overview, and rebuilding.";

// A row of the table: its quantiles in milliseconds.
void quantiles(const char* label, const State& state, Series series, const char* about) {
    const Quantiles q = state.measures.ring(series).quantiles();
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(label);
    ui::tip(about);
    for (const float us : {q.p50, q.p99, q.max, q.last}) {
        ImGui::TableNextColumn();
        ui::right_text(ms_text(static_cast<double>(us)).text, ImGui::GetColorU32(ImGuiCol_Text));
    }
}

void draw_table(const State& state) {
    if (!ImGui::BeginTable("times", 5, ImGuiTableFlags_SizingStretchProp)) return;
    ImGui::TableSetupColumn("name", 0, 1.6F);
    for (const char* name : {"p50", "p99", "max", "last"}) ImGui::TableSetupColumn(name, 0, 1);
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::quiet), "ms");
    for (const char* name : {"p50", "p99", "max", "last"}) {
        ImGui::TableNextColumn();
        ui::right_text(name, ui::quiet);
    }
    quantiles("Frame", state, Series::frame_us,
              "All work of the editor for a frame whose terrain has changed. Waiting for input does not count.");
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
    quantiles("Upload", state, Series::upload_us, upload_about);
    quantiles("Draw", state, Series::draw_us, draw_about);
    quantiles("Present", state, Series::present_us, present_about);
    quantiles("Editor", state, Series::editor_us,
              "The editor's own code: panels, commands and measures. Should stay below 1 ms.");
    quantiles("Other", state, Series::other_us, other_about);
    if (state.measures.ring(Series::gpu_us).size() != 0)
        quantiles("GPU", state, Series::gpu_us,
                  "The GPU's time by its own clock, some frames ago. The GPU works beside the CPU, so this is not a "
                  "part of the "
                  "times above.");
    ImGui::EndTable();
    if (!state.software) return;
    ui::note("GPU: not measured; software draws, in Present.");
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
    const ui::Share shares[] = {{"update", update_us, blue, "The method's update on the CPU, and streaming."},
                                {"upload", t.upload_us, yellow, upload_about},
                                {"draw", t.draw_us, orange, draw_about},
                                {"present", t.present_us, green, present_about},
                                {"editor", t.editor_us, violet, "The editor's own code."},
                                {"other", std::max(t.frame_us - parts_us, 0.0), grey, other_about}};
    char value[64];
    std::snprintf(value, sizeof value, "%s ms", ms_text(t.frame_us).text);
    char label[48];
    if (state.chosen)
        std::snprintf(label, sizeof label, "Frame");
    else
        std::snprintf(label, sizeof label, "Frame, mean of %zu", m.ring(Series::frame_us).size());
    ui::row(label, "%s", value);
    ui::stacked_bar("frame", shares);
}

// What the clicked frame reported, and the way to where it was drawn from.
void draw_report(const State& state, Commands& commands) {
    const MeasuredFrame& f = *state.chosen;
    const session::FrameEntry& e = f.entry;
    ui::heading("This frame");
    const std::uint64_t ago = state.measures.recorded() - f.number;
    ui::row("Age", "%s frames", count_text(static_cast<double>(ago)).text);
    if (e.error_bound_px < 1e6)
        ui::row("Threshold", "%.3g px of %.3g", e.error_bound_px, e.error_px_requested);
    else
        ui::row("Threshold", "unbounded");
    ui::row("Work items", "%s", count_text(e.items).text);
    ui::row("Activated, deactivated", "%s, %s", count_text(e.activations).text, count_text(e.deactivations).text);
    ui::row("Triangles drawn", "%s", count_text(e.triangles_drawn).text);
    ui::row("Uploaded", "%s", byte_text(static_cast<double>(e.upload_bytes)).text);
    const Vec3& p = f.pose.position_m;
    ui::row("Camera", "%s", place_text(p.x, p.y, p.z).text);
    if (ImGui::Button("Go to its camera")) {
        const session::FreeCamera camera = session::free_camera(f.pose, state.eye.free.speed_m_s);
        commands.push(PlayPath{false});
        commands.push(PlaceCamera{camera.position_m, camera.heading, camera.pitch});
    }
    ui::control("frame", "camera", "Puts the camera where this frame was drawn from.");
    ImGui::SameLine();
    if (ImGui::Button("All frames")) commands.push(ChooseFrame{});
    ui::control("frame", "all", "Shows the mean of all measured frames again.");
    const auto step = [&](const char* label, const char* name, bool can, std::size_t to, const char* about) {
        ImGui::SameLine();
        ImGui::BeginDisabled(!can);
        if (ImGui::Button(label)) commands.push(ChooseFrame{true, to});
        ImGui::EndDisabled();
        ui::control("frame", name, about);
    };
    const std::size_t size = state.measures.ring(Series::frame_us).size();
    step("<", "older", ago + 1 < size, ago + 1, "Shows the frame before this one.");
    step(">", "newer", ago > 0, ago - 1, "Shows the frame after this one.");
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
    if (ImGui::Button(held ? "Continue###hold" : "Pause###hold")) commands.push(HoldMeasures{!held});
    ui::control("graphs", "hold",
                held ? "Measures all frames again (T)." : "Stops graphs and times, so that you can look at them (T).");
    ImGui::SameLine();
    ImGui::BeginDisabled(state.graphs.whole());
    if (ImGui::Button("Zoom out")) commands.push(ZoomGraphs{measured_frames - 1, 0});
    ImGui::EndDisabled();
    ui::control("graphs", "whole", "Shows all frames again. Drag over a graph to zoom in.");
    ImGui::SameLine();
    if (ImGui::Button("Zoom in")) zoom_in(state, commands);
    ui::control("graphs", "zoom-in",
                "Pauses, and shows half as many frames, around the chosen one. Or drag over a graph.");
    if (!held) return;
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::warning_colour), "paused");
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
        commands.push(ShowGroup{Group::cost_time, true});
    }
    const std::size_t size = m.ring(Series::frame_us).size();
    if (input.oldest == ui::no_frame || input.newest >= size) return; // there are no frames yet
    if (input.drags && !m.held()) commands.push(HoldMeasures{true});
    if (input.released) commands.push(ZoomGraphs{std::min(input.oldest, size - 1), input.newest});
}

void draw_time(const State& state, PanelState&, Commands& commands) {
    const Measures& m = state.measures;
    const auto ring = [&](Series series) { return &m.ring(series); };
    if (ring(Series::frame_us)->size() == 0) {
        ImGui::TextWrapped("No frame has been measured yet: fly. A still view costs nothing.");
        return;
    }
    const auto graph = [&](const ui::Graph& g, std::initializer_list<ui::GraphLine> lines) {
        draw_measured_graph(g, lines, state, commands);
    };
    const double budget_us = state.document.profile().cut.max_time_us;
    const bool limited = session::facts_of(state.document.profile()).keeps_mesh && budget_us > 0;
    draw_hold(state, commands);
    draw_parts(state);
    if (state.chosen) draw_report(state, commands);
    graph({"update", "ms", 7, limited ? budget_us / 1000 : 0, "budget"},
          {{ring(Series::update_us), blue, "update", 1e-3F, true}});
    graph({"frame", "ms", 7, frame_budget_ms, "16.7 ms: 60 Hz"},
          {{ring(Series::frame_us), teal, "frame", 1e-3F, true},
           {ring(Series::draw_us), orange, "draw", 1e-3F, false},
           {ring(Series::editor_us), violet, "editor", 1e-3F, false}});
    draw_table(state);
    ui::heading("Threshold");
    graph({"threshold", "px", 6.5, 0, "", true}, {{ring(Series::effective_px), orange, "effective", 1, false},
                                                  {ring(Series::requested_px), blue, "requested", 1, false}});
    ui::heading("Changes per frame");
    graph({"changes", "vertices", 6.5}, {{ring(Series::activations), teal, "activated", 1, true},
                                         {ring(Series::deactivations), orange, "deactivated", -1, true}});
    ui::heading("Upload per frame");
    graph({"upload", "kB", 5.5}, {{ring(Series::uploaded_bytes), violet, "mesh", 1e-3F, true}});
}

} // namespace fjell::editor
