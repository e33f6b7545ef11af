// Decoding is a handful of loops over short rows that the compiler turns into vector code; the speed that docs/notes/
// records.md promises rests on that, not on intrinsics.
#include "pack/page.h"

#include "asserts.h"
#include "pack/clones.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>

namespace fjell {

namespace {

constexpr std::uint32_t n = page_squares;
constexpr std::uint32_t first_side_x = n * n, first_side_y = first_side_x + n * (n + 1);

// Residuals are differences modulo 2^16, folded so that small ones of either sign are small numbers.
[[gnu::always_inline]] inline void read_residuals(const std::byte* low, const std::byte* high, std::uint32_t count,
                                                  std::uint16_t* out) {
    const auto unfold = [](std::uint32_t folded) {
        return static_cast<std::uint16_t>((folded >> 1) ^ (0u - (folded & 1)));
    };
    if (high)
        for (std::uint32_t i = 0; i < count; ++i)
            out[i] = unfold(std::to_integer<std::uint32_t>(low[i]) | std::to_integer<std::uint32_t>(high[i]) << 8);
    else
        for (std::uint32_t i = 0; i < count; ++i) out[i] = unfold(std::to_integer<std::uint32_t>(low[i]));
}

// Residuals to heights, in place; all arithmetic modulo 2^16. A centre is predicted as west + north - north-west, which
// makes a row the one before it plus a running sum.
[[gnu::always_inline]] inline void undo_prediction(std::uint16_t* h) {
    const auto add = [](std::uint16_t& to, std::uint32_t what) { to = static_cast<std::uint16_t>(to + what); };
    for (std::uint32_t j = 0; j < n; ++j) {
        std::uint16_t* const row = h + j * n;
        std::uint32_t sum = row[0];
        for (std::uint32_t i = 1; i < n; ++i) row[i] = static_cast<std::uint16_t>(sum += row[i]);
    }
    for (std::uint32_t i = n; i < n * n; ++i) add(h[i], h[i - n]);
    for (std::uint32_t j = 0; j <= n; ++j) {
        std::uint16_t* const row = h + first_side_x + j * n;
        const std::uint16_t* const north = h + (j == 0 ? 0 : j - 1) * n;
        const std::uint16_t* const south = h + (j == n ? n - 1 : j) * n;
        for (std::uint32_t i = 0; i < n; ++i)
            add(row[i], (static_cast<std::uint32_t>(north[i]) + static_cast<std::uint32_t>(south[i])) >> 1);
    }
    for (std::uint32_t j = 0; j < n; ++j) {
        std::uint16_t* const row = h + first_side_y + j * (n + 1);
        const std::uint16_t* const centre = h + j * n;
        add(row[0], centre[0]);
        for (std::uint32_t i = 1; i < n; ++i)
            add(row[i], (static_cast<std::uint32_t>(centre[i - 1]) + static_cast<std::uint32_t>(centre[i])) >> 1);
        add(row[n], centre[n - 1]);
    }
}

// The same for rows of a raster, or one long row.
void undo_rows(std::uint16_t* h, std::uint32_t count, std::uint32_t row) {
    for (std::uint32_t i = 1; i < count; ++i) {
        std::uint32_t predicted = h[i - 1];
        if (row != 0 && i > row) predicted += static_cast<std::uint32_t>(h[i - row]) - h[i - row - 1];
        h[i] = static_cast<std::uint16_t>(h[i] + predicted);
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

namespace {

// A plane of `rows` rows of `stride` vertices from one code for each 4 x 4: a line is made once and copied. The last
// column of 33 has a code of its own.
template <std::uint32_t Stride>
void expand_plane(const std::uint8_t* stored, std::uint32_t rows, std::uint8_t* to) {
    constexpr std::uint32_t size = 1u << radius_squares_log2, blocks = n / size;
    std::uint8_t line[n + size];
    for (std::uint32_t j = 0; j < rows; ++j, to += Stride) {
        if (j % size == 0) {
            for (std::uint32_t b = 0; b < blocks + Stride - n; ++b) std::memset(line + b * size, stored[b], size);
            stored += blocks + Stride - n;
        }
        std::memcpy(to, line, Stride);
    }
}

} // namespace

void expand_radii(const std::uint8_t* stored, std::uint8_t* radii) {
    constexpr std::uint32_t blocks = n >> radius_squares_log2;
    expand_plane<n>(stored, n, radii);
    expand_plane<n>(stored + blocks * blocks, n + 1, radii + first_side_x);
    expand_plane<n + 1>(stored + blocks * (2 * blocks + 1), n, radii + first_side_y);
}

FJELL_CLONES Status unpack_page(const PageLayout& pages, std::uint32_t page, std::span<const std::byte> raw,
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

    read_residuals(low, high, count, out.heights);
    if (step_page)
        undo_prediction(out.heights);
    else
        undo_rows(out.heights, count, row_length(pages));
    if (errors) std::memcpy(out.errors, errors, count);
    const auto* const codes = reinterpret_cast<const std::uint8_t*>(radii);
    if (std::any_of(codes, codes + (step_page ? page_radii : count), [](std::uint8_t r) { return r >= radius_codes; }))
        return corrupt;
    if (step_page)
        expand_radii(codes, out.radii);
    else
        std::memcpy(out.radii, codes, count);
    if (holes)
        for (std::uint32_t i = 0; i < count; ++i)
            if ((std::to_integer<unsigned>(holes[i / 8]) >> (i % 8)) & 1) out.radii[i] |= void_bit;
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

// -1 at odd places.
constexpr auto odd_places = [] {
    std::array<std::int32_t, n + 1> mask{};
    for (std::uint32_t i = 1; i <= n; i += 2) mask[i] = -1;
    return mask;
}();

// |2 h - sum| of one row, cut off where the table ends. Answers with all of them or-ed together.
[[gnu::always_inline]] inline std::uint32_t jumps(std::int32_t base, const std::uint16_t* heights,
                                                  const std::int32_t* sums, std::uint32_t count, std::uint16_t* to) {
    std::uint32_t all = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto jump = static_cast<std::uint32_t>(std::abs(2 * (base + heights[i]) - sums[i]));
        all |= jump;
        to[i] = static_cast<std::uint16_t>(std::min(jump, LeafErrors::table_size - 1));
    }
    return all;
}

// Eight look-ups for one store.
[[gnu::always_inline]] inline void look_up(const std::uint8_t* table, const std::uint16_t* jump, std::uint32_t count,
                                           std::uint8_t* codes) {
    static_assert(max_page_vertices % 8 == 0);
    for (std::uint32_t i = 0; i < count; i += 8) {
        const std::uint8_t eight[8] = {table[jump[i]],     table[jump[i + 1]], table[jump[i + 2]], table[jump[i + 3]],
                                       table[jump[i + 4]], table[jump[i + 5]], table[jump[i + 6]], table[jump[i + 7]]};
        std::memcpy(codes + i, eight, sizeof eight);
    }
}

// A row of centres: what they say themselves, or what their sides ask of them. In loops of bytes, which the compiler
// does 16 or 32 at a time.
[[gnu::always_inline]] inline void raise(std::uint32_t nesting_steps, const std::uint8_t* x_north,
                                         const std::uint8_t* x_south, const std::uint8_t* side_y,
                                         std::uint8_t* centres) {
    const auto steps = static_cast<std::uint8_t>(nesting_steps), cap = static_cast<std::uint8_t>(255 - steps);
    const auto larger = [](std::uint8_t a, std::uint8_t b) { return a > b ? a : b; };
    std::uint8_t x[2][n], y[n + 1], own[n], child[n], least[n];
    std::memcpy(x[0], x_north, n);
    std::memcpy(x[1], x_south, n);
    std::memcpy(y, side_y, n + 1);
    std::memcpy(own, centres, n);
    for (std::uint32_t i = 0; i < n; ++i) child[i] = larger(x[0][i], x[1][i]);
    for (std::uint32_t i = 0; i < n; ++i) least[i] = larger(y[i], y[i + 1]);
    for (std::uint32_t i = 0; i < n; ++i) child[i] = larger(child[i], least[i]);
    for (std::uint32_t i = 0; i < n; ++i) least[i] = child[i] < cap ? child[i] : cap;
    for (std::uint32_t i = 0; i < n; ++i) least[i] = static_cast<std::uint8_t>(least[i] + steps);
    for (std::uint32_t i = 0; i < n; ++i) least[i] = child[i] == 0 ? 0 : least[i];
    for (std::uint32_t i = 0; i < n; ++i) least[i] = larger(least[i], own[i]);
    std::memcpy(centres, least, n);
}

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

FJELL_CLONES void derive_errors(const CornerSteps& corners, const ErrorScale& scale, const LeafErrors& leaf,
                                PageArrays& page) {
    constexpr std::uint32_t w = page_corners;
    const std::uint16_t* const h = page.heights;
    std::uint8_t* const e = page.errors;
    std::int32_t sums[max_page_vertices];
    std::uint16_t jump[max_page_vertices];
    for (std::uint32_t j = 0; j <= n; ++j) {
        const std::int32_t* const row = corners + j * w;
        std::int32_t* const to = sums + first_side_x + j * n;
        for (std::uint32_t i = 0; i < n; ++i) to[i] = row[i] + row[i + 1];
    }
    for (std::uint32_t j = 0; j < n; ++j) {
        const std::int32_t* const north = corners + j * w;
        const std::int32_t* const south = north + w;
        for (std::uint32_t i = 0; i < w; ++i) sums[first_side_y + j * w + i] = north[i] + south[i];
        const std::int32_t* const odd = odd_places.data() + (j & 1);
        for (std::uint32_t i = 0; i < n; ++i) { // see diamond(): odd squares are cut from south-west to north-east
            const std::int32_t falling = north[i] + south[i + 1], rising = south[i] + north[i + 1];
            sums[j * n + i] = falling ^ ((falling ^ rising) & odd[i]);
        }
    }
    const std::uint32_t all = jumps(page.base, h, sums, max_page_vertices, jump);
    look_up(leaf.table(), jump, max_page_vertices, e);
    if (all >= LeafErrors::table_size) // far ones, which no table holds
        for (std::uint32_t i = 0; i < max_page_vertices; ++i)
            if (jump[i] == LeafErrors::table_size - 1)
                e[i] = leaf.code(static_cast<std::uint32_t>(std::abs(2 * (page.base + h[i]) - sums[i])));
    for (std::uint32_t j = 0; j < n; ++j)
        raise(scale.nesting_steps, e + first_side_x + j * n, e + first_side_x + (j + 1) * n, e + first_side_y + j * w,
              e + j * n);
    FJELL_ASSERT(are_nested(scale, e));
}

} // namespace fjell
