#include "rivals/simplify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace fjell::rivals {

namespace {

// Metres that a cell of an edge's squared length weighs: among collapses that are equally wrong, short ones first, or
// level ground becomes slivers.
constexpr double shape_m = 1e-3;

// What is around a vertex: faces[i] holds it, ring[i] and ring[i + 1].
struct Star {
    std::vector<std::uint32_t> faces, ring; // a closed ring ends with its first
    bool closed = false;
};

struct Candidate {
    double key;
    std::uint32_t from, to, stamp;
    float error_m;
    friend bool operator<(const Candidate& a, const Candidate& b) {
        return a.key != b.key ? a.key > b.key : a.from > b.from; // the least first
    }
};

class Simplifier {
public:
    explicit Simplifier(const Ground& ground) : ground_(ground), face_of_(ground.height_m.size()) {
        make_faces();
        stamps_.assign(ground.height_m.size(), 0);
    }
    void block(std::int32_t column, std::int32_t row, std::int32_t cells, std::size_t vertices);
    Simplified done;

private:
    void make_faces();
    [[nodiscard]] SampleIndex coord(std::uint32_t i) const {
        const auto stride = static_cast<std::uint32_t>(ground_.side + 1);
        return {static_cast<std::int32_t>(i % stride), static_cast<std::int32_t>(i / stride)};
    }
    [[nodiscard]] bool may_go(SampleIndex c, std::int32_t column, std::int32_t row, std::int32_t cells) const;
    [[nodiscard]] bool same_side(SampleIndex a, SampleIndex b) const {
        return (a.column == b.column && (a.column == 0 || a.column == ground_.side)) ||
               (a.row == b.row && (a.row == 0 || a.row == ground_.side));
    }
    static std::int64_t doubled_area(SampleIndex a, SampleIndex b, SampleIndex c) {
        return std::int64_t{b.row - a.row} * (c.column - a.column) -
               std::int64_t{b.column - a.column} * (c.row - a.row);
    }
    void star_of(std::uint32_t v, Star& star) const;
    // The largest distance of a sample from this triangle, or something above `limit`.
    [[nodiscard]] double deviation(std::uint32_t a, std::uint32_t b, std::uint32_t c, double limit) const;
    [[nodiscard]] double error_of(const Star& star, std::size_t target, double limit) const;
    void propose(std::uint32_t v);
    void collapse(const Candidate& c);
    void replace_neighbour(std::uint32_t face, std::uint32_t was, std::uint32_t is);

