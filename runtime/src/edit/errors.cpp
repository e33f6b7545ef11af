#include "edit/errors.h"

#include "shared/diamond_error.h"

namespace fjell::edit {

namespace {

// The largest vertical difference between a triangle and the ground under it. The tree itself says where to look: below
// a triangle that the tree splits, nothing is farther from its plane than its splitting vertex' error; so most of it
// need not be looked at (branch and bound). In units of 1 / 2s steps, whole numbers.
class Search {
public:
    Search(const Ground& ground, SampleIndex v, std::uint32_t least)
        : t_(ground.terrain), ground_(ground), s_(1 << Tree::step_log2(v)),
          unit_m_(0.5 * static_cast<double>(t_.header.quantum_m) / s_) {
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

private:
    struct Corner {
        SampleIndex at;
        std::int64_t off; // |2s (h - plane)|
    };
    void raise(std::uint32_t code) {
        code_ = std::min(code, 255u);
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
        see(static_cast<double>(middle.off) * unit_m_);
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
    std::int32_t s_;
    double unit_m_, enough_m_ = 0;
    std::uint32_t code_ = 0;
    bool exact_ = true;
    std::int64_t gx_ = 0, gy_ = 0, origin_ = 0;
    SampleIndex at_{};
};

// Diamonds up to this step (its log2) are looked at sample by sample where they must be: with holes, or at the rim.
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
    const DiamondTerms terms{t.errors,
                             static_cast<double>(t.header.quantum_m),
                             {t.header.spacing_m[0], t.header.spacing_m[1]},
                             e.radius.ground_pad_m,
                             e.radius.height_pad_m,
                             t.header.estimate == ErrorEstimate::midpoint};
    return {diamond_error(ground, terms, v, [&](SampleIndex apex) { return t.tree.contains(apex); }).code, true};
}

// What lies under a small diamond, looked at sample by sample in the window: the largest difference from its triangles,
// in units of 1 / 2s steps. v: its vertex, of step s, with all around it loaded.
class SmallDiamond {
public:
    SmallDiamond(const Cell* v, std::int32_t s) : v_(v), s_(s) {}
    [[nodiscard]] std::int32_t side_x() {
        const std::int32_t west = h(-s_, 0), east = h(s_, 0), gx = east - west, middle = west + east;
        for (std::int32_t dy = -s_; dy <= s_; ++dy) {
            const std::int32_t far = std::abs(dy), rise = 2 * h(0, dy < 0 ? -s_ : s_) - middle;
            row(dy, far - s_, s_ - far, s_ * middle + far * rise, gx);
        }
        return worst_;
    }
    [[nodiscard]] std::int32_t side_y() {
        const std::int32_t north = h(0, -s_), south = h(0, s_), gy = south - north, middle = north + south;
        const std::int32_t to_west = 2 * h(-s_, 0) - middle, to_east = 2 * h(s_, 0) - middle;
        for (std::int32_t dy = -s_; dy <= s_; ++dy) {
            const std::int32_t half = s_ - std::abs(dy), at = s_ * middle + gy * dy;
            row(dy, -half, 0, at, -to_west);
            row(dy, 0, half, at, to_east);
        }
        return worst_;
    }
    // from_sw: its hypotenuse runs from south-west to north-east, otherwise from north-west to south-east.
    [[nodiscard]] std::int32_t centre(bool from_sw) {
        const std::int32_t sign = from_sw ? -1 : 1;
        const std::int32_t north = h(-s_ * sign, -s_), south = h(s_ * sign, s_); // ends of the hypotenuse
        const std::int32_t west = h(-s_, s_ * sign), east = h(s_, -s_ * sign);   // apexes
        for (std::int32_t dy = -s_; dy <= s_; ++dy) {
            // Across the west triangle's row heights change as along its leg, and so across the east one's.
            const std::int32_t split = dy * sign, at = s_ * (north + south) + dy * (south - north);
            row(dy, -s_, split, at, from_sw ? north - west : south - west, split);
            row(dy, split, s_, at, from_sw ? east - south : east - north, split);
        }
        return worst_;
    }

private:
    [[nodiscard]] std::int32_t h(std::int32_t dx, std::int32_t dy) const {
        return v_[dy * window_side + dx].steps - v_->steps;
    }
    // at: the triangle's height at dx = origin.
    void row(std::int32_t dy, std::int32_t from, std::int32_t to, std::int32_t at, std::int32_t gx,
             std::int32_t origin = 0) {
        const Cell* const cells = v_ + dy * window_side;
        std::int32_t plane = at + gx * (from - origin), worst = worst_;
        for (std::int32_t dx = from; dx <= to; ++dx, plane += gx)
            worst = std::max(worst, std::abs(2 * s_ * (cells[dx].steps - v_->steps) - plane));
        worst_ = worst;
    }
    const Cell* v_;
    std::int32_t s_, worst_ = 0;
};

// Of the ground under its triangles alone. least: a smaller code is not told from this one.
Measured measure_ground(const EditsData& e, const Ground& ground, SampleIndex v, std::uint32_t least) {
    const TerrainData& t = ground.terrain;
    if (straddles_rim(t.tree, v) || t.has_voids()) return scan(e, ground, v);
    const Diamond d = diamond(t.tree, v);
    if (Tree::step_log2(v) == 0 || t.header.estimate == ErrorEstimate::midpoint) {
        const Cell own = ground.at(v), a = ground.at(d.ends[0]), b = ground.at(d.ends[1]);
        if (!a.loaded || !b.loaded || !own.loaded) return {255, false};
        const std::int64_t jump = std::abs(2 * std::int64_t{own.steps} - a.steps - b.steps);
        return {t.memory->leaf.code(static_cast<std::uint32_t>(jump)), true};
    }
    const int z = Tree::step_log2(v);
    const std::int32_t s = 1 << z;
    if (Window* const w = ground.window(); w != nullptr && w->complete && z <= measured_at_once &&
                                           w->rect.contains(Rect{v.column - s, v.row - s, v.column + s, v.row + s})) {
        SmallDiamond small(&w->at(v), s);
        const VertexKind kind = Tree::kind(v);
        const std::int32_t worst = kind == VertexKind::side_x   ? small.side_x()
                                   : kind == VertexKind::side_y ? small.side_y()
                                                                : small.centre(d.ends[0].row > v.row);
        return {t.errors.code_up(0.5 * static_cast<double>(t.header.quantum_m) / s * worst), true};
    }
    Search search(ground, v, least);
    for (const SampleIndex apex : d.apexes)
        if (t.tree.contains(apex)) search.triangle(apex, d.ends, v);
    return {search.code(), search.exact()};
}

} // namespace

Asked asked_by_children(const Ground& ground, SampleIndex v) {
    const std::int32_t s = 1 << Tree::step_log2(v);
    const bool centre = Tree::kind(v) == VertexKind::centre;
    if (!centre && s == 1) return {0, true};
    if (Window* const w = ground.window();
        w != nullptr && w->complete && w->rect.contains(Rect{v.column - s, v.row - s, v.column + s, v.row + s})) {
        const Cell* const own = &w->at(v);
        const std::ptrdiff_t h = centre ? s : s / 2, across = centre ? 0 : h;
        const std::ptrdiff_t a = h + across * window_side, b = h * window_side - across;
        const std::uint32_t most = std::max({own[a].error, own[-a].error, own[b].error, own[-b].error});
        return {std::min(ground.terrain.errors.above(most), 255u), true};
    }
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
    Measured own = measure_ground(e, ground, v, asked.code);
    own.code = std::max(own.code, asked.code);
    return own;
}

std::uint32_t grown(const TerrainData& t, std::uint32_t code, double by_m) {
    return t.errors.code_up(static_cast<double>(t.errors.metres[code]) + by_m);
}

// Why growing suffices. Let the ground's heights change by d at each sample, least <= d <= most, 0 among them. Over an
// un-split diamond a sample differed from the surface by at most e. Now the sample has moved by d, and the surface over
// it by a mean of d's at its corners; these differ by at most most - least, so the new difference is at most
// e + (most - least). Codes round up, so they bound it; and each is raised to what its children ask for, from fine to
// coarse, so they nest.
int raise_errors(EditsData& e, const Ground& ground, const Rect& places, const StepRange& off) {
    TerrainData& t = *e.terrain;
    const double by_m = off.span() * static_cast<double>(t.header.quantum_m);
    int loose_z = std::min(t.header.estimate == ErrorEstimate::midpoint ? t.tree.tile_log2 : measured_at_once + 1,
                           t.tree.tile_log2);
    std::uint32_t most = 0;
    for_each_plane(0, t.tree.tile_log2 - 1, [&](const Plane& plane) {
        const Rect squares = around(t.tree, plane, places), touched = places.grown(1 << plane.z);
        for (std::int32_t j = squares.y0; j <= squares.y1; ++j)
            for (std::int32_t i = squares.x0; i <= squares.x1; ++i) {
                const SampleIndex v = plane.at(i, j);
                const Cell own = ground.at(v);
                if (!own.loaded) {
                    loose_z = std::min(loose_z, plane.z);
                    continue;
                }
                const Asked asked = asked_by_children(ground, v);
                // The ground under its triangles has changed, or that under a vertex below it may have.
                const bool affected = touched.contains(v) || !asked.all;
                std::uint32_t code = std::max(affected ? grown(t, own.error, by_m) : own.error, asked.code);
                // Measured too where it has grown again and again, until no code is left.
                if (plane.z < loose_z || code == 255) {
                    const Measured measured = measure(e, ground, v, asked);
                    if (measured.exact)
                        code = measured.code;
                    else
                        loose_z = std::min(loose_z, plane.z);
                }
                if (code == own.error) continue;
                ground.set_error(plane, i, j, static_cast<std::uint8_t>(code));
                most = std::max(most, code);
            }
    });
    note_error(t, most);
    return loose_z;
}

void note_error(TerrainData& t, std::uint32_t code) {
    if (t.errors.metres[code] > t.range.error_m) store_release(t.range.error_m, t.errors.metres[code]);
}

} // namespace fjell::edit
