#include "edit/measure.h"

#include <cmath>

#include "shared/diamond_error.h"

namespace fjell::edit {

namespace {

// --- errors

// The largest vertical difference between a triangle and the ground under it. The tree itself says where to look: below
// a triangle that the tree splits, nothing is farther from its plane than its splitting vertex' error; so most of it
// need not be looked at (branch and bound). In units of 1 / 2s steps, whole numbers.
class Search {
public:
    Search(const TerrainData& t, const Heights& heights, SampleIndex v, std::uint32_t least)
        : t_(t), heights_(heights), s_(1 << Tree::step_log2(v)),
          unit_m_(0.5 * static_cast<double>(t.header.quantum_m) / s_) {
        raise(least);
    }
    void triangle(SampleIndex apex, const SampleIndex (&ends)[2], SampleIndex middle, std::uint32_t code) {
        const Height a = heights_.at(apex), b = heights_.at(ends[0]), c = heights_.at(ends[1]);
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
        const Corner corner[3] = {{apex, 0}, {ends[0], 0}, {ends[1], 0}};
        descend(corner[0], corner[1], corner[2], middle, code);
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
    // The triangle with its right angle at a and its hypotenuse from b to c; m splits it, a vertex with this code.
    void descend(const Corner& a, const Corner& b, const Corner& c, SampleIndex m, std::uint32_t code) {
        const std::int64_t most = std::max({a.off, b.off, c.off});
        const double within_m = static_cast<double>(most) * unit_m_ + static_cast<double>(t_.errors.metres[code]);
        if (within_m * (1 - 0x1p-40) <= enough_m_) return;
        const Height h = heights_.at(m);
        const Corner middle{m, off(m, h.steps)};
        see(static_cast<double>(middle.off) * unit_m_);
        below(middle, a, b, code);
        below(middle, c, a, code);
    }
    // parent: code of the vertex at the right angle.
    void below(const Corner& right, const Corner& one, const Corner& other, std::uint32_t parent) {
        const SampleIndex sum = one.at + other.at;
        if (((sum.column | sum.row) & 1) != 0) return; // of the full resolution: nothing lies under it
        const SampleIndex m{sum.column / 2, sum.row / 2};
        const Found found = find_record(t_, m);
        if (found.record == nullptr) { // its error nests in its parent's
            const std::uint32_t most = parent > t_.errors.nesting_steps ? parent - t_.errors.nesting_steps : 0;
            const double within_m = static_cast<double>(std::max({right.off, one.off, other.off})) * unit_m_ +
                                    static_cast<double>(t_.errors.metres[most]);
            if (within_m > enough_m_) {
                raise(t_.errors.code_up(within_m));
                exact_ = false;
            }
            return;
        }
        descend(right, one, other, m, found.record->error);
    }

    const TerrainData& t_;
    const Heights& heights_;
    std::int32_t s_;
    double unit_m_, enough_m_ = 0;
    std::uint32_t code_ = 0;
    bool exact_ = true;
    std::int64_t gx_ = 0, gy_ = 0, origin_ = 0;
    SampleIndex at_{};
};

// Diamonds of so many places a side are looked at sample by sample where they must be: with holes, or at the rim.
constexpr int looked_through = 8; // log2 of the step

bool may_have_holes(const TerrainData& t) {
    return t.has_voids();
}

} // namespace

OwnError own_error(const EditsData& e, const Heights& heights, SampleIndex v, std::uint32_t least) {
    const TerrainData& t = heights.terrain;
    const int z = Tree::step_log2(v);
    const bool midpoint = t.header.estimate == ErrorEstimate::midpoint;
    const Diamond d = diamond(t.tree, v);
    if (straddles_rim(t.tree, v) || may_have_holes(t)) {
        const auto now = [&]() -> std::uint32_t {
            const Found found = find_record(t, v);
            return found.record != nullptr ? found.record->error : 255u;
        };
        if (z > looked_through) return {std::max(least, now()), false};
        const std::int32_t s = 1 << z;
        const Rect around = Rect{v.column - s, v.row - s, v.column + s, v.row + s}.within(grid_of(t.tree));
        for (std::int32_t y = around.y0; y <= around.y1; ++y)
            for (std::int32_t x = around.x0; x <= around.x1; ++x)
                if (!heights.at({x, y}).loaded) return {std::max(least, now()), false};
        const DiamondTerms terms{t.errors,
                                 static_cast<double>(t.header.quantum_m),
                                 {t.header.spacing_m[0], t.header.spacing_m[1]},
                                 e.radius.ground_pad_m,
                                 e.radius.height_pad_m,
                                 midpoint};
        const auto code = diamond_error(heights, terms, v, [&](SampleIndex apex) { return exists(t.tree, apex); }).code;
        return {std::max<std::uint32_t>(code, least), true};
    }
    const Height h = heights.at(v);
    if (z == 0 || midpoint) {
        const Height a = heights.at(d.ends[0]), b = heights.at(d.ends[1]);
        if (!a.loaded || !b.loaded || !h.loaded) return {255, false};
        const std::int64_t jump = std::abs(2 * std::int64_t{h.steps} - a.steps - b.steps);
        return {std::max<std::uint32_t>(t.memory->leaf.code(static_cast<std::uint32_t>(jump)), least), true};
    }
    Search search(t, heights, v, least);
    for (const SampleIndex apex : d.apexes) // 255: that the vertex' own error is not known
        if (exists(t.tree, apex)) search.triangle(apex, d.ends, v, 255);
    return {search.code(), search.exact()};
}

Asked asked_by_children(const TerrainData& t, SampleIndex v) {
    const Children below = children(v);
    Asked asked{0, true};
    for (int k = 0; k < below.count; ++k) {
        if (!exists(t.tree, below.at[k])) continue;
        const Found found = find_record(t, below.at[k]);
        if (found.record != nullptr)
            asked.code = std::max<std::uint32_t>(asked.code, t.errors.above(found.record->error));
        else
            asked.all = false;
    }
    asked.code = std::min(asked.code, 255u);
    return asked;
}

// --- radii: as baker/errors/step.cpp has it, for a few vertices

RadiusTerms radius_terms(const TerrainData& t) {
    const PackHeader& h = t.header;
    RadiusTerms r{};
    const double extent = std::max({t.tree.grid_columns() * h.spacing_m[0], t.tree.grid_rows() * h.spacing_m[1], 1e4});
    const double least = h.min_m, most = h.max_m;
    r.ground_pad_m = extent * 0x1p-22;
    r.height_pad_m = (std::max(std::abs(least), std::abs(most)) + most - least) * 0x1p-22;
    r.half_quantum_m = 0.5 * static_cast<double>(h.quantum_m);
    r.quantum = h.quantum_m;
    r.height_pad = static_cast<float>(r.height_pad_m);
    r.leaf_pad = static_cast<float>(r.half_quantum_m);
    for (int z = 0; z < t.tree.tile_log2; ++z) {
        const double s = 1 << z;
        const auto ground = [&](double x, double y) {
            const double dx = x * h.spacing_m[0] + 2 * r.ground_pad_m, dy = y * h.spacing_m[1] + 2 * r.ground_pad_m;
            return static_cast<float>(dx * dx * (x != 0) + dy * dy * (y != 0));
        };
        r.along_x[z] = ground(s, 0);
        r.along_y[z] = ground(0, s);
        r.across[z] = ground(s / 2, s / 2);
        const int level = 2 * (t.tree.tile_log2 - 1 - z);
        r.unit_m[2 * z] = h.level_radius_m[level + 1];
        r.unit_m[2 * z + 1] = h.level_radius_m[level];
    }
    return r;
}

namespace {

constexpr float float_rounding = 1 + 0x1p-19f; // of the baker, and the next
constexpr double sphere_margin = 1 + 0x1p-16;

class RadiusStep {
public:
    // by_m: what heights have changed by at most, where radii can only be bounded.
    RadiusStep(EditsData& e, const Heights& heights, int z, double by_m)
        : e_(e), heights_(heights), t_(*e.terrain), z_(z), by_m_(by_m) {}

