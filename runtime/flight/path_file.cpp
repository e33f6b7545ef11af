// Camera paths from text and to it: our JSON, and frames recorded by G3dOGL (H. Hoppe's terrain viewer), one line
// `F level  view(3)  left(3)  up(3)  position(3)  zoom` each.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <set>
#include <span>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "flight/path.h"
#include "flight/path_timing.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::flight {

namespace {

using io::Failure;
using nlohmann::json;

constexpr double largest_number = 1e8;
constexpr std::size_t most_points = 1'000'000;

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
    bool flag(const char* key) {
        const json* value = find(key);
        if (value && !value->is_boolean()) bad(key, "must be true or false");
        return value && value->get<bool>();
    }
    Vec3 vector(const char* key) {
        const std::vector<double> v = numbers(key, 3);
        return {v[0], v[1], v[2]};
    }
    // Call when all keys have been asked for. "comment" is allowed everywhere.
    void refuse_others() {
        known_.insert("comment");
        for (const auto& [key, value] : object_.items())
            if (!known_.contains(key)) bad(key.c_str(), "unknown key; remove it");
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

// What a point may have beside its nine numbers.
struct Extras {
    std::vector<std::optional<double>> times_s;
    std::vector<std::optional<Vec3>> targets;
};

ControlPoint control_point(const json& value, const std::string& name, std::size_t index, Extras& extras) {
    Fields fields(value, name, place_of(index));
    const Vec3 position = fields.vector("position"), direction = fields.vector("direction");
    const Vec3 up = fields.find("up") ? fields.vector("up") : Vec3{0, 1, 0};
    if (fields.find("time_s")) extras.times_s[index] = fields.number("time_s", 0, 0, max_path_seconds);
    if (fields.find("look_at")) {
        extras.targets[index] = fields.vector("look_at");
        if (length(*extras.targets[index] - position) == 0)
            fields.bad("look_at", "is where the camera is; give another");
    }
    fields.refuse_others();
    if (!(length(direction) > 1e-9)) fields.bad("direction", "is zero; give the way the camera looks");
    if (!(length(up) > 1e-9)) fields.bad("up", "is zero; give the camera's upward axis, e.g. [0, 1, 0]");
    const ControlPoint p =
        unit_point({position.x, position.y, position.z, direction.x, direction.y, direction.z, up.x, up.y, up.z});
    if (!(length(cross({p[3], p[4], p[5]}, {p[6], p[7], p[8]})) > 1e-3))
        fields.bad("up", "is parallel to direction; give another up");
    return p;
}

// All points have one or none has.
std::vector<double> times_of(const std::vector<std::optional<double>>& given, const std::string& name) {
    const auto bad = [&](std::size_t point, const std::string& what) { fail(name, place_of(point) + ".time_s", what); };
    std::vector<double> times_s;
    for (const std::optional<double>& time_s : given)
        if (time_s) times_s.push_back(*time_s);
    if (times_s.empty()) return times_s;
    for (std::size_t i = 0; i < given.size(); ++i)
        if (!given[i]) bad(i, "is missing; give it to all points or to none");
    if (const auto at = first_bad_time(times_s)) {
        if (*at == 0) bad(0, "must be 0; times count from the first point");
        bad(*at, fmt::format("must be at least {} s after the point before it, which is at {} s", least_between_times_s,
                             times_s[*at - 1]));
    }
    if (times_s.size() == 1) bad(0, "a single point has no time; remove it, or add a point");
    return times_s;
}

// The last point is the first, with another time.
void require_closed(const std::vector<ControlPoint>& points, const std::vector<std::optional<Vec3>>& targets,
                    const std::string& name) {
    const auto same = [](const std::optional<Vec3>& a, const std::optional<Vec3>& b) {
        return a.has_value() == b.has_value() && (!a || length(*a - *b) == 0);
    };
    if (points.size() < 3) fail(name, "closed", "needs at least 3 points, of which the last is the first again");
    if (points.front() != points.back() || !same(targets.front(), targets.back()))
        fail(name, place_of(points.size() - 1), "must be the first point again, because the path is closed");
}

SplinePath spline_path(const json& value, const std::string& name, Units units, bool closed, bool eases) {
    if (!value.is_array()) fail(name, "points", "must be an array of control points");
    if (value.empty()) fail(name, "points", "a path needs a control point; add some");
    if (value.size() > most_points) fail(name, "points", "more than 1,000,000 control points; thin them out");
    std::vector<ControlPoint> points;
    points.reserve(value.size());
    Extras extras;
    extras.times_s.resize(value.size());
    extras.targets.resize(value.size());
    for (const json& point : value) points.push_back(control_point(point, name, points.size(), extras));
    if (closed) require_closed(points, extras.targets, name);
    const auto looks = std::ranges::find_if(extras.targets, [](const auto& t) { return t.has_value(); });
    if (looks == extras.targets.end())
        extras.targets.clear();
    else if (units != Units::metres)
        fail(name, place_of(static_cast<std::size_t>(looks - extras.targets.begin())) + ".look_at",
             "is for units \"metres\" only; remove it, or give the path in metres");
    if (points.size() == 1) {
        points.push_back(points[0]);
        if (!extras.targets.empty()) extras.targets.push_back(extras.targets[0]);
    }
    std::vector<double> knots = chord_knots(points, name);
    SplinePath path{CubicSpline<9>(std::move(knots), std::move(points), closed), times_of(extras.times_s, name), eases,
                    std::move(extras.targets)};
    if (eases && path.times_s.empty()) fail(name, "ease", "is for points with time_s; give them times, or remove it");
    return path;
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
    const bool closed = fields.flag("closed"), eases = fields.flag("ease");
    if (!points && (closed || eases)) fields.bad(closed ? "closed" : "ease", "is for points only; remove it");
    fields.refuse_others();
    if (points) {
        SplinePath spline = spline_path(*points, name, path.units, closed, eases);
        if (!spline.times_s.empty()) {
            const double last_s = spline.times_s.back();
            if (path.seconds != 0 && path.seconds != last_s)
                fields.bad("seconds", fmt::format("must be the last point's time_s, {}; or remove it", last_s));
            path.seconds = last_s;
        }
        path.kind = std::move(spline);
    } else if (around)
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
        const std::string time = path.times_s.empty() ? "" : fmt::format("\"time_s\": {}, ", path.times_s[i]);
        const bool looks = !path.targets.empty() && path.targets[i];
        const std::string target = looks ? fmt::format(", \"look_at\": {}", vector_text(*path.targets[i])) : "";
        text += fmt::format("{}\n    {{{}\"position\": {}, \"direction\": {}, \"up\": {}{}}}", i == 0 ? "" : ",", time,
                            numbers_text(all.subspan(0, 3)), numbers_text(all.subspan(3, 3)),
                            numbers_text(all.subspan(6, 3)), target);
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
    const bool timed = spline != nullptr && !spline->times_s.empty(); // which say how long it takes
    if (path.seconds > 0 && !timed) text += fmt::format("  \"seconds\": {},\n", path.seconds);
    if (spline != nullptr) {
        if (spline->spline.closed()) text += "  \"closed\": true,\n";
        if (spline->eases) text += "  \"ease\": true,\n";
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

} // namespace fjell::flight
