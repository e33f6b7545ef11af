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

// Stones and strokes: single things that lie on what is there, and on each other.

namespace {

// Numbers of one element, one after the other.
class Dice {
public:
    Dice(std::uint32_t element, std::uint32_t seed) : element_(element), seed_(seed) {}
    float roll() { return unit_of(mix_bits(element_, count_++, seed_)); }
    float roll(float from, float to) { return from + (to - from) * roll(); }
    // A unit vector without sines, which differ between machines.
    void direction(float& x, float& y) {
        for (int i = 0; i < 16; ++i) {
            x = roll(-1, 1), y = roll(-1, 1);
            const float squared = x * x + y * y;
            if (squared > 1 || squared < 0.01f) continue;
            const float per = 1 / std::sqrt(squared);
            x *= per, y *= per;
            return;
        }
        x = 1, y = 0;
    }

private:
    std::uint32_t element_, seed_, count_ = 0;
};

// Where the next element stands; false: where clumps leave the ground bare.
bool place(const MaterialStep& step, std::uint32_t seed, Dice& dice, float& u, float& v) {
    u = dice.roll(), v = dice.roll();
    if (step.clump <= 0) return true;
    NoiseShape shape = step.noise;
    shape.seed = seed + 77;
    return noise_at(shape, u, v) + dice.roll(-0.08f, 0.08f) > 0.35f + 0.25f * step.clump;
}

// Most are small, as what breaks is.
float pick_size(const MaterialStep& step, Dice& dice) {
    const float t = dice.roll();
    return step.size[0] + (step.size[1] - step.size[0]) * t * t * t;
}

constexpr int max_faces = 9;

struct Stone {
    float radius = 0, tall = 0, tilt[2] = {0, 0}, axis[2] = {1, 0}, stretch = 1;
    int faces = 0;
    float face[max_faces][4]; // direction, where it begins, how steep it is
    float angular = 0;

