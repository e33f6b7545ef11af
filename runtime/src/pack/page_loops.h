// The loops that decoding a page of one step consists of, in the machine's vectors; and each once more one vertex at a
// time, which says what they do, runs where there are no vectors, and is what tests compare with. All arithmetic is in
// integers: they agree bit for bit.
//
// They trust their arguments: unpack_page has checked every length.
#pragma once

#include <cstddef>
#include <cstdint>

#include "shared/page.h"
#include "shared/record.h"

namespace fjell {

// A step page's planes: centres, side_x, side_y.
inline constexpr std::uint32_t first_side_x = page_squares * page_squares,
                               first_side_y = first_side_x + page_squares * page_corners;

// Heights of a step page from the differences that it stores: max_page_vertices low bytes, and as many high ones or
// null. Differences are modulo 2^16, folded so that small ones of either sign are small numbers.
void restore_heights(const std::byte* low, const std::byte* high, std::uint16_t* heights);
void restore_heights_scalar(const std::byte* low, const std::byte* high, std::uint16_t* heights);

// One coarser step's planes over a page of step 1: from square (i0, j0) of the page that holds them on.
struct StepRows {
    const VertexRecord* records; // of the step
    std::int32_t base;
    std::uint32_t side; // squares of the page
    PageOrder order;    // not linear
    std::uint32_t i0, j0;

    [[nodiscard]] std::uint32_t index(VertexKind kind, std::uint32_t i, std::uint32_t j) const {
        return order == PageOrder::planar ? page_index<PageOrder::planar>(side, kind, i0 + i, j0 + j)
                                          : page_index<PageOrder::hierarchical_z>(side, kind, i0 + i, j0 + j);
    }
    [[nodiscard]] std::int32_t steps(VertexKind kind, std::uint32_t i, std::uint32_t j) const {
        return base + records[index(kind, i, j)].height;
    }
};
// Heights of the corners of a page's squares: the page's own (north-west, north-east, south-west, south-east) and what
// the planes of steps 32, 16, 8, 4 and 2 hold between them. Read as the frame's thread may: without regard for others.
void refine_corners(const std::int32_t (&own)[4], const StepRows (&rows)[page_squares_log2], CornerSteps& corners);
void refine_corners_scalar(const std::int32_t (&own)[4], const StepRows (&rows)[page_squares_log2],
                           CornerSteps& corners);

// Radii of a step page's vertices from the page_radii codes that it stores (page.h has the former).
void expand_radii_scalar(const std::uint8_t* stored, std::uint8_t* radii);

// derive_errors (page.h) is this.
void leaf_errors(const CornerSteps& corners, std::uint32_t nesting_steps, const LeafErrors& leaf, PageArrays& page);
void leaf_errors_scalar(const CornerSteps& corners, std::uint32_t nesting_steps, const LeafErrors& leaf,
                        PageArrays& page);

// The first `count` vertices as records, in order, for readers of other threads (pack/publish.h).
void write_page(const PageArrays& page, std::uint32_t count, VertexRecord* to);
void write_page_scalar(const PageArrays& page, std::uint32_t count, VertexRecord* to);
// The same in another order: at place i vertex vertex_at[i].
void write_permuted(const PageArrays& page, std::uint32_t count, const std::uint16_t* vertex_at, VertexRecord* to);

[[nodiscard]] inline std::uint32_t packed_record(const PageArrays& page, std::uint32_t vertex) {
    return static_cast<std::uint32_t>(page.heights[vertex]) | static_cast<std::uint32_t>(page.errors[vertex]) << 16 |
           static_cast<std::uint32_t>(page.radii[vertex]) << 24;
}

// Of leaf_errors(): errors of the vertices whose jump (|2 h - a - b|) was cut off at the table's end.
void far_errors(const CornerSteps& corners, const LeafErrors& leaf, const std::uint16_t* jump, PageArrays& page);

} // namespace fjell
