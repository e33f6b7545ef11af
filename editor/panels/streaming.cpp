// What streams: what is wanted, under way, failed and read, and how far the picture is from all of it.
#include <algorithm>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/graph.h"
#include "editor/panels/panels.h"
#include "editor/strings.h"

namespace fjell::editor {

namespace {

void flag(const char* label, bool good, const char* yes, const char* no, const char* about) {
    ImGui::PushStyleColor(ImGuiCol_Text, good ? ui::good : ui::warning_colour);
    ui::row(label, "%s", good ? yes : no);
    ImGui::PopStyleColor();
    ui::tip(about);
}

void bytes_row(const char* label, double bytes, const char* about) {
    ui::row(label, "%s", byte_text(bytes).text);
    ui::tip(about);
}

void draw_not_streamed(const State& state, Commands& commands) {
    ImGui::TextWrapped(strings::streaming::all_in_memory, count_text(state.scene.pages).text);
    ImGui::Spacing();
    ImGui::TextWrapped(strings::streaming::how_to_stream);
    const std::uint32_t tiles = state.scene.tiles;
    const std::uint32_t slots = std::max(tiles, state.scene.pages / 2);
    if (slots >= state.scene.pages) return;
    char label[64];
    std::snprintf(label, sizeof label, strings::streaming::stream_with, count_text(slots).text);
    if (ImGui::Button(label))
        commands.push(SetKey{flight::find_profile_key("stream.page_slots"), static_cast<double>(slots), false});
    ui::mark("streaming", "begin");
    ui::tip(strings::streaming::about_stream_with);
}

void draw_geometry(const StreamReport& r) {
    ui::heading(strings::streaming::geometry);
    flag(strings::streaming::pages_for_this_view, r.converged, strings::streaming::complete,
         strings::streaming::incomplete, strings::streaming::about_pages_for_this_view);
    ui::row(strings::streaming::wanted_missing, "%s", count_text(r.pages_wanted).text);
    ui::tip(strings::streaming::about_wanted);
    ui::row(strings::streaming::accepted, "%s, %s", count_text(r.pages_inserted).text, count_text(r.pages_left).text);
    ui::tip(strings::streaming::about_accepted);
    ui::row(strings::streaming::evicting, "%s", count_text(r.pages_evicting).text);
    ui::tip(strings::streaming::about_evicting);
    ui::row(strings::common::page_slots, strings::streaming::of, count_text(r.page_slots.used).text,
            count_text(r.page_slots.capacity).text);
    if (r.missing_px >= 1e7)
        ui::row(strings::streaming::missing_error, strings::common::unbounded);
    else
        ui::row(strings::streaming::missing_error, "%.2f px", r.missing_px);
    ui::tip(strings::streaming::about_missing_error);
}

void draw_maps(const StreamReport& r) {
    ui::heading(strings::streaming::maps);
    flag(strings::streaming::mips_for_this_view, r.maps_converged, strings::streaming::complete,
         strings::streaming::incomplete, strings::streaming::about_mips_for_this_view);
    ui::row(strings::streaming::accepted, "%s, %s", count_text(r.mips_uploaded).text, count_text(r.mips_left).text);
    ui::row(strings::streaming::missing_mips, "%.1f", r.missing_mips);
    ui::tip(strings::streaming::about_missing_mips);
    ui::row(strings::streaming::on_the_gpu, strings::streaming::of,
            byte_text(static_cast<double>(r.map_bytes_used)).text,
            byte_text(static_cast<double>(r.map_bytes_capacity)).text);
}

void draw_reading(const StreamReport& r, const io::StreamReaderCounters& reader) {
    ui::heading(strings::streaming::reading);
    ui::row(strings::streaming::in_flight, "%s", count_text(r.in_flight).text);
    ui::tip(strings::streaming::about_in_flight);
    ui::row(strings::streaming::pages_mips, "%s, %s", count_text(static_cast<double>(r.pages_read)).text,
            count_text(static_cast<double>(r.mips_read)).text);
    bytes_row(strings::streaming::bytes, static_cast<double>(r.bytes_read), strings::streaming::about_bytes);
    ui::row(strings::streaming::reads, "%s", count_text(static_cast<double>(reader.reads)).text);
    const double a_second = reader.read_s > 0 ? static_cast<double>(reader.bytes) / reader.read_s : 0;
    ui::row(strings::streaming::read_rate, "%s/s", byte_text(a_second).text);
    ui::tip(strings::streaming::about_read_rate);
    ui::row(strings::streaming::decompression, "%.2f s", reader.provide_s);
    ui::tip(strings::streaming::about_decompression);
    ui::row(strings::streaming::withdrawn, "%s", count_text(static_cast<double>(reader.unwanted)).text);
    ui::tip(strings::streaming::about_withdrawn);
    const bool failed = r.failed > 0 || reader.errors > 0;
    if (failed) ImGui::PushStyleColor(ImGuiCol_Text, ui::bad);
    ui::row(strings::streaming::failed, "%s", count_text(r.failed).text);
    if (failed) ImGui::PopStyleColor();
    ui::tip(strings::streaming::about_failed);
}

} // namespace

void draw_streaming(const State& state, Commands& commands) {
    if (!state.scene.open()) {
        ImGui::TextWrapped(strings::common::no_terrain_is_open);
        return;
    }
    if (!state.scene.streamed) {
        draw_not_streamed(state, commands);
        return;
    }
    const StreamReport& r = state.measures.last().stream;
    flag(strings::common::streaming, r.complete, strings::streaming::started, strings::streaming::starting,
         strings::streaming::about_started);
    draw_measured_graph(
        {"queue", strings::streaming::pages_mips_unit, 7},
        {{&state.measures.ring(Series::pages_wanted), IM_COL32(235, 160, 90, 255), strings::streaming::wanted, 1, true},
         {&state.measures.ring(Series::requested), IM_COL32(125, 175, 235, 255), strings::streaming::in_flight_line, 1,
          false}},
        state, commands);
    draw_geometry(r);
    draw_maps(r);
    draw_reading(r, state.reader);
}

} // namespace fjell::editor
