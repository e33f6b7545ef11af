// The way down to a point: which vertices split the triangles over it, found without reading any.
//
// A triangle's half that has the point follows from their places alone, as do the pages that hold its vertices. So the
// whole way is worked out in whole numbers first, without a branch that depends on the point, and memory is asked for
// all records at once: read one after the other, each would be waited for by itself.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "query/reader.h"

namespace fjell::query {

// place_of() for vertices that are known to be of one step, a centre or the middle of a side, for both orders by
// levels. What the step alone decides is worked out once, and no branch depends on where a vertex lies: descents go
// left or right as it comes.
template <PageOrder O>
class StepPlaces {
public:
    StepPlaces(const PageLayout& pages, int z)
        : step_(pages.step_layout(z)), shift_(z + 1), page_log2_(std::countr_zero(step_.page_side)),
          last_((1u << step_.pages_log2) - 1) {}

    // x, y: in the tile. along_y: 1 where the side runs along y.
    [[nodiscard]] PagePlace centre(std::uint32_t x, std::uint32_t y) const {
        return place(VertexKind::centre, 0, 0, x, y);
    }
    [[nodiscard]] PagePlace side(std::uint32_t along_y, std::uint32_t x, std::uint32_t y) const {
        const std::uint32_t n = step_.page_side;
        return place(along_y != 0 ? VertexKind::side_y : VertexKind::side_x, n * n + (n * (n + 1) & (0 - along_y)),
                     along_y, x, y);
    }

private:
    // Planar (page_index<PageOrder::planar>): of a plane that begins at `first` and whose rows are `wider` than the
    // page's squares.
    [[nodiscard]] PagePlace place(VertexKind kind, std::uint32_t first, std::uint32_t wider, std::uint32_t x,
                                  std::uint32_t y) const {
        const std::uint32_t i = x >> shift_, j = y >> shift_;
        const std::uint32_t px = std::min(i >> page_log2_, last_), py = std::min(j >> page_log2_, last_);
        const std::uint32_t in_x = i - (px << page_log2_), in_y = j - (py << page_log2_);
        if constexpr (O == PageOrder::hierarchical_z)
            return {step_.first_page + interleave(px, py),
                    step_.offset + page_index<O>(step_.page_side, kind, in_x, in_y)};
        return {step_.first_page + (py << step_.pages_log2) + px,
                step_.offset + first + in_y * (step_.page_side + wider) + in_x};
    }

    StepLayout step_;
    int shift_, page_log2_;
    std::uint32_t last_; // page of a row
};

// Choices on the way down are made by masks, all bits or none: every second branch would be mispredicted.
[[nodiscard]] inline std::uint32_t mask_if(bool condition) {
    return 0 - static_cast<std::uint32_t>(condition);
}
[[nodiscard]] inline std::uint32_t choose(std::uint32_t mask, std::uint32_t a, std::uint32_t b) {
    return b ^ ((a ^ b) & mask);
}
struct Spot { // a sample of the tile
    std::uint32_t x, y;
};
[[nodiscard]] inline Spot choose(std::uint32_t mask, Spot a, Spot b) {
    return {choose(mask, a.x, b.x), choose(mask, a.y, b.y)};
}
[[nodiscard]] inline Spot middle(Spot a, Spot b) {
    return {(a.x + b.x) / 2, (a.y + b.y) / 2};
}

// A point as the way down sees it. All lines that it could cross are x, y, x - y or x + y = a whole number, so it is
// enough to know where each of the four is among whole numbers: twice that number, or odd between two. In the tile,
// modulo 2^32. Told from what is left of x and y in their cell, which is exact where x + y would be rounded.
struct PointHalves {
    std::uint32_t x, y, difference, sum;
    PointHalves(Point p, SampleIndex origin) { // p: not negative
        const auto column = static_cast<std::int32_t>(p.x), row = static_cast<std::int32_t>(p.y);
        const double u = p.x - column, v = p.y - row, rest = 1 - v;
        const auto x0 = 2 * static_cast<std::uint32_t>(column - origin.column),
                   y0 = 2 * static_cast<std::uint32_t>(row - origin.row);
        const auto one_if = [](bool condition) { return static_cast<std::uint32_t>(condition); };
        x = x0 + one_if(u > 0);
        y = y0 + one_if(v > 0);
        difference = x0 - y0 + one_if(u > v) - one_if(u < v);
        sum = x0 + y0 + (one_if(u > 0) | one_if(v > 0)) + one_if(u >= rest) + one_if(u > rest);
    }
    // All bits: in the half that has b, or on the border between both. The line that splits the triangle runs from a
    // through m. First where it is a diagonal, then where it runs along an axis.
    [[nodiscard]] std::uint32_t half_of_square(Spot a, Spot b, Spot m) const {
        const std::uint32_t dx = m.x - a.x, falling = mask_if(dx == m.y - a.y);
        const std::uint32_t beyond = choose(falling, difference - 2 * (a.x - a.y), sum - 2 * (a.x + a.y));
        const std::uint32_t sign = (0 - (dx >> 31)) ^ ~mask_if(b.y == a.y); // further along x, toward b or away from it
        return ~(0 - (((beyond ^ sign) - sign) >> 31));
    }
    [[nodiscard]] std::uint32_t half_of_quarter(Spot a, Spot b, std::uint32_t along_y) const {
        const std::uint32_t mask = 0 - along_y, beyond = choose(mask, y - 2 * a.y, x - 2 * a.x);
        const std::uint32_t sign = 0 - (choose(mask, b.y - a.y, b.x - a.x) >> 31);
        return ~(0 - (((beyond ^ sign) - sign) >> 31));
    }
};

// The vertices that split the triangles over a point, from one that is half of a square (its hypotenuse the diagonal)
// downwards, two a step: the square's centre, then the middle of the side that the point lies at. The point alone
// decides which they are, so all are known, and asked of memory, before the first is read.
struct Way {
    static constexpr std::uint32_t given = 3; // the triangle itself: its right angle, ends[0] and ends[1]
    Spot spot[given + 2 * max_tile_log2];
    PagePlace at[given + 2 * max_tile_log2];
    std::uint32_t half[given + 2 * max_tile_log2]; // mask: of the triangle that it splits, the one with ends[0]
    std::uint32_t end = given;
};
// spot[0] to spot[2] are set. O(levels).
template <PageOrder O>
inline void find_way(const PageLayout& pages, const Reader& reader, Point p, Way& way) {
    const PointHalves point(p, reader.origin());
    Spot a = way.spot[0], b = way.spot[1], c = way.spot[2];
    std::uint32_t k = Way::given;
    const auto split = [&](Spot m, PagePlace at, std::uint32_t half) {
        way.spot[k] = m;
        way.at[k] = at;
        way.half[k++] = half;
        reader.prefetch(at);
        b = choose(half, b, c);
        c = a;
        a = m;
    };
    for (int z = std::countr_zero(b.x - c.x) - 1; z >= 0; --z) {
        const StepPlaces<O> step(pages, z);
        const Spot centre = middle(b, c);
        split(centre, step.centre(centre.x, centre.y), point.half_of_square(a, b, centre));
        const Spot side = middle(b, c);
        const auto along_y = static_cast<std::uint32_t>(b.x == c.x);
        split(side, step.side(along_y, side.x, side.y), point.half_of_quarter(a, b, along_y));
    }
    way.end = k;
}

} // namespace fjell::query
