// Light, air and water, in GLSL: what shaders.cpp colours the ground with, and the sky behind it.
#include "gl/shaders.h"

namespace fjell::gl {

// In front of the fragment shaders of the sky and of shaded ground. Defines: AIR for the physical air.
const char* light_shader() {
    return R"(
#ifdef AIR
layout(binding = 16) uniform sampler2DArray sky_map;
#endif

float luminance(vec3 colour) { return dot(colour, vec3(0.2126, 0.7152, 0.0722)); }

// Light that level air scatters towards the eye from a direction until nothing shines through it any more.
vec3 haze_source(vec3 direction) {
#ifdef AIR
    float to_sun = dot(direction, sun.xyz), towards = dot(direction.xz, sun_level.xy);
    float g = 1.64 - 1.6 * to_sun; // Mie's phase function: Cornette and Shanks, g = 0.8 (lighting.h)
    float lobe = 1.0 + to_sun * to_sun;
    float mie = 0.01628 * lobe * inversesqrt(g * g * g);
    return max(source[0].rgb + source[3].rgb * towards, 0.0) * (0.0596831 * lobe) +
           max(source[1].rgb + source[4].rgb * towards, 0.0) * mie + source[2].rgb;
#else
    float glow = max(dot(direction, sun.xyz), 0.0);
    glow *= glow;
    glow *= glow;
    return sky_simple[0].rgb + sky_simple[2].rgb * (glow * glow);
#endif
}

// Above the horizon.
vec3 sky_radiance(vec3 direction) {
    float up = max(direction.y, 0.0);
#ifdef AIR
    // The table's axes: sky.h.
    float level = max(dot(direction.xz, direction.xz), 1e-8);
    float towards = dot(direction.xz, sun_level.xy) * inversesqrt(level);
    vec2 at = vec2(sqrt(max(0.5 - 0.5 * towards, 0.0)), sqrt(up)) * vec2(39.0 / 40.0, 55.0 / 56.0) +
              vec2(0.5 / 40.0, 0.5 / 56.0);
    return mix(texture(sky_map, vec3(at, sun_level.z)).rgb, texture(sky_map, vec3(at, sun_level.z + 1.0)).rgb,
               sun_level.w);
#else
    return mix(sky_simple[1].rgb, haze_source(direction), exp(-3.5 * up));
#endif
}

// What of light comes through the air on a way of so many metres that ends so many metres above the eye.
vec3 through_air(float metres, float rise) {
#ifdef AIR
    // Densities fall by e every 8000 and 1200 m (lighting.h): their means over the way, relative to the eye's.
    vec2 x = clamp(rise * vec2(air[0].w, air[1].w), -30.0, 30.0);
    vec2 mean = mix((1.0 - exp(-x)) / x, 1.0 - 0.5 * x, lessThan(abs(x), vec2(1e-3)));
    return exp(-metres * (air[0].rgb * mean.x + air[1].rgb * mean.y));
#else
    // Blue light is scattered first: transmittances to the powers 3/4, 1 and 3/2 from one exponential.
    float a = exp(-0.25 * metres * air[0].g), a2 = a * a, a3 = a2 * a;
    return vec3(a3, a2 * a2, a3 * a3);
#endif
}

vec3 sun_at(float rise) {
    return mix(sun_low.rgb, sun_high.rgb, clamp((rise - sun_low.w) * sun_high.w, 0.0, 1.0));
}
// Of a white surface: the sun's light and the sky's, over pi.
vec3 sky_light(vec3 normal) {
    return ambient[0].rgb + ambient[1].rgb * normal.y + ambient[2].rgb * dot(normal.xz, sun_level.xy);
}

// What a surface of water shows of the sky and the sun, and of what is below. calm: 0 where waves are finer than a pixel,
// which widens the sun's glint (Blinn and Phong, normalised).
vec3 on_water(vec3 below, vec3 direction, vec3 normal, float calm, float rise) {
    float facing = max(dot(normal, -direction), 0.02);
    float fresnel = 0.02 + 0.98 * pow(1.0 - facing, 5.0) / (1.0 + 4.0 * (1.0 - facing)); // rough: less at grazing angles
    vec3 mirrored = reflect(direction, normal);
    vec3 reflected = sky_radiance(vec3(mirrored.x, abs(mirrored.y), mirrored.z));
    vec3 half_way = normalize(sun.xyz - direction);
    float power = 140.0 * exp2(2.7 * calm), off = 1.0 - max(dot(half_way, -direction), 0.0), off2 = off * off;
    float glint = (power + 8.0) * 0.0398 * pow(max(dot(half_way, normal), 0.0), power);
    return mix(below, reflected, fresnel) +
           sun_at(rise) * (glint * max(sun.y, 0.0) * (0.02 + 0.98 * off2 * off2 * off));
}

// What level ground fades into: the brightest of the sky, so that nothing lies between the two.
vec3 far_air(vec3 direction) { return sky_radiance(vec3(direction.x, 0.0, direction.z)); }

// The level ground or sea that lies under the terrain, at the lowest height: what is seen through holes, and beyond the
// ground around it.
vec3 backdrop(vec3 direction) {
    float down = max(-direction.y, 1e-6), metres = -backdrop_at.w / down;
    vec3 lit = backdrop_at.rgb * (sun_at(backdrop_at.w) * (0.31831 * max(sun.y, 0.0)) + sky_light(vec3(0.0, 1.0, 0.0)));
    if (water.y > 0.0) lit = on_water(lit, direction, vec3(0.0, 1.0, 0.0), 0.0, backdrop_at.w);
    if (haze.x <= 0.0) return lit;
    float seen = water.y > 0.0 ? 1.0 : exp(-0.5 * metres * surround.x);
    return mix(far_air(direction), lit, seen * through_air(metres, backdrop_at.w));
}

// Exposure; S. Hill's fit of the ACES curve (BakingLab, 2016), whose matrices let bright colours pale; half an 8-bit step of noise (J. Jimenez, Interleaved Gradient
// Noise, 2014), as wide in linear light as sRGB's curve makes it.
vec3 picture(vec3 colour) {
    colour = max(colour, 0.0) * film.x;
    if (film.y > 0.0) {
        const mat3 to_film = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
        const mat3 from_film = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
        vec3 c = to_film * colour;
        c = (c * (c + 0.0245786) - 0.000090537) / (c * (0.983729 * c + 0.4329510) + 0.238081);
        colour = clamp(from_film * c, 0.0, 1.0);
    }
    if (film.z > 0.0) {
        float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
        colour += noise * film.z * max(0.0064 * sqrt(colour) + 0.0026 * colour, 0.0003);
    }
    return colour;
}
)";
}

