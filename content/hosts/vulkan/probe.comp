#version 460
// For the check: where the vertices of the device's buffer stand, by the code that draws them.
#extension GL_GOOGLE_include_directive : require
#include "terrain.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 1, std430) readonly buffer Vertices { uvec4 vertices[]; };
layout(set = 0, binding = 2, std430) readonly buffer Asked { uint asked_count, unused; uvec2 asked[]; }; // slot, place of a tile
layout(set = 0, binding = 3, std430) writeonly buffer Answers { vec4 answers[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= asked_count) return;
    answers[i] = vec4(world_position(vertices[asked[i].x], int(asked[i].y)), 1.0);
}
