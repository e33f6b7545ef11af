// Light and air: where the sun stands, how clear the air is, how the picture is exposed, and how much of it is drawn.
//
// One struct for all of it, as profiles, command lines and editors set it; Renderer::draw() takes it in DrawOptions.
// Units: degrees, kilometres, metres, stops (EV) and hours, where the name says so. Scene axes: x east, y up, z south.
// Ownership: plain values. Thread: any. Complexity: O(1). Failure: validate() throws io::Failure, 3.
#pragma once

#include <cstdint>
#include <string>

#include "fjell/export.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell::gl {

// Where the sun's place comes from.
enum class SunBy : std::uint8_t { direction, time };
// How the sky and the air before the ground are drawn. simple: two colours and one exponential a pixel. physical:
// from a table, with Rayleigh's and Mie's scattering apart.
enum class Air : std::uint8_t { simple, physical };
// automatic: by the light that falls on the ground, as an incident-light meter measures it; the same settings over the
// same terrain always give the same exposure, whatever is looked at. fixed: by ev100.
enum class Exposure : std::uint8_t { automatic, fixed };
// none: light is cut off at white. filmic: it rolls off, as film does.
enum class ToneCurve : std::uint8_t { none, filmic };

// Ranges, for validate() and for whoever offers the fields.
inline constexpr double min_sun_elevation_deg = -18;
inline constexpr std::uint32_t min_sun_year = 1950, max_sun_year = 2050;
inline constexpr double min_visibility_km = 1, max_visibility_km = 280;
inline constexpr double min_ev100 = -6, max_ev100 = 20, max_exposure_bias_ev = 8;
inline constexpr double min_water_level_m = -12000, max_water_level_m = 100000;

struct LightSettings {
    SunBy sun = SunBy::direction;
    double azimuth_deg = 315;  // by direction: clockwise from north, 0 to 360; from the upper left, as maps are lit
    double elevation_deg = 40; // by direction: above the horizon, -18 to 90
    double latitude_deg = 45;  // by time: north positive, -90 to 90
    double longitude_deg = 0;  // by time: east positive, -180 to 180
    std::uint32_t year = 2026; // by time: 1950 to 2050
    std::uint32_t month = 6;   // by time: 1 to 12
    std::uint32_t day = 21;    // by time: 1 to 31; past the month's end it counts on into the next
    double hour_utc = 12;      // by time: universal time, 0 to 24

    Air air = Air::physical;
    // How far a black ridge can be told from the sky at sea level (Koschmieder's range), 1 to 280 km: 280 is pure air.
    // Terrain of more than 400 km across is taken for a model of one that size, and its air is thinner by as much.
    double visibility_km = 160;

    Exposure exposure = Exposure::automatic;
    double ev100 = 15;           // fixed: exposure value at ISO 100, -6 to 20 stops; sunlit ground 14 to 15
    double exposure_bias_ev = 0; // brighter by so many stops, -8 to 8; automatic and fixed
    ToneCurve tone_curve = ToneCurve::filmic;
    bool dither = true; // noise of half an 8-bit step, so that skies have no bands
    bool detail = true; // fine noise on near ground, where a texel of its map covers many pixels
    // Shadows of the ground on itself, and less of the sky's light where ground hides some of the sky: of packs with
    // horizon maps (fjell-bake --horizons). Six texture reads a pixel.
    bool shadows = true;

    bool water = false;       // a sheet of water at one level, over the ground that lies below it
    double water_level_m = 0; // -12000 to 100000
};

// Throws io::Failure, 3, with one line that names the field: "LightSettings::visibility_km must be a number from 1 to
// 280".
void validate(const LightSettings& light);

// A place on the sky.
struct SunPosition {
    double azimuth_deg = 0;   // clockwise from north, 0 to 360
    double elevation_deg = 0; // of the sun's centre, as geometry has it: air lifts it by 0.6 degrees at the horizon
};

// Where the sun stands by year, month, day and hour_utc, seen from latitude_deg and longitude_deg. To 0.02 degrees
// (J. Meeus, Astronomical Algorithms, 2nd edition: chapters 7, 12, 13 and the low accuracy of 25).
[[nodiscard]] SunPosition sun_position(const LightSettings& light);
// Unit vector to the sun, by direction or by time.
[[nodiscard]] Vec3 sun_direction(const LightSettings& light);

} // namespace fjell::gl
FJELL_API_END
