#version 460
#extension GL_GOOGLE_include_directive : require
#include "terrain.glsl"

layout(location = 0) in vec3 world_m;
layout(location = 0) out vec4 colour;

void main() {
    vec3 normal = normalize(cross(dFdx(world_m), dFdy(world_m))); // of the triangle
    if (normal.z < 0.0) normal = -normal;
    float high = (world_m.z + frame.origin_height_m - frame.low_high_m.x) / (frame.low_high_m.y - frame.low_high_m.x);
    vec3 ground = mix(vec3(0.06, 0.11, 0.03), vec3(0.24, 0.19, 0.14), smoothstep(0.1, 0.6, high));
    ground = mix(ground, vec3(0.8), smoothstep(0.75, 0.95, high) * smoothstep(0.6, 0.9, normal.z));
    colour = vec4(ground * (0.15 + 1.1 * max(dot(normal, normalize(vec3(-0.8, 0.5, 0.35))), 0.0)), 1.0);
}
