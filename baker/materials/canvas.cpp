#include "baker/materials/canvas.h"

#include <algorithm>
#include <cmath>

namespace fjell::baker {

namespace {

// Displaced by noise, so that nothing follows the grid.
void warp(const MaterialStep& step, std::uint32_t seed, float& u, float& v) {
    if (step.warp <= 0) return;
    const NoiseShape bend{NoiseForm::soft, {step.warp_cells, step.warp_cells}, 4, 0.5f, seed};
    NoiseShape other = bend;
    other.seed += 977;
    const float du = noise_at(bend, u, v) - 0.5f, dv = noise_at(other, u, v) - 0.5f;
    u += step.warp * du;
    v += step.warp * dv;
}

// 0 to 1, before it is stretched.
float value_of(const MaterialStep& step, std::uint32_t seed, float u, float v) {
    NoiseShape shape = step.noise;
    shape.seed = seed;
    switch (step.draw) {
    case Draw::noise: return noise_at(shape, u, v);
    case Draw::cells: {
        const NearPoints near = near_points(shape.cells, step.jitter, seed, u, v);
        return std::max(1 - near.first * near.first, 0.0f);
    }
    case Draw::plates: return near_points(shape.cells, step.jitter, seed, u, v).value;
    case Draw::cracks: {
        const NearPoints near = near_points(shape.cells, step.jitter, seed, u, v);
        return smooth_step(0, step.width, near.second - near.first);
    }
    case Draw::ripples: {
        // Steep on one side, as wind leaves them.
        const float t = fraction(u * static_cast<float>(shape.cells[0]) + v * static_cast<float>(shape.cells[1] - 1));
        return t < 0.65f ? smooth_step(0, 0.65f, t) : smooth_step(1, 0.65f, t);
    }
    case Draw::stones:
    case Draw::strokes: break;
    }
    return 0;
}

void draw_field(const MaterialStep& step, std::uint32_t seed, Canvas& canvas) {
    const float per = 1 / static_cast<float>(canvas.side), stretch = 1 / (step.high - step.low);
    for (int y = 0; y < canvas.side; ++y)
        for (int x = 0; x < canvas.side; ++x) {
            float u = (static_cast<float>(x) + 0.5f) * per, v = (static_cast<float>(y) + 0.5f) * per;
            warp(step, seed + 500, u, v);
            const float value = std::clamp((value_of(step, seed, u, v) - step.low) * stretch, 0.0f, 1.0f);
            const std::size_t i = canvas.at(x, y);
            canvas.height[i] += step.height * value;
            if (step.opacity <= 0) continue;
            float rgb[3];
            colour_of(step, value, rgb);
            // A single colour covers more where the value is higher.
            const float cover = step.opacity * (step.rgb.size() == 3 ? value : 1);
            for (std::size_t c = 0; c < 3; ++c) canvas.rgb[3 * i + c] += cover * (rgb[c] - canvas.rgb[3 * i + c]);
        }
}

// Running sums along one axis.
void blur_line(const float* from, float* to, int side, std::size_t stride, int radius) {
    const auto at = [&](int i) { return static_cast<std::size_t>((i % side + side) % side) * stride; };
    const float per = 1 / static_cast<float>(2 * radius + 1);
    float sum = 0;
    for (int i = -radius; i <= radius; ++i) sum += from[at(i)];
    for (int i = 0; i < side; ++i) {
        to[at(i)] = sum * per;
        sum += from[at(i + radius + 1)] - from[at(i - radius)];
    }
}

} // namespace

void colour_of(const MaterialStep& step, float t, float (&rgb)[3]) {
    const std::size_t count = step.rgb.size() / 3;
    const float at = std::clamp(t, 0.0f, 1.0f) * static_cast<float>(count - 1);
    const std::size_t first = std::min(static_cast<std::size_t>(at), count - 1), next = std::min(first + 1, count - 1);
    const float share = at - static_cast<float>(first);
    for (std::size_t c = 0; c < 3; ++c) rgb[c] = step.rgb[3 * first + c] * (1 - share) + step.rgb[3 * next + c] * share;
}

std::vector<float> blurred(const std::vector<float>& from, int side, int channels, int radius) {
    std::vector<float> a = from, b(from.size());
    radius = std::min(radius, (side - 1) / 2);
    const auto n = static_cast<std::size_t>(side), k = static_cast<std::size_t>(channels);
    for (int round = 0; round < 2; ++round) {
        for (std::size_t y = 0; y < n; ++y)
            for (std::size_t c = 0; c < k; ++c) blur_line(&a[y * n * k + c], &b[y * n * k + c], side, k, radius);
        for (std::size_t x = 0; x < n * k; ++x) blur_line(&b[x], &a[x], side, n * k, radius);
    }
    return a;
}

Canvas draw_material(const MaterialRecipe& recipe, int side) {
    Canvas canvas{side, recipe.size_m, {}, {}};
    const auto texels = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    canvas.height.assign(texels, 0.0f);
    canvas.rgb.resize(3 * texels);
    for (std::size_t i = 0; i < 3 * texels; ++i) canvas.rgb[i] = recipe.base[i % 3];
    std::uint32_t seed = mix_bits(recipe.seed, 1, 1);
    for (const MaterialStep& step : recipe.steps) {
        seed += 0x9e3779b1u;
        if (step.draw == Draw::stones)
            draw_stones(step, seed, canvas);
        else if (step.draw == Draw::strokes)
            draw_strokes(step, seed, canvas);
        else
            draw_field(step, seed, canvas);
    }
    return canvas;
}

} // namespace fjell::baker
