#include "gl/lighting.h"

#include <algorithm>
#include <cmath>

#include <epoxy/gl.h>

#include "gl/noise.h"

namespace fjell::gl {

namespace {

Texture make_sky_map() {
    unsigned name = 0;
    // An array and not 3-D: Mesa 22's software driver crashes where 3-D textures stand beside indexed arrays of
    // samplers.
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
    glTextureStorage3D(name, 1, GL_RGB16F, sky_columns, sky_rows, sky_slices);
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    for (const GLenum axis : {GLenum{GL_TEXTURE_WRAP_S}, GLenum{GL_TEXTURE_WRAP_T}})
        glTextureParameteri(name, axis, GL_CLAMP_TO_EDGE);
    return Texture(name);
}

Texture make_noise_map() {
    unsigned name = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &name);
    glTextureStorage2D(name, noise_mips, GL_RGBA8, noise_side, noise_side);
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    const std::vector<std::uint8_t> texels = make_noise();
    const std::uint8_t* from = texels.data();
    for (GLint mip = 0; mip < noise_mips; ++mip) {
        const GLsizei side = noise_side >> mip;
        glTextureSubImage2D(name, mip, 0, 0, side, side, GL_RGBA, GL_UNSIGNED_BYTE, from);
        from += 4 * side * side;
    }
    return Texture(name);
}

} // namespace

unsigned Lighting::variant(const LightSettings& light) {
    if (units == 0) glGetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &units);
    if (units <= static_cast<int>(noise_unit)) return 0;
    return (light.air == Air::physical ? light_air : 0) | (light.detail ? light_detail : 0) |
           (light.water ? light_water : 0);
}

void Lighting::follow(const LightSettings& light, unsigned bits) {
    validate(light);
    const Vec3 now = sun_direction(light);
    if (visibility_km != light.visibility_km || now.x != sun.x || now.y != sun.y || now.z != sun.z) {
        make_sky(now, light.visibility_km, sky);
        sun = now;
        visibility_km = light.visibility_km;
        in_map = false;
    }
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    if ((bits & light_air) != 0 && !in_map) {
        if (sky_map.get() == 0) sky_map = make_sky_map();
        glTextureSubImage3D(sky_map.get(), 0, 0, 0, 0, sky_columns, sky_rows, sky_slices, GL_RGB, GL_FLOAT,
                            sky.radiance.data());
        in_map = true;
    }
    if ((bits & (light_detail | light_water | light_layers)) != 0 && noise_map.get() == 0) noise_map = make_noise_map();
}

void Lighting::bind() const {
    if (units <= static_cast<int>(noise_unit)) return;
    glBindTextureUnit(sky_unit, sky_map.get());
    glBindTextureUnit(noise_unit, noise_map.get());
    glBindSampler(sky_unit, 0);
    glBindSampler(noise_unit, 0);
}

