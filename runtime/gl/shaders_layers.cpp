// Detail layers, in GLSL: materials that rules lay over the ground near the eye.
#include "gl/shaders.h"

namespace fjell::gl {

// Behind light_shader(), in front of ground_light_shader(); with LAYERS only.
const char* layers_shader() {
    return R"(
#ifdef LAYERS
layout(binding = 17) uniform sampler2D noise_map;
layout(binding = 18) uniform sampler2DArray material_map;
layout(binding = 19) uniform sampler2DArray material_normal;
struct Rule {
    vec4 height, slope, noise;
    vec4 how;    // material, opacity; displaced by metres and degrees a unit of noise
    vec4 noises; // shares of patches and spots
};
layout(std140, binding = 1) uniform Layers {
    vec4 material_turn[16]; // periods of the fine and the coarse texture, east and south
    vec4 material_mean[16]; // linear rgb; share of the coarse texture
    Rule rule[16];
    ivec4 rules; // their count; for LAKES the splat map's name that is water
    ivec4 of_name[4]; // the material of each of the splat map's names
};
const float layer_period = 1.0 / 1024.0;
// Of a place: even what is highest in it would lie below the others.
const float least_share = 0.12;

// A material at a place: its colour as a multiple of its mean, its height, and its slopes in the projection's plane.
struct Ground {
    vec3 colour;
    float height;
    vec2 slope;
};

float band(vec4 edges, float value) {
    return clamp((value - edges.x) * edges.y, 0.0, 1.0) * clamp((edges.z - value) * edges.w, 0.0, 1.0);
}

// Keeps the three that are most, of those that come one after the other.
void keep_most(int of, float here, inout ivec3 material, inout vec3 most) {
    if (here > most.x) {
        most = vec3(here, most.xy);
        material = ivec3(of, material.xy);
    } else if (here > most.y) {
        most.yz = vec2(here, most.y);
        material.yz = ivec2(of, material.y);
    } else if (here > most.z) {
        most.z = here;
        material.z = of;
    }
}

// The three rules that show most: layer_shares() of fjell/gl/layers.h.
void strongest_rules(float height, float slope, vec2 noises, out ivec3 material, out vec3 share) {
    share = vec3(0.0);
    material = ivec3(0);
    float left = 1.0;
    for (int i = rules.x - 1; i >= 0 && left > 0.004; --i) {
        float noise = dot(noises, rule[i].noises.xy), off = noise - 0.5;
        float here = left * rule[i].how.y * band(rule[i].height, height + off * rule[i].how.z) *
                     band(rule[i].slope, slope + off * rule[i].how.w) * band(rule[i].noise, noise);
        left -= here;
        keep_most(int(rule[i].how.x), here, material, share);
    }
    float all = share.x + share.y + share.z;
    share = all > 0.0 ? share / all : vec3(1.0, 0.0, 0.0);
}

#ifdef SPLAT
layout(binding = SPLAT_UNIT) uniform usampler2DArray splat_map[SPLAT_MAPS];

// Adds what four texels of one mip say around a place: weights of names, four names a vector. Numbers cannot be
// filtered, so weights are, by hand. The outermost texel centres lie on the border.
void add_texels(vec2 at, ivec2 map, int mip, int lod, float share, inout vec4 names[4]) {
    int last = int(splat.x) >> mip;
    vec2 place = clamp(at, 0.0, 1.0) * float(last - 1);
    ivec2 first = clamp(ivec2(place), ivec2(0), ivec2(last - 2));
    vec2 along = place - vec2(first);
    int tap = 0;
    do {
        ivec2 beside = ivec2(tap & 1, tap >> 1);
        uvec4 texel = texelFetch(splat_map[map.y], ivec3(first + beside, map.x), lod);
        vec2 nearness = mix(1.0 - along, along, vec2(beside));
        vec4 weight = vec4(texel & 255u) * (share * nearness.x * nearness.y / 255.0);
        uvec4 name = texel >> 8u;
        int i = 0;
        do {
            uvec4 numbers = uvec4(0, 1, 2, 3) + uint(4 * i);
            names[i] += weight.x * vec4(equal(name.xxxx, numbers)) + weight.y * vec4(equal(name.yyyy, numbers)) +
                        weight.z * vec4(equal(name.zzzz, numbers)) + weight.w * vec4(equal(name.wwww, numbers));
        } while (++i < 4);
    } while (++tap < 4);
}

// Weights of names, four a vector. dx, dy: of a texel of mip 0. Of a tile whose map has not come: none.
void names_of_map(vec2 at, vec2 dx, vec2 dy, out vec4 names[4]) {
    names = vec4[4](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
#ifdef ALL_THERE
    ivec2 map = ivec2(surface.block, 0);
    float least = 0.0;
    int first_mip = 0;
#else
    ivec2 map = tile_block[surface.block].splat;
    if (map.y < 0) return;
    float least = finest_mip(3);
    int first_mip = tile_block[surface.block].splat_mip;
#endif
    float mip = clamp(0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-9)), least, splat.y - 1.0);
    int finer = int(mip);
    float second = mip - float(finer);
    add_texels(at, map, finer, max(finer - first_mip, 0), 1.0 - second, names);
    if (second > 0.0) {
        int coarser = min(finer + 1, int(splat.y) - 1);
        add_texels(at, map, coarser, max(coarser - first_mip, 0), second, names);
    }
}

#ifdef LAKES
// Straight from texel to texel a shore has the texels' corners. Where it runs, the share of water is a quadratic
// B-spline of the finest mip's, and straight again over the last texel before a tile's border, where both tiles read the
// same texel. wet: the share that names_of_map() gave.
float shore_of_map(vec2 at, vec2 dx, vec2 dy, float wet) {
    float mip = 0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-9));
