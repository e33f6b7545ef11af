// Deterministic mountains: a pure function of position in metres, so that every grid size and spacing of one seed shows
// the same landscape, and any row can be made by any thread.
//
// Three layers, from coarse to fine, each steered by the slope of what is there already:
//   massifs   ridged multifractal (Musgrave et al., "The Synthesis and Rendering of Eroded Fractal Terrains", 1989)
//   over
//             a warped domain, under a wider envelope that leaves lowland between the ranges;
//   gullies   waves in jittered cells whose crests run downhill, as water cuts them (sparse convolution noise, Lewis
//             1989, steered by the gradient); every octave sees the slopes the coarser ones left, so valleys branch;
//   detail    gradient noise damped where it is flat already, so that valley floors stay smooth and ridges rough.
// Rejected: a simulation of rivers. It looks better still, but depends on the grid's size and borders.
//
// Only + - * / and sqrt, in double and float without contraction, and integer hashes: same recipe, same bytes, on every
// machine and compiler.
#include "baker/synth/synth.h"
#include "baker/materials/pattern.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/georeference/open_source.h"
#include "baker/read/windows.h"
#include "baker/store/parallel.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::baker {

namespace {

struct LandRecipe {
    std::int32_t columns = 1025, rows = 1025;
    double spacing_m = 60;
    std::uint32_t seed = 1;
    double base_m = 0, relief_m = 3000, feature_m = 24000;
    int octaves = 0; // of detail; 0: down to the samples
    double roughness = 0.5, warp = 0.5, gullies = 0.6, lowland = 0.35;
};

// A value and its gradient.
struct Field {
    float value = 0, dx = 0, dy = 0;
};

std::uint32_t hash(std::int32_t x, std::int32_t y, std::uint32_t salt) {
    return salted_bits(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), salt);
}

// floor() without <cmath>'s dependence on the rounding mode; |v| < 2^31 by the recipe's ranges.
std::int32_t whole(double v) {
    const auto i = static_cast<std::int32_t>(v);
    return i - (v < i ? 1 : 0);
}

// Sixteen directions, evenly spread, none along an axis: axes show.
constexpr std::array<std::array<float, 2>, 16> directions{{{0.98078528f, 0.19509032f},
                                                           {0.83146961f, 0.55557023f},
                                                           {0.55557023f, 0.83146961f},
                                                           {0.19509032f, 0.98078528f},
                                                           {-0.19509032f, 0.98078528f},
                                                           {-0.55557023f, 0.83146961f},
                                                           {-0.83146961f, 0.55557023f},
                                                           {-0.98078528f, 0.19509032f},
                                                           {-0.98078528f, -0.19509032f},
                                                           {-0.83146961f, -0.55557023f},
                                                           {-0.55557023f, -0.83146961f},
                                                           {-0.19509032f, -0.98078528f},
                                                           {0.19509032f, -0.98078528f},
                                                           {0.55557023f, -0.83146961f},
                                                           {0.83146961f, -0.55557023f},
                                                           {0.98078528f, -0.19509032f}}};

// Gradient noise (Perlin 2002), about -1..1, with its derivative by the quintic's own.
Field gradient_noise(double x, double y, std::uint32_t salt) {
    const std::int32_t i = whole(x), j = whole(y);
    const auto fx = static_cast<float>(x - i), fy = static_cast<float>(y - j);
    const auto& a = directions[hash(i, j, salt) >> 28];
    const auto& b = directions[hash(i + 1, j, salt) >> 28];
    const auto& c = directions[hash(i, j + 1, salt) >> 28];
    const auto& d = directions[hash(i + 1, j + 1, salt) >> 28];
    const float va = a[0] * fx + a[1] * fy, vb = b[0] * (fx - 1) + b[1] * fy;
    const float vc = c[0] * fx + c[1] * (fy - 1), vd = d[0] * (fx - 1) + d[1] * (fy - 1);
    const float u = fx * fx * fx * (fx * (fx * 6 - 15) + 10), v = fy * fy * fy * (fy * (fy * 6 - 15) + 10);
    const float du = 30 * fx * fx * (fx * (fx - 2) + 1), dv = 30 * fy * fy * (fy * (fy - 2) + 1);
    const float twist = va - vb - vc + vd;
    const auto mixed = [&](std::size_t k) {
        return a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]) + u * v * (a[k] - b[k] - c[k] + d[k]);
    };
    constexpr float gain = 1.5f; // the plain noise stays within about +-0.7
    return {gain * (va + u * (vb - va) + v * (vc - va) + u * v * twist), gain * (mixed(0) + du * (vb - va + v * twist)),
            gain * (mixed(1) + dv * (vc - va + u * twist))};
}

