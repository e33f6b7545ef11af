// The renderer's shaders as text, and the one block of numbers they share with the CPU.
//
// Internal to runtime/gl.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fjell/cut.h"
#include "fjell/gl/palette.h"
#include "fjell/stream.h"

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
    float maps[4];             // texels a side of mip 0: colour, normal; anisotropy; residency: texels a sample
    std::int32_t tile[4];      // log2 cells a side; mips of the map that Mode::mips shows; the eye's cell
    float legend[max_triangle_levels][4]; // linear rgb of levels, mips or steps, whichever the mode shows
    float morph[4];                       // views, 0: nothing morphs; now [s]; 1 / time to rise [1/s]; morph_clock_s
    float morph_eye[max_cut_views][4];    // metres from the eye that the picture is drawn for
    float morph_reach[max_cut_views][4];  // start_per_error, full_per_error
    float tile_border[4], page_border[4]; // linear rgb, opacity
    std::int32_t last[4];                 // the terrain's last column and row; columns and rows of the height grid
    float error_eye[4];                   // metres from the eye; share of a metre's error at a metre's distance
    std::int32_t heights[4];              // log2 of the grid's step, 1 where diagonals alternate; texels of a layer
    float rounding[4];                    // metres that floats may add to an error
    // Light: linear rgb of a sun of irradiance 1 above the air (lighting.h); heights in metres above the eye.
    float sun_low[4], sun_high[4]; // at the terrain's lowest and highest place; the lowest; 1 / their difference
    float ambient[3][4];           // SkyLight::ambient
    float bounce[4];               // what ground in place of sky adds: the ground around, of a white surface
    float source[5][4];            // SkyLight::source
    float sky_simple[3][4];        // of the simple air: horizon, zenith, glow around the sun
    float air[2][4];               // extinction at the eye [1/m], Rayleigh's and Mie's; 1 / height [1/m]
    float sun_level[4]; // the sun's azimuth as a unit vector, x and z; the sky table's slice and share of the next
    float film[4];      // exposure; 1: filmic; 1: dithered; time [s]
    float water[4]; // level [m]; 1 where it is seen; what is no further from the level is on it [m]; shore's depth [m]
    float water_tint[4];   // extinction in water [1/m]
    float backdrop[4];     // ground around the terrain: rgb; height
    float noise_scale[4];  // tiles of noise a metre: the coarsest on ground, waves; a texel [m]
    float noise_at[4];     // of the eye, from where the noise repeats [m]
    float surround[4];     // of the ground around the terrain that is seen, 1/m by which it falls by e
    float layers_at[4];    // of the eye, from where materials repeat [m]
    float layers[4];       // LayerSettings: distance [m], tint, relief; where the fine textures end [m]
    float shadow_plane[4]; // column and row of the horizon map's planes on both sides of the sun's azimuth
    float splat[4];  // texels a side of mip 0; mips; shares of a tile that noise displaces a place by, east and south
    float shadow[4]; // share of the second; sine of half the penumbra; texels a side of mip 0; mips
    float relief[4]; // contours a metre, 0: none; 1: slopes; 1: hatching of broken bounds
};
static_assert(sizeof(FrameBlock) == 64 + 10 * 16 + (max_triangle_levels + 1 + 2 * max_cut_views + 6 + 30) * 16 &&
                  offsetof(FrameBlock, tile) == 208,
              "FrameBlock is uploaded: change the block `Frame` in shaders.cpp with it");

// What differs from tile to tile: the first 16 bytes are read once an instance, all of it by the fragment shader.
struct TileBlock {
    std::int32_t column, row;                                            // first sample of the tile
    std::int32_t index, tile;                                            // among this draw's; of the terrain
    std::int32_t colour_layer, colour_array, normal_layer, normal_array; // array -1: nothing is there yet
    float mip[map_kinds][9];                                             // min_lod_grid()
    std::uint32_t tint;                                                  // of Mode::tiles: linear rgb, 10 bits each
    std::int32_t horizon_mip;                                            // the pack's mip that is the array's first
    std::int32_t horizon_layer, horizon_array, splat_layer, splat_array;
    std::int32_t splat_mip; // as of horizons
    std::uint32_t reserved; // an array's elements begin at multiples of 16
};
static_assert(sizeof(TileBlock) == 208 && offsetof(TileBlock, mip) == 32 && offsetof(TileBlock, horizon_layer) == 184,
              "TileBlock is uploaded: change attribute 2 of the renderer and TileBlock in shaders.cpp with it");

// The block `Frame`: goes in front of every shader below.
[[nodiscard]] const char* common_shader();
[[nodiscard]] const char* terrain_vertex_shader();
// Names each triangle's level and corners for the fragment shader; needed by LEVELS, ERROR and WIREFRAME only.
[[nodiscard]] const char* terrain_geometry_shader();
// The ground's fragment shader: terrain_fragment_shader(), for LIT light_shader() and ground_light_shader(), then
// overlay_shader() and terrain_main_shader(). Defines: COLOUR_MAPS and NORMAL_MAPS, how many array textures there are
// of each, when there are any; SHADED, LEVELS, DISTANCE, TILES, MIPS, RESIDENCY or ERROR for the mode; WIREFRAME;
// BORDERS; ALL_THERE: one array of each, layer = tile; with SHADED also LIT, and with that AIR: physical, DETAIL,
// WATER, LAYERS, SHADOWS (with HORIZON_MAPS), SPLAT (with LAYERS, SPLAT_MAPS, and SPLAT_UNIT: the first of their
// texture units), LAKES (with SPLAT and WATER: splat maps speak of water).
[[nodiscard]] const char* terrain_fragment_shader();
[[nodiscard]] const char* light_shader();
[[nodiscard]] const char* layers_shader(); // between the two
[[nodiscard]] const char* ground_light_shader();
[[nodiscard]] const char* overlay_shader(); // for WIREFRAME and BORDERS
[[nodiscard]] const char* terrain_main_shader();
[[nodiscard]] const char* sky_vertex_shader();
[[nodiscard]] const char* sky_fragment_shader(); // after light_shader()

} // namespace fjell::gl