namespace {

constexpr float pi_f = 3.14159265f;
constexpr float ground_m = 6'360'000, top_m = 6'460'000; // radii: of the planet, and of its air
constexpr int depth_columns = 64, depth_rows = 32, scatter_columns = 12, scatter_rows = 8;
constexpr float ground_albedo = 0.2f;
// Table 1, 1/m.
constexpr Rgb rayleigh_m{5.802e-6f, 13.558e-6f, 33.1e-6f}, ozone_m{0.650e-6f, 1.881e-6f, 0.085e-6f};
constexpr float mie_albedo = 0.9f;
// Daylight film: level ground under a sun at 40 degrees in clear air is neutral.
constexpr Rgb sun_colour{0.944f, 1, 1.05f};

Rgb exp_of(Rgb x) {
    return {std::exp(x.r), std::exp(x.g), std::exp(x.b)};
}

// What a metre of air scatters and takes away.
struct Medium {
    Rgb rayleigh, extinction;
    float mie = 0;
};
Medium medium_at(const Sky& sky, float altitude_m) {
    const float high = std::max(altitude_m, 0.0f);
    const float ozone = std::max(1 - std::abs(high - 25000) / 15000, 0.0f);
    const Rgb rayleigh = sky.rayleigh * std::exp(-high / rayleigh_height_m);
    const Rgb mie = sky.mie * std::exp(-high / mie_height_m);
    return {rayleigh, rayleigh + mie + ozone_m * ozone, mie.g * mie_albedo};
}

float to_top(float r, float mu) {
    return -r * mu + std::sqrt(std::max(r * r * (mu * mu - 1) + top_m * top_m, 0.0f));
}
// The ground in the way, a degree wide, so that dusk comes smoothly.
float above_horizon(float r, float mu) {
    const float edge = -std::sqrt(std::max(1 - ground_m * ground_m / (r * r), 0.0f));
    return std::clamp((mu - edge) / 0.0175f + 0.5f, 0.0f, 1.0f);
}

float lerp_at(float x, int count, int& first) {
    const float at = std::clamp(x, 0.0f, 1.0f) * static_cast<float>(count - 1);
    first = std::min(static_cast<int>(at), count - 2);
    return at - static_cast<float>(first);
}
Rgb bilinear(const std::vector<Rgb>& table, int columns, int rows, float x, float y) {
    int i = 0, j = 0;
    const float u = lerp_at(x, columns, i), v = lerp_at(y, rows, j);
    const Rgb* const at = &table[static_cast<std::size_t>(j * columns + i)];
    return (at[0] * (1 - u) + at[1] * u) * (1 - v) + (at[columns] * (1 - u) + at[columns + 1] * u) * v;
}

// Bruneton's mapping: the share of the way to the top of the air between the shortest and the longest there is.
constexpr float longest_m = 1'132'254; // sqrt(top_m^2 - ground_m^2)
Rgb transmittance(const Sky& sky, float r, float mu) {
    const float level = std::sqrt(std::max(r * r - ground_m * ground_m, 0.0f)), least = top_m - r;
    const float x = (to_top(r, mu) - least) / (level + longest_m - least);
    return bilinear(sky.transmittance, depth_columns, depth_rows, x, level / longest_m);
}

void fill_transmittance(Sky& sky) {
    sky.transmittance.resize(depth_columns * depth_rows);
    for (int j = 0; j < depth_rows; ++j)
        for (int i = 0; i < depth_columns; ++i) {
            const float level = longest_m * static_cast<float>(j) / (depth_rows - 1);
            const float r = std::max(std::sqrt(level * level + ground_m * ground_m), ground_m + 1);
            const float least = top_m - r;
            const float d = least + (level + longest_m - least) * static_cast<float>(i) / (depth_columns - 1);
            const float mu =
                d <= 0 ? 1 : std::clamp((longest_m * longest_m - level * level - d * d) / (2 * r * d), -1.0f, 1.0f);
            constexpr int steps = 32;
            Rgb depth;
            for (int k = 0; k < steps; ++k) { // denser near the beginning, where the air is
                const float a = static_cast<float>(k) / steps, b = static_cast<float>(k + 1) / steps;
                const float t = d * 0.25f * (a + b) * (a + b), along = d * (b * b - a * a);
                const float altitude = std::sqrt(r * r + t * t + 2 * r * mu * t) - ground_m;
                depth = depth + medium_at(sky, altitude).extinction * along;
            }
            sky.transmittance[static_cast<std::size_t>(j * depth_columns + i)] = exp_of(depth * -1);
        }
}

Rgb multiple(const Sky& sky, float altitude_m, float sun_mu) {
    return bilinear(sky.scattered, scatter_columns, scatter_rows, 0.5f + 0.5f * sun_mu,
                    std::sqrt(altitude_m / 100'000));
}

// Light that a ray gathers, by how it was scattered last and without phase functions; and what is left of light from
// its end.
struct Gathered {
    Rgb rayleigh, mie, multiple, left{1, 1, 1};
};
Gathered march(const Sky& sky, float r, float mu, float cos_sun, float sun_mu, float d, int steps, bool to_eye) {
    Gathered sum;
    for (int k = 0; k < steps; ++k) {
        const float a = static_cast<float>(k) / static_cast<float>(steps);
        const float b = static_cast<float>(k + 1) / static_cast<float>(steps);
        const float t = d * 0.25f * (a + b) * (a + b), along = d * (b * b - a * a);
        const float here = std::max(std::sqrt(r * r + t * t + 2 * r * mu * t), ground_m);
        const float sun_here = (r * sun_mu + t * cos_sun) / here;
        Medium air = medium_at(sky, here - ground_m);
        // Ozone colours the sun's way through the air. Before the eye it would colour level rays from tens of km up,
        // which the picture shows far above its horizon: purple.
        if (to_eye) air.extinction = air.rayleigh + sky.mie * (air.mie / std::max(sky.mie.g * mie_albedo, 1e-12f));
        const Rgb through = exp_of(air.extinction * -along);
        const Rgb share{(1 - through.r) / air.extinction.r, (1 - through.g) / air.extinction.g,
                        (1 - through.b) / air.extinction.b};
        const Rgb arriving = sum.left * share;
        const Rgb sunlight = sun_colour * transmittance(sky, here, sun_here) * above_horizon(here, sun_here);
        sum.rayleigh = sum.rayleigh + arriving * air.rayleigh * sunlight;
        sum.mie = sum.mie + arriving * sunlight * air.mie;
        if (to_eye)
            sum.multiple = sum.multiple + arriving * (air.rayleigh + Rgb{air.mie, air.mie, air.mie}) *
                                              multiple(sky, here - ground_m, sun_here);
        sum.left = sum.left * through;
    }
    return sum;
}

// Section 5.5: light that has been scattered twice, and the share that is scattered on, make a geometric series.
void fill_multiple(Sky& sky) {
    sky.scattered.resize(scatter_columns * scatter_rows);
    constexpr int heights = 8, turns = 4;
    for (int j = 0; j < scatter_rows; ++j)
        for (int i = 0; i < scatter_columns; ++i) {
            const float share = static_cast<float>(j) / (scatter_rows - 1);
            const float r = ground_m + std::max(100'000 * share * share, 1.0f);
            const float sun_mu = 2 * static_cast<float>(i) / (scatter_columns - 1) - 1;
            const float sun_level = std::sqrt(std::max(1 - sun_mu * sun_mu, 0.0f));
            Rgb second, again;
            for (int k = 0; k < heights * turns; ++k) {
                const float mu = 2 * (static_cast<float>(k / turns) + 0.5f) / heights - 1;
                const float turned = pi_f * (static_cast<float>(k % turns) + 0.5f) / turns;
                const float cos_sun = mu * sun_mu + std::sqrt(1 - mu * mu) * sun_level * std::cos(turned);
                const float below = r * r * (mu * mu - 1) + ground_m * ground_m;
                const bool lands = mu < 0 && below > 0;
                const float d = lands ? -r * mu - std::sqrt(below) : to_top(r, mu);
                const Gathered light = march(sky, r, mu, cos_sun, sun_mu, d, 12, false);
                second = second + (light.rayleigh + light.mie) * (1 / (4 * pi_f));
                again = again + (Rgb{1, 1, 1} - light.left); // all extinction as scattering: ozone and soot take little
                if (!lands) continue;
                const float sun_there = (r * sun_mu + d * cos_sun) / ground_m;
                second = second + light.left * sun_colour * transmittance(sky, ground_m, sun_there) *
                                      above_horizon(ground_m, sun_there) *
                                      (std::max(sun_there, 0.0f) * ground_albedo / pi_f);
            }
            constexpr float n = 1.0f / (heights * turns);
            const auto series = [](float light, float on) { return light / (1 - std::min(0.95f * on, 0.9f)); };
            sky.scattered[static_cast<std::size_t>(j * scatter_columns + i)] = {series(second.r * n, again.r * n),
                                                                                series(second.g * n, again.g * n),
                                                                                series(second.b * n, again.b * n)};
        }
}

float rayleigh_phase(float cos_sun) {
    return 3 / (16 * pi_f) * (1 + cos_sun * cos_sun);
}
float mie_phase(float cos_sun) { // Cornette and Shanks
    constexpr float g = mie_asymmetry;
    const float base = 1 + g * g - 2 * g * cos_sun;
    return 3 / (8 * pi_f) * (1 - g * g) * (1 + cos_sun * cos_sun) / ((2 + g * g) * base * std::sqrt(base));
}
Rgb radiance_of(const Gathered& light, float cos_sun) {
    return light.rayleigh * rayleigh_phase(cos_sun) + light.mie * mie_phase(cos_sun) + light.multiple;
}

float column_angle(float column) {
    return 2 * std::asin(std::clamp(column / (sky_columns - 1), 0.0f, 1.0f));
}

// The picture's ground is flat, so its horizon is level; the planet's lies lower, the more the higher the eye is. The
// picture's sky is the one above the planet's horizon, pulled down to the level: from far up a level ray meets hardly
// more than ozone, and a horizon of its colour was purple. Sine of the elevation there by that in the picture.
float true_sine(float r, float y) {
    const float dip = std::sqrt(std::max(1 - ground_m * ground_m / (r * r), 0.0f));
    return y * (1 + dip) - dip;
}

// One altitude of the sky view, and the sums over it.
void fill_slice(Sky& sky, int slice, float sun_y) {
    SkyLight& light = sky.light[static_cast<std::size_t>(slice)];
    const float share = static_cast<float>(slice) / (sky_slices - 1);
    const float altitude = std::max(static_cast<float>(sky_top_m) * share * share, 1.0f), r = ground_m + altitude;
    const float sun_level = std::sqrt(std::max(1 - sun_y * sun_y, 0.0f));
    light = {};
    light.sun = sun_at(sky, static_cast<double>(altitude), static_cast<double>(sun_y));
    float* out = &sky.radiance[static_cast<std::size_t>(slice * sky_rows * sky_columns * 3)];
    Rgb falling;
    for (int row = 0; row < sky_rows; ++row) {
        const float v = static_cast<float>(row) / (sky_rows - 1), y = std::max(v * v, 1e-4f);
        const float level = std::sqrt(std::max(1 - y * y, 0.0f));
        const float mu = true_sine(r, y), true_level = std::sqrt(std::max(1 - mu * mu, 0.0f)), d = to_top(r, mu);
        const float low = std::max(v - 0.5f / (sky_rows - 1), 0.0f), high = std::min(v + 0.5f / (sky_rows - 1), 1.0f);
        for (int column = 0; column < sky_columns; ++column) {
            const auto at = static_cast<float>(column);
            const float turned = std::cos(column_angle(at)), towards = turned * level;
            const float true_cos_sun = mu * sun_y + turned * true_level * sun_level;
            const Rgb here = radiance_of(march(sky, r, mu, true_cos_sun, sun_y, d, 24, true),
                                         y * sun_y + towards * sun_level); // around the sun that is drawn
            *out++ = here.r, *out++ = here.g, *out++ = here.b;
            // Both sides of the sun's azimuth.
            const float angle = 2 * (high * high - low * low) * (column_angle(at + 0.5f) - column_angle(at - 0.5f));
            light.ambient[0] = light.ambient[0] + here * (angle / (4 * pi_f));
            light.ambient[1] = light.ambient[1] + here * (angle * y / (2 * pi_f));
            light.ambient[2] = light.ambient[2] + here * (angle * towards / (2 * pi_f));
            falling = falling + here * (angle * y);
            if (row == 1 && column >= sky_columns / 2)
                light.horizon = light.horizon + here * (2.0f / static_cast<float>(sky_columns));
            if (row == sky_rows - 1 && column == 0) light.zenith = here;
        }
    }
    const Rgb bounce = (falling + light.sun * std::max(sun_y, 0.0f)) * (ground_albedo / pi_f);
    light.ambient[0] = light.ambient[0] + bounce * 0.5f;
    light.ambient[1] = light.ambient[1] - bounce * 0.5f;
}

void fill_source(const Sky& sky, int slice, float sun_y, SkyLight& light) {
    const float share = static_cast<float>(slice) / (sky_slices - 1);
    const float r = ground_m + std::max(static_cast<float>(sky_top_m) * share * share, 1.0f);
    const float y = true_sine(r, 0.005f);
    const float sun_level = std::sqrt(std::max(1 - sun_y * sun_y, 0.0f));
    Gathered ray[3]; // towards the sun's azimuth, across, away
    for (int i = 0; i < 3; ++i)
        ray[i] = march(sky, r, y, y * sun_y + static_cast<float>(1 - i) * sun_level, sun_y, to_top(r, y), 28, true);
    const auto mean = [&](Rgb Gathered::*of) { return (ray[0].*of + ray[1].*of * 2 + ray[2].*of) * 0.25f; };
    const auto lean = [&](Rgb Gathered::*of) { // never more than the mean: nothing gets negative
        const Rgb m = mean(of), d = (ray[0].*of - ray[2].*of) * 0.5f;
        return Rgb{std::clamp(d.r, -m.r, m.r), std::clamp(d.g, -m.g, m.g), std::clamp(d.b, -m.b, m.b)};
    };
    light.source = {mean(&Gathered::rayleigh), mean(&Gathered::mie), mean(&Gathered::multiple),
                    lean(&Gathered::rayleigh), lean(&Gathered::mie)};
}

} // namespace

Rgb sun_at(const Sky& sky, double altitude_m, double sun_y) {
    const float r = ground_m + static_cast<float>(std::clamp(altitude_m, 1.0, 60'000.0));
    const auto mu = static_cast<float>(sun_y);
    return sun_colour * transmittance(sky, r, std::max(mu, -std::sqrt(1 - ground_m * ground_m / (r * r)))) *
           above_horizon(r, mu);
}

void make_sky(Vec3 sun, double visibility_km, Sky& sky) {
    sky.rayleigh = rayleigh_m;
    // Koschmieder: contrast falls to 2% (3.912 = -ln 0.02) over the visibility, in green light.
    const float mie = std::max(3.912f / static_cast<float>(visibility_km * 1000) - rayleigh_m.g, 1e-8f);
    sky.mie = {mie, mie, mie};
    sky.radiance.resize(std::size_t{3} * sky_columns * sky_rows * sky_slices);
    fill_transmittance(sky);
    fill_multiple(sky);
    const auto sun_y = static_cast<float>(sun.y);
    for (int slice = 0; slice < sky_slices; ++slice) {
        fill_slice(sky, slice, sun_y);
        fill_source(sky, slice, sun_y, sky.light[static_cast<std::size_t>(slice)]);
    }
}

SkyLight light_at(const Sky& sky, double altitude_m) {
    int first = 0;
    const float share =
        lerp_at(static_cast<float>(std::sqrt(std::clamp(altitude_m / sky_top_m, 0.0, 1.0))), sky_slices, first);
    const SkyLight &a = sky.light[static_cast<std::size_t>(first)], &b = sky.light[static_cast<std::size_t>(first) + 1];
    const auto mix = [&](Rgb x, Rgb y) { return x * (1 - share) + y * share; };
    SkyLight light;
    light.sun = mix(a.sun, b.sun);
    for (std::size_t i = 0; i < light.ambient.size(); ++i) light.ambient[i] = mix(a.ambient[i], b.ambient[i]);
    for (std::size_t i = 0; i < light.source.size(); ++i) light.source[i] = mix(a.source[i], b.source[i]);
    light.zenith = mix(a.zenith, b.zenith);
    light.horizon = mix(a.horizon, b.horizon);
    return light;
}

} // namespace fjell::gl
