#include "baker/pack/encode_page.h"

#include <algorithm>
#include <cstring>

#include "shared/compiler.h"

namespace fjell::baker {

namespace {

constexpr std::int32_t squares = page_squares;
constexpr std::int32_t first_side_x = squares * squares, first_side_y = first_side_x + squares * (squares + 1);

FJELL_ALWAYS_INLINE inline std::uint16_t fold(std::uint32_t difference) {
    const auto d = static_cast<std::int16_t>(difference);
    return static_cast<std::uint16_t>((d << 1) ^ (d >> 15));
}

// Differences from what a reader predicts, from heights it already has; all modulo 2^16.
FJELL_CLONES void page_residuals(const std::uint16_t* h, std::uint16_t* out) {
    for (std::int32_t j = 0; j < squares; ++j) {
        const std::uint16_t* const row = h + j * squares;
        std::uint16_t line[squares]; // less the row before
        for (std::int32_t i = 0; i < squares; ++i)
            line[i] = static_cast<std::uint16_t>(row[i] - (j ? row[i - squares] : 0));
        std::uint16_t* const to = out + j * squares;
        to[0] = fold(line[0]);
        for (std::int32_t i = 1; i < squares; ++i) to[i] = fold(static_cast<std::uint32_t>(line[i] - line[i - 1]));
    }
    for (std::int32_t j = 0; j <= squares; ++j) {
        const std::uint16_t* const north = h + (j == 0 ? 0 : j - 1) * squares;
        const std::uint16_t* const south = h + (j == squares ? squares - 1 : j) * squares;
        const std::uint16_t* const row = h + first_side_x + j * squares;
        std::uint16_t* const to = out + first_side_x + j * squares;
        for (std::int32_t i = 0; i < squares; ++i)
            to[i] = fold(row[i] - ((static_cast<std::uint32_t>(north[i]) + south[i]) >> 1));
    }
    for (std::int32_t j = 0; j < squares; ++j) {
        const std::uint16_t* const centre = h + j * squares;
        const std::uint16_t* const row = h + first_side_y + j * (squares + 1);
        std::uint16_t* const to = out + first_side_y + j * (squares + 1);
        to[0] = fold(static_cast<std::uint32_t>(row[0]) - centre[0]);
        for (std::int32_t i = 1; i < squares; ++i)
            to[i] = fold(row[i] - ((static_cast<std::uint32_t>(centre[i - 1]) + centre[i]) >> 1));
        to[squares] = fold(static_cast<std::uint32_t>(row[squares]) - centre[squares - 1]);
    }
}

void row_residuals(const std::uint16_t* h, std::uint32_t count, std::uint32_t row, std::uint16_t* out) {
    for (std::uint32_t i = 0; i < count; ++i) {
        std::uint32_t predicted = i == 0 ? 0 : h[i - 1];
        if (row != 0 && i > row) predicted += static_cast<std::uint32_t>(h[i - row]) - h[i - row - 1];
        out[i] = fold(h[i] - predicted);
    }
}

// What a page consists of, in the order in which it is stored.
struct StoredArrays {
    std::uint32_t count = 0;
    const std::uint16_t* residuals = nullptr;
    bool errors = false, voids = false;
    std::vector<std::uint8_t> radii; // as stored, without void_bit
};

FJELL_CLONES std::uint32_t all_bits(const std::uint16_t* from, std::uint32_t count) {
    std::uint32_t all = 0;
    for (std::uint32_t i = 0; i < count; ++i) all |= from[i];
    return all;
}

std::vector<std::byte> assemble(const PageArrays& a, const StoredArrays& s) {
    const bool wide = all_bits(s.residuals, s.count) > 0xff;
    const PageHead head{
        a.base,
        static_cast<std::uint8_t>((wide ? page_wide : 0) | (s.errors ? page_errors : 0) | (s.voids ? page_voids : 0)),
        {}};
    std::vector<std::byte> out(sizeof head + s.count * (1u + wide + s.errors) + s.radii.size() +
                               (s.voids ? (s.count + 7) / 8 : 0));
    std::byte* to = out.data();
    const auto put = [&](const void* from, std::size_t bytes) {
        std::memcpy(to, from, bytes);
        to += bytes;
    };
    put(&head, sizeof head);
    for (std::uint32_t i = 0; i < s.count; ++i) to[i] = static_cast<std::byte>(s.residuals[i] & 0xff);
    to += s.count;
    if (wide) {
        for (std::uint32_t i = 0; i < s.count; ++i) to[i] = static_cast<std::byte>(s.residuals[i] >> 8);
        to += s.count;
    }
    if (s.errors) put(a.errors, s.count);
    put(s.radii.data(), s.radii.size());
    if (s.voids)
        for (std::uint32_t i = 0; i < s.count; i += 8) {
            unsigned bits = 0;
            for (std::uint32_t k = i; k < std::min(i + 8, s.count); ++k) bits |= (a.radii[k] >> 7 & 1u) << (k - i);
            *to++ = static_cast<std::byte>(bits);
        }
    return out;
}

FJELL_CLONES PageBound bound_of(const PackHeader& header, const PageArrays& a, std::uint32_t count, int level,
                                float radius_m) {
    static constexpr RadiusScale radii = RadiusScale::make();
    std::uint16_t least = 0xffff, most = 0;
    std::uint8_t error = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        least = a.heights[i] < least ? a.heights[i] : least;
        most = a.heights[i] > most ? a.heights[i] : most;
        error = a.errors[i] > error ? a.errors[i] : error;
    }
    const std::uint32_t shift = bound_shift(header);
    return {static_cast<std::uint16_t>((a.base + least) >> shift), static_cast<std::uint16_t>((a.base + most) >> shift),
            error, radii.code_up(header.level_radius_m[level], static_cast<double>(radius_m)), 0};
}

// Of codes on a level's unit.
float largest_radius_m(const PackHeader& header, int level, std::span<const std::uint8_t> codes) {
    static constexpr RadiusScale radii = RadiusScale::make();
    return header.level_radius_m[level] * radii.factor[*std::max_element(codes.begin(), codes.end())];
}

// A page's three planes row by row: visit(kind, first vertex, row, columns).
template <typename Visit>
void for_each_row(const Visit& visit) {
    for (std::int32_t j = 0; j < squares; ++j) visit(VertexKind::centre, j * squares, j, squares);
    for (std::int32_t j = 0; j <= squares; ++j) visit(VertexKind::side_x, first_side_x + j * squares, j, squares);
    for (std::int32_t j = 0; j < squares; ++j)
        visit(VertexKind::side_y, first_side_y + j * (squares + 1), j, squares + 1);
}

template <typename T>
const VertexPlane<T>& plane(const VertexPlanes<T>& of, VertexKind kind) {
    return kind == VertexKind::centre ? of.centre : kind == VertexKind::side_x ? of.side_x : of.side_y;
}

// Of a row; a loop that the compiler vectorises.
FJELL_ALWAYS_INLINE inline std::int32_t least_of(const std::int32_t* row, std::int32_t count, std::int32_t least) {
    for (std::int32_t i = 0; i < count; ++i) least = row[i] < least ? row[i] : least;
    return least;
}

FJELL_CLONES void gather(const StepPageInput& in, PageArrays& a) {
    std::int32_t least = max_height_steps - 65535;
    for_each_row([&](VertexKind kind, std::int32_t, std::int32_t j, std::int32_t columns) {
        least = least_of(plane(in.steps, kind).row(in.j + j) + in.i, columns, least);
    });
    a.base = least;
    for_each_row([&](VertexKind kind, std::int32_t first, std::int32_t j, std::int32_t columns) {
        const std::int32_t* const row = plane(in.steps, kind).row(in.j + j) + in.i;
        for (std::int32_t i = 0; i < columns; ++i) a.heights[first + i] = static_cast<std::uint16_t>(row[i] - least);
        std::memcpy(a.errors + first, plane(in.error, kind).row(in.j + j) + in.i, static_cast<std::size_t>(columns));
    });
}

bool reader_knows(const StepPageInput& in, const PageArrays& a) {
    CornerSteps corners;
    for (std::int32_t j = 0; j <= squares; ++j)
        std::copy_n(in.steps.corner.row(in.j + j) + in.i, squares + 1,
                    corners + j * static_cast<std::int32_t>(page_corners));
    PageArrays reader;
    reader.base = a.base;
    std::memcpy(reader.heights, a.heights, sizeof a.heights);
    derive_errors(corners, in.scale, *in.leaf, reader);
    return std::memcmp(a.errors, reader.errors, max_page_vertices) == 0;
}

} // namespace

