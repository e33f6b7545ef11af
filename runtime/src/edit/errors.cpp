#include "edit/errors.h"

#include "edit/locks.h"

#include "edit/small_diamonds.h"
#include "shared/diamond_error.h"

namespace fjell::edit {

namespace {

DiamondTerms terms_of(const EditsData& e) {
    const TerrainData& t = *e.terrain;
    return {t.errors,
            static_cast<double>(t.header.quantum_m),
            {t.header.spacing_m[0], t.header.spacing_m[1]},
            e.radius.ground_pad_m,
            e.radius.height_pad_m,
            t.header.estimate == ErrorEstimate::midpoint};
}

// The largest vertical difference between a triangle and the ground under it. The tree itself says where to look: below
// a triangle that the tree splits, nothing is farther from its plane than its splitting vertex' error; so most of it
// need not be looked at (branch and bound). In units of 1 / 2s steps, whole numbers.
class Search {
public:
    // jumps: the error is the surface's jump at the vertex, and what is here counts at a hole's rim alone.
    Search(const EditsData& e, const Ground& ground, SampleIndex v, std::uint32_t least, const LockAt& lock, bool jumps)
        : t_(ground.terrain), ground_(ground), terms_(terms_of(e)), lock_(lock), s_(1 << Tree::step_log2(v)),
          unit_m_(0.5 * static_cast<double>(t_.header.quantum_m) / s_), holes_(t_.has_voids()), jumps_(jumps),
          side_m_(e.radius.side_edge_m), centre_m_(e.radius.centre_edge_m) {
        raise(least);
    }
    // split: the vertex that splits it, whose own error is not known.
    void triangle(SampleIndex apex, const SampleIndex (&ends)[2], SampleIndex split) {
        const Cell a = ground_.at(apex), b = ground_.at(ends[0]), c = ground_.at(ends[1]);
        if (!a.loaded || !b.loaded || !c.loaded) { // it may be anything
            raise(255);
            exact_ = false;
            return;
        }
        kinds_ = none;
        if (holes_) {
            for (const Cell& corner : {a, b, c}) see_kind(corner.hole);
            look(apex, ends[0], ends[1], split, 255);
            all_kinds_ |= kinds_;
            if (kinds_ == hole) return;
            if (kinds_ == both) see(longest_edge_m(apex, ends)), rim_ = true;
            if (jumps_ && kinds_ != both) return;
        }
        // The plane: 2s h = origin + gx x + gy y, from the apex. Its legs are along axes or diagonals.
        const std::int64_t bx = ends[0].column - apex.column, by = ends[0].row - apex.row,
                           cx = ends[1].column - apex.column, cy = ends[1].row - apex.row;
        const std::int64_t area = bx * cy - by * cx, hb = b.steps - a.steps, hc = c.steps - a.steps;
        const std::int64_t two_s = 2 * std::int64_t{s_};
        gx_ = two_s * (hb * cy - hc * by) / area;
        gy_ = two_s * (hc * bx - hb * cx) / area;
        at_ = apex;
        origin_ = two_s * a.steps;
        descend({apex, 0}, {ends[0], 0}, {ends[1], 0}, split, ground_.at(split).steps, 255);
    }
    [[nodiscard]] std::uint32_t code() const { return code_; }
    [[nodiscard]] bool exact() const { return exact_; }
    // Is there ground under any of the triangles; and has one of them a hole under it as well?
    [[nodiscard]] bool has_ground() const { return !holes_ || (all_kinds_ & land) != 0; }
    [[nodiscard]] bool has_rim() const { return rim_; }

private:
    // What has been seen under a triangle.
    static constexpr std::uint32_t none = 0, land = 1, hole = 2, both = 3;
    void see_kind(bool is_hole) { kinds_ |= is_hole ? hole : land; }
    // Is there ground as well as a hole? An error is the longest edge at least where there is: so below a triangle that
    // is split by a vertex with a smaller error all is of one kind, and need not be looked at.
    void look(SampleIndex right, SampleIndex one, SampleIndex other, SampleIndex m, std::uint32_t code) {
        const Cell cell = ground_.at(m);
        if (cell.loaded) see_kind(cell.hole);
        if (kinds_ == both || t_.errors.metres[code] < shortest_m(m)) return;
        if (!cell.loaded) { // whatever it is
            exact_ = false;
            kinds_ = both;
            return;
        }
        look_below(m, right, one, code);
        if (kinds_ != both) look_below(m, other, right, code);
    }
    void look_below(SampleIndex right, SampleIndex one, SampleIndex other, std::uint32_t parent) {
        const SampleIndex sum = one + other;
        if (((sum.column | sum.row) & 1) != 0) return;
        const SampleIndex m{sum.column / 2, sum.row / 2};
        const Cell cell = ground_.at(m);
        const std::uint32_t nested = parent > t_.errors.nesting_steps ? parent - t_.errors.nesting_steps : 0;
        look(right, one, other, m, cell.loaded ? cell.error : nested);
    }
    // The longest edge of its triangles, as the crow flies along the ground: no more than that.
    [[nodiscard]] float shortest_m(SampleIndex m) const {
        const auto step = static_cast<float>(1 << Tree::step_log2(m));
        return step * (Tree::kind(m) == VertexKind::centre ? centre_m_ : side_m_);
    }
    [[nodiscard]] double longest_edge_m(SampleIndex apex, const SampleIndex (&ends)[2]) const {
        return diamonds::longest_edge_m(ground_, terms_, apex, ends[0], ends[1]);
    }
    struct Corner {
        SampleIndex at;
        std::int64_t off; // |2s (h - plane)|
    };
    void raise(std::uint32_t code) {
        code_ = std::min(lock_.raised(code), 255u); // so that it need not be known how much more than allowed it is
        enough_m_ = static_cast<double>(t_.errors.metres[code_]);
    }
    void see(double off_m) {
        if (off_m > enough_m_) raise(t_.errors.code_up(off_m));
    }
    [[nodiscard]] std::int64_t off(SampleIndex v, std::int32_t steps) const {
        const std::int64_t plane = origin_ + gx_ * (v.column - at_.column) + gy_ * (v.row - at_.row);
        const std::int64_t d = 2 * std::int64_t{s_} * steps - plane;
        return d < 0 ? -d : d;
    }
    // What lies under a triangle is within this of its plane, if what splits it has such an error.
    [[nodiscard]] double within_m(const Corner& a, const Corner& b, const Corner& c, std::uint32_t code) const {
        return static_cast<double>(std::max({a.off, b.off, c.off})) * unit_m_ +
               static_cast<double>(t_.errors.metres[code]);
    }
    // The triangle with its right angle at a and its hypotenuse from b to c; m splits it, a vertex with this code.
    void descend(const Corner& a, const Corner& b, const Corner& c, SampleIndex m, std::int32_t steps,
                 std::uint32_t code) {
        if (within_m(a, b, c, code) * (1 - 0x1p-40) <= enough_m_) return;
        const Corner middle{m, off(m, steps)};
        if (!holes_ || !ground_.at(m).hole) see(static_cast<double>(middle.off) * unit_m_);
        below(middle, a, b, code);
        below(middle, c, a, code);
    }
    // parent: code of the vertex at the right angle.
    void below(const Corner& right, const Corner& one, const Corner& other, std::uint32_t parent) {
        const SampleIndex sum = one.at + other.at;
        if (((sum.column | sum.row) & 1) != 0) return; // of the full resolution: nothing lies under it
        const SampleIndex m{sum.column / 2, sum.row / 2};
        const Cell cell = ground_.at(m);
        if (cell.loaded) return descend(right, one, other, m, cell.steps, cell.error);
        // Its error nests in its parent's.
        const double most_m =
            within_m(right, one, other, parent > t_.errors.nesting_steps ? parent - t_.errors.nesting_steps : 0);
        if (most_m <= enough_m_) return;
        raise(t_.errors.code_up(most_m));
        exact_ = false;
    }

