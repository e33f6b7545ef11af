#include "validate.h"

#include "pack/memory.h"
#include "stream/maps.h"
#include "stream/requests.h"
#include "stream/watch.h"

namespace fjell {

namespace {

// A request that has not ended: the client may move it on meanwhile, but only the frame's thread ends it.
bool is_open(const Request& r) {
    const Phase phase = phase_of(r);
    return phase != Phase::vacant && phase != Phase::shown;
}

Violation check_page_requests(const StreamState& s) {
    std::uint32_t open = 0, in_flight = 0;
    Tally requested, watched;
    for (std::uint32_t i = 0; i < s.budget.page_requests; ++i) {
        const Request& r = s.requests[i];
        if (phase_of(r) == Phase::shown) return {"a page was shown like a map"};
        if (!is_open(r)) continue;
        ++open;
        if (r.watch >= s.watch_count || s.states[r.watch] != WatchState::in_flight)
            return {"a request whose page is not in flight"};
        const ChunkId id = chunk_of(s, r.watch);
        if (r.id.kind != ChunkKind::geometry || r.id.tile != id.tile || r.id.item != id.item)
            return {"a request whose watch speaks of another page"};
        requested.add(r.watch);
    }
    if (open != s.reserved_slots) return {"reserved slots do not add up"};
    if (s.terrain->memory->free_count < open) return {"a request without a slot"};
    for (std::uint32_t watch = 0; watch < s.watch_count; ++watch) {
        if (s.states[watch] != WatchState::in_flight) continue;
        watched.add(watch);
        ++in_flight;
    }
    return in_flight == open && watched == requested ? Violation{} : Violation{"a page is in flight without a request"};
}

// A watch by itself: what is said of it in several places.
Violation check_watch(const StreamState& s, std::uint32_t watch) {
    const WatchState state = s.states[watch];
    const bool marked = (s.missing_bits[watch / 64] >> watch % 64 & 1) != 0;
    if (marked && s.wants[watch] == 0) return {"a page is missed, and not wanted"};
    if (marked && (state == WatchState::loaded || state == WatchState::idle))
        return {"a page is missed, and loaded or not watched"};
    if (!marked && s.wants[watch] != 0 && (state == WatchState::missing || state == WatchState::in_flight))
        return {"a page is wanted and not loaded, and not missed"};
    if (state == WatchState::idle) return {};
    if (s.watch_page[watch] >= s.terrain->page_count()) return {"a page is watched that there is not"};
    const bool failed = has_failed(s, chunk_index(s.terrain->header, chunk_of(s, watch)));
    return failed || state != WatchState::failed ? Violation{} : Violation{"a page has failed without a failure"};
}

// A slot with a page: its own watch, the one above it, and those below.
Violation check_slot(const StreamState& s, std::uint32_t slot) {
    const TerrainData& t = *s.terrain;
    const std::uint32_t page = t.slot_page[slot], watch = s.slot_watch[slot], own = slot * watches_per_slot;
    if ((page == no_index) != (watch == no_index)) return {"a slot is taken in one place and free in another"};
    if (page == no_index) {
        for (std::uint32_t k = 0; k < watches_per_slot; ++k)
            if (s.states[own + k] != WatchState::idle) return {"a page below a slot without a page is watched"};
        return {};
    }
    if (watch >= s.watch_count || s.watch_page[watch] != page) return {"a slot's watch speaks of another page"};
    const WatchState state = s.states[watch];
    if (state != WatchState::loaded && state != WatchState::evicting)
        return {"a page is loaded, and its watch says no"};
    if (is_root(s, watch)) {
        if (state != WatchState::loaded) return {"a coarsest page is not pinned"};
    } else {
        if (t.slot_page[slot_of(watch)] == no_index) return {"a page without the one above it"};
        if (s.states[own] != state || s.watch_page[own] != page) return {"two watches of a page disagree"};
    }
    std::uint32_t below = 0;
    for (std::uint32_t k = 1; k < watches_per_slot; ++k) {
        const WatchState of = s.states[own + k];
        below += of == WatchState::in_flight || of == WatchState::loaded || of == WatchState::evicting;
    }
    return below == s.below[slot] ? Violation{} : Violation{"pages below do not add up"};
}

Violation check_pages(const StreamState& s) {
    Tally listed, marked;
    for (std::uint32_t watch = 0; watch < s.watch_count; ++watch)
        if (const Violation wrong = check_watch(s, watch)) return wrong;
    for (std::uint32_t slot = 0; slot < s.slots; ++slot) {
        if (const Violation wrong = check_slot(s, slot)) return wrong;
        const std::uint32_t watch = s.slot_watch[slot];
        if (watch != no_index && s.states[watch] == WatchState::evicting) marked.add(slot);
    }
    for (std::uint32_t i = 0; i < s.evicting_count; ++i) listed.add(s.evicting[i]);
    return listed == marked ? Violation{} : Violation{"a page is evicted that is not listed, or listed twice"};
}

// Layers of one size: free, a tile's, or kept for one, each once.
Violation check_layers(const StreamState& s, std::uint32_t kind, std::uint32_t log2) {
    const MapState& m = s.maps[kind];
    const MapArray& array = m.arrays[log2];
    if (array.free_count > array.count) return {"more layers are free than there are"};
    Tally used, all;
    for (std::uint32_t i = 0; i < array.free_count; ++i) used.add(array.free_layers[i]);
    for (std::uint32_t i = 0; i < s.tiles; ++i) {
        if (m.tiles[i].size_log2 == log2) used.add(m.tiles[i].layer);
        if (m.tiles[i].lower_log2 == log2) used.add(m.tiles[i].reserved);
    }
    for (std::uint32_t i = s.budget.page_requests; i < s.request_count; ++i) {
        const Request& r = s.requests[i];
        if (!is_open(r) || r.repaints || map_of_chunks(r.id.kind) != kind) continue;
        if (m.sizes.top_log2 - r.id.item == log2) used.add(r.layer);
    }
    all.add_range(0, array.count);
    return used == all ? Violation{} : Violation{"a layer is used or free twice, or lost"};
}

Violation check_maps(const StreamState& s, std::uint32_t kind) {
    const MapState& m = s.maps[kind];
    if (m.sizes.top_log2 == 0) return {};
    Tally requested, waiting, repainted, repaints;
    for (std::uint32_t i = s.budget.page_requests; i < s.request_count; ++i) {
        const Request& r = s.requests[i];
        if (!is_open(r) || map_of_chunks(r.id.kind) != kind) continue;
        if (r.id.tile >= s.tiles) return {"a map is requested of a tile that there is not"};
        (r.repaints ? repainted : requested).add(r.id.tile);
    }
    for (std::uint32_t i = 0; i < s.tiles; ++i) {
        const MapTile& tile = m.tiles[i];
        if (tile.in_flight) waiting.add(i);
        for (std::uint32_t n = 0; n < tile.repaints; ++n) repaints.add(i);
        if (tile.size_log2 == 0) continue;
        if (tile.size_log2 < m.sizes.tail_log2 || tile.size_log2 > m.sizes.top_log2)
            return {"a tile has a map of a size that there is not"};
        if (tile.size_log2 == m.sizes.tail_log2 && tile.layer != i) return {"a tile's smallest map is another's"};
        if (m.shown[i].layer != tile.layer || m.shown[i].side_log2 != tile.size_log2)
            return {"a tile shows another map than it has"};
    }
    if (!(requested == waiting)) return {"a tile waits for a map without a request, or twice"};
    if (!(repainted == repaints)) return {"mips to be painted again do not add up"};
    for (std::uint32_t log2 = m.sizes.tail_log2 + 1; log2 <= m.sizes.top_log2; ++log2)
        if (const Violation wrong = check_layers(s, kind, log2)) return wrong;
    return {};
}

} // namespace

Violation validate_stream(const StreamState& s) {
    if (const Violation wrong = check_page_requests(s)) return wrong;
    if (const Violation wrong = check_pages(s)) return wrong;
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind)
        if (const Violation wrong = check_maps(s, kind)) return wrong;
    return {};
}

} // namespace fjell
