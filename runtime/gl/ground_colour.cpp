// Follows add_layers() of shaders_layers.cpp, where the ground is near: change both together. Of the shader's planes
// only the one from above is left, as that is how maps lie on the ground.
#include "fjell/gl/ground_colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fjell/texture.h"
#include "gl/layers.h"
#include "gl/noise.h"

namespace fjell::gl {

namespace ground {

using Rgb = std::array<float, 3>;

float linear_of(std::uint8_t code) {
    const float v = static_cast<float>(code) / 255;
    return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}
std::uint8_t srgb_of(float light) {
    const float v = light <= 0.0031308f ? 12.92f * light : 1.055f * std::pow(light, 1 / 2.4f) - 0.055f;
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(v, 0.0f, 1.0f)));
}
float luminance_of(const Rgb& v) {
    return 0.2126f * v[0] + 0.7152f * v[1] + 0.0722f * v[2];
}

// A texture that repeats.
struct Repeating {
    std::uint32_t side = 0;
    std::vector<float> texels;

    // Between its texels; u, v in periods.
    template <std::size_t Channels>
    [[nodiscard]] std::array<float, Channels> at(double u, double v) const {
        const auto texel_of = [this](double periods) {
            const double at = periods - 0.5 / side;
            return static_cast<float>(at - std::floor(at)) * static_cast<float>(side);
        };
        const float x = texel_of(u), y = texel_of(v);
        const auto x0 = static_cast<std::uint32_t>(x), y0 = static_cast<std::uint32_t>(y);
        const float along = x - static_cast<float>(x0), down = y - static_cast<float>(y0);
        std::array<float, Channels> sum{};
        for (std::uint32_t tap = 0; tap < 4; ++tap) {
            const std::uint32_t i = (x0 + tap % 2) % side, j = (y0 + tap / 2) % side;
            const float near = (tap % 2 != 0 ? along : 1 - along) * (tap / 2 != 0 ? down : 1 - down);
            for (std::size_t c = 0; c < Channels; ++c)
                sum[c] += near * texels[Channels * (std::size_t{j} * side + i) + c];
        }
        return sum;
    }
};

// Of a texture that repeats after a period: the mip whose texels are about as far apart as what it is read for.
std::uint32_t mip_for(double texel_m, double period_m, std::uint32_t side, std::uint32_t mips) {
    const double finer = std::log2(std::max(texel_m * side / period_m, 1.0));
    return static_cast<std::uint32_t>(std::min<double>(std::round(finer), mips - 1));
}

struct Material {
    Repeating fine, coarse;    // colour over the mean, and height
    std::array<float, 4> turn; // turns_of()
    float coarse_share = 0;
    Rgb mean{};
};

Repeating texture_of(const io::Materials& materials, std::uint32_t number, double period_m, double texel_m) {
    const std::uint32_t mip = mip_for(texel_m, period_m, 1u << materials.side_log2, materials.mips());
    Repeating texture{1u << (materials.side_log2 - mip), {}};
    const std::vector<std::uint8_t> rgba =
        decode_material(true, materials.colour.data() + materials.mip_offset(mip, number), texture.side);
    const io::MaterialRecord& record = materials.records[number];
    for (std::size_t i = 0; i < rgba.size(); ++i)
        texture.texels.push_back(i % 4 == 3 ? static_cast<float>(rgba[i]) / 255
                                            : linear_of(rgba[i]) / std::max(record.mean[i % 4], 0.004f));
    return texture;
}

constexpr double patches_m = 512, spots_m = 64; // of a period