#ifdef ALL_THERE
    ivec2 map = ivec2(surface.block, 0);
#else
    ivec2 map = tile_block[surface.block].splat;
    mip = max(mip, finest_mip(3));
    if (tile_block[surface.block].splat_mip > 0) mip = 1.0;
#endif
    float last = splat.x - 1.0;
    vec2 place = clamp(at, 0.0, 1.0) * last, here = clamp(min(place, last - place), 0.0, 1.0);
    float curved = min(here.x, here.y) * (1.0 - smoothstep(0.3, 1.0, mip));
    vec2 middle = clamp(round(place), 1.0, last - 1.0), f = place - middle;
    vec2 before = 0.5 * (0.5 - f) * (0.5 - f), after = 0.5 * (0.5 + f) * (0.5 + f), centre = 1.0 - before - after;
    float share = 0.0;
    int taps = curved > 0.0 && map.y >= 0 && wet > 0.02 && wet < 0.98 ? 9 : 0;
    for (int tap = 0; tap < taps; ++tap) {
        ivec2 beside = ivec2(tap % 3, tap / 3);
        uvec4 texel = texelFetch(splat_map[map.y], ivec3(ivec2(middle) + beside - 1, map.x), 0);
        vec2 nearness = vec2(beside.x == 0 ? before.x : beside.x == 1 ? centre.x : after.x,
                             beside.y == 0 ? before.y : beside.y == 1 ? centre.y : after.y);
        vec4 weight = vec4(texel & 255u) * (nearness.x * nearness.y / 255.0);
        share += dot(weight, vec4(equal(texel >> 8u, uvec4(rules.y))));
    }
    return taps > 0 ? mix(wet, share, curved) : wet;
}
#endif

// Noise moves places in the map, so that its texels do not show.
vec2 swayed(vec2 in_tile, vec2 patches) { return in_tile + (clamp(patches * 2.4 - 0.7, 0.0, 1.0) - 0.5) * splat.zw; }

// The three materials that the map has most of here, and how much of the ground materials cover. wet: the share of
// water, which is none of them.
float strongest_of_map(vec4 names[4], vec2 noises, out ivec3 material, out vec3 share, out float wet) {
    float covered = 0.0;
    vec3 most = vec3(0.0);
    material = ivec3(0);
    wet = 0.0;
    int i = 0;
    do {
        float here = names[i >> 2][i & 3];
#ifdef LAKES
        if (i == rules.y) {
            wet = here;
            here = 0.0;
        }
#endif
        covered += here;
        keep_most(i, here, material, most);
    } while (++i < 16);
    float all = most.x + most.y + most.z;
    share = all > 0.0 ? most / all : vec3(1.0, 0.0, 0.0);
    // A map's texels are tens of metres: noise makes patches of what they say of two materials. Its sign follows from
    // the two, not from which is more, or a line would show where they are equal.
    float sway = (0.75 * noises.x + 0.25 * noises.y - 0.5) * 1.4 * min(4.0 * share.x * share.y, 1.0);
    sway = material.x < material.y ? sway : -sway;
    share.xy = max(share.xy + vec2(sway, -sway), 0.0);
    share /= share.x + share.y + share.z;
    if (share.y > share.x) {
        share.xy = share.yx;
        material.xy = material.yx;
    }
    material = ivec3(of_name[material.x >> 2][material.x & 3], of_name[material.y >> 2][material.y & 3],
                     of_name[material.z >> 2][material.z & 3]);
    return min(covered, 1.0);
}
#endif

