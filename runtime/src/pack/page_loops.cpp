// Highway compiles the vectors' part once for each instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pack/page_loops.cpp"
#include <hwy/foreach_target.h> // includes this file once a target

#include <hwy/highway.h>

#include <cstring>

#include "pack/page_loops.h"
#include "pack/publish.h"

HWY_BEFORE_NAMESPACE();
namespace fjell::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

void restore_heights_lanes(const std::byte* low, const std::byte* high, std::uint16_t* heights) {
    restore_heights_scalar(low, high, heights);
}
void refine_corners_lanes(const std::int32_t (&own)[4], const StepRows (&rows)[page_squares_log2],
                          CornerSteps& corners) {
    refine_corners_scalar(own, rows, corners);
}
void expand_radii_lanes(const std::uint8_t* stored, std::uint8_t* radii) {
    expand_radii_scalar(stored, radii);
}
void leaf_errors_lanes(const CornerSteps& corners, std::uint32_t nesting_steps, const LeafErrors& leaf,
                       PageArrays& page) {
    leaf_errors_scalar(corners, nesting_steps, leaf, page);
}
void write_page_lanes(const PageArrays& page, std::uint32_t count, VertexRecord* to) {
    write_page_scalar(page, count, to);
}

#else

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::uint32_t n = page_squares, w = page_corners;

// As many as a register holds, and a whole number of registers to a row of squares.
using Words = hn::CappedTag<std::uint16_t, n>;
using Steps = hn::CappedTag<std::int32_t, n>;
using Codes = hn::CappedTag<std::uint8_t, n>;
using Words8 = hn::FixedTag<std::uint16_t, 8>;

// Known at run time only where registers have no fixed length (SVE): there MaxLanes() is more than a register holds.
template <class D>
HWY_INLINE std::uint32_t lanes(D d) {
    return static_cast<std::uint32_t>(hn::Lanes(d));
}

// --- heights

// Differences from vertex i on, unfolded.
template <bool Wide, class D>
HWY_INLINE hn::Vec<D> differences(D d, const std::uint8_t* low, const std::uint8_t* high, std::uint32_t i) {
    const hn::Rebind<std::uint8_t, D> bytes;
    auto folded = hn::PromoteTo(d, hn::LoadU(bytes, low + i));
    if constexpr (Wide) folded = hn::Or(folded, hn::ShiftLeft<8>(hn::PromoteTo(d, hn::LoadU(bytes, high + i))));
    return hn::Xor(hn::ShiftRight<1>(folded), hn::Sub(hn::Zero(d), hn::And(folded, hn::Set(d, 1))));
}

template <class V>
HWY_INLINE V running_sum(V v) {
    const Words8 d;
    v = hn::Add(v, hn::ShiftLeftLanes<1>(d, v));
    v = hn::Add(v, hn::ShiftLeftLanes<2>(d, v));
    return hn::Add(v, hn::ShiftLeftLanes<4>(d, v));
}

// Centres are predicted as west + north - north-west. So a row is the running sum of all rows' differences down to it,
// and no row waits for the one before.
template <bool Wide>
HWY_INLINE void restore_centres(const std::uint8_t* low, const std::uint8_t* high, std::uint16_t* h) {
    static_assert(n == 32, "four registers a row");
    const Words8 d;
    auto a = hn::Zero(d), b = a, c = a, e = a;
    for (std::uint32_t i = 0; i < n * n; i += n) {
        a = hn::Add(a, differences<Wide>(d, low, high, i));
        b = hn::Add(b, differences<Wide>(d, low, high, i + 8));
        c = hn::Add(c, differences<Wide>(d, low, high, i + 16));
        e = hn::Add(e, differences<Wide>(d, low, high, i + 24));
        const auto first = running_sum(a);
        const auto second = hn::Add(running_sum(b), hn::Broadcast<7>(first));
        const auto third = hn::Add(running_sum(c), hn::Broadcast<7>(second));
        const auto fourth = hn::Add(running_sum(e), hn::Broadcast<7>(third));
        hn::StoreU(first, d, h + i);
        hn::StoreU(second, d, h + i + 8);
        hn::StoreU(third, d, h + i + 16);
        hn::StoreU(fourth, d, h + i + 24);
    }
}

