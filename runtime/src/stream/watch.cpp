// Which pages the views want, without looking at their vertices.
//
// A vertex is wanted while the eye is nearer than radius + error q (view/wanted.h). Of a page the directory knows the
// largest of both and how high its ground is, so one distance to a box rules out a page none of whose vertices can be
// wanted. Bounds do not have to nest: a page is watched only when the one above it is loaded, and a wanted
// vertex' ancestors are wanted, one of them in every page above (a page's bound counts its borders too). So when no
// watched page is wanted and missing, no vertex is.
//
// The largest threshold at which a missing page would still be wanted, its px, is therefore what the mesh guarantees
// meanwhile: every page wanted at a higher one is there. That is how page slots answer to the governor: instead of a
// threshold that is raised until pages suffice, the worst page without a slot says which one they suffice for.
#include "stream/watch.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "edit/apply.h"
#include "edit/blocks.h"
#include "edit/locks.h"

namespace fjell {

namespace {

constexpr double grow = 1 + 0x1p-16; // more than all roundings of wanted() together
constexpr double sooner = 0.95;      // share of the threshold at which a page will be wanted soon

// A page's own places, and the distance between its vertices.
struct PagePlaces {
    edit::Rect rect;
    std::int32_t step;
};
PagePlaces places_of(const TerrainData& t, std::uint32_t tile, std::uint32_t page) {
    const SampleIndex place = t.tile_xy(tile);
    SampleIndex first{place.column * t.tree.side(), place.row * t.tree.side()};
    std::int32_t cells = t.tree.side(), step = cells;
    if (const int z = t.pages.page_step_log2(page); z >= 0) {
        const SampleIndex position = t.pages.page_position(page);
        cells = static_cast<std::int32_t>(2 * page_squares) << z;
        step = 1 << z;
        first = {first.column + position.column * cells, first.row + position.row * cells};
    }
    return {{first.column, first.row, first.column + cells, first.row + cells}, step};
}

// Places whose ground a page's vertices may depend on.
edit::Rect places_around(const TerrainData& t, std::uint32_t tile, std::uint32_t page) {
    const PagePlaces own = places_of(t, tile, page);
    return own.rect.grown(edit::radius_reach * own.step);
}

Watch box_of(const StreamState& s, std::uint32_t tile, std::uint32_t page) {
    const TerrainData& t = *s.terrain;
    const PageBound bound = s.pack->entry(chunk_index(t.header, {ChunkKind::geometry, tile, page})).bound;
    // What was edited may stand, hide and reach farther; and the rim of a hole is drawn to within its triangles' size.
    const auto by_m =
        t.edits != nullptr ? static_cast<float>(edit::growth_m(*t.edits, places_around(t, tile, page))) : 0.0f;
    const PagePlaces places = places_of(t, tile, page);
    const edit::Rect own = places.rect;
    const SampleIndex a = t.tree.sample({own.x0, own.y0}), b = t.tree.sample({own.x1, own.y1});
    const bool has_rim = t.edits != nullptr && edit::has_changed_holes(*t.edits, own.grown(places.step));
    const double climb_m = static_cast<double>(t.range.high_m) - static_cast<double>(t.range.low_m);
    const double side = 2.0 * places.step;
    const auto rim_m = static_cast<float>(
        has_rim ? std::hypot(side * t.header.spacing_m[0], side * t.header.spacing_m[1], climb_m) * grow : 0.0);
    // Where a lock asks for a page, it does from afar.
    const int level = bound_level(t.pages, page);
    const std::uint32_t most = t.errors.code_up(static_cast<double>(t.errors.metres[bound.error] + by_m));
    const float lock_m =
        t.edits != nullptr &&
                most > edit::least_allowed(*t.edits, own.grown(edit::error_reach(VertexKind::centre) * places.step))
            ? t.errors.metres[t.errors.always(level)]
            : 0.0f;
    const std::uint32_t shift = bound_shift(t.header);
    const auto height = [&](std::uint32_t steps) { return t.height_scale.height_m(static_cast<std::int32_t>(steps)); };
    return {t.x_m(a.column),
            t.x_m(b.column),
            height(std::uint32_t{bound.low} << shift) - by_m,
            height(((std::uint32_t{bound.high} + 1) << shift) - 1) + by_m,
            t.z_m(a.row),
            t.z_m(b.row),
            std::max({t.errors.metres[bound.error] + by_m, rim_m, lock_m}),
            t.header.level_radius_m[level] * t.radii.factor[bound.radius] +
                by_m * static_cast<float>(2 * max_tile_log2 + 1)};
}

} // namespace

void watch_page(StreamState& s, std::uint32_t watch, std::uint32_t tile, std::uint32_t page, WatchState state) {
    s.watches[watch] = box_of(s, tile, page);
    s.watch_page[watch] = tile * s.terrain->pages_per_tile + page;
    s.states[watch] = state;
    s.due[watch] = -1;
    s.wants[watch] = 0;
    s.page_px[watch] = 0;
}

void follow_ground(StreamState& s) {
    const TerrainData& t = *s.terrain;
    if (const std::uint64_t awaits = t.edits != nullptr ? t.edits->awaits_changes : 0; s.seen_awaits != awaits) {
        s.seen_awaits = awaits;
        for (std::uint32_t i = 0; i < s.watch_count; ++i)
            if (s.due[i] < never) s.due[i] = -1;
        s.tested = false;
    }
    if (s.seen_ground == t.ground_changes) return;
    const bool all = t.changed_ground == nullptr || t.ground_changes - s.seen_ground > ground_change_log;
    for (std::uint32_t watch = 0; watch < s.watch_count; ++watch) {
        if (s.states[watch] == WatchState::idle) continue;
        const std::uint32_t tile = s.watch_page[watch] / t.pages_per_tile,
                            page = s.watch_page[watch] % t.pages_per_tile;
        const edit::Rect places = places_around(t, tile, page);
        bool near = all;
        for (std::uint64_t n = s.seen_ground; n < t.ground_changes && !near; ++n) {
            const GroundChange& c = t.changed_ground[n % ground_change_log];
            near = c.step_log2 < 0 && places.meets({c.first.column, c.first.row, c.last.column, c.last.row});
        }
        if (!near) continue;
        s.watches[watch] = box_of(s, tile, page);
        test(s, watch);
    }
    s.seen_ground = t.ground_changes;
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

namespace {

// By a stamp. A square of a page may reach a step beyond it.
bool is_awaited(const StreamState& s, std::uint32_t watch) {
    const TerrainData& t = *s.terrain;
    if (t.edits == nullptr || t.edits->awaiting_count == 0) return false;
    const PagePlaces own = places_of(t, s.watch_page[watch] / t.pages_per_tile, s.watch_page[watch] % t.pages_per_tile);
    const bool whole_tile = own.step == t.tree.side();
    return edit::awaits_pages(*t.edits, own.rect.grown(whole_tile ? 2 : 2 * own.step),
                              whole_tile ? t.tree.tile_log2 - 1
                                         : std::countr_zero(static_cast<std::uint32_t>(own.step)));
}

} // namespace

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
        const double apart = distance_m(w, {eye.x, eye.y, eye.z}) - w.radius_m * grow - pad,
                     reach = w.error_m * grow * eye.focal_length_px;
        const double px = apart > 0 ? std::min(reach / apart, most_px) : most_px;
        if (px > threshold) wants |= eye.predicted ? 2 : 1;
        most = std::max(most, px);
        slack_m = std::min(slack_m, std::abs(apart - reach / threshold));
    }
    if (is_root(s, watch) || is_awaited(s, watch)) wants |= 1;
    s.wants[watch] = wants;
    s.page_px[watch] = static_cast<float>(most);
    s.due[watch] = static_cast<float>(std::min((s.odometer_m + slack_m * 0.999) * (1 - 0x1p-22), double{never} / 2));
    const WatchState state = s.states[watch];
    set_missing(s, watch, wants != 0 && state != WatchState::loaded && state != WatchState::idle);
}