// The noise's two heights.
Repeating noise_of(const std::vector<std::uint8_t>& noise, double period_m, double texel_m) {
    const std::uint32_t mip = mip_for(texel_m, period_m, noise_side, noise_mips);
    std::size_t first = 0;
    for (std::uint32_t finer = 0; finer < mip; ++finer)
        first += std::size_t{4} * (noise_side >> finer) * (noise_side >> finer);
    Repeating texture{static_cast<std::uint32_t>(noise_side) >> mip, {}};
    for (std::size_t i = 0; i < std::size_t{texture.side} * texture.side; ++i)
        for (const std::size_t channel : {2u, 3u})
            texture.texels.push_back(static_cast<float>(noise[first + 4 * i + channel]) / 255);
    return texture;
}

// At a place, 0 to 1.
struct Noises {
    float patches, spots;
    std::array<float, 2> sway; // of places in splat maps
};

struct Share {
    std::size_t material = 0;
    float share = 0;
};
using Strongest = std::array<Share, 3>;

void keep_most(Share share, Strongest& most) {
    for (Share& kept : most)
        if (share.share > kept.share) std::swap(kept, share);
}
void make_whole(Strongest& most) {
    const float all = most[0].share + most[1].share + most[2].share;
    if (!(all > 0)) most[0].share = 1;
    if (all > 0)
        for (Share& s : most) s.share /= all;
}

struct Painter {
    std::vector<Material> materials;
    std::vector<LayerRule> rules;
    std::vector<std::int32_t> of_name; // the material of each of the splat maps' names; -1: water
    Repeating patches, spots;
    float tint = 0;

    [[nodiscard]] Noises noises_at(double x_m, double z_m) const;
    [[nodiscard]] Strongest of_rules(double height_m, double slope_deg, const Noises& noises) const;
    [[nodiscard]] Strongest of_map(const GroundTexels& texels, double x, double y, const Noises& noises,
                                   float& covered) const;
    [[nodiscard]] std::array<float, 4> material_at(const Material& m, double x_m, double z_m,
                                                   const Noises& noises) const;
    [[nodiscard]] Rgb blend(const Strongest& strongest, const Rgb& map, double x_m, double z_m,
                            const Noises& noises) const;
};

Noises Painter::noises_at(double x_m, double z_m) const {
    const auto spread = [](float code) { return std::clamp(code * 2.4f - 0.7f, 0.0f, 1.0f); };
    const auto far = patches.at<2>(x_m / patches_m, z_m / patches_m), near = spots.at<2>(x_m / spots_m, z_m / spots_m);
    return {spread(far[0]), spread(near[0]), {spread(far[0]) - 0.5f, spread(far[1]) - 0.5f}};
}

Strongest Painter::of_rules(double height_m, double slope_deg, const Noises& noises) const {
    std::array<double, max_layer_rules> shares;
    layer_shares(rules, height_m, slope_deg, static_cast<double>(noises.patches), static_cast<double>(noises.spots),
                 std::span(shares).first(rules.size()));
    Strongest most{};
    for (std::size_t i = rules.size(); i-- > 0;) keep_most({rules[i].material, static_cast<float>(shares[i])}, most);
    make_whole(most);
    return most;
}

