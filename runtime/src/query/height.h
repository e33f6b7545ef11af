// The finest triangle that is there under a point.
#pragma once

#include "query/ground.h"

namespace fjell::query {

struct Found {
    Plane plane;
    double error_m = 0;
    bool hole = false, finest = false;
};

// The same from any triangle downwards. Places and heights in plain variables: triangles that are copied at every level
// cost twice the time.
[[nodiscard]] inline Found find_below(const Terrain& t, Reader& reader, const Triangle& from, Point p,
                                      std::int32_t accurate) {
    Corner a = from.apex, b = from.ends[0], c = from.ends[1];
    std::int32_t bound = from.bound;
    const auto found = [&](std::int32_t code) {
        return Found{plane_of(a, b, c), error_m(t, code), a.hole || b.hole || c.hole, code == 0};
    };
    while (((b.at.x ^ c.at.x) & 1) == 0) {
        const Coord m{(b.at.x + c.at.x) / 2, (b.at.y + c.at.y) / 2};
        const Sample sample = reader.read(m);
        if (!sample.loaded) return found(bound);
        if (suffices(sample.error, accurate, a.hole || b.hole || c.hole)) return found(sample.error);
        bound = below(t, sample.error);
        // On the border between the halves: the first.
        const bool first = turn(a.at, m, p) * turn(a.at, m, b.at) >= 0;
        b.at.x = first ? b.at.x : c.at.x, b.at.y = first ? b.at.y : c.at.y;
        b.steps = first ? b.steps : c.steps, b.hole = first ? b.hole : c.hole;
        c.at.x = a.at.x, c.at.y = a.at.y, c.steps = a.steps, c.hole = a.hole;
        a.at.x = m.x, a.at.y = m.y, a.steps = sample.steps, a.hole = sample.hole;
    }
    return found(0);
}

// p: in the tile, within the terrain. O(levels).
[[nodiscard]] inline Found find_ground(const Terrain& t, Reader& reader, Point p, std::int32_t accurate) {
    Square s = root_square(t, reader);
    if (!cut_by_rim(t, s.nw, s.side)) return find_below(t, reader, s.half(s.half_of(p)), p, accurate);
    for (;;) { // never satisfied in a square that is cut: its halves do not nest
        const Sample sample = reader.read(s.centre());
        if (!sample.loaded) {
            const Triangle half = s.half(s.half_of(p));
            return {plane_of(half.apex, half.ends[0], half.ends[1]), error_m(t, s.bound) + spread_m(t, s), half.hole(),
                    false};
        }
        const Corner centre = corner_of(t, s.centre(), sample);
        const int k = quarter_at(t, centre.at, p);
        const Quarter q = quarter_of(t, reader, s, centre, sample.error, k);
        if (q.kind == Quarter::Kind::square) {
            s = q.square;
            continue;
        }
        const int i = q.half_of(p);
        const Triangle& half = q.half[i];
        if (q.flat[i]) return {plane_of(half.apex, half.ends[0], half.ends[1]), q.error_m[i], half.hole(), false};
        return find_below(t, reader, half, p, accurate);
    }
}

// The tile over a point of the terrain.
[[nodiscard]] inline Coord tile_of(const Terrain& t, Point p) {
    const std::int32_t side = t.tree.side();
    return {std::min(static_cast<std::int32_t>(p.x) / side, t.tree.tiles_x - 1),
            std::min(static_cast<std::int32_t>(p.y) / side, t.tree.tiles_y - 1)};
}

[[nodiscard]] inline double height_m(const Terrain& t, double steps) {
    return static_cast<double>(t.height_scale.base_m) + steps * static_cast<double>(t.height_scale.quantum_m);
}

} // namespace fjell::query
