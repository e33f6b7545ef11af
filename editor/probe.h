// What is known of the ground under the pointer and of the mesh drawn there, and what lies between marked places.
//
// Positions: scene axes, metres; places in the picture: shares of its width and height, from its upper left corner.
// Thread: the frame's. Memory: fixed. Complexity: update_probe() is O(levels) for the ray and looks at no more than
// triangles_a_call triangles, so the mesh under the pointer may be known some frames later; nothing while it is off.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "fjell/sample_index.h"
#include "fjell/view.h"

namespace fjell::baker {
class Coordinates;
}
namespace fjell::session {
struct Session;
}

namespace fjell::editor {

// The triangle that is drawn over a place.
struct ProbedMesh {
    int level = 0;       // as triangle_level() has it
    double height_m = 0; // of the mesh, morphing included
    double error_px = 0; // how far it is from the ground, as the refining view sees it
};

struct ProbedGround {
    Vec3 position_m;
    double distance_m = 0; // from the eye
    double slope_rad = 0;
    double error_m = 0;  // the original ground is within this of it
    bool finest = false; // of the full resolution; otherwise pages are missing
    SampleIndex sample;  // the nearest
    std::uint32_t tile_x = 0, tile_y = 0;
    std::uint32_t page = 0;                       // of that tile: the finest one
    std::optional<ProbedMesh> mesh;               // none: not found yet, or nothing is drawn there
    std::optional<std::array<double, 2>> degrees; // latitude, longitude; none: not known
};

inline constexpr std::size_t most_marks = 64;

// Along marked places, straight from one to the next. Lengths and areas are those of the map, and those of its ground,
// which climbs and falls: that is measured in steps of half a sample, or longer ones where there would be too many.
struct HeightProfile {
    static constexpr std::size_t samples = 128;
    std::array<float, samples> height_m{};
    std::array<std::array<double, 2>, samples> place_m{}; // x, z
    double length_m = 0, ground_length_m = 0;
    double area_m2 = 0, ground_area_m2 = 0; // that the marks enclose, the last joined to the first; of two: 0
    float lowest_m = 0, highest_m = 0;
};

struct Probe {
    bool on = false;
    std::optional<std::array<double, 2>> pointer; // in the picture
    std::optional<ProbedGround> ground;           // none: the sky, or a hole
    std::array<Vec3, most_marks> mark_m{};
    std::size_t marks = 0; // of those, how many are set
    HeightProfile profile; // when two are
    // How far the search for the triangle has come.
    bool looking = false;
    std::size_t range = 0, triangle = 0; // goes on there: in MeshView::tiles, and in that range
    std::size_t ranges_left = 0;
};

// A place of the picture as a direction from the eye, any length; and a position as a place of the picture, none where
// it lies behind the eye.
[[nodiscard]] Vec3 direction_at(const View& view, double x, double y);
[[nodiscard]] std::optional<std::array<double, 2>> place_in(const View& view, const Vec3& position_m);

inline constexpr std::size_t triangles_a_call = 10'000;
// After a frame's update. refining: the view that the mesh is for. changed: the mesh, since the call before.
// coordinates: null: the ground's degrees are not known.
void update_probe(Probe& probe, const session::Session& session, const View& drawn, const View& refining, bool changed,
                  const baker::Coordinates* coordinates = nullptr);
// The next mark; beyond most_marks none.
void set_mark(Probe& probe, const session::Session& session, double x_m, double z_m);
void remove_mark(Probe& probe, const session::Session& session); // the last one
// Anew, where pages have come or gone.
void measure_profile(Probe& probe, const session::Session& session);

} // namespace fjell::editor
