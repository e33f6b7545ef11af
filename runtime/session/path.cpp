#include "session/path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <span>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "fjell/pages.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::session {

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

std::vector<Pose> resample_spline(const CameraPath& path, const SplinePath& kind, const Ground& ground,
                                  std::span<const double> share) {
    const CubicSpline<9>& spline = kind.spline;
    // A still camera stays at its point, without the rounding of what lies between two of them.
    const double first = spline.knots().front(), last = is_still(kind) ? first : spline.knots().back();
    std::vector<Pose> poses;
    poses.reserve(share.size());
    const auto add = [&](const auto& place) {
        for (const double s : share) {
            const double t = first + (last - first) * s;
            const ControlPoint p = spline.at(t);
            poses.push_back(make_pose(place(position_of(p), t), direction_of(p), up_of(p), path, poses.size()));
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
    const std::vector<double>& knots = path.spline.knots();
    std::vector<double> shares;
    shares.reserve(knots.size());
    for (const double at : knots) shares.push_back((at - knots.front()) / (knots.back() - knots.front()));
    return shares;
}

std::vector<Pose> resample(const CameraPath& path, const Ground& ground, std::size_t frames) {
    std::vector<double> share(frames, 0);
    for (std::size_t i = 1; i < frames; ++i) share[i] = static_cast<double>(i) / static_cast<double>(frames - 1);
    if (const auto* spline = std::get_if<SplinePath>(&path.kind)) return resample_spline(path, *spline, ground, share);
    if (const auto* orbit = std::get_if<Orbit>(&path.kind)) return resample_orbit(path, *orbit, ground, share);
    return resample_straight(path, std::get<Straight>(path.kind), ground, share);
}

// --- Paths from text and to it: our JSON, and frames recorded by G3dOGL (H. Hoppe's terrain viewer), one line
// `F level  view(3)  left(3)  up(3)  position(3)  zoom` each.

namespace {

using nlohmann::json;

constexpr double largest_number = 1e8;
constexpr std::size_t most_points = 1'000'000;
constexpr std::string_view removed_keys[] = {"closed", "ease", "time_s", "look_at"}; // of version 0.2

[[noreturn]] void fail(const std::string& name, const std::string& where, const std::string& what) {
    throw Failure(1, where.empty() ? fmt::format("{}: {}", name, what) : fmt::format("{}: {}: {}", name, where, what));
}

// One JSON object with its place in the file; asks for keys by name and refuses those nobody asked for.
class Fields {
public:
    Fields(const json& object, std::string name, std::string where)
        : object_(object), name_(std::move(name)), where_(std::move(where)) {
        if (!object_.is_object()) bad("must be an object { ... }");
    }

    [[noreturn]] void bad(const std::string& what) const { fail(name_, where_, what); }
    [[noreturn]] void bad(const char* key, const std::string& what) const { fail(name_, place(key), what); }

    [[nodiscard]] const json* find(const char* key) {
        known_.insert(key);
        const auto at = object_.find(key);
        return at == object_.end() ? nullptr : &*at;
    }
    double number(const char* key, double otherwise, double least, double most) {
        const json* value = find(key);
        if (!value) return otherwise;
        if (!value->is_number()) bad(key, "must be a number");
        const double v = value->get<double>();
        if (!(v >= least && v <= most)) bad(key, fmt::format("must be from {} to {}", least, most));
        return v;
    }
    // An array of `count` numbers.
    std::vector<double> numbers(const char* key, std::size_t count) {
        const json* value = find(key);
        if (!value) bad(key, fmt::format("is missing; give {} numbers", count));
        if (!value->is_array() || value->size() != count) bad(key, fmt::format("must be {} numbers", count));
        std::vector<double> result;
        for (const json& v : *value) {
            if (!v.is_number() || !(std::abs(v.get<double>()) <= largest_number))
                bad(key, fmt::format("must be {} numbers within 1e8", count));
            result.push_back(v.get<double>());
        }
        return result;
    }
    Vec3 vector(const char* key) {
        const std::vector<double> v = numbers(key, 3);
        return {v[0], v[1], v[2]};
    }
    // Call when all keys have been asked for. "comment" is allowed everywhere.
    void refuse_others() {
        known_.insert("comment");
        for (const auto& [key, value] : object_.items())
            if (!known_.contains(key))
                bad(key.c_str(), std::ranges::find(removed_keys, key) == std::end(removed_keys)
                                     ? "unknown key; remove it"
                                     : "is not read any more: paths have no times, targets or closing; remove it");
    }
    [[nodiscard]] std::string place(const std::string& key) const { return where_.empty() ? key : where_ + "." + key; }

private:
    const json& object_;
    std::string name_, where_;
    std::set<std::string> known_;
};

std::string place_of(std::size_t point) {
    return fmt::format("points[{}]", point);
}

ControlPoint control_point(const json& value, const std::string& name, std::size_t index) {
    Fields fields(value, name, place_of(index));
    const Vec3 position = fields.vector("position"), direction = fields.vector("direction");
    const Vec3 up = fields.find("up") ? fields.vector("up") : Vec3{0, 1, 0};
    fields.refuse_others();
    if (!(length(direction) > 1e-9)) fields.bad("direction", "is zero; give the way the camera looks");
    if (!(length(up) > 1e-9)) fields.bad("up", "is zero; give the camera's upward axis, e.g. [0, 1, 0]");
    const ControlPoint p =
        unit_point({position.x, position.y, position.z, direction.x, direction.y, direction.z, up.x, up.y, up.z});
    if (!(length(cross({p[3], p[4], p[5]}, {p[6], p[7], p[8]})) > 1e-3))
        fields.bad("up", "is parallel to direction; give another up");
    return p;
}

SplinePath spline_path(const json& value, const std::string& name) {
    if (!value.is_array()) fail(name, "points", "must be an array of control points");
    if (value.empty()) fail(name, "points", "a path needs a control point; add some");
    if (value.size() > most_points) fail(name, "points", "more than 1,000,000 control points; thin them out");
    std::vector<ControlPoint> points;
    points.reserve(value.size());
    for (const json& point : value) points.push_back(control_point(point, name, points.size()));
    if (points.size() == 1) points.push_back(points[0]);
    std::vector<double> knots = chord_knots(points, name);
    return {CubicSpline<9>(std::move(knots), std::move(points))};
}

Orbit orbit(const json& value, const std::string& name, Units units) {
    Fields fields(value, name, "orbit");
    Orbit o;
    const bool needed = units == Units::metres; // the defaults are shares of the terrain
    if (needed || fields.find("centre")) {
        const std::vector<double> centre = fields.numbers("centre", 2);
        o.centre_x = centre[0];
        o.centre_z = centre[1];
    }
    if (needed)
        for (const char* key : {"radius", "height"})
            if (!fields.find(key)) fields.bad(key, "is missing; give metres, or use units \"terrain\"");
    o.radius = fields.number("radius", o.radius, 1e-6, largest_number);
    o.height = fields.number("height", o.height, -largest_number, largest_number);
    o.turns = fields.number("turns", o.turns, -1000, 1000);
    fields.refuse_others();
    return o;
}

Straight straight(const json& value, const std::string& name) {
    Fields fields(value, name, "straight");
    Straight s;
    s.from = fields.vector("from");
    s.to = fields.vector("to");
    s.cells_per_frame = fields.number("cells_per_frame", 0, 0, 1e6);
    s.pitch_deg = fields.number("pitch_deg", 0, -89, 89);
    fields.refuse_others();
    if (s.from.x == s.to.x && s.from.z == s.to.z) fields.bad("to", "must lie north, south, east or west of from");
    return s;
}

CameraPath parse_json(std::string_view text, const std::string& name) {
    const json root = io::parse_json(text, name, io::JsonComments::yes);
    Fields fields(root, name, "");
    CameraPath path;
    path.name = name;
    if (const json* units = fields.find("units")) {
        if (*units == "metres")
            path.units = Units::metres;
        else if (*units == "terrain")
            path.units = Units::terrain;
        else
            fields.bad("units", "must be \"metres\" or \"terrain\"");
    }
    path.seconds = fields.number("seconds", 0, 0, max_path_seconds);
    const json *points = fields.find("points"), *around = fields.find("orbit"), *line = fields.find("straight");
    if ((points != nullptr) + (around != nullptr) + (line != nullptr) != 1)
        fields.bad("a path has exactly one of points, orbit and straight");
    fields.refuse_others();
    if (points)
        path.kind = spline_path(*points, name);
    else if (around)
        path.kind = orbit(*around, name, path.units);
    else
        path.kind = straight(*line, name);
    return path;
}

// The shortest digits that read back to the same double.
std::string numbers_text(std::span<const double> values) {
    std::string text = "[";
    for (const double v : values) text += fmt::format("{}{}", text.size() > 1 ? ", " : "", v);
    return text + "]";
}
std::string vector_text(const Vec3& v) {
    return numbers_text(std::array{v.x, v.y, v.z});
}

std::string points_text(const SplinePath& path) {
    std::string text = "\"points\": [";
    const std::vector<double>& knots = path.spline.knots();
    for (std::size_t i = 0; i < knots.size(); ++i) { // where the spline is exactly the point
        const ControlPoint p = unit_point(path.spline.at(knots[i]));
        const std::span<const double> all(p);
        text += fmt::format("{}\n    {{\"position\": {}, \"direction\": {}, \"up\": {}}}", i == 0 ? "" : ",",
                            numbers_text(all.subspan(0, 3)), numbers_text(all.subspan(3, 3)),
                            numbers_text(all.subspan(6, 3)));
    }
    return text + "\n  ]";
}

// The recording's frame has x east, y north, z up, in multiples of the DEM's width, from its south-west corner. It says
// so itself: view x left = up makes it right-handed with z up, its speed along the view is even, and the camera then
// follows the valleys, which no other placing of the rectangle gives.
ControlPoint recorded_frame(const std::array<double, 14>& f) {
    return {f[10], f[12], -f[11], f[1], f[3], -f[2], f[7], f[9], -f[8]};
}

CameraPath parse_recorded(std::string_view text, const std::string& name) {
    std::vector<ControlPoint> points;
    std::istringstream lines{std::string(text)};
    std::string line;
    for (std::size_t number = 1; std::getline(lines, line); ++number) {
        if (line.empty() || line[0] != 'F') continue; // keys and reprojections in between
        std::istringstream fields(line.substr(1));
        std::array<double, 14> f{};
        for (double& v : f)
            if (!(fields >> v) || !(std::abs(v) <= largest_number))
                fail(name, fmt::format("line {}", number), "a frame is F and 14 numbers");
        points.push_back(recorded_frame(f));
        if (points.size() > most_points) fail(name, "", "more than 1,000,000 frames; cut it");
    }
    if (points.size() < 2) fail(name, "", "fewer than 2 frames; a path needs at least 2");
    // Frames were taken at even times, and the camera may stand still.
    std::vector<double> knots(points.size());
    for (std::size_t i = 0; i < knots.size(); ++i) knots[i] = static_cast<double>(i);
    CameraPath path;
    path.name = name;
    path.units = Units::recorded;
    path.kind = SplinePath{CubicSpline<9>(std::move(knots), std::move(points))};
    return path;
}

} // namespace

CameraPath parse_path(std::string_view text, const std::string& name) {
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    if (first != std::string_view::npos && text.substr(first).starts_with("F ")) return parse_recorded(text, name);
    return parse_json(text, name);
}

ControlPoint unit_point(const ControlPoint& p) {
    // Unit lengths, or a long vector would pull the interpolated direction to its side. Dividing a vector by a length
    // that is 1 but for rounding would only move its last bits, and a path that is written and read would wander.
    const auto unit = [](Vec3 v) { return std::abs(length(v) - 1) <= 0x1p-50 ? v : normalised(v); };
    const Vec3 d = unit({p[3], p[4], p[5]}), u = unit({p[6], p[7], p[8]});
    return {p[0], p[1], p[2], d.x, d.y, d.z, u.x, u.y, u.z};
}

std::string path_text(const CameraPath& path) {
    if (path.units == Units::recorded)
        fail(path.name, "", "recorded frames are not written; make control points of them first");
    std::string text = fmt::format("{{\n  \"units\": \"{}\",\n", path.units == Units::metres ? "metres" : "terrain");
    const auto* spline = std::get_if<SplinePath>(&path.kind);
    if (path.seconds > 0) text += fmt::format("  \"seconds\": {},\n", path.seconds);
    if (spline != nullptr) {
        text += "  " + points_text(*spline);
    } else if (const auto* o = std::get_if<Orbit>(&path.kind)) {
        text += fmt::format("  \"orbit\": {{\"centre\": {}, \"radius\": {}, \"height\": {}, \"turns\": {}}}",
                            numbers_text(std::array{o->centre_x, o->centre_z}), o->radius, o->height, o->turns);
    } else {
        const auto& line = std::get<Straight>(path.kind);
        text += fmt::format("  \"straight\": {{\"from\": {}, \"to\": {}, \"cells_per_frame\": {}, \"pitch_deg\": {}}}",
                            vector_text(line.from), vector_text(line.to), line.cells_per_frame, line.pitch_deg);
    }
    return text + "\n}\n";
}

CameraPath read_path(const std::string& file) {
    const std::vector<std::byte> bytes = io::read_file(file);
    return parse_path({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, file);
}

} // namespace fjell::session