EncodedPage encode_step_page(const StepPageInput& input) {
    PageArrays a;
    gather(input, a);
    std::uint16_t residuals[max_page_vertices];
    page_residuals(a.heights, residuals);
    StoredArrays s;
    s.count = max_page_vertices;
    s.residuals = residuals;
    s.errors = !input.leaf || !reader_knows(input, a);
    if (input.voids)
        for_each_row([&](VertexKind kind, std::int32_t first, std::int32_t j, std::int32_t columns) {
            const std::uint8_t* const row = plane(*input.voids, kind).row(input.j + j) + input.i;
            for (std::int32_t i = 0; i < columns; ++i) {
                a.radii[first + i] = row[i] ? void_bit : 0;
                s.voids = s.voids || row[i];
            }
        });
    s.radii.reserve(page_radii);
    constexpr std::int32_t step = 1 << radius_squares_log2;
    const auto take = [&](VertexKind kind, std::int32_t columns, std::int32_t rows) {
        for (std::int32_t j = 0; j < rows; j += step)
            for (std::int32_t i = 0; i < columns; i += step)
                s.radii.push_back(input.radii.at(kind, input.i + i, input.j + j));
    };
    take(VertexKind::centre, squares, squares);
    take(VertexKind::side_x, squares, squares + 1);
    take(VertexKind::side_y, squares + 1, squares);
    // Centres, then sides, whose level is the next and counts on a unit of its own.
    constexpr std::size_t centres = std::size_t{squares / step} * (squares / step);
    const int level = 2 * (static_cast<int>(input.header.tile_log2) - 1 - input.z);
    const std::span codes(s.radii);
    const float radius_m = std::max(largest_radius_m(input.header, level, codes.first(centres)),
                                    largest_radius_m(input.header, level + 1, codes.subspan(centres)));
    return {assemble(a, s), sizeof(PageHead) + s.count, bound_of(input.header, a, s.count, level, radius_m)};
}

