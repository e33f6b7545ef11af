// The finest triangle that is there under a point.
#pragma once

#include "query/ground.h"

namespace fjell::query {

struct Found {
    Plane plane;
    double error_m = 0;
    bool hole = false, finest = false;
};

// The same from any triangle downwards.
[[nodiscard]] inline Found find_below(const Terrain& t, Reader& reader, Triangle triangle, Point p, float accurate_m) {
    const auto found = [&](double error_m, bool finest) {
        return Found{plane_of(triangle.apex, triangle.ends[0], triangle.ends[1]), error_m, triangle.hole(), finest};
    };
    while (!triangle.leaf()) {
        const Coord m = triangle.middle();
        const Sample sample = reader.read(m);
        if (!sample.loaded) return found(triangle.bound_m, triangle.bound_m == 0);
        if (suffices(t, triangle, sample.error, accurate_m)) return found(error_m(t, sample.error), sample.error == 0);
        triangle = triangle.half({m, sample.steps, sample.hole}, triangle.half_of(p), below_m(t, sample.error));
    }
    return found(0, true);
}

// p: in the tile, within the terrain. O(levels).
[[nodiscard]] inline Found find_ground(const Terrain& t, Reader& reader, Point p, float accurate_m) {
    Square s = root_square(t, reader);
    if (!cut_by_rim(t, s.nw, s.side)) return find_below(t, reader, s.half(s.half_of(p)), p, accurate_m);
    for (;;) { // never satisfied in a square that is cut: its halves do not nest
        const Sample sample = reader.read(s.centre());
        if (!sample.loaded) {
            const Triangle half = s.half(s.half_of(p));
            return {plane_of(half.apex, half.ends[0], half.ends[1]), s.bound_m + spread_m(t, s), half.hole(), false};
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
        if (q.flat[i])
            return {plane_of(half.apex, half.ends[0], half.ends[1]), q.error_m[i], half.hole(), false};
        return find_below(t, reader, half, p, accurate_m);
    }
}

// The tile over a point of the terrain.
[[nodiscard]] inline Coord tile_of(const Terrain& t, Point p) {
    const std::int32_t side = t.tree.side();
    return {std::min(static_cast<std::int32_t>(p.x) / side, t.tree.tiles_x - 1),
            std::min(static_cast<std::int32_t>(p.y) / side, t.tree.tiles_y - 1)};
}

[[nodiscard]] inline double height_m(const Terrain& t, double steps) {
    return static_cast<double>(t.lattice.base_m) + steps * static_cast<double>(t.lattice.quantum_m);
}

} // namespace fjell::query