// cos(2 pi t) by a polynomial, within 1e-4: the library's cosine differs from machine to machine. |t| < 8.
float wave(float t) {
    t -= static_cast<float>(static_cast<std::int32_t>(t + 8.5f) - 8); // -0.5..0.5
    const float a = 1 - 4 * std::fabs(t), a2 = a * a;                 // cos(2 pi t) = sin(pi/2 a)
    return a * (1.5706268f + a2 * (-0.6432292f + a2 * 0.0727102f));
}

// The pivots of the 3 x 3 cells around a sample, from the middle cell's corner. Neighbouring samples mostly share them,
// so a row remembers the last ones of every octave. Twelve, so that the loop over them fills whole SIMD registers; the
// last three are out of reach.
struct GullyCells {
    std::int32_t i = INT32_MIN, j = INT32_MIN;
    std::array<float, 12> x{}, y{};

    void move(std::int32_t to_i, std::int32_t to_j, std::uint32_t salt) {
        if (i == to_i && j == to_j) return;
        i = to_i;
        j = to_j;
        x.fill(4);
        y.fill(4);
        for (std::int32_t k = 0; k < 9; ++k) {
            const std::int32_t di = k % 3 - 1, dj = k / 3 - 1;
            const std::uint32_t h = hash(i + di, j + dj, salt);
            // Within 0.3 of the cell's middle, so that kernels of radius 1.2 never reach past 3 x 3 cells.
            x[static_cast<std::size_t>(k)] =
                static_cast<float>(di) + 0.2f + static_cast<float>(h & 0xffff) * (0.6f / 65536);
            y[static_cast<std::size_t>(k)] =
                static_cast<float>(dj) + 0.2f + static_cast<float>(h >> 16) * (0.6f / 65536);
        }
    }
};

// Waves along `across` (unit length), one phase per jittered cell, blended by compact kernels. The crests of one cell
// are straight; the blend lets them fork and end. value in -1..1; dx, dy: gradient.
Field steered_waves(GullyCells& cells, double x, double y, float across_x, float across_y, std::uint32_t salt) {
    const std::int32_t i = whole(x), j = whole(y);
    cells.move(i, j, salt);
    const auto fx = static_cast<float>(x - i), fy = static_cast<float>(y - j);
    std::array<float, 12> weights, crests, slopes;
    for (std::size_t k = 0; k < 12; ++k) {
        const float rx = fx - cells.x[k], ry = fy - cells.y[k];
        const float reach = 1 - (rx * rx + ry * ry) * (1 / 1.44f);
        const float held = 0.5f * (reach + std::fabs(reach)); // not below 0; a branch would keep the loop scalar
        const float turn = rx * across_x + ry * across_y;
        weights[k] = held * held * held;
        crests[k] = weights[k] * wave(turn);
        slopes[k] = weights[k] * wave(turn + 0.25f); // -sin
    }
    float weight = 0, crest = 0, slope = 0;
    for (std::size_t k = 0; k < 9; ++k) {
        weight += weights[k];
        crest += crests[k];
        slope += slopes[k];
    }
    const float scale = 1 / weight, rise = slope * scale * 6.2831853f;
    return {crest * scale, rise * across_x, rise * across_y};
}

float clamp01(float v) {
    return v < 0 ? 0 : v > 1 ? 1 : v;
}
float smooth(float t) {
    return t * t * (3 - 2 * t);
}

