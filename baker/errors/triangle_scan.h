// Vertices of one row against the samples under their triangles: the inner loop of estimate 1.
#pragma once

#include <cstddef>
#include <cstdint>

#include "baker/store/memory.h"
#include "shared/tree.h"

namespace fjell::baker {

// `count` vertices of one plane, 2s samples apart. before: the triangles north of sides along x, west of sides along y;
// after: those south or east of them. Centres are squares: the first is cut from north-west to south-east or not, and
// every further one the other way where `alternate` says so.
struct VertexRow {
    const std::int32_t* first; // its height in steps; up to `scan_slack` heights past the triangles are read
    std::ptrdiff_t stride;     // from row to row of samples
    std::int32_t s, count;
    VertexKind kind;
    bool before = true, after = true;
    bool falling = true, alternate = true;
};
inline constexpr std::size_t scan_slack = 64;

// worst[i]: the largest |2s (h - plane)| of vertex i, exact as long as heights under a triangle span less than
// 2^30 / 2s steps. The second one is the same, without vectors.
void scan_row(const VertexRow& row, std::int32_t* worst);
void scan_row_scalar(const VertexRow& row, std::int32_t* worst);

// Where triangles are small their rows do not fill a vector: then neighbouring vertices go side by side. For that the
// samples lie by their column modulo the vertices' distance `period` = 2s, s = 2, 4 or 8.
struct DeinterleavedSamples {
    std::int32_t period = 0, columns = 0,
                 rows = 0;       // columns: periods of a row, with the one that its last sample begins
    Buffer<std::int32_t> values; // not cleared: rows * period lines of columns + scan_slack

    // samples: the first of rows x (periods * period + 1) of them.
    static DeinterleavedSamples of(const std::int32_t* samples, std::ptrdiff_t stride, std::int32_t periods,
                                   std::int32_t rows, std::int32_t period);
    // Samples x0 + i * period + column, i = 0, 1, ..., of a row; column: -period .. 2 * period - 1.
    template <std::int32_t of_period>
    [[nodiscard]] const std::int32_t* line_of(std::int32_t column, std::int32_t row) const {
        const std::int32_t turn = column < 0 ? -1 : column >= of_period ? 1 : 0;
        const std::size_t at = (static_cast<std::size_t>(row) * static_cast<std::size_t>(of_period) +
                                static_cast<std::size_t>(column - turn * of_period)) *
                               length();
        return values.data() + front + at + turn;
    }
    [[nodiscard]] std::size_t length() const { return static_cast<std::size_t>(columns) + scan_slack; }
    static constexpr std::size_t front = 1; // for column -period of the first line
};
// The same as scan_row, for all vertices of a row at row `y` of the phases, counted from the first one's column on:
// sides along y at column 0, others at column s. Halves that lie outside are left out of the first and last side along
// y: `open_west`, `open_east` say that they do not. worst: room for scan_slack more.
struct SmallRow {
    const DeinterleavedSamples& samples;
    std::int32_t y, count;
    VertexKind kind;
    bool before = true, after = true;          // of sides along x
    bool open_west = false, open_east = false; // of sides along y
    bool falling = true, alternate = true;
};
void scan_small_row(const SmallRow& row, std::int32_t* worst);

} // namespace fjell::baker
