// Where texels lie on a height field, without asking a CRS for each: that took most of the time of writing tiles.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "baker/store/window.h"

namespace fjell::baker {

// Texels are numbered over all of a map, and looked at by squares of 8 x 8. Corners of squares are exact; between them
// places are bilinear, if that is right in the square's middle to a share of a texel. It is but near poles and at a
// projection's end, where every texel is exact. Squares lie on the map's grid, so a texel is at the same place in
// whatever window it is asked for.
class TexelPlaces {
public:
    using Place = std::optional<std::array<double, 2>>; // column and row of the field
    // Of the middle of a texel; also of texels beside the window, and between texels.
    using Exact = std::function<Place(double x, double y)>;

    static constexpr std::int32_t side_log2 = 3, side = 1 << side_log2; // of a square, in texels

    // accuracy: the share of a texel. O(texels of the window / 32) calls of `exact`.
    TexelPlaces(const Window& window, double accuracy, Exact exact)
        : exact_(std::move(exact)), first_x_(square_of(window.x)), first_y_(square_of(window.y)),
          across_(square_of(window.x + window.columns - 1) - first_x_ + 1) {
        const std::int32_t down = square_of(window.y + window.rows - 1) - first_y_ + 1;
        for (std::int32_t j = 0; j <= down; ++j)
            for (std::int32_t i = 0; i <= across_; ++i)
                nodes_.push_back(exact_((first_x_ + i) * side, (first_y_ + j) * side));
        for (std::int32_t j = 0; j < down; ++j)
            for (std::int32_t i = 0; i < across_; ++i) smooth_.push_back(is_smooth(i, j, accuracy));
    }
    // A texel of the window.
    [[nodiscard]] Place at(std::int32_t x, std::int32_t y) const {
        const std::int32_t i = square_of(x) - first_x_, j = square_of(y) - first_y_;
        if (!smooth_[static_cast<std::size_t>(j) * static_cast<std::size_t>(across_) + static_cast<std::size_t>(i)])
            return exact_(x, y);
        return between(i, j, (x & (side - 1)) * a_texel, (y & (side - 1)) * a_texel);
    }

private:
    static constexpr double a_texel = 1.0 / side;
    static std::int32_t square_of(std::int32_t texel) { return texel >> side_log2; }
    [[nodiscard]] const Place& node(std::int32_t i, std::int32_t j) const {
        return nodes_[static_cast<std::size_t>(j) * static_cast<std::size_t>(across_ + 1) +
                      static_cast<std::size_t>(i)];
    }
    [[nodiscard]] std::array<double, 2> between(std::int32_t i, std::int32_t j, double s, double t) const {
        std::array<double, 2> place{};
        for (std::size_t axis = 0; axis < 2; ++axis)
            place[axis] = (1 - t) * ((1 - s) * (*node(i, j))[axis] + s * (*node(i + 1, j))[axis]) +
                          t * ((1 - s) * (*node(i, j + 1))[axis] + s * (*node(i + 1, j + 1))[axis]);
        return place;
    }
    [[nodiscard]] bool is_smooth(std::int32_t i, std::int32_t j, double accuracy) const {
        if (!node(i, j) || !node(i + 1, j) || !node(i, j + 1) || !node(i + 1, j + 1)) return false;
        const Place middle = exact_((first_x_ + i + 0.5) * side, (first_y_ + j + 0.5) * side);
        if (!middle) return false;
        const auto apart = [](const std::array<double, 2>& a, const std::array<double, 2>& b) {
            return std::hypot(a[0] - b[0], a[1] - b[1]);
        };
        const double texel = std::min(apart(*node(i, j), *node(i + 1, j)), apart(*node(i, j), *node(i, j + 1))) / side;
        return apart(*middle, between(i, j, 0.5, 0.5)) <= texel * accuracy;
    }

    Exact exact_;
    std::int32_t first_x_, first_y_, across_; // squares
    std::vector<Place> nodes_;
    std::vector<bool> smooth_;
};

} // namespace fjell::baker
