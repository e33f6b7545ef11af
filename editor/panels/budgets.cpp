// Used, peak and capacity of every budget, which one is exhausted, the knob that raises it, and where the memory is.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/graph.h"
#include "editor/panels/panels.h"
#include "fjell/gl/palette.h"

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
    const ProfileKey* const key = find_profile_key(line.key);
    if (key == nullptr) return;
    const double now = key->get(state.document.profile()), more = std::min(2 * now, key->most);
    ImGui::PushID(line.key);
    if (now > 0 && more > now) {
        if (ImGui::SmallButton("Double")) commands.push(SetKey{key, more, false});
        ui::control("budget.double", line.key,
                    key->rebuild == Rebuild::nothing ? "Twice as much, from the next frame on."
                                                     : "Twice as much. Memory is reallocated; the view stays.");
        ImGui::SameLine();
    }
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ui::bad), "exhausted: %s", line.key);
    ImGui::PopID();
}

void draw_method(const State& state, Commands& commands) {
    const session::FrameEntry& e = state.measures.last();
    const Peaks& p = state.measures.peaks();
    const Profile& profile = state.document.profile();
    const bool kept = session::facts_of(profile).keeps_mesh;
    ui::heading("Refinement:  used | peak | limit");
    const double vertices_peak = std::max(e.vertex_slots.peak, p.vertices);
    draw_line({"Vertices", "budget.vertices", "Slots of the vertex buffer. At the limit, the threshold rises.",
               static_cast<double>(e.vertex_slots.used), vertices_peak, static_cast<double>(e.vertex_slots.capacity),
               session::exhausted_vertices},
              state, commands);
    if (!kept) {
        draw_line({"Indices", "budget.indices", "Slots of the index buffer. At the limit, the threshold rises.",
                   static_cast<double>(e.index_slots.used), static_cast<double>(p.indices),
                   static_cast<double>(e.index_slots.capacity), session::exhausted_indices},
                  state, commands);
        return;
    }
    draw_line({"Triangles", "budget.triangles",
               "Slots of the index buffer, in whole segments. At the limit, the threshold rises.",
               static_cast<double>(e.triangle_slots.used), static_cast<double>(e.triangle_slots.peak),
               static_cast<double>(e.triangle_slots.capacity), session::exhausted_triangles},
              state, commands);
    const bool limited = e.item_limit != unlimited_work;
    draw_line({"Work items", "budget.max_work",
               "Vertices that an update examines or changes. At the limit, the mesh lags behind the camera.",
               static_cast<double>(e.items), static_cast<double>(p.items),
               limited ? static_cast<double>(e.item_limit) : 0, session::exhausted_items},
              state, commands);
    draw_line({"Time, ms", "budget.max_time_us",
               "Time that an update may take. At the limit, the mesh lags behind the camera.", e.update_us, p.update_us,
               profile.cut.max_time_us, session::exhausted_time, Unit::microseconds},
              state, commands);
}

void draw_stream(const State& state, Commands& commands) {
    if (!state.scene.streamed) return;
    const StreamReport& r = state.measures.last().stream;
    const Peaks& p = state.measures.peaks();
    const Profile& profile = state.document.profile();
    ui::heading("Streaming:  used | peak | limit");
    draw_line({"Page slots", "stream.page_slots",
               "Pages in memory. At the limit, distant terrain is coarser than requested.",
               static_cast<double>(r.page_slots.used), static_cast<double>(std::max(r.page_slots.peak, p.page_slots)),
               static_cast<double>(r.page_slots.capacity), session::exhausted_page_slots},
              state, commands);
    draw_line({"Requests", "stream.page_requests",
               "Pages and mips in flight (stream.map_requests for mips). At the limit, further requests wait.",
               static_cast<double>(r.in_flight), static_cast<double>(p.requested),
               static_cast<double>(profile.stream_budget.page_requests + profile.stream_budget.map_requests),
               session::exhausted_stream_requests},
              state, commands);
    draw_line({"Pages per frame", "stream.pages",
               "Inserted pages, 5 to 10 us each. At the limit, pages wait for the next frame.",
               static_cast<double>(r.pages_inserted), static_cast<double>(p.pages_inserted),
               static_cast<double>(profile.stream.pages), session::exhausted_stream_pages},
              state, commands);
    draw_line({"Map memory", "stream.map_mb",
               "Maps on the GPU. At the limit, distant maps are blurrier than requested.",
               static_cast<double>(r.map_bytes_used), static_cast<double>(p.map_bytes),
               static_cast<double>(r.map_bytes_capacity), session::exhausted_map_bytes, Unit::bytes},
              state, commands);
    draw_line({"Upload per frame", "stream.map_kb", "Maps uploaded to the GPU; one mip may exceed it.",
               static_cast<double>(r.map_upload_bytes), static_cast<double>(p.map_upload_bytes),
               static_cast<double>(profile.stream.map_bytes), session::exhausted_stream_upload, Unit::bytes},
              state, commands);
    const bool tests = (state.measures.last().exhausted & session::exhausted_stream_tests) != 0;
    ui::row("Pages tested", tests ? "limit reached" : "within the limit");
    ui::tip(
        "How many pages one stream update tests for being wanted (stream.tests). Raise it when the limit is reached.");
}

