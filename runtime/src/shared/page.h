// A page between its bytes and its records. Shared by the runtime, which decodes, and the baker, which encodes and must
// know what a reader will make of it.
//
// Arrays are in the page's canonical order: planar for both orders by levels (records of hierarchical Z-order are
// permuted last), row by row for linear order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/pack.h"
#include "fjell/status.h"
#include "shared/order.h"
#include "shared/record.h"

namespace fjell {

struct PageArrays {
    std::int32_t base;   // height scale steps that heights are counted from
    bool errors_derived; // errors[] is not set: derive_errors
    std::uint16_t heights[max_page_vertices];
    std::uint8_t errors[max_page_vertices];
    std::uint8_t radii[max_page_vertices]; // with void_bit
};

// How heights are predicted: a page's centres from three neighbours, its sides from the centres beside them. Other
// pages are rows of `row` vertices, or one row for 0.
[[nodiscard]] inline bool is_step_page(const PageLayout& pages, std::uint32_t page) {
    return pages.page_step_log2(page) >= 0;
}
[[nodiscard]] inline std::uint32_t row_length(const PageLayout& pages) {
    return pages.order == PageOrder::linear ? pages.side() + 1 : 0;
}

// raw: a decompressed page, any bytes. Fails with corrupt when sizes or values cannot be.
Status unpack_page(const PageLayout& pages, std::uint32_t page, std::span<const std::byte> raw, PageArrays& out);

// Expands the radii that a page stores to its vertices.
void expand_radii(const std::uint8_t* stored, std::uint8_t* radii);

// Errors of the finest step follow from heights. A side's is the jump when it comes in: half |2 h - a - b| between the
// ends of its side; a centre's that across its diagonal, or what its sides ask of it. k: |2 h - a - b|, in height scale
// steps.
class LeafErrors {
public:
    LeafErrors() = default;
    LeafErrors(const ErrorScale& scale, float quantum_m);
    [[nodiscard]] std::uint8_t code(std::uint32_t k) const { return k < table_size ? table_[k] : far_code(k); }
    [[nodiscard]] const std::uint8_t* table() const { return table_; } // codes of k < table_size
    static constexpr std::uint32_t table_size = 4096;

private:
    [[nodiscard]] std::uint8_t far_code(std::uint32_t k) const;
    ErrorScale scale_;
    double half_quantum_m_ = 0.5;
    std::uint8_t table_[table_size] = {};
};

// Heights, in height scale steps, of the 33 x 33 corners of a page's squares, row by row.
inline constexpr std::uint32_t page_corners = page_squares + 1;
using CornerSteps = std::int32_t[page_corners * page_corners];

// Fills page.errors of a page of step 1.
void derive_errors(const CornerSteps& corners, const ErrorScale& scale, const LeafErrors& leaf, PageArrays& page);

} // namespace fjell
