#version 330 core
in vec4 vertex;
uniform mat4 world;
uniform mat4 viewproj;
uniform mat4 shadow_viewproj;
uniform vec4 eye_in_scene_m;

out vec3 from_eye_m;
out vec3 scene_m;
out vec4 in_shadow;

void main() {
    scene_m = (world * vertex).xyz;
    from_eye_m = scene_m - eye_in_scene_m.xyz;
    in_shadow = shadow_viewproj * vec4(scene_m, 1.0);
    gl_Position = viewproj * vec4(scene_m, 1.0);
}