// x, y: 0 to 1 in the square.
Strongest Painter::of_map(const GroundTexels& texels, double x, double y, const Noises& noises, float& covered) const {
    const std::uint32_t side = texels.splat_side;
    const double px = std::clamp(x, 0.0, 1.0) * (side - 1), py = std::clamp(y, 0.0, 1.0) * (side - 1);
    const auto x0 = std::min(static_cast<std::uint32_t>(px), side - 2),
               y0 = std::min(static_cast<std::uint32_t>(py), side - 2);
    const auto along = static_cast<float>(px - x0), down = static_cast<float>(py - y0);
    std::array<float, max_splat_names> names{};
    for (std::uint32_t tap = 0; tap < 4; ++tap) {
        const std::size_t texel = (std::size_t{y0 + tap / 2} * side + x0 + tap % 2) * splat_texel_bytes;
        const float near = (tap % 2 != 0 ? along : 1 - along) * (tap / 2 != 0 ? down : 1 - down);
        for (std::size_t i = 0; i < splat_layers; ++i) {
            const auto weight = static_cast<float>(texels.splat[texel + 2 * i]) / 255;
            names[static_cast<std::size_t>(texels.splat[texel + 2 * i + 1]) % max_splat_names] += near * weight;
        }
    }
    covered = 0;
    Strongest most{};
    for (std::size_t name = 0; name < names.size(); ++name) {
        if (name < of_name.size() && of_name[name] < 0) continue; // water has the map's colour
        covered += names[name];
        keep_most({name, names[name]}, most);
    }
    make_whole(most);
    const float sway = (0.75f * noises.patches + 0.25f * noises.spots - 0.5f) * 1.4f *
                       std::min(4 * most[0].share * most[1].share, 1.0f) *
                       (most[0].material < most[1].material ? 1.0f : -1.0f);
    most[0].share = std::max(most[0].share + sway, 0.0f);
    most[1].share = std::max(most[1].share - sway, 0.0f);
    make_whole(most);
    if (most[1].share > most[0].share) std::swap(most[0], most[1]);
    for (Share& s : most)
        s.material = s.material < of_name.size() ? static_cast<std::size_t>(std::max(of_name[s.material], 0)) : 0;
    covered = std::min(covered, 1.0f);
    return most;
}

// Its colour over its mean, and its height.
std::array<float, 4> Painter::material_at(const Material& m, double x_m, double z_m, const Noises& noises) const {
    const auto read = [&](const Repeating& texture, std::size_t turn, double number) {
        const double east = static_cast<double>(m.turn[turn]) / layer_period_m,
                     south = static_cast<double>(m.turn[turn + 1]) / layer_period_m;
        const double u = number * 0.7548777, v = number * 0.5698403; // the patch's own place
        return texture.at<4>(east * x_m - south * z_m + u, south * x_m + east * z_m + v);
    };
    const float patch = 7 * noises.spots + 3 * noises.patches, number = std::floor(patch);
    const float t = std::clamp((patch - number - 0.4f) / 0.2f, 0.0f, 1.0f), next = t * t * (3 - 2 * t);
    const std::array<float, 4> first = read(m.fine, 0, static_cast<double>(number)),
                               second = read(m.fine, 0, static_cast<double>(number) + 1), coarse = read(m.coarse, 2, 0);
    const float share = 0.55f * m.coarse_share;
    std::array<float, 4> ground;
    for (std::size_t c = 0; c < 4; ++c) {
        const float fine = first[c] + (second[c] - first[c]) * next;
        ground[c] =
            c == 3 ? 0.35f * (0.5f + (coarse[c] - 0.5f) * share) + 0.65f * fine : (1 + (coarse[c] - 1) * share) * fine;
    }
    return ground;
}

Rgb Painter::blend(const Strongest& strongest, const Rgb& map, double x_m, double z_m, const Noises& noises) const {
    // A strong colour of the map only leans on a material's own.
    const float grey = std::max(luminance_of(map), 1e-4f);
    Rgb leaning;
    for (std::size_t c = 0; c < 3; ++c) leaning[c] = std::sqrt(std::max(map[c], 0.0f) / grey);
    const float as_light = grey / std::max(luminance_of(leaning), 1e-4f);
    std::array<Rgb, 3> colours{};
    std::array<float, 3> reach{-1, -1, -1};
    for (std::size_t i = 0; i < 3; ++i) {
        const float share = strongest[i].share;
        if (i != 0 && share <= 0.12f) break; // even what is highest in it would lie below the others
        const Material& m = materials[strongest[i].material];
        const std::array<float, 4> ground = material_at(m, x_m, z_m, noises);
        for (std::size_t c = 0; c < 3; ++c)
            colours[i][c] = ground[c] * (m.mean[c] + (leaning[c] * as_light - m.mean[c]) * tint);
        reach[i] = share + (ground[3] - 0.5f) * std::min(4 * share * (1 - share), 1.0f);
    }
    const float top = *std::ranges::max_element(reach) - 0.15f;
    Rgb sum{};
    float all = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const float weight = std::max(reach[i] - top, 0.0f);
        all += weight;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * colours[i][c];
    }
    for (float& c : sum) c = std::clamp(c / all, 0.0f, 0.95f);
    return sum;
}

} // namespace ground

