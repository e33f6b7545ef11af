#include "baker/maps/base_mip.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "shared/compiler.h"

namespace fjell::baker {

namespace {

// Unit normals of a row by differences to both sides. per_*: 1 / the distance between the samples of a difference.
// Without FJELL_RESTRICT the compiler would have to compare too many pointers, and goes one by one.
FJELL_CLONES void normals_of_row(const float* west, const float* east, const float* north, const float* south,
                                 float per_east, float per_south, float* FJELL_RESTRICT x, float* FJELL_RESTRICT up,
                                 float* FJELL_RESTRICT z, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
        const float rise_east = (east[i] - west[i]) * per_east, rise_south = (south[i] - north[i]) * per_south;
        const float upward = 1 / std::sqrt(1 + rise_east * rise_east + rise_south * rise_south);
        x[i] = -(rise_east * upward);
        up[i] = upward;
        z[i] = -(rise_south * upward);
    }
}

// Rows of heights as they are, and of normals, made once each and kept as long as a filter looks at them.
class HeightRows : public RowSource {
public:
    enum Channel : int { x, z, height, up };

    // order: which of the channels the filter's first, second .. ones are.
    HeightRows(const MapPlan& plan, const GroundWindows& ground, const Taps& across, const Taps& down,
               std::array<Channel, 2> order)
        : plan_(plan), ground_(ground), first_(across.source_first), width_(across.source_end - across.source_first),
          kept_(down.taps), order_(order), next_(down.source_first) {
        for (auto& part : parts_) part.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(kept_));
    }

    void prepare(std::int32_t first, std::int32_t end) override {
        next_ = std::max(next_, first);
        for (; next_ < end; ++next_) make(next_);
    }
    [[nodiscard]] const float* row(int channel, std::int32_t y) const override {
        const Channel c = order_[static_cast<std::size_t>(channel)];
        if (c == height) return at(ground_.heights, first_, y);
        return parts_[c == x ? 0 : c == up ? 1 : 2].data() + slot(y);
    }

private:
    [[nodiscard]] static const float* at(const HeightWindow& of, std::int32_t column, std::int32_t row) {
        return of.heights_m + (row - of.at.y) * of.stride + (column - of.at.x);
    }
    [[nodiscard]] std::size_t slot(std::int32_t y) const {
        return static_cast<std::size_t>(y % kept_) * static_cast<std::size_t>(width_);
    }
    // Columns [from, to): one-sided on the rim, where west or east is the column itself.
    void make_columns(std::int32_t y, std::int32_t from, std::int32_t to) {
        if (from >= to) return;
        const std::int32_t columns = plan_.tree.columns(), rows = plan_.tree.rows();
        const std::int32_t west = std::max(from - 1, 0), east = std::min(from + 1, columns - 1);
        const std::int32_t north = std::max(y - 1, 0), south = std::min(y + 1, rows - 1);
        const auto per_east = static_cast<float>(1 / ((east - west) * plan_.spacing_m[0])),
                   per_south = static_cast<float>(1 / ((south - north) * plan_.spacing_m[1]));
        const std::size_t skip = slot(y) + static_cast<std::size_t>(from - first_);
        const HeightWindow& shape = ground_.shape;
        normals_of_row(at(shape, west, y), at(shape, east, y), at(shape, from, north), at(shape, from, south), per_east,
                       per_south, parts_[0].data() + skip, parts_[1].data() + skip, parts_[2].data() + skip,
                       static_cast<std::size_t>(to - from));
    }
    void make(std::int32_t y) {
        const std::int32_t end = first_ + width_, last = plan_.tree.columns() - 1;
        const std::int32_t inner = std::max(first_, 1), outer = std::min(end, last);
        make_columns(y, first_, std::min(inner, end));
        make_columns(y, inner, outer);
        make_columns(y, std::max(outer, inner), end);
    }

    const MapPlan& plan_;
    GroundWindows ground_;
    std::int32_t first_, width_, kept_;
    std::array<Channel, 2> order_;
    std::int32_t next_;
    Buffer<float> parts_[3]; // x, up, z
};

