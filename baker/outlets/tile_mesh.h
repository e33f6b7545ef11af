// The mesh of one globe tile: right isosceles triangles over its rectangle of degrees, as few as keep every sample of
// the ground within a tolerance, and exactly those vertices on its borders that its neighbours have.
//
// A vertex is active when (1) it is of the coarse grid that the globe's curvature needs, (2) a neighbour has it, (3) it
// is a parent of an active one, or (4) it splits a triangle over ground that is farther away than the tolerance. A
// triangle and its error depend on its place alone, and each of these rules only adds: so there is one least set of
// active vertices over all tiles of a level, and whichever tile is made first, making those again whose neighbours have
// a border vertex more ends with it. That is why neighbours meet whatever the order and the number of threads.
//
// Errors are those of the mesh as it is read: places on the 15-bit grid of quantized-mesh, heights in whole steps, and
// of two readings the larger: linear in degrees, as heights are looked up, and flat in space, as triangles are drawn.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "baker/outlets/globe.h"
#include "baker/outlets/surface.h"
#include "shared/tree.h"

namespace fjell::baker {

// Vertices of a tile lie at multiples of 1 / 8192 of its sides, rounded to 1 / 32767, as quantized-mesh stores them.
inline constexpr int tile_grid_log2 = 13;
inline constexpr std::int32_t tile_grid = 1 << tile_grid_log2;
inline constexpr std::int32_t quantized_most = 32767;
[[nodiscard]] constexpr std::int32_t quantized(std::int32_t on_grid) {
    return (on_grid * quantized_most + tile_grid / 2) / tile_grid;
}

struct TileSide {
    enum Name : std::uint8_t { west, south, east, north };
};
[[nodiscard]] constexpr std::size_t opposite(std::size_t side) {
    return (side + 2) % 4;
}
// Vertices on a tile's sides between its corners, ascending.
using BorderVertices = std::array<std::vector<std::uint16_t>, 4>;

struct TileMesh {
    struct Vertex {
        SampleIndex at; // on the tile's grid, rows from the south
        double height_m;
    };
    DegreeBox box;
    std::vector<Vertex> vertices;                        // in the order in which triangles first use them
    std::vector<std::array<std::uint32_t, 3>> triangles; // counter-clockwise, seen from above
    BorderVertices borders;
    double error_m = 0; // no ground in the tile is farther from it
    std::size_t ground = 0;

    [[nodiscard]] LonLat place(const Vertex& v) const {
        const auto along = [](double from, double to, std::int32_t at) {
            const std::int32_t q = quantized(at);
            return q == quantized_most ? to : from + (to - from) * q / quantized_most;
        };
        return {along(box.west, box.east, v.at.column), along(box.south, box.north, v.at.row)};
    }
};

struct TileRules {
    double tolerance_m = 0;
    double height_step_m = 0; // heights of vertices are whole multiples of it
    int coarsest_log2 = 1;    // the grid of 2^this cells a side is always active: at least 1
};
// tolerance_m: of the largest error that was asked for; a mesh keeps it unless its grid is too coarse for a cliff.
[[nodiscard]] TileMesh make_tile_mesh(const GroundSurface& surface, const SampleFinder& finder, const DegreeBox& box,
                                      const TileRules& rules, const BorderVertices& wanted);

} // namespace fjell::baker