    const TerrainData& t_;
    const Ground& ground_;
    const DiamondTerms terms_;
    const LockAt lock_;
    std::int32_t s_;
    double unit_m_, enough_m_ = 0;
    std::uint32_t code_ = 0;
    bool exact_ = true;
    std::int64_t gx_ = 0, gy_ = 0, origin_ = 0;
    SampleIndex at_{};
    const bool holes_, jumps_;
    const float side_m_, centre_m_;
    std::uint32_t kinds_ = none, all_kinds_ = none;
    bool rim_ = false;
};

// Diamonds up to this step (its log2) are looked at sample by sample where they must be: at the rim, and for midpoint
// errors at that of a hole.
constexpr int looked_through = 8;

Measured scan(const EditsData& e, const Ground& ground, SampleIndex v) {
    const TerrainData& t = ground.terrain;
    const std::int32_t s = 1 << Tree::step_log2(v);
    const Measured as_it_is{ground.at(v).error, false};
    if (Tree::step_log2(v) > looked_through) return as_it_is;
    const Rect under = Rect{v.column - s, v.row - s, v.column + s, v.row + s}.within(grid_of(t.tree));
    for (std::int32_t y = under.y0; y <= under.y1; ++y)
        for (std::int32_t x = under.x0; x <= under.x1; ++x)
            if (!ground.at({x, y}).loaded) return as_it_is;
    return {diamond_error(ground, terms_of(e), v, [&](SampleIndex apex) { return t.tree.contains(apex); }).code, true};
}

// Of the ground under its triangles alone. least: a smaller code is not told from this one. One above what locks allow
// may be raised already.
Measured measure_ground(const EditsData& e, const Ground& ground, SampleIndex v, std::uint32_t least,
                        const LockAt& lock) {
    const TerrainData& t = ground.terrain;
    if (straddles_rim(t.tree, v)) return scan(e, ground, v);
    const Diamond d = diamond(t.tree, v);
    const auto search_all = [&](Search& search) {
        for (const SampleIndex apex : d.apexes)
            if (t.tree.contains(apex)) search.triangle(apex, d.ends, v);
    };
    if (Tree::step_log2(v) == 0 || t.header.estimate == ErrorEstimate::midpoint) {
        const Cell own = ground.at(v), a = ground.at(d.ends[0]), b = ground.at(d.ends[1]);
        if (!a.loaded || !b.loaded || !own.loaded) return {255, false};
        const std::int64_t jump = std::abs(2 * std::int64_t{own.steps} - a.steps - b.steps);
        const Measured at_vertex{t.memory->leaf.code(static_cast<std::uint32_t>(jump)), true};
        if (!t.has_voids()) return at_vertex;
        Search search(e, ground, v, at_vertex.code, lock, true);
        search_all(search);
        if (!search.has_ground() && search.exact()) return {0, true};
        // Midpoint errors below say nothing of the samples that a rim's triangles are off by.
        if (search.has_rim() && Tree::step_log2(v) != 0) return scan(e, ground, v);
        return {search.code(), search.exact()};
    }
    Search search(e, ground, v, least, lock, false);
    search_all(search);
    return {search.code(), search.exact()};
}

// Errors of the vertices of one plane whose diamonds lie in a window that is complete.
class MeasuredPlane {
public:
    MeasuredPlane(const Ground& ground, const Plane& plane, const WindowLocks& locks)
        : t_(ground.terrain), window_(*ground.window()), plane_(plane), locks_(locks) {}
    // Squares of those of a rectangle that can be measured so.
    [[nodiscard]] static Rect measurable(const Ground& ground, const Plane& plane, const Rect& squares) {
        const TerrainData& t = ground.terrain;
        const Window* const w = ground.window();
        if (w == nullptr || !w->complete || plane.z > measured_at_once) return {};
        if (plane.z != 0 && t.header.estimate == ErrorEstimate::midpoint) return {};
        Rect inside = w->rect.grown(-(1 << plane.z));
        // At a rim inside a tile triangles are squeezed.
        if (t.tree.cut_x != 0) inside.x1 = std::min(inside.x1, t.tree.columns() - 1 - (1 << plane.z));
        if (t.tree.cut_y != 0) inside.y1 = std::min(inside.y1, t.tree.rows() - 1 - (1 << plane.z));
        return inside.empty() ? Rect{} : plane.squares(inside).within(squares);
    }
    // Returns the squares whose codes have changed. most: grows to the largest code.
    [[nodiscard]] Rect measure(const Rect& squares, std::uint32_t& most) const {
        Rect changed;
        for (std::int32_t j = squares.y0; j <= squares.y1; ++j)
            for (std::int32_t i = squares.x0; i <= squares.x1; i += diamond_lanes) {
                std::uint8_t codes[diamond_lanes];
                const std::int32_t count = std::min(diamond_lanes, squares.x1 - i + 1);
                ground_codes(i, j, count, codes);
                Cell* const first = &window_.at(plane_.at(i, j));
                if (locks_.any()) raise_locked(i, j, count, codes);
                for (std::int32_t k = 0; k < count; ++k) {
                    Cell& own = first[static_cast<std::ptrdiff_t>(k) << (plane_.z + 1)];
                    const std::uint32_t code = std::max<std::uint32_t>(codes[k], asked_of(own));
                    if (code == own.error) continue;
                    own.error = static_cast<std::uint8_t>(code);
                    most = std::max(most, code);
                    changed = changed.with({i + k, j, i + k, j});
                }
            }
        return changed;
    }

private:
    void ground_codes(std::int32_t i, std::int32_t j, std::int32_t count, std::uint8_t* codes) const {
        const SampleIndex v = plane_.at(i, j);
        const Cell* const first = &window_.at(v);
        const bool centre = plane_.kind == VertexKind::centre;
        const bool alternates = centre && plane_.z != t_.tree.tile_log2 - 1,
                   first_from_sw = centre && diamond(t_.tree, v).ends[0].row > v.row;
        if (plane_.z == 0) {
            for (std::int32_t k = 0; k < count; ++k) {
                const Cell* const own = first + 2 * k;
                const bool from_sw = first_from_sw != (alternates && (k & 1) != 0);
                const std::ptrdiff_t end =
                    !centre ? (plane_.kind == VertexKind::side_x ? 1 : window_side) : window_side + (from_sw ? -1 : 1);
                const std::int64_t jump =
                    2 * std::int64_t{own->steps} - std::int64_t{own[-end].steps} - std::int64_t{own[end].steps};
                codes[k] = t_.memory->leaf.code(static_cast<std::uint32_t>(std::abs(jump)));
            }
            return;
        }
        std::int32_t worst[diamond_lanes];
        worst_under({first, plane_.z, plane_.kind, count, first_from_sw, alternates}, worst);
        const double unit_m = 0.5 * static_cast<double>(t_.header.quantum_m) / (1 << plane_.z);
        for (std::int32_t k = 0; k < count; ++k) codes[k] = t_.errors.code_up(unit_m * worst[k]);
    }
    void raise_locked(std::int32_t i, std::int32_t j, std::int32_t count, std::uint8_t* codes) const {
        const std::uint32_t always = t_.errors.always(t_.tree.level(plane_.at(i, j)));
        for (std::int32_t k = 0; k < count; ++k)
            codes[k] = static_cast<std::uint8_t>(locks_.at(plane_.at(i + k, j), always).raised(codes[k]));
    }
    [[nodiscard]] std::uint32_t asked_of(const Cell& vertex) const {
        const bool centre = plane_.kind == VertexKind::centre;
        if (!centre && plane_.z == 0) return 0;
        const Cell* const own = &vertex;
        const std::ptrdiff_t h = std::ptrdiff_t{1} << (centre ? plane_.z : plane_.z - 1), across = centre ? 0 : h;
        const std::ptrdiff_t a = h + across * window_side, b = h * window_side - across;
        const std::uint32_t most = std::max({own[a].error, own[-a].error, own[b].error, own[-b].error});
        return std::min(t_.errors.above(most), 255u);
    }
    const TerrainData& t_;
    Window& window_;
    Plane plane_;
    const WindowLocks& locks_;
};

} // namespace

Asked asked_by_children(const Ground& ground, SampleIndex v) {
    const Children below = children(v);
    Asked asked{0, true};
    for (int k = 0; k < below.count; ++k) {
        if (!ground.tree.contains(below.at[k])) continue;
        const Cell child = ground.at(below.at[k]);
        if (child.loaded)
            asked.code = std::max<std::uint32_t>(asked.code, ground.terrain.errors.above(child.error));
        else
            asked.all = false;
    }
    asked.code = std::min(asked.code, 255u);
    return asked;
}

Measured measure(const EditsData& e, const Ground& ground, SampleIndex v, const Asked& asked) {
    if (!asked.all) return {std::max<std::uint32_t>(ground.at(v).error, asked.code), false};
    const LockAt lock = lock_at(e, v);
    // Where children ask for what locks do, or more, it does not matter which they are.
    Measured own =
        measure_ground(e, ground, v, lock.always > asked.code ? std::min(asked.code, lock.allowed) : asked.code, lock);
    own.code = std::max(lock.raised(own.code), asked.code);
    return own;
}

// As diamonds::longest_edge_m() of the same way.
double rim_m(const PackHeader& header, const Pads& pads, int z, double climb_m) {
    const double side = 2.0 * (1 << z), dx = side * header.spacing_m[0], dz = side * header.spacing_m[1];
    return (std::sqrt(dx * dx + dz * dz + climb_m * climb_m) + (2 * pads.ground_m + pads.height_m)) * (1 + 0x1p-20);
}

std::uint8_t rim_code(const EditsData& e, SampleIndex v) {
    const TerrainData& t = *e.terrain;
    const double climb_m = (t.range.high_steps - t.range.low_steps) * static_cast<double>(t.header.quantum_m);
    const std::uint32_t levels = levels_below(v);
    const Pads pads{e.radius.ground_pad_m, e.radius.height_pad_m};
    std::uint32_t most = 0;
    for (std::uint32_t d = 0; d <= levels; ++d) // what is below nests in it
        most = std::max(most, t.errors.code_up(rim_m(t.header, pads, static_cast<int>(levels - d) / 2, climb_m)) +
                                  d * t.errors.nesting_steps);
    return static_cast<std::uint8_t>(std::min(most, 255u));
}

double rim_around_m(const EditsData& e, const Ground& ground, SampleIndex v, const StepRange& filled) {
    const TerrainData& t = *e.terrain;
    StepRange heights = filled;
    bool all = t.header.estimate != ErrorEstimate::midpoint; // its codes bound no sample
    const auto see = [&](SampleIndex at) {
        const Cell cell = ground.at(at);
        all = all && cell.loaded;
        if (cell.loaded) heights.add(cell.steps);
    };
    const Diamond d = diamond(t.tree, v);
    for (const SampleIndex at : {v, d.ends[0], d.ends[1]}) see(at);
    for (const SampleIndex apex : d.apexes)
        if (t.tree.contains(apex)) see(apex);
    if (!all) heights.add({t.range.low_steps, t.range.high_steps});
    return rim_m(t.header, {e.radius.ground_pad_m, e.radius.height_pad_m}, Tree::step_log2(v),
                 heights.span() * static_cast<double>(t.header.quantum_m));
}

std::uint32_t grown(const TerrainData& t, std::uint32_t code, double by_m) {
    return t.errors.code_up(static_cast<double>(t.errors.metres[code]) + by_m);
}

// Why growing suffices. Let the ground's heights change by d at each sample, least <= d <= most, 0 among them. Over an
// un-split diamond a sample differed from the surface by at most e. Now the sample has moved by d, and the surface over
// it by a mean of d's at its corners; these differ by at most most - least, so the new difference is at most
// e + (most - least). Codes round up, so they bound it; and each is raised to what its children ask for, from fine to
// coarse, so they nest.
//
// Where samples become holes, or ground, a diamond with such a sample under it is off by rim_around_m() at most: by the
// longest edge of its triangles, if a rim runs under it; by e, at what was ground; and by the heights between all its
// corners and what has become ground, there.
//
// A vertex under whose square something is locked gets the locks' code where this bound is above what is allowed, until
// it is measured: so locks keep their errors after every step.
//
// Only vertices with changed ground under them, and those above a vertex whose code has changed, need another one: all
// others nest and bound as they did. One that is not loaded counts as changed.
int raise_errors(EditsData& e, const Ground& ground, const Change& change) {
    TerrainData& t = *e.terrain;
    const Rect& places = change.places;
    const double by_m = change.off.span() * static_cast<double>(t.header.quantum_m);
    int loose_z = std::min(t.header.estimate == ErrorEstimate::midpoint ? t.tree.tile_log2 : measured_at_once + 1,
                           t.tree.tile_log2);
    // No ground is farther from its triangles than all heights are apart, or over a hole's rim than its own size: what
    // locks have raised so far does not grow further.
    std::uint32_t most_codes[max_tile_log2];
    const double all_m = (t.range.high_steps - t.range.low_steps) * static_cast<double>(t.header.quantum_m);
    for (int z = 0; z < t.tree.tile_log2; ++z)
        most_codes[z] = t.errors.code_up(
            t.has_voids() ? rim_m(t.header, {e.radius.ground_pad_m, e.radius.height_pad_m}, z, all_m) : all_m);
    std::uint32_t most = 0;
    WindowLocks locks(e, *ground.window());
    const auto raise = [&](const Plane& plane, std::int32_t i, std::int32_t j, const Rect& touched) { // true: changed
        const SampleIndex v = plane.at(i, j);
        const Cell own = ground.at(v);
        if (!own.loaded) {
            loose_z = std::min(loose_z, plane.z);
            return true;
        }
        const Asked asked = asked_by_children(ground, v);
        const auto may_be = [&] {
            // The ground under its triangles has changed, or that under a vertex below it may have.
            const bool affected = touched.contains(v) || !asked.all;
            const bool grows = affected && own.error < most_codes[plane.z];
            std::uint32_t code = std::max(grows ? grown(t, own.error, by_m) : own.error, asked.code);
            if (!touched.contains(v)) return code;
            if (change.holes)
                code = std::max<std::uint32_t>(code, t.errors.code_up(rim_around_m(e, ground, v, change.filled)));
            return lock_at(e, v).raised(code);
        };
        std::uint32_t code = 256;
        // Measured too where it has grown again and again, until no code is left.
        if (plane.z < loose_z || (code = may_be()) == 255) {
            const Measured measured = measure(e, ground, v, asked);
            if (measured.exact)
                code = measured.code;
            else
                loose_z = std::min(loose_z, plane.z), code = may_be();
        }
        if (code == own.error) return false;
        ground.set_error(plane, i, j, static_cast<std::uint8_t>(code));
        most = std::max(most, code);
        return true;
    };
    go_up(
        0, t.tree.tile_log2 - 1, [&](const Plane& plane) { return plane.squares(places.grown(1 << plane.z)); },
        [&](const Plane& plane, const Rect& todo) {
            // Not beyond what depends on these places, where a vertex under which pages are missing would grow for
            // nothing, and followers would not look.
            const Rect squares = todo.within(around(t.tree, plane, places)), touched = places.grown(1 << plane.z),
                       at_once = MeasuredPlane::measurable(ground, plane, squares);
            Rect changed;
            if (!at_once.empty()) {
                locks.begin_step(plane.z);
                changed = MeasuredPlane(ground, plane, locks).measure(at_once, most);
                ground.window()->note(plane.z, plane.places(changed));
            }
            for (std::int32_t j = squares.y0; j <= squares.y1; ++j)
                for (std::int32_t i = squares.x0; i <= squares.x1; ++i) {
                    if (at_once.contains(SampleIndex{i, j}))
                        i = at_once.x1;
                    else if (raise(plane, i, j, touched))
                        changed = changed.with({i, j, i, j});
                }
            return changed;
        });
    note_error(t, most);
    return loose_z;
}

void note_error(TerrainData& t, std::uint32_t code) {
    if (t.errors.metres[code] > t.range.error_m) store_release(t.range.error_m, t.errors.metres[code]);
}

} // namespace fjell::edit
