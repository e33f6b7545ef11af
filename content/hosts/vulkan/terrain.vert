#version 460
#extension GL_GOOGLE_include_directive : require
#include "terrain.glsl"

layout(location = 0) in uvec4 vertex; // CompactVertex
layout(location = 0) out vec3 world_m;
invariant gl_Position;

void main() {
    world_m = world_position(vertex, gl_InstanceIndex); // firstInstance of a draw is the place of its tile
    gl_Position = frame.clip_from_world * vec4(world_m, 1.0);
}
