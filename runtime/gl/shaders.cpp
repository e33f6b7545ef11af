#include "gl/shaders.h"

namespace fjell::gl {

const char* common_shader() {
    return R"(
layout(std140, binding = 0) uniform Frame {
    mat4 view_projection;
    vec4 eye;
    vec4 grid;
    vec4 grid2;
    vec4 sun;
    vec4 haze;
    vec4 ray_x;
    vec4 ray_y;
    vec4 line;
    vec4 maps;
    ivec4 tile;
    vec4 legend[25];
    vec4 morph;
    vec4 morph_eye[8];
    vec4 morph_reach[8];
    vec4 tile_border;
    vec4 page_border;
    ivec4 last;
    vec4 error_eye;
    ivec4 heights;
    vec4 rounding;
    vec4 sun_low, sun_high;
    vec4 ambient[3];
    vec4 bounce;
    vec4 source[5];
    vec4 sky_simple[3];
    vec4 air[2];
    vec4 sun_level;
    vec4 film;
    vec4 water, water_tint;
    vec4 backdrop_at;
    vec4 noise_scale, noise_at;
    vec4 surround;
    vec4 layers_at, layers;
    vec4 shadow_plane, splat, shadow;
    vec4 relief;
};

// What stages hand on: metres from the eye; samples from the tile's first; the tile's block; what modes need.
#ifdef BORDERS
#define SURFACE_END flat ivec2 tile_end;
#else
#define SURFACE_END
#endif
#ifdef ERROR
#define SURFACE_HEIGHT float height; // as drawn, in metres
#else
#define SURFACE_HEIGHT
#endif
#define SURFACE vec3 position; vec2 sample_at; flat int block; SURFACE_END SURFACE_HEIGHT
)";
}

// Why no far-away origin shakes, and no crack opens between tiles: a vertex' position is counted in whole samples from
// the sample nearest to the eye - exact in integers and, below 2^24, in floats - and only then scaled to metres. What
// rounding remains is relative to the distance from the eye, some 1e-7 of it; and the two tiles that share a border
// vertex compute the same integer, hence the same position bit for bit. (Adding a float tile origin to a float local
// position would not give that.) Heights subtract the eye's in two parts for the same reason.
const char* terrain_vertex_shader() {
    return R"(
layout(location = 0) in ivec2 a_sample;
layout(location = 1) in float a_height;
layout(location = 2) in ivec4 a_tile; // first sample, block, tile
layout(location = 3) in vec4 a_morph; // height to start from, error, radius, born
out Surface {
    SURFACE
} surface;
invariant gl_Position;

// morphed_height_m() of fjell/cut.h.
float morphed_height(vec3 at) {
    float morphed = 0.0;
    for (int i = 0; i < int(morph.x); ++i) {
        float start = a_morph.z + a_morph.y * morph_reach[i].x, full = a_morph.z + a_morph.y * morph_reach[i].y;
        float from_eye = distance(at, morph_eye[i].xyz);
        morphed = max(morphed, start > full ? (start - from_eye) / (start - full) : from_eye < start ? 1.0 : 0.0);
    }
    float age = morph.y - a_morph.w;
    if (age < 0.0) age += morph.w; // the cut's clock has started again
    morphed = clamp(min(morphed, age * morph.z), 0.0, 1.0);
    return a_morph.x + (a_height - a_morph.x) * morphed;
}

void main() {
    vec2 cells = vec2(a_sample - tile.zw);
    precise vec3 p = vec3(cells.x * grid.x - eye.x, (a_height - eye.z) - eye.w, cells.y * grid.y - eye.y);
    float height = a_height;
    if (morph.x > 0.0) {
        height = morphed_height(p);
        p.y = (height - eye.z) - eye.w;
    }
    gl_Position = view_projection * vec4(p, 1.0);
    surface.position = p;
    surface.sample_at = vec2(a_sample - a_tile.xy);
#ifdef ALL_THERE
    surface.block = a_tile.w; // a whole pack's layer
#else
    surface.block = a_tile.z;
#endif
#ifdef ERROR
    surface.height = height;
#endif
#ifdef BORDERS
    surface.tile_end = min(ivec2(1 << tile.x), last.xy - a_tile.xy); // the terrain's rim may cut the tile
#endif
}
)";
}

