#include "gl/noise.h"

#include <algorithm>
#include <cmath>

namespace fjell::gl {
namespace {

std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t octave) {
    std::uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ octave * 0xc2b2ae3du;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return h ^ h >> 15;
}

// Gradient noise (K. Perlin, Improving Noise, 2002) that repeats after `cells`, about -0.7 to 0.7.
float gradient_noise(float x, float y, std::uint32_t cells, std::uint32_t octave) {
    const auto i = static_cast<std::uint32_t>(x), j = static_cast<std::uint32_t>(y);
    const float u = x - static_cast<float>(i), v = y - static_cast<float>(j);
    const auto corner = [&](std::uint32_t di, std::uint32_t dj) {
        const std::uint32_t h = hash((i + di) % cells, (j + dj) % cells, octave);
        const float gx = static_cast<float>(h & 0xffff) / 32767.5f - 1, gy = static_cast<float>(h >> 16) / 32767.5f - 1;
        return gx * (u - static_cast<float>(di)) + gy * (v - static_cast<float>(dj));
    };
    const auto ease = [](float t) { return t * t * t * (t * (t * 6 - 15) + 10); };
    const float a = ease(u), b = ease(v);
    return (corner(0, 0) * (1 - a) + corner(1, 0) * a) * (1 - b) + (corner(0, 1) * (1 - a) + corner(1, 1) * a) * b;
}

std::uint8_t code(float value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255));
}

} // namespace

std::vector<std::uint8_t> make_noise() {
    constexpr int n = noise_side;
    std::vector<float> soft(std::size_t{n} * n), ridged(soft.size()), relief(soft.size());
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const auto at = static_cast<std::size_t>(y * n + x);
            constexpr float shares[] = {0.75f, 0.75f, 0.55f, 0.4f, 0.3f}; // little of the first, whose cells would show
            // Of slopes the finest would be the steepest, and look like fur.
            constexpr float lumps[] = {1.0f, 0.8f, 0.5f, 0.26f, 0.13f};
            for (std::uint32_t cells = 8, octave = 0; cells <= 128; cells *= 2, ++octave) {
                const float share = shares[octave];
                const float scale = static_cast<float>(cells) / n;
                const float h = gradient_noise((static_cast<float>(x) + 0.5f) * scale,
                                               (static_cast<float>(y) + 0.5f) * scale, cells, octave);
                soft[at] += share * h;
                ridged[at] += share * (0.25f - std::abs(h));
                relief[at] += lumps[octave] * (0.5f * h - 0.5f * (0.25f - std::abs(h)));
            }
        }
    std::vector<std::uint8_t> texels;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const auto height = [&](int dx, int dy) {
                return relief[static_cast<std::size_t>(((y + dy + n) % n) * n + (x + dx + n) % n)];
            };
            const auto at = static_cast<std::size_t>(y * n + x);
            texels.push_back(code(0.5f + 4 * 0.25f * (height(1, 0) - height(-1, 0))));
            texels.push_back(code(0.5f + 4 * 0.25f * (height(0, 1) - height(0, -1))));
            texels.push_back(code(0.5f + 0.6f * soft[at]));
            texels.push_back(code(0.5f + 0.6f * ridged[at]));
        }
    std::size_t first = 0;
    for (int side = n / 2; side >= n >> (noise_mips - 1); side /= 2) {
        const std::size_t above = first;
        first = texels.size();
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
                for (std::size_t c = 0; c < 4; ++c) {
                    const std::size_t row = std::size_t{8} * static_cast<std::size_t>(side);
                    const std::size_t at = above + std::size_t{2} * static_cast<std::size_t>(y) * row +
                                           std::size_t{8} * static_cast<std::size_t>(x) + c;
                    texels.push_back(static_cast<std::uint8_t>(
                        (texels[at] + texels[at + 4] + texels[at + row] + texels[at + row + 4] + 2) / 4));
                }
    }
    return texels;
}

} // namespace fjell::gl