    // Codes of a plane over squares, and stores them; whole blocks, which share one where the step has pages of its
    // own. Returns those that changed.
    [[nodiscard]] Rect plane(VertexKind kind, Rect squares, bool& fits) {
        const Plane plane{z_, kind};
        const int log2 = t_.tree.tile_log2 - 1 - z_;
        const std::int32_t size = log2 >= page_squares_log2 ? 1 << radius_squares_log2 : 1;
        const Rect all{0, 0, (t_.tree.tiles_x << log2) - (kind == VertexKind::side_y ? 0 : 1),
                       (t_.tree.tiles_y << log2) - (kind == VertexKind::side_x ? 0 : 1)};
        squares = squares.within(all);
        Rect changed;
        if (squares.empty()) return changed;
        for (std::int32_t j = squares.y0 & -size; j <= squares.y1; j += size)
            for (std::int32_t i = squares.x0 & -size; i <= squares.x1; i += size) {
                const Rect block = Rect{i, j, i + size - 1, j + size - 1}.within(all);
                float most = 0;
                bool known = true;
                for (std::int32_t y = block.y0; y <= block.y1 && known; ++y)
                    for (std::int32_t x = block.x0; x <= block.x1 && known; ++x)
                        known = add(plane.at(x, y), kind, most);
                if (!known) { // something below is not loaded
                    e_.radii_unknown = true;
                    if (grow(plane, block)) changed = changed.with(block);
                    continue;
                }
                const float unit_m = e_.radius.unit_m[2 * z_ + (kind == VertexKind::centre ? 1 : 0)];
                const std::uint32_t code = code_up(unit_m, most);
                fits = fits && static_cast<double>(unit_m * t_.radii.factor[code]) >= static_cast<double>(most);
                if (store(plane, block, static_cast<std::uint8_t>(code))) changed = changed.with(block);
            }
        return changed;
    }