EncodedPage encode_mixed_page(const PackHeader& header, std::uint32_t page,
                              const std::function<MixedPageVertex(SampleIndex)>& vertex) {
    const PageLayout pages{static_cast<int>(header.tile_log2), header.order};
    const Tree tree{pages.tile_log2};
    const PageLayout canonical{pages.tile_log2,
                               pages.order == PageOrder::linear ? PageOrder::linear : PageOrder::planar};
    PageArrays a;
    StoredArrays s;
    s.count = canonical.page_vertices(page);
    std::vector<MixedPageVertex> vertices(s.count);
    std::int32_t least = max_height_steps - 65535;
    float radius_m = 0;
    for (std::uint32_t i = 0; i < s.count; ++i) {
        const SampleIndex c = canonical.coord({page, i});
        vertices[i] = vertex(c);
        least = std::min(least, vertices[i].steps);
        const auto code = static_cast<std::uint8_t>(vertices[i].radius & ~void_bit);
        if (!tree.is_corner(c)) // which has no radius
            radius_m = std::max(radius_m, largest_radius_m(header, tree.level(c), std::span(&code, 1)));
    }
    a.base = least;
    for (std::uint32_t i = 0; i < s.count; ++i) {
        a.heights[i] = static_cast<std::uint16_t>(vertices[i].steps - least);
        a.errors[i] = vertices[i].error;
        a.radii[i] = vertices[i].radius;
        s.voids = s.voids || (vertices[i].radius & void_bit);
        s.radii.push_back(static_cast<std::uint8_t>(vertices[i].radius & ~void_bit));
    }
    std::uint16_t residuals[max_page_vertices];
    row_residuals(a.heights, s.count, row_length(pages), residuals);
    s.residuals = residuals;
    s.errors = true;
    return {assemble(a, s), sizeof(PageHead) + s.count,
            bound_of(header, a, s.count, bound_level(pages, page), radius_m)};
}

} // namespace fjell::baker