// For shaded ground. Defines: DETAIL, WATER, SHADOWS.
const char* ground_light_shader() {
    return R"(
#if (defined(DETAIL) || defined(WATER)) && !defined(LAYERS)
layout(binding = 17) uniform sampler2D noise_map;
#endif

#ifdef DETAIL
// 17 times finer and turned by 28 degrees, so that no two scales line up; whole numbers keep what repeats repeating.
const mat2 finer = mat2(15.0, 8.0, -8.0, 15.0);

// Roughens what a map's texels, as large as a cell, leave smooth: steep ground more than level ground, from three sides
// where it is steep. Mips fade the finer scales out with the distance. The coarsest, as wide as texels, would never end,
// and show as blotches: it fades where a texel is a few pixels. So nothing pops, and far ground is as it was baked. Snow
// has what wind makes of it instead: long low waves, bluish in their hollows, and grains that glitter nearby.
void add_detail(inout vec3 base, inout vec3 normal, float snow, out float glitter) {
    vec3 at = (surface.position + noise_at.xyz) * noise_scale.x; // from the corner of the eye's cell
    vec3 dx = dFdx(surface.position), dy = dFdy(surface.position);
    float coarse = smoothstep(2.0, 9.0, noise_scale.z * inversesqrt(sqrt(max(dot(dx, dx) * dot(dy, dy), 1e-20))));
    dx *= noise_scale.x;
    dy *= noise_scale.x;
    vec3 side = normal * normal;
    side *= side;
    side.xz *= smoothstep(0.9, 0.75, normal.y); // sides count from 26 degrees on
    side = max(side / (side.x + side.y + side.z) - 0.05, 0.0);
    side /= side.x + side.y + side.z;
    float rough = smoothstep(0.03, 0.35, 1.0 - normal.y) * (1.0 - 0.35 * snow);
    vec2 shade = vec2(0.0); // soft, ridged
    vec3 bump = vec3(0.0);
    vec3 left = side;
    float grain = 0.0;
    // A loop that ends with its condition: a software driver goes through every branch.
    do {
        // On cliffs noise is stretched downwards, as gullies are.
        bool above = left.y > 0.0, east = left.x > 0.0;
        mat2x3 plane = above ? mat2x3(1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
                     : east  ? mat2x3(0.0, 0.0, 1.0, 0.0, 0.6, 0.0)
                             : mat2x3(1.0, 0.0, 0.0, 0.0, 0.6, 0.0);
        float share = above ? left.y : east ? left.x : left.z;
        vec2 place = at * plane, along = dx * plane, across = dy * plane;
        vec4 all = coarse * (textureGrad(noise_map, place, along, across) - 0.5);
        place = finer * place, along = finer * along, across = finer * across;
        all += textureGrad(noise_map, place, along, across) - 0.5;
        vec4 fine = textureGrad(noise_map, finer * place, finer * along, finer * across) - 0.5;
        all += 0.8 * fine;
        grain += share * fine.z;
        shade += share * all.zw;
        bump += plane * (share * all.xy);
        left = above ? vec3(left.x, 0.0, left.z) : east ? vec3(0.0, 0.0, left.z) : vec3(0.0);
    } while (left.x + left.y + left.z > 0.0);
    const mat2 wind = mat2(4.0, 15.0, -1.0, 3.75); // four times as long as wide
    vec4 drift = textureGrad(noise_map, wind * at.xz, wind * dx.xz, wind * dy.xz) - 0.5;
    base *= clamp(1.0 + mix(0.6 * shade.x, 0.75 * shade.y, rough) * (1.0 - 0.8 * snow), 0.3, 1.9);
    base *= 1.0 + snow * vec3(0.42, 0.30, 0.12) * drift.w;
    // Where a map's texel is half snow, patches are: as much in all as before.
    base += vec3(0.6, 0.62, 0.66) * (clamp(snow + 6.0 * snow * (1.0 - snow) * shade.y, 0.0, 1.0) - snow);
    bump = mix(bump, vec3(0.7 * bump.x + 0.6 * drift.x, bump.y, 0.7 * bump.z - 0.16 * drift.x), snow);
    normal = normalize(normal - mix(0.5, 1.4, rough) * (bump - normal * dot(bump, normal)));
    // A threshold is not filtered by mips: grains are seen where a texel of the finest scale covers pixels.
    glitter = snow * smoothstep(0.22, 0.36, grain) * clamp(2.0 - 2.0 * 289.0 * 256.0 * max(length(dx), length(dy)), 0.0, 1.0);
}
#endif

#ifdef WATER
// Two trains of small waves.
vec3 wave_normal(vec3 at, out float calm) {
    vec2 place = at.xz + noise_at.xz;
    vec2 first = texture(noise_map, place * noise_scale.y + film.w * vec2(0.021, 0.013)).xy;
    vec2 second = texture(noise_map, place.yx * (noise_scale.y * 0.25) - film.w * vec2(0.006, 0.004)).xy;
    vec2 slope = first + second - 1.0;
    calm = clamp(0.5 - 0.25 * log2(max(8.0 * noise_scale.y * length(fwidth(at.xz)), 1e-6)), 0.0, 1.0);
    return normalize(vec3(-0.22 * slope.x, 1.0, -0.22 * slope.y));
}

// What comes up out of deep water.
vec3 body_of_water(float rise) {
    return vec3(0.012, 0.045, 0.06) * (sun_at(rise) * max(sun.y, 0.0) * 0.31831 + sky_light(vec3(0.0, 1.0, 0.0)));
}

// A lake that the splat map knows: how deep it is nobody knows, so ground shows through at its shore alone.
vec3 on_lake(vec3 direction, float rise) {
    float calm;
    vec3 normal = wave_normal(surface.position, calm);
    return on_water(body_of_water(rise), direction, normal, calm, rise);
}

// Light from the ground below, dimmed and tinted by its depth, and the sky and the sun on the surface.
vec3 under_water(vec3 ground, vec3 direction, float way, float depth, float rise) {
    vec3 clear = exp(-(depth + 1.1 * way) * water_tint.rgb);
    float calm;
    vec3 normal = wave_normal(direction * (water.x / direction.y), calm);
    return on_water(mix(body_of_water(rise), ground, clear), direction, normal, calm, rise);
}
#endif

#ifdef SHADOWS
layout(binding = 20) uniform sampler2DArray horizon_map[HORIZON_MAPS];

// Of one mip: the sine of the horizon's elevation towards the sun, and the share of the sky that is seen. Planes stand
// side by side, so texels are counted and no filter leaves its plane; the outermost texel centres lie on the border.
vec2 horizon_of_mip(vec2 at, ivec2 map, int mip, int first_mip) {
    float texels = exp2(log2(shadow.z) - float(mip)), per = 1.0 / (4.0 * texels), lod = float(mip - first_mip);
    vec2 place = at * (texels - 1.0) + 0.5;
    float before = textureLod(horizon_map[map.y], vec3((place + shadow_plane.xy * texels) * per, map.x), lod).r;
    float after = textureLod(horizon_map[map.y], vec3((place + shadow_plane.zw * texels) * per, map.x), lod).r;
    float sky = textureLod(horizon_map[map.y], vec3((place + 3.0 * texels) * per, map.x), lod).r;
    return vec2(mix(before, after, shadow.x), sky);
}

// The same, between two mips; of a tile whose map has not come: nothing hides anything.
vec2 horizon_here() {
    vec2 at = clamp(surface.sample_at / float(1 << tile.x), 0.0, 1.0), texel = at * shadow.z;
    vec2 dx = dFdx(texel), dy = dFdy(texel);
#ifdef ALL_THERE
    ivec2 map = ivec2(surface.block, 0);
    float least = 0.0;
    int first_mip = 0;
#else
    ivec2 map = tile_block[surface.block].horizon;
    if (map.y < 0) return vec2(0.0, 1.0);
    float least = finest_mip(2);
    int first_mip = tile_block[surface.block].horizon_mip;
#endif
    float mip = clamp(0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-9)), least, shadow.w - 1.0);
    int finer = int(mip);
    vec2 fine = horizon_of_mip(at, map, finer, first_mip);
    vec2 coarse = horizon_of_mip(at, map, min(finer + 1, int(shadow.w) - 1), first_mip);
    return mix(fine, coarse, mip - float(finer));
}
#endif