// A landscape in units of one feature (positions) and of the relief (heights, about 0..1).
class Landscape {
public:
    Landscape(const LandRecipe& recipe)
        : seed_(hash(static_cast<std::int32_t>(recipe.seed), 0x5bd1e995, 0x27220A95u)),
          finest_(recipe.feature_m / (2 * recipe.spacing_m)), gain_(static_cast<float>(0.30 + 0.35 * recipe.roughness)),
          warp_(0.45 * recipe.warp), gullies_(static_cast<float>(recipe.gullies)),
          lowland_(static_cast<float>(recipe.lowland)), octaves_(recipe.octaves ? recipe.octaves : 32) {}

    static constexpr std::uint32_t gully_octaves = 5;
    using Row = std::array<GullyCells, gully_octaves>; // what a row of samples remembers

    [[nodiscard]] float height(Row& row, double x, double y) const {
        // Bending the domain turns straight ranges into arcs. Everything after it lives in the bent domain, slopes too.
        const double wx = gradient_noise(x * 0.55, y * 0.55, salt(1)).value;
        const double wy = gradient_noise(x * 0.55, y * 0.55, salt(2)).value;
        x += warp_ * wx;
        y += warp_ * wy;
        Field ground = massifs(x, y);
        carve(ground, row, x, y);
        roughen(ground, x, y);
        return 0.1f + 1.08f * ground.value;
    }

private:
    [[nodiscard]] std::uint32_t salt(std::uint32_t layer) const { return seed_ + layer * 0x632BE5ABu; }
    // How much of an octave the samples can carry: all of it at 4 samples a wave, none at 2.
    [[nodiscard]] float carried(double frequency) const {
        return clamp01(static_cast<float>(2 * finest_ / frequency - 1));
    }

    [[nodiscard]] Field massifs(double x, double y) const;
    void carve(Field& ground, Row& row, double x, double y) const;
    void roughen(Field& ground, double x, double y) const;

    std::uint32_t seed_;
    double finest_; // waves per feature that two samples a wave allow
    float gain_;
    double warp_;
    float gullies_, lowland_;
    int octaves_;
};

Field Landscape::massifs(double x, double y) const {
    // The envelope: where there are ranges at all, and how high.
    const Field wide = gradient_noise(x * 0.31 + 0.37, y * 0.31 + 0.71, salt(3));
    const float shifted = clamp01(0.5f + 0.9f * wide.value + (0.5f - lowland_) * 0.9f);
    const float envelope = smooth(shifted);
    const float envelope_rise = shifted <= 0 || shifted >= 1 ? 0 : 6 * shifted * (1 - shifted) * 0.9f * 0.31f;

    // The first octave's creases are the main ridges; the finer ones only bend them, for creases of their own would
    // cross the slopes as no ridge does.
    const Field main = gradient_noise(x, y, salt(4));
    const float round = std::sqrt(main.value * main.value + 0.03f), ridge = 1.17f - round;
    const float steep = -1.24f * ridge * main.value / round;
    Field sum{0.62f * ridge * ridge, steep * main.dx, steep * main.dy};
    float amplitude = 0.20f;
    double frequency = 1.83;
    for (std::uint32_t k = 0; k < 2; ++k, frequency *= 2.09, amplitude *= 0.42f) {
        const float share = amplitude * carried(frequency);
        if (share == 0) break;
        const Field n = gradient_noise(x * frequency, y * frequency, salt(5 + k));
        sum.value += share * n.value;
        sum.dx += share * static_cast<float>(frequency) * n.dx;
        sum.dy += share * static_cast<float>(frequency) * n.dy;
    }
    // Rivers fill what would lie below their bed: a soft floor, which the lowland shares.
    const float root = std::sqrt(sum.value * sum.value + 0.02f), above = 0.5f * (1 + sum.value / root);
    sum = {0.5f * (sum.value + root), sum.dx * above, sum.dy * above};
    const float floor = 0.06f, lift = floor + (1 - floor) * envelope;
    const float dlift = (1 - floor) * envelope_rise * sum.value;
    return {sum.value * lift, sum.dx * lift + dlift * wide.dx, sum.dy * lift + dlift * wide.dy};
}

