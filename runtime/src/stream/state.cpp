// A stream: its memory, how it begins, and an update.
#include "stream/state.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <new>
#define ZSTD_STATIC_LINKING_ONLY
#include <zstd.h>

#include "block_layout.h"
#include "cut/state.h"
#include "pack/memory.h"
#include "stream/maps.h"
#include "stream/pages.h"
#include "stream/requests.h"
#include "stream/watch.h"
#include "validate.h"

namespace fjell {

namespace {

std::uint32_t watch_count(const TerrainData& t) {
    return t.slot_count * watches_per_slot + t.tile_count();
}

// The most bytes that a request for maps brings: one mip, or a tail.
std::size_t map_room(const PackHeader& h, const StreamBudget& budget) {
    std::size_t most = 0;
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
        const MapLayers sizes = map_layers(h, budget, static_cast<MapKind>(kind));
        if (sizes.top_log2 == 0) continue;
        const ChunkKind chunks = chunks_of_map(kind);
        std::size_t tail = 0;
        for (std::uint32_t item = sizes.top_log2 - sizes.tail_log2; item < mip_count(sizes.top_log2); ++item)
            tail += chunk_raw_bytes(h, {chunks, 0, item});
        most = std::max(most, tail);
        for (std::uint32_t log2 = sizes.tail_log2 + 1; log2 <= sizes.top_log2; ++log2)
            if (sizes.layers[log2] != 0) most = std::max(most, chunk_raw_bytes(h, {chunks, 0, sizes.top_log2 - log2}));
    }
    return block_aligned(most);
}

std::size_t page_room(const TerrainData& t) {
    return block_aligned(max_page_raw_bytes(t.page_capacity));
}

// Of maps that paint changes: all mips of all requests.
std::uint32_t patch_room(const PackHeader& h, const StreamBudget& budget) {
    return h.colour_log2 == 0 && h.splat_log2 == 0 ? 0 : budget.map_requests * budget.tail_log2;
}

// Where its parts lie; one function for the size and for the placement, so they cannot disagree.
struct Layout {
    std::size_t watches, due, page_px, states, wants, missing_bits, watch_page, below, slot_watch, evicting,
        failed_bits, tiles[map_kinds], shown[map_kinds], free_layers[map_kinds], tile_box, commands, patches, requests,
        page_rooms, map_rooms, zstd, failures, arrivals, end;
};

Layout layout_of(const Pack& pack, const TerrainData& t, const StreamBudget& budget) {
    Layout l{};
    BlockLayout block(sizeof(StreamState));
    const auto place = [&](std::uint64_t count, std::size_t bytes) { return block.place(count, bytes); };
    const std::uint64_t watches = watch_count(t), padded = (watches + 63) / 64 * 64;
    const std::uint32_t requests = budget.page_requests + budget.map_requests;
    l.watches = place(watches, sizeof(Watch));
    l.due = place(padded, sizeof(float));
    l.page_px = place(watches, sizeof(float));
    l.states = place(watches, sizeof(WatchState));
    l.wants = place(watches, 1);
    l.missing_bits = place(padded / 64, 8);
    l.watch_page = place(watches, 4);
    l.below = place(t.slot_count, 1);
    l.slot_watch = place(t.slot_count, 4);
    l.evicting = place(max_evictions, 4);
    l.failed_bits = place(pack.header.directory_count / 64 + 1, 8);
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
        const MapLayers sizes = map_layers(pack.header, budget, static_cast<MapKind>(kind));
        const std::size_t tiles = sizes.top_log2 ? t.tile_count() : 0;
        l.tiles[kind] = place(tiles, sizeof(MapTile));
        l.shown[kind] = place(tiles, sizeof(TileMap));
        std::size_t layers = 0;
        for (std::uint32_t log2 = sizes.tail_log2 + 1; sizes.top_log2 && log2 <= sizes.top_log2; ++log2)
            layers += sizes.layers[log2];
        l.free_layers[kind] = place(layers, 4);
    }
    l.tile_box = place(t.tile_count(), sizeof(Watch));
    l.commands = place(requests + max_evictions, sizeof(MapCommand));
    l.patches = place(patch_room(pack.header, budget), sizeof(MapPatch));
    l.requests = place(requests, sizeof(Request));
    l.page_rooms = place(budget.page_requests, page_room(t));
    l.map_rooms = place(budget.map_requests, map_room(pack.header, budget));
    l.zstd = place(budget.decoders, block_aligned(ZSTD_estimateDCtxSize()));
    l.failures = place(requests + 64, sizeof(StreamFailure));
    l.arrivals = place(max_arrivals, sizeof(PageArrival));
    l.end = block.end();
    return l;
}