// n sides from vertex i on, each between two centres: their mean, rounded down, plus the difference.
template <bool Wide>
HWY_INLINE void restore_sides(const std::uint8_t* low, const std::uint8_t* high, std::uint32_t i,
                              const std::uint16_t* one, const std::uint16_t* other, std::uint16_t* h) {
    const Words d;
    for (std::uint32_t k = 0; k < n; k += lanes(d)) {
        const auto p = hn::LoadU(d, one + k), q = hn::LoadU(d, other + k);
        const auto mean = hn::Add(hn::And(p, q), hn::ShiftRight<1>(hn::Xor(p, q)));
        hn::StoreU(hn::Add(mean, differences<Wide>(d, low, high, i + k)), d, h + i + k);
    }
}

template <bool Wide>
HWY_INLINE std::uint16_t difference(const std::uint8_t* low, const std::uint8_t* high, std::uint32_t i) {
    const std::uint32_t folded = low[i] | (Wide ? static_cast<std::uint32_t>(high[i]) << 8 : 0);
    return static_cast<std::uint16_t>((folded >> 1) ^ (0u - (folded & 1)));
}

template <bool Wide>
HWY_INLINE void restore(const std::uint8_t* low, const std::uint8_t* high, std::uint16_t* h) {
    restore_centres<Wide>(low, high, h);
    for (std::uint32_t j = 0; j <= n; ++j)
        restore_sides<Wide>(low, high, first_side_x + j * n, h + (j == 0 ? 0 : j - 1) * n, h + (j == n ? n - 1 : j) * n,
                            h);
    for (std::uint32_t j = 0; j < n; ++j) {
        const std::uint32_t first = first_side_y + j * w;
        const std::uint16_t* const centres = h + j * n;
        // The last lane reads what follows the row, which is in the array, and is put right below.
        restore_sides<Wide>(low, high, first + 1, centres, centres + 1, h);
        h[first] = static_cast<std::uint16_t>(centres[0] + difference<Wide>(low, high, first));
        h[first + n] = static_cast<std::uint16_t>(centres[n - 1] + difference<Wide>(low, high, first + n));
    }
}

void restore_heights_lanes(const std::byte* low, const std::byte* high, std::uint16_t* heights) {
    const auto* const l = reinterpret_cast<const std::uint8_t*>(low);
    if (high != nullptr)
        restore<true>(l, reinterpret_cast<const std::uint8_t*>(high), heights);
    else
        restore<false>(l, nullptr, heights);
}

// --- radii

// A plane of n or fewer rows of `Stride` vertices from one code for each 4 x 4. The last column of 33 has its own.
template <std::uint32_t Stride>
HWY_INLINE void expand_plane(const std::uint8_t* stored, std::uint32_t rows, std::uint8_t* to) {
    constexpr std::uint32_t size = 1u << radius_squares_log2, blocks = n / size;
    static_assert(size == 4 && blocks == sizeof(std::uint64_t), "the codes of a row fit a word");
    const hn::FixedTag<std::uint8_t, 16> d;
    const auto first = hn::ShiftRight<2>(hn::Iota(d, 0)), second = hn::Add(first, hn::Set(d, 4));
    for (std::uint32_t j = 0; j < rows; j += size, stored += blocks + Stride - n) {
        std::uint64_t eight;
        std::memcpy(&eight, stored, sizeof eight);
        const auto codes = hn::BitCast(d, hn::Set(hn::FixedTag<std::uint64_t, 2>(), eight));
        const auto west = hn::TableLookupBytes(codes, first), east = hn::TableLookupBytes(codes, second);
        for (std::uint32_t k = j; k < (j + size < rows ? j + size : rows); ++k, to += Stride) {
            hn::StoreU(west, d, to);
            hn::StoreU(east, d, to + n / 2);
            if constexpr (Stride > n) to[n] = stored[blocks];
        }
    }
}

void expand_radii_lanes(const std::uint8_t* stored, std::uint8_t* radii) {
    constexpr std::uint32_t blocks = n >> radius_squares_log2;
    expand_plane<n>(stored, n, radii);
    expand_plane<n>(stored + blocks * blocks, n + 1, radii + first_side_x);
    expand_plane<n + 1>(stored + blocks * (2 * blocks + 1), n, radii + first_side_y);
}

// --- corners

// Heights of a row of planar records.
template <class D>
HWY_INLINE hn::Vec<D> row_steps(D d, const VertexRecord* from, hn::Vec<D> base) {
    const auto records = hn::LoadU(d, reinterpret_cast<const std::int32_t*>(from));
    return hn::Add(base, hn::And(records, hn::Set(d, 0xffff)));
}