struct GroundColour::Data : ground::Painter {};

void GroundColour::set(const io::Materials& materials, std::span<const LayerRule> rules,
                       std::span<const std::string> names, const LayerSettings& settings, double texel_m) {
    data_ = nullptr;
    std::int32_t of_name[io::max_materials] = {};
    validate(settings);
    check_layers({materials, rules, names}, of_name);
    const auto data = std::make_shared<Data>();
    for (std::uint32_t i = 0; i < materials.records.size(); ++i) {
        const io::MaterialRecord& r = materials.records[i];
        const auto size_m = static_cast<double>(r.size_m), coarse_m = size_m * static_cast<double>(r.coarse);
        data->materials.push_back(
            {ground::texture_of(materials, i, size_m, texel_m),
             ground::texture_of(materials, i, coarse_m, texel_m),
             turns_of(r, i),
             r.coarse_share,
             {std::max(r.mean[0], 0.004f), std::max(r.mean[1], 0.004f), std::max(r.mean[2], 0.004f)}});
    }
    data->rules.assign(rules.begin(), rules.end());
    data->of_name.assign(of_name, of_name + names.size());
    const std::vector<std::uint8_t> noise = make_noise();
    data->patches = ground::noise_of(noise, ground::patches_m, texel_m);
    data->spots = ground::noise_of(noise, ground::spots_m, texel_m);
    data->tint = static_cast<float>(settings.tint);
    data_ = data;
}

bool GroundColour::paint(const GroundTexels& t) const {
    const std::size_t all = std::size_t{t.side} * t.side;
    const bool by_map = !t.splat.empty();
    if (data_ == nullptr || t.side < 2 || t.rgb.size() != 3 * all) return false;
    if (by_map && (t.splat_side < 2 || t.splat.size() != std::size_t{t.splat_side} * t.splat_side * splat_texel_bytes))
        return false;
    if (!by_map && (data_->rules.empty() || t.height_m.size() != all || t.slope_deg.size() != all)) return false;
    // Noise moves places in a splat map by half a texel, but no further than its own patches are wide.
    const double most_m = 30, half = 0.5 / std::max(t.splat_side, 1u), across = t.side - 1;
    const double sway_x = std::min(half, most_m / (across * t.step_x_m)),
                 sway_y = std::min(half, most_m / (across * t.step_z_m));
    for (std::size_t i = 0; i < all; ++i) {
        const auto column = static_cast<double>(i % t.side), row = static_cast<double>(i / t.side);
        const double x_m = t.x_m + column * t.step_x_m, z_m = t.z_m + row * t.step_z_m;
        const ground::Noises noises = data_->noises_at(x_m, z_m);
        float covered = 1;
        const ground::Strongest strongest =
            by_map ? data_->of_map(t, column / across + sway_x * static_cast<double>(noises.sway[0]),
                                   row / across + sway_y * static_cast<double>(noises.sway[1]), noises, covered)
                   : data_->of_rules(static_cast<double>(t.height_m[i]), static_cast<double>(t.slope_deg[i]), noises);
        if (!(covered > 0)) continue;
        const ground::Rgb map{ground::linear_of(t.rgb[3 * i]), ground::linear_of(t.rgb[3 * i + 1]),
                              ground::linear_of(t.rgb[3 * i + 2])};
        const ground::Rgb painted = data_->blend(strongest, map, x_m, z_m, noises);
        for (std::size_t c = 0; c < 3; ++c)
            t.rgb[3 * i + c] = ground::srgb_of(map[c] + (painted[c] - map[c]) * covered);
    }
    return true;
}

} // namespace fjell::gl
