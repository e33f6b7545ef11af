// Maps are filtered straight from the source for every mip, not from the mip below: a tile's mips do not halve on the
// same grid (first and last texels lie on the border of each), and a texel on a border must not know whose it is.
#include "baker/colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace fjell::baker {

namespace {

// ---- a separable tent filter -------------------------------------------------------------------------------------

// The source pixels under one texel along one axis, with weights that add up to 1.
struct Taps {
    std::int32_t first = 0;
    std::vector<float> weights;
};

// Texel `first` .. `first + count` of the whole terrain; texel g stands at g * step + shift in source pixels.
struct Axis {
    std::int64_t first;
    std::int32_t count;
    double step, shift;
    std::int32_t source_size;
};

std::vector<Taps> make_taps(const Axis& axis) {
    std::vector<Taps> all(static_cast<std::size_t>(axis.count));
    const double radius = std::max(axis.step, 1.0);
    for (std::int32_t i = 0; i < axis.count; ++i) {
        // From the texel's place in the terrain alone, so that both tiles at a border get the same bits.
        const double centre = static_cast<double>(axis.first + i) * axis.step + axis.shift;
        const auto low = std::clamp(static_cast<std::int32_t>(std::ceil(centre - radius)), 0, axis.source_size - 1);
        const auto high = std::clamp(static_cast<std::int32_t>(std::floor(centre + radius)), low, axis.source_size - 1);
        std::vector<double> weights;
        double sum = 0;
        for (std::int32_t k = low; k <= high; ++k) {
            weights.push_back(std::max(1 - std::abs(k - centre) / radius, 0.0));
            sum += weights.back();
        }
        Taps& taps = all[static_cast<std::size_t>(i)];
        taps.first = low;
        // A texel past the last pixel by rounding alone has no weight at all: it takes the nearest.
        for (const double w : weights)
            taps.weights.push_back(static_cast<float>(sum > 0 ? w / sum : 1.0 / (high - low + 1)));
    }
    return all;
}

std::int32_t end_of(const Taps& taps) {
    return taps.first + static_cast<std::int32_t>(taps.weights.size());
}

// fill(y, x0, x1, to): the source's row y, columns [x0, x1), `channels` floats each. Returns count_x * count_y texels.
template <std::size_t channels, typename Fill>
std::vector<float> filter(const Axis& axis_x, const Axis& axis_y, const Fill& fill) {
    const std::vector<Taps> across = make_taps(axis_x), down = make_taps(axis_y);
    const std::int32_t x0 = across.front().first, x1 = end_of(across.back());
    const std::size_t width = across.size() * channels;
    std::vector<float> source(static_cast<std::size_t>(x1 - x0) * channels), line(width), out(width * down.size());
    std::size_t oldest = 0; // texel rows before it have all their source rows
    for (std::int32_t y = down.front().first; y < end_of(down.back()); ++y) {
        fill(y, x0, x1, source.data());
        for (std::size_t i = 0; i < across.size(); ++i) {
            std::array<float, channels> sum{};
            const float* from = source.data() + static_cast<std::size_t>(across[i].first - x0) * channels;
            for (const float w : across[i].weights)
                for (std::size_t c = 0; c < channels; ++c) sum[c] += w * *from++;
            std::copy(sum.begin(), sum.end(), line.begin() + static_cast<std::ptrdiff_t>(i * channels));
        }
        while (oldest < down.size() && end_of(down[oldest]) <= y) ++oldest;
        for (std::size_t j = oldest; j < down.size() && down[j].first <= y; ++j) {
            const float w = down[j].weights[static_cast<std::size_t>(y - down[j].first)];
            float* const to = out.data() + j * width;
            for (std::size_t k = 0; k < width; ++k) to[k] += w * line[k];
        }
    }
    return out;
}

struct Footprint {
    Axis x, y;
};

// Texels of one mip of one tile over a source whose pixel k stands at (k + centre) * sample_columns / width samples.
Footprint over_samples(const MapBuilder& maps, std::uint32_t tile, std::int32_t texels) {
    const auto tiles_x = static_cast<std::uint32_t>(maps.tree.tiles_x);
    const double step = static_cast<double>(maps.tree.side()) / (texels - 1);
    const std::int64_t column = tile % tiles_x, row = tile / tiles_x;
    return {{column * (texels - 1), texels, step, 0, maps.dem.columns},
            {row * (texels - 1), texels, step, 0, maps.dem.rows}};
}

Footprint over_image(const MapBuilder& maps, const Image& image, std::uint32_t tile, std::int32_t texels) {
    Footprint at = over_samples(maps, tile, texels);
    // Edges on the outermost samples: pixel k's middle is at k + 1/2.
    at.x = {at.x.first, texels, at.x.step * image.width / (maps.dem.columns - 1), -0.5, image.width};
    at.y = {at.y.first, texels, at.y.step * image.height / (maps.dem.rows - 1), -0.5, image.height};
    return at;
}

std::int32_t texels_of(std::uint32_t log2, std::uint32_t mip) {
    return std::int32_t{1} << (log2 - mip);
}

// ---- colours -----------------------------------------------------------------------------------------------------

double linear_of(double srgb) { // 0..1
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

// 8-bit sRGB to linear light, and back by comparing with the middles between codes.
struct SrgbTables {
    std::array<float, 256> linear{};
    std::array<float, 256> upper{};         // linear light above which the next code is nearer
    std::array<std::uint8_t, 1024> guess{}; // a code that is not too high, by linear light in 1024ths

    SrgbTables() {
        for (std::size_t v = 0; v < 256; ++v) {
            linear[v] = static_cast<float>(linear_of(static_cast<double>(v) / 255));
            upper[v] = v == 255 ? HUGE_VALF : static_cast<float>(linear_of((static_cast<double>(v) + 0.5) / 255));
        }
        std::size_t code = 0;
        for (std::size_t i = 0; i < guess.size(); ++i) {
            while (static_cast<float>(i) / 1024 >= upper[code]) ++code;
            guess[i] = static_cast<std::uint8_t>(code);
        }
    }
    [[nodiscard]] std::uint8_t code(float light) const {
        const float clamped = std::clamp(light, 0.0f, 1.0f);
        std::size_t v = guess[std::min<std::size_t>(static_cast<std::size_t>(clamped * 1024), 1023)];
        while (clamped >= upper[v]) ++v;
        return static_cast<std::uint8_t>(v);
    }
};

const SrgbTables& srgb() {
    static const SrgbTables tables;
    return tables;
}

std::vector<std::uint8_t> image_mip(const MapBuilder& maps, const Image& image, std::uint32_t tile,
                                    std::int32_t texels) {
    const SrgbTables& tables = srgb();
    const Footprint at = over_image(maps, image, tile, texels);
    const auto light = filter<3>(at.x, at.y, [&](std::int32_t y, std::int32_t x0, std::int32_t x1, float* to) {
        const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width);
        const std::uint8_t* from = image.rgb.data() + (row + static_cast<std::size_t>(x0)) * 3;
        std::transform(from, from + static_cast<std::ptrdiff_t>(x1 - x0) * 3, to,
                       [&](std::uint8_t v) { return tables.linear[v]; });
    });
    std::vector<std::uint8_t> rgb(light.size());
    std::transform(light.begin(), light.end(), rgb.begin(), [&](float v) { return tables.code(v); });
    return rgb;
}

std::array<std::uint8_t, 3> colour_of(const Ramp& ramp, double height_m) {
    const auto above = std::upper_bound(ramp.stops.begin(), ramp.stops.end(), height_m,
                                        [](double h, const Ramp::Stop& stop) { return h < stop.height_m; });
    const Ramp::Stop& high = above == ramp.stops.end() ? ramp.stops.back() : *above;
    const Ramp::Stop& low = above == ramp.stops.begin() ? ramp.stops.front() : *(above - 1);
    const double range = high.height_m - low.height_m;
    const double t = range > 0 ? std::clamp((height_m - low.height_m) / range, 0.0, 1.0) : 0;
    std::array<std::uint8_t, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c)
        rgb[c] = static_cast<std::uint8_t>(std::clamp(low.rgb[c] + t * (high.rgb[c] - low.rgb[c]) + 0.5, 0.0, 255.0));
    return rgb;
}

