#version 330 core
in vec3 from_eye_m;
in vec3 scene_m;
in vec4 in_shadow;
uniform sampler2D shadow_map;
uniform vec4 sun; // towards it
uniform vec4 tint;
uniform vec4 shadow; // 1 / texels; a texel in the shadow's depth
out vec4 colour;

float lit(float facing) {
    vec3 at = in_shadow.xyz / in_shadow.w;
    at.z = at.z * 0.5 + 0.5; // OGRE maps x and y to the texture, and leaves depth as OpenGL has it
    if (any(lessThan(at.xy, vec2(0.0))) || any(greaterThan(at.xy, vec2(1.0)))) return 1.0;
    // Within the texels that are asked the ground rises so much towards the sun, or it would shade itself.
    float bias = shadow.y * (0.5 + 2.2 * sqrt(1.0 - facing * facing) / max(facing, 0.1));
    float sum = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            sum += texture(shadow_map, at.xy + vec2(x, y) * shadow.x).r + bias < at.z ? 0.0 : 1.0;
    return sum / 9.0;
}

void main() {
    vec3 normal = normalize(cross(dFdx(from_eye_m), dFdy(from_eye_m)));
    if (dot(normal, from_eye_m) > 0.0) normal = -normal;
    float facing = max(dot(normal, sun.xyz), 0.0);
    vec3 ground = tint.rgb;
    if (tint.a > 0.0) ground = mix(ground, vec3(0.36, 0.33, 0.29), smoothstep(0.82, 0.62, normal.y)); // rock where steep
    vec3 lit_m = ground * (vec3(0.22, 0.26, 0.33) + vec3(1.0, 0.94, 0.82) * facing * lit(facing));
    float air = 1.0 - exp(-length(from_eye_m) / 30000.0);
    colour = vec4(pow(mix(lit_m, vec3(0.45, 0.58, 0.75), air), vec3(1.0 / 2.2)), 1.0);
}