Status check_budget(const Pack& pack, const TerrainData& t, const StreamBudget& b) {
    if (!same_pack(pack.header, t.header) || pack.directory == nullptr) return {StatusCode::wrong_pack, "pack"};
    if (t.pages.order == PageOrder::linear)
        return {StatusCode::not_supported,
                "terrain in linear order (bake with --order planar): coarse vertices lie in all pages"};
    if (b.page_requests < 1 || b.page_requests > max_page_requests)
        return {StatusCode::out_of_range, "StreamBudget::page_requests (1 to 256)"};
    if (b.map_requests < 1 || b.map_requests > max_map_requests)
        return {StatusCode::out_of_range, "StreamBudget::map_requests (1 to 64)"};
    if (b.tail_log2 < 2 || b.tail_log2 > max_texture_log2)
        return {StatusCode::out_of_range, "StreamBudget::tail_log2 (2 to 12)"};
    if (b.decoders < 1 || b.decoders > max_decoders)
        return {StatusCode::out_of_range, "StreamBudget::decoders (1 to 16)"};
    if (t.slot_count < t.tile_count()) return {StatusCode::budget_too_small, "TerrainBudget::page_slots (one a tile)"};
    if (t.slot_count > 0xffffffffu / 8) return {StatusCode::out_of_range, "TerrainBudget::page_slots"};
    if (t.pages_missing != t.page_count()) return {StatusCode::out_of_range, "terrain (no page may be loaded yet)"};
    std::uint64_t bytes = 0;
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind)
        bytes += map_layer_bytes(map_layers(pack.header, b, static_cast<MapKind>(kind)), static_cast<MapKind>(kind));
    if (bytes > b.map_bytes)
        return {StatusCode::budget_too_small, "StreamBudget::map_bytes (the smallest mips of all tiles)"};
    return {};
}

} // namespace

std::size_t stream_bytes(const Pack& pack, const Terrain& terrain, const StreamBudget& budget) {
    const TerrainData* const t = find(terrain);
    return t != nullptr && check_budget(pack, *t, budget).ok() ? layout_of(pack, *t, budget).end : 0;
}

Status create_stream(const Pack& pack, const Terrain& handle, LiveCut cut, const StreamBudget& budget,
                     std::span<std::byte> memory, Stream& stream) {
    TerrainData* const found = find(handle);
    if (found == nullptr) return {StatusCode::invalid_handle, "terrain"};
    TerrainData& terrain = *found;
    CutState* cut_state = nullptr;
    if (cut != LiveCut{}) {
        cut_state = find_cut(cut);
        if (cut_state == nullptr) return no_cut;
        if (cut_state->pages.grid.terrain != &terrain) return {StatusCode::wrong_terrain, "cut"};
    }
    if (Status fits = check_budget(pack, terrain, budget); !fits.ok()) return fits;
    const Layout l = layout_of(pack, terrain, budget);
    if (memory.size() < l.end) return {StatusCode::memory_too_small, "memory"};
    std::byte* const at = memory.data();
    if (reinterpret_cast<std::uintptr_t>(at) % block_alignment != 0)
        return {StatusCode::out_of_range, "memory alignment"};
    std::memset(at, 0, l.end); // touches every page now rather than in a frame
    auto& s = *new (at) StreamState{};
    const auto part = [&]<typename T>(T*& pointer, std::size_t offset) { pointer = reinterpret_cast<T*>(at + offset); };
    s.own_pack = pack;
    s.pack = &s.own_pack;
    s.terrain_handle = handle;
    s.terrain = &terrain;
    s.cut = cut;
    s.cut_state = cut_state;
    s.budget = budget;
    s.tiles = terrain.tile_count();
    s.slots = terrain.slot_count;
    s.watch_count = watch_count(terrain);
    part(s.watches, l.watches);
    part(s.due, l.due);
    part(s.page_px, l.page_px);
    part(s.states, l.states);
    part(s.wants, l.wants);
    part(s.missing_bits, l.missing_bits);
    part(s.watch_page, l.watch_page);
    part(s.below, l.below);
    part(s.slot_watch, l.slot_watch);
    part(s.evicting, l.evicting);
    part(s.failed_bits, l.failed_bits);
    part(s.tile_box, l.tile_box);
    part(s.commands, l.commands);
    part(s.patches, l.patches);
    s.patch_room = patch_room(pack.header, budget);
    part(s.failures, l.failures);
    part(s.arrivals, l.arrivals);
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
        MapState& m = s.maps[kind];
        m.sizes = map_layers(pack.header, budget, static_cast<MapKind>(kind));
        part(m.tiles, l.tiles[kind]);
        part(m.shown, l.shown[kind]);
        std::uint32_t* layers = nullptr;
        part(layers, l.free_layers[kind]);
        for (std::uint32_t log2 = m.sizes.tail_log2 + 1; m.sizes.top_log2 && log2 <= m.sizes.top_log2; ++log2) {
            m.arrays[log2].free_layers = layers;
            layers += m.sizes.layers[log2];
        }
    }
    s.request_count = budget.page_requests + budget.map_requests;
    s.requests = reinterpret_cast<Request*>(at + l.requests);
    for (std::uint32_t i = 0; i < s.request_count; ++i) {
        Request* const r = new (s.requests + i) Request{};
        const bool page = i < budget.page_requests;
        r->raw = at + (page ? l.page_rooms + i * page_room(terrain)
                            : l.map_rooms + (i - budget.page_requests) * map_room(pack.header, budget));
    }
    for (std::uint32_t i = 0; i < budget.decoders; ++i) {
        Decoder& decoder = s.decoders[i];
        decoder.zstd =
            ZSTD_initStaticDCtx(at + l.zstd + i * block_aligned(ZSTD_estimateDCtxSize()), ZSTD_estimateDCtxSize());
        if (decoder.zstd == nullptr) return {StatusCode::memory_too_small, "memory"};
    }
    const auto padded = (s.watch_count + 63) / 64 * 64;
    for (std::uint32_t i = s.watch_count; i < padded; ++i) s.due[i] = 3e38f;
    begin_pages(s);
    begin_maps(s);
    HandleAccess::begin(s, stream);
    return {};
}

