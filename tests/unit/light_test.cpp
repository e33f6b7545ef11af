// Light: where the sun stands, what settings are refused, and the sky's tables.
#include <cmath>
#include <limits>
#include <string>

#include <catch2/catch.hpp>

#include "fjell/gl/light.h"
#include "fjell/profile/keys.h"
#include "gl/lighting.h"
#include "gl/noise.h"

using namespace fjell;
using namespace fjell::gl;

namespace {

LightSettings seen_from(double latitude_deg, double longitude_deg, std::uint32_t year, std::uint32_t month,
                        std::uint32_t day, double hour_utc) {
    LightSettings light;
    light.sun = SunBy::time;
    light.latitude_deg = latitude_deg;
    light.longitude_deg = longitude_deg;
    light.year = year;
    light.month = month;
    light.day = day;
    light.hour_utc = hour_utc;
    return light;
}

Vec3 at_elevation(double degrees) {
    return sun_direction({.azimuth_deg = 90, .elevation_deg = degrees});
}

// A profile with this key at this value.
LightSettings with(const fjell::ProfileKey& key, double value) {
    fjell::Profile profile;
    key.set(profile, value);
    return profile.light;
}

} // namespace

TEST_CASE("the sun stands where published positions have it, to a tenth of a degree") {
    struct Published {
        LightSettings light;
        double azimuth_deg, elevation_deg; // azimuth below 0: none, at the pole
    };
    const Published published[] = {
        // I. Reda and A. Andreas, Solar Position Algorithm (NREL/TP-560-34302), appendix A.5: without refraction.
        {seen_from(39.742476, -105.1786, 2003, 10, 17, 19 + 30.5 / 60), 194.340241, 39.872046},
        // J. Meeus, example 25.a: the declination, which is the elevation at the pole.
        {seen_from(90, 0, 1992, 10, 13, 0), -1, -7.78507},
        // NOAA's solar calculator, whose elevations have refraction: 0.03 degrees at most.
        {seen_from(-41, 0, 2012, 12, 22, 12), 359.09, 72.44},
        {seen_from(-3, 0, 2012, 12, 22, 12), 180.79, 69.57},
        {seen_from(41, 0, 2012, 12, 22, 12), 180.30, 25.60},
    };
    for (const Published& p : published) {
        const SunPosition at = sun_position(p.light);
        CHECK(at.elevation_deg == Approx(p.elevation_deg).margin(0.1));
        if (p.azimuth_deg >= 0) CHECK(at.azimuth_deg == Approx(p.azimuth_deg).margin(0.1));
        const Vec3 sun = sun_direction(p.light);
        CHECK(length(sun) == Approx(1));
        CHECK(sun.y == Approx(std::sin(at.elevation_deg * 3.14159265358979 / 180)));
    }
    const SunPosition past = sun_position(seen_from(50, 10, 2026, 2, 31, 12)),
                      march = sun_position(seen_from(50, 10, 2026, 3, 3, 12));
    CHECK(past.elevation_deg == march.elevation_deg);
    CHECK(sun_direction({.azimuth_deg = 90, .elevation_deg = 0}).x == Approx(1)); // east
}

TEST_CASE("settings of light out of range are refused with the field's name, and ranges are the profile's") {
    using Catch::StartsWith;
    validate(LightSettings{});
    CHECK_THROWS_WITH(validate(LightSettings{.visibility_km = 0.5}),
                      "LightSettings::visibility_km must be a number from 1 to 280");
    CHECK_THROWS_WITH(validate(LightSettings{.water_level_m = std::nan("")}),
                      StartsWith("LightSettings::water_level_m"));
    CHECK_THROWS_WITH(validate(LightSettings{.air = static_cast<Air>(7)}),
                      "LightSettings::air must be simple or physical");
    int numbers = 0;
    for (const fjell::ProfileKey& key : fjell::profile_keys()) {
        if (std::string(key.table) != "light") continue;
        CAPTURE(key.name);
        CHECK_NOTHROW(validate(with(key, key.least)));
        CHECK_NOTHROW(validate(with(key, key.most)));
        if (key.kind == fjell::KeyKind::choice || key.kind == fjell::KeyKind::flag) continue;
        ++numbers;
        const bool whole = key.kind == fjell::KeyKind::whole;
        const double more = whole ? 1 : 0.01;
        const std::string refusal = std::string("LightSettings::") + key.name + " must";
        CHECK_THROWS_WITH(validate(with(key, key.most + more)), StartsWith(refusal));
        CHECK_THROWS_WITH(validate(with(key, key.least - more)), StartsWith(refusal));
    }
    CHECK(numbers == 12);
}