// What brings a request forward: how much worse than the threshold it is, that a frustum may show it, and that it is
// wanted now and not only soon. The coarsest pages come first: without them there is nothing to draw.
float score_if_seen(const StreamState& s, std::uint32_t watch) {
    const float ratio = static_cast<float>(s.page_px[watch] / s.threshold_px);
    return 8 * ratio * (s.wants[watch] & 1 ? 1.0f : 0.1f);
}

float score_of(const StreamState& s, std::uint32_t watch) {
    const float seen = score_if_seen(s, watch);
    return (is_root(s, watch) ? 1e9f : 0.0f) + (may_be_seen(s, s.watches[watch]) ? seen : seen / 8);
}

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

void set_views(StreamState& s, std::span<const View> views, const CutSettings& cut, double effective_px) {
    const double nested = 1 + static_cast<double>(s.terrain->header.nesting);
    const double early = cut.morph == Morph::none ? 1 : nested * nested;
    // Below most_px, or nothing would be wanted at any threshold.
    const double threshold_px = std::min(std::max(cut.max_error_px, effective_px), most_px / 2);
    const double seconds = s.settings.now_s - s.now_s;
    const std::uint32_t kinds = s.settings.lookahead_s > 0 ? 2 : 1;
    const auto count = static_cast<std::uint32_t>(views.size());
    bool all = threshold_px != s.threshold_px || count != s.view_count || s.eye_count != count * kinds;
    double way_m = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3 eye = views[i].eye_m;
        if (i >= s.view_count) s.last_eye[i] = eye, s.last_speed[i] = s.speed[i] = {};
        // A view with its own threshold is one that magnifies as much more as its threshold is lower.
        const double own = cut.max_error_px / view_max_error_px(views[i], cut.max_error_px);
        const double lambda = focal_length_px(views[i]) * early * (cut.corner_safe ? corner_factor(views[i]) : 1) * own;
        for (std::uint32_t kind = 0; kind < kinds; ++kind) {
            const Vec3 at = kind == 0 ? eye : ahead(s, i, eye, seconds);
            WantedEye& e = s.eyes[i * kinds + kind];
            all = all || e.focal_length_px != lambda;
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
    if (!all && s.odometer_m < 1e6 * static_cast<double>(std::min(s.terrain->spacing_x_m, s.terrain->spacing_z_m)))
        return;
    s.odometer_m = 0;
    for (std::uint32_t i = 0; i < s.watch_count; ++i)
        if (s.due[i] < never) s.due[i] = -1;
    s.tested = false; // from where the last tests ended: what changes with every frame must not start again with each
}

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

} // namespace fjell
