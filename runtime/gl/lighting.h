// The light of a draw: the sky's tables, and the two textures that shaders read. Internal to runtime/gl.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "fjell/gl/light.h"
#include "fjell/view.h"
#include "gl/objects.h"

namespace fjell::gl {

// The sky as tables: radiance by direction and altitude, and what of it lights the ground and the air before it.
//
// S. Hillaire, A Scalable and Production Ready Sky and Atmosphere Rendering Technique (2020): the atmosphere of its
// table 1, a table of transmittance (after E. Bruneton), one of multiple scattering, and a sky view. Departures: all on
// the CPU and only when the sun or the air changes; the sky view ends at the planet's horizon, which is drawn level
// because the ground is flat; it has four altitudes instead of following the eye; aerial perspective is a closed form
// in the shader, fed by SkyLight::source. Radiance is that of a sun of irradiance 1 above the air, seen by film for
// daylight. Memory: 120 KB. Complexity: make_sky() some 25 ms.

struct Rgb {
    float r = 0, g = 0, b = 0;
    friend constexpr Rgb operator+(Rgb x, Rgb y) { return {x.r + y.r, x.g + y.g, x.b + y.b}; }
    friend constexpr Rgb operator-(Rgb x, Rgb y) { return {x.r - y.r, x.g - y.g, x.b - y.b}; }
    friend constexpr Rgb operator*(Rgb x, Rgb y) { return {x.r * y.r, x.g * y.g, x.b * y.b}; }
    friend constexpr Rgb operator*(Rgb x, float f) { return {x.r * f, x.g * f, x.b * f}; }
};
[[nodiscard]] constexpr float luminance(Rgb c) {
    return 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b;
}

// Columns by the sine of half the angle from the sun's azimuth, rows by the root of the elevation's sine, slices by the
// root of the altitude; the first of each at 0, the last at 1 (180 degrees, the zenith, sky_top_m). Altitudes 0, 4, 16
// and 36 km.
inline constexpr int sky_columns = 40, sky_rows = 56, sky_slices = 4;
inline constexpr double sky_top_m = 36000;

// At one altitude.
struct SkyLight {
    Rgb sun; // irradiance across its rays
    // Irradiance / pi on a surface of normal n: [0] + [1] n.y + [2] (n along the sun's azimuth). With the ground's
    // bounce.
    std::array<Rgb, 3> ambient;
    // Light that a long level ray gathers, phase functions left out: Rayleigh's, Mie's, multiple scattering; of the
    // first two also what there is more of towards the sun's azimuth.
    std::array<Rgb, 5> source;
    Rgb zenith, horizon; // radiance; the horizon's mean beside and away from the sun
};

struct Sky {
    Rgb rayleigh, mie; // extinction at sea level, 1/m
    std::array<SkyLight, sky_slices> light;
    std::vector<float> radiance; // rgb, columns fastest
    std::vector<Rgb> transmittance, scattered;
};
inline constexpr float rayleigh_height_m = 8000, mie_height_m = 1200, mie_asymmetry = 0.8f;

void make_sky(Vec3 sun, double visibility_km, Sky& sky);
[[nodiscard]] SkyLight light_at(const Sky& sky, double altitude_m);
// The sun's irradiance at an altitude. sun_y: its elevation's sine.
[[nodiscard]] Rgb sun_at(const Sky& sky, double altitude_m, double sun_y);

inline constexpr unsigned sky_unit = 16, noise_unit = 17; // behind those of colours and normals
inline constexpr unsigned horizon_unit = 20;              // of the first horizon map, behind materials

// Which lines of the ground's shader are compiled: bits.
inline constexpr unsigned light_air = 1, light_detail = 2, light_water = 4, light_layers = 8, light_shadows = 16;
inline constexpr unsigned light_splat = 32; // with light_layers only
inline constexpr unsigned light_lakes = 64; // with light_splat and light_water only
inline constexpr unsigned light_none = 128, light_variants = 129;

// Made at the first draw that needs them; the tables anew when the sun or the air changes.
struct Lighting {
    Sky sky;
    Vec3 sun;                 // that the tables are for
    double visibility_km = 0; // 0: there are no tables yet
    Texture sky_map, noise_map;
    bool in_map = false; // whether sky_map holds the tables
    int units = 0;       // that this GPU gives a fragment shader

    // Bits of the variant for these settings. A GPU of only 16 texture units has the simple air and no detail.
    [[nodiscard]] unsigned variant(const LightSettings& light);
    // Tables and textures for these settings and this variant. Refuses settings out of range.
    void follow(const LightSettings& light, unsigned bits);
    void bind() const;
};

} // namespace fjell::gl