void memory_row(const char* label, double bytes, const char* about, double& sum) {
    ui::row(label, "%s", byte_text(bytes).text);
    ui::tip(about);
    sum += bytes;
}

void draw_memory(const State& state) {
    const Scene& s = state.scene;
    const session::FrameEntry& e = state.measures.last();
    const session::MethodFacts& slot = session::facts_of(state.document.profile());
    double host = 0, gpu = 0;
    ui::heading("Memory");
    memory_row("Terrain", static_cast<double>(s.terrain_bytes), "Page slots, page table and corners.", host);
    memory_row("Method", static_cast<double>(s.method_bytes), "Vertices, indices and bookkeeping.", host);
    if (s.streamed)
        memory_row("Stream", static_cast<double>(s.stream_bytes), "Requests in flight and their buffers.", host);
    memory_row("GPU: mesh",
               static_cast<double>(slot.gpu_vertex_bytes) * e.vertex_slots.capacity +
                   static_cast<double>(slot.gpu_triangle_bytes) *
                       std::max(e.triangle_slots.capacity, e.index_slots.capacity), // the method has one of them
               "Vertex and index buffers, without staging buffers.", gpu);
    if (state.drawn)
        memory_row("GPU: maps", static_cast<double>(state.drawn->texture_bytes), "Textures of colours and normals.",
                   gpu);
    double sum = 0;
    ImGui::Separator();
    memory_row("Total", host + gpu, "Host and GPU, without the program itself.", sum);
}

} // namespace

void draw_budgets(const State& state, PanelState&, Commands& commands) {
    draw_method(state, commands);
    draw_stream(state, commands);
    draw_memory(state);
}

// --- What streams: what is wanted, under way, failed and read, and how far the picture is from all of it.

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
    ImGui::TextWrapped("To stream it, give the profile fewer page slots than the pack has pages (Tune > Streaming), "
                       "and at least one for each tile. Pages are then read when the view wants them.");
    const std::uint32_t tiles = state.scene.tiles;
    const std::uint32_t slots = std::max(tiles, state.scene.pages / 2);
    if (slots >= state.scene.pages) return;
    char label[64];
    std::snprintf(label, sizeof label, "Stream with %s page slots", count_text(slots).text);
    if (ImGui::Button(label))
        commands.push(SetKey{find_profile_key("stream.page_slots"), static_cast<double>(slots), false});
    ui::control("streaming", "begin", "Half of its pages. The pack is reopened and the view stays; Undo reverts it.");
}

