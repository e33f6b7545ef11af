// Light and air: where the sun is, how clear the air is, how the picture is exposed, and which of these are drawn.
//
// One struct has all of it. Profiles, command lines and editors set it, and Renderer::draw() takes it in DrawOptions.
// Units: degrees, kilometres, metres, stops (EV) and hours, where the name says so. Scene axes: x east, y up, z south.
// Ownership: plain values. Thread: any. Complexity: O(1). Failure: validate() throws io::Failure, 3.
#pragma once

#include <cstdint>
#include <string>

#include "fjell/export.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell::gl {

// How the position of the sun is given.
enum class SunBy : std::uint8_t { direction, time };
// How the sky and the haze are drawn. simple: two colours and one exponential a pixel. physical: from a table, with
// Rayleigh and Mie scattering.
enum class Air : std::uint8_t { simple, physical };
// How bright the picture is. automatic: by the light that falls on the ground, as an incident-light meter measures it.
// The same settings over the same terrain always give the same exposure, wherever the camera looks. fixed: by ev100.
enum class Exposure : std::uint8_t { automatic, fixed };
// How light becomes colours of the picture. none: light is cut off at white. filmic: it rolls off, as film does.
enum class ToneCurve : std::uint8_t { none, filmic };

// Ranges, for validate() and for controls.
inline constexpr double min_sun_elevation_deg = -18;
inline constexpr std::uint32_t min_sun_year = 1950, max_sun_year = 2050;
inline constexpr double min_visibility_km = 1, max_visibility_km = 280;
inline constexpr double min_ev100 = -6, max_ev100 = 20, max_exposure_bias_ev = 8;
inline constexpr double min_water_level_m = -12000, max_water_level_m = 100000;

struct LightSettings {
    SunBy sun = SunBy::direction;
    // By direction: clockwise from north, 0 to 360. 315 lights from the upper left, as maps are lit.
    double azimuth_deg = 315;
    double elevation_deg = 40; // by direction: height above the horizon, -18 to 90
    double latitude_deg = 45;  // by time: north positive, -90 to 90
    double longitude_deg = 0;  // by time: east positive, -180 to 180
    std::uint32_t year = 2026; // by time: 1950 to 2050
    std::uint32_t month = 6;   // by time: 1 to 12
    // By time: 1 to 31. A day past the month's end counts on into the next month.
    std::uint32_t day = 21;
    double hour_utc = 12; // by time: universal time, 0 to 24

    Air air = Air::physical;
    // Visibility at sea level (Koschmieder's range): from how far a black ridge can be told from the sky. 1 to 280 km;
    // 280 is pure air. A terrain more than 400 km wide is treated as a model of one that is 400 km wide, and its air is
    // thinner in the same ratio.
    double visibility_km = 160;

    Exposure exposure = Exposure::automatic;
    // Fixed: exposure value at ISO 100, -6 to 20 stops. Sunlit ground has 14 to 15.
    double ev100 = 15;
    // Makes the picture brighter by this many stops, -8 to 8. Automatic and fixed.
    double exposure_bias_ev = 0;
    ToneCurve tone_curve = ToneCurve::filmic;
    bool dither = true; // noise of half an 8-bit step, so that skies show no bands
    // Fine noise on near ground, where a texel of its map covers many pixels.
    bool detail = true;
    // Shadows that the ground casts on itself, and less skylight where ground hides some of the sky. Needs a pack with
    // horizon maps (fjell-bake --horizons). Six texture reads a pixel.
    bool shadows = true;

    bool water = false;       // a sheet of water at one level, over lower ground
    double water_level_m = 0; // -12000 to 100000
};

// Throws io::Failure, 3, with one line that names the field: "LightSettings::visibility_km must be a number from 1 to
// 280".
void validate(const LightSettings& light);

// A position on the sky.
struct SunPosition {
    double azimuth_deg = 0; // clockwise from north, 0 to 360
    // Of the sun's centre without refraction; the air lifts it by 0.6 degrees at the horizon.
    double elevation_deg = 0;
};

// The position of the sun at year, month, day and hour_utc, seen from latitude_deg and longitude_deg. Accurate to 0.02
// degrees (J. Meeus, Astronomical Algorithms, 2nd edition: chapters 7, 12, 13 and the low accuracy of 25).
[[nodiscard]] SunPosition sun_position(const LightSettings& light);
// The unit vector to the sun, by direction or by time.
[[nodiscard]] Vec3 sun_direction(const LightSettings& light);

} // namespace fjell::gl
FJELL_API_END