vec2 place_of_patch(float number) { return fract(number * vec2(0.7548777, 0.5698403)); }

// Near sRGB's curve, after filtering: drivers without a GPU would take it texel by texel.
vec3 light_of(vec3 code) { return code * (code * (code * 0.305306 + 0.682171) + 0.012523); }

// From the unit normal in the texture's axes to slopes in the plane's.
vec2 slope_of(vec2 codes, vec2 turn) {
    vec2 tilt = codes * (255.0 / 127.0) - 128.0 / 127.0;
    tilt *= -inversesqrt(max(1.0 - dot(tilt, tilt), 0.05) * dot(turn, turn));
    return vec2(dot(tilt, turn), dot(tilt, vec2(-turn.y, turn.x)));
}

// Both scales of a material in one plane. The fine one ends where its texels are finer than a pixel; the coarse one is
// all that there is from then on, and nearby only keeps the fine one from looking the same everywhere. Noise cuts the
// plane into patches, each with its own place in the fine texture, which meet softly: so no eye finds the period
// (I. Quilez, Texture Repetition).
//
// Loops that end with their condition, here and below, in place of branches: a software driver goes through every
// branch, and one body stands for all of them.
Ground material_at(int material, vec2 at, vec2 dx, vec2 dy, float near, vec2 noises) {
    float patch_at = 7.0 * noises.y + 3.0 * noises.x, number = floor(patch_at);
    // Patches meet softly over more of their width from 48 m on, where a narrow edge would shimmer.
    float edge = mix(0.5, 0.1, max(4.0 * near - 3.0, 0.0));
    float next = smoothstep(0.5 - edge, 0.5 + edge, patch_at - number);
    int reads = near <= 0.0 ? 1 : next <= 0.0 || next >= 1.0 ? 2 : 3;
    vec4 mean = material_mean[material], turns = material_turn[material];
    vec4 coarse = vec4(0.0), fine = vec4(0.0);
    vec2 slope = vec2(0.0), turn = turns.zw, offset = vec2(0.0);
    float share = 0.75 * mean.w * (1.0 - near), of_coarse = 1.0;
    int read = 0;
    do {
        mat2 periods = mat2(turn.x, turn.y, -turn.y, turn.x) * layer_period;
        vec3 place = vec3(periods * at + offset, float(material));
        vec2 along = periods * dx, across = periods * dy;
        vec4 texel = textureGrad(material_map, place, along, across);
        slope += share * slope_of(textureGrad(material_normal, place, along, across).rg, turn);
        coarse += of_coarse * texel;
        fine += (1.0 - of_coarse) * share * texel;
        bool second = read == 1 || next >= 1.0;
        share = near * (second ? next : 1.0 - next);
        offset = place_of_patch(number + (second ? 1.0 : 0.0));
        turn = turns.xy;
        of_coarse = 0.0;
    } while (++read < reads);
    float coarse_share = mean.w * (1.0 - 0.45 * near);
    Ground ground = Ground(mix(vec3(1.0), light_of(coarse.rgb) / mean.rgb, coarse_share), mix(0.5, coarse.a, coarse_share), slope);
    if (near > 0.0) {
        fine /= near;
        ground.colour *= mix(vec3(1.0), light_of(fine.rgb) / mean.rgb, near);
        ground.height = mix(ground.height, 0.35 * ground.height + 0.65 * fine.a, near);
    }
    return ground;
}

struct Shaped {
    vec3 colour;
    float reach; // how high it stands out against the others
    vec3 bump;   // of the surface, across its normal
};