    // One vertex, which has to contain its children: those that are loaded, and the others wherever they may be by now.
    // Never less than it does. True: it was another radius.
    bool contain(const Plane& plane, std::int32_t i, std::int32_t j) {
        const SampleIndex v = plane.at(i, j);
        const Found found = find_record(t_, v);
        if (found.record == nullptr) return false;
        const std::uint32_t before = found.record->radius & (radius_codes - 1u);
        const float unit_m = e_.radius.unit_m[2 * z_ + (plane.kind == VertexKind::centre ? 1 : 0)];
        float most = 0;
        if (!add(v, plane.kind, most) && by_m_ > 0)
            most = std::max(most, unit_m * t_.radii.factor[before] +
                                      static_cast<float>((levels_below(v) + 1) * by_m_ * (1 + 0x1p-10)));
        const std::uint32_t code = std::max(code_up(unit_m, most), before);
        return code != before && store(plane, {i, j, i, j}, static_cast<std::uint8_t>(code));
    }

private:
    [[nodiscard]] std::uint32_t code_up(float unit_m, float radius_m) const {
        const double asked_m = static_cast<double>(radius_m) * sphere_margin;
        std::uint32_t below = 0; // how many codes are
        for (std::uint32_t step = radius_codes / 2; step != 0; step /= 2)
            below += step * static_cast<std::uint32_t>(static_cast<double>(unit_m * t_.radii.factor[below + step - 1]) <
                                                       asked_m);
        return below;
    }
    bool grow(const Plane& plane, const Rect& block) {
        bool changed = false;
        for (std::int32_t y = block.y0; y <= block.y1; ++y)
            for (std::int32_t x = block.x0; x <= block.x1; ++x) changed = contain(plane, x, y) || changed;
        return changed;
    }
    [[nodiscard]] float distance_m(float ground, std::int32_t a, std::int32_t b) const {
        const float climb = static_cast<float>(std::abs(a - b)) * e_.radius.quantum + e_.radius.height_pad;
        return std::sqrt(ground + climb * climb);
    }
    // most: of the radii so far. False: something is not loaded, and most is of the rest.
    [[nodiscard]] bool add(SampleIndex v, VertexKind kind, float& most) const {
        const Height own = heights_.at(v);
        if (!own.loaded) return false;
        if (kind != VertexKind::centre && z_ == 0) {
            const bool along_x = kind == VertexKind::side_x;
            const Diamond d = diamond(t_.tree, v);
            float end = 0, apex = 0;
            for (int k = 0; k < 2; ++k) {
                const Height e = heights_.at(d.ends[k]);
                if (!e.loaded) return false;
                end = std::max(end,
                               distance_m(along_x ? e_.radius.along_x[0] : e_.radius.along_y[0], e.steps, own.steps));
                // One that is beyond the terrain stands where the vertex does.
                const Height a = exists(t_.tree, d.apexes[k]) ? heights_.at(d.apexes[k]) : own;
                if (!a.loaded) return false;
                apex = std::max(apex,
                                distance_m(along_x ? e_.radius.along_y[0] : e_.radius.along_x[0], a.steps, own.steps));
            }
            most = std::max(most, (std::max(end, apex) + e_.radius.leaf_pad) * float_rounding);
            return true;
        }
        const Children all = children(v);
        bool known = true;
        for (const SampleIndex child : all.at) {
            if (!exists(t_.tree, child)) continue;
            const Found found = find_record(t_, child);
            const Height h = heights_.at(child);
            if (found.record == nullptr || !h.loaded) {
                known = false;
                continue;
            }
            const int code = found.record->radius & (radius_codes - 1);
            float ground = 0, radius_m = 0;
            if (kind == VertexKind::centre) {
                ground = child.row == v.row ? e_.radius.along_x[z_] : e_.radius.along_y[z_];
                radius_m = e_.radius.unit_m[2 * z_] * t_.radii.factor[code];
            } else {
                ground = e_.radius.across[z_];
                radius_m = e_.radius.unit_m[2 * (z_ - 1) + 1] * t_.radii.factor[code];
            }
            most = std::max(most, (distance_m(ground, h.steps, own.steps) + radius_m) * float_rounding);
        }
        return known;
    }
    // True: it was another one.
    bool store(const Plane& plane, const Rect& block, std::uint8_t code) {
        TerrainMemory& m = *t_.memory;
        bool changed = false;
        for_each_run(t_, plane, block, [&](const Run& run) {
            const std::uint32_t slot = t_.page_table[run.page].slot;
            if (slot == no_index) return;
            VertexRecord* const to = m.records + std::size_t{slot} * t_.page_capacity + run.index;
            for (std::int32_t k = 0; k < run.count; ++k) {
                VertexRecord record = to[k];
                if ((record.radius & (radius_codes - 1)) == code) continue;
                changed = true;
                record.radius = static_cast<std::uint8_t>((record.radius & void_bit) | code);
                write_record(to + k, bits_as<std::uint32_t>(record));
            }
        });
        return changed;
    }

