#include "flight/path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "fjell/pages.h"
#include "flight/path_timing.h"

namespace fjell::flight {

namespace {

using io::Failure;

constexpr double farthest_m = 1e8; // as fjell::validate(View) limits the eye

Vec3 position_of(const ControlPoint& p) {
    return {p[0], p[1], p[2]};
}
Vec3 direction_of(const ControlPoint& p) {
    return {p[3], p[4], p[5]};
}
Vec3 up_of(const ControlPoint& p) {
    return {p[6], p[7], p[8]};
}

// What a camera flies over: the ground's highest point near each of a row of stations along the path, smoothed.
//
// First every station takes the largest value within `reach` stations, then two means over reach / 2 on either side
// follow. Each value that enters the second mean is a maximum that saw the station itself, for the two means together
// look no farther than `reach`; so the envelope never lies below the ground's value at the station.
class Envelope {
public:
    Envelope(const CubicSpline<9>& spline, const Ground& ground) : first_(spline.knots().front()) {
        step_ = (spline.knots().back() - first_) / (stations - 1);
        std::vector<double> height(stations);
        for (std::size_t i = 0; i < stations; ++i) {
            const auto p = spline.at(first_ + static_cast<double>(i) * step_);
            height[i] = highest_near(ground, p[0] * ground.extent_x_m, p[2] * ground.extent_z_m);
        }
        const auto largest = [](std::span<const double> s) { return *std::max_element(s.begin(), s.end()); };
        const auto mean = [](std::span<const double> s) {
            double sum = 0;
            for (const double h : s) sum += h;
            return sum / static_cast<double>(s.size());
        };
        height_ = windowed(windowed(windowed(height, reach, largest), reach / 2, mean), reach / 2, mean);
    }

    [[nodiscard]] double at(double t) const {
        const double s = std::clamp((t - first_) / step_, 0.0, stations - 1.0);
        const auto i = std::min(static_cast<std::size_t>(s), stations - 2);
        const double b = s - static_cast<double>(i);
        return height_[i] * (1 - b) + height_[i + 1] * b;
    }

private:
    static constexpr std::size_t stations = 1024, reach = 24;

    // The highest of 9x9 places within a hundredth of the terrain's longer extent.
    static double highest_near(const Ground& ground, double x_m, double z_m) {
        const double step = 0.01 * ground.longer_m() / 4;
        double highest = ground.height_m(x_m, z_m);
        for (int j = -4; j <= 4; ++j)
            for (int i = -4; i <= 4; ++i) highest = std::max(highest, ground.height_m(x_m + i * step, z_m + j * step));
        return highest;
    }

    template <typename Reduce>
    static std::vector<double> windowed(const std::vector<double>& from, std::size_t around, const Reduce& reduce) {
        std::vector<double> to(from.size());
        for (std::size_t i = 0; i < from.size(); ++i) {
            const std::size_t begin = i < around ? 0 : i - around, end = std::min(i + around + 1, from.size());
            to[i] = reduce(std::span(from).subspan(begin, end - begin));
        }
        return to;
    }