void Landscape::carve(Field& ground, Row& row, double x, double y) const {
    if (gullies_ == 0) return;
    double frequency = 2.3;
    float depth = 0.17f * gullies_;
    for (std::uint32_t k = 0; k < gully_octaves; ++k, frequency *= 2.07, depth *= 0.5f) {
        const float share = depth * carried(frequency);
        if (share == 0) break;
        // Crests run along the slope, so the wave travels across it. Flat ground has no direction and gets no wave.
        const float steepness2 = ground.dx * ground.dx + ground.dy * ground.dy;
        if (steepness2 < 1e-12f) continue;
        const float inverse = 1 / std::sqrt(steepness2);
        const Field w = steered_waves(row[k], x * frequency, y * frequency, -ground.dy * inverse, ground.dx * inverse,
                                      salt(16 + k));
        const float deep = share * steepness2 / (steepness2 + 0.12f);
        ground.value += deep * (w.value - 0.1f);
        const float steep = deep * static_cast<float>(frequency);
        ground.dx += steep * w.dx;
        ground.dy += steep * w.dy;
    }
}

void Landscape::roughen(Field& ground, double x, double y) const {
    double frequency = 4.7;
    float amplitude = 0.045f;
    float dx = ground.dx, dy = ground.dy;
    for (int k = 0; k < octaves_; ++k, frequency *= 2.01, amplitude *= gain_) {
        const float share = amplitude * carried(frequency);
        if (share == 0) break;
        const Field n = gradient_noise(x * frequency, y * frequency, salt(32 + static_cast<std::uint32_t>(k)));
        const float steepness2 = dx * dx + dy * dy;
        const float damped = share * (0.2f + 0.8f * steepness2 / (steepness2 + 1.2f));
        ground.value += damped * n.value;
        dx += damped * static_cast<float>(frequency) * n.dx;
        dy += damped * static_cast<float>(frequency) * n.dy;
    }
}

[[noreturn]] void refuse(const std::string& what) {
    throw Failure(1, "recipe: " + what);
}

// One number of the recipe, inside its range.
struct Entry {
    const char* name;
    double least, most;
    bool whole;
    double value;
};

LandRecipe parse_land(const nlohmann::json& recipe) {
    if (!recipe.is_object()) refuse("not a JSON object; see content/terrain/mountains.json for one that is");
    LandRecipe r;
    std::array<Entry, 12> entries{{{"columns", 2, 65537, true, static_cast<double>(r.columns)},
                                   {"rows", 2, 65537, true, static_cast<double>(r.rows)},
                                   {"spacing_m", 1e-3, 1e6, false, r.spacing_m},
                                   {"seed", 0, 4294967295.0, true, static_cast<double>(r.seed)},
                                   {"base_m", -10000, 9000, false, r.base_m},
                                   {"relief_m", 0, 20000, false, r.relief_m},
                                   {"feature_m", 1e-2, 1e7, false, r.feature_m},
                                   {"octaves", 0, 16, true, static_cast<double>(r.octaves)},
                                   {"roughness", 0, 1, false, r.roughness},
                                   {"warp", 0, 1, false, r.warp},
                                   {"gullies", 0, 1, false, r.gullies},
                                   {"lowland", 0, 1, false, r.lowland}}};
    for (const auto& item : recipe.items()) {
        const std::string& key = item.key();
        const auto& value = item.value();
        if (key == "comment") continue;
        const auto entry = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return key == e.name; });
        if (entry == entries.end())
            refuse(fmt::format("unknown field \"{}\"; content/README.md lists the fields", key));
        if (!value.is_number()) refuse(fmt::format("\"{}\" must be a number", key));
        entry->value = value.get<double>();
        const bool fits =
            entry->value >= entry->least && entry->value <= entry->most &&
            (!entry->whole || entry->value == static_cast<double>(static_cast<std::int64_t>(entry->value)));
        if (!fits)
            refuse(fmt::format("\"{}\" must be a {} in {}..{}", key, entry->whole ? "whole number" : "number",
                               entry->least, entry->most));
    }
    const auto value = [&](std::size_t i) { return entries[i].value; };
    r = {static_cast<std::int32_t>(value(0)),
         static_cast<std::int32_t>(value(1)),
         value(2),
         static_cast<std::uint32_t>(value(3)),
         value(4),
         value(5),
         value(6),
         static_cast<int>(value(7)),
         value(8),
         value(9),
         value(10),
         value(11)};
    if (r.feature_m < 4 * r.spacing_m)
        refuse(fmt::format("\"feature_m\" must be at least 4 spacings ({} m), or no mountain shows", 4 * r.spacing_m));
    // Places in the finest octave must be whole numbers of 32 bits (whole()), the warp's half a feature included.
    if (r.feature_m > 1e9 * r.spacing_m) refuse("\"feature_m\" must be at most 1e9 spacings");
    return r;
}