// The ground's colour as the eye's film gets it. base: diffuse, of which no more light leaves than comes.
vec3 shaded(vec3 base, vec3 normal) {
    float steep = length(normal.xz);
    float squared = dot(surface.position, surface.position), inverse = inversesqrt(squared), metres = squared * inverse;
    vec3 direction = surface.position * inverse;
#ifdef LAYERS
    vec3 map = base, map_normal = normal;
#endif
    // Light goes through snow a little: its shaded side begins softly.
    float snow = smoothstep(0.25, 0.65, min(min(base.r, base.g), base.b)), glitter = 0.0;
#ifdef DETAIL
    add_detail(base, normal, snow, glitter);
#endif
#ifdef LAYERS
    // Nearby a strong colour of the map only leans on a material's own: soil under an orange image is not orange.
    float grey = max(luminance(map), 1e-4);
    vec3 leaning = sqrt(max(map, 0.0) / grey);
    leaning *= grey / max(luminance(leaning), 1e-4);
    float lake = add_layers(base, normal, mix(leaning, map, smoothstep(0.05, 0.6, metres / layers.x)), map_normal,
                            metres);
#endif
    float rise = surface.position.y;
    float facing = dot(normal, sun.xyz), sky_seen = 1.0;
    float sunlit = 0.31831 * max(mix(facing, 0.9 * facing + 0.1, snow), 0.0) * (1.0 + 3.0 * glitter);
#ifdef SHADOWS
    vec2 horizon = horizon_here();
    sunlit *= smoothstep(horizon.x - shadow.y, horizon.x + shadow.y, sun.y);
    sky_seen = horizon.y;
#endif
    vec3 colour = base * (sun_at(rise) * sunlit + mix(bounce.rgb, sky_light(normal), sky_seen));
#ifdef LAKES
    // A shore is sharper than the map's texels are, and wet.
    // At the edges of triangles a software driver's neighbours know no share: nothing but water stays water there.
    float lake_soft = clamp(fwidth(lake), 0.02, 0.5);
    colour *= 1.0 - 0.4 * smoothstep(0.36, 0.48, lake);
    colour = mix(colour, on_lake(direction, rise), smoothstep(0.5 - lake_soft, 0.5 + lake_soft, lake) * mix(0.75, 1.0, smoothstep(0.5, 0.62, lake)));
#endif
#ifdef WATER
    float depth = water.x - rise;
    if (water.y > 0.0 && depth > -0.5) {
        colour *= mix(0.6, 1.0, clamp(-2.0 * depth, 0.0, 1.0)); // a wet shore
        float unknown = smoothstep(2.0 * water.z, water.z, abs(depth)) * smoothstep(0.02, 0.006, steep);
        float to_surface = water.x / direction.y, cover = max(clamp(depth / (water.w + 1.5 * fwidth(rise)), 0.0, 1.0), unknown);
        vec3 wet = under_water(colour, direction, max(metres - to_surface, 0.0) + 100.0 * unknown, max(depth, 0.0), water.x);
        colour = mix(colour, wet, cover);
        metres = mix(metres, to_surface, cover);
        rise = mix(rise, water.x, cover);
    }
#endif
    if (haze.x > 0.0) colour = mix(haze_source(direction), colour, through_air(metres, rise));
    return picture(colour);
}
)";
}

// One triangle over the whole picture at depth 0, the farthest: it passes only where nothing was drawn.
const char* sky_vertex_shader() {
    return R"(
out vec3 v_ray;
void main() {
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    v_ray = haze.yzw + corner.x * ray_x.xyz + corner.y * ray_y.xyz;
    gl_Position = vec4(corner, 0.0, 1.0);
}
)";
}

const char* sky_fragment_shader() {
    return R"(
in vec3 v_ray;
layout(location = 0) out vec4 out_colour;
void main() {
    vec3 direction = normalize(v_ray);
    vec3 colour = direction.y < 0.0 ? backdrop(direction) : sky_radiance(direction);
    // The sun's disc is 0.53 degrees wide; its edge is as soft as a pixel.
    float off = length(cross(direction, sun.xyz)), soft = max(fwidth(off), 1e-5);
    if (direction.y >= 0.0 && dot(direction, sun.xyz) > 0.0)
        colour += sun_low.rgb * (40.0 * clamp((0.00465 - off) / soft + 0.5, 0.0, 1.0));
    out_colour = vec4(picture(colour), 1.0);
}
)";
}

} // namespace fjell::gl