// For level colours and wireframe. A leaf triangle's bounding rectangle names its level: a square of side w holds a
// triangle whose hypotenuse is its diagonal (levels 2k), a rectangle of w x w/2 one whose hypotenuse is the long side
// (levels 2k + 1).
const char* terrain_geometry_shader() {
    return R"(
layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;
in Surface {
    SURFACE
} corner[];
out Surface {
    SURFACE
} surface;
flat out int triangle_level;
#ifdef ERROR
flat out ivec2 triangle_at;     // the first corner, in the tile
flat out ivec4 triangle_edges;  // to the second and the third, in samples
flat out vec3 triangle_heights; // of the first, and what the others have more
centroid out vec3 weight;       // of the corners; within the triangle for every sample
#endif
out vec3 corner_weight; // 1 at one corner, 0 along the edge across: what wireframe measures
invariant gl_Position;
void main() {
    ivec2 a = ivec2(corner[0].sample_at), b = ivec2(corner[1].sample_at), c = ivec2(corner[2].sample_at);
    ivec2 extent = max(max(a, b), c) - min(min(a, b), c);
    int longest = max(extent.x, extent.y);
    int name = 2 * (tile.x - findMSB(longest)) + (extent.x == extent.y ? 0 : 1);
#ifdef ERROR
    vec3 heights_m = vec3(corner[0].height, corner[1].height - corner[0].height, corner[2].height - corner[0].height);
#endif
    for (int i = 0; i < 3; ++i) {
        gl_Position = gl_in[i].gl_Position;
        surface.position = corner[i].position;
        surface.sample_at = corner[i].sample_at;
        surface.block = corner[i].block;
#ifdef ERROR
        surface.height = corner[i].height;
        triangle_at = a;
        triangle_edges = ivec4(b - a, c - a);
        triangle_heights = heights_m;
        weight = vec3(i == 0, i == 1, i == 2);
#endif
#ifdef BORDERS
        surface.tile_end = corner[i].tile_end;
#endif
        triangle_level = name;
        corner_weight = vec3(i == 0, i == 1, i == 2);
        EmitVertex();
    }
    EndPrimitive();
}
)";
}