TEST_CASE("the sky gives no more light than comes, reddens a low sun by the air's mass, and is never negative") {
    Sky sky;
    make_sky(at_elevation(90), 280, sky); // pure air
    const double zenith = -std::log(static_cast<double>(sun_at(sky, 0, 1).g));
    CHECK(zenith == Approx(13.558e-6 * 8000 + 1.881e-6 * 15000).epsilon(0.02)); // Rayleigh and ozone, by hand
    for (const double elevation :
         {30.0, 10.0, 5.0}) { // F. Kasten and A. Young, 1989; scattering and ozone differ a little
        const double mass =
            1 / (std::sin(elevation * 3.14159265 / 180) + 0.50572 * std::pow(elevation + 6.07995, -1.6364));
        CHECK(-std::log(static_cast<double>(sun_at(sky, 0, at_elevation(elevation).y).g)) ==
              Approx(zenith * mass).epsilon(0.08));
    }
    double before = 0;
    for (const double elevation : {-18.0, -4.0, 0.0, 6.0, 30.0, 90.0}) {
        CAPTURE(elevation);
        const Vec3 sun = at_elevation(elevation);
        make_sky(sun, elevation < 10 ? 5 : 160, sky);
        bool good = true;
        for (const float value : sky.radiance) good = good && value >= 0 && value < 10; // NaN is neither
        CHECK(good);
        const SkyLight ground = light_at(sky, 0);
        const double high = std::max(sun.y, 0.0),
                     level = static_cast<double>(luminance(ground.sun)) * high +
                             3.14159 * static_cast<double>(luminance(ground.ambient[0] + ground.ambient[1]));
        CHECK(level > before);
        if (elevation > 5) CHECK(level < high);
        before = level;
        if (elevation > 0) CHECK(ground.sun.b < ground.sun.r * 1.13f); // the film's white: 1.05 / 0.944
        if (elevation == 30) {
            CHECK(ground.zenith.b > 2 * ground.zenith.r);   // blue above,
            CHECK(ground.horizon.b < 2 * ground.horizon.r); // pale below
            CHECK(luminance(ground.horizon) > 2 * luminance(ground.zenith));
        }
    }
}

TEST_CASE("from tens of km up the sky is blue and never purple: pale at the horizon, and almost black overhead") {
    Sky sky;
    make_sky(at_elevation(40), 160, sky);
    const auto at = [&](int slice, int row, int column) {
        const std::size_t first =
            (static_cast<std::size_t>(slice) * sky_rows + static_cast<std::size_t>(row)) * sky_columns;
        const float* const rgb = &sky.radiance[(first + static_cast<std::size_t>(column)) * 3];
        return Rgb{rgb[0], rgb[1], rgb[2]};
    };
    for (int slice = 0; slice < sky_slices; ++slice)
        for (int row = 0; row < sky_rows; ++row)
            for (int column = sky_columns / 3; column < sky_columns; ++column) { // beside the sun and away from it
                const Rgb here = at(slice, row, column);
                CAPTURE(slice, row, column, here.r, here.g, here.b);
                REQUIRE(here.g > here.r); // purple is red and blue
                REQUIRE(here.b > here.g);
            }
    const int top = sky_slices - 1, away = sky_columns - 1;
    CHECK(luminance(at(top, 1, away)) > 0.8f * luminance(at(1, 1, away)));
    CHECK(luminance(at(top, sky_rows - 1, away)) < 0.1f * luminance(at(0, sky_rows - 1, away)));
}

TEST_CASE("noise repeats without a seam and fades to its mean") {
    const std::vector<std::uint8_t> texels = make_noise();
    std::size_t texel_count = 0;
    for (int mip = 0; mip < noise_mips; ++mip) texel_count += std::size_t{1} << 2 * (8 - mip);
    REQUIRE(texels.size() == 4 * texel_count);
    const auto height = [&](int x, int y) {
        return static_cast<int>(texels[static_cast<std::size_t>((y * 256 + x) * 4 + 2)]);
    };
    int inside = 0, across = 0;
    for (int i = 0; i < 256; ++i)
        for (int j = 0; j < 255; ++j) {
            inside = std::max(
                {inside, std::abs(height(j, i) - height(j + 1, i)), std::abs(height(i, j) - height(i, j + 1))});
            across =
                std::max({across, std::abs(height(255, i) - height(0, i)), std::abs(height(i, 255) - height(i, 0))});
        }
    CHECK(inside > 8);
    CHECK(across <= inside);
    const auto range = [&](std::size_t first, std::size_t count) { // of heights
        int least = 255, most = 0;
        for (std::size_t i = first; i < first + count; ++i) {
            least = std::min<int>(least, texels[4 * i + 2]);
            most = std::max<int>(most, texels[4 * i + 2]);
        }
        return most - least;
    };
    CHECK(range(0, 256 * 256) > 100);
    CHECK(range(texel_count - 16, 16) < range(0, 256 * 256) / 8);
}
