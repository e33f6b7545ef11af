// A cubic spline through points of any dimension: passes through every one, and its first and second derivatives are
// continuous, and the second is zero at both ends (thesis 6.2 uses nine dimensions for a camera).
//
// Between knots i and i + 1, h apart, with a = (t[i+1] - t) / h and b = 1 - a, and m the second derivatives at the
// knots,
//   s(t) = a p[i] + b p[i+1] + h^2 / 6 ((a^3 - a) m[i] + (b^3 - b) m[i+1]).
// Equal slopes on both sides of every inner knot give one equation each,
//   h[i-1] m[i-1] + 2 (h[i-1] + h[i]) m[i] + h[i] m[i+1] = 6 ((p[i+1] - p[i]) / h[i] - (p[i] - p[i-1]) / h[i-1]),
// and m is zero at both ends. The matrix is diagonally dominant, so elimination needs no pivots.
//
// Thread: immutable after construction. Complexity: O(points) to build, O(log points) to evaluate.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace fjell::session {

template <std::size_t D>
class CubicSpline {
public:
    using Point = std::array<double, D>;

    CubicSpline() = default;
    // knots: strictly increasing, as many as points, at least 2.
    CubicSpline(std::vector<double> knots, std::vector<Point> points)
        : knots_(std::move(knots)), points_(std::move(points)), second_(points_.size(), Point{}) {
        solve();
    }

    // derivative: 0, 1 or 2. t outside the knots continues the first or last piece.
    [[nodiscard]] Point at(double t, int derivative = 0) const {
        const auto above = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, t);
        const auto i = static_cast<std::size_t>(above - knots_.begin()) - 1;
        const double h = knots_[i + 1] - knots_[i], a = (knots_[i + 1] - t) / h, b = (t - knots_[i]) / h;
        // What p[i], p[i+1], m[i] and m[i+1] are multiplied with.
        std::array<double, 4> w{a, b, (a * a * a - a) * h * h / 6, (b * b * b - b) * h * h / 6};
        if (derivative == 1) w = {-1 / h, 1 / h, (1 - 3 * a * a) * h / 6, (3 * b * b - 1) * h / 6};
        if (derivative == 2) w = {0, 0, a, b};
        Point result{};
        for (std::size_t d = 0; d < D; ++d)
            result[d] =
                w[0] * points_[i][d] + w[1] * points_[i + 1][d] + w[2] * second_[i][d] + w[3] * second_[i + 1][d];
        return result;
    }
    [[nodiscard]] const std::vector<double>& knots() const { return knots_; }

private:
    [[nodiscard]] double piece(std::size_t i) const { return knots_[i + 1] - knots_[i]; }
    // The right-hand side at an inner knot.
    [[nodiscard]] double turn(std::size_t i, std::size_t d) const {
        return 6 *
               ((points_[i + 1][d] - points_[i][d]) / piece(i) - (points_[i][d] - points_[i - 1][d]) / piece(i - 1));
    }

    void solve() {
        const std::size_t n = points_.size();
        std::vector<double> upper(n, 0); // the eliminated matrix' upper diagonal
        for (std::size_t i = 1; i + 1 < n; ++i) {
            const double before = piece(i - 1), after = piece(i), pivot = 2 * (before + after) - before * upper[i - 1];
            upper[i] = after / pivot;
            for (std::size_t d = 0; d < D; ++d) second_[i][d] = (turn(i, d) - before * second_[i - 1][d]) / pivot;
        }
        for (std::size_t i = n - 1; i-- > 1;)
            for (std::size_t d = 0; d < D; ++d) second_[i][d] -= upper[i] * second_[i + 1][d];
    }

    std::vector<double> knots_;
    std::vector<Point> points_, second_;
};

} // namespace fjell::session
