// The stream's memory: how large, how laid out, how it begins.
#include <algorithm>
#include <cstring>
#include <new>

#define ZSTD_STATIC_LINKING_ONLY
#include <zstd.h>

#include "block_layout.h"
#include "stream/maps.h"
#include "stream/pages.h"
#include "stream/requests.h"

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

// Where its parts lie; one function for the size and for the placement, so they cannot disagree.
struct Layout {
    std::size_t watches, due, page_px, states, wants, missing_bits, watch_page, below, slot_watch, evicting,
        failed_bits, tiles[map_kinds], shown[map_kinds], free_layers[map_kinds], tile_box, commands, requests,
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
    if (!same_pack(pack.header, t.header) || pack.directory == nullptr) return {Code::wrong_pack, "pack"};
    if (t.pages.order == Order::linear)
        return {Code::not_supported,
                "terrain in linear order (bake with --order planar): coarse vertices lie in all pages"};
    if (b.page_requests < 1 || b.page_requests > max_page_requests)
        return {Code::out_of_range, "StreamBudget::page_requests (1 to 256)"};
    if (b.map_requests < 1 || b.map_requests > max_map_requests)
        return {Code::out_of_range, "StreamBudget::map_requests (1 to 64)"};
    if (b.tail_log2 < 2 || b.tail_log2 > max_texture_log2)
        return {Code::out_of_range, "StreamBudget::tail_log2 (2 to 12)"};
    if (b.decoders < 1 || b.decoders > max_decoders) return {Code::out_of_range, "StreamBudget::decoders (1 to 16)"};
    if (t.slot_count < t.tile_count()) return {Code::budget_too_small, "TerrainBudget::page_slots (one a tile)"};
    if (t.slot_count > 0xffffffffu / 8) return {Code::out_of_range, "TerrainBudget::page_slots"};
    if (t.pages_missing != t.page_count()) return {Code::out_of_range, "terrain (no page may be loaded yet)"};
    std::uint64_t bytes = 0;
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind)
        bytes += map_layer_bytes(map_layers(pack.header, b, static_cast<MapKind>(kind)), static_cast<MapKind>(kind));
    if (bytes > b.map_bytes)
        return {Code::budget_too_small, "StreamBudget::map_bytes (the smallest mips of all tiles)"};
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
    if (found == nullptr) return {Code::invalid_handle, "terrain"};
    TerrainData& terrain = *found;
    CutState* cut_state = nullptr;
    if (cut != LiveCut{}) {
        cut_state = find_cut(cut);
        if (cut_state == nullptr) return no_cut;
        if (cut_state->pages.grid.terrain != &terrain) return {Code::wrong_terrain, "cut"};
    }
    if (Status fits = check_budget(pack, terrain, budget); !fits.ok()) return fits;
    const Layout l = layout_of(pack, terrain, budget);
    if (memory.size() < l.end) return {Code::memory_too_small, "memory"};
    std::byte* const at = memory.data();
    if (reinterpret_cast<std::uintptr_t>(at) % block_alignment != 0) return {Code::out_of_range, "memory alignment"};
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
        if (decoder.zstd == nullptr) return {Code::memory_too_small, "memory"};
    }
    const auto padded = (s.watch_count + 63) / 64 * 64;
    for (std::uint32_t i = s.watch_count; i < padded; ++i) s.due[i] = 3e38f;
    begin_pages(s);
    begin_maps(s);
    HandleAccess::begin(s, stream);
    return {};
}

Status destroy_stream(Stream stream) {
    return HandleAccess::end(stream) ? Status{} : no_stream;
}

} // namespace fjell
