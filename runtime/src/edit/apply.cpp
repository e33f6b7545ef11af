#include "edit/apply.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "edit/areas.h"
#include "edit/blocks.h"
#include "edit/errors.h"
#include "edit/locks.h"
#include "edit/radii.h"
#include "edit/refuse.h"
#include "shared/stamp.h"

namespace fjell::edit {

namespace {

// What a stamp makes of the samples of a piece, from the window into e.piece.
class Evaluation {
public:
    Evaluation(EditsData& e, const Stamp& stamp)
        : e_(e), t_(*e.terrain), grid_(t_), stamp_(stamp), samples_(samples_of(grid_, stamp)),
          base_m_(t_.height_scale.base_m), quantum_m_(t_.height_scale.quantum_m) {}

    // rect: of the piece and, where pieces after it are not evaluated, one row and column of theirs.
    [[nodiscard]] Change evaluate(const Rect& piece, const Rect& rect, const Rect& places) {
        return evaluate(piece, rect, places, [&](SampleIndex at, const Cell& now, bool& hole, Change& change) {
            return new_steps(at, now, hole, change);
        });
    }
    // make: the steps of a place, from those that it has now; hole: as it is, and it may make it another.
    template <typename Make>
    [[nodiscard]] Change evaluate(const Rect& piece, const Rect& rect, const Rect& places, const Make& make) {
        e_.piece.rect = rect;
        Change change;
        change.pieces = 1;
        for (std::int32_t y = rect.y0; y <= rect.y1; ++y) {
            const Cell* const now = &e_.window.at({rect.x0, y});
            std::int32_t* const to = &e_.piece.at({rect.x0, y});
            bool* const holes = &e_.piece.hole_at({rect.x0, y});
            for (std::int32_t k = 0; k < rect.columns(); ++k) {
                holes[k] = now[k].hole;
                to[k] = make(SampleIndex{rect.x0 + k, y}, now[k], holes[k], change);
            }
            if (y > piece.y1) continue;
            std::int32_t first = INT32_MAX, last = 0;
            for (std::int32_t k = 0; k <= piece.x1 - rect.x0; ++k) {
                const bool becomes = holes[k] != now[k].hole;
                if (to[k] == now[k].steps && !becomes) continue;
                first = std::min(first, k), last = k;
                change.holes = change.holes || becomes;
                if (becomes && !holes[k]) change.filled.add(to[k]);
                change.heights.add(to[k]), change.before.add(now[k].steps), change.off.add(to[k] - now[k].steps);
                ++change.samples;
            }
            if (first <= last) change.places = change.places.with({rect.x0 + first, y, rect.x0 + last, y});
        }
        if (change.samples != 0) look_at_steps(places, change);
        return change;
    }

private:
    [[nodiscard]] std::int32_t new_steps(SampleIndex at, const Cell& now, bool& hole, Change& change) {
        const SampleIndex sample = t_.tree.sample(at);
        const bool restores = stamp_.shape == StampShape::restore;
        if (!now.loaded || !samples_.contains(sample)) return now.steps;
        if (now.hole && !restores && !makes_or_fills_holes(stamp_.shape)) return now.steps;
        if (sample != at) { // it stands where the last one does, which comes before it in its row or column
            if (e_.piece.rect.contains(sample)) {
                hole = e_.piece.hole_at(sample);
                return e_.piece.at(sample);
            }
            const Cell last = cell_at(t_, sample);
            hole = last.hole;
            return last.steps;
        }
        Surroundings around{base_m_ + now.steps * quantum_m_, 0, 0};
        InPack pack{now.steps, now.hole};
        if (restores) {
            if (!find_in_pack(e_, sample, pack)) return now.steps;
            around.pack_m = base_m_ + pack.steps * quantum_m_;
        }
        if (restores || makes_or_fills_holes(stamp_.shape)) switch (hole_change(grid_, stamp_, sample)) {
            case HoleChange::none: break;
            case HoleChange::fill: hole = false; break;
            case HoleChange::cut: hole = true; break;
            case HoleChange::as_in_pack: hole = pack.hole; break;
            }
        if (stamp_.shape == StampShape::smooth) around.mean_m = base_m_ + mean_around(sample) * quantum_m_;
        const double new_m = stamped_m(grid_, stamp_, sample, around);
        if (std::isnan(new_m)) return now.steps;
        // What goes all the way back is the pack's own, whatever rounding says.
        if (restores && new_m == around.pack_m) return pack.steps;
        const double steps = std::floor((new_m - base_m_) / quantum_m_ + 0.5);
        if (std::abs(steps) < max_height_steps) return static_cast<std::int32_t>(steps);
        change.no_number = true;
        return now.steps;
    }
    [[nodiscard]] double mean_around(SampleIndex sample) const {
        const Rect near = Rect{sample.column - 1, sample.row - 1, sample.column + 1, sample.row + 1}.within(
            {0, 0, t_.tree.columns() - 1, t_.tree.rows() - 1});
        std::int64_t sum = 0;
        std::int32_t count = 0;
        for (std::int32_t y = near.y0; y <= near.y1; ++y)
            for (std::int32_t x = near.x0; x <= near.x1; ++x)
                if (const Cell cell = e_.window.at({x, y}); cell.loaded && !cell.hole) sum += cell.steps, ++count;
        return static_cast<double>(sum) / count;
    }
    // How steep the ground is, and how far neighbours move apart: along all edges of samples that change. Those to a
    // piece before this one were looked at with that.
    void look_at_steps(const Rect& places, Change& change) {
        const auto see = [&](std::int32_t a, std::int32_t old_a, std::int32_t b, std::int32_t old_b) {
            change.steepest = std::max(change.steepest, std::abs(a - b));
            change.bend = std::max(change.bend, std::abs((a - old_a) - (b - old_b)));
        };
        const Rect r = change.places.grown(1).within(e_.piece.rect);
        for (std::int32_t y = r.y0; y <= r.y1; ++y) {
            const std::int32_t* const to = &e_.piece.at({r.x0, y});
            const Cell* const now = &e_.window.at({r.x0, y});
            const bool has_below = y < r.y1;
            for (std::int32_t k = 0; k < r.columns(); ++k) {
                if (!now[k].loaded) continue;
                if (k + 1 < r.columns() && now[k + 1].loaded) see(to[k], now[k].steps, to[k + 1], now[k + 1].steps);
                if (has_below && now[k + window_side].loaded)
                    see(to[k], now[k].steps, to[k + largest_piece], now[k + window_side].steps);
            }
        }
        const auto see_beyond = [&](SampleIndex at, SampleIndex beyond) { // what no stamp changes
            if (places.contains(beyond) || !e_.window.rect.contains(beyond)) return;
            const Cell &now = e_.window.at(at), &other = e_.window.at(beyond);
            if (now.loaded && other.loaded) see(e_.piece.at(at), now.steps, other.steps, other.steps);
        };
        const Rect all = e_.piece.rect;
        for (std::int32_t x = all.x0; x <= all.x1; ++x)
            see_beyond({x, all.y0}, {x, all.y0 - 1}), see_beyond({x, all.y1}, {x, all.y1 + 1});
        for (std::int32_t y = all.y0; y <= all.y1; ++y)
            see_beyond({all.x0, y}, {all.x0 - 1, y}), see_beyond({all.x1, y}, {all.x1 + 1, y});
    }