    double first_, step_ = 1;
    std::vector<double> height_;
};

// Orthonormal or a Failure that says which part cannot be.
Pose make_pose(Vec3 position_m, Vec3 direction, Vec3 up, const CameraPath& path, std::size_t frame) {
    const auto fail = [&](const char* what) {
        throw Failure(1, fmt::format("{}: frame {}: {}", path.name, frame, what));
    };
    if (!(length(position_m) <= farthest_m)) fail("the camera leaves the range of 1e8 m; bring the points nearer");
    const Vec3 forward = normalised(direction);
    // Interpolated directions that nearly cancel would spin the camera within a frame; 1e-3 of a unit vector is noise.
    if (!(length(direction) > 1e-3)) fail("the direction vanishes between two points; add a point between them");
    const Vec3 across = up - forward * dot(up, forward);
    if (!(length(across) > 1e-3)) fail("up is parallel to the direction between two points; add a point between them");
    return {position_m, forward, normalised(across)};
}

bool is_still(const SplinePath& path) {
    const std::vector<double>& knots = path.spline.knots();
    return knots.size() == 2 && path.spline.at(knots[0]) == path.spline.at(knots[1]);
}

// Metres of one unit of a position.
Vec3 unit_m(Units units, const Ground& ground) {
    switch (units) {
    case Units::metres: break;
    case Units::recorded: return Vec3{1, 1, 1} * ground.extent_x_m;
    case Units::terrain: return {ground.extent_x_m, ground.longer_m(), ground.extent_z_m};
    }
    return {1, 1, 1};
}

// Places on the spline at those shares of the flight.
std::vector<double> knots_at(const CameraPath& path, const SplinePath& kind, const Ground& ground,
                             std::span<const double> share) {
    const std::vector<double>& knots = kind.spline.knots();
    std::vector<double> at(share.size());
    if (kind.times_s.empty() || is_still(kind)) {
        // A still camera stays at its point, without the rounding of what lies between two of them.
        const double first = knots.front(), last = is_still(kind) ? first : knots.back();
        for (std::size_t i = 0; i < at.size(); ++i) at[i] = first + (last - first) * share[i];
        return at;
    }
    const PathTiming timing(kind.spline, kind.times_s, unit_m(path.units, ground), kind.eases);
    for (std::size_t i = 0; i < at.size(); ++i) at[i] = timing.knot_at(share[i] * kind.times_s.back());
    return at;
}

// What the camera looks along and its upward axis, there on the spline, where p is the spline's own.
struct Facing {
    Vec3 direction, up;
};
Facing facing_at(const SplinePath& path, double t, const ControlPoint& p) {
    const Facing own{direction_of(p), up_of(p)};
    if (path.targets.empty()) return own;
    const std::vector<double>& knots = path.spline.knots();
    const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, t);
    const auto i = static_cast<std::size_t>(above - knots.begin()) - 1;
    const auto facing = [&](const std::optional<Vec3>& target) {
        return target ? Facing{normalised(*target - position_of(p)), {0, 1, 0}} : own;
    };
    const std::optional<Vec3>&from = path.targets[i], &to = path.targets[i + 1];
    const Facing a = facing(from);
    if (from.has_value() == to.has_value() && (!from || length(*from - *to) == 0)) return a;
    const Facing b = facing(to);
    const double f = std::clamp((t - knots[i]) / (knots[i + 1] - knots[i]), 0.0, 1.0), w = f * f * (3 - 2 * f);
    return {a.direction * (1 - w) + b.direction * w, a.up * (1 - w) + b.up * w};
}

std::vector<Pose> resample_spline(const CameraPath& path, const SplinePath& kind, const Ground& ground,
                                  std::span<const double> share) {
    const CubicSpline<9>& spline = kind.spline;
    const std::vector<double> knots = knots_at(path, kind, ground, share);
    std::vector<Pose> poses;
    poses.reserve(share.size());
    const auto add = [&](const auto& place) {
        for (const double t : knots) {
            const ControlPoint p = spline.at(t);
            const Facing facing = facing_at(kind, t, p);
            poses.push_back(make_pose(place(position_of(p), t), facing.direction, facing.up, path, poses.size()));
        }
    };
    switch (path.units) {
    case Units::metres: add([](Vec3 p, double) { return p; }); break;
    case Units::recorded:
        add([&](Vec3 p, double) { return Vec3{0, 0, ground.extent_z_m} + p * ground.extent_x_m; });
        break;
    case Units::terrain: {
        const Envelope envelope(spline, ground);
        add([&](Vec3 p, double t) {
            return Vec3{p.x * ground.extent_x_m, envelope.at(t) + p.y * ground.longer_m(), p.z * ground.extent_z_m};
        });
        break;
    }
    }
    return poses;
}

double highest_on(std::size_t places, const Ground& ground, const std::function<Vec3(double)>& at) {
    double highest = -farthest_m;
    for (std::size_t i = 0; i <= places; ++i) {
        const Vec3 p = at(static_cast<double>(i) / static_cast<double>(places));
        highest = std::max(highest, ground.height_m(p.x, p.z));
    }
    return highest;
}

constexpr std::size_t places_on_the_way = 4096;

std::vector<Pose> resample_orbit(const CameraPath& path, const Orbit& orbit, const Ground& ground,
                                 std::span<const double> share) {
    const bool metres = path.units == Units::metres;
    const Area all{0, 0, ground.extent_x_m, ground.extent_z_m}, area = orbit.over_start ? ground.start_area() : all;
    const double unit = metres ? 1 : area.longer_m();
    Vec3 centre{orbit.centre_x * (metres ? 1 : area.width_m), 0, orbit.centre_z * (metres ? 1 : area.depth_m)};
    if (!metres) centre.x += area.x_m, centre.z += area.z_m;
    centre.y = ground.height_m(centre.x, centre.z);
    // The first frame looks north; then the camera goes round clockwise, seen from above.
    const auto on_circle = [&](double s) {
        const double angle = 2 * std::numbers::pi * orbit.turns * s;
        return centre + Vec3{-std::sin(angle), 0, std::cos(angle)} * (orbit.radius * unit);
    };
    const double base_m = metres ? 0 : highest_on(places_on_the_way, ground, on_circle);
    std::vector<Pose> poses;
    poses.reserve(share.size());
    for (const double s : share) {
        Vec3 eye = on_circle(s);
        eye.y = base_m + orbit.height * unit;
        poses.push_back(make_pose(eye, centre - eye, {0, 1, 0}, path, poses.size()));
    }
    return poses;
}

std::vector<Pose> resample_straight(const CameraPath& path, const Straight& line, const Ground& ground,
                                    std::span<const double> share) {
    const bool metres = path.units == Units::metres;
    const auto place = [&](Vec3 p) {
        return metres ? p : Vec3{p.x * ground.extent_x_m, p.y * ground.longer_m(), p.z * ground.extent_z_m};
    };
    Vec3 from = place(line.from);
    const Vec3 to = place(line.to), way = to - from, forward = normalised(way);
    const auto frames = static_cast<double>(share.size());
    const Vec3 whole = line.cells_per_frame > 0 ? forward * (line.cells_per_frame * ground.cell_m * (frames - 1)) : way;
    if (!metres) from.y += highest_on(places_on_the_way, ground, [&](double s) { return from + whole * s; });
    // Pitch turns the view about the axis to the right of the flight.
    const Vec3 right = normalised(cross(forward, {0, 1, 0}));
    const double pitch = line.pitch_deg * std::numbers::pi / 180;
    const Vec3 direction = forward * std::cos(pitch) + cross(right, forward) * std::sin(pitch);
    std::vector<Pose> poses;
    poses.reserve(share.size());
    for (const double s : share) poses.push_back(make_pose(from + whole * s, direction, {0, 1, 0}, path, poses.size()));
    return poses;
}

// splitmix64, because the standard's distributions differ from library to library.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double between(double least, double most) {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return least + (most - least) * static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

} // namespace