TexelPlanes filtered(const MapPlan& plan, MapKind kind, const GroundWindows& ground, const Window& texels,
                     std::array<HeightRows::Channel, 2> channels) {
    const SampleAxes from = sample_axes(plan, kind);
    const Taps x = make_taps(from.axes[0], texels.x, texels.columns),
               y = make_taps(from.axes[1], texels.y, texels.rows);
    HeightRows rows(plan, ground, x, y, channels);
    return tent_filter(x, y, texels, rows, 2);
}

// ---- images --------------------------------------------------------------------------------------------------------

// Where an image's pixels lie under texels, along one axis. A texel whose centre is beyond the image's outer edge sees
// nothing (half a pixel of grace: an image cut exactly at the outermost samples ends there).
TentAxis image_axis(const MapPlan& plan, const ImageLayer& layer, int axis) {
    const SampleAxes samples = sample_axes(plan, MapKind::colour);
    TentAxis a = samples.axes[axis];
    a.scale = layer.per_sample[axis];
    a.shift = layer.first_px[axis] - 0.5;
    a.size = axis == 0 ? layer.columns : layer.rows;
    return a;
}

// The texels of [first, first + count) that the image covers: one run.
struct Run {
    std::int32_t first = 0, count = 0;
};
Run covered(const TentAxis& axis, std::int32_t first, std::int32_t count) {
    Run run{first, 0};
    for (std::int32_t g = first; g < first + count; ++g) {
        const double centre = axis.centre(g);
        if (centre < -1 || centre > axis.size) continue;
        if (run.count++ == 0) run.first = g;
    }
    return run;
}

// Red, green and blue light times alpha, and alpha: one row of pixels, summed across to texels.
void sum_pixels(const Taps& x, const std::uint8_t* rgba, const float* light, float* to) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(x.count); ++i) {
        const std::uint8_t* from = rgba + 4 * static_cast<std::size_t>(x.first[i]);
        const float* const w = x.weights.data() + i * static_cast<std::size_t>(x.taps);
        float r = 0, g = 0, b = 0, a = 0;
        for (std::int32_t k = 0; k < x.taps; ++k, from += 4) {
            const float share = w[k] * (static_cast<float>(from[3]) * (1.0f / 255));
            r += share * light[from[0]];
            g += share * light[from[1]];
            b += share * light[from[2]];
            a += share;
        }
        to[4 * i] = r, to[4 * i + 1] = g, to[4 * i + 2] = b, to[4 * i + 3] = a;
    }
}

const float* light_codes() {
    static const auto table = [] {
        std::array<float, 256> light{};
        for (std::size_t v = 0; v < 256; ++v) light[v] = LightOfSrgb::table().at(static_cast<float>(v));
        return light;
    }();
    return table.data();
}

// Sums of light times alpha, and alpha, over what is there; the same four channels.
void blend(const std::vector<float>& sums, const Window& over, TexelPlanes& light) {
    const float* sum = sums.data();
    for (std::int32_t y = over.y; y < over.y + over.rows; ++y)
        for (std::int32_t x = over.x; x < over.x + over.columns; ++x, sum += 4) {
            const auto to = static_cast<std::size_t>(y - light.at.y) * static_cast<std::size_t>(light.at.columns) +
                            static_cast<std::size_t>(x - light.at.x);
            const float open = std::max(1 - sum[3], 0.0f);
            for (std::size_t c = 0; c < 4; ++c) light.channel[c][to] = sum[c] + open * light.channel[c][to];
        }
}

