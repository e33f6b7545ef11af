// What streams: what is wanted, under way, failed and read, and how far the picture is from all of it.
#include <algorithm>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/graph.h"
#include "editor/panels/panels.h"

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
    ImGui::TextWrapped("The whole terrain is in memory: all of its %s pages were read when it was opened.",
                       count_text(state.scene.pages).text);
    ImGui::Spacing();
    ImGui::TextWrapped(
        "To stream it, give the profile fewer page slots than the pack has pages (stream.page_slots in the Tune "
        "panel), and at least one for each tile. Pages are then read when the view wants them.");
    const std::uint32_t tiles = state.scene.tiles;
    const std::uint32_t slots = std::max(tiles, state.scene.pages / 2);
    if (slots >= state.scene.pages) return;
    char label[64];
    std::snprintf(label, sizeof label, "Stream with %s page slots", count_text(slots).text);
    if (ImGui::Button(label))
        commands.push(SetKey{flight::find_profile_key("stream.page_slots"), static_cast<double>(slots), false});
    ui::mark("streaming", "begin");
    ui::tip("Half of its pages. The pack is reopened and the view stays; Undo reverts it.");
}

void draw_geometry(const StreamReport& r) {
    ui::heading("Geometry");
    flag("Pages for this view", r.converged, "complete", "incomplete",
         "Complete: the threshold holds against the whole terrain.");
    ui::row("Wanted, missing", "%s", count_text(r.pages_wanted).text);
    ui::tip("Pages that the views want and that are not loaded, although the coarser ones above them are.");
    ui::row("Accepted, left", "%s, %s", count_text(r.pages_inserted).text, count_text(r.pages_left).text);
    ui::tip("Arrived pages that were accepted in this frame, and those left for the next ones (stream.pages).");
    ui::row("Evicting", "%s", count_text(r.pages_evicting).text);
    ui::tip("Pages that are not wanted any more, evicted as soon as the mesh does not use them.");
    ui::row("Page slots", "%s of %s", count_text(r.page_slots.used).text, count_text(r.page_slots.capacity).text);
    if (r.missing_px >= 1e7)
        ui::row("Missing error", "unbounded");
    else
        ui::row("Missing error", "%.2f px", r.missing_px);
    ui::tip("The largest error on screen that a missing page may hide, in pixels.");
}

void draw_maps(const StreamReport& r) {
    ui::heading("Maps");
    flag("Mips for this view", r.maps_converged, "complete", "incomplete", "Complete: loaded and faded in.");
    ui::row("Accepted, left", "%s, %s", count_text(r.mips_uploaded).text, count_text(r.mips_left).text);
    ui::row("Missing mips", "%.1f", r.missing_mips);
    ui::tip("Mips that the blurriest tile in view lacks.");
    ui::row("On the GPU", "%s of %s", byte_text(static_cast<double>(r.map_bytes_used)).text,
            byte_text(static_cast<double>(r.map_bytes_capacity)).text);
}

void draw_reading(const StreamReport& r, const io::StreamReaderCounters& reader) {
    ui::heading("Reading");
    ui::row("In flight", "%s", count_text(r.in_flight).text);
    ui::tip("Pages and mips that were requested and have not arrived (stream.page_requests, stream.map_requests).");
    ui::row("Pages, mips", "%s, %s", count_text(static_cast<double>(r.pages_read)).text,
            count_text(static_cast<double>(r.mips_read)).text);
    bytes_row("Bytes", static_cast<double>(r.bytes_read), "Compressed, in total.");
    ui::row("Reads", "%s", count_text(static_cast<double>(reader.reads)).text);
    const double a_second = reader.read_s > 0 ? static_cast<double>(reader.bytes) / reader.read_s : 0;
    ui::row("Read rate", "%s/s", byte_text(a_second).text);
    ui::tip("Over the time that the reader's thread spent reading.");
    ui::row("Decompression", "%.2f s", reader.provide_s);
    ui::tip("Checking and decompressing on the reader's thread, in total.");
    ui::row("Withdrawn", "%s", count_text(static_cast<double>(reader.unwanted)).text);
    ui::tip("Requests that were not wanted any more when their turn came.");
    const bool failed = r.failed > 0 || reader.errors > 0;
    if (failed) ImGui::PushStyleColor(ImGuiCol_Text, ui::bad);
    ui::row("Failed", "%s", count_text(r.failed).text);
    if (failed) ImGui::PopStyleColor();
    ui::tip("Pages and mips that are unreadable or damaged; the terrain is coarser there. See Help > Messages.");
}

} // namespace

void draw_streaming(const State& state, Commands& commands) {
    if (!state.scene.open()) {
        ImGui::TextWrapped("No terrain is open.");
        return;
    }
    if (!state.scene.streamed) {
        draw_not_streamed(state, commands);
        return;
    }
    const StreamReport& r = state.measures.last().stream;
    flag("Streaming", r.complete, "coarse terrain loaded", "loading coarse terrain",
         "Whether the coarsest page and the smallest mips of every tile are loaded.");
    draw_measured_graph(
        {"queue", "pages, mips", 7},
        {{&state.measures.ring(Series::pages_wanted), IM_COL32(235, 160, 90, 255), "wanted", 1, true},
         {&state.measures.ring(Series::requested), IM_COL32(125, 175, 235, 255), "in flight", 1, false}},
        state, commands);
    draw_geometry(r);
    draw_maps(r);
    draw_reading(r, state.reader);
}

} // namespace fjell::editor
