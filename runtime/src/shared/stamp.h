// What a stamp (fjell/edit.h) makes of one sample: for the terrain that is flown, and for the baker.
#pragma once

#include <algorithm>
#include <cstdint>

#include "fjell/edit.h"
#include "shared/terrain_data.h"

namespace fjell::edit {

// Places [x0, x1] by [y0, y1].
struct Rect {
    std::int32_t x0 = 0, y0 = 0, x1 = -1, y1 = -1;
    [[nodiscard]] bool empty() const { return x1 < x0 || y1 < y0; }
    [[nodiscard]] std::int32_t columns() const { return x1 - x0 + 1; }
    [[nodiscard]] std::int32_t rows() const { return y1 - y0 + 1; }
    [[nodiscard]] bool contains(SampleIndex v) const {
        return v.column >= x0 && v.column <= x1 && v.row >= y0 && v.row <= y1;
    }
    [[nodiscard]] bool contains(const Rect& r) const { return r.x0 >= x0 && r.x1 <= x1 && r.y0 >= y0 && r.y1 <= y1; }
    [[nodiscard]] bool meets(const Rect& r) const { return x0 <= r.x1 && r.x0 <= x1 && y0 <= r.y1 && r.y0 <= y1; }
    [[nodiscard]] Rect grown(std::int32_t by) const { return {x0 - by, y0 - by, x1 + by, y1 + by}; }
    [[nodiscard]] Rect within(const Rect& r) const {
        return {std::max(x0, r.x0), std::max(y0, r.y0), std::min(x1, r.x1), std::min(y1, r.y1)};
    }
    [[nodiscard]] Rect with(const Rect& r) const {
        if (empty()) return r;
        if (r.empty()) return *this;
        return {std::min(x0, r.x0), std::min(y0, r.y0), std::max(x1, r.x1), std::max(y1, r.y1)};
    }
};

// What a stamp has to know of the field of samples that it changes; a baker's need be no terrain.
struct StampGrid {
    std::int32_t columns = 0, rows = 0;
    double spacing_m[2] = {1, 1};

    StampGrid(std::int32_t c, std::int32_t r, const double (&spacing)[2])
        : columns(c), rows(r), spacing_m{spacing[0], spacing[1]} {}
    StampGrid(const TerrainData& t) : StampGrid(t.tree.columns(), t.tree.rows(), t.header.spacing_m) {}
};

// Samples that a stamp may change, within the field.
[[nodiscard]] Rect samples_of(const StampGrid& grid, const Stamp& stamp);

// Can it change a sample in this part of them? Told by distances; may say yes where it does not.
[[nodiscard]] bool may_change(const StampGrid& grid, const Stamp& stamp, const Rect& samples);

// What the sample's neighbourhood looks like to a stamp: heights in metres.
struct Surroundings {
    double height_m; // now
    double pack_m;   // in the pack
    double mean_m;   // of it and its eight neighbours, for `smooth`
};
// The new height in metres; NaN: as it is.
[[nodiscard]] double stamped_m(const StampGrid& grid, const Stamp& stamp, SampleIndex sample, const Surroundings& now);

// How much of a stamp applies to a sample, 0 to 1: by distance and mask. Not of a crater, whose rim lies outside.
[[nodiscard]] double stamp_weight(const StampGrid& grid, const Stamp& stamp, SampleIndex sample);

[[nodiscard]] constexpr bool paints(StampShape shape) {
    return shape == StampShape::paint || shape == StampShape::unpaint;
}

[[nodiscard]] constexpr bool locks(StampShape shape) {
    return shape == StampShape::lock || shape == StampShape::unlock;
}
// All others leave heights and holes as they are.
[[nodiscard]] constexpr bool moves_ground(StampShape shape) {
    return !paints(shape) && !locks(shape);
}
// Of a sample in samples_of() a stamp that locks, or unlocks: does it? It reaches a cell's diagonal beyond its radius.
// What is drawn differs from the full resolution by an amount that is linear over each of the finest triangles, so what
// holds at their corners holds between them.
[[nodiscard]] bool locks_sample(const StampGrid& grid, const Stamp& stamp, SampleIndex sample);

// What it makes of a sample's being a hole: nothing, or ground, or a hole, or what it is in the pack.
enum class HoleChange : std::uint8_t { none, fill, cut, as_in_pack };
[[nodiscard]] HoleChange hole_change(const StampGrid& grid, const Stamp& stamp, SampleIndex sample);
[[nodiscard]] inline bool makes_or_fills_holes(StampShape shape) {
    return shape == StampShape::hole || shape == StampShape::fill;
}

} // namespace fjell::edit
