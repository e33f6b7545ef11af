// Used, peak and capacity of every budget, which one is exhausted, the knob that raises it, and where the memory is.
#include <algorithm>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/graph.h"
#include "editor/panels/panels.h"
#include "editor/strings.h"

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
                  line.capacity > 0 ? amount(line.capacity, line.unit).text : strings::budgets::no_limit);
    const bool exhausted = (state.measures.last().exhausted & line.bit) != 0;
    const double share = line.capacity > 0 ? line.used / line.capacity : 0;
    const double mark = line.capacity > 0 ? line.peak / line.capacity : -1;
    ImGui::BeginGroup();
    ui::bar(line.label, value, share, mark, fullness_colour(share, exhausted));
    ImGui::EndGroup();
    ui::mark("budget", line.key);
    if (ui::begin_tip()) {
        ImGui::Text(strings::budgets::row_help, line.about, line.key);
        ui::end_tip();
    }
    if (!exhausted) return;
    const flight::ProfileKey* const key = flight::find_profile_key(line.key);
    if (key == nullptr) return;
    const double now = key->get(state.document.profile()), more = std::min(2 * now, key->most);
    ImGui::PushID(line.key);
    if (now > 0 && more > now) {
        if (ImGui::SmallButton(strings::budgets::double_)) commands.push(SetKey{key, more, false});
        ui::mark("budget.double", line.key);
        ui::tip(key->rebuild == flight::Rebuild::nothing ? strings::budgets::about_double
                                                         : strings::budgets::about_double_memory);
        ImGui::SameLine();
    }
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::bad), strings::budgets::exhausted, line.key);
    ImGui::PopID();
}

void draw_method(const State& state, Commands& commands) {
    const flight::FrameEntry& e = state.measures.last();
    const Peaks& p = state.measures.peaks();
    const flight::Profile& profile = state.document.profile();
    const bool kept = flight::facts_of(profile).keeps_mesh;
    ui::heading(strings::budgets::refinement);
    const double vertices_peak = std::max(e.vertex_slots.peak, p.vertices);
    draw_line({strings::common::vertices, "budget.vertices", strings::budgets::about_vertices,
               static_cast<double>(e.vertex_slots.used), vertices_peak, static_cast<double>(e.vertex_slots.capacity),
               flight::exhausted_vertices},
              state, commands);
    if (!kept) {
        draw_line({strings::budgets::indices, "budget.indices", strings::budgets::about_indices,
                   static_cast<double>(e.index_slots.used), static_cast<double>(p.indices),
                   static_cast<double>(e.index_slots.capacity), flight::exhausted_indices},
                  state, commands);
        return;
    }
    draw_line({strings::common::triangles, "budget.triangles", strings::budgets::about_triangles,
               static_cast<double>(e.triangle_slots.used), static_cast<double>(e.triangle_slots.peak),
               static_cast<double>(e.triangle_slots.capacity), flight::exhausted_triangles},
              state, commands);
    const bool limited = e.item_limit != unlimited_items;
    draw_line({strings::common::work_items, "budget.items", strings::budgets::about_work_items,
               static_cast<double>(e.items), static_cast<double>(p.items),
               limited ? static_cast<double>(e.item_limit) : 0, flight::exhausted_items},
              state, commands);
    draw_line({strings::budgets::time_ms, "budget.budget_us", strings::budgets::about_time, e.update_us, p.update_us,
               profile.cut.budget_us, flight::exhausted_time, Unit::microseconds},
              state, commands);
}

void draw_stream(const State& state, Commands& commands) {
    if (!state.scene.streamed) return;
    const StreamReport& r = state.measures.last().stream;
    const Peaks& p = state.measures.peaks();
    const flight::Profile& profile = state.document.profile();
    ui::heading(strings::budgets::streaming);
    draw_line({strings::common::page_slots, "stream.page_slots", strings::budgets::about_page_slots,
               static_cast<double>(r.page_slots.used), static_cast<double>(std::max(r.page_slots.peak, p.page_slots)),
               static_cast<double>(r.page_slots.capacity), flight::exhausted_page_slots},
              state, commands);
    draw_line({strings::budgets::requests, "stream.page_requests", strings::budgets::about_requests,
               static_cast<double>(r.in_flight), static_cast<double>(p.requested),
               static_cast<double>(profile.stream_budget.page_requests + profile.stream_budget.map_requests),
               flight::exhausted_stream_requests},
              state, commands);
    draw_line({strings::budgets::pages_per_frame, "stream.pages", strings::budgets::about_pages_per_frame,
               static_cast<double>(r.pages_inserted), static_cast<double>(p.pages_inserted),
               static_cast<double>(profile.stream.pages), flight::exhausted_stream_pages},
              state, commands);
    draw_line({strings::budgets::map_memory, "stream.map_mb", strings::budgets::about_map_memory,
               static_cast<double>(r.map_bytes_used), static_cast<double>(p.map_bytes),
               static_cast<double>(r.map_bytes_capacity), flight::exhausted_map_bytes, Unit::bytes},
              state, commands);
    draw_line({strings::common::upload_per_frame, "stream.map_kb", strings::budgets::about_map_upload,
               static_cast<double>(r.map_upload_bytes), static_cast<double>(p.map_upload_bytes),
               static_cast<double>(profile.stream.map_bytes), flight::exhausted_stream_upload, Unit::bytes},
              state, commands);
    const bool tests = (state.measures.last().exhausted & flight::exhausted_stream_tests) != 0;
    ui::row(strings::budgets::pages_tested,
            tests ? strings::budgets::limit_reached : strings::budgets::within_the_limit);
    ui::tip(strings::budgets::about_pages_tested);
}

void memory_row(const char* label, double bytes, const char* about, double& sum) {
    ui::row(label, "%s", byte_text(bytes).text);
    ui::tip(about);
    sum += bytes;
}

void draw_memory(const State& state) {
    const Scene& s = state.scene;
    const flight::FrameEntry& e = state.measures.last();
    const flight::MethodFacts& slot = flight::facts_of(state.document.profile());
    double host = 0, gpu = 0;
    ui::heading(strings::budgets::memory);
    memory_row(strings::budgets::terrain, static_cast<double>(s.terrain_bytes), strings::budgets::about_terrain, host);
    memory_row(strings::budgets::method, static_cast<double>(s.method_bytes), strings::budgets::about_method, host);
    if (s.streamed)
        memory_row(strings::common::stream, static_cast<double>(s.stream_bytes), strings::budgets::about_stream, host);
    memory_row(strings::budgets::gpu_mesh,
               static_cast<double>(slot.gpu_vertex_bytes) * e.vertex_slots.capacity +
                   static_cast<double>(slot.gpu_triangle_bytes) *
                       std::max(e.triangle_slots.capacity, e.index_slots.capacity), // the method has one of them
               strings::budgets::about_gpu_mesh, gpu);
    if (state.drawn)
        memory_row(strings::budgets::gpu_maps, static_cast<double>(state.drawn->texture_bytes),
                   strings::budgets::about_gpu_maps, gpu);
    double sum = 0;
    ImGui::Separator();
    memory_row(strings::common::total, host + gpu, strings::budgets::about_total, sum);
}

} // namespace

void draw_budgets(const State& state, Commands& commands) {
    if (!state.scene.open()) {
        ImGui::TextWrapped(strings::common::no_terrain_is_open);
        return;
    }
    draw_method(state, commands);
    draw_stream(state, commands);
    draw_memory(state);
}

} // namespace fjell::editor