std::vector<std::uint8_t> ramp_mip(const MapBuilder& maps, const Ramp& ramp, std::uint32_t tile, std::int32_t texels) {
    const Footprint at = over_samples(maps, tile, texels);
    const auto heights = filter<1>(at.x, at.y, [&](std::int32_t y, std::int32_t x0, std::int32_t x1, float* to) {
        const auto row = maps.dem.heights_m.begin() + static_cast<std::ptrdiff_t>(y) * maps.dem.columns;
        std::copy(row + x0, row + x1, to);
    });
    std::vector<std::uint8_t> rgb;
    rgb.reserve(heights.size() * 3);
    for (const float h : heights)
        for (const std::uint8_t c : colour_of(ramp, h)) rgb.push_back(c);
    return rgb;
}

// ---- normals -----------------------------------------------------------------------------------------------------

// Unit normals (east, up, south) of a row's samples [x0, x1).
void normals_of_row(const Dem& dem, std::int32_t y, std::int32_t x0, std::int32_t x1, float* to) {
    const std::int32_t north = std::max(y - 1, 0), south = std::min(y + 1, dem.rows - 1);
    const double per_south = south > north ? 1 / ((south - north) * dem.spacing_m[1]) : 0;
    for (std::int32_t x = x0; x < x1; ++x) {
        const std::int32_t west = std::max(x - 1, 0), east = std::min(x + 1, dem.columns - 1);
        const double per_east = east > west ? 1 / ((east - west) * dem.spacing_m[0]) : 0;
        const double rise_east = (static_cast<double>(dem.at(east, y)) - dem.at(west, y)) * per_east;
        const double rise_south = (static_cast<double>(dem.at(x, south)) - dem.at(x, north)) * per_south;
        const double up = 1 / std::sqrt(1 + rise_east * rise_east + rise_south * rise_south);
        *to++ = static_cast<float>(-rise_east * up);
        *to++ = static_cast<float>(up);
        *to++ = static_cast<float>(-rise_south * up);
    }
}

