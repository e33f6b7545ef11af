#include "shared/stamp.h"

#include <cmath>
#include <limits>

#include "fjell/texture.h"

namespace fjell::edit {

namespace {

constexpr double unchanged = std::numeric_limits<double>::quiet_NaN();

double smooth_step(double t) {
    return t * t * (3 - 2 * t);
}

// 1 up to radius_m, 0 from falloff_m further on.
double weight_at(const Stamp& stamp, double away_m) {
    const double beyond = away_m - static_cast<double>(stamp.radius_m);
    if (beyond <= 0) return 1;
    return beyond < static_cast<double>(stamp.falloff_m)
               ? 1 - smooth_step(beyond / static_cast<double>(stamp.falloff_m))
               : 0;
}

// The nearest point of the line through a path's points: how far away, and how high it is there.
struct OnPath {
    double away_m = std::numeric_limits<double>::infinity(), height_m = 0;
};
OnPath nearest_on_path(const Stamp& stamp, double x, double z) {
    OnPath nearest;
    for (std::uint32_t k = 0; k + 1 < stamp.point_count; ++k) {
        const StampPoint &a = stamp.points[k], &b = stamp.points[k + 1];
        const double dx = b.x_m - a.x_m, dz = b.z_m - a.z_m, squared = dx * dx + dz * dz;
        const double along =
            squared > 0 ? std::min(std::max(((x - a.x_m) * dx + (z - a.z_m) * dz) / squared, 0.0), 1.0) : 0;
        const double away_x = x - (a.x_m + along * dx), away_z = z - (a.z_m + along * dz);
        const double away_m = std::sqrt(away_x * away_x + away_z * away_z);
        if (away_m >= nearest.away_m) continue;
        const double from = a.height_m, to = b.height_m;
        nearest = {away_m, from + along * (to - from)};
    }
    return nearest;
}

double lattice(std::int64_t i, std::int64_t j, std::uint32_t seed) { // -1 to 1
    std::uint64_t h = static_cast<std::uint64_t>(i) * 0x9e37'79b9'7f4a'7c15 ^
                      static_cast<std::uint64_t>(j) * 0xc2b2'ae3d'27d4'eb4f ^
                      (std::uint64_t{seed} + 1) * 0x1656'67b1'9e37'79f9;
    h = (h ^ h >> 29) * 0xbf58'476d'1ce4'e5b9;
    h ^= h >> 32;
    return static_cast<double>(h & 0xffff'ffff) * 0x1p-31 - 1;
}
double noise(double x, double z, std::uint32_t seed) {
    const double i = std::floor(x), j = std::floor(z), u = smooth_step(x - i), v = smooth_step(z - j);
    const auto at = [&](int di, int dj) {
        return lattice(static_cast<std::int64_t>(i) + di, static_cast<std::int64_t>(j) + dj, seed);
    };
    const double north = at(0, 0) + (at(1, 0) - at(0, 0)) * u, south = at(0, 1) + (at(1, 1) - at(0, 1)) * u;
    return north + (south - north) * v;
}

// A bowl: its floor amount_m deep, its edge at radius_m; a rim of a fifth of that outside, which fades out.
double crater_m(const Stamp& stamp, double away_m) {
    constexpr double rim = 0.2;
    const double depth = stamp.amount_m, radius = stamp.radius_m;
    if (away_m < radius) {
        const double r = away_m / radius;
        return depth * ((1 + rim) * r * r - 1);
    }
    return depth * rim * weight_at(stamp, away_m);
}

bool along_path(const Stamp& stamp) {
    return stamp.shape == StampShape::path || (!moves_ground(stamp.shape) && stamp.point_count != 0);
}
// How far beyond its centre, or its line, a stamp applies.
double reach_m(const StampGrid& grid, const Stamp& stamp) {
    const double radius_m = stamp.radius_m;
    return locks(stamp.shape) ? radius_m + std::hypot(grid.spacing_m[0], grid.spacing_m[1])
                              : radius_m + static_cast<double>(stamp.falloff_m);
}
bool by_distance(const Stamp& stamp) { // otherwise by its rectangle alone
    return stamp.shape != StampShape::heights && !(stamp.columns > 0 && stamp.radius_m == 0);
}
double away_from(const Stamp& stamp, double x_m, double z_m) {
    if (along_path(stamp)) return nearest_on_path(stamp, x_m, z_m).away_m;
    const double dx = x_m - stamp.x_m, dz = z_m - stamp.z_m;
    return std::sqrt(dx * dx + dz * dz);
}
double away_from(const StampGrid& grid, const Stamp& stamp, SampleIndex sample) {
    return away_from(stamp, sample.column * grid.spacing_m[0], sample.row * grid.spacing_m[1]);
}
// How much of it happens, by strength and mask.
double share_of(const Stamp& stamp, SampleIndex sample) {
    const double strength = stamp.strength;
    if (stamp.columns == 0 || stamp.mask == nullptr) return strength;
    const std::size_t at =
        static_cast<std::size_t>(sample.row - stamp.first.row) * static_cast<std::size_t>(stamp.columns) +
        static_cast<std::size_t>(sample.column - stamp.first.column);
    return strength * (stamp.mask[at] / 255.0);
}

} // namespace

Rect samples_of(const StampGrid& grid, const Stamp& stamp) {
    Rect all{0, 0, grid.columns - 1, grid.rows - 1};
    if (stamp.columns > 0)
        all = all.within({stamp.first.column, stamp.first.row, stamp.first.column + stamp.columns - 1,
                          stamp.first.row + stamp.rows - 1});
    if (!by_distance(stamp)) return all;
    double x0 = stamp.x_m, x1 = stamp.x_m, z0 = stamp.z_m, z1 = stamp.z_m;
    if (along_path(stamp)) {
        x0 = x1 = stamp.points[0].x_m, z0 = z1 = stamp.points[0].z_m;
        for (std::uint32_t k = 1; k < stamp.point_count; ++k) {
            x0 = std::min(x0, stamp.points[k].x_m), x1 = std::max(x1, stamp.points[k].x_m);
            z0 = std::min(z0, stamp.points[k].z_m), z1 = std::max(z1, stamp.points[k].z_m);
        }
    }
    const double out = reach_m(grid, stamp);
    const auto place = [](double at, double spacing, std::int32_t last) {
        return static_cast<std::int32_t>(std::min(std::max(at / spacing, -1.0), last + 1.0));
    };
    const double sx = grid.spacing_m[0], sz = grid.spacing_m[1];
    const std::int32_t last_x = grid.columns - 1, last_y = grid.rows - 1;
    return all.within({static_cast<std::int32_t>(std::ceil(std::min(std::max((x0 - out) / sx, 0.0), last_x + 1.0))),
                       static_cast<std::int32_t>(std::ceil(std::min(std::max((z0 - out) / sz, 0.0), last_y + 1.0))),
                       x1 + out < 0 ? -1 : place(x1 + out, sx, last_x),
                       z1 + out < 0 ? -1 : place(z1 + out, sz, last_y)});
}

bool may_change(const StampGrid& grid, const Stamp& stamp, const Rect& samples) {
    if (!by_distance(stamp)) return true;
    const double sx = grid.spacing_m[0], sz = grid.spacing_m[1], x = 0.5 * (samples.x0 + samples.x1) * sx,
                 z = 0.5 * (samples.y0 + samples.y1) * sz, half_x = 0.5 * samples.columns() * sx,
                 half_z = 0.5 * samples.rows() * sz;
    return away_from(stamp, x, z) <= reach_m(grid, stamp) + std::hypot(half_x, half_z);
}

double stamp_weight(const StampGrid& grid, const Stamp& stamp, SampleIndex sample) {
    const double share = share_of(stamp, sample);
    return by_distance(stamp) ? share * weight_at(stamp, away_from(grid, stamp, sample)) : share;
}

bool locks_sample(const StampGrid& grid, const Stamp& stamp, SampleIndex sample) {
    return share_of(stamp, sample) >= 0.5 &&
           (!by_distance(stamp) || away_from(grid, stamp, sample) <= reach_m(grid, stamp));
}

double stamped_m(const StampGrid& grid, const Stamp& stamp, SampleIndex sample, const Surroundings& now) {
    const double x = sample.column * grid.spacing_m[0], z = sample.row * grid.spacing_m[1];
    double weight = share_of(stamp, sample), path_m = 0;
    double away_m = 0;
    if (stamp.shape == StampShape::path) {
        const OnPath nearest = nearest_on_path(stamp, x, z);
        away_m = nearest.away_m, path_m = nearest.height_m;
    } else if (by_distance(stamp)) {
        const double dx = x - stamp.x_m, dz = z - stamp.z_m;
        away_m = std::sqrt(dx * dx + dz * dz);
    }
    if (by_distance(stamp) && stamp.shape != StampShape::crater) weight *= weight_at(stamp, away_m);
    if (weight == 0) return unchanged;
    const auto towards = [&](double target_m) { return now.height_m + (target_m - now.height_m) * weight; };
    const double amount = stamp.amount_m;
    switch (stamp.shape) {
    case StampShape::raise: return now.height_m + amount * weight;
    case StampShape::level:
        return towards(static_cast<double>(stamp.height_m) + static_cast<double>(stamp.slope_x) * (x - stamp.x_m) +
                       static_cast<double>(stamp.slope_z) * (z - stamp.z_m));
    case StampShape::crater: {
        const double by_m = crater_m(stamp, away_m) * weight;
        return by_m == 0 ? unchanged : now.height_m + by_m;
    }
    case StampShape::path: return towards(path_m);
    case StampShape::noise: {
        const double wave = stamp.wavelength_m;
        return now.height_m + amount * weight * noise(x / wave, z / wave, stamp.seed);
    }
    case StampShape::smooth: return towards(now.mean_m);
    case StampShape::heights: {
        const std::size_t at =
            static_cast<std::size_t>(sample.row - stamp.first.row) * static_cast<std::size_t>(stamp.columns) +
            static_cast<std::size_t>(sample.column - stamp.first.column);
        const double height_m = stamp.heights_m[at];
        return std::isnan(height_m) ? unchanged : towards(height_m);
    }
    case StampShape::paint:
    case StampShape::unpaint:
    case StampShape::hole:
    case StampShape::fill:
    case StampShape::lock:
    case StampShape::unlock: return unchanged;
    case StampShape::restore: break;
    }
    return weight == 1 ? now.pack_m : towards(now.pack_m);
}

HoleChange hole_change(const StampGrid& grid, const Stamp& stamp, SampleIndex sample) {
    const bool back = stamp.shape == StampShape::restore;
    if ((!back && !makes_or_fills_holes(stamp.shape)) || stamp_weight(grid, stamp, sample) < 0.5)
        return HoleChange::none;
    return back ? HoleChange::as_in_pack : stamp.shape == StampShape::hole ? HoleChange::cut : HoleChange::fill;
}

} // namespace fjell::edit

namespace fjell {

Status check_stamp(const Stamp& s) {
    const auto bad = [](const char* field) { return Status{StatusCode::out_of_range, field}; };
    const auto finite = [](double v) { return std::abs(v) < 1e9; };
    if (static_cast<std::uint32_t>(s.shape) > static_cast<std::uint32_t>(StampShape::unlock))
        return bad("Stamp::shape");
    if (!finite(s.x_m)) return bad("Stamp::x_m");
    if (!finite(s.z_m)) return bad("Stamp::z_m");
    if (!(s.radius_m >= 0) || !finite(s.radius_m)) return bad("Stamp::radius_m");
    if (!(s.falloff_m >= 0) || !finite(s.falloff_m)) return bad("Stamp::falloff_m");
    if (!finite(s.amount_m)) return bad("Stamp::amount_m");
    if (!finite(s.height_m)) return bad("Stamp::height_m");
    if (!finite(s.slope_x)) return bad("Stamp::slope_x");
    if (!finite(s.slope_z)) return bad("Stamp::slope_z");
    if (!(s.morph_s >= 0) || !finite(s.morph_s)) return bad("Stamp::morph_s");
    if (!(s.strength >= 0 && s.strength <= 1)) return bad("Stamp::strength");
    if (s.columns < 0 || s.rows < 0 || (s.columns == 0) != (s.rows == 0) || s.columns > std::int32_t{max_columns} ||
        s.rows > std::int32_t{max_columns})
        return bad("Stamp::columns, rows");
    if (std::abs(s.first.column) > std::int32_t{max_columns} || std::abs(s.first.row) > std::int32_t{max_columns})
        return bad("Stamp::first");
    if (s.mask != nullptr && s.columns == 0) return bad("Stamp::mask (needs columns and rows)");
    switch (s.shape) {
    case StampShape::crater:
        if (!(s.radius_m > 0)) return bad("Stamp::radius_m (0 for a crater)");
        break;
    case StampShape::noise:
        if (!(s.wavelength_m > 0) || !finite(s.wavelength_m)) return bad("Stamp::wavelength_m");
        break;
    case StampShape::heights:
        if (s.heights_m == nullptr || s.columns == 0) return bad("Stamp::heights_m");
        break;
    case StampShape::paint:
    case StampShape::unpaint:
        if (s.material >= max_splat_names && s.material != no_material) return bad("Stamp::material");
        break;
    case StampShape::lock:
        if (!(s.amount_m >= 0)) return bad("Stamp::amount_m");
        break;
    default: break;
    }
    if (s.shape == StampShape::path || (s.point_count != 0 && !edit::moves_ground(s.shape))) {
        if (s.points == nullptr || s.point_count < 2 || s.point_count > max_path_points) return bad("Stamp::points");
        for (std::uint32_t k = 0; k < s.point_count; ++k)
            if (!finite(s.points[k].x_m) || !finite(s.points[k].z_m) || !finite(s.points[k].height_m))
                return bad("Stamp::points");
    }
    return {};
}

} // namespace fjell