// One step finer: from the corners of Count x Count squares to those of twice as many a side, by the step's planes.
template <std::uint32_t Count>
HWY_INLINE void refine_step(const StepRows& rows, const std::int32_t* grid, std::int32_t* finer) {
    constexpr std::uint32_t width = 2 * Count + 1;
    const hn::CappedTag<std::int32_t, Count> d;
    const auto base = hn::Set(d, rows.base);
    const VertexRecord* side_x = rows.records + rows.index(VertexKind::side_x, 0, 0);
    const VertexRecord* side_y = rows.records + rows.index(VertexKind::side_y, 0, 0);
    const VertexRecord* centre = rows.records + rows.index(VertexKind::centre, 0, 0);
    for (std::uint32_t j = 0;; ++j) {
        for (std::uint32_t k = 0; k < Count; k += lanes(d))
            hn::StoreInterleaved2(hn::LoadU(d, grid + k), row_steps(d, side_x + k, base), d, finer + 2 * k);
        finer[2 * Count] = grid[Count];
        if (j == Count) return;
        finer += width;
        for (std::uint32_t k = 0; k < Count; k += lanes(d))
            hn::StoreInterleaved2(row_steps(d, side_y + k, base), row_steps(d, centre + k, base), d, finer + 2 * k);
        finer[2 * Count] = rows.base + side_y[Count].height;
        finer += width;
        grid += Count + 1;
        side_x += rows.side;
        side_y += rows.side + 1;
        centre += rows.side;
    }
}

void refine_corners_lanes(const std::int32_t (&own)[4], const StepRows (&rows)[page_squares_log2],
                          CornerSteps& corners) {
    static_assert(page_squares_log2 == 5);
    if (rows[0].order != PageOrder::planar) return refine_corners_scalar(own, rows, corners);
    std::int32_t one[9 * 9], other[17 * 17];
    refine_step<1>(rows[0], own, one);
    refine_step<2>(rows[1], one, other);
    refine_step<4>(rows[2], other, one);
    refine_step<8>(rows[3], one, other);
    refine_step<16>(rows[4], other, corners);
}

// --- errors

// |2 h - sum| of the vertices from `h` on, cut off where the table ends. all: all of them or-ed together.
template <class V>
HWY_INLINE void jumps(const std::uint16_t* h, V base_2, V sum, V& all, std::uint16_t* to) {
    const Steps d;
    const hn::Rebind<std::uint16_t, Steps> words;
    const auto height = hn::PromoteTo(d, hn::LoadU(words, h));
    const auto jump = hn::Abs(hn::Sub(hn::Add(hn::Add(height, height), base_2), sum));
    all = hn::Or(all, jump);
    const auto cut = hn::Min(jump, hn::Set(d, static_cast<std::int32_t>(LeafErrors::table_size - 1)));
    hn::StoreU(hn::DemoteTo(words, cut), words, to);
}

// Of all vertices. True: one of them lies beyond the table.
HWY_INLINE bool all_jumps(const CornerSteps& corners, const PageArrays& page, std::uint16_t* to) {
    const Steps d;
    const std::uint16_t* const h = page.heights;
    const auto base_2 = hn::Set(d, 2 * page.base);
    const auto odd_lanes = hn::Sub(hn::Zero(d), hn::And(hn::Iota(d, 0), hn::Set(d, 1)));
    auto all = hn::Zero(d);
    std::uint32_t east = 0; // the sides of the last column
    for (std::uint32_t j = 0; j < n; ++j) {
        const std::int32_t* const north = corners + j * w;
        const std::int32_t* const south = north + w;
        const auto odd = j % 2 == 0 ? odd_lanes : hn::Not(odd_lanes); // cut from south-west to north-east: diamond()
        for (std::uint32_t i = 0; i < n; i += lanes(d)) {
            const auto nw = hn::LoadU(d, north + i), ne = hn::LoadU(d, north + i + 1);
            const auto sw = hn::LoadU(d, south + i), se = hn::LoadU(d, south + i + 1);
            const auto falling = hn::Add(nw, se), rising = hn::Add(sw, ne);
            const auto diagonal = hn::Xor(falling, hn::And(hn::Xor(falling, rising), odd));
            const std::uint32_t centre = j * n + i, x = first_side_x + j * n + i, y = first_side_y + j * w + i;
            jumps(h + centre, base_2, diagonal, all, to + centre);
            jumps(h + x, base_2, hn::Add(nw, ne), all, to + x);
            jumps(h + y, base_2, hn::Add(nw, sw), all, to + y);
        }
        const std::uint32_t y = first_side_y + j * w + n;
        const std::int32_t jump = 2 * (page.base + h[y]) - north[n] - south[n];
        const auto size = static_cast<std::uint32_t>(jump < 0 ? -jump : jump);
        east |= size;
        to[y] = static_cast<std::uint16_t>(size < LeafErrors::table_size ? size : LeafErrors::table_size - 1);
    }
    const std::int32_t* const last = corners + n * w;
    for (std::uint32_t i = 0; i < n; i += lanes(d)) {
        const std::uint32_t x = first_side_x + n * n + i;
        jumps(h + x, base_2, hn::Add(hn::LoadU(d, last + i), hn::LoadU(d, last + i + 1)), all, to + x);
    }
    const auto most = hn::Set(d, static_cast<std::int32_t>(LeafErrors::table_size - 1));
    return east >= LeafErrors::table_size || !hn::AllFalse(d, hn::Gt(all, most));
}