    const Ground& ground_;
    std::vector<std::uint32_t> face_of_, stamps_; // of a sample: one of its faces; how often its star has changed
    std::priority_queue<Candidate> queue_;
    Star star_;
};

void Simplifier::make_faces() {
    const std::int32_t n = ground_.side;
    done.faces.resize(2 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
    const auto lower = [&](std::int32_t x, std::int32_t y) { // corner at (x, y + 1)
        return x < 0 || y < 0 || x >= n || y >= n ? no_index : 2 * static_cast<std::uint32_t>(y * n + x);
    };
    const auto upper = [&](std::int32_t x, std::int32_t y) { // corner at (x + 1, y)
        const std::uint32_t l = lower(x, y);
        return l == no_index ? l : l + 1;
    };
    for (std::int32_t y = 0; y < n; ++y)
        for (std::int32_t x = 0; x < n; ++x) {
            const std::uint32_t a = ground_.index({x, y}), b = ground_.index({x + 1, y}), c = ground_.index({x, y + 1}),
                                d = ground_.index({x + 1, y + 1});
            done.faces[lower(x, y)] = {{a, c, d}, {upper(x, y + 1), upper(x, y), upper(x - 1, y)}};
            done.faces[upper(x, y)] = {{a, d, b}, {lower(x + 1, y), lower(x, y - 1), lower(x, y)}};
            face_of_[a] = lower(x, y);
            if (x + 1 == n) face_of_[b] = upper(x, y);
            if (y + 1 == n) face_of_[c] = lower(x, y);
            if (x + 1 == n && y + 1 == n) face_of_[d] = lower(x, y);
        }
}

bool Simplifier::may_go(SampleIndex c, std::int32_t column, std::int32_t row, std::int32_t cells) const {
    const auto inside = [&](std::int32_t v, std::int32_t from) {
        return (v > from && v < from + cells) || v == 0 || v == ground_.side;
    };
    const bool at_x = c.column == 0 || c.column == ground_.side, at_y = c.row == 0 || c.row == ground_.side;
    return !(at_x && at_y) && inside(c.column, column) && inside(c.row, row);
}

void Simplifier::star_of(std::uint32_t v, Star& star) const {
    star.faces.clear();
    star.ring.clear();
    const auto place_in = [&](std::uint32_t face) {
        const auto& corner = done.faces[face].corner;
        return corner[0] == v ? 0u : corner[1] == v ? 1u : 2u;
    };
    const std::uint32_t some = face_of_[v];
    std::uint32_t start = some;
    for (;;) { // back to the rim, or once around
        const std::uint32_t before = done.faces[start].neighbour[(place_in(start) + 2) % 3];
        if (before == no_index || before == some) break;
        start = before;
    }
    star.closed = done.faces[start].neighbour[(place_in(start) + 2) % 3] != no_index;
    for (std::uint32_t face = start;;) {
        const std::uint32_t k = place_in(face);
        star.faces.push_back(face);
        star.ring.push_back(done.faces[face].corner[(k + 1) % 3]);
        const std::uint32_t next = done.faces[face].neighbour[(k + 1) % 3];
        if (next == no_index || next == start) {
            star.ring.push_back(done.faces[face].corner[(k + 2) % 3]);
            return;
        }
        face = next;
    }
}

double Simplifier::deviation(std::uint32_t ia, std::uint32_t ib, std::uint32_t ic, double limit) const {
    SampleIndex p[3] = {coord(ia), coord(ib), coord(ic)};
    const std::int64_t area = doubled_area(p[0], p[1], p[2]);
    if (area <= 1) return 0; // no samples but its corners
    const double h0 = static_cast<double>(ground_.height_m[ia]), h1 = static_cast<double>(ground_.height_m[ib]) - h0,
                 h2 = static_cast<double>(ground_.height_m[ic]) - h0, per_area = 1 / static_cast<double>(area);
    // doubled_area is turned: rows go down.
    const double across = -(h1 * (p[2].row - p[0].row) - h2 * (p[1].row - p[0].row)) * per_area,
                 down = (h1 * (p[2].column - p[0].column) - h2 * (p[1].column - p[0].column)) * per_area;
    const SampleIndex origin = p[0];
    std::sort(std::begin(p), std::end(p), [](SampleIndex a, SampleIndex b) { return a.row < b.row; });
    const auto at_row = [](SampleIndex a, SampleIndex b, std::int32_t y) {
        return a.column + static_cast<double>(b.column - a.column) * (y - a.row) / (b.row - a.row);
    };
    double most = 0;
    for (std::int32_t y = p[0].row; y <= p[2].row; ++y) {
        double x0 = at_row(p[0], p[2], y), x1 = y == p[1].row  ? p[1].column
                                                : y < p[1].row ? at_row(p[0], p[1], y)
                                                               : at_row(p[1], p[2], y);
        if (x0 > x1) std::swap(x0, x1);
        const auto from = static_cast<std::int32_t>(std::ceil(x0 - 1e-9)),
                   to = static_cast<std::int32_t>(std::floor(x1 + 1e-9));
        const float* const heights = &ground_.height_m[ground_.index({0, y})];
        double surface = h0 + down * (y - origin.row) + across * (from - origin.column);
        for (std::int32_t x = from; x <= to; ++x, surface += across)
            most = std::max(most, std::abs(surface - static_cast<double>(heights[x])));
        if (most > limit) return most;
    }
    return most;
}

// Of collapsing to ring[target]; infinite where a triangle would flip.
double Simplifier::error_of(const Star& star, std::size_t target, double limit) const {
    const std::uint32_t to = star.ring[target];
    const SampleIndex v = coord(to);
    const std::size_t count = star.faces.size();
    const auto gone = [&](std::size_t i) { return i == target || (star.closed ? (i + 1) % count : i + 1) == target; };
    for (std::size_t i = 0; i < count; ++i)
        if (!gone(i) && doubled_area(v, coord(star.ring[i]), coord(star.ring[i + 1])) <= 0)
            return std::numeric_limits<double>::infinity();
    double most = 0;
    for (std::size_t i = 0; i < count && most <= limit; ++i)
        if (!gone(i)) most = std::max(most, deviation(to, star.ring[i], star.ring[i + 1], limit));
    return most;
}

// One that cannot go as its star is now comes last: by then it may have changed.
void Simplifier::propose(std::uint32_t v) {
    star_of(v, star_);
    const SampleIndex at = coord(v);
    Candidate best{std::numeric_limits<double>::infinity(), v, no_index, stamps_[v], 0};
    const bool too_few = star_.faces.size() < (star_.closed ? 3u : 2u);
    const std::size_t targets = too_few ? 0 : star_.closed ? star_.ring.size() - 1 : star_.ring.size();
    for (std::size_t t = 0; t < targets; ++t) {
        const SampleIndex to = coord(star_.ring[t]);
        if (!star_.closed && !(same_side(at, to) && (t == 0 || t + 1 == targets))) continue;
        const double x = to.column - at.column, y = to.row - at.row, shape = shape_m * (x * x + y * y);
        if (shape >= best.key) continue;
        const double error = error_of(star_, t, best.key - shape);
        if (error + shape < best.key) {
            best.key = error + shape;
            best.to = star_.ring[t];
            best.error_m = std::nextafter(static_cast<float>(error), std::numeric_limits<float>::infinity());
        }
    }
    queue_.push(best);
}

void Simplifier::replace_neighbour(std::uint32_t face, std::uint32_t was, std::uint32_t is) {
    if (face == no_index) return;
    auto& n = done.faces[face].neighbour;
    n[n[0] == was ? 0 : n[1] == was ? 1 : 2] = is;
}

void Simplifier::collapse(const Candidate& candidate) {
    star_of(candidate.from, star_);
    const std::size_t count = star_.faces.size();
    const auto target =
        static_cast<std::size_t>(std::find(star_.ring.begin(), star_.ring.end(), candidate.to) - star_.ring.begin());
    Collapse c;
    c.from = candidate.from;
    c.to = candidate.to;
    c.error_m = candidate.error_m;
    if (star_.closed || target < count) c.first = star_.faces[target % count];
    if (star_.closed || target > 0) c.second = star_.faces[(target + count - 1) % count];
    const auto neighbour_across = [&](std::uint32_t face, std::uint32_t opposite) {
        const LinkedFace& f = done.faces[face];
        return f.neighbour[f.corner[0] == opposite ? 0 : f.corner[1] == opposite ? 1 : 2];
    };
    for (std::size_t i = 0; i < 2; ++i) {
        const std::uint32_t face = i == 0 ? c.first : c.second;
        if (face == no_index) continue;
        const std::uint32_t beyond_to = neighbour_across(face, c.from), beyond_from = neighbour_across(face, c.to);
        c.around[2 * i] = beyond_to;
        c.around[2 * i + 1] = beyond_from;
        replace_neighbour(beyond_to, face, beyond_from);
        replace_neighbour(beyond_from, face, beyond_to);
        done.faces[face].corner.fill(no_index);
    }
    const auto height = [&](std::uint32_t i) { return static_cast<double>(ground_.height_m[i]); };
    const SampleIndex at = coord(c.from);
    for (const std::uint32_t w : star_.ring) {
        const double x = (coord(w).column - at.column) * static_cast<double>(ground_.spacing_x_m),
                     z = (coord(w).row - at.row) * static_cast<double>(ground_.spacing_z_m),
                     y = height(w) - height(c.from);
        c.reach_m = std::max(c.reach_m, static_cast<float>(std::sqrt(x * x + y * y + z * z) * (1 + 1e-6)));
    }
    for (const std::uint32_t face : star_.faces) {
        auto& corner = done.faces[face].corner;
        if (corner[0] == no_index) continue;
        for (std::uint32_t& k : corner) {
            if (k == c.from) k = c.to;
            face_of_[k] = face;
        }
    }
    for (const std::uint32_t w : star_.ring) ++stamps_[w];
    done.collapses.push_back(c);
}

void Simplifier::block(std::int32_t column, std::int32_t row, std::int32_t cells, std::size_t vertices) {
    queue_ = {};
    std::size_t left = 0;
    for (std::int32_t y = row; y <= row + cells; ++y)
        for (std::int32_t x = column; x <= column + cells; ++x) {
            const std::uint32_t v = ground_.index({x, y});
            if (face_of_[v] == no_index || !may_go({x, y}, column, row, cells)) continue;
            ++left;
            propose(v);
        }
    while (left > vertices && !queue_.empty()) {
        const Candidate c = queue_.top();
        queue_.pop();
        if (face_of_[c.from] == no_index) continue;
        if (c.stamp != stamps_[c.from]) {
            propose(c.from);
        } else if (c.to != no_index) {
            collapse(c);
            face_of_[c.from] = no_index;
            --left;
        }
    }
}

} // namespace

Simplified simplify(const Ground& ground, std::int32_t block_cells, std::size_t block_vertices) {
    Simplifier all(ground);
    for (std::int32_t cells = std::min(block_cells, ground.side);; cells *= 2) {
        const std::size_t vertices = cells == ground.side ? 0 : block_vertices;
        for (std::int32_t row = 0; row < ground.side; row += cells)
            for (std::int32_t column = 0; column < ground.side; column += cells)
                all.block(column, row, cells, vertices);
        if (cells == ground.side) return std::move(all.done);
    }
}

} // namespace fjell::rivals
