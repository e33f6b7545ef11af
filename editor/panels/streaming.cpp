// What streams: what is wanted, under way, failed and read, and how far the picture is from all of it.
#include <algorithm>
#include <cstdio>

#include "editor/panels/graph.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

void flag(const char* label, bool good, const char* yes, const char* no, const char* about) {
    ImGui::PushStyleColor(ImGuiCol_Text, good ? ui::good : ui::careful);
    ui::row(label, "%s", good ? yes : no);
    ImGui::PopStyleColor();
    ui::tip(about);
}

void bytes_row(const char* label, double bytes, const char* about) {
    char text[16];
    ui::short_bytes(text, bytes);
    ui::row(label, "%s", text);
    ui::tip(about);
}

void draw_not_streamed(const State& state, Commands& commands) {
    ImGui::TextWrapped("This terrain is in memory whole: all of its %u pages were read when it was opened.",
                       state.scene.pages);
    ImGui::Spacing();
    ImGui::TextWrapped(
        "To stream it, give the profile fewer page slots than it has pages (stream.page_slots, among the "
        "Tune panel's controls), at least one a tile: pages are then read when the view wants them.");
    const std::uint32_t tiles = state.scene.tiles_x * state.scene.tiles_y;
    const std::uint32_t slots = std::max(tiles, state.scene.pages / 2);
    if (slots >= state.scene.pages) return;
    char label[48];
    std::snprintf(label, sizeof label, "Stream with %u page slots", slots);
    if (ImGui::Button(label))
        commands.push(SetKey{flight::find_profile_key("stream.page_slots"), static_cast<double>(slots), false});
    ui::mark("streaming", "begin");
    ui::tip("Half of its pages. The terrain is opened anew, where the camera is; Undo takes it back.");
}

void draw_geometry(const StreamReport& r) {
    ui::heading("Geometry");
    flag("Pages for this view", r.converged, "all there", "some missing",
         "All there: the threshold's bound is that of the whole terrain.");
    ui::row("Wanted, missing", "%u", r.pages_wanted);
    ui::tip("Pages that the views want and that are not there, as far as the coarser ones over them are.");
    ui::row("Taken over, left", "%u, %u", r.pages_inserted, r.pages_left);
    ui::tip("Pages that had come and were taken over in this frame, and those left for the next ones (stream.pages).");
    ui::row("Draining", "%u", r.pages_evicting);
    ui::tip("Pages that nothing wants any more, and that go as soon as the mesh has let go of them.");
    ui::row("Page slots", "%u of %u", r.page_slots.used, r.page_slots.capacity);
    if (r.missing_px >= 1e7)
        ui::row("May be hidden", "anything");
    else
        ui::row("May be hidden", "%.2f px", r.missing_px);
    ui::tip("The largest error on screen that a missing page may hide, in pixels.");
}

void draw_maps(const StreamReport& r) {
    ui::heading("Maps");
    flag("Mips for this view", r.maps_converged, "all there", "some missing", "All there, and faded in.");
    ui::row("Taken over, left", "%u, %u", r.mips_uploaded, r.mips_left);
    ui::row("Missing mips", "%.1f", r.missing_mips);
    ui::tip("Levels that the blurriest tile in view lacks.");
    char used[16], capacity[16];
    ui::short_bytes(used, static_cast<double>(r.map_bytes_used));
    ui::short_bytes(capacity, static_cast<double>(r.map_bytes_capacity));
    ui::row("On the GPU", "%s of %s", used, capacity);
}

void draw_reading(const StreamReport& r, const io::StreamReaderCounters& reader) {
    ui::heading("Reading");
    ui::row("Under way", "%u", r.in_flight);
    ui::tip("Pages and mips that were asked for and have not come (stream.page_requests, stream.map_requests).");
    ui::row("Pages, mips", "%llu, %llu", static_cast<unsigned long long>(r.pages_read),
            static_cast<unsigned long long>(r.mips_read));
    bytes_row("Bytes", static_cast<double>(r.bytes_read), "As stored, so far.");
    ui::row("Reads", "%llu", static_cast<unsigned long long>(reader.reads));
    const double mb_s = reader.read_s > 0 ? static_cast<double>(reader.bytes) / 1e6 / reader.read_s : 0;
    ui::row("Speed of reading", "%.0f MB/s", mb_s);
    ui::tip("Of the time that the reader's thread spent in reads.");
    ui::row("Unpacking", "%.2f s", reader.provide_s);
    ui::tip("Checking and decompressing, on the reader's thread, so far.");
    ui::row("Withdrawn", "%llu", static_cast<unsigned long long>(reader.unwanted));
    ui::tip("Requests that were no longer wanted when their turn came.");
    const bool failed = r.failed > 0 || reader.errors > 0;
    if (failed) ImGui::PushStyleColor(ImGuiCol_Text, ui::bad);
    ui::row("Failed", "%u", r.failed);
    if (failed) ImGui::PopStyleColor();
    ui::tip("What could not be read or was damaged: reported once, and coarser there. Messages say which.");
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
    flag("Streaming", r.complete, "coarse terrain there", "coarse terrain coming",
         "Whether the coarsest page and the smallest mips of every tile are there.");
    ui::graph({"queue", "pages, mips", 7, 0, "", false},
              {{&state.measures.ring(Series::pages_wanted), IM_COL32(235, 160, 90, 255), "wanted", 1, true},
               {&state.measures.ring(Series::requested), IM_COL32(125, 175, 235, 255), "under way", 1, false}});
    draw_geometry(r);
    draw_maps(r);
    draw_reading(r, state.reader);
}

} // namespace fjell::editor
