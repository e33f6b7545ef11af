// What is drawn over the ground's colour, in GLSL: edges of triangles, borders of tiles and pages, contours, slopes.
#include "gl/shaders.h"

namespace fjell::gl {

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
        if (band >= 0) colour = mix(colour, bands[min(band, 3)], 0.6);
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
