// What the editor draws into the scene with lines: the frozen camera's frustum, tiles that were culled, and spheres
// that bound vertices.
//
// Ownership: its own arrays, made once; the terrain and mesh are read in build() only. Thread: the frame's. Memory:
// fixed; what does not fit is left out, farthest tiles first. Complexity: O(tiles), and nothing when no overlay is on.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "editor/state.h"
#include "fjell/gl/lines.h"
#include "flight/session.h"

namespace fjell::editor {

class SceneLines {
public:
    static constexpr std::uint32_t most_lines = 8192, most_balls = 128;

    SceneLines();
    void build(const State& state, const flight::Session& session);
    [[nodiscard]] std::span<const gl::Line> lines() const { return lines_; }
    [[nodiscard]] std::span<const gl::Ball> balls() const { return balls_; }
    [[nodiscard]] bool empty() const { return lines_.empty() && balls_.empty(); }

private:
    void add_culled(const flight::Session& session);
    void add_tile_spheres(const flight::Session& session, const View& view);
    void add_chain(const flight::Session& session, const View& view);

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
