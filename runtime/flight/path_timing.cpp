#include "flight/path_timing.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fjell::flight {

namespace {

constexpr std::size_t most_stations = 262'144; // unless there are more points than a quarter of that

struct Rates {
    double moving_m, turning;
};

Rates rates_at(const CubicSpline<9>& spline, double t, const Vec3& unit_m) {
    const std::array<double, 9> d = spline.at(t, 1);
    return {length(Vec3{d[0] * unit_m.x, d[1] * unit_m.y, d[2] * unit_m.z}),
            length(Vec3{d[3], d[4], d[5]}) + length(Vec3{d[6], d[7], d[8]})};
}

} // namespace

std::optional<std::size_t> first_bad_time(std::span<const double> times_s) {
    constexpr double least_s =
        least_between_times_s - 1e-9; // times of decimals are rounded, and so is their difference
    for (std::size_t i = 0; i < times_s.size(); ++i)
        if (!(i == 0 ? times_s[0] == 0 : times_s[i] - times_s[i - 1] >= least_s)) return i;
    return {};
}

PathTiming::PathTiming(const CubicSpline<9>& spline, std::span<const double> times_s, const Vec3& unit_m, bool eases)
    : knots_(spline.knots()), times_s_(times_s.begin(), times_s.end()) {
    steps_ = std::clamp<std::size_t>(most_stations / (knots_.size() - 1), 4, 64);
    measure(spline, unit_m);
    choose_speeds(spline.closed(), eases);
}

double PathTiming::station(std::size_t i) const {
    const std::size_t piece = i / steps_;
    if (piece + 1 == knots_.size()) return knots_.back();
    const double part = static_cast<double>(i % steps_) / static_cast<double>(steps_);
    return knots_[piece] + (knots_[piece + 1] - knots_[piece]) * part;
}

void PathTiming::measure(const CubicSpline<9>& spline, const Vec3& unit_m) {
    const std::size_t stations = (knots_.size() - 1) * steps_ + 1;
    std::vector<double> turning(stations);
    rate_.resize(stations);
    for (std::size_t i = 0; i < stations; ++i) {
        const Rates rates = rates_at(spline, station(i), unit_m);
        rate_[i] = rates.moving_m;
        turning[i] = rates.turning;
    }
    double way_m = 0, turned = 0;
    for (std::size_t i = 1; i < stations; ++i) {
        const double half = (station(i) - station(i - 1)) / 2;
        way_m += half * (rate_[i] + rate_[i - 1]);
        turned += half * (turning[i] + turning[i - 1]);
    }
    // A camera that only turns has its turning for a way.
    const double weight = turned == 0 ? 0 : way_m == 0 ? 1 : 0.01 * way_m / turned;
    // Where a flight reverses its derivative is zero; it must not be divided by.
    const double least = 1e-6 * (way_m + weight * turned) / (knots_.back() - knots_.front());
    for (std::size_t i = 0; i < stations; ++i) rate_[i] = std::max(rate_[i] + weight * turning[i], least);
    way_.assign(stations, 0);
    for (std::size_t i = 1; i < stations; ++i)
        way_[i] = way_[i - 1] + (station(i) - station(i - 1)) / 2 * (rate_[i] + rate_[i - 1]);
}

void PathTiming::choose_speeds(bool closed, bool eases) {
    const std::size_t last = knots_.size() - 1;
    const auto seconds = [&](std::size_t piece) { return times_s_[piece + 1] - times_s_[piece]; };
    const auto mean = [&](std::size_t piece) {
        return (way_[(piece + 1) * steps_] - way_[piece * steps_]) / seconds(piece);
    };
    // A weighted harmonic mean of the pieces' mean speeds is at most three times the slower one, which is what keeps
    // both cubics from turning back.
    const auto between = [&](std::size_t piece, std::size_t next) {
        const double before = mean(piece), after = mean(next), s = seconds(piece), r = seconds(next);
        return before > 0 && after > 0 ? 3 * (s + r) / ((2 * r + s) / before + (r + 2 * s) / after) : 0;
    };
    speed_.assign(knots_.size(), 0);
    for (std::size_t i = 1; i < last; ++i) speed_[i] = between(i - 1, i);
    if (eases) return;
    if (closed) {
        speed_[0] = speed_[last] = between(last - 1, 0);
        return;
    }
    // No second derivative at an end: between 0 and 1.5 times the mean, because its neighbour is between 0 and 3 times.
    speed_[0] = last == 1 ? mean(0) : (3 * mean(0) - speed_[1]) / 2;
    speed_[last] = last == 1 ? mean(0) : (3 * mean(last - 1) - speed_[last - 1]) / 2;
}

double PathTiming::knot_at(double time_s) const {
    if (time_s <= times_s_.front()) return knots_.front();
    if (time_s >= times_s_.back()) return knots_.back();
    const auto later = std::upper_bound(times_s_.begin(), times_s_.end(), time_s);
    const auto piece = static_cast<std::size_t>(later - times_s_.begin()) - 1;
    const std::size_t first = piece * steps_;
    const double seconds = times_s_[piece + 1] - times_s_[piece], f = (time_s - times_s_[piece]) / seconds;
    const double all = way_[first + steps_] - way_[first];
    const double s =
        all * f * f * (3 - 2 * f) + seconds * f * (1 - f) * (speed_[piece] * (1 - f) - speed_[piece + 1] * f);
    const double way = way_[first] + std::clamp(s, 0.0, all);

    const auto begin = way_.begin() + static_cast<std::ptrdiff_t>(first);
    const auto beyond = std::upper_bound(begin + 1, begin + static_cast<std::ptrdiff_t>(steps_), way);
    const auto i = static_cast<std::size_t>(beyond - way_.begin()) - 1;
    // Between two stations the rate is linear, r + a u, and the way r u + a u^2 / 2; so speeds stay continuous. This
    // form of the root does not cancel.
    const double from = station(i), step = station(i + 1) - from, r = rate_[i], a = (rate_[i + 1] - r) / step;
    const double left = way - way_[i];
    const double u = 2 * left / (r + std::sqrt(std::max(r * r + 2 * a * left, 0.0)));
    return from + std::clamp(u, 0.0, step);
}

} // namespace fjell::flight
