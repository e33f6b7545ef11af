#version 450
in vec3 from_eye_m;
in vec2 at_sample;
layout(location = 0) out vec4 colour;

uniform vec2 tile_first;         // the tile's first column and row
uniform float tile_cells;        // and its cells a side
uniform sampler2DArray maps[2];  // colour and normals: the arrays that the tile's layers are in
uniform int layer[2];            // -1: nothing is loaded yet
uniform float texels[2];         // of the pack's mip 0, a side
uniform float missing_mips[2];   // finer mips that the pack has and the array has not
uniform float min_lod[18];       // min_lod_grid() of both

// Bilinear over the tile, so that neighbours meet at one value.
float min_lod_at(int map, vec2 at) {
    vec2 middle = clamp(at * (2.0 / tile_cells), 0.0, 2.0);
    ivec2 quarter = min(ivec2(middle), 1);
    int i = 9 * map + 3 * quarter.y + quarter.x;
    middle -= vec2(quarter);
    return mix(mix(min_lod[i], min_lod[i + 1], middle.x), mix(min_lod[i + 3], min_lod[i + 4], middle.x), middle.y);
}

vec4 texel_at(int map) {
    vec2 at = at_sample - tile_first;
    vec2 uv = at / tile_cells * ((texels[map] - 1.0) / texels[map]) + 0.5 / texels[map];
    float lod = textureQueryLod(maps[map], uv).y; // of the array's own mips
    return textureLod(maps[map], vec3(uv, layer[map]), max(lod, min_lod_at(map, at) - missing_mips[map]));
}

void main() {
    vec3 normal = normalize(cross(dFdx(from_eye_m), dFdy(from_eye_m)));
    if (normal.y < 0.0) normal = -normal;
    if (layer[1] >= 0) { // east and south; up follows
        vec2 slope = texel_at(1).xy * (255.0 / 127.0) - 128.0 / 127.0;
        normal = vec3(slope.x, sqrt(max(1.0 - dot(slope, slope), 0.0)), slope.y);
    }
    vec3 ground = layer[0] >= 0 ? texel_at(0).rgb : vec3(0.3, 0.27, 0.22);
    float sun = max(dot(normal, normalize(vec3(-0.5, 0.6, -0.5))), 0.0);
    colour = vec4(ground * (0.3 + 1.1 * sun), 1.0);
}
