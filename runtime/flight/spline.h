// A cubic spline through points of any dimension: passes through every one, and its first and second derivatives are
// continuous (thesis 6.2 uses nine dimensions for a camera). It is natural, or closed: then the last point is the
// first, and the derivatives are continuous there too.
//
// Between knots i and i + 1, h apart, with a = (t[i+1] - t) / h and b = 1 - a, and m the second derivatives at the
// knots,
//   s(t) = a p[i] + b p[i+1] + h^2 / 6 ((a^3 - a) m[i] + (b^3 - b) m[i+1]).
// Equal slopes on both sides of every inner knot give one equation each,
//   h[i-1] m[i-1] + 2 (h[i-1] + h[i]) m[i] + h[i] m[i+1] = 6 ((p[i+1] - p[i]) / h[i] - (p[i] - p[i-1]) / h[i-1]),
// and m is zero at both ends of a natural one. The matrix is diagonally dominant, so elimination needs no pivots.
// Of a closed one with N pieces the equation holds at its seam too, with h[-1] = h[N-1] and m[N] = m[0]. That matrix is
// the tridiagonal one and two corners h[N-1]. Corners of h and -p on the diagonal are a matrix of rank one,
//   u v^T with u = (-p, 0 .. 0, h) and v = (1, 0 .. 0, -h / p),
// so with A' = A - u v^T, which is tridiagonal, Sherman and Morrison (1950) give m = y - z (v y) / (1 + v z) of A' y =
// r and A' z = u. With p the first element of the diagonal A' is diagonally dominant as well.
//
// Thread: immutable after construction. Complexity: O(points) to build, O(log points) to evaluate.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace fjell::flight {

template <std::size_t D>
class CubicSpline {
public:
    using Point = std::array<double, D>;

    CubicSpline() = default;
    // knots: strictly increasing, as many as points, at least 2. closed: at least 3, and the last point is the first.
    CubicSpline(std::vector<double> knots, std::vector<Point> points, bool closed = false)
        : knots_(std::move(knots)), points_(std::move(points)), second_(points_.size(), Point{}), closed_(closed) {
        closed ? solve_closed() : solve_natural();
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
    [[nodiscard]] bool closed() const { return closed_; }

private:
    [[nodiscard]] double piece(std::size_t i) const { return knots_[i + 1] - knots_[i]; }
    // The right-hand side at a knot between pieces before and i.
    [[nodiscard]] double turn(std::size_t before, std::size_t i, std::size_t d) const {
        return 6 * ((points_[i + 1][d] - points_[i][d]) / piece(i) -
                    (points_[before + 1][d] - points_[before][d]) / piece(before));
    }

    void solve_natural() {
        const std::size_t n = points_.size();
        std::vector<double> upper(n, 0); // the eliminated matrix' upper diagonal
        for (std::size_t i = 1; i + 1 < n; ++i) {
            const double before = piece(i - 1), after = piece(i), pivot = 2 * (before + after) - before * upper[i - 1];
            upper[i] = after / pivot;
            for (std::size_t d = 0; d < D; ++d)
                second_[i][d] = (turn(i - 1, i, d) - before * second_[i - 1][d]) / pivot;
        }
        for (std::size_t i = n - 1; i-- > 1;)
            for (std::size_t d = 0; d < D; ++d) second_[i][d] -= upper[i] * second_[i + 1][d];
    }

    void solve_closed() {
        const std::size_t n = points_.size() - 1; // pieces, and unknowns
        const double corner = piece(n - 1), first = 2 * (corner + piece(0));
        std::vector<double> upper(n, 0), z(n, 0); // z: of A' z = u
        for (std::size_t i = 0; i < n; ++i) {
            const double before = i == 0 ? 0 : piece(i - 1), after = piece(i);
            double diagonal = i == 0 ? 2 * first : 2 * (before + after), u = i == 0 ? -first : 0;
            if (i == n - 1) {
                diagonal += corner * corner / first;
                u += corner;
            }
            const double pivot = diagonal - (i == 0 ? 0 : before * upper[i - 1]);
            upper[i] = after / pivot;
            z[i] = (u - (i == 0 ? 0 : before * z[i - 1])) / pivot;
            for (std::size_t d = 0; d < D; ++d)
                second_[i][d] =
                    (turn(i == 0 ? n - 1 : i - 1, i, d) - (i == 0 ? 0 : before * second_[i - 1][d])) / pivot;
        }
        for (std::size_t i = n - 1; i-- > 0;) {
            z[i] -= upper[i] * z[i + 1];
            for (std::size_t d = 0; d < D; ++d) second_[i][d] -= upper[i] * second_[i + 1][d];
        }
        const double v = -corner / first, below = 1 + z[0] + v * z[n - 1];
        for (std::size_t d = 0; d < D; ++d) {
            const double share = (second_[0][d] + v * second_[n - 1][d]) / below;
            for (std::size_t i = 0; i < n; ++i) second_[i][d] -= share * z[i];
        }
        second_[n] = second_[0];
    }

    std::vector<double> knots_;
    std::vector<Point> points_, second_;
    bool closed_ = false;
};

} // namespace fjell::flight
