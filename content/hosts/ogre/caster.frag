#version 330 core
in vec3 scene_m;
out vec4 depth;
void main() { depth = vec4(gl_FragCoord.z); }