    EditsData& e_;
    const Heights& heights_;
    const TerrainData& t_;
    int z_;
    double by_m_;
};

} // namespace

void push_change(EditsData& e, const Rect& places, bool heights, std::int8_t step_log2) {
    TerrainData& t = *e.terrain;
    e.changes[t.ground_changes++ % ground_change_log] = {
        {places.x0, places.y0}, {places.x1, places.y1}, heights, step_log2};
}

void contain_children(EditsData& e, const Plane& plane, std::int32_t i, std::int32_t j) {
    (void)RadiusStep(e, {*e.terrain, nullptr}, plane.z, 0).contain(plane, i, j);
}

bool nest_radii(EditsData& e, const Heights& heights, const Rect& places, double by_m, int from_z, bool told) {
    const TerrainData& t = *e.terrain;
    bool fits = true;
    Rect finer; // centres of the step before that stand or reach elsewhere
    for (int z = from_z; z < t.tree.tile_log2; ++z) {
        // Of pages that have come, all that may depend on the places.
        const Rect changed = told ? places : places.grown(radius_reach << z).within(grid_of(t.tree));
        RadiusStep step(e, heights, z, by_m);
        const auto note = [&](VertexKind kind, const Rect& squares) {
            if (squares.empty()) return squares;
            const Plane plane{z, kind};
            const SampleIndex first = plane.at(squares.x0, squares.y0), last = plane.at(squares.x1, squares.y1);
            const Rect moved{first.column, first.row, last.column, last.row};
            const Rect near = changed.grown((kind == VertexKind::centre ? 3 : 2) << z);
            if (!told || !near.contains(first) || !near.contains(last))
                push_change(e, moved, false, static_cast<std::int8_t>(z));
            return squares;
        };
        Rect sides[2]; // along x, along y
        for (const int k : {0, 1}) {
            const bool along_x = k == 0;
            const Plane plane{z, along_x ? VertexKind::side_x : VertexKind::side_y};
            const Rect own = plane.squares(changed);
            Rect todo = z == 0 ? plane.squares(changed.grown(1)) : own;
            if (!finer.empty())
                todo = todo.with({finer.x0 >> 1, finer.y0 >> 1, (finer.x1 + (along_x ? 0 : 1)) >> 1,
                                  (finer.y1 + (along_x ? 1 : 0)) >> 1});
            sides[k] = note(plane.kind, step.plane(plane.kind, todo, fits)).with(own);
            if (own.empty() && sides[k].empty()) sides[k] = {};
        }
        const Rect own = Plane{z, VertexKind::centre}.squares(changed);
        Rect todo = own;
        if (!sides[0].empty()) todo = todo.with({sides[0].x0, sides[0].y0 - 1, sides[0].x1, sides[0].y1});
        if (!sides[1].empty()) todo = todo.with({sides[1].x0 - 1, sides[1].y0, sides[1].x1, sides[1].y1});
        finer = note(VertexKind::centre, step.plane(VertexKind::centre, todo, fits));
        if (!own.empty()) finer = finer.with(own);
    }
    return fits;
}

} // namespace fjell::edit
