// A page from heights and codes to bytes; runtime/src/pack/page.cpp undoes it (docs/pack-format.md).
#include "baker/bake.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace fjell::baker {

namespace {

constexpr std::uint32_t n = page_squares;
constexpr std::uint32_t first_side_x = n * n, first_side_y = first_side_x + n * (n + 1);

std::size_t cell(Coord c, std::int32_t columns) {
    return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c.x);
}

// A page's vertices in canonical order, as a reader will have them.
class PageSource {
public:
    PageSource(const PageInput& input, std::uint32_t tile, std::uint32_t page)
        : in_(input), canonical_{input.pages.tile_log2,
                                 input.pages.order == Order::linear ? Order::linear : Order::planar},
          page_(page), block_(is_block(input.pages, page)) {
        const std::int32_t side = in_.tree.side(), tiles_x = in_.tree.tiles_x;
        const auto t = static_cast<std::int32_t>(tile);
        corner_ = {t % tiles_x * side, t / tiles_x * side};
        if (!block_) return;
        place_ = in_.pages.page_block(page);
        page_ = canonical_.page_of_block(in_.pages.page_step_log2(page), static_cast<std::uint32_t>(place_.x),
                                         static_cast<std::uint32_t>(place_.y));
    }
    [[nodiscard]] bool block() const { return block_; }
    [[nodiscard]] std::uint32_t count() const { return canonical_.page_vertices(page_); }
    [[nodiscard]] Coord vertex(std::uint32_t i) const { return corner_ + canonical_.coord({page_, i}); }
    [[nodiscard]] std::int32_t steps(Coord v) const { return in_.steps[cell(in_.tree.sample(v), in_.tree.columns())]; }
    [[nodiscard]] bool hole(Coord v) const {
        return !in_.dem.voids.empty() && in_.dem.voids[cell(in_.tree.sample(v), in_.tree.columns())] != 0;
    }
    [[nodiscard]] std::uint8_t error(Coord v) const { return in_.errors.error[cell(v, in_.tree.lattice_columns())]; }
    [[nodiscard]] std::uint8_t radius(Coord v) const { return in_.errors.radius[cell(v, in_.tree.lattice_columns())]; }
    // Of the squares of a block of step 1.
    void corners(CornerSteps& out) const {
        for (std::int32_t j = 0; j <= static_cast<std::int32_t>(n); ++j)
            for (std::int32_t i = 0; i <= static_cast<std::int32_t>(n); ++i)
                out[j * static_cast<std::int32_t>(block_corners) + i] =
                    steps(corner_ + Coord{2 * (place_.x * static_cast<std::int32_t>(n) + i),
                                          2 * (place_.y * static_cast<std::int32_t>(n) + j)});
    }

private:
    const PageInput& in_;
    PageLayout canonical_;
    std::uint32_t page_; // in the canonical layout
    bool block_;
    Coord corner_, place_;
};

// What a reader predicts a vertex to be, from heights it already has; all modulo 2^16.
std::uint32_t predict_in_block(const std::uint16_t* h, std::uint32_t index) {
    const auto mean = [&](std::uint32_t a, std::uint32_t b) {
        return (static_cast<std::uint32_t>(h[a]) + static_cast<std::uint32_t>(h[b])) >> 1;
    };
    if (index < first_side_x) {
        const std::uint32_t i = index % n, j = index / n;
        const std::uint32_t west = i ? h[index - 1] : 0, north = j ? h[index - n] : 0,
                            north_west = i && j ? h[index - n - 1] : 0;
        return west + north - north_west;
    }
    if (index < first_side_y) {
        const std::uint32_t i = (index - first_side_x) % n, j = (index - first_side_x) / n;
        return mean((j == 0 ? 0 : j - 1) * n + i, (j == n ? n - 1 : j) * n + i);
    }
    const std::uint32_t i = (index - first_side_y) % (n + 1), j = (index - first_side_y) / (n + 1);
    return mean(j * n + (i == 0 ? 0 : i - 1), j * n + (i == n ? n - 1 : i));
}