// A tile's map is sampled as if the pack's own size were there, but with a footprint no smaller than the texels that
// are: each axis of it is stretched to a texel of mip `finest`. So the level is at least that, whatever the driver
// makes of the two axes, and anisotropic filtering keeps what it still can. Along a tile's border `finest` is the same
// on both sides, uv is the same expression whatever the size, and every mip's border texels are equal: no seam.
const char* terrain_fragment_shader() {
    return R"(
in Surface {
    SURFACE
} surface;
#ifdef LEVELS
flat in int triangle_level;
#endif
#ifdef WIREFRAME
in vec3 corner_weight;
#endif
layout(location = 0) out vec4 out_colour;

struct TileBlock {
    ivec4 at;
    ivec4 map; // colour: layer, array; normal: the same
    float mip[36];
    uint tint;
    int horizon_mip; // the pack's mip that is the array's first
    ivec2 horizon, splat; // layer, array
    int splat_mip;
};
layout(std430, binding = 0) readonly buffer Tiles { TileBlock tile_block[]; };
#ifdef ERROR
flat in ivec2 triangle_at;
flat in ivec4 triangle_edges;
flat in vec3 triangle_heights;
centroid in vec3 weight;
layout(binding = 0) uniform sampler2DArray height_map;
#elif defined(RESIDENCY)
layout(binding = 0) uniform usampler2D residency;
#elif defined(COLOUR_MAPS)
layout(binding = 0) uniform sampler2DArray colour_map[COLOUR_MAPS];
#endif
#ifdef NORMAL_MAPS
layout(binding = 8) uniform sampler2DArray normal_map[NORMAL_MAPS];
#endif

// min_lod_grid() at this place.
float finest_mip(int kind) {
    vec2 at = clamp(surface.sample_at * (2.0 / float(1 << tile.x)), 0.0, 2.0);
    ivec2 quarter = min(ivec2(at), 1);
    at -= vec2(quarter);
    int i = 9 * kind + 3 * quarter.y + quarter.x;
    float north = mix(tile_block[surface.block].mip[i], tile_block[surface.block].mip[i + 1], at.x);
    float south = mix(tile_block[surface.block].mip[i + 3], tile_block[surface.block].mip[i + 4], at.x);
    return mix(north, south, at.y);
}

struct Place {
    vec2 uv, dx, dy;
};
vec2 stretched(vec2 axis, vec2 otherwise, float least) {
    float longest = length(axis);
    return longest >= least ? axis : longest > 1e-12 ? axis * (least / longest) : otherwise * least;
}
Place place_in_map(int kind, vec2 samples_to_uv, float texels) {
    Place place;
    place.uv = surface.sample_at * samples_to_uv.x + samples_to_uv.y;
    float least = exp2(finest_mip(kind)) / texels;
    place.dx = stretched(dFdx(place.uv), vec2(1.0, 0.0), least);
    place.dy = stretched(dFdy(place.uv), vec2(0.0, 1.0), least);
    return place;
}

// x east, y up, z south. The map stores east and south, 0 as the byte 128 (fjell/texture.h); up follows, because the
// terrain has no overhangs.
vec3 from_codes(vec2 codes) {
    vec2 slope = codes * (255.0 / 127.0) - 128.0 / 127.0;
    return vec3(slope.x, sqrt(max(1.0 - dot(slope, slope), 0.0)), slope.y);
}

#if defined(DETAIL) && defined(NORMAL_MAPS)
// A map between its texels. Straight from texel to texel, as hardware filters, the cells of a slope show as facets with
// creases between them; a cubic B-spline has none, and takes four reads, each between two texels (C. Sigg and
// M. Hadwiger, GPU Gems 2, chapter 20). It comes where a texel covers pixels, and turns straight again over the last
// texel before a border, where both tiles then read the same. mip: the finest that is there; between two, straight.
vec2 smooth_codes(sampler2DArray map, int layer, vec2 uv, vec2 dx, vec2 dy, vec2 own_dx, vec2 own_dy, float mip) {
    float whole = round(mip), texels = maps.y * exp2(-whole);
    float covers = inversesqrt(max(max(dot(own_dx, own_dx), dot(own_dy, own_dy)), 1e-20)) / texels;
    float curved = smoothstep(1.0, 3.0, covers) * clamp(1.0 - 2.0 * abs(mip - whole), 0.0, 1.0);
    vec2 at = clamp(uv * texels - 0.5, 0.0, texels - 1.0), first = floor(at), f = at - first, f2 = f * f, f3 = f2 * f;
    vec2 here = clamp(min(at, texels - 1.0 - at), 0.0, 1.0) * curved;
    vec2 before = here * (1.0 - 3.0 * f + 3.0 * f2 - f3) / 6.0, after = here * f3 / 6.0;
    vec2 low = mix(1.0 - f, (5.0 - 3.0 * f - 3.0 * f2 + 2.0 * f3) / 6.0, here), high = 1.0 - low;
    vec4 place = vec4(first - before / max(low, 1e-6), first + 1.0 + after / max(high, 1e-6)) + 0.5;
    place /= texels;
    vec2 codes = vec2(0.0);
    int read = 0, reads = curved > 0.0 ? 4 : 1;
    do {
        vec4 by = reads == 1 ? vec4(uv, 1.0, 1.0)
                             : vec4((read & 1) == 0 ? vec2(place.x, low.x) : vec2(place.z, high.x),
                                    (read & 2) == 0 ? vec2(place.y, low.y) : vec2(place.w, high.y)).xzyw;
        codes += by.z * by.w * textureGrad(map, vec3(by.xy, layer), dx, dy).rg;
    } while (++read < reads);
    return codes;
}
#endif

vec3 world_normal() {
#if defined(ALL_THERE) && defined(NORMAL_MAPS) && defined(DETAIL)
    vec2 uv = surface.sample_at * grid2.x + grid2.y, dx = dFdx(uv), dy = dFdy(uv);
    return from_codes(smooth_codes(normal_map[0], surface.block, uv, dx, dy, dx, dy, 0.0));
#elif defined(ALL_THERE) && defined(NORMAL_MAPS)
    return from_codes(texture(normal_map[0], vec3(surface.sample_at * grid2.x + grid2.y, surface.block)).rg);
#else
    vec3 n = normalize(cross(dFdx(surface.position), dFdy(surface.position)));
    if (n.y < 0.0) n = -n;
#ifdef NORMAL_MAPS
    Place at = place_in_map(1, grid2.xy, maps.y);
    ivec2 map = tile_block[surface.block].map.zw;
    if (map.y >= 0) { // the same for a whole draw, as indexing needs
#ifdef DETAIL
        n = from_codes(smooth_codes(normal_map[map.y], map.x, at.uv, at.dx, at.dy, dFdx(at.uv), dFdy(at.uv),
                                    finest_mip(1)));
#else
        n = from_codes(textureGrad(normal_map[map.y], vec3(at.uv, map.x), at.dx, at.dy).rg);
#endif
    }
#endif
    return n;
#endif
}

// Neutral rock: lighter where debris can lie, darker where it cannot.
vec3 rock(vec3 normal) {
    return mix(vec3(0.17, 0.15, 0.13), vec3(0.36, 0.33, 0.28), smoothstep(0.62, 0.95, normal.y));
}

#ifdef MIPS
vec3 mip_colour() {
#ifdef COLOUR_MAPS
    Place at = place_in_map(0, grid.zw, maps.x);
    float texels = maps.x;
    int array_of_map = tile_block[surface.block].map.y;
#elif defined(NORMAL_MAPS)
    Place at = place_in_map(1, grid2.xy, maps.y);
    float texels = maps.y;
    int array_of_map = tile_block[surface.block].map.w;
#endif
#if defined(COLOUR_MAPS) || defined(NORMAL_MAPS)
    if (array_of_map < 0) return vec3(0.02);
    float a = length(at.dx) * texels, b = length(at.dy) * texels;
    float drawn = clamp(log2(max(min(a, b), max(a, b) / maps.z)), 0.0, float(tile.y - 1));
    int finer = int(drawn);
    return mix(legend[finer].rgb, legend[min(finer + 1, tile.y - 1)].rgb, drawn - float(finer));
#else
    return vec3(0.02);
#endif
}
#endif

#ifdef ERROR
float height_at(ivec2 at) {
    ivec2 part = at / heights.zw;
    int across = (last.z + heights.z - 1) / heights.z; // layers
    return texelFetch(height_map, ivec3(at - part * heights.zw, part.y * across + part.x), 0).r;
}

// The height of the full resolution at a sample and a share of the way to the next: on the triangle that bisection ends
// with, not between all four. Squares with an even sum are cut from north-west to south-east, odd ones the other way
// (shared/tree.h); tiles of one square all fall. Without a height: below -1e38.
float full_height(ivec2 first, vec2 further) {
    ivec2 whole = ivec2(floor(further)), sample_at = first + whole;
    ivec2 square = clamp(sample_at >> heights.x, ivec2(0), last.zw - 2);
    ivec2 begin = square << heights.x, end = min((square + 1) << heights.x, last.xy);
    vec2 at = (vec2(sample_at - begin) + (further - vec2(whole))) / vec2(end - begin);
    bool falls = ((square.x + square.y) & heights.y) == 0;
    bool first_half = falls ? at.y >= at.x : at.x + at.y <= 1.0;
    float nw = height_at(square), ne = height_at(square + ivec2(1, 0));
    float sw = height_at(square + ivec2(0, 1)), se = height_at(square + ivec2(1, 1));
    float least = falls ? min(min(nw, se), first_half ? sw : ne) : min(min(ne, sw), first_half ? nw : se);
    if (least < -1e38) return least;
    if (falls) return first_half ? nw + (sw - nw) * at.y + (se - sw) * at.x : nw + (ne - nw) * at.x + (se - ne) * at.y;
    if (first_half) return nw + (ne - nw) * at.x + (sw - nw) * at.y;
    return se + (sw - se) * (1.0 - at.x) + (ne - se) * (1.0 - at.y);
}

// Weights are held inside the triangle: seen edge-on they are rounded beyond it, to where another one is drawn.
vec3 error_colour() {
    ivec2 extent = max(max(triangle_edges.xy, triangle_edges.zw), ivec2(0)) -
                   min(min(triangle_edges.xy, triangle_edges.zw), ivec2(0));
    // As fine as the grid or finer: not known.
    if (heights.x > 0 && max(extent.x, extent.y) <= 1 << heights.x) return legend[5].rgb;
    vec3 at = max(weight, 0.0);
    at /= at.x + at.y + at.z;
    vec2 further = at.y * vec2(triangle_edges.xy) + at.z * vec2(triangle_edges.zw);
    float full = full_height(tile_block[surface.block].at.xy + triangle_at, further);
    if (full < -1e38) return legend[5].rgb;
    float drawn = triangle_heights.x + (at.y * triangle_heights.y + at.z * triangle_heights.z);
    float error_m = max(abs(drawn - full) - rounding.x, 0.0);
    vec3 from_eye = vec3(surface.position.x, (full - eye.z) - eye.w, surface.position.z) - error_eye.xyz;
    float share = error_m * error_eye.w / max(length(from_eye), 1e-6);
    // Hatched, a broken promise is told from snow, and from red, by its pattern too.
    bool gap = relief.z > 0.0 && mod(gl_FragCoord.x + gl_FragCoord.y, 8.0) < 3.0;
    if (share > 1.0) return gap ? vec3(0.0) : legend[4].rgb;
    float t = clamp((share - 0.1) / 0.3, 0.0, 3.0);
    int i = min(int(t), 2);
    return mix(legend[i].rgb, legend[i + 1].rgb, t - float(i));
}
#endif

vec3 albedo(vec3 normal) {
#if defined(ERROR)
    return error_colour();
#elif defined(LEVELS)
    return legend[triangle_level].rgb;
#elif defined(TILES)
    uvec3 tint = uvec3(tile_block[surface.block].tint) >> uvec3(0u, 10u, 20u) & 1023u;
    return vec3(tint) / 1023.0;
#elif defined(MIPS)
    return mip_colour();
#elif defined(RESIDENCY)
    vec2 at = vec2(tile_block[surface.block].at.xy) + clamp(surface.sample_at, 0.0, float(1 << tile.x) - 0.5);
    return legend[texelFetch(residency, ivec2(at * maps.w), 0).r].rgb;
#elif defined(COLOUR_MAPS) && defined(ALL_THERE)
    return texture(colour_map[0], vec3(surface.sample_at * grid.z + grid.w, surface.block)).rgb;
#elif defined(COLOUR_MAPS)
    Place at = place_in_map(0, grid.zw, maps.x);
    ivec2 map = tile_block[surface.block].map.xy;
    if (map.y < 0) return rock(normal);
    return textureGrad(colour_map[map.y], vec3(at.uv, map.x), at.dx, at.dy).rgb;
#else
    return rock(normal);
#endif
}

#ifndef SHADED
// For modes whose colours mean something: a white sun, and a hemisphere from the bounce of the ground to the blue of the
// sky. Level ground under a sun at 40 degrees comes out close to its own colour.
vec3 light(vec3 normal) {
    float sunlight = max(dot(normal, sun.xyz), 0.0);
    vec3 ambient = mix(vec3(0.16, 0.14, 0.12), vec3(0.24, 0.30, 0.40), 0.5 + 0.5 * normal.y);
    return vec3(1.28, 1.20, 1.05) * sunlight + ambient;
}
#endif
)";
}

