// What terrain.vert and probe.comp share: from the 16 bytes of a vertex to where it stands.
// World: right-handed, x east, y north, z up, metres, counted from an origin that follows the eye.
layout(set = 0, binding = 0, std140) uniform Frame { // Frame of drawer.h
    mat4 clip_from_world;
    ivec2 origin_sample; // column and row of the origin
    vec2 spacing_m;
    float origin_height_m;
    float now_s, morph_s; // MorphFrame's
    int morph_views;      // 0 without morphing
    int tiles_x, tile_log2;
    vec2 low_high_m;      // heights that occur, for the colours
    vec4 morph_eye_m[8];  // xyz, counted from the origin
    vec4 morph_q[8];      // xy: start_per_error, full_per_error
} frame;

const float morph_clock_s = 1024.0; // fjell::morph_clock_s
const float late_s = 1.0 / 32.0;    // fjell::compact_late_s

// The column and the row whose low 16 bits these are, out of those that the tile at a place can have.
ivec2 sample_of(uint low_bits, int place) {
    ivec2 first = ivec2(place % frame.tiles_x, place / frame.tiles_x) << frame.tile_log2;
    ivec2 low = ivec2(low_bits & 0xffffu, low_bits >> 16);
    return first + ((low - first) & 0xffff);
}

float unsigned_half(uint bits) { return uintBitsToFloat((bits << 12) + 0x3a800000u); } // from 2^-10 on

float morph_age_s(uint activated) {
    float age_s = frame.now_s - float(activated) / 64.0;
    return age_s - morph_clock_s * round(age_s / morph_clock_s); // the cut's clock starts again
}

// How far a vertex has morphed in: morphed_height_m() of fjell/cut.h has the same.
float morphed(vec3 full, float error_m, float radius_m, uint activated) {
    float t = frame.morph_views == 0 ? 1.0 : 0.0;
    for (int i = 0; i < frame.morph_views; ++i) {
        float start_m = radius_m + error_m * frame.morph_q[i].x, end_m = radius_m + error_m * frame.morph_q[i].y;
        t = max(t, (start_m - distance(full, frame.morph_eye_m[i].xyz)) / (start_m - end_m));
    }
    // What was activated late starts up to late_s later than the cut thinks, so it takes so much less.
    if (activated != 0xffffu) t = min(t, morph_age_s(activated) / max(frame.morph_s - late_s, 1e-3));
    return clamp(t, 0.0, 1.0);
}

// vertex: CompactVertex of fjell/compact.h.
vec3 world_position(uvec4 vertex, int place) {
    vec2 cells = vec2(sample_of(vertex.x, place) - frame.origin_sample); // whole numbers: exact
    precise vec3 p = vec3(cells.x * frame.spacing_m.x, -cells.y * frame.spacing_m.y,
                          uintBitsToFloat(vertex.y) - frame.origin_height_m);
    float rise_m = unpackHalf2x16(vertex.z).x; // to the flat height
    float t = morphed(p, unsigned_half(vertex.w & 0xffffu), unsigned_half(vertex.w >> 16), vertex.z >> 16);
    p.z += rise_m * (1.0 - t);
    return p;
}