// A layer over what is there. Pixels stream through in strips of rows; each row is summed across once and added to the
// texel rows that see it.
void lay_image(const MapPlan& plan, ImageReader& reader, std::size_t layer, TexelPlanes& light) {
    const Window& at = light.at;
    const TentAxis ax = image_axis(plan, plan.image->layers[layer], 0),
                   ay = image_axis(plan, plan.image->layers[layer], 1);
    const Run run_x = covered(ax, at.x, at.columns), run_y = covered(ay, at.y, at.rows);
    if (run_x.count == 0 || run_y.count == 0) return;
    const Taps x = make_taps(ax, run_x.first, run_x.count), y = make_taps(ay, run_y.first, run_y.count);
    const std::int32_t width = x.source_end - x.source_first;
    const auto line_floats = static_cast<std::size_t>(x.count) * 4;
    const std::int32_t strip = std::clamp((1 << 20) / width, 1, y.source_end - y.source_first);
    Buffer<std::uint8_t> rgba(static_cast<std::size_t>(strip) * static_cast<std::size_t>(width) * 4);
    std::vector<float> line(line_floats), sums(line_floats * static_cast<std::size_t>(y.count));
    std::size_t oldest = 0;
    for (std::int32_t row = y.source_first; row < y.source_end; ++row) {
        const std::int32_t in_strip = (row - y.source_first) % strip;
        if (in_strip == 0)
            reader.read(layer, {x.source_first, row, width, std::min(strip, y.source_end - row)}, rgba.data());
        sum_pixels(x, rgba.data() + static_cast<std::size_t>(in_strip) * static_cast<std::size_t>(width) * 4,
                   light_codes(), line.data());
        const std::int32_t k = row - y.source_first;
        while (oldest < static_cast<std::size_t>(y.count) && y.first[oldest] + y.taps <= k) ++oldest;
        for (std::size_t j = oldest; j < static_cast<std::size_t>(y.count) && y.first[j] <= k; ++j) {
            const float w = y.weights[j * static_cast<std::size_t>(y.taps) + static_cast<std::size_t>(k - y.first[j])];
            float* const to = sums.data() + j * line_floats;
            if (w != 0)
                for (std::size_t i = 0; i < line_floats; ++i) to[i] += w * line[i];
        }
    }
    blend(sums, {run_x.first, run_y.first, x.count, y.count}, light);
}

// The ramp alone.
TexelPlanes paint_ground(const MapPlan& plan, const GroundWindows& from, const Window& texels) {
    const TexelPlanes ground = filtered(plan, MapKind::colour, from, texels, {HeightRows::height, HeightRows::up});
    TexelPlanes light(texels, 3);
    RampPainter(*plan.ramp)
        .paint_light(ground.channel[0].data(), ground.channel[1].data(), texels.area(),
                     {light.channel[0].data(), light.channel[1].data(), light.channel[2].data()});
    return light;
}

// The ramp where images leave something open.
void lay_under(const MapPlan& plan, const GroundWindows& from, TexelPlanes& light) {
    constexpr float opaque = 0.9999f; // weights add up to 1 but for rounding
    const Buffer<float>& alpha = light.channel[3];
    if (std::all_of(alpha.begin(), alpha.end(), [](float a) { return a >= opaque; })) return;
    const TexelPlanes ground = filtered(plan, MapKind::colour, from, light.at, {HeightRows::height, HeightRows::up});
    const LightOfSrgb& table = LightOfSrgb::table();
    RampPainter painter(*plan.ramp);
    for (std::size_t i = 0; i < alpha.size(); ++i) {
        if (alpha[i] >= opaque) continue;
        float rgb[3];
        painter.paint(ground.channel[0][i], ground.channel[1][i], rgb);
        const float open = std::max(1 - alpha[i], 0.0f);
        for (std::size_t c = 0; c < 3; ++c) light.channel[c][i] += open * table.at(rgb[c]);
    }
}

} // namespace

TexelPlanes base_normals(const MapPlan& plan, const HeightWindow& shape, const Window& texels) {
    return filtered(plan, MapKind::normal, {shape, shape}, texels, {HeightRows::x, HeightRows::z});
}

TexelPlanes base_colours(const MapPlan& plan, const GroundWindows& ground, const Window& texels, ImageReader* reader) {
    const bool images = plan.image && reader;
    if (!images && plan.ramp) return paint_ground(plan, ground, texels);
    TexelPlanes light(texels, 4); // three colours times alpha, alpha
    light.clear();
    if (images)
        for (std::size_t layer = 0; layer < plan.image->layers.size(); ++layer) lay_image(plan, *reader, layer, light);
    if (plan.ramp) lay_under(plan, ground, light);
    light.channel.pop_back();
    return light;
}

} // namespace fjell::baker
