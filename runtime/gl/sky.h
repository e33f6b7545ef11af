// The sky as tables: radiance by direction and altitude, and what of it lights the ground and the air before it.
//
// S. Hillaire, A Scalable and Production Ready Sky and Atmosphere Rendering Technique (2020): the atmosphere of its
// table 1, a table of transmittance (after E. Bruneton), one of multiple scattering, and a sky view. Departures: all on
// the CPU and only when the sun or the air changes; the sky view ends at the planet's horizon, which is drawn level
// because the ground is flat; it has four altitudes instead of following the eye; aerial perspective is a closed form
// in the shader, fed by SkyLight::source. Radiance is that of a sun of irradiance 1 above the air, seen by film for
// daylight. Internal to runtime/gl. Memory: 120 KB. Complexity: make_sky() some 25 ms.
#pragma once

#include <array>
#include <vector>

#include "fjell/view.h"

namespace fjell::gl {

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

} // namespace fjell::gl
