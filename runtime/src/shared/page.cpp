#include "shared/page.h"

#include "asserts.h"
#include "pack/page_loops.h"

#include <algorithm>
#include <cstring>

namespace fjell {

namespace {

constexpr std::uint32_t n = page_squares;

// Heights of rows of a raster, or of one long row: differences are unfolded, and added to what is predicted from west,
// north and north-west.
void restore_rows(const std::byte* low, const std::byte* high, std::uint32_t count, std::uint32_t row,
                  std::uint16_t* h) {
    std::uint32_t west = 0; // all arithmetic is modulo 2^16 in the end
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t folded = std::to_integer<std::uint32_t>(low[i]) |
                                     (high != nullptr ? std::to_integer<std::uint32_t>(high[i]) << 8 : 0);
        const std::uint32_t north =
            row != 0 && i > row ? static_cast<std::uint32_t>(h[i - row]) - h[i - row - 1] : 0; // less north-west
        west += north + ((folded >> 1) ^ (0u - (folded & 1)));
        h[i] = static_cast<std::uint16_t>(west);
    }
}

// Hands out a page's arrays one after the other; null when the bytes end too early.
struct Cursor {
    std::span<const std::byte> left;
    const std::byte* take(std::size_t bytes) {
        if (bytes > left.size()) return nullptr;
        const std::byte* const at = left.data();
        left = left.subspan(bytes);
        return at;
    }
};

} // namespace

Status unpack_page(const PageLayout& pages, std::uint32_t page, std::span<const std::byte> raw, PageArrays& out) {
    const Status corrupt{StatusCode::corrupt, "geometry page"};
    const std::uint32_t count = pages.page_vertices(page);
    Cursor cursor{raw};
    PageHead head;
    const std::byte* const head_bytes = cursor.take(sizeof head);
    if (!head_bytes) return corrupt;
    std::memcpy(&head, head_bytes, sizeof head);
    const bool step_page = is_step_page(pages, page), wide = head.flags & page_wide, voids = head.flags & page_voids;
    if (head.flags > (page_wide | page_errors | page_voids) || (head.reserved[0] | head.reserved[1] | head.reserved[2]))
        return corrupt;
    if (head.base < 0 || head.base > max_height_steps - 65535) return corrupt;
    out.base = head.base;
    out.errors_derived = !(head.flags & page_errors);
    if (out.errors_derived && pages.page_step_log2(page) != 0) return corrupt;

    const std::byte* const low = cursor.take(count);
    const std::byte* const high = wide ? cursor.take(count) : nullptr;
    const std::byte* const errors = out.errors_derived ? nullptr : cursor.take(count);
    const std::byte* const radii = cursor.take(step_page ? page_radii : count);
    const std::byte* const holes = voids ? cursor.take((count + 7) / 8) : nullptr;
    if (!low || (wide && !high) || (!out.errors_derived && !errors) || !radii || (voids && !holes) ||
        !cursor.left.empty())
        return corrupt;

    if (step_page)
        restore_heights(low, high, out.heights);
    else
        restore_rows(low, high, count, row_length(pages), out.heights);
    if (errors) std::memcpy(out.errors, errors, count);
    const auto* const codes = reinterpret_cast<const std::uint8_t*>(radii);
    std::uint8_t all = 0; // or-ed together: one test for all of them, and nothing that ends the loop
    for (std::uint32_t i = 0; i < (step_page ? page_radii : count); ++i) all |= codes[i];
    if (all >= radius_codes) return corrupt;
    if (step_page)
        expand_radii(codes, out.radii);
    else
        std::memcpy(out.radii, codes, count);
    if (holes)
        for (std::uint32_t i = 0; i < count; ++i) {
            const auto eight = std::to_integer<unsigned>(holes[i / 8]);
            if (eight == 0)
                i |= 7; // most pages have few
            else if ((eight >> i % 8 & 1) != 0)
                out.radii[i] |= void_bit;
        }
    return {};
}

LeafErrors::LeafErrors(const ErrorScale& scale, float quantum_m)
    : scale_(scale), half_quantum_m_(0.5 * static_cast<double>(quantum_m)) {
    for (std::uint32_t k = 0; k < table_size; ++k) table_[k] = far_code(k);
}

std::uint8_t LeafErrors::far_code(std::uint32_t k) const {
    return scale_.code_up(half_quantum_m_ * k);
}

namespace {

// Invariant 2 within the page: what is derived nests, whatever the heights are.
[[maybe_unused]] bool are_nested(const ErrorScale& scale, const std::uint8_t* e) {
    for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint8_t* const x = e + first_side_x + j * n + i;
            const std::uint8_t* const y = e + first_side_y + j * (n + 1) + i;
            const std::uint8_t child = std::max({x[0], x[n], y[0], y[1]});
            if (e[j * n + i] < std::min(scale.above(child), 255u)) return false;
        }
    return true;
}

} // namespace

void derive_errors(const CornerSteps& corners, const ErrorScale& scale, const LeafErrors& leaf, PageArrays& page) {
    leaf_errors(corners, scale.nesting_steps, leaf, page);
    FJELL_ASSERT(are_nested(scale, page.errors));
}

} // namespace fjell
