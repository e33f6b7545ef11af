// The renderer's shaders as text, and the one block of numbers they share with the CPU.
//
// Internal to runtime/gl.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fjell/cut.h"
#include "gl/palette.h"

namespace fjell::gl {

// One draw's constants; mirrors the std140 block `Frame` in shaders.cpp.
struct FrameBlock {
    float view_projection[16]; // metres from the eye, scene axes -> clip space with reversed depth; column by column
    float eye[4];              // x and z inside the eye's cell [m], then the eye's height in two parts, high and low
    float grid[4];             // spacing x, z [m]; colour texture: scale from samples to 0..1, and offset
    float grid2[4];            // normal map: scale and offset; near [m]; 1 / log2(farthest / near)
    float sun[4];              // unit vector to the sun; 1 when lit
    float haze[4];             // 1 / distance [1/m] (0: none); pixel's ray at the picture's centre
    float ray_x[4], ray_y[4];  // how the ray changes from the centre to the right and upper edge
    float line[4];             // wireframe: linear rgb
    std::int32_t tile[4];      // log2 cells a side; 0; the eye's cell
    float level[max_triangle_levels][4]; // linear rgb
    float morph[4];                      // views, 0: nothing morphs; now [s]; 1 / time to rise [1/s]
    float morph_eye[max_cut_views][4];   // metres from the eye that the picture is drawn for
    float morph_reach[max_cut_views][4]; // q_start, q_full
};
static_assert(sizeof(FrameBlock) == 64 + 9 * 16 + (max_triangle_levels + 1 + 2 * max_cut_views) * 16 &&
                  offsetof(FrameBlock, tile) == 192,
              "FrameBlock is uploaded: change the block `Frame` in shaders.cpp with it");

// What differs from tile to tile, read once an instance.
struct TileBlock {
    std::int32_t column, row; // first sample of the tile
    std::int32_t layer;       // of the texture arrays
    std::int32_t reserved;
};
static_assert(sizeof(TileBlock) == 16, "TileBlock is uploaded: change attribute 2 of the renderer with it");

// The block `Frame` and the sky's colours: goes in front of every shader below.
[[nodiscard]] const char* common_shader();
[[nodiscard]] const char* terrain_vertex_shader();
// Names each triangle's level and corners for the fragment shader; needed by LEVELS and WIREFRAME only.
[[nodiscard]] const char* terrain_geometry_shader();
// Defines: COLOUR_MAP, NORMAL_MAP when the pack has them; LEVELS or DISTANCE for a mode other than shaded; WIREFRAME.
[[nodiscard]] const char* terrain_fragment_shader();
[[nodiscard]] const char* sky_vertex_shader();
[[nodiscard]] const char* sky_fragment_shader();

} // namespace fjell::gl
