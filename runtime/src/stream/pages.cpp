// Which pages the views want, without looking at their vertices.
//
// A vertex is wanted while the eye is nearer than radius + error q (tree/wanted.h). Of a page the directory knows the
// largest of both and how high its ground is, so a page none of whose vertices can be wanted is told apart by one
// distance to a box. Bounds do not have to nest: a page is watched only when the one above it is loaded, and a wanted
// vertex' ancestors are wanted, one of them in every page above (a page's bound counts its borders too). So when no
// watched page is wanted and missing, no vertex is.
//
// The largest threshold at which a missing page would still be wanted, its px, is therefore what the mesh guarantees
// meanwhile: every page wanted at a higher one is there. That is how page slots answer to the governor: instead of a
// threshold that is raised until pages suffice, the worst page without a slot says which one they suffice for.
#include "stream/pages.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "pack/memory.h"
#include "stream/best.h"
#include "stream/requests.h"

namespace fjell {

namespace {

constexpr float never = 3e38f;
constexpr double grow = 1 + 0x1p-16; // more than all roundings of wanted() together
constexpr double most_px = 1e7;      // of pages that are wanted at any threshold
constexpr double sooner = 0.95;      // share of the threshold at which a page will be wanted soon

std::uint32_t root_watch(const StreamState& s, std::uint32_t tile) {
    return s.slots * watches_per_slot + tile;
}
bool is_root(const StreamState& s, std::uint32_t watch) {
    return watch >= s.slots * watches_per_slot;
}
std::uint32_t slot_of(std::uint32_t watch) {
    return watch / watches_per_slot;
}
ChunkId chunk_of(const StreamState& s, std::uint32_t watch) {
    const std::uint32_t page = s.watch_page[watch], pages = s.terrain->pages_per_tile;
    return {ChunkKind::geometry, page / pages, page % pages};
}

Watch box_of(const StreamState& s, std::uint32_t tile, std::uint32_t page) {
    const Terrain& t = *s.terrain;
    const PageBound bound = s.pack->entry(chunk_index(t.header, {ChunkKind::geometry, tile, page})).bound;
    const auto tile_x = static_cast<std::int32_t>(tile % t.header.tiles_x),
               tile_y = static_cast<std::int32_t>(tile / t.header.tiles_x);
    Coord first{tile_x * t.tree.side(), tile_y * t.tree.side()};
    std::int32_t cells = t.tree.side();
    if (const int z = t.pages.page_step_log2(page); z >= 0) {
        const Coord block = t.pages.page_block(page);
        cells = static_cast<std::int32_t>(2 * page_squares) << z;
        first = {first.x + block.x * cells, first.y + block.y * cells};
    }
    const Coord a = t.tree.sample(first), b = t.tree.sample({first.x + cells, first.y + cells});
    const std::uint32_t shift = bound_shift(t.header);
    const auto height = [&](std::uint32_t steps) { return t.lattice.height_m(static_cast<std::int32_t>(steps)); };
    return {t.x_m(a.x),
            t.x_m(b.x),
            height(std::uint32_t{bound.low} << shift),
            height(((std::uint32_t{bound.high} + 1) << shift) - 1),
            t.z_m(a.y),
            t.z_m(b.y),
            t.errors.metres[bound.error],
            t.header.level_radius_m[bound_level(t.pages, page)] * t.radii.factor[bound.radius]};
}

void watch_page(StreamState& s, std::uint32_t watch, std::uint32_t tile, std::uint32_t page, WatchState state) {
    s.watches[watch] = box_of(s, tile, page);
    s.watch_page[watch] = tile * s.terrain->pages_per_tile + page;
    s.states[watch] = state;
    s.due[watch] = -1;
    s.wants[watch] = 0;
    s.page_px[watch] = 0;
}

void set_missing(StreamState& s, std::uint32_t watch, bool missing) {
    const std::uint64_t bit = std::uint64_t{1} << watch % 64;
    s.missing_bits[watch / 64] = missing ? s.missing_bits[watch / 64] | bit : s.missing_bits[watch / 64] & ~bit;
}

void forget_watch(StreamState& s, std::uint32_t watch) {
    s.states[watch] = WatchState::idle;
    s.due[watch] = never;
    s.wants[watch] = 0;
    set_missing(s, watch, false);
}

// How wanted, by whom, and for how long that stands.
void test(StreamState& s, std::uint32_t watch) {
    const Watch& w = s.watches[watch];
    double most = 0, slack_m = never;
    std::uint8_t wants = 0;
    for (std::uint32_t i = 0; i < s.eye_count; ++i) {
        const WantedEye& eye = s.eyes[i];
        const double threshold = s.threshold_px * (eye.predicted ? sooner : 1);
        // The eye is rounded to float there: a few units in the last place.
        const double pad = (std::abs(eye.x) + std::abs(eye.y) + std::abs(eye.z)) * 0x1p-22;
        const double apart = distance_m(w, {eye.x, eye.y, eye.z}) - w.radius_m * grow - pad, reach = w.error_m * grow * eye.lambda_px;
        const double px = apart > 0 ? std::min(reach / apart, most_px) : most_px;
        if (px > threshold) wants |= eye.predicted ? 2 : 1;
        most = std::max(most, px);
        slack_m = std::min(slack_m, std::abs(apart - reach / threshold));
    }
    if (is_root(s, watch)) wants |= 1;
    s.wants[watch] = wants;
    s.page_px[watch] = static_cast<float>(most);
    s.due[watch] = static_cast<float>(std::min((s.odometer_m + slack_m * 0.999) * (1 - 0x1p-22), double{never} / 2));
    const WatchState state = s.states[watch];
    set_missing(s, watch, wants != 0 && state != WatchState::loaded && state != WatchState::idle);
}

// What brings a request forward: how much worse than the threshold it is, that a frustum may show it, and that it is
// wanted now and not only soon. The coarsest pages come first: without them there is nothing to draw.
float score_of(const StreamState& s, std::uint32_t watch) {
    const float ratio = static_cast<float>(s.page_px[watch] / s.threshold_px);
    const float seen = may_be_seen(s, s.watches[watch]) ? 8.0f : 1.0f, now = s.wants[watch] & 1 ? 1.0f : 0.1f;
    return (is_root(s, watch) ? 1e9f : 0.0f) + ratio * seen * now;
}

// Who is next. Where slots are plenty, by score; where one page gives way to another, in the order in which they do
// (gives_way): were the slot to go to another than it was freed for, say one in view, both would come and go for ever.
float rank_of(const StreamState& s, std::uint32_t watch) {
    if (!s.contended || is_root(s, watch)) return score_of(s, watch);
    return s.page_px[watch] * (s.wants[watch] & 1 ? 1.0f : 1e-12f);
}

void record(StreamState& s, std::uint32_t watch, PageEvent event) {
    const ChunkId id = chunk_of(s, watch);
    if (s.arrival_count < max_arrivals) s.arrivals[s.arrival_count++] = {id.tile, id.item, event};
}

// A page's request ends without the page.
void end_request(StreamState& s, Request& r, WatchState state) {
    s.states[r.watch] = state;
    if (!is_root(s, r.watch)) --s.below[slot_of(r.watch)];
    --s.reserved_slots;
    test(s, r.watch);
    set_phase(r, Phase::vacant);
}

void insert(StreamState& s, Request& r) {
    Terrain& t = *s.terrain;
    const Status status = insert_page(t, r.id.tile, r.id.item, {r.raw, r.raw_bytes});
    if (!status.ok()) {
        note_failure(s, r.id, r.first_chunk, Code::corrupt);
        return end_request(s, r, WatchState::failed);
    }
    ++s.report.pages_taken;
    record(s, r.watch, PageEvent::inserted);
    const std::uint32_t slot = t.page_table[std::size_t{r.id.tile} * t.pages_per_tile + r.id.item].slot;
    s.slot_watch[slot] = r.watch;
    s.states[r.watch] = WatchState::loaded;
    s.due[r.watch] = never;
    set_missing(s, r.watch, false);
    s.below[slot] = 0;
    const std::uint32_t own = slot * watches_per_slot;
    if (r.id.item != 0) watch_page(s, own, r.id.tile, r.id.item, WatchState::loaded);
    // The pages below: of page 0 the next step's, which is one block; of a block the four that divide it.
    const int z = r.id.item == 0 ? t.pages.tile_log2 - page_squares_log2 : t.pages.page_step_log2(r.id.item);
    if (z > 0) {
        const Coord block = r.id.item == 0 ? Coord{0, 0} : t.pages.page_block(r.id.item);
        for (std::uint32_t k = 0; k < (r.id.item == 0 ? 1u : 4u); ++k) {
            const bool only = r.id.item == 0;
            const auto bx = static_cast<std::uint32_t>(block.x) * (only ? 1 : 2) + k % 2,
                       by = static_cast<std::uint32_t>(block.y) * (only ? 1 : 2) + k / 2;
            const std::uint32_t page = t.pages.page_of_block(z - 1, bx, by);
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
    unload_page(*s.terrain, id.tile, id.item);
    for (std::uint32_t k = 0; k < watches_per_slot; ++k) forget_watch(s, slot * watches_per_slot + k);
    s.slot_watch[slot] = none;
    s.states[watch] = WatchState::missing;
    if (!is_root(s, watch)) --s.below[slot_of(watch)];
    test(s, watch);
}

std::uint32_t free_slots(const StreamState& s) {
    return s.terrain->memory->free_count - s.reserved_slots;
}

} // namespace

double distance_m(const Watch& w, Vec3 eye) {
    const auto beyond = [](double at, double low, double high) { return std::max({low - at, at - high, 0.0}); };
    return length({beyond(eye.x, w.x0, w.x1), beyond(eye.y, w.y0, w.y1), beyond(eye.z, w.z0, w.z1)});
}

Watch tile_box(const StreamState& s, std::uint32_t tile) {
    Watch box = box_of(s, tile, 0);
    box.y0 -= box.error_m;
    box.y1 += box.error_m;
    return box;
}

bool may_be_seen(const StreamState& s, const Watch& w) {
    const Vec3 middle{(double{w.x0} + w.x1) / 2, (double{w.y0} + w.y1) / 2, (double{w.z0} + w.z1) / 2};
    const double radius = length({(double{w.x1} - w.x0) / 2, (double{w.y1} - w.y0) / 2, (double{w.z1} - w.z0) / 2});
    for (std::uint32_t i = 0; i < s.view_count; ++i) {
        const Vec3 p = middle - s.views[i].eye_m;
        bool inside = true;
        for (int plane = 0; plane < 6 && inside; ++plane)
            inside = dot(s.frustums[i].normal[plane], p) >= s.frustums[i].offset[plane] - radius;
        if (inside) return true;
    }
    return false;
}

namespace {

// Where an eye will be, if it goes on as it did: the slower of its last two speeds, so that a cut of the camera is no
// motion, and smoothed.
Vec3 ahead(StreamState& s, std::uint32_t i, Vec3 eye, double seconds) {
    Vec3 now{};
    if (seconds > 0) now = (eye - s.last_eye[i]) * (1 / seconds);
    const Vec3 slower = length(now) < length(s.last_speed[i]) ? now : s.last_speed[i];
    s.last_speed[i] = now;
    s.last_eye[i] = eye;
    s.speed[i] = s.speed[i] + (slower - s.speed[i]) * 0.25;
    const Vec3 way = s.speed[i] * s.settings.lookahead_s;
    if (!std::isfinite(length(way))) { // a clock that hardly moves
        s.last_speed[i] = s.speed[i] = {};
        return eye;
    }
    const double cell_m = std::min(s.terrain->spacing_x_m, s.terrain->spacing_z_m);
    return length(way) < 0.5 * cell_m ? eye : eye + way;
}

} // namespace

void look_for_pages(StreamState& s, std::span<const View> views, const CutSettings& cut, double effective_px) {
    const double nested = 1 + static_cast<double>(s.terrain->header.nesting);
    const double early = cut.morph == Morph::none ? 1 : nested * nested;
    const double threshold_px = std::max(cut.error_px, effective_px);
    const double seconds = s.settings.now_s - s.now_s;
    const std::uint32_t kinds = s.settings.lookahead_s > 0 ? 2 : 1;
    const auto count = static_cast<std::uint32_t>(views.size());
    bool all = threshold_px != s.threshold_px || count != s.view_count || s.eye_count != count * kinds;
    double way_m = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3 eye = views[i].eye_m;
        if (i >= s.view_count) s.last_eye[i] = eye, s.last_speed[i] = s.speed[i] = {};
        const double lambda = views[i].lambda_px * early * (cut.corner_safe ? corner_factor(views[i]) : 1);
        for (std::uint32_t kind = 0; kind < kinds; ++kind) {
            const Vec3 at = kind == 0 ? eye : ahead(s, i, eye, seconds);
            WantedEye& e = s.eyes[i * kinds + kind];
            all = all || e.lambda_px != lambda;
            way_m = std::max(way_m, length(at - Vec3{e.x, e.y, e.z}));
            e = {at.x, at.y, at.z, lambda, kind != 0};
        }
        s.views[i] = views[i];
        s.frustums[i] = make_frustum(views[i]);
    }
    s.eye_count = count * kinds;
    s.view_count = count;
    s.threshold_px = threshold_px;
    s.now_s = s.settings.now_s;
    s.moved = all || way_m > 0;
    s.odometer_m += way_m * grow;
    if (!all && s.odometer_m < 1e6 * static_cast<double>(std::min(s.terrain->spacing_x_m, s.terrain->spacing_z_m))) return;
    s.odometer_m = 0;
    for (std::uint32_t i = 0; i < s.watch_count; ++i)
        if (s.due[i] < never) s.due[i] = -1;
    s.tested = false; // from where the last tests ended: what changes with every frame must not begin anew with each
}

void begin_pages(StreamState& s) {
    for (std::uint32_t i = 0; i < s.watch_count; ++i) forget_watch(s, i);
    for (std::uint32_t slot = 0; slot < s.slots; ++slot) s.slot_watch[slot] = none;
    for (std::uint32_t tile = 0; tile < s.tiles; ++tile)
        watch_page(s, root_watch(s, tile), tile, 0, WatchState::missing);
}

void take_pages(StreamState& s) {
    for (std::uint32_t i = 0; i < s.budget.page_requests; ++i) {
        Request& r = s.requests[i];
        switch (phase_of(r)) {
        case Phase::damaged:
        case Phase::unreadable:
            note_failure(s, r.id, r.first_chunk, phase_of(r) == Phase::damaged ? Code::corrupt : Code::unreadable);
            end_request(s, r, WatchState::failed);
            break;
        case Phase::unwanted: end_request(s, r, WatchState::missing); break;
        default: break;
        }
    }
    while (Request* const r = best_ready(s, 0, s.budget.page_requests)) {
        if (s.report.pages_taken >= s.settings.pages) {
            s.report.exhausted |= stream_pages;
            break;
        }
        s.bytes_read += r->stored_bytes;
        ++s.pages_read;
        insert(s, *r);
    }
}

namespace {

// Tests everything whose time has come. Sets `tested` when the limit sufficed.
void test_pages(StreamState& s) {
    const auto now = static_cast<float>(s.odometer_m * (1 + 0x1p-22));
    constexpr std::uint32_t run = 64; // looked through at once
    std::uint32_t left = s.settings.tests, base = s.tested ? 0 : s.cursor / run * run;
    const std::uint32_t runs = (s.watch_count + run - 1) / run;
    for (std::uint32_t n = 0; n < runs; ++n) {
        if (base >= s.watch_count) base = 0;
        int any = 0;
        for (std::uint32_t i = base; i < base + run; ++i) any |= s.due[i] <= now ? 1 : 0; // due[] is padded to runs
        if (any != 0) {
            if (left == 0) {
                s.cursor = base;
                s.tested = false;
                s.report.exhausted |= stream_tests;
                return;
            }
            for (std::uint32_t i = base; i < std::min(base + run, s.watch_count); ++i) {
                if (!(s.due[i] <= now)) continue;
                test(s, i);
                left -= left != 0;
            }
        }
        base += run;
    }
    s.tested = true;
}

// Missing pages that are wanted: the worst one's px, and the best candidates to be asked for.
void gather(StreamState& s, Best& best) {
    double missing_px = 0;
    for (std::uint32_t word = 0; word < (s.watch_count + 63) / 64; ++word)
        for (std::uint64_t bits = s.missing_bits[word]; bits != 0; bits &= bits - 1) {
            const std::uint32_t watch = word * 64 + static_cast<std::uint32_t>(std::countr_zero(bits));
            test(s, watch); // its px has changed with every step of the eye
            const WatchState state = s.states[watch];
            if (s.wants[watch] == 0) continue;
            if (s.wants[watch] & 1) {
                ++s.report.pages_wanted;
                missing_px = std::max(missing_px, static_cast<double>(s.page_px[watch]));
            }
            const bool going = !is_root(s, watch) && // with the page above it
                               s.states[slot_of(watch) * watches_per_slot] == WatchState::draining;
            if (state == WatchState::missing && !going) best.offer({watch, 0, rank_of(s, watch)});
        }
    // What has not been looked at may hide anything.
    s.report.missing_px = s.tested ? missing_px : most_px;
    s.report.converged = s.tested && missing_px <= s.threshold_px; // a coarsest page may be wanted for its own sake
}

void review_requests(StreamState& s) {
    for (std::uint32_t i = 0; i < s.budget.page_requests; ++i) {
        Request& r = s.requests[i];
        const Phase phase = phase_of(r);
        if (phase != Phase::offered && phase != Phase::taken) continue;
        test(s, r.watch);
        r.wanted = s.wants[r.watch] != 0;
        if (r.wanted) {
            r.score.store(score_of(s, r.watch), std::memory_order_relaxed);
        } else if (claim(r, Phase::vacant)) {
            end_request(s, r, WatchState::missing);
            ++s.report.withdrawn;
            continue;
        }
        r.withdrawn.store(!r.wanted, std::memory_order_relaxed); // noticed when the client has it
    }
}

// The offered request that is wanted least.
Request* least_offered(StreamState& s) {
    Request* least = nullptr;
    for (std::uint32_t i = 0; i < s.budget.page_requests; ++i) {
        Request& r = s.requests[i];
        if (phase_of(r) != Phase::offered) continue;
        if (!least || r.score.load(std::memory_order_relaxed) < least->score.load(std::memory_order_relaxed)) least = &r;
    }
    return least;
}

bool ask(StreamState& s, const Candidate& c) {
    Request* r = vacant_request(s, false);
    const float score = score_of(s, c.which);
    if (!r) {
        Request* const least = least_offered(s);
        if (!least || least->score.load(std::memory_order_relaxed) * 2 > score || !claim(*least, Phase::vacant))
            return false;
        end_request(s, *least, WatchState::missing);
        ++s.report.withdrawn;
        r = least;
    }
    const ChunkId id = chunk_of(s, c.which);
    r->watch = c.which;
    r->wanted = true;
    if (!offer_request(s, *r, id, 1, score)) return false; // cannot be: one chunk
    s.states[c.which] = WatchState::requested;
    if (!is_root(s, c.which)) ++s.below[slot_of(c.which)];
    ++s.reserved_slots;
    return true;
}

// The loaded page without pages below it that is wanted least, or none; `after`: those wanted more than it.
std::uint32_t least_loaded(const StreamState& s) {
    std::uint32_t least = none;
    int least_wants = 4;
    float least_px = never;
    for (std::uint32_t slot = 0; slot < s.slots; ++slot) {
        const std::uint32_t own = slot * watches_per_slot;
        if (s.states[own] != WatchState::loaded || s.below[slot] != 0) continue;
        const int wants = s.wants[own] & 1 ? 2 : s.wants[own] != 0 ? 1 : 0;
        if (wants > least_wants || (wants == least_wants && s.page_px[own] >= least_px)) continue;
        least = slot, least_wants = wants, least_px = s.page_px[own];
    }
    return least;
}

// Asks the cut to let go of the page in that slot.
void drain(StreamState& s, std::uint32_t slot) {
    const std::uint32_t watch = s.slot_watch[slot];
    record(s, watch, PageEvent::released);
    bool released = false; // drain_pages() asks again; the cut must be asked in the order that is recorded
    const ChunkId id = chunk_of(s, watch);
    if (s.cut.state) (void)release_page(s.cut, id.tile, id.item, released);
    s.states[slot * watches_per_slot] = s.states[watch] = WatchState::draining;
    s.draining[s.draining_count++] = slot;
    test(s, watch);
}

// A page makes room only for one that is wanted clearly more, or two would push each other out for ever.
bool gives_way(StreamState& s, std::uint32_t slot, const Candidate& to) {
    const std::uint32_t own = slot * watches_per_slot;
    test(s, own);
    const bool wanted = s.wants[own] & 1, more = s.wants[to.which] & 1;
    if (wanted != more) return more;
    if (!wanted && s.wants[own] == 0) return true;
    return s.page_px[to.which] > 1.25f * s.page_px[own];
}

void drain_pages(StreamState& s) {
    for (std::uint32_t i = 0; i < s.draining_count;) {
        const std::uint32_t slot = s.draining[i], watch = s.slot_watch[slot];
        const ChunkId id = chunk_of(s, watch);
        bool released = s.cut.state == nullptr;
        if ((s.wants[watch] & 1) && free_slots(s) != 0) { // after all
            if (s.cut.state) keep_page(s.cut, id.tile, id.item);
            record(s, watch, PageEvent::kept);
            s.states[slot * watches_per_slot] = s.states[watch] = WatchState::loaded;
            test(s, watch);
            s.due[watch] = never;
        } else {
            if (!released) (void)release_page(s.cut, id.tile, id.item, released);
            if (!released) {
                ++i;
                continue;
            }
            remove(s, slot);
        }
        s.draining[i] = s.draining[--s.draining_count];
    }
    s.report.pages_draining = s.draining_count;
}

} // namespace

void want_pages(StreamState& s) {
    review_requests(s);
    test_pages(s);
    Best best;
    gather(s, best);
    drain_pages(s);
    if (best.count <= free_slots(s)) s.contended = false;
    std::uint32_t making_room = s.draining_count;
    for (std::uint32_t i = 0; i < best.count; ++i) {
        const Candidate& c = best.at[i];
        if (free_slots(s) != 0) {
            if (ask(s, c)) continue;
            s.report.exhausted |= stream_requests;
            break;
        }
        if (making_room != 0) { // for this one
            --making_room;
            continue;
        }
        const std::uint32_t slot = s.draining_count < max_drains ? least_loaded(s) : none;
        if (slot != none) s.contended = s.wants[slot * watches_per_slot] != 0;
        if (slot != none && slot != (is_root(s, c.which) ? none : slot_of(c.which)) && gives_way(s, slot, c)) {
            drain(s, slot);
            continue;
        }
        if (s.wants[c.which] & 1) s.report.exhausted |= stream_page_slots;
        break;
    }
    drain_pages(s);
    s.terrain->missing_px = s.report.missing_px;
}

void forget_failed_pages(StreamState& s) {
    for (std::uint32_t i = 0; i < s.watch_count; ++i) {
        if (s.states[i] != WatchState::failed) continue;
        s.states[i] = WatchState::missing;
        s.due[i] = -1;
    }
}

} // namespace fjell