Ground ground_of(const Terrain& terrain) {
    const PackHeader& h = terrain.header();
    Ground ground;
    ground.extent_x_m = (h.columns - 1) * h.spacing_m[0];
    ground.extent_z_m = (h.rows - 1) * h.spacing_m[1];
    ground.cell_m = std::min(h.spacing_m[0], h.spacing_m[1]);
    ground.height_m = [terrain](double x_m, double z_m) { return terrain_height_m(terrain, x_m, z_m); };
    return ground;
}

std::vector<double> chord_knots(std::span<const ControlPoint> points, const std::string& name) {
    if (points.size() == 2 && points[0] == points[1]) return {0, 1}; // a still camera
    std::vector<double> chord(points.size(), 0), turn(points.size(), 0);
    double all_chords = 0, all_turns = 0;
    for (std::size_t i = 1; i < points.size(); ++i) {
        const ControlPoint &a = points[i - 1], &b = points[i];
        chord[i] = length(position_of(b) - position_of(a));
        turn[i] = length(normalised(direction_of(b)) - normalised(direction_of(a))) +
                  length(normalised(up_of(b)) - normalised(up_of(a)));
        if (chord[i] + turn[i] == 0)
            throw Failure(1, fmt::format("{}: points[{}] repeats the point before it; remove one of them", name, i));
        all_chords += chord[i];
        all_turns += turn[i];
    }
    std::vector<double> knots(points.size(), 0);
    for (std::size_t i = 1; i < points.size(); ++i)
        knots[i] = knots[i - 1] + (all_chords > 0 ? 0.9 * chord[i] / all_chords : 0) +
                   (all_turns > 0 ? 0.1 * turn[i] / all_turns : 0);
    return knots;
}

CameraPath still_path(const ControlPoint& point, const std::string& name) {
    const ControlPoint unit = unit_point(point);
    return {name, Units::metres, SplinePath{CubicSpline<9>({0, 1}, {unit, unit})}};
}

CameraPath random_path(std::uint64_t seed) {
    Random random(seed);
    std::vector<ControlPoint> points;
    double x = random.between(0.2, 0.8), z = random.between(0.2, 0.8),
           heading = random.between(0, 2 * std::numbers::pi);
    for (int i = 0; i < 10; ++i) {
        const Vec3 forward{std::sin(heading), random.between(-0.35, -0.05), -std::cos(heading)};
        points.push_back({x, random.between(0.002, 0.02), z, forward.x, forward.y, forward.z, 0, 1, 0});
        x += 0.1 * forward.x;
        z += 0.1 * forward.z;
        // Near the rim turn back to the middle, otherwise wander.
        if (std::min({x, z, 1 - x, 1 - z}) < 0.15)
            heading = std::atan2(0.5 - x, z - 0.5);
        else
            heading += random.between(-0.8, 0.8);
    }
    CameraPath path;
    path.name = fmt::format("random path {}", seed);
    path.units = Units::terrain;
    std::vector<double> knots = chord_knots(points, path.name);
    path.kind = SplinePath{CubicSpline<9>(std::move(knots), std::move(points))};
    return path;
}

std::vector<double> shares(const SplinePath& path) {
    const std::vector<double>& from = path.times_s.empty() ? path.spline.knots() : path.times_s;
    std::vector<double> shares;
    shares.reserve(from.size());
    for (const double at : from) shares.push_back((at - from.front()) / (from.back() - from.front()));
    return shares;
}

std::vector<Pose> resample(const CameraPath& path, const Ground& ground, std::size_t frames) {
    std::vector<double> share(frames, 0);
    for (std::size_t i = 1; i < frames; ++i) share[i] = static_cast<double>(i) / static_cast<double>(frames - 1);
    if (const auto* spline = std::get_if<SplinePath>(&path.kind)) return resample_spline(path, *spline, ground, share);
    if (const auto* orbit = std::get_if<Orbit>(&path.kind)) return resample_orbit(path, *orbit, ground, share);
    return resample_straight(path, std::get<Straight>(path.kind), ground, share);
}

} // namespace fjell::flight