void draw_geometry(const StreamReport& r) {
    ui::heading("Geometry");
    flag("Pages for this view", r.converged, "complete", "incomplete",
         "Complete: the threshold holds against the whole terrain.");
    ui::row("Wanted, missing", "%s", count_text(r.pages_wanted).text);
    ui::tip("Pages that the views want and that are not loaded yet. Their coarser pages are loaded.");
    ui::row("Inserted, waiting", "%s, %s", count_text(r.pages_inserted).text, count_text(r.pages_left).text);
    ui::tip("Pages that were inserted in this frame, and pages that have arrived and wait for the next frames "
            "(stream.pages).");
    ui::row("Evicting", "%s", count_text(r.pages_evicting).text);
    ui::tip("Pages that no view wants any more. They are evicted as soon as the mesh does not use them.");
    ui::row("Page slots", "%s of %s", count_text(r.page_slots.used).text, count_text(r.page_slots.capacity).text);
    if (r.missing_px >= 1e7)
        ui::row("Error of missing pages", "unbounded");
    else
        ui::row("Error of missing pages", "%.2f px", r.missing_px);
    ui::tip("The largest error on screen that a missing page may hide, in pixels.");
}

void draw_maps(const StreamReport& r) {
    ui::heading("Maps");
    flag("Mips for this view", r.maps_converged, "complete", "incomplete", "Complete: loaded and faded in.");
    ui::row("Uploaded, waiting", "%s, %s", count_text(r.mips_uploaded).text, count_text(r.mips_left).text);
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

void draw_streaming(const State& state, PanelState&, Commands& commands) {
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

// --- How many of the triangles that are drawn are of which level.

namespace {

// "0  64 cells": a bar as long as its share of the fullest level.
void level_bar(const LevelHistogram& levels, std::uint32_t level, int tile_log2, double cell_m) {
    const float em = ImGui::GetFontSize(), names = 6 * em, numbers = 4.8F * em;
    const ImVec2 from = ImGui::GetCursorScreenPos();
    const float width = std::max(ImGui::GetContentRegionAvail().x, names + numbers + em);
    const float room = width - names - numbers;
    const std::uint32_t count = levels.triangles[level];
    ImDrawList& list = *ImGui::GetWindowDrawList();
    char text[32];
    // Legs of level 2 k are 2^(tile_log2 - k) cells long.
    const double leg_m = cell_m * std::exp2(tile_log2 - level / 2.0);
    if (leg_m >= 1000)
        std::snprintf(text, sizeof text, "%2u  %.3g km", level, leg_m / 1000);
    else
        std::snprintf(text, sizeof text, "%2u  %.3g m", level, leg_m);
    list.AddText(from, ImGui::GetColorU32(ImGuiCol_Text), text);
    const float share = levels.most > 0 ? static_cast<float>(count) / static_cast<float>(levels.most) : 0;
    const float x = from.x + names;
    list.AddRectFilled({x, from.y + 0.1F * em}, {x + std::max(share * room, count > 0 ? 1.0F : 0.0F), from.y + em},
                       ui::colour(gl::level_rgb(static_cast<int>(level), tile_log2)));
    const NumberText shown = count_text(count);
    const char* const number = shown.text;
    list.AddText({from.x + width - ImGui::CalcTextSize(number).x, from.y}, ImGui::GetColorU32(ImGuiCol_Text), number);
    ImGui::Dummy({width, 1.15F * em});
    char about[96];
    std::snprintf(about, sizeof about, "level %u: %s triangles with short sides of %.4g m", level, number, leg_m);
    ui::tip(about);
}

} // namespace

void draw_levels(const State& state, PanelState&, Commands& commands) {
    const LevelHistogram& levels = state.measures.levels();
    const int tile_log2 = static_cast<int>(std::bit_width(state.scene.tile_cells)) - 1;
    std::uint64_t all = 0;
    for (const std::uint32_t count : levels.triangles) all += count;
    ui::heading("Triangles drawn, by level");
    ui::tip("Level 0: the two base triangles of a tile; each further level halves them. Legs are a triangle's two "
            "equal sides.");
    for (std::uint32_t i = 0; i < levels.levels; ++i)
        level_bar(levels, i, tile_log2, std::min(state.scene.spacing_m[0], state.scene.spacing_m[1]));
    ui::row("Total", "%s", count_text(static_cast<double>(all)).text);
    bool shown = state.interface.mode == session::PictureMode::levels;
    if (ImGui::Checkbox("Colour the picture by level", &shown))
        commands.push(SetPictureMode{shown ? session::PictureMode::levels : session::PictureMode::shaded});
    ui::control("levels", "colour", "Every triangle in its level's colour, as here. Costs almost nothing.");
}

} // namespace fjell::editor
