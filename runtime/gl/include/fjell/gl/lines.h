// Lines and balls in a scene that a Renderer has drawn: cameras, spheres and picked vertices of an editor.
//
// Draw them into the same Target with the same View, after the terrain. Parts behind the terrain are left out, or
// dimmed and dashed. Lines have a width in pixels and soft edges, with or without multisampling. Everything is blended
// in the order given, lines first; lines and balls do not hide each other. Units: metres, scene axes. Colours are sRGB
// with straight opacity.
// Nothing shakes far from the origin. Lines are cut to the view and projected in doubles, even if they pass behind the
// eye. The centre of a ball is projected in doubles; its three great circles (level, facing south, facing east) are
// floats, exact to some 1e-7 of the radius.
// Ownership: GL objects of the context that was current at creation; destroy them while it is current. Thread: the
// context's. Memory, all at creation: three times 28 bytes for each line and ball. Complexity of a draw: O(lines +
// balls), and at most four GL draws. Failure: io::Failure, 3, with the number to change; the target keeps its picture.
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

// A line from one place to another.
struct Line {
    Vec3 from, to;
    Rgba8 rgba{255, 255, 255, 255};
};

// A ball, drawn as three great circles.
struct Ball {
    Vec3 centre;
    double radius_m = 1;
    Rgba8 rgba{255, 255, 255, 255};
};

// How many there is room for in one draw.
struct LinesOptions {
    std::uint32_t lines = 4096, balls = 256;
};

// The style of the lines of one draw.
struct LineStyle {
    float width_px = 1.5f; // up to 64
    // Opacity of parts behind the terrain, as a share of their own; there they are dashed, 6 pixels on and 6 off. 0:
    // not drawn.
    float hidden = 0.3f;
};

// Draws lines and balls.
class Lines {
public:
    [[nodiscard]] static std::unique_ptr<Lines> create(const LinesOptions& options);
    ~Lines();
    Lines(const Lines&) = delete;
    Lines& operator=(const Lines&) = delete;

    // Call it after Renderer::draw(), with the same target and view.
    void draw(std::span<const Line> lines, std::span<const Ball> balls, const View& view, const Target& target,
              const LineStyle& style = {});

private:
    Lines();
    struct State;
    std::unique_ptr<State> state_;
};

// The edges of what a view sees: four around the near plane, four around a plane length_m ahead (at least near_m), and
// four between them. Pure.
void frustum_lines(const View& of, double length_m, Rgba8 rgba, std::span<Line, 12> out);

} // namespace fjell::gl
FJELL_API_END
