#include "pack/page.h"

#include "asserts.h"
#include "compiler.h"
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

// A plane of n or fewer rows of `stride` vertices from one code for each 4 x 4: a line is made once and copied. The
// last column of 33 has a code of its own.
template <std::uint32_t Stride>
FJELL_ALWAYS_INLINE inline void expand_plane(const std::uint8_t* stored, std::uint32_t rows, std::uint8_t* to) {
    constexpr std::uint32_t size = 1u << radius_squares_log2, blocks = n / size;
    static_assert(size == sizeof(std::uint32_t));
    for (std::uint32_t j = 0; j < rows; j += size, stored += blocks + Stride - n) {
        std::uint32_t line[blocks];
        for (std::uint32_t b = 0; b < blocks; ++b) line[b] = stored[b] * 0x01010101u;
        for (std::uint32_t k = j; k < std::min(j + size, rows); ++k, to += Stride) {
            std::memcpy(to, line, n);
            if constexpr (Stride > n) to[n] = stored[blocks];
        }
    }
}

// Clones are of this source alone: a shared library shows others to its hosts, hidden or not (g++ 12).
FJELL_CLONES void expand_codes(const std::uint8_t* stored, std::uint8_t* radii) {
    constexpr std::uint32_t blocks = n >> radius_squares_log2;
    expand_plane<n>(stored, n, radii);
    expand_plane<n>(stored + blocks * blocks, n + 1, radii + first_side_x);
    expand_plane<n + 1>(stored + blocks * (2 * blocks + 1), n, radii + first_side_y);
}

FJELL_CLONES Status unpack(const PageLayout& pages, std::uint32_t page, std::span<const std::byte> raw,
                           PageArrays& out) {
    const Status corrupt{Code::corrupt, "geometry page"};
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
        expand_codes(codes, out.radii);
    else
        std::memcpy(out.radii, codes, count);
    if (holes)
        for (std::uint32_t i = 0; i < count; ++i)
            out.radii[i] |=
                static_cast<std::uint8_t>(((std::to_integer<unsigned>(holes[i / 8]) >> (i % 8)) & 1) * void_bit);
    return {};
}

} // namespace

void expand_radii(const std::uint8_t* stored, std::uint8_t* radii) {
    expand_codes(stored, radii);
}

Status unpack_page(const PageLayout& pages, std::uint32_t page, std::span<const std::byte> raw, PageArrays& out) {
    return unpack(pages, page, raw, out);
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