// Centres: what they say themselves, or what their sides ask of them.
HWY_INLINE void raise_centres(std::uint32_t nesting_steps, std::uint8_t* e) {
    const Codes d;
    const auto steps = hn::Set(d, static_cast<std::uint8_t>(nesting_steps));
    for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = 0; i < n; i += lanes(d)) {
            const std::uint8_t* const x = e + first_side_x + j * n + i;
            const std::uint8_t* const y = e + first_side_y + j * w + i;
            const auto child =
                hn::Max(hn::Max(hn::LoadU(d, x), hn::LoadU(d, x + n)), hn::Max(hn::LoadU(d, y), hn::LoadU(d, y + 1)));
            const auto least = hn::IfThenZeroElse(hn::Eq(child, hn::Zero(d)), hn::SaturatedAdd(child, steps));
            std::uint8_t* const own = e + j * n + i;
            hn::StoreU(hn::Max(hn::LoadU(d, own), least), d, own);
        }
}

void leaf_errors_lanes(const CornerSteps& corners, std::uint32_t nesting_steps, const LeafErrors& leaf,
                       PageArrays& page) {
    std::uint16_t jump[max_page_vertices];
    const bool far = all_jumps(corners, page, jump);
    const std::uint8_t* const table = leaf.table();
    std::uint8_t* const e = page.errors;
    static_assert(max_page_vertices % 8 == 0);
    for (std::uint32_t i = 0; i < max_page_vertices; i += 8) { // eight look-ups for one store
        std::uint64_t eight = 0;
        for (std::uint32_t k = 0; k < 8; ++k) eight |= std::uint64_t{table[jump[i + k]]} << (8 * k);
        std::memcpy(e + i, &eight, sizeof eight);
    }
    if (far) far_errors(corners, leaf, jump, page);
    raise_centres(nesting_steps, e);
}

// --- records

// Four records (pack/publish.h).
template <class V>
HWY_INLINE void write_records(V records, VertexRecord* to) {
#if FJELL_WRITES_FOURS && HWY_TARGET != HWY_EMU128
    write_four(to, records.raw);
#else
    const auto pairs = hn::BitCast(hn::FixedTag<std::uint64_t, 2>(), records);
    write_pair(to, hn::ExtractLane(pairs, 0));
    write_pair(to + 2, hn::ExtractLane(pairs, 1));
#endif
}

void write_page_lanes(const PageArrays& page, std::uint32_t count, VertexRecord* to) {
    const hn::FixedTag<std::uint8_t, 16> bytes;
    const Words8 words;
    const hn::FixedTag<std::uint32_t, 4> records;
    std::uint32_t i = 0;
    for (; i < count && !takes_several(to + i); ++i) write_record(to + i, packed_record(page, i));
    for (; i + 16 <= count; i += 16) {
        const auto error = hn::LoadU(bytes, page.errors + i), radius = hn::LoadU(bytes, page.radii + i);
        const auto codes_0 = hn::ZipLower(words, error, radius), codes_1 = hn::ZipUpper(words, error, radius);
        const auto height_0 = hn::LoadU(words, page.heights + i), height_1 = hn::LoadU(words, page.heights + i + 8);
        write_records(hn::ZipLower(records, height_0, codes_0), to + i);
        write_records(hn::ZipUpper(records, height_0, codes_0), to + i + 4);
        write_records(hn::ZipLower(records, height_1, codes_1), to + i + 8);
        write_records(hn::ZipUpper(records, height_1, codes_1), to + i + 12);
    }
    for (; i < count; ++i) write_record(to + i, packed_record(page, i));
}

