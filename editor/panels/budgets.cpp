// Used, peak and capacity of every budget, which one is exhausted, the knob that raises it, and where the memory is.
#include <algorithm>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/graph.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

enum class Unit : std::uint8_t { count, microseconds, bytes };

struct Line {
    const char* label;
    const char* key; // of the profile
    const char* about;
    double used, peak, capacity; // capacity 0: no limit
    std::uint32_t bit;           // ExhaustedBit
    Unit unit = Unit::count;
};

NumberText amount(double value, Unit unit) {
    return unit == Unit::bytes ? byte_text(value) : unit == Unit::microseconds ? ms_text(value) : count_text(value);
}

ImU32 fullness_colour(double share, bool exhausted) {
    return exhausted || share >= 0.97 ? ui::bad : share >= 0.8 ? ui::warning_colour : ui::good;
}

void draw_line(const Line& line, const State& state, Commands& commands) {
    char value[112];
    std::snprintf(value, sizeof value, "%s | %s | %s", amount(line.used, line.unit).text,
                  amount(line.peak, line.unit).text,
                  line.capacity > 0 ? amount(line.capacity, line.unit).text : "no limit");
    const bool exhausted = (state.measures.last().exhausted & line.bit) != 0;
    const double share = line.capacity > 0 ? line.used / line.capacity : 0;
    const double mark = line.capacity > 0 ? line.peak / line.capacity : -1;
    ImGui::BeginGroup();
    ui::bar(line.label, value, share, mark, fullness_colour(share, exhausted));
    ImGui::EndGroup();
    ui::mark("budget", line.key);
    if (ui::begin_tip()) {
        ImGui::Text("%s\nRaise it with %s.", line.about, line.key);
        ui::end_tip();
    }
    if (!exhausted) return;
    const flight::ProfileKey* const key = flight::find_profile_key(line.key);
    if (key == nullptr) return;
    const double now = key->get(state.document.profile()), more = std::min(2 * now, key->most);
    ImGui::PushID(line.key);
    if (now > 0 && more > now) {
        if (ImGui::SmallButton("Double")) commands.push(SetKey{key, more, false});
        ui::mark("budget.double", line.key);
        ui::tip(key->rebuild == flight::Rebuild::nothing ? "Twice as much, from the next frame on."
                                                         : "Twice as much. Memory is reallocated; the view stays.");
        ImGui::SameLine();
    }
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::bad), "exhausted: %s", line.key);
    ImGui::PopID();
}

void draw_method(const State& state, Commands& commands) {
    const flight::FrameEntry& e = state.measures.last();
    const Peaks& p = state.measures.peaks();
    const flight::Profile& profile = state.document.profile();
    const bool incremental = profile.method == flight::Method::incremental;
    ui::heading("Refinement:  used | peak | limit");
    const double vertices_peak = std::max(e.vertex_slots.peak, p.vertices);
    draw_line({"Vertices", "budget.vertices", "Slots of the vertex buffer. At the limit, the threshold rises.",
               static_cast<double>(e.vertex_slots.used), vertices_peak, static_cast<double>(e.vertex_slots.capacity),
               flight::exhausted_vertices},
              state, commands);
    if (!incremental) {
        draw_line({"Indices", "budget.indices", "Slots of the index buffer. At the limit, the threshold rises.",
                   static_cast<double>(e.index_slots.used), static_cast<double>(p.indices),
                   static_cast<double>(e.index_slots.capacity), flight::exhausted_indices},
                  state, commands);
        return;
    }
    draw_line({"Triangles", "budget.triangles",
               "Slots of the index buffer, in whole segments. At the limit, the threshold rises.",
               static_cast<double>(e.triangle_slots.used), static_cast<double>(e.triangle_slots.peak),
               static_cast<double>(e.triangle_slots.capacity), flight::exhausted_triangles},
              state, commands);
    const bool limited = e.item_limit != unlimited_items;
    draw_line({"Work items", "budget.items",
               "Vertices that an update examines or changes. At the limit, the mesh lags behind the camera.",
               static_cast<double>(e.items), static_cast<double>(p.items),
               limited ? static_cast<double>(e.item_limit) : 0, flight::exhausted_items},
              state, commands);
    draw_line({"Time, ms", "budget.budget_us",
               "Time that an update may take. At the limit, the mesh lags behind the camera.", e.update_us, p.update_us,
               profile.cut.budget_us, flight::exhausted_time, Unit::microseconds},
              state, commands);
}

