// The ground around the terrain: it goes on from the rim, in the rim's heights and colours, levels out, and fades into
// the air. Nobody measured it, so it has no features, writes no depth and is no part of any mesh.
//
// A closed line of points runs along the terrain's rim; where the rim is a hole, it runs along the first ground within.
// From each point a row of vertices leads outwards, ever farther apart. A vertex' height and colour are means along the
// line, over more of it the farther out the vertex is. Internal to runtime/gl. Thread: the context's. Complexity:
// follow() is O(points * rings) when a page or a map of the rim came, O(1) otherwise.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fjell/terrain.h"
#include "gl/maps.h"
#include "gl/objects.h"

namespace fjell::gl {

// How far out a share e of the ground is seen, in diagonals of the terrain.
inline constexpr double surround_fade_diagonals = 0.55;

struct SurroundVertex {
    std::int32_t column, row; // as of samples; outside the terrain
    float height_m;
    float ground; // what is seen of it, 1 to 0: the rest is air
    std::array<float, 3> colour;
    std::array<float, 2> slope; // east and south components of the unit normal
};
static_assert(sizeof(SurroundVertex) == 36, "the surround's vertices are uploaded: change Surround's attributes too");

struct Surround {
    Program program[2]; // with the simple and with the physical air; made at first use

    // Made anew when more of the rim's heights or colours are loaded than before.
    void follow(const Terrain& terrain, const Maps& maps);
    void draw();
    void leave_context() { array_ = VertexArray(); }

private:
    struct Point {
        double column = 0, row = 0; // where the ground ends
        double out_column = 0, out_row = 0;
        float top_m = 0, low_m = 0; // of the ground there, and of what lies beside it
        std::array<float, 3> colour{};
    };
    void find_points(const Terrain& terrain, const Maps& maps);
    void fill_rings(const Terrain& terrain);
    void upload();

    Buffer vertices_, indices_;
    VertexArray array_;
    std::uint32_t index_count_ = 0;
    std::uint32_t seen_pages_ = 0;
    std::uint64_t seen_colours_ = 0;
    bool complete_ = false; // every height that is asked for was loaded
    std::vector<Point> points_;
    std::vector<SurroundVertex> rings_;
};

[[nodiscard]] const char* surround_vertex_shader();
[[nodiscard]] const char* surround_fragment_shader(); // after light_shader()

} // namespace fjell::gl