    // Height over its lowest, in radii; below 0: beside it. x, y: from the middle, in radii.
    [[nodiscard]] float top(float x, float y) const {
        const float p = (x * axis[0] + y * axis[1]) / stretch, q = (y * axis[0] - x * axis[1]) * stretch;
        const float round = 1 - (p * p + q * q);
        float flat = tall + tilt[0] * p + tilt[1] * q;
        for (int i = 0; i < faces; ++i)
            flat = std::min(flat, face[i][3] * (face[i][2] - p * face[i][0] - q * face[i][1]));
        const float smooth = round > 0 ? tall * std::sqrt(round) : round;
        return angular * flat + (1 - angular) * smooth;
    }
};

Stone make_stone(const MaterialStep& step, Dice& dice) {
    Stone s;
    s.radius = pick_size(step, dice);
    s.angular = step.angular;
    s.tall = dice.roll(0.45f, 0.8f);
    dice.direction(s.axis[0], s.axis[1]);
    s.stretch = dice.roll(1.0f, 1.35f);
    for (float& t : s.tilt) t = dice.roll(-0.45f, 0.45f);
    s.faces = 5 + static_cast<int>(dice.roll() * 4.99f);
    for (int i = 0; i < s.faces; ++i) {
        dice.direction(s.face[i][0], s.face[i][1]);
        s.face[i][2] = dice.roll(0.6f, 0.95f);
        s.face[i][3] = dice.roll(0.6f, 1.7f);
    }
    return s;
}

void lay_stone(const MaterialStep& step, const Stone& stone, float u, float v, Dice& dice, Canvas& canvas) {
    const auto side = static_cast<float>(canvas.side);
    const float cx = u * side, cy = v * side, radius = stone.radius * side;
    const int reach = static_cast<int>(1.4f * radius) + 1, x0 = static_cast<int>(cx), y0 = static_cast<int>(cy);
    const float metres = stone.radius * canvas.size_m;
    const float ground = canvas.height[canvas.at(x0, y0)] - step.sink * stone.tall * metres;
    float rgb[3];
    colour_of(step, dice.roll(), rgb);
    const float shade = dice.roll(0.82f, 1.12f);
    for (int y = std::max(y0 - reach, y0 - canvas.side); y <= y0 + reach; ++y)
        for (int x = std::max(x0 - reach, x0 - canvas.side); x <= x0 + reach; ++x) {
            const float top =
                stone.top((static_cast<float>(x) + 0.5f - cx) / radius, (static_cast<float>(y) + 0.5f - cy) / radius);
            const std::size_t i = canvas.at(x, y);
            const float height = ground + top * metres;
            if (top <= 0 || height <= canvas.height[i]) continue;
            canvas.height[i] = height;
            const float grain = 0.9f + 0.2f * unit_of(mix_bits(static_cast<std::uint32_t>(i), 3, 5));
            for (std::size_t c = 0; c < 3; ++c)
                canvas.rgb[3 * i + c] += step.opacity * (rgb[c] * shade * grain - canvas.rgb[3 * i + c]);
        }
}

struct Stroke {
    float x = 0, y = 0, dx = 0, dy = 0, turn = 0; // texels; a unit vector; how it turns on its way
    float length = 0, half_width = 0;             // texels
    float foot = 0, rise = 0;                     // metres
    float rgb[3] = {};
};

float width_at(float t, float leaf) {
    const float blade = 1 - t * t, oval = 4 * t * (1 - t);
    return blade + leaf * (oval - blade);
}

void lay_stroke(const MaterialStep& step, Stroke s, Canvas& canvas) {
    const int parts = std::max(static_cast<int>(s.length / 0.6f), 2);
    const float part = s.length / static_cast<float>(parts), turn = s.turn / static_cast<float>(parts);
    for (int k = 0; k < parts; ++k) {
        const float t = (static_cast<float>(k) + 0.5f) / static_cast<float>(parts);
        s.x += s.dx * part, s.y += s.dy * part;
        const float nx = s.dx - turn * s.dy, ny = s.dy + turn * s.dx, per = 1 / std::sqrt(nx * nx + ny * ny);
        s.dx = nx * per, s.dy = ny * per;
        const float half = s.half_width * width_at(t, step.leaf);
        const float z = s.foot + s.rise * t * (1.4f - 0.4f * t);
        const int across = static_cast<int>(half + 0.5f);
        for (int j = -across; j <= across; ++j) {
            const float off = static_cast<float>(j);
            const int x = static_cast<int>(s.x - off * s.dy + static_cast<float>(canvas.side)) % canvas.side;
            const int y = static_cast<int>(s.y + off * s.dx + static_cast<float>(canvas.side)) % canvas.side;
            const std::size_t i = canvas.at(x, y);
            // A rib in the middle, and round: its sides lie lower.
            const float aside = half > 0 ? off / (half + 0.5f) : 0;
            const float here =
                z - 0.4f * s.half_width * aside * aside * canvas.size_m / static_cast<float>(canvas.side);
            if (here <= canvas.height[i]) continue;
            canvas.height[i] = here;
            const float light = (0.62f + 0.45f * t) * (1 - 0.18f * aside);
            for (std::size_t c = 0; c < 3; ++c)
                canvas.rgb[3 * i + c] += step.opacity * (s.rgb[c] * light - canvas.rgb[3 * i + c]);
        }
    }
}

} // namespace

void draw_stones(const MaterialStep& step, std::uint32_t seed, Canvas& canvas) {
    for (int n = 0; n < step.count; ++n) {
        Dice dice(static_cast<std::uint32_t>(n), seed);
        float u = 0, v = 0;
        if (!place(step, seed, dice, u, v)) continue;
        const Stone stone = make_stone(step, dice);
        lay_stone(step, stone, u, v, dice, canvas);
    }
}

void draw_strokes(const MaterialStep& step, std::uint32_t seed, Canvas& canvas) {
    const auto side = static_cast<float>(canvas.side);
    for (int n = 0; n < step.count; ++n) {
        Dice dice(static_cast<std::uint32_t>(n), seed);
        float u = 0, v = 0;
        if (!place(step, seed, dice, u, v)) continue;
        Stroke s;
        s.x = u * side, s.y = v * side;
        dice.direction(s.dx, s.dy);
        s.length = pick_size(step, dice) * side;
        s.half_width = std::max(0.5f * step.width * side * dice.roll(0.7f, 1.2f), 0.3f);
        s.turn = step.bend * dice.roll(-1, 1);
        // Those that are drawn later stand higher, or the first would hide them.
        s.rise = step.height * dice.roll(0.5f, 1.0f);
        s.foot = canvas.height[canvas.at(static_cast<int>(s.x), static_cast<int>(s.y))] - 0.5f * s.rise;
        colour_of(step, dice.roll(), s.rgb);
        lay_stroke(step, s, canvas);
    }
}

} // namespace fjell::baker
