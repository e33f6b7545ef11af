#include "editor/panels/tune_cost.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include "editor/number_text.h"
#include "editor/strings.h"

namespace fjell::editor {

namespace {

using flight::FrameEntry;

struct Text {
    char* to;
    std::size_t size, used = 0;

    void add(const char* format, ...) IM_FMTARGS(2) {
        if (used + 1 >= size) return;
        va_list values;
        va_start(values, format);
        const int n = std::vsnprintf(to + used, size - used, format, values);
        va_end(values);
        if (n > 0) used += static_cast<std::size_t>(n);
    }
    void count(const char* before, double number) { add("%s%s", before, count_text(number).text); }
    void bytes(double bytes) { add("%s", byte_text(bytes).text); }
};

// Of the states of pages that a cut with so many vertices has for the terrain that is shown.
double page_state_bytes(const State& state, double vertices) {
    const Scene& scene = state.scene;
    const std::uint32_t slots =
        scene.streamed ? std::min(scene.pages, state.document.profile().page_slots) : scene.pages;
    return static_cast<double>(cut_pages({.vertices = static_cast<std::uint32_t>(vertices)}, slots, scene.tiles)) *
           static_cast<double>(cut_page_bytes);
}

// What the table above the profile's keys says of bytes, for the chosen method.
void vertices(const State& state, Text& text, double value) {
    const FrameEntry& e = state.measures.last();
    const flight::MethodFacts& slot = flight::facts_of(state.document.profile());
    text.bytes(value * static_cast<double>(slot.vertex_bytes) + (slot.keeps_mesh ? page_state_bytes(state, value) : 0));
    text.add(" + ");
    text.bytes(value * static_cast<double>(slot.gpu_vertex_bytes));
    text.add(strings::tune_cost::gpu);
    text.count(strings::tune_cost::used, e.vertices);
    if (slot.keeps_mesh) text.count(strings::tune_cost::peak, e.vertices_peak);
}

void triangles(const State& state, Text& text, double value) {
    const FrameEntry& e = state.measures.last();
    text.bytes(value * static_cast<double>(cut_triangle_bytes));
    text.add(" + ");
    text.bytes(value * 12);
    text.count(strings::tune_cost::gpu_used, e.triangles);
    text.count(strings::tune_cost::peak, e.triangles_peak);
}

void indices(const State&, Text& text, double value) {
    text.bytes(value * 4);
    text.add(" + ");
    text.bytes(value * 4);
    text.add(strings::tune_cost::gpu);
}

void items(const State& state, Text& text, double) {
    text.count(strings::tune_cost::last_frame, state.measures.last().items);
}

void time(const State& state, Text& text, double) {
    text.add(strings::tune_cost::last_update, ms_text(state.measures.last().update_us).text);
}

void threshold(const State& state, Text& text, double) {
    const FrameEntry& e = state.measures.last();
    if (e.error_px_effective >= 1e6)
        text.add(strings::common::lags);
    else
        text.add(strings::tune_cost::keeps_px, e.error_px_effective < 100 ? 2 : 0, e.error_px_effective);
    text.count(", ", e.triangles_drawn);
    text.add(strings::tune_cost::triangles_drawn);
}

void page_slots(const State& state, Text& text, double value) {
    text.bytes(value * 12.5e3);
    if (state.scene.pages != 0) text.count(strings::tune_cost::the_pack_has, state.scene.pages);
    const FrameEntry& e = state.measures.last();
    if (!e.streamed) return;
    text.count(strings::tune_cost::used, e.stream.page_slots.used);
    text.count(strings::tune_cost::peak, e.stream.page_slots.peak);
}

void page_requests(const State& state, Text& text, double value) {
    text.bytes(value * 16e3);
    if (state.measures.last().streamed)
        text.add(strings::tune_cost::in_flight_with_mips, state.measures.last().stream.in_flight);
}

void map_requests(const State&, Text& text, double value) {
    text.add(strings::tune_cost::up_to);
    text.bytes(value * 525e3);
}

void map_mb(const State& state, Text& text, double value) {
    text.bytes(value * 1048576);
    text.add(strings::tune_cost::gpu);
    const FrameEntry& e = state.measures.last();
    if (!e.streamed) return;
    text.add(strings::tune_cost::used);
    text.bytes(static_cast<double>(e.stream.map_bytes_used));
}

void pages(const State& state, Text& text, double) {
    const FrameEntry& e = state.measures.last();
    if (e.streamed) text.add(strings::tune_cost::last_frame_left, e.stream.pages_inserted, e.stream.pages_left);
}

void map_kb(const State& state, Text& text, double) {
    const FrameEntry& e = state.measures.last();
    if (!e.streamed) return;
    text.add(strings::tune_cost::last_frame);
    text.bytes(static_cast<double>(e.stream.map_upload_bytes));
}

struct Cost {
    const char *table, *name;
    void (*write)(const State&, Text&, double value);
};
constexpr Cost costs[] = {
    {"refine", "error_px", threshold},
    {"budget", "vertices", vertices},
    {"budget", "triangles", triangles},
    {"budget", "items", items},
    {"budget", "budget_us", time},
    {"budget", "indices", indices},
    {"stream", "page_slots", page_slots},
    {"stream", "page_requests", page_requests},
    {"stream", "map_requests", map_requests},
    {"stream", "map_mb", map_mb},
    {"stream", "pages", pages},
    {"stream", "map_kb", map_kb},
};

bool is(const flight::ProfileKey& key, const char* table, const char* name) {
    return std::strcmp(key.table, table) == 0 && std::strcmp(key.name, name) == 0;
}

} // namespace

bool cost_text(const flight::ProfileKey& key, const State& state, char* to, std::size_t size) {
    for (const Cost& cost : costs) {
        if (!is(key, cost.table, cost.name)) continue;
        Text text{to, size};
        cost.write(state, text, key.get(state.document.profile()));
        return text.used != 0;
    }
    return false;
}

const char* why_idle(const flight::ProfileKey& key, const State& state) {
    const flight::Profile& profile = state.document.profile();
    switch (key.used_by) {
    case flight::UsedBy::any: break;
    case flight::UsedBy::incremental:
        if (flight::facts_of(profile).keys != key.used_by) return strings::tune_cost::incremental_only;
        break;
    case flight::UsedBy::recursive:
        if (flight::facts_of(profile).keys != key.used_by) return strings::tune_cost::recursive_only;
        break;
    case flight::UsedBy::streaming: // page_slots decides whether anything is streamed: it counts always
        if (!state.scene.streamed && !is(key, "stream", "page_slots")) return strings::tune_cost::streaming_only;
        break;
    }
    if (is(key, "refine", "morph_s") && profile.cut.morph != Morph::time) return strings::tune_cost::morph_time_only;
    return nullptr;
}

} // namespace fjell::editor