Status destroy_stream(Stream stream) {
    StreamState* const s = find_stream(stream);
    if (s != nullptr) s->terrain->map_patch_count = 0;
    return HandleAccess::end(stream) ? Status{} : no_stream;
}

// --- an update

namespace {

using Clock = std::chrono::steady_clock; // CLOCK_MONOTONIC: read without a system call

Status check(std::span<const View> views, const CutSettings& cut, const StreamSettings& c) {
    if (views.empty() || views.size() > max_cut_views) return {StatusCode::out_of_range, "views (1 to 8)"};
    CutBudget any;
    any.views = max_cut_views;
    if (Status v = validate(views, cut, any); !v.ok()) return v;
    if (!(c.texel_px >= 0.1 && c.texel_px <= 100))
        return {StatusCode::out_of_range, "StreamSettings::texel_px (0.1 to 100)"};
    if (!(c.lookahead_s >= 0 && c.lookahead_s <= 60))
        return {StatusCode::out_of_range, "StreamSettings::lookahead_s (0 to 60)"};
    if (!(c.fade_s >= 0 && c.fade_s <= 10)) return {StatusCode::out_of_range, "StreamSettings::fade_s (0 to 10)"};
    if (!std::isfinite(c.now_s)) return {StatusCode::out_of_range, "StreamSettings::now_s"};
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
    r.mips_left += s.horizons_waiting;
    const std::uint32_t used = s.slots - t.memory->free_count;
    s.slot_peak = std::max(s.slot_peak, used);
    r.page_slots = {used, s.slot_peak, s.slots};
    r.failed = static_cast<std::uint32_t>(s.failed);
    r.bytes_read = s.bytes_read;
    r.pages_read = s.pages_read;
    r.mips_read = s.mips_read;
}

} // namespace

void note_failure(StreamState& s, const ChunkId& id, std::uint64_t chunk, StatusCode code) {
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
    if (Status v = check(views, cut, settings); !v.ok()) return v;
    const auto started = Clock::now();
    const double seconds = s.frame == 0 ? 0 : settings.now_s - s.now_s;
    s.settings = settings;
    s.report = {};
    s.report.frame = ++s.frame;
    s.failure_count = s.arrival_count = s.command_count = s.patch_count = 0;
    for (std::uint32_t i = s.budget.page_requests; i < s.request_count; ++i)
        if (phase_of(s.requests[i]) == Phase::shown) set_phase(s.requests[i], Phase::vacant);
    set_views(s, views, cut, s.cut_state ? next_threshold_px(s.cut_state->governor, cut.max_error_px) : 0);
    follow_ground(s);
    insert_pages(s);
    upload_maps(s);
    request_pages(s);
    std::copy(views.begin(), views.end(), s.terrain->sought_view);
    s.terrain->sought_views = static_cast<std::uint32_t>(views.size());
    request_maps(s, seconds);
    publish_patches(s);
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