const char* terrain_main_shader() {
    return R"(
void main() {
#if defined(DISTANCE)
    // Logarithmic, so that the near and the far both show; as light, because sRGB's curve then lifts the far, where
    // most of a view lies.
    vec3 colour = vec3(clamp(1.0 - log2(length(surface.position) / grid2.z) * grid2.w, 0.0, 1.0));
#else
    vec3 normal = world_normal();
    vec3 colour = albedo(normal);
#if defined(LIT)
    colour = shaded(colour, normal);
#elif defined(SHADED) // bare
#elif defined(ERROR)
    if (sun.w > 0.0) colour *= 0.35 + 0.65 * min(dot(light(normal), vec3(1.0 / 3.0)), 1.0); // the legend stays readable
#else
    if (sun.w > 0.0) colour *= light(normal);
#endif
#ifdef BORDERS
    colour = with_relief(colour, normal);
#endif
#endif
#ifdef WIREFRAME
    colour = mix(colour, line.rgb, wire_opacity());
#endif
#ifdef BORDERS
    colour = with_borders(colour);
#endif
    out_colour = vec4(colour, 1.0);
}
)";
}

// What is drawn over the ground's colour, in GLSL: edges of triangles, borders of tiles and pages, contours, slopes.

const char* overlay_shader() {
    return R"(
#ifdef WIREFRAME
// Half a line on this side of each edge, 0.9 pixels wide; the neighbour draws the other half. Measured by how fast the
// weights change from pixel to pixel, so it is right in perspective and needs no second pass that fights for depth.
// Where triangles shrink to a few pixels lines pale, or they would blacken the distance.
float wire_opacity() {
    vec3 change = max(fwidth(corner_weight), 1e-6);
    vec3 pixels = corner_weight / change;
    float altitude = 1.0 / max(max(change.x, change.y), change.z);
    return 0.7 * clamp(1.4 - min(min(pixels.x, pixels.y), pixels.z), 0.0, 1.0) * clamp(altitude / 8.0, 0.15, 1.0);
}
#endif

#ifdef BORDERS
// Of the lines of one kind, each way: the nearer one's cover. `apart`: samples between two such lines. Lines pale
// before they would lie closer than 6 pixels, each way by itself: seen flat, those across the view go first. Then
// nothing is left to flicker.
float border_cover(vec2 samples, vec2 samples_a_pixel, float apart, float half_width_px) {
    vec2 covered = clamp(half_width_px + 0.5 - samples / samples_a_pixel, 0.0, 1.0);
    covered *= smoothstep(6.0, 16.0, apart / samples_a_pixel);
    return max(covered.x, covered.y);
}
// With a dark rim of a pixel, so that a line shows on any ground.
vec3 with_line(vec3 colour, vec4 line_colour, vec2 samples, vec2 samples_a_pixel, float apart, float half_width_px) {
    float rim = border_cover(samples, samples_a_pixel, apart, half_width_px + 1.0);
    colour *= 1.0 - 0.6 * line_colour.a * rim;
    return mix(colour, line_colour.rgb,
               line_colour.a * border_cover(samples, samples_a_pixel, apart, half_width_px));
}

// Bands of slope: from 15, 25, 35 and 45 degrees on, each darker than the one before, so that no hue is needed to tell
// them apart. Contours: lines of equal height, every fifth one wider; they pale before they would lie closer than 6
// pixels.
vec3 with_relief(vec3 colour, vec3 normal) {
    if (relief.y > 0.0) {
        const vec3 bands[4] = vec3[](vec3(0.97, 0.70, 0.13), vec3(0.91, 0.20, 0.01), vec3(0.35, 0.02, 0.10),
                                     vec3(0.02, 0.003, 0.08));
        float degrees_up = degrees(acos(clamp(normal.y, 0.0, 1.0)));
        int band = int(floor((degrees_up - 5.0) / 10.0)) - 1;
        // Those of the legend, but for a little relief from the north-west.
        float relief_light = 0.9 + 0.1 * dot(normal, vec3(-0.577, 0.577, -0.577));
        if (band >= 0) colour = bands[min(band, 3)] * relief_light;
    }
    if (relief.x > 0.0) {
        float at = (surface.position.y + eye.z + eye.w) * relief.x, a_pixel = max(fwidth(at), 1e-9);
        float nearest = round(at), wide = mod(nearest, 5.0) < 0.5 ? 1.1 : 0.5;
        float cover = clamp(wide + 0.5 - abs(at - nearest) / a_pixel, 0.0, 1.0);
        float apart = wide > 1.0 ? 5.0 : 1.0;
        colour = mix(colour, vec3(0.02, 0.012, 0.008), 0.75 * cover * smoothstep(6.0, 16.0, apart / a_pixel));
    }
    return colour;
}

// Tiles draw half of their common border each, like triangles their edges.
vec3 with_borders(vec3 colour) {
    vec2 at = surface.sample_at, dx = dFdx(at), dy = dFdy(at);
    vec2 samples_a_pixel = max(vec2(length(vec2(dx.x, dy.x)), length(vec2(dx.y, dy.y))), 1e-9);
    float side = float(1 << tile.x), page = 1.0 / maps.w;
    vec2 to_page = abs(at - page * round(at * maps.w)), to_tile = abs(min(at, vec2(surface.tile_end) - at));
    colour = with_line(colour, page_border, to_page, samples_a_pixel, page, 0.75);
    return with_line(colour, tile_border, to_tile, samples_a_pixel, side, 1.25);
}
#endif
)";
}

} // namespace fjell::gl
