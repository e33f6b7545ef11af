#include "fjell/gl/light.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "gl/fail.h"

namespace fjell::gl {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;

struct Field {
    const char* name;
    double value, least, most;
};

// Shorter than std::to_string: 0.5, 280, -12000.
std::string number_text(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.10g", value);
    return text;
}

// Meeus, equation 7.1, for dates of the Gregorian calendar. A day past the month's end counts on.
double julian_day(std::uint32_t year, std::uint32_t month, double day) {
    const double y = month > 2 ? year : year - 1.0, m = month > 2 ? month : month + 12.0;
    const double century = std::floor(y / 100);
    return std::floor(365.25 * (y + 4716)) + std::floor(30.6001 * (m + 1)) + day + 2 - century +
           std::floor(century / 4) - 1524.5;
}

double turn(double degrees) {
    const double rest = std::fmod(degrees, 360.0);
    return rest < 0 ? rest + 360 : rest;
}

} // namespace

void validate(const LightSettings& light) {
    const Field fields[] = {
        {"azimuth_deg", light.azimuth_deg, 0, 360},
        {"elevation_deg", light.elevation_deg, min_sun_elevation_deg, 90},
        {"latitude_deg", light.latitude_deg, -90, 90},
        {"longitude_deg", light.longitude_deg, -180, 180},
        {"year", static_cast<double>(light.year), min_sun_year, max_sun_year},
        {"month", static_cast<double>(light.month), 1, 12},
        {"day", static_cast<double>(light.day), 1, 31},
        {"hour_utc", light.hour_utc, 0, 24},
        {"visibility_km", light.visibility_km, min_visibility_km, max_visibility_km},
        {"ev100", light.ev100, min_ev100, max_ev100},
        {"exposure_bias_ev", light.exposure_bias_ev, -max_exposure_bias_ev, max_exposure_bias_ev},
        {"water_level_m", light.water_level_m, min_water_level_m, max_water_level_m},
    };
    for (const Field& field : fields)
        if (!(field.value >= field.least && field.value <= field.most)) // NaN too
            fail(std::string("LightSettings::") + field.name + " must be a number from " + number_text(field.least) +
                 " to " + number_text(field.most));
    if (light.sun > SunBy::time) fail("LightSettings::sun must be direction or time");
    if (light.air > Air::physical) fail("LightSettings::air must be simple or physical");
    if (light.exposure > Exposure::fixed) fail("LightSettings::exposure must be automatic or fixed");
    if (light.tone_curve > ToneCurve::filmic) fail("LightSettings::tone_curve must be none or filmic");
}

SunPosition sun_position(const LightSettings& light) {
    const double days = julian_day(light.year, light.month, light.day + light.hour_utc / 24) - 2451545.0;
    const double t = days / 36525; // UT for TD: the minute between them moves the sun by 0.0007 degrees
    // Chapter 25: mean longitude, mean anomaly, the equation of the centre, and the apparent longitude.
    const double mean = 280.46646 + t * (36000.76983 + t * 0.0003032);
    const double anomaly = (357.52911 + t * (35999.05029 - t * 0.0001537)) * degree;
    const double centre = (1.914602 - t * (0.004817 + t * 0.000014)) * std::sin(anomaly) +
                          (0.019993 - t * 0.000101) * std::sin(2 * anomaly) + 0.000289 * std::sin(3 * anomaly);
    const double node = (125.04 - 1934.136 * t) * degree;
    const double longitude = (mean + centre - 0.00569 - 0.00478 * std::sin(node)) * degree;
    const double obliquity =
        (23.4392911 - t * (0.0130042 + t * (1.64e-7 - t * 5.04e-7)) + 0.00256 * std::cos(node)) * degree;
    const double ascension =
        std::atan2(std::cos(obliquity) * std::sin(longitude), std::cos(longitude)); // equation 25.6
    const double declination = std::asin(std::sin(obliquity) * std::sin(longitude));
    // Equation 12.4, and the hour angle west of the meridian.
    const double sidereal = 280.46061837 + 360.98564736629 * days + t * t * (0.000387933 - t / 38710000);
    const double hour = turn(sidereal + light.longitude_deg - ascension / degree) * degree;
    const double latitude = light.latitude_deg * degree; // chapter 13
    const double south = std::sin(hour),
                 west = std::cos(hour) * std::sin(latitude) - std::tan(declination) * std::cos(latitude);
    SunPosition at;
    at.azimuth_deg = turn(std::atan2(south, west) / degree + 180);
    at.elevation_deg = std::asin(std::clamp(std::sin(latitude) * std::sin(declination) +
                                                std::cos(latitude) * std::cos(declination) * std::cos(hour),
                                            -1.0, 1.0)) /
                       degree;
    return at;
}

Vec3 sun_direction(const LightSettings& light) {
    const SunPosition at =
        light.sun == SunBy::time ? sun_position(light) : SunPosition{light.azimuth_deg, light.elevation_deg};
    const double azimuth = at.azimuth_deg * degree, elevation = at.elevation_deg * degree;
    return {std::sin(azimuth) * std::cos(elevation), std::sin(elevation), -std::cos(azimuth) * std::cos(elevation)};
}

} // namespace fjell::gl