std::uint8_t signed_byte(float v) {
    return static_cast<std::uint8_t>(static_cast<std::int8_t>(std::round(std::clamp(v, -1.0f, 1.0f) * 127)));
}

} // namespace

std::vector<std::uint8_t> colour_mip(const MapBuilder& maps, const Image* image, const Ramp* ramp, std::uint32_t tile,
                                     std::uint32_t mip) {
    const std::int32_t texels = texels_of(maps.colour_log2, mip);
    if (image) return image_mip(maps, *image, tile, texels);
    if (ramp->relative) return ramp_mip(maps, absolute(*ramp, maps.dem), tile, texels);
    return ramp_mip(maps, *ramp, tile, texels);
}

std::vector<std::uint8_t> normal_mip(const MapBuilder& maps, std::uint32_t tile, std::uint32_t mip) {
    const Footprint at = over_samples(maps, tile, texels_of(maps.normal_log2, mip));
    const auto sums = filter<3>(at.x, at.y, [&](std::int32_t y, std::int32_t x0, std::int32_t x1, float* to) {
        normals_of_row(maps.dem, y, x0, x1, to);
    });
    std::vector<std::uint8_t> bytes;
    bytes.reserve(sums.size() / 3 * 2);
    for (std::size_t i = 0; i < sums.size(); i += 3) {
        // Every normal points up, so the mean never vanishes.
        const float scale = 1 / std::sqrt(sums[i] * sums[i] + sums[i + 1] * sums[i + 1] + sums[i + 2] * sums[i + 2]);
        bytes.push_back(signed_byte(sums[i] * scale));
        bytes.push_back(signed_byte(sums[i + 2] * scale));
    }
    return bytes;
}

Ramp absolute(const Ramp& ramp, const Dem& dem) {
    if (!ramp.relative) return ramp;
    const auto [least, most] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    Ramp metres{ramp.stops, false};
    for (Ramp::Stop& stop : metres.stops)
        stop.height_m = *least + stop.height_m * (static_cast<double>(*most) - *least);
    return metres;
}

std::uint32_t fitting_log2(double texels_per_tile, std::uint32_t max_log2) {
    std::uint32_t log2 = 2;
    // An eighth too few is no visible loss, and saves three quarters of the bytes.
    while (log2 < max_log2 && static_cast<double>(std::uint32_t{1} << log2) * 1.125 < texels_per_tile) ++log2;
    return log2;
}

} // namespace fjell::baker