#endif

} // namespace fjell::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cstdlib>

namespace fjell {

HWY_EXPORT(restore_heights_lanes);
HWY_EXPORT(expand_radii_lanes);
HWY_EXPORT(refine_corners_lanes);
HWY_EXPORT(leaf_errors_lanes);
HWY_EXPORT(write_page_lanes);

void restore_heights(const std::byte* low, const std::byte* high, std::uint16_t* heights) {
    HWY_DYNAMIC_DISPATCH(restore_heights_lanes)(low, high, heights);
}
void expand_radii(const std::uint8_t* stored, std::uint8_t* radii) {
    HWY_DYNAMIC_DISPATCH(expand_radii_lanes)(stored, radii);
}
void refine_corners(const std::int32_t (&own)[4], const StepRows (&rows)[page_squares_log2], CornerSteps& corners) {
    HWY_DYNAMIC_DISPATCH(refine_corners_lanes)(own, rows, corners);
}
void leaf_errors(const CornerSteps& corners, std::uint32_t nesting_steps, const LeafErrors& leaf, PageArrays& page) {
    HWY_DYNAMIC_DISPATCH(leaf_errors_lanes)(corners, nesting_steps, leaf, page);
}
void write_page(const PageArrays& page, std::uint32_t count, VertexRecord* to) {
    HWY_DYNAMIC_DISPATCH(write_page_lanes)(page, count, to);
}

void restore_heights_scalar(const std::byte* low, const std::byte* high, std::uint16_t* h) {
    constexpr std::uint32_t squares = page_squares;
    const auto restore = [&](std::uint32_t i, std::uint32_t predicted) {
        const std::uint32_t folded = std::to_integer<std::uint32_t>(low[i]) |
                                     (high != nullptr ? std::to_integer<std::uint32_t>(high[i]) << 8 : 0);
        h[i] = static_cast<std::uint16_t>(predicted + ((folded >> 1) ^ (0u - (folded & 1))));
    };
    const auto centre = [&](std::uint32_t i, std::uint32_t j) -> std::uint32_t { return h[j * squares + i]; };
    for (std::uint32_t j = 0; j < squares; ++j)
        for (std::uint32_t i = 0; i < squares; ++i) {
            const std::uint32_t west = i == 0 ? 0 : centre(i - 1, j), north = j == 0 ? 0 : centre(i, j - 1);
            restore(j * squares + i, west + north - (i == 0 || j == 0 ? 0 : centre(i - 1, j - 1)));
        }
    for (std::uint32_t j = 0; j <= squares; ++j)
        for (std::uint32_t i = 0; i < squares; ++i)
            restore(first_side_x + j * squares + i,
                    (centre(i, j == 0 ? 0 : j - 1) + centre(i, std::min(j, squares - 1))) / 2);
    for (std::uint32_t j = 0; j < squares; ++j)
        for (std::uint32_t i = 0; i <= squares; ++i)
            restore(first_side_y + j * page_corners + i,
                    (centre(i == 0 ? 0 : i - 1, j) + centre(std::min(i, squares - 1), j)) / 2);
}

namespace {

// visit(vertex, jump): |2 h - a - b| between the two corners that end the vertex' hypotenuse.
template <typename Visit>
void for_each_jump(const CornerSteps& corners, const PageArrays& page, const Visit& visit) {
    constexpr std::uint32_t squares = page_squares;
    const auto corner = [&](std::uint32_t i, std::uint32_t j) { return corners[j * page_corners + i]; };
    const auto jump = [&](std::uint32_t vertex, std::int32_t one_end, std::int32_t other_end) {
        visit(vertex,
              static_cast<std::uint32_t>(std::abs(2 * (page.base + page.heights[vertex]) - one_end - other_end)));
    };
    for (std::uint32_t j = 0; j < squares; ++j)
        for (std::uint32_t i = 0; i < squares; ++i)
            if ((i + j) % 2 == 0) // see diamond(): odd squares are cut from south-west to north-east
                jump(j * squares + i, corner(i, j), corner(i + 1, j + 1));
            else
                jump(j * squares + i, corner(i, j + 1), corner(i + 1, j));
    for (std::uint32_t j = 0; j <= squares; ++j)
        for (std::uint32_t i = 0; i < squares; ++i)
            jump(first_side_x + j * squares + i, corner(i, j), corner(i + 1, j));
    for (std::uint32_t j = 0; j < squares; ++j)
        for (std::uint32_t i = 0; i <= squares; ++i)
            jump(first_side_y + j * page_corners + i, corner(i, j), corner(i, j + 1));
}

} // namespace

void far_errors(const CornerSteps& corners, const LeafErrors& leaf, const std::uint16_t* jump, PageArrays& page) {
    for_each_jump(corners, page, [&](std::uint32_t vertex, std::uint32_t k) {
        if (jump[vertex] == LeafErrors::table_size - 1) page.errors[vertex] = leaf.code(k);
    });
}

void expand_radii_scalar(const std::uint8_t* stored, std::uint8_t* radii) {
    const auto expand = [&](std::uint32_t first, std::uint32_t columns, std::uint32_t rows) {
        const std::uint32_t codes = ((columns - 1) >> radius_squares_log2) + 1; // a row of them
        for (std::uint32_t j = 0; j < rows; ++j)
            for (std::uint32_t i = 0; i < columns; ++i)
                radii[first + j * columns + i] =
                    stored[(j >> radius_squares_log2) * codes + (i >> radius_squares_log2)];
        stored += (((rows - 1) >> radius_squares_log2) + 1) * codes;
    };
    expand(0, page_squares, page_squares);
    expand(first_side_x, page_squares, page_corners);
    expand(first_side_y, page_corners, page_squares);
}

void refine_corners_scalar(const std::int32_t (&own)[4], const StepRows (&rows)[page_squares_log2],
                           CornerSteps& corners) {
    const auto at = [&](std::uint32_t i, std::uint32_t j) -> std::int32_t& { return corners[j * page_corners + i]; };
    for (std::uint32_t k = 0; k < 4; ++k) at(k % 2 * page_squares, k / 2 * page_squares) = own[k];
    for (std::uint32_t coarse = 0; coarse < page_squares_log2; ++coarse) {
        const std::uint32_t count = 1u << coarse, side = page_squares >> coarse, half = side / 2;
        for (std::uint32_t j = 0; j <= count; ++j)
            for (std::uint32_t i = 0; i <= count; ++i) {
                const std::uint32_t x = i * side, y = j * side;
                if (i < count) at(x + half, y) = rows[coarse].steps(VertexKind::side_x, i, j);
                if (j < count) at(x, y + half) = rows[coarse].steps(VertexKind::side_y, i, j);
                if (i < count && j < count) at(x + half, y + half) = rows[coarse].steps(VertexKind::centre, i, j);
            }
    }
}

void leaf_errors_scalar(const CornerSteps& corners, std::uint32_t nesting_steps, const LeafErrors& leaf,
                        PageArrays& page) {
    constexpr std::uint32_t squares = page_squares;
    std::uint8_t* const e = page.errors;
    for_each_jump(corners, page, [&](std::uint32_t vertex, std::uint32_t k) { e[vertex] = leaf.code(k); });
    for (std::uint32_t j = 0; j < squares; ++j)
        for (std::uint32_t i = 0; i < squares; ++i) {
            const std::uint8_t* const x = e + first_side_x + j * squares + i;
            const std::uint8_t* const y = e + first_side_y + j * page_corners + i;
            const std::uint32_t child = std::max({x[0], x[squares], y[0], y[1]});
            const std::uint32_t least = child == 0 ? 0 : std::min(child + nesting_steps, 255u);
            e[j * squares + i] = std::max(e[j * squares + i], static_cast<std::uint8_t>(least));
        }
}

// Packed in vectors first: reading records here and there costs less than putting them together here and there.
void write_permuted(const PageArrays& page, std::uint32_t count, const std::uint16_t* vertex_at, VertexRecord* to) {
    alignas(records_at_once * sizeof(VertexRecord)) VertexRecord packed[max_page_vertices];
    write_page(page, count, packed);
    const auto word = [&](std::uint32_t i) {
        std::uint32_t w;
        std::memcpy(&w, packed + vertex_at[i], sizeof w);
        return w;
    };
    std::uint32_t i = 0;
    for (; i < count && !takes_several(to + i); ++i) write_record(to + i, word(i));
    for (; i + 2 <= count; i += 2) write_pair(to + i, word(i) | std::uint64_t{word(i + 1)} << 32);
    for (; i < count; ++i) write_record(to + i, word(i));
}

void write_page_scalar(const PageArrays& page, std::uint32_t count, VertexRecord* to) {
    for (std::uint32_t i = 0; i < count; ++i) write_record(to + i, packed_record(page, i));
}

} // namespace fjell
#endif
