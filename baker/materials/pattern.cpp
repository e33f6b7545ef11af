#include "baker/materials/pattern.h"

#include <algorithm>
#include <cmath>

namespace fjell::baker {

namespace {

int whole_part(float v) {
    const auto i = static_cast<int>(v);
    return i - (v < static_cast<float>(i) ? 1 : 0);
}

std::uint32_t wrapped(int i, int cells) {
    const int rest = i % cells;
    return static_cast<std::uint32_t>(rest < 0 ? rest + cells : rest);
}

float ease(float t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}

// -1 to 1, about -0.7 to 0.7.
float gradient_noise(float x, float y, int nx, int ny, std::uint32_t seed) {
    const int i = whole_part(x), j = whole_part(y);
    const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
    const auto corner = [&](int di, int dj) {
        const std::uint32_t h = mix_bits(wrapped(i + di, nx), wrapped(j + dj, ny), seed);
        const float gx = static_cast<float>(h & 0xffff) / 32767.5f - 1, gy = static_cast<float>(h >> 16) / 32767.5f - 1;
        return gx * (fx - static_cast<float>(di)) + gy * (fy - static_cast<float>(dj));
    };
    const float a = ease(fx), b = ease(fy);
    return (corner(0, 0) * (1 - a) + corner(1, 0) * a) * (1 - b) + (corner(0, 1) * (1 - a) + corner(1, 1) * a) * b;
}

} // namespace

float fraction(float v) {
    return v - static_cast<float>(whole_part(v));
}

float smooth_step(float from, float to, float v) {
    const float t = std::clamp((v - from) / (to - from), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

float noise_at(const NoiseShape& shape, float u, float v) {
    float sum = 0, weight = 1, total = 0;
    int nx = shape.cells[0], ny = shape.cells[1];
    for (int octave = 0; octave < shape.octaves; ++octave, nx *= 2, ny *= 2, weight *= shape.gain) {
        const float n = 1.5f * gradient_noise(u * static_cast<float>(nx), v * static_cast<float>(ny), nx, ny,
                                              shape.seed + 31u * static_cast<std::uint32_t>(octave));
        const float away = std::min(std::abs(n), 1.0f);
        switch (shape.form) {
        case NoiseForm::soft: sum += weight * n; break;
        case NoiseForm::ridged: sum += weight * (1 - away) * (1 - away); break;
        case NoiseForm::billow: sum += weight * away; break;
        }
        total += weight;
    }
    const float mean = sum / total;
    return std::clamp(shape.form == NoiseForm::soft ? 0.5f + 0.75f * mean : mean, 0.0f, 1.0f);
}

NearPoints near_points(const int (&cells)[2], float jitter, std::uint32_t seed, float u, float v) {
    const float x = u * static_cast<float>(cells[0]), y = v * static_cast<float>(cells[1]);
    const int i = whole_part(x), j = whole_part(y);
    NearPoints near{8, 8, 0};
    for (int dj = -1; dj <= 1; ++dj)
        for (int di = -1; di <= 1; ++di) {
            const std::uint32_t h = mix_bits(wrapped(i + di, cells[0]), wrapped(j + dj, cells[1]), seed);
            const float px =
                static_cast<float>(i + di) + 0.5f + jitter * (static_cast<float>(h & 0xffff) / 65536 - 0.5f);
            const float py = static_cast<float>(j + dj) + 0.5f + jitter * (static_cast<float>(h >> 16) / 65536 - 0.5f);
            const float away = (px - x) * (px - x) + (py - y) * (py - y);
            if (away < near.first) {
                near.second = near.first;
                near.first = away;
                near.value = unit_of(mix_bits(h, 7, seed));
            } else {
                near.second = std::min(near.second, away);
            }
        }
    near.first = std::sqrt(near.first);
    near.second = std::sqrt(near.second);
    return near;
}

} // namespace fjell::baker