std::uint32_t predict_in_rows(const std::uint16_t* h, std::uint32_t index, std::uint32_t row) {
    if (index == 0) return 0;
    std::uint32_t predicted = h[index - 1];
    if (row != 0 && index > row) predicted += static_cast<std::uint32_t>(h[index - row]) - h[index - row - 1];
    return predicted;
}

std::uint16_t fold(std::uint32_t difference) {
    const auto d = static_cast<std::int16_t>(difference);
    return static_cast<std::uint16_t>((d << 1) ^ (d >> 15));
}

// One radius of each 4 x 4 squares: the error stage made them equal.
void reduce_radii(const std::uint8_t* radii, std::vector<std::byte>& out) {
    constexpr std::uint32_t step = 1u << radius_block_log2;
    const auto take = [&](std::uint32_t first, std::uint32_t stride, std::uint32_t columns, std::uint32_t rows) {
        for (std::uint32_t j = 0; j < rows; j += step)
            for (std::uint32_t i = 0; i < columns; i += step)
                out.push_back(static_cast<std::byte>(radii[first + j * stride + i] & ~void_bit));
    };
    take(0, n, n, n);
    take(first_side_x, n, n, n + 1);
    take(first_side_y, n + 1, n + 1, n);
}

} // namespace

std::vector<std::byte> pack_page(const PageInput& input, std::uint32_t tile, std::uint32_t page) {
    const PageSource source(input, tile, page);
    const std::uint32_t count = source.count();
    PageArrays a;
    std::int32_t least = max_lattice_steps;
    for (std::uint32_t i = 0; i < count; ++i) least = std::min(least, source.steps(source.vertex(i)));
    a.base = std::min(least, max_lattice_steps - 65535);
    bool voids = false;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Coord v = source.vertex(i);
        const bool hole = source.hole(v);
        a.heights[i] = static_cast<std::uint16_t>(source.steps(v) - a.base);
        a.errors[i] = source.error(v);
        a.radii[i] = static_cast<std::uint8_t>(source.radius(v) | (hole ? void_bit : 0));
        voids = voids || hole;
    }
    bool derived = false;
    if (input.pages.page_step_log2(page) == 0) {
        CornerSteps corners;
        PageArrays reader = a;
        source.corners(corners);
        derive_errors(corners, input.errors.scale, input.leaf, reader);
        derived = std::equal(a.errors, a.errors + count, reader.errors);
    }

    std::vector<std::uint16_t> residuals(count);
    bool wide = false;
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t predicted =
            source.block() ? predict_in_block(a.heights, i) : predict_in_rows(a.heights, i, row_length(input.pages));
        residuals[i] = fold(a.heights[i] - predicted);
        wide = wide || residuals[i] > 0xff;
    }
    const PageHead head{
        a.base,
        static_cast<std::uint8_t>((wide ? page_wide : 0) | (derived ? 0 : page_errors) | (voids ? page_voids : 0)),
        {}};
    std::vector<std::byte> out(sizeof head);
    std::memcpy(out.data(), &head, sizeof head);
    for (const std::uint16_t r : residuals) out.push_back(static_cast<std::byte>(r & 0xff));
    if (wide)
        for (const std::uint16_t r : residuals) out.push_back(static_cast<std::byte>(r >> 8));
    if (!derived)
        for (std::uint32_t i = 0; i < count; ++i) out.push_back(static_cast<std::byte>(a.errors[i]));
    if (source.block())
        reduce_radii(a.radii, out);
    else
        for (std::uint32_t i = 0; i < count; ++i) out.push_back(static_cast<std::byte>(a.radii[i] & ~void_bit));
    if (voids)
        for (std::uint32_t i = 0; i < count; i += 8) {
            unsigned bits = 0;
            for (std::uint32_t k = i; k < std::min(i + 8, count); ++k) bits |= (a.radii[k] >> 7 & 1u) << (k - i);
            out.push_back(static_cast<std::byte>(bits));
        }
    return out;
}

} // namespace fjell::baker
