// One step of the vertex tree over a region: errors and radii of its centres and sides, from their unsaturated errors
// and from the centres of the finer step (thesis 5.3.2, leaves to root; invariant 2).
//
// Squares of side 2s, s = 2^z, are counted over the whole terrain; a region has nx x ny of them from `square` on. Its
// borders belong to it: side_x has ny + 1 rows, side_y nx + 1 columns. What a border vertex needs of the neighbours is
// in the arrays: one square more to the north and west, `reach` more to the south and east.
#pragma once

#include <cstdint>
#include <vector>

#include "baker/heights/region.h"
#include "baker/heights/scales.h"
#include "shared/page.h"
#include "shared/tree.h"

namespace fjell::baker {

// Radii of steps that are cut into pages are shared by blocks of 4 x 4 squares; those of a border lie in the next
// region's.
inline constexpr std::int32_t reach = 1 << radius_squares_log2;

// One value a square, for squares -1 .. nx + reach by -1 .. ny + reach of a region.
template <typename T>
struct VertexPlane {
    std::int32_t stride = 0;
    Buffer<T> values; // not cleared

    VertexPlane() = default;
    VertexPlane(std::int32_t nx, std::int32_t ny)
        : stride(nx + reach + 2), values(static_cast<std::size_t>(stride) * static_cast<std::size_t>(ny + reach + 2)) {}
    [[nodiscard]] T* row(std::int32_t j) { return values.data() + (j + 1) * stride + 1; } // at column 0
    [[nodiscard]] const T* row(std::int32_t j) const { return values.data() + (j + 1) * stride + 1; }
};

// By place in the square: its north-west corner, the middle of its north side, of its west side, its centre.
template <typename T>
struct VertexPlanes {
    VertexPlane<T> corner, side_x, side_y, centre;

    VertexPlanes() = default;
    VertexPlanes(std::int32_t nx, std::int32_t ny) : corner(nx, ny), side_x(nx, ny), side_y(nx, ny), centre(nx, ny) {}
};
// Splits the patch of places of step s that begins at twice square (-1, -1) of the region.
template <typename T>
void split_planes(const Patch<T>& from, VertexPlanes<T>& to) {
    const std::int32_t columns = to.corner.stride;
    for (std::int32_t y = 0; y < from.rows; ++y) {
        const T* const row = from.values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(from.columns);
        T* const even = (y % 2 ? to.side_y : to.corner).row(y / 2 - 1) - 1;
        T* const odd = (y % 2 ? to.centre : to.side_x).row(y / 2 - 1) - 1;
        for (std::int32_t i = 0; i < columns; ++i) {
            even[i] = row[2 * i];
            odd[i] = row[2 * i + 1];
        }
    }
}

// Centres of the finer step, z - 1, twice as many a side: from twice square (-1, -1) of the region on. Those beyond the
// terrain have no error and no radius.
struct FinerCentres {
    std::int32_t stride = 0;
    Buffer<std::int32_t> steps;
    Buffer<std::uint8_t> error;
    Buffer<float> radius_m;

    FinerCentres() = default;
    FinerCentres(std::int32_t nx, std::int32_t ny);
    [[nodiscard]] std::size_t row(std::int32_t j) const { // of finer square (0, j)
        return static_cast<std::size_t>(j + 2) * static_cast<std::size_t>(stride) + 2;
    }
};

struct StepInput {
    const Scales& scales;
    Tree tree;
    double spacing_m[2] = {1, 1};
    int z = 0;
    SampleIndex square;
    std::int32_t nx = 0, ny = 0;
    const VertexPlanes<std::int32_t>& steps;
    VertexPlanes<std::uint8_t>& error;   // unsaturated; saturate_errors changes it in place
    const FinerCentres* finer = nullptr; // not for z == 0
};
// Radius codes, one for each 2^shift x 2^shift squares.
struct Radii {
    int shift = 0;
    std::int32_t blocks_x = 0, blocks_y = 0; // of centres; sides along x have one row more, along y one column more
    std::vector<std::uint8_t> side_x, side_y, centre;
    [[nodiscard]] std::uint8_t at(VertexKind kind, std::int32_t i, std::int32_t j) const {
        i >>= shift, j >>= shift;
        switch (kind) {
        case VertexKind::side_x: return side_x[static_cast<std::size_t>(j * blocks_x + i)];
        case VertexKind::side_y: return side_y[static_cast<std::size_t>(j * (blocks_x + 1) + i)];
        case VertexKind::centre: break;
        }
        return centre[static_cast<std::size_t>(j * blocks_x + i)];
    }
};
// Unsaturated errors of the finest step: half the surface's jump when the vertex is activated, by LeafErrors. Not at
// the rim or beside holes.
void leaf_errors(const StepInput& input, const LeafErrors& leaf);
// Errors: each at least its children's and a nesting step more. Radii: each sphere contains its children's. O(squares).
void saturate_errors(const StepInput& input);
void nest_radii(const StepInput& input, Radii& out);

} // namespace fjell::baker
