// Lines and balls in a scene that a Renderer has drawn: what an editor shows of cameras, spheres and picked vertices.
//
// Drawn into the same Target with the same View afterwards; what lies behind the terrain is left out or dimmed and
// dashed. Lines have a width in pixels and soft edges, with or without samples. Units: metres, scene axes; colours
// sRGB with straight opacity. Nothing shakes far from the origin: lines are cut to the view and projected in doubles,
// also those that pass behind the eye. A ball's centre is projected in doubles, its three great circles (level, and
// facing south and east) in floats: exact to some 1e-7 of its radius. Nothing hides anything by itself: all are
// blended in the order given, lines first. Ownership: GL objects of the context that was current at creation; destroy
// while it is current. Thread: the context's. Memory, all at creation: three times 28 bytes a line and a ball.
// Complexity of a draw: O(lines + balls) and at most four GL draws. Failure: io::Failure, 3, with the number to change;
// the target keeps its picture.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "fjell/export.h"
#include "fjell/gl/target.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell::gl {

using Rgba8 = std::array<std::uint8_t, 4>;

// From one place to another.
struct Line {
    Vec3 from, to;
    Rgba8 rgba{255, 255, 255, 255};
};

// Three great circles.
struct Ball {
    Vec3 centre;
    double radius_m = 1;
    Rgba8 rgba{255, 255, 255, 255};
};

// How much there is room for.
struct LinesOptions {
    std::uint32_t lines = 4096, balls = 256; // of one draw
};

// How lines of one draw look.
struct LineStyle {
    float width_px = 1.5f; // up to 64
    // Opacity of what lies behind the terrain, as a share of its own; there every second 6 pixels or so are left out.
    // 0: not drawn.
    float hidden = 0.3f;
};

// Draws lines and balls.
class Lines {
public:
    [[nodiscard]] static std::unique_ptr<Lines> create(const LinesOptions& options);
    ~Lines();
    Lines(const Lines&) = delete;
    Lines& operator=(const Lines&) = delete;

    // After Renderer::draw() into the same target with the same view.
    void draw(std::span<const Line> lines, std::span<const Ball> balls, const View& view, const Target& target,
              const LineStyle& style = {});

private:
    Lines();
    struct State;
    std::unique_ptr<State> state_;
};

// What a view sees, as its edges: four around the near plane, four around the plane length_m ahead (at least near_m),
// and four between them. Pure.
void frustum_lines(const View& of, double length_m, Rgba8 rgba, std::span<Line, 12> out);

} // namespace fjell::gl
FJELL_API_END
