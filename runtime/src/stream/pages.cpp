// A page's way: requested, inserted, evicted; or failed.
#include "stream/pages.h"

#include <algorithm>
#include <bit>

#include "pack/memory.h"
#include "stream/requests.h"
#include "stream/watch.h"

namespace fjell {

namespace {

void record(StreamState& s, std::uint32_t watch, PageEvent event) {
    const ChunkId id = chunk_of(s, watch);
    if (s.arrival_count < max_arrivals) s.arrivals[s.arrival_count++] = {id.tile, id.item, event};
}

// A page's request ends without the page.
void end_request(StreamState& s, Request& r, WatchState state) {
    FJELL_ASSERT(s.states[r.watch] == WatchState::in_flight && s.reserved_slots != 0);
    s.states[r.watch] = state;
    FJELL_ASSERT(is_root(s, r.watch) || s.below[slot_of(r.watch)] != 0);
    if (!is_root(s, r.watch)) --s.below[slot_of(r.watch)];
    --s.reserved_slots;
    test(s, r.watch);
    set_phase(r, Phase::vacant);
}

void insert(StreamState& s, Request& r) {
    TerrainData& t = *s.terrain;
    const Status status = insert_page(s.terrain_handle, r.id.tile, r.id.item, {r.raw, r.raw_bytes});
    if (!status.ok()) {
        note_failure(s, r.id, r.first_chunk, StatusCode::corrupt);
        return end_request(s, r, WatchState::failed);
    }
    ++s.report.pages_inserted;
    record(s, r.watch, PageEvent::inserted);
    const std::uint32_t slot = t.page_table[std::size_t{r.id.tile} * t.pages_per_tile + r.id.item].slot;
    s.slot_watch[slot] = r.watch;
    s.states[r.watch] = WatchState::loaded;
    s.due[r.watch] = never;
    set_missing(s, r.watch, false);
    s.below[slot] = 0;
    const std::uint32_t own = slot * watches_per_slot;
    if (r.id.item != 0) watch_page(s, own, r.id.tile, r.id.item, WatchState::loaded);
    // The pages below: of page 0 the next step's, which is one page; of another page the four that divide it.
    const int z = r.id.item == 0 ? t.pages.tile_log2 - page_squares_log2 : t.pages.page_step_log2(r.id.item);
    if (z > 0) {
        const SampleIndex position = r.id.item == 0 ? SampleIndex{0, 0} : t.pages.page_position(r.id.item);
        for (std::uint32_t k = 0; k < (r.id.item == 0 ? 1u : 4u); ++k) {
            const bool only = r.id.item == 0;
            const auto px = static_cast<std::uint32_t>(position.column) * (only ? 1 : 2) + k % 2,
                       py = static_cast<std::uint32_t>(position.row) * (only ? 1 : 2) + k / 2;
            const std::uint32_t page = t.pages.page_at(z - 1, px, py);
            const bool failed = has_failed(s, chunk_index(t.header, {ChunkKind::geometry, r.id.tile, page}));
            watch_page(s, own + 1 + k, r.id.tile, page, failed ? WatchState::failed : WatchState::missing);
        }
    }
    --s.reserved_slots;
    set_phase(r, Phase::vacant);
}

void remove(StreamState& s, std::uint32_t slot) {
    const std::uint32_t watch = s.slot_watch[slot];
    const ChunkId id = chunk_of(s, watch);
    record(s, watch, PageEvent::removed);
    (void)unload_page(s.terrain_handle, id.tile, id.item);
    for (std::uint32_t k = 0; k < watches_per_slot; ++k) forget_watch(s, slot * watches_per_slot + k);
    s.slot_watch[slot] = no_index;
    s.states[watch] = WatchState::missing;
    FJELL_ASSERT(is_root(s, watch) || s.below[slot_of(watch)] != 0);
    if (!is_root(s, watch)) --s.below[slot_of(watch)];
    test(s, watch);
}

std::uint32_t free_slots(const StreamState& s) {
    return s.terrain->memory->free_count - s.reserved_slots;
}

} // namespace

void begin_pages(StreamState& s) {
    for (std::uint32_t i = 0; i < s.watch_count; ++i) forget_watch(s, i);
    for (std::uint32_t slot = 0; slot < s.slots; ++slot) s.slot_watch[slot] = no_index;
    for (std::uint32_t tile = 0; tile < s.tiles; ++tile)
        watch_page(s, root_watch(s, tile), tile, 0, WatchState::missing);
}

void insert_pages(StreamState& s) {
    for (std::uint32_t i = 0; i < s.budget.page_requests; ++i) {
        Request& r = s.requests[i];
        switch (phase_of(r)) {
        case Phase::damaged:
        case Phase::unreadable:
            note_failure(s, r.id, r.first_chunk,
                         phase_of(r) == Phase::damaged ? StatusCode::corrupt : StatusCode::unreadable);
            end_request(s, r, WatchState::failed);
            break;
        case Phase::unwanted: end_request(s, r, WatchState::missing); break;
        default: break;
        }
    }
    while (Request* const r = best_ready(s, 0, s.budget.page_requests)) {
        if (s.report.pages_inserted >= s.settings.pages) {
            s.report.exhausted |= stream_pages;
            break;
        }
        s.bytes_read += r->stored_bytes;
        ++s.pages_read;
        insert(s, *r);
    }
}

namespace {

// Who is next. Where slots are plenty, by score; where one page gives way to another, in the order in which they do
// (gives_way): were the slot to go to another than it was freed for, say one in view, both would come and go for ever.
float rank_of(const StreamState& s, std::uint32_t watch) {
    if (!s.contended || is_root(s, watch)) return score_of(s, watch);
    return s.page_px[watch] * (s.wants[watch] & 1 ? 1.0f : 1e-12f);
}

// No less than that, and cheaper.
float most_rank(const StreamState& s, std::uint32_t watch) {
    return is_root(s, watch) ? never : std::max(s.page_px[watch], score_if_seen(s, watch));
}

// Missing pages that are wanted: the worst one's px, and the best candidates for a request.
void gather(StreamState& s, Best& best) {
    double missing_px = 0;
    for (std::uint32_t word = 0; word < (s.watch_count + 63) / 64; ++word)
        for (std::uint64_t bits = s.missing_bits[word]; bits != 0; bits &= bits - 1) {
            const std::uint32_t watch = word * 64 + static_cast<std::uint32_t>(std::countr_zero(bits));
            if (s.moved) test(s, watch); // its px has changed with every step of an eye
            const WatchState state = s.states[watch];
            if (s.wants[watch] == 0) continue;
            if (s.wants[watch] & 1) {
                ++s.report.pages_wanted;
                missing_px = std::max(missing_px, static_cast<double>(s.page_px[watch]));
            }
            const bool going = !is_root(s, watch) && // with the page above it
                               s.states[slot_of(watch) * watches_per_slot] == WatchState::evicting;
            if (state == WatchState::missing && !going && best.takes(most_rank(s, watch)))
                best.offer({watch, 0, rank_of(s, watch)});
        }
    best.sort();
    // What has not been tested may hide anything.
    s.report.missing_px = s.tested ? missing_px : most_px;
    s.report.converged = s.tested && missing_px <= s.threshold_px; // a coarsest page may be wanted for its own sake
}

void review_requests(StreamState& s) {
    for (std::uint32_t i = 0; i < s.budget.page_requests; ++i) {
        Request& r = s.requests[i];
        const Phase phase = phase_of(r);
        if (phase != Phase::queued && phase != Phase::in_flight) continue;
        test(s, r.watch);
        const bool wanted = s.wants[r.watch] != 0;
        if (wanted) {
            r.score.store(score_of(s, r.watch), std::memory_order_relaxed);
        } else if (claim(r, Phase::vacant)) {
            end_request(s, r, WatchState::missing);
            ++s.report.cancelled;
            continue;
        }
        r.cancelled.store(!wanted, std::memory_order_relaxed); // noticed when the client has it
    }
}

// The offered request that is wanted least.
Request* least_queued(StreamState& s) {
    Request* least = nullptr;
    for (std::uint32_t i = 0; i < s.budget.page_requests; ++i) {
        Request& r = s.requests[i];
        if (phase_of(r) != Phase::queued) continue;
        if (!least || r.score.load(std::memory_order_relaxed) < least->score.load(std::memory_order_relaxed))
            least = &r;
    }
    return least;
}

bool request_page(StreamState& s, const Candidate& c) {
    Request* r = vacant_request(s, false);
    const float score = score_of(s, c.which);
    if (!r) {
        Request* const least = least_queued(s);
        if (!least || least->score.load(std::memory_order_relaxed) * 2 > score || !claim(*least, Phase::vacant))
            return false;
        end_request(s, *least, WatchState::missing);
        ++s.report.cancelled;
        r = least;
    }
    const ChunkId id = chunk_of(s, c.which);
    r->watch = c.which;
    if (!queue_request(s, *r, id, 1, score)) return false; // cannot be: one chunk
    s.states[c.which] = WatchState::in_flight;
    if (!is_root(s, c.which)) ++s.below[slot_of(c.which)];
    ++s.reserved_slots;
    return true;
}

// The loaded pages without pages below them that are wanted least, least first.
Best least_loaded(const StreamState& s) {
    Best least;
    for (std::uint32_t slot = 0; slot < s.slots; ++slot) {
        const std::uint32_t own = slot * watches_per_slot;
        if (s.states[own] != WatchState::loaded || s.below[slot] != 0) continue;
        const double wanted_by = s.wants[own] & 1 ? 2 : s.wants[own] != 0 ? 1 : 0;
        least.offer({slot, 0, -(wanted_by * 10 * most_px + static_cast<double>(s.page_px[own]))});
    }
    least.sort();
    return least;
}

// Has the cut evict the page in that slot.
void evict(StreamState& s, std::uint32_t slot) {
    const std::uint32_t watch = s.slot_watch[slot];
    record(s, watch, PageEvent::released);
    bool released = false; // evict_pages() calls again; the cut must be called in the order that is recorded
    const ChunkId id = chunk_of(s, watch);
    if (s.cut_state) (void)cut_release_page(s.cut, id.tile, id.item, released);
    s.states[slot * watches_per_slot] = s.states[watch] = WatchState::evicting;
    FJELL_ASSERT(s.evicting_count < max_evictions);
    s.evicting[s.evicting_count++] = slot;
    test(s, watch);
}

// A page is evicted only for one that is wanted clearly more, or two would evict each other for ever.
bool gives_way(StreamState& s, std::uint32_t slot, const Candidate& to) {
    const std::uint32_t own = slot * watches_per_slot;
    test(s, own);
    const bool wanted = s.wants[own] & 1, more = s.wants[to.which] & 1;
    if (wanted != more) return more;
    if (!wanted && s.wants[own] == 0) return true;
    return s.page_px[to.which] > 1.25f * s.page_px[own];
}

void evict_pages(StreamState& s) {
    for (std::uint32_t i = 0; i < s.evicting_count;) {
        const std::uint32_t slot = s.evicting[i], watch = s.slot_watch[slot];
        const ChunkId id = chunk_of(s, watch);
        bool released = s.cut_state == nullptr;
        if ((s.wants[watch] & 1) && free_slots(s) != 0 && !s.contended) { // after all
            if (s.cut_state) (void)cut_cancel_release(s.cut, id.tile, id.item);
            record(s, watch, PageEvent::kept);
            s.states[slot * watches_per_slot] = s.states[watch] = WatchState::loaded;
            test(s, watch);
            s.due[watch] = never;
            set_missing(s, slot * watches_per_slot, false); // tested while it was evicted, it was missed
        } else {
            if (!released) (void)cut_release_page(s.cut, id.tile, id.item, released);
            if (!released) {
                ++i;
                continue;
            }
            remove(s, slot);
        }
        s.evicting[i] = s.evicting[--s.evicting_count];
    }
    s.report.pages_evicting = s.evicting_count;
}

} // namespace

void request_pages(StreamState& s) {
    review_requests(s);
    test_pages(s);
    Best best;
    gather(s, best);
    evict_pages(s);
    if (best.count <= free_slots(s)) s.contended = false;
    std::uint32_t making_room = s.evicting_count, next = 0;
    Best least;
    for (std::uint32_t i = 0; i < best.count; ++i) {
        const Candidate& c = best.at[i];
        if (free_slots(s) != 0) {
            if (request_page(s, c)) continue;
            s.report.exhausted |= stream_requests;
            break;
        }
        if (making_room != 0) { // for this one
            --making_room;
            continue;
        }
        if (least.count == 0) least = least_loaded(s);
        const bool any = next < least.count && s.evicting_count < max_evictions;
        const std::uint32_t slot = any ? least.at[next].which : no_index;
        if (any) s.contended = s.wants[slot * watches_per_slot] != 0;
        if (any && slot != (is_root(s, c.which) ? no_index : slot_of(c.which)) && gives_way(s, slot, c)) {
            evict(s, slot);
            ++next;
            continue;
        }
        if (s.wants[c.which] & 1) s.report.exhausted |= stream_page_slots;
        break;
    }
    evict_pages(s);
    s.terrain->missing_px = s.report.missing_px;
    s.terrain->sought_px = s.threshold_px;
}

void forget_failed_pages(StreamState& s) {
    for (std::uint32_t i = 0; i < s.watch_count; ++i) {
        if (s.states[i] != WatchState::failed) continue;
        s.states[i] = WatchState::missing;
        s.due[i] = -1;
    }
}

} // namespace fjell
