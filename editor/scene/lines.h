// What the editor draws into the scene with lines: the frozen camera's frustum, tiles that were culled, and spheres
// that bound vertices.
//
// Ownership: its own arrays, made once; the terrain and mesh are read in build() only. Thread: the frame's. Memory:
// fixed; what does not fit is left out, farthest tiles first. Complexity: O(tiles), and nothing when no overlay is on.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "editor/route.h"
#include "editor/state.h"
#include "fjell/gl/lines.h"
#include "fjell/view.h"
#include "session/session.h"

namespace fjell::editor {

// However long the path is: it is shown coarser then, and of its points some.
inline constexpr std::size_t most_route_pieces = 512, most_route_marks = 256;
inline constexpr std::size_t most_route_lines = 2 * most_route_pieces + 4 * most_route_marks;

// Points are squares that face the view, some pixels wide; the selected one is larger. Those that are nearer than the
// near plane, or behind it, are left out: the camera is at one of them often.
void add_route_lines(const Route& route, const View& view, std::vector<gl::Line>& to);

class SceneLines {
public:
    static constexpr std::uint32_t most_lines = 8192, most_balls = 128;

    SceneLines();
    void build(const State& state, const session::Session& session);
    [[nodiscard]] std::span<const gl::Line> lines() const { return lines_; }
    [[nodiscard]] std::span<const gl::Ball> balls() const { return balls_; }
    [[nodiscard]] bool empty() const { return lines_.empty() && balls_.empty(); }

private:
    void add_culled(const session::Session& session);
    void add_tile_spheres(const session::Session& session, const View& view);
    void add_chain(const session::Session& session, const View& view);

    std::vector<gl::Line> lines_;
    std::vector<gl::Ball> balls_;
    std::vector<bool> drawn_; // by tile
    struct Near {
        double distance_m;
        std::uint32_t tile;
    };
    std::vector<Near> near_;
};

} // namespace fjell::editor