// From above; where it is steep from the sides too. side: their shares, which add up to 1.
Shaped shaped_material(int material, vec3 at, vec3 dx, vec3 dy, vec3 side, float near, vec2 noises) {
    Shaped shaped = Shaped(vec3(0.0), 0.0, vec3(0.0));
    vec3 left = side;
    do {
        // What lies in the plane, and which way its first and second axis point.
        bool above = left.y > 0.0, east = left.x > 0.0;
        mat2x3 plane = above ? mat2x3(1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
                     : east  ? mat2x3(0.0, 0.0, 1.0, 0.0, 1.0, 0.0)
                             : mat2x3(1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        float share = above ? left.y : east ? left.x : left.z;
        Ground g = material_at(material, at * plane, dx * plane, dy * plane, near, noises);
        shaped.colour += share * g.colour;
        shaped.reach += share * g.height;
        shaped.bump += plane * (share * g.slope);
        left = above ? vec3(left.x, 0.0, left.z) : east ? vec3(0.0, 0.0, left.z) : vec3(0.0);
    } while (left.x + left.y + left.z > 0.0);
    return shaped;
}

// Replaces colour and normal near the eye. base, normal: with noise; map, map_normal: as the maps have them. Gives the
// share of water, which far ground has too.
float add_layers(inout vec3 base, inout vec3 normal, vec3 map, vec3 map_normal, float metres) {
    vec3 dx = dFdx(surface.position), dy = dFdy(surface.position);
#ifdef SPLAT
    vec2 in_tile = surface.sample_at / float(1 << tile.x), texel_x = dFdx(in_tile) * splat.x, texel_y = dFdy(in_tile) * splat.x;
#endif
    vec3 at = surface.position + layers_at.xyz;
    float wet = 0.0;
    if (metres >= layers.x) {
#ifdef LAKES
        vec4 far_names[4];
        in_tile = swayed(in_tile, textureGrad(noise_map, at.xz / 512.0, dx.xz / 512.0, dy.xz / 512.0).zw);
        names_of_map(in_tile, texel_x, texel_y, far_names);
        wet = shore_of_map(in_tile, texel_x, texel_y, far_names[rules.y >> 2][rules.y & 3]);
#endif
        return wet;
    }
    float fade = 1.0 - smoothstep(0.4 * layers.x, layers.x, metres);
    float near = 1.0 - smoothstep(0.3 * layers.w, layers.w, metres);
    vec2 patches = textureGrad(noise_map, at.xz / 512.0, dx.xz / 512.0, dy.xz / 512.0).zw;
    float spots = textureGrad(noise_map, at.xz / 64.0, dx.xz / 64.0, dy.xz / 64.0).z;
    vec2 noises = clamp(vec2(patches.x, spots) * 2.4 - 0.7, 0.0, 1.0);
    ivec3 material;
    vec3 share;
#ifdef SPLAT
    vec4 names[4];
    in_tile = swayed(in_tile, patches);
    names_of_map(in_tile, texel_x, texel_y, names);
    fade *= strongest_of_map(names, noises, material, share, wet);
#ifdef LAKES
    wet = shore_of_map(in_tile, texel_x, texel_y, wet);
#endif
    if (fade <= 0.0) return wet;
#else
    strongest_rules(surface.position.y + eye.z + eye.w, degrees(acos(clamp(map_normal.y, 0.0, 1.0))), noises, material,
                    share);
#endif
    // Sides count from 35 degrees on.
    vec3 side = normal * normal;
    side *= side;
    side.xz *= smoothstep(0.85, 0.7, normal.y);
    side = max(side / (side.x + side.y + side.z) - 0.06, 0.0);
    side /= side.x + side.y + side.z;

    Shaped now = Shaped(vec3(0.0), -1.0, vec3(0.0)), before = now, first = now;
    float towards_map = mix(layers.y, 1.0, smoothstep(0.0, layers.x, metres));
    do {
        first = before;
        before = now;
        now = shaped_material(material.x, at, dx, dy, side, near, noises);
        now.colour *= mix(material_mean[material.x].rgb, map, towards_map);
        // Where two share a place the higher stands out: stones out of grass, each by itself.
        now.reach = share.x + (now.reach - 0.5) * min(4.0 * share.x * (1.0 - share.x), 1.0);
        material = material.yzx;
        share = vec3(share.yz, 0.0);
    } while (share.x > least_share);
    // From afar, where no stone is seen, they mix by their shares.
    float top = max(max(now.reach, before.reach), first.reach) - mix(0.6, 0.15, near);
    vec3 weight = max(vec3(now.reach, before.reach, first.reach) - top, 0.0);
    weight /= weight.x + weight.y + weight.z;
    vec3 colour = weight.x * now.colour + weight.y * before.colour + weight.z * first.colour;
    vec3 bump = weight.x * now.bump + weight.y * before.bump + weight.z * first.bump;
    // No meadow is one green; further away the noise of the map's texels is all that there is.
    float noise = dot(base, vec3(1.0)) / max(dot(map, vec3(1.0)), 1e-4);
    colour *= mix(0.3 + 0.7 * noise, 0.65 + 0.35 * noise, near);
    base = mix(base, clamp(colour, 0.0, 0.95), fade);
    bump *= layers.z;
    vec3 ground = normalize(mix(normal, map_normal, 0.5 * near));
    bump -= ground * dot(bump, ground);
    normal = normalize(mix(normal, ground - bump, fade));
    return wet;
}
#endif
)";
}

} // namespace fjell::gl
