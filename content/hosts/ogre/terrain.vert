#version 330 core
in vec4 vertex; // column, row, height_m
in vec4 uv0;    // MorphVertex: morph_from_m, error_m, radius_m, activated_s

uniform vec4 spacing_m;      // x, z; 1 with morphing
uniform vec4 eye_cell;       // the column and row north-west of the eye
uniform vec4 eye_in_cell_m;  // how far the eye is from there: east, south; its height, and what is missing to the double
uniform vec4 eye_in_scene_m; // the eye, counted from the scene's origin
uniform vec4 morph_eye_m;    // MorphView's eye, counted from the eye
uniform vec4 morph;          // MorphView: start_per_error, full_per_error; MorphFrame: now_s, morph_s
uniform mat4 viewproj;       // OGRE's, of the camera or of the shadow's
uniform mat4 shadow_viewproj;

const float morph_clock_s = 1024.0;

out vec3 from_eye_m;
out vec3 scene_m;
out vec4 in_shadow;

// morphed_height_m() of fjell/cut.h, for one view. at_m: counted from the eye, at the full height.
float morphed_height_m(vec3 at_m) {
    float start_m = uv0.z + uv0.y * morph.x, end_m = uv0.z + uv0.y * morph.y, away_m = distance(at_m, morph_eye_m.xyz);
    float t = start_m > end_m ? (start_m - away_m) / (start_m - end_m) : away_m < start_m ? 1.0 : 0.0;
    float age_s = morph.z - uv0.w;
    if (age_s < 0.0) age_s += morph_clock_s; // the cut's clock has started again
    t = min(t, age_s / morph.w);
    return mix(uv0.x, vertex.z, clamp(t, 0.0, 1.0));
}

void main() {
    vec2 cells = vertex.xy - eye_cell.xy; // whole numbers: exact
    vec3 p = vec3(cells.x * spacing_m.x - eye_in_cell_m.x, (vertex.z - eye_in_cell_m.z) - eye_in_cell_m.w,
                  cells.y * spacing_m.y - eye_in_cell_m.y);
    if (spacing_m.z > 0.0) p.y = (morphed_height_m(p) - eye_in_cell_m.z) - eye_in_cell_m.w;
    from_eye_m = p;
    scene_m = p + eye_in_scene_m.xyz;
    in_shadow = shadow_viewproj * vec4(scene_m, 1.0);
    gl_Position = viewproj * vec4(scene_m, 1.0);
}
