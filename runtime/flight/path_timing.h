// When a camera is where on its spline, if its control points have times.
//
// The way along the spline is interpolated over time by a monotone cubic (F. N. Fritsch, J. Butland: A Method for
// Constructing Local Monotone Piecewise Cubic Interpolants, 1984): the camera passes each point at its time, its speed
// is continuous, and it never flies backwards. At both ends the second derivative is zero, as a natural spline's is; a
// closed spline's last piece is followed by its first, so that the speed is continuous there too; and where the camera
// eases, its speed is zero at both ends.
//
// Units: seconds; the way is in metres of position, with a hundredth for turning, so that a camera that only turns
// moves on too. In units of the terrain the rise of the ground under the flight is not counted. Thread: immutable.
// Complexity: O(points) to build, O(log points) to evaluate. Memory: 16 bytes for each of 4 to 64 stations a piece, at
// least 4 a point.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "fjell/view.h"
#include "flight/spline.h"

namespace fjell::flight {

// Closer times would be speeds without a limit.
inline constexpr double least_between_times_s = 0.001;

// The first time that is not that much later than the one before, or not 0 though it is the first; none: all are good.
[[nodiscard]] std::optional<std::size_t> first_bad_time(std::span<const double> times_s);

class PathTiming {
public:
    // times_s: without a bad one, as many as knots. unit_m: metres of one unit of position, along x, y and z.
    PathTiming(const CubicSpline<9>& spline, std::span<const double> times_s, const Vec3& unit_m, bool eases = false);

    // Where on the spline, in its knots' measure. Exactly a knot at its time; before and after all times the ends.
    [[nodiscard]] double knot_at(double time_s) const;
    // Along the spline from its first knot to that one.
    [[nodiscard]] double way_to(std::size_t knot) const { return way_[knot * steps_]; }

private:
    [[nodiscard]] double station(std::size_t i) const; // its place on the spline
    void measure(const CubicSpline<9>& spline, const Vec3& unit_m);
    void choose_speeds(bool closed, bool eases);

    std::vector<double> knots_, times_s_;
    std::vector<double> speed_;      // of the way, at the knots, a second
    std::size_t steps_ = 4;          // stations a piece
    std::vector<double> rate_, way_; // at stations: of the way along the spline, and the way up to there
};

} // namespace fjell::flight