void draw_stream(const State& state, Commands& commands) {
    if (!state.scene.streamed) return;
    const StreamReport& r = state.measures.last().stream;
    const Peaks& p = state.measures.peaks();
    const flight::Profile& profile = state.document.profile();
    ui::heading("Streaming:  used | peak | limit");
    draw_line({"Page slots", "stream.page_slots",
               "Pages in memory. At the limit, distant terrain is coarser than requested.",
               static_cast<double>(r.page_slots.used), static_cast<double>(std::max(r.page_slots.peak, p.page_slots)),
               static_cast<double>(r.page_slots.capacity), flight::exhausted_page_slots},
              state, commands);
    draw_line({"Requests", "stream.page_requests",
               "Pages and mips in flight (stream.map_requests for mips). At the limit, further requests wait.",
               static_cast<double>(r.in_flight), static_cast<double>(p.requested),
               static_cast<double>(profile.stream_budget.page_requests + profile.stream_budget.map_requests),
               flight::exhausted_stream_requests},
              state, commands);
    draw_line({"Pages per frame", "stream.pages",
               "Accepted pages, 10 to 20 us each. At the limit, pages wait for the next frame.",
               static_cast<double>(r.pages_inserted), static_cast<double>(p.pages_inserted),
               static_cast<double>(profile.stream.pages), flight::exhausted_stream_pages},
              state, commands);
    draw_line({"Map memory", "stream.map_mb",
               "Maps on the GPU. At the limit, distant maps are blurrier than requested.",
               static_cast<double>(r.map_bytes_used), static_cast<double>(p.map_bytes),
               static_cast<double>(r.map_bytes_capacity), flight::exhausted_map_bytes, Unit::bytes},
              state, commands);
    draw_line({"Upload per frame", "stream.map_kb", "Maps uploaded to the GPU; one mip may exceed it.",
               static_cast<double>(r.map_upload_bytes), static_cast<double>(p.map_upload_bytes),
               static_cast<double>(profile.stream.map_bytes), flight::exhausted_stream_upload, Unit::bytes},
              state, commands);
    const bool tests = (state.measures.last().exhausted & flight::exhausted_stream_tests) != 0;
    ui::row("Pages tested", tests ? "limit reached" : "within the limit");
    ui::tip("Pages that an update of the stream tests (stream.tests). Raise it when the limit is reached.");
}

void memory_row(const char* label, double bytes, const char* about, double& sum) {
    ui::row(label, "%s", byte_text(bytes).text);
    ui::tip(about);
    sum += bytes;
}

void draw_memory(const State& state) {
    const Scene& s = state.scene;
    const flight::FrameEntry& e = state.measures.last();
    const bool incremental = state.document.profile().method == flight::Method::incremental;
    double host = 0, gpu = 0;
    ui::heading("Memory");
    memory_row("Terrain", static_cast<double>(s.terrain_bytes), "Page slots, page table and corners.", host);
    memory_row("Method", static_cast<double>(s.method_bytes), "Vertices, indices and bookkeeping.", host);
    if (s.streamed)
        memory_row("Stream", static_cast<double>(s.stream_bytes), "Requests in flight and their buffers.", host);
    memory_row("GPU: mesh",
               incremental ? 28.0 * e.vertex_slots.capacity + 12.0 * e.triangle_slots.capacity
                           : 12.0 * e.vertex_slots.capacity + 4.0 * e.index_slots.capacity,
               "Vertex and index buffers, without staging buffers.", gpu);
    if (state.drawn)
        memory_row("GPU: maps", static_cast<double>(state.drawn->texture_bytes), "Textures of colours and normals.",
                   gpu);
    double sum = 0;
    ImGui::Separator();
    memory_row("Total", host + gpu, "Host and GPU, without the program itself.", sum);
}

} // namespace

void draw_budgets(const State& state, Commands& commands) {
    if (!state.scene.open()) {
        ImGui::TextWrapped("No terrain is open.");
        return;
    }
    draw_method(state, commands);
    draw_stream(state, commands);
    draw_memory(state);
}

} // namespace fjell::editor
