#version 450
layout(location = 0) in ivec2 sample_at;   // MeshVertex: column, row
layout(location = 1) in float full_m;      // MeshVertex: height_m
layout(location = 2) in vec4 morph_vertex; // MorphVertex: morph_from_m, error_m, radius_m, activated_s

uniform vec2 spacing_m;     // from column to column, from row to row
uniform ivec2 eye_cell;     // the column and row north-west of the eye
uniform vec2 eye_in_cell_m; // and how far the eye is from there: east, south
uniform vec2 eye_height_m;  // the nearest float, and what is missing to the double
uniform mat4 clip_from_eye; // of positions that count from the eye

uniform int morph_views;     // MorphFrame::views; 0 without morphing
uniform vec3 morph_eye_m[8]; // MorphView's eye, counted from the drawing eye
uniform vec2 morph_q[8];     // MorphView: start_per_error, full_per_error
uniform vec3 morph_time_s;   // MorphFrame: now_s, morph_s; morph_clock_s

out vec3 from_eye_m;
out vec2 at_sample;
invariant gl_Position;

float morph_age_s(float now_s, float then_s) {
    float age_s = now_s - then_s;
    return age_s < 0.0 ? age_s + morph_time_s.z : age_s; // the cut's clock has started again
}

// morphed_height_m() of fjell/cut.h. position_m: at the full height.
float morphed_height_m(vec3 position_m) {
    float morph_from_m = morph_vertex.x, error_m = morph_vertex.y, radius_m = morph_vertex.z;
    float t = 0.0;
    for (int i = 0; i < morph_views; ++i) {
        float start_m = radius_m + error_m * morph_q[i].x, end_m = radius_m + error_m * morph_q[i].y;
        float distance_m = distance(position_m, morph_eye_m[i]);
        t = max(t, start_m > end_m ? (start_m - distance_m) / (start_m - end_m) : distance_m < start_m ? 1.0 : 0.0);
    }
    t = min(t, morph_age_s(morph_time_s.x, morph_vertex.w) / morph_time_s.y);
    return mix(morph_from_m, full_m, clamp(t, 0.0, 1.0));
}

void main() {
    vec2 cells = vec2(sample_at - eye_cell); // whole numbers: exact, however far the terrain's corner is
    precise vec3 p = vec3(cells.x * spacing_m.x - eye_in_cell_m.x, (full_m - eye_height_m.x) - eye_height_m.y,
                          cells.y * spacing_m.y - eye_in_cell_m.y);
    if (morph_views > 0) p.y = (morphed_height_m(p) - eye_height_m.x) - eye_height_m.y;
    from_eye_m = p;
    at_sample = vec2(sample_at);
    gl_Position = clip_from_eye * vec4(p, 1.0);
}