class LandReader final : public HeightReader {
public:
    LandReader(const Landscape& land, const LandRecipe& recipe) : land_(land), recipe_(recipe) {}
    void read(const Window& window, float* to, ReadStatistics& statistics) override {
        statistics.per_unit = 1; // the quantum is known
        const double scale = recipe_.spacing_m / recipe_.feature_m;
        for (std::int32_t y = window.y; y < window.y + window.rows; ++y) {
            Landscape::Row memory;
            for (std::int32_t x = window.x; x < window.x + window.columns; ++x, ++to) {
                const double up = land_.height(memory, static_cast<double>(x) * scale, static_cast<double>(y) * scale);
                // To whole decimetres: a DEM with a step of its own is lossless in a pack.
                const std::int32_t steps = whole((recipe_.base_m + recipe_.relief_m * up) * 10 + 0.5);
                *to = static_cast<float>(steps * 0.1);
                statistics.least_m = std::min(statistics.least_m, *to);
                statistics.most_m = std::max(statistics.most_m, *to);
            }
        }
    }

private:
    const Landscape& land_;
    const LandRecipe& recipe_;
};

class LandSource final : public HeightSource {
public:
    explicit LandSource(const LandRecipe& recipe) : recipe_(recipe), land_(recipe) {
        facts.height_unit = std::string("m");
        columns = recipe.columns;
        rows = recipe.rows;
        spacing_m[0] = spacing_m[1] = recipe.spacing_m;
    }
    [[nodiscard]] std::unique_ptr<HeightReader> reader() const override {
        return std::make_unique<LandReader>(land_, recipe_);
    }
    [[nodiscard]] std::vector<Window> windows(std::size_t most) const override {
        return cut_along({0, 0, columns, rows}, {columns, 1, 0, 0}, most);
    }
    [[nodiscard]] SourceProperties properties(const ReadStatistics&) const override { return {0.1, 0, false}; }
    // The number changes when the landscape of a recipe does.
    [[nodiscard]] std::string identity() const override {
        const LandRecipe& r = recipe_;
        return fmt::format(
            "mountains 1: {} x {}, {} m, seed {} base {} relief {} feature {} octaves {} roughness {} warp {} "
            "gullies {} lowland {}",
            r.columns, r.rows, r.spacing_m, r.seed, r.base_m, r.relief_m, r.feature_m, r.octaves, r.roughness, r.warp,
            r.gullies, r.lowland);
    }

private:
    LandRecipe recipe_;
    Landscape land_;
};

} // namespace

std::unique_ptr<HeightSource> synth_source(const std::string& recipe_json) {
    return std::make_unique<LandSource>(parse_land(io::parse_json(recipe_json, "recipe", io::JsonComments::yes)));
}

std::unique_ptr<HeightSource> open_synth(const std::string& recipe_path) {
    const auto recipe = io::parse_json(io::read_text(recipe_path), recipe_path, io::JsonComments::yes);
    try {
        return std::make_unique<LandSource>(parse_land(recipe));
    } catch (const Failure& failure) {
        throw Failure(failure.exit_code, fmt::format("{}: {}", recipe_path, failure.what()));
    }
}

} // namespace fjell::baker