    EditsData& e_;
    const TerrainData& t_;
    const StampGrid grid_;
    const Stamp& stamp_;
    Rect samples_;
    double base_m_, quantum_m_;
};

Rect piece_at(const Rect& places, std::uint32_t n) {
    if (places.columns() <= largest_piece && places.rows() <= largest_piece) return n == 0 ? places : Rect{};
    // Blocks lie in one of them.
    const std::int32_t x0 = places.x0 & -piece_side, y0 = places.y0 & -piece_side;
    const auto across = static_cast<std::uint32_t>((places.x1 - x0) / piece_side + 1);
    const std::int32_t x = x0 + static_cast<std::int32_t>(n % across) * piece_side,
                       y = y0 + static_cast<std::int32_t>(n / across) * piece_side;
    return Rect{x, y, x + piece_side - 1, y + piece_side - 1}.within(places);
}

// The next piece that a stamp may change; empty: there is none. n: its number, and then that of the one after it.
Rect next_piece(const TerrainData& t, const Waiting& w, std::uint32_t& n) {
    for (;;) {
        const Rect piece = piece_at(w.places, n++);
        if (piece.empty()) return piece;
        const SampleIndex first = t.tree.sample({piece.x0, piece.y0}), last = t.tree.sample({piece.x1, piece.y1});
        if (may_change(t, w.stamp, {first.column, first.row, last.column, last.row})) return piece;
    }
}

// Blocks that nobody has a claim to.
std::uint32_t free_blocks(const EditsData& e, const Moving* own) {
    std::uint32_t taken = e.block_count;
    for (std::uint32_t i = 0; i < e.moving_count; ++i)
        if (&e.moving[i] != own) taken += e.moving[i].blocks;
    return e.budget.blocks - std::min(taken, e.budget.blocks);
}

// unknown: it has to be looked at again. at_once: not piece by piece.
// own: the one that is on its way, if it is; null otherwise.
Refusal refusal_of(EditsData& e, const Change& change, const Moving* own, bool& unknown, bool& at_once) {
    unknown = at_once = false;
    if (change.no_number) return Refusal::number;
    if (change.samples == 0) return Refusal::none;
    if (change.blocks > free_blocks(e, own)) return Refusal::blocks;
    StepRange heights = change.heights;
    for (std::uint32_t i = 0; i < e.moving_count; ++i) heights.add(e.moving[i].heights); // they may share a page
    if (!spans_fit(e, change.places, heights, change.before)) return Refusal::span;
    const Fit fit = fits_codes(e, change, at_once);
    unknown = fit == Fit::unknown;
    return fit == Fit::no ? Refusal::bound : Refusal::none;
}

void widen(GroundRange& r, const HeightScale& scale, const StepRange& heights) {
    if (heights.low < r.low_steps) {
        store_release(r.low_steps, heights.low);
        store_release(r.low_m, std::min(r.low_m, scale.height_m(heights.low)));
    }
    if (heights.high > r.high_steps) {
        store_release(r.high_steps, heights.high);
        store_release(r.high_m, std::max(r.high_m, scale.height_m(heights.high)));
    }
}

// e.piece becomes the ground. The window reaches window_margin beyond it.
void apply(EditsData& e, const Change& change) {
    TerrainData& t = *e.terrain;
    const Rect& places = change.places;
    const float by_m = static_cast<float>(change.off.span()) * t.header.quantum_m;
    if (by_m > t.editing_m) store_release(t.editing_m, by_m);
    store_release(t.ground_epoch, t.ground_epoch + 1);
    fence_release();
    for (std::int32_t y = places.y0; y <= places.y1; ++y) {
        Cell* const cells = &e.window.at({places.x0, y});
        const std::int32_t* const to = &e.piece.at({places.x0, y});
        const bool* const holes = &e.piece.hole_at({places.x0, y});
        if (y < t.tree.rows())
            remember(e, {places.x0, y}, std::min(places.x1 + 1, t.tree.columns()) - places.x0, cells, {to, holes});
        for (std::int32_t k = 0; k < places.columns(); ++k) cells[k].steps = to[k], cells[k].hole = holes[k];
    }
    if (change.holes) look_for_holes(t, e.window);
    for (int z = 0; z < t.tree.tile_log2; ++z) e.window.note(z, places);
    widen(t.range, t.height_scale, change.heights);
    const Ground ground(t, &e.window);
    const bool radii_known = nest_radii(e, ground, places, static_cast<double>(by_m));
    const int loose_z = raise_errors(e, ground, change);
    write_back(t, e.window, change.heights);
    fence_release();
    store_release(t.ground_epoch, t.ground_epoch + 1);
    push_change(e, places, heights_changed, change.holes);
    if (!radii_known || loose_z < t.tree.tile_log2) push_area(e, places, loose_z, radii_known ? no_radii : 0);
}

} // namespace

bool is_held(const EditsData& e, Waiting& w) {
    const TerrainData& t = *e.terrain;
    if (!moves_ground(w.stamp.shape)) return w.lacks_pages = false;
    if (w.page_changes != t.changes) { // not at every item: under a large stamp lie many pages
        w.page_changes = t.changes;
        w.lacks_pages = false;
        for_each_plane(0, t.tree.tile_log2 - 1, [&](const Plane& plane) {
            for_each_page(t, plane, plane.squares(w.places.grown(1)), [&](std::uint32_t page) {
                w.lacks_pages = w.lacks_pages || t.page_table[page].slot == no_index;
            });
        });
    }
    return w.lacks_pages || (w.wants_rest && !is_at_rest(e, w.places));
}

bool awaits_pages(const EditsData& e, const Rect& places, int step_log2) {
    if (e.awaiting_count == 0) return false;
    const TerrainData& t = *e.terrain;
    // One that waits until all is measured around it needs what is_at_rest() asks for, and what areas there have
    // lacked.
    const auto lacked = [&](const Area& area) {
        for (std::uint32_t i = 0; i < area.missing.count; ++i) {
            const SampleIndex v = area.missing.at[i];
            if (Tree::step_log2(v) <= step_log2 && places.contains(v)) return true; // pages above come first
        }
        return false;
    };
    const auto awaits = [&](const Waiting& w) {
        if (!w.awaits) return false;
        if (w.places.grown(1).meets(places)) return true;
        if (!w.wants_rest) return false;
        if (w.places.grown(error_reach(VertexKind::centre) << step_log2).meets(places)) return true;
        return std::any_of(e.areas, e.areas + e.area_count, [&](const Area& area) {
            return area.places.grown(2 * t.tree.side()).meets(w.places) && lacked(area);
        });
    };
    return std::any_of(e.waiting, e.waiting + e.waiting_count, awaits) ||
           std::any_of(e.moving, e.moving + e.moving_count, [&](const Moving& m) { return awaits(m.stamp); });
}

namespace {

// From the window to e.piece, which has been looked at. Its pages are awaited until it has come.
void begin_move(EditsData& e, Waiting& w, const Change& change, double now_s) {
    w.moves = true;
    if (!std::exchange(w.awaits, true)) ++e.awaiting_count, ++e.awaits_changes;
    Moving& m = e.moving[e.moving_count++];
    m.stamp = w;
    m.begun_s = now_s, m.share = 0;
    m.rect = e.piece.rect;
    m.heights = change.heights;
    m.heights.add(change.before);
    m.blocks = change.blocks;
    for (std::int32_t y = m.rect.y0; y <= m.rect.y1; ++y)
        for (std::int32_t x = m.rect.x0; x <= m.rect.x1; ++x) {
            const std::size_t at = e.piece.index({x, y});
            m.from[at] = e.window.at({x, y}).steps, m.to[at] = e.piece.at({x, y});
        }
}

} // namespace

bool move_on(EditsData& e, Moving& m, double now_s, Refusal& refusal, std::uint32_t& samples) {
    refusal = Refusal::none;
    if (is_held(e, m.stamp)) return false;
    const double share = std::clamp((now_s - m.begun_s) / static_cast<double>(m.stamp.stamp.morph_s), m.share, 1.0);
    read(*e.terrain, m.rect.grown(window_margin), e.window);
    Change change =
        Evaluation(e, m.stamp.stamp)
            .evaluate(m.rect, m.rect, m.rect, [&](SampleIndex place, const Cell& now, bool&, Change&) {
                const std::size_t at = e.piece.index(place);
                if (!now.loaded || m.from[at] == m.to[at]) return now.steps;
                return m.from[at] + static_cast<std::int32_t>(std::floor((m.to[at] - m.from[at]) * share + 0.5));
            });
    if (change.samples != 0) {
        change.blocks = missing_blocks(e, change.places);
        bool unknown = false, at_once = false;
        refusal = refusal_of(e, change, &m, unknown, at_once);
        if (refusal != Refusal::none || unknown) { // others have come beside it: again when all is measured
            const bool wanted = m.stamp.wants_rest;
            const bool never = share == 1 && !unknown && std::exchange(m.stamp.wants_rest, true);
            if (m.stamp.wants_rest != wanted) ++e.awaits_changes;
            if (!never) refusal = Refusal::none;
            return never;
        }
        m.blocks -= std::min(m.blocks, change.blocks);
        apply(e, change);
    }
    m.stamp.wants_rest = false;
    m.share = share;
    samples += change.samples;
    return share == 1;
}

bool apply_piece(EditsData& e, Waiting& w, double now_s, Refusal& refusal, std::uint32_t& samples) {
    refusal = Refusal::none;
    const auto look_again = [&] { // when it is held no longer
        if (!std::exchange(w.wants_rest, true)) ++e.awaits_changes;
        w.piece = 0;
        w.change = {};
        return false;
    };
    const bool is_only = piece_at(w.places, 1).empty();
    bool unknown = false, is_last = false;
    do {
        const Rect piece = next_piece(*e.terrain, w, w.piece);
        if (piece.empty()) return true;
        std::uint32_t after = w.piece;
        is_last = next_piece(*e.terrain, w, after).empty();
        const bool applies = w.fits || is_only;
        read(*e.terrain, piece.grown(applies ? window_margin : 2), e.window);
        const Rect rect = Rect{piece.x0, piece.y0, piece.x1 + !applies, piece.y1 + !applies}.within(w.places);
        Change change = Evaluation(e, w.stamp).evaluate(piece, rect, w.places);
        if (!w.fits) {
            if (change.samples != 0) change.blocks = missing_blocks(e, change.places);
            w.change.add(change);
            if (is_only) refusal = refusal_of(e, w.change, nullptr, unknown, w.at_once);
            if (unknown) return look_again();
            if (refusal != Refusal::none) return true;
            if (is_only && w.stamp.morph_s > 0 && change.samples != 0 && !change.holes &&
                e.moving_count < e.budget.moving) {
                begin_move(e, w, change, now_s);
                return true;
            }
        }
        if (!applies) break;
        if (change.samples != 0) apply(e, change);
        samples += change.samples;
        if (is_last) return true;
    } while (w.at_once);
    if (w.fits || !is_last) return false;
    refusal = refusal_of(e, w.change, nullptr, unknown, w.at_once); // all have been looked at
    if (unknown) return look_again();
    w.fits = true;
    w.piece = 0;
    return refusal != Refusal::none || w.change.samples == 0;
}

bool lock_piece(EditsData& e, Waiting& w, Refusal& refusal) {
    TerrainData& t = *e.terrain;
    refusal = !w.fits && !has_room_for(e, w.stamp) ? Refusal::locks : Refusal::none;
    if (refusal != Refusal::none) return true;
    w.fits = true;
    const Rect piece = next_piece(t, w, w.piece);
    if (piece.empty()) return true;
    const Rect samples = piece.within({0, 0, t.tree.columns() - 1, t.tree.rows() - 1});
    Change change;
    change.places = samples.empty() ? samples : lock_samples(e, w.stamp, samples);
    if (change.places.empty()) return false;
    read(t, change.places.grown(window_margin), e.window);
    const int loose_z = raise_errors(e, Ground(t, &e.window), change);
    write_back(t, e.window, {});
    push_change(e, change.places, errors_changed);
    if (loose_z < t.tree.tile_log2) push_area(e, change.places, loose_z, no_radii);
    return false;
}

} // namespace fjell::edit
