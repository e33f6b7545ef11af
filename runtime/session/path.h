// Camera paths: where the camera is, and how it is held, in every frame of a flight (thesis 6.2).
//
// A path is one of
//   points    a spline over control points of position, direction and up: nine dimensions, C2; one point, or two equal
//             ones, are a still camera;
//   orbit     a circle around a point, looking at it;
//   straight  a line, at a given speed in cells a frame or from end to end;
//   recorded  frames that another program wrote down (lines `F level 3x4-matrix zoom`).
// It is resampled regularly to as many frames as asked for; direction and up are made orthonormal.
//
// Axes as everywhere: x east, y up, z south, metres, from sample (0, 0). Units of a file: "metres" takes them as they
// are. "terrain" makes a path that flies over any pack: x and z are shares 0..1 of the terrain's extents, lengths and
// heights shares of the longer extent, and heights count from the ground: along points from a smooth envelope over it,
// so that the camera glides over peaks between control points too; for orbit and straight from the highest ground on
// the way, so that the flight is level. Directions are metric in both. File formats: content/README.md. Thread:
// immutable, shareable. Failure: io::Failure with exit code 1, which names the file, the point and what to give
// instead.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "fjell/terrain.h"
#include "fjell/view.h"
#include "session/spline.h"
#include "session/start_area.h"

namespace fjell::session {

inline constexpr std::size_t default_frames = 840; // as many as in the thesis' fly-throughs

struct Pose {
    Vec3 position_m;
    Vec3 direction, up; // orthonormal
};

enum class Units : std::uint8_t {
    metres,
    terrain,
    recorded // multiples of the DEM's width, from its south-west corner; z negative to the north
};

// What a path needs to know of the terrain it crosses.
struct Ground {
    double extent_x_m = 1, extent_z_m = 1;
    double cell_m = 1;         // the smaller of the two spacings
    std::optional<Area> start; // of a sparse terrain: where there is ground (start_area.h)
    std::function<double(double x_m, double z_m)> height_m = [](double, double) { return 0.0; };

    [[nodiscard]] double longer_m() const { return extent_x_m > extent_z_m ? extent_x_m : extent_z_m; }
    [[nodiscard]] Area start_area() const { return start.value_or(Area{0, 0, extent_x_m, extent_z_m}); }
};
// terrain must outlive the result.
[[nodiscard]] Ground ground_of(const Terrain& terrain);

// Position, direction, up of a control point, in the file's units.
using ControlPoint = std::array<double, 9>;

struct SplinePath {
    CubicSpline<9> spline;
};
struct Orbit {
    double centre_x = 0.5, centre_z = 0.5;
    double radius = 0.3, height = 0.2, turns = 1;
    bool over_start = false; // shares are those of Ground::start_area(): of the flight that nobody has given a path
};
struct Straight {
    Vec3 from, to;
    double cells_per_frame = 0; // 0: from end to end
    double pitch_deg = 0;       // of the view against the flight; positive looks up
};

inline constexpr double max_path_seconds = 3600;

struct CameraPath {
    std::string name; // for messages
    Units units = Units::metres;
    std::variant<SplinePath, Orbit, Straight> kind;
    double seconds = 0; // that its flight should take, up to max_path_seconds; 0: not said
};

// The format is told from the content.
[[nodiscard]] CameraPath read_path(const std::string& file);
[[nodiscard]] CameraPath parse_path(std::string_view text, const std::string& name);
// The other way: JSON, a line a control point, that parse_path() reads back to the last bit where directions and ups
// have unit length (unit_point()). Throws Failure (1) for recorded frames, which have no text of ours.
[[nodiscard]] std::string path_text(const CameraPath& path);
// With direction and up of unit length, as parse_path() makes them; what is of unit length within rounding stays.
[[nodiscard]] ControlPoint unit_point(const ControlPoint& point);
// A still camera, in metres.
[[nodiscard]] CameraPath still_path(const ControlPoint& point, const std::string& name);
// A wandering path over any terrain, the same for the same seed everywhere.
[[nodiscard]] CameraPath random_path(std::uint64_t seed);

// Knots of the control points: nine parts of ten by distance, one by turning, so that the speed is even and a camera
// that only turns moves on too. Throws Failure when two neighbours are equal, but for two points alone.
[[nodiscard]] std::vector<double> chord_knots(std::span<const ControlPoint> points, const std::string& name);

// Where the camera passes the points, 0..1 of its flight.
[[nodiscard]] std::vector<double> shares(const SplinePath& path);

// frames >= 1. Throws Failure where direction and up cannot be made orthonormal, and when a position leaves 1e8 m.
[[nodiscard]] std::vector<Pose> resample(const CameraPath& path, const Ground& ground,
                                         std::size_t frames = default_frames);

} // namespace fjell::session
