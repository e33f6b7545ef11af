#include <algorithm>
#include <chrono>
#include <cmath>

#include "cut/state.h"
#include "pack/memory.h"
#include "stream/maps.h"
#include "stream/pages.h"
#include "stream/requests.h"
#include "stream/watch.h"
#include "validate.h"

namespace fjell {

namespace {

using Clock = std::chrono::steady_clock; // CLOCK_MONOTONIC: read without a system call

Status check(const StreamState& s, std::span<const View> views, const CutSettings& cut, const StreamSettings& c) {
    if (views.empty() || views.size() > max_cut_views) return {Code::out_of_range, "views (1 to 8)"};
    if (Status v = validate(views, cut, s.cut_state ? s.cut_state->budget.views : max_cut_views); !v.ok()) return v;
    if (!(c.texel_px >= 0.1 && c.texel_px <= 100)) return {Code::out_of_range, "StreamSettings::texel_px (0.1 to 100)"};
    if (!(c.lookahead_s >= 0 && c.lookahead_s <= 60))
        return {Code::out_of_range, "StreamSettings::lookahead_s (0 to 60)"};
    if (!(c.fade_s >= 0 && c.fade_s <= 10)) return {Code::out_of_range, "StreamSettings::fade_s (0 to 10)"};
    if (!std::isfinite(c.now_s)) return {Code::out_of_range, "StreamSettings::now_s"};
    return {};
}

void finish(StreamState& s) {
    StreamReport& r = s.report;
    const TerrainData& t = *s.terrain;
    bool complete = true;
    for (std::uint32_t tile = 0; tile < s.tiles; ++tile)
        complete = complete && t.page_table[std::size_t{tile} * t.pages_per_tile].slot != no_index;
    r.complete = complete;
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
        const MapState& m = s.maps[kind];
        r.complete = r.complete && m.tails_missing == 0;
        MapLayers used = m.sizes;
        for (std::uint32_t log2 = used.tail_log2 + 1; used.top_log2 && log2 <= used.top_log2; ++log2)
            used.layers[log2] -= m.arrays[log2].free_count;
        r.map_bytes_used += map_layer_bytes(used, static_cast<MapKind>(kind));
        r.map_bytes_capacity += map_layer_bytes(m.sizes, static_cast<MapKind>(kind));
    }
    for (std::uint32_t i = 0; i < s.request_count; ++i) {
        const Phase phase = phase_of(s.requests[i]);
        if (phase == Phase::queued || phase == Phase::in_flight) ++r.in_flight;
        if (phase == Phase::ready) ++(i < s.budget.page_requests ? r.pages_left : r.mips_left);
    }
    const std::uint32_t used = s.slots - t.memory->free_count;
    s.slot_peak = std::max(s.slot_peak, used);
    r.page_slots = {used, s.slot_peak, s.slots};
    r.failed = static_cast<std::uint32_t>(s.failed);
    r.bytes_read = s.bytes_read;
    r.pages_read = s.pages_read;
    r.mips_read = s.mips_read;
}

} // namespace

void note_failure(StreamState& s, const ChunkId& id, std::uint64_t chunk, Code code) {
    s.failed_bits[chunk / 64] |= std::uint64_t{1} << chunk % 64;
    ++s.failed;
    FJELL_ASSERT(s.failure_count < s.request_count + 64);
    s.failures[s.failure_count++] = {id, code}; // there is room for all requests and what cannot be requested
}

Status update_stream(Stream stream, std::span<const View> views, const CutSettings& cut, const StreamSettings& settings,
                     StreamReport& report) {
    StreamState* const found = find_stream(stream);
    if (found == nullptr) return no_stream;
    StreamState& s = *found;
    if (Status v = check(s, views, cut, settings); !v.ok()) return v;
    const auto started = Clock::now();
    const double seconds = s.frame == 0 ? 0 : settings.now_s - s.now_s;
    s.settings = settings;
    s.report = {};
    s.report.frame = ++s.frame;
    s.failure_count = s.arrival_count = s.command_count = 0;
    for (std::uint32_t i = s.budget.page_requests; i < s.request_count; ++i)
        if (phase_of(s.requests[i]) == Phase::shown) set_phase(s.requests[i], Phase::vacant);
    set_views(s, views, cut, s.cut_state ? s.cut_state->governor.effective_px : 0);
    insert_pages(s);
    upload_maps(s);
    request_pages(s);
    request_maps(s, seconds);
    finish(s);
    s.report.update_us = std::chrono::duration<double, std::micro>(Clock::now() - started).count();
    report = s.report;
    FJELL_WALK(s.frame, validate_stream(s));
    return {};
}

std::span<const StreamFailure> stream_failures(Stream stream) {
    const StreamState* const s = find_stream(stream);
    if (s == nullptr) return {};
    return {s->failures, s->failure_count};
}
std::span<const PageArrival> stream_page_arrivals(Stream stream) {
    const StreamState* const s = find_stream(stream);
    if (s == nullptr) return {};
    return {s->arrivals, s->arrival_count};
}
std::span<const MapCommand> stream_map_commands(Stream stream) {
    const StreamState* const s = find_stream(stream);
    if (s == nullptr) return {};
    return {s->commands, s->command_count};
}

namespace {

const MapState* map_state(const Stream& stream, MapKind kind) {
    const StreamState* const s = find_stream(stream);
    const auto index = static_cast<std::uint32_t>(kind);
    return s != nullptr && index < map_kinds ? &s->maps[index] : nullptr;
}

} // namespace

std::span<const TileMap> stream_tile_maps(Stream stream, MapKind kind) {
    const MapState* const m = map_state(stream, kind);
    if (m == nullptr || m->sizes.top_log2 == 0) return {};
    return {m->shown, data_of(stream).tiles};
}
MapLayers stream_map_layers(Stream stream, MapKind kind) {
    const MapState* const m = map_state(stream, kind);
    return m != nullptr ? m->sizes : MapLayers{};
}

Status stream_retry_failed(Stream stream) {
    StreamState* const found = find_stream(stream);
    if (found == nullptr) return no_stream;
    StreamState& s = *found;
    for (std::uint64_t i = 0; i <= s.pack->header.directory_count / 64; ++i) s.failed_bits[i] = 0;
    forget_failed_pages(s);
    forget_failed_maps(s);
    return {};
}

const char* budget_field(StreamBudgetBit bit) {
    switch (bit) {
    case stream_page_slots: return "TerrainBudget::page_slots";
    case stream_map_bytes: return "StreamBudget::map_bytes";
    case stream_pages: return "StreamSettings::pages";
    case stream_upload: return "StreamSettings::map_bytes";
    case stream_tests: return "StreamSettings::tests";
    case stream_requests: break;
    }
    return "StreamBudget::page_requests or map_requests";
}

} // namespace fjell
