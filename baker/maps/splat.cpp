#include "baker/maps/splat.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/read/gdal_file.h"
#include "fjell/io/failure.h"
#include "fjell/io/materials.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::baker {

namespace {

using Layers = std::array<float, max_splat_names>;

// ---- noise ---------------------------------------------------------------------------------------------------------

float of_place(std::int64_t x, std::int64_t y) {
    std::uint64_t h =
        static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ull ^ static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4full;
    h ^= h >> 29;
    h *= 0xbf58476d1ce4e5b9ull;
    h ^= h >> 32;
    return static_cast<float>(h >> 40) * 0x1p-24f;
}

float value_noise(double x, double y) {
    const double fx = std::floor(x), fy = std::floor(y);
    const auto ix = static_cast<std::int64_t>(fx), iy = static_cast<std::int64_t>(fy);
    const auto soft = [](double t) { return static_cast<float>(t * t * (3 - 2 * t)); };
    const float u = soft(x - fx), v = soft(y - fy);
    const float nw = of_place(ix, iy), ne = of_place(ix + 1, iy), sw = of_place(ix, iy + 1),
                se = of_place(ix + 1, iy + 1);
    const float north = nw + (ne - nw) * u, south = sw + (se - sw) * u;
    return north + (south - north) * v;
}

// ---- ranges --------------------------------------------------------------------------------------------------------

// A trapezoid: where a value comes and where it goes, 1 between.
struct Edges {
    float begin = -1e9f, rise = 1, end = 1e9f, fall = 1;

    [[nodiscard]] float share(float value) const {
        const float up = (value - begin) * rise, down = (end - value) * fall;
        return std::clamp(up, 0.0f, 1.0f) * std::clamp(down, 0.0f, 1.0f);
    }
};
Edges edges_of(const SplatRange& range) {
    Edges edges;
    if (!range.given) return edges;
    const double half = 0.5 * std::max(range.soft, 1e-3);
    edges.rise = edges.fall = static_cast<float>(0.5 / half);
    if (!range.open_low) edges.begin = static_cast<float>(range.low - half);
    if (!range.open_high) edges.end = static_cast<float>(range.high + half);
    return edges;
}

// Of azimuths: how far from the middle, which way round ever.
struct Facing {
    float middle = 0, half = 0, per = 0;

    [[nodiscard]] float share(float azimuth) const {
        float off = std::abs(azimuth - middle);
        off = off > 180 ? 360 - off : off;
        return std::clamp((half - off) * per, 0.0f, 1.0f);
    }
};
Facing facing_of(const SplatRange& range) {
    if (!range.given) return {};
    const double wide = range.high >= range.low ? range.high - range.low : range.high - range.low + 360;
    const double soft = std::max(range.soft, 1e-3);
    return {static_cast<float>(std::fmod(range.low + 0.5 * wide, 360.0)),
            static_cast<float>(wide >= 360 ? 1e9 : 0.5 * wide + 0.5 * soft), static_cast<float>(1 / soft)};
}

struct Prepared {
    const SplatRule* rule;
    Edges height, slope, curvature, wetness, noise;
    Facing aspect;
    float opacity, ragged_m, ragged_deg;
    bool noisy;
};
std::vector<Prepared> prepared(const SplatPlan& plan) {
    std::vector<Prepared> all;
    for (const SplatRule& r : plan.rules) {
        Prepared p{&r,
                   edges_of(r.height_m),
                   edges_of(r.slope_deg),
                   edges_of(r.curvature),
                   edges_of(r.wetness),
                   edges_of(r.noise),
                   facing_of(r.aspect_deg),
                   static_cast<float>(r.opacity),
                   0,
                   0,
                   r.noise.given};
        if (r.height_m.given) p.ragged_m = static_cast<float>(r.ragged * r.height_m.soft);
        if (r.slope_deg.given) p.ragged_deg = static_cast<float>(r.ragged * r.slope_deg.soft);
        p.noisy |= p.ragged_m > 0 || p.ragged_deg > 0;
        all.push_back(p);
    }
    return all;
}

// ---- a point -------------------------------------------------------------------------------------------------------

struct Shape {
    float height_m, slope_deg, aspect_deg, curvature;
};

// The samples whose slopes and curvatures points have, and those beside that they follow from.
Window shapes_for_splat(const SplatGround& ground, const Window& points) {
    constexpr std::int32_t beside = 2; // of curvature
    const std::int32_t last_x = ground.columns - 1, last_y = ground.rows - 1;
    const std::int32_t x0 = std::clamp((points.x << ground.stride_log2) - beside, 0, last_x),
                       y0 = std::clamp((points.y << ground.stride_log2) - beside, 0, last_y);
    const std::int32_t x1 =
        std::min((std::min((points.x + points.columns - 1) << ground.stride_log2, last_x)) + beside, last_x);
    const std::int32_t y1 =
        std::min((std::min((points.y + points.rows - 1) << ground.stride_log2, last_y)) + beside, last_y);
    const std::int32_t x = std::min(x0, std::max(last_x - beside, 0)), y = std::min(y0, std::max(last_y - beside, 0));
    return {x, y, x1 - x + 1, y1 - y + 1};
}

// Slopes from the samples beside, as normal maps have them, one-sided on the rim; curvature over twice as far, which
// the noise of heights shows less in.
class Shapes {
public:
    Shapes(const SplatGround& ground, const Window& points, const float* heights_m)
        : ground_(ground),
          at_(shapes_for_splat(ground, points)), heights_{heights_m, 0, heights_for_splat(ground, points)},
          shape_(heights_m) {
        heights_.stride = heights_.at.columns;
        if (!ground.smooth.smooths()) return;
        smooth_ = smooth_heights(ground.smooth, heights_, at_);
        shape_ = smooth_.data();
    }

    [[nodiscard]] Shape of(std::int32_t x, std::int32_t y) const {
        const auto degrees = static_cast<float>(180 / std::numbers::pi);
        const std::int32_t west = std::max(x - 1, 0), east = std::min(x + 1, ground_.columns - 1);
        const std::int32_t north = std::max(y - 1, 0), south = std::min(y + 1, ground_.rows - 1);
        const float rise_east =
            (height(east, y) - height(west, y)) * static_cast<float>(1 / ((east - west) * ground_.spacing_m[0]));
        const float rise_south =
            (height(x, south) - height(x, north)) * static_cast<float>(1 / ((south - north) * ground_.spacing_m[1]));
        const float azimuth = std::atan2(-rise_east, rise_south) * degrees; // downwards, clockwise from north
        const float height_m = heights_.heights_m[(y - heights_.at.y) * heights_.stride + (x - heights_.at.x)];
        return {height_m, std::atan(std::sqrt(rise_east * rise_east + rise_south * rise_south)) * degrees,
                azimuth < 0 ? azimuth + 360 : azimuth, 0};
    }
    [[nodiscard]] float curvature(std::int32_t x, std::int32_t y) const {
        const std::int32_t west = std::max(x - 2, 0), east = std::min(x + 2, ground_.columns - 1);
        const std::int32_t north = std::max(y - 2, 0), south = std::min(y + 2, ground_.rows - 1);
        const float here = height(x, y);
        const auto per = [](double spacing_m) { return static_cast<float>(1 / (4 * spacing_m * spacing_m)); };
        const float across = (here - height(west, y) + (here - height(east, y))) * per(ground_.spacing_m[0]);
        const float down = (here - height(x, north) + (here - height(x, south))) * per(ground_.spacing_m[1]);
        return 500 * (across + down);
    }

private:
    [[nodiscard]] float height(std::int32_t x, std::int32_t y) const { // of the shape
        return shape_[static_cast<std::size_t>(y - at_.y) * static_cast<std::size_t>(at_.columns) +
                      static_cast<std::size_t>(x - at_.x)];
    }
    const SplatGround& ground_;
    Window at_; // of the shape
    HeightWindow heights_;
    Buffer<float> smooth_;
    const float* shape_;
};

// ---- rasters -------------------------------------------------------------------------------------------------------

// What each pixel shows of each of a raster's layers, added to a texel-wide row with the weights of a tent.
class Palette {
public:
    explicit Palette(const SplatRaster& raster) : raster_(raster) {}

    void add(const std::uint8_t* pixel, float weight, float* shares) const {
        if (raster_.kind == SplatRaster::Kind::weights) return add_weights(pixel, weight, shares);
        if (pixel[3] < 128) return;
        const std::uint8_t layer = raster_.kind == SplatRaster::Kind::classes
                                       ? raster_.of_class[static_cast<std::size_t>(pixel[0] | pixel[1] << 8)]
                                       : painted(pixel);
        if (layer != no_layer) shares[layer] += weight;
    }

private:
    // The nearest colour, if it is near: pictures are saved with losses.
    [[nodiscard]] std::uint8_t painted(const std::uint8_t* rgb) const {
        constexpr int near = 48;
        int least = near;
        std::uint8_t layer = no_layer;
        for (const SplatRaster::Painted& known : raster_.colours) {
            int off = 0;
            for (int c = 0; c < 3; ++c) off = std::max(off, std::abs(rgb[c] - known.rgb[c]));
            if (off < least) least = off, layer = known.layer;
        }
        return layer;
    }
    void add_weights(const std::uint8_t* pixel, float weight, float* shares) const {
        float all = 0;
        for (int c = 0; c < 4; ++c)
            if (raster_.of_channel[c] != no_layer) all += pixel[c];
        if (all <= 0) return;
        weight /= std::max(all, 255.0f);
        if (raster_.of_channel[3] == no_layer) weight *= static_cast<float>(pixel[3]) * (1.0f / 255);
        for (int c = 0; c < 4; ++c)
            if (raster_.of_channel[c] != no_layer) shares[raster_.of_channel[c]] += weight * pixel[c];
    }
    const SplatRaster& raster_;
};

TentAxis raster_axis(const SplatGround& ground, const ImageLayer& image, int axis) {
    TentAxis a;
    a.num = std::int64_t{1} << ground.stride_log2;
    a.last = (axis == 0 ? ground.columns : ground.rows) - 1.0;
    a.scale = image.per_sample[axis];
    a.shift = image.first_px[axis] - 0.5;
    a.size = axis == 0 ? image.columns : image.rows;
    return a;
}

// The points of a window that the raster covers, along one axis: one run.
Window covered(const TentAxis (&axes)[2], const Window& points) {
    Window run{points.x, points.y, 0, 0};
    const auto inside = [](const TentAxis& axis, std::int32_t g) {
        const double centre = axis.centre(g);
        return centre >= -0.5 && centre <= axis.size - 0.5;
    };
    for (std::int32_t x = points.x; x < points.x + points.columns; ++x)
        if (inside(axes[0], x) && run.columns++ == 0) run.x = x;
    for (std::int32_t y = points.y; y < points.y + points.rows; ++y)
        if (inside(axes[1], y) && run.rows++ == 0) run.y = y;
    return run;
}

// Shares of a raster's layers over a window of points, max_splat_names each. Pixels stream through row by row.
std::vector<float> raster_shares(const SplatRaster& raster, const ImageLayer& image, const SplatGround& ground,
                                 const Window& points, ImageReader& reader) {
    constexpr std::size_t n = max_splat_names;
    std::vector<float> shares(points.area() * n);
    const TentAxis axes[2] = {raster_axis(ground, image, 0), raster_axis(ground, image, 1)};
    const Window run = covered(axes, points);
    if (run.columns == 0 || run.rows == 0) return shares;
    const Taps x = make_taps(axes[0], run.x, run.columns), y = make_taps(axes[1], run.y, run.rows);
    const Palette palette(raster);
    const auto wide = static_cast<std::size_t>(x.source_end - x.source_first);
    const std::int32_t strip =
        std::clamp((1 << 19) / (x.source_end - x.source_first), 1, y.source_end - y.source_first);
    std::vector<std::uint8_t> rgba(static_cast<std::size_t>(strip) * wide * 4);
    std::vector<float> line(static_cast<std::size_t>(x.count) * n);
    for (std::int32_t row = y.source_first; row < y.source_end; ++row) {
        const std::int32_t k = row - y.source_first, in_strip = k % strip;
        if (in_strip == 0)
            reader.read(0, {x.source_first, row, static_cast<std::int32_t>(wide), std::min(strip, y.source_end - row)},
                        rgba.data());
        std::fill(line.begin(), line.end(), 0.0f);
        for (std::size_t i = 0; i < static_cast<std::size_t>(x.count); ++i)
            for (std::int32_t tap = 0; tap < x.taps; ++tap)
                if (const float w = x.weights[i * static_cast<std::size_t>(x.taps) + static_cast<std::size_t>(tap)];
                    w != 0)
                    palette.add(rgba.data() + 4 * (static_cast<std::size_t>(in_strip) * wide +
                                                   static_cast<std::size_t>(x.first[i] + tap)),
                                w, line.data() + i * n);
        for (std::size_t j = 0; j < static_cast<std::size_t>(y.count); ++j) {
            if (y.first[j] > k || y.first[j] + y.taps <= k) continue;
            const float w = y.weights[j * static_cast<std::size_t>(y.taps) + static_cast<std::size_t>(k - y.first[j])];
            float* const to = shares.data() + n * ((static_cast<std::size_t>(run.y - points.y) + j) *
                                                       static_cast<std::size_t>(points.columns) +
                                                   static_cast<std::size_t>(run.x - points.x));
            for (std::size_t i = 0; i < line.size(); ++i) to[i] += w * line[i];
        }
    }
    return shares;
}

// ---- all of a point ------------------------------------------------------------------------------------------------

class Evaluation {
public:
    Evaluation(const SplatPlan& plan, const SplatGround& ground, const Window& points, const SplatInput& in)
        : plan_(plan), ground_(ground), points_(points), rules_(prepared(plan)), shapes_(ground, points, in.heights_m) {
        for (const Prepared& p : rules_) curved_ |= p.rule->curvature.given, wet_ |= p.rule->wetness.given;
        for (std::size_t i = 0; i < plan.rasters.size(); ++i)
            rasters_.push_back(raster_shares(plan.rasters[i], in.images[i]->layers[0], ground, points, *in.readers[i]));
    }

    // i: of the point in the window.
    [[nodiscard]] Layers at(std::int32_t px, std::int32_t py, std::size_t i) const {
        const std::int32_t x = std::min(px << ground_.stride_log2, ground_.columns - 1),
                           y = std::min(py << ground_.stride_log2, ground_.rows - 1);
        Shape shape = shapes_.of(x, y);
        if (curved_) shape.curvature = shapes_.curvature(x, y);
        const float wetness = wet_ ? ground_.wetness->at(x, y) : 0;
        Layers shares{};
        float left = 1;
        for (std::size_t r = rules_.size(); r-- > 0 && left > 0;) {
            const Prepared& p = rules_[r];
            float here = left * p.opacity * p.curvature.share(shape.curvature) * p.wetness.share(wetness);
            if (here > 0 && p.rule->aspect_deg.given) // level ground faces nowhere
                here *= p.aspect.share(shape.aspect_deg) * std::min(shape.slope_deg * 0.5f, 1.0f);
            if (here <= 0) continue;
            const float noise = p.noisy ? noise_of(*p.rule, x, y) : 0.5f;
            here *= p.height.share(shape.height_m + (noise - 0.5f) * p.ragged_m) *
                    p.slope.share(shape.slope_deg + (noise - 0.5f) * p.ragged_deg) * p.noise.share(noise);
            lay(p, here, i, shares, left);
        }
        return shares;
    }

private:
    [[nodiscard]] float noise_of(const SplatRule& rule, std::int32_t x, std::int32_t y) const {
        const double east = x * ground_.spacing_m[0], south = y * ground_.spacing_m[1];
        const auto fine = static_cast<float>(rule.fine);
        float noise = 0;
        if (fine < 1) noise += (1 - fine) * splat_noise(east, south, rule.noise_m);
        if (fine > 0) noise += fine * splat_noise(east + 7777, south + 3333, rule.noise_m / 8);
        return noise;
    }
    void lay(const Prepared& p, float here, std::size_t i, Layers& shares, float& left) const {
        if (p.rule->raster < 0) {
            shares[p.rule->layer] += here;
            left -= here;
            return;
        }
        const auto raster = static_cast<std::size_t>(p.rule->raster);
        const float* const of = rasters_[raster].data() + i * max_splat_names;
        for (const std::uint8_t layer : plan_.rasters[raster].layers) {
            shares[layer] += here * of[layer];
            left -= here * of[layer];
        }
    }

    const SplatPlan& plan_;
    const SplatGround& ground_;
    Window points_;
    std::vector<Prepared> rules_;
    Shapes shapes_;
    std::vector<std::vector<float>> rasters_;
    bool curved_ = false, wet_ = false;
};

} // namespace

float splat_noise(double east_m, double south_m, double wavelength_m) {
    float sum = 0, weight = 1, all = 0;
    double x = east_m / wavelength_m, y = south_m / wavelength_m;
    for (int octave = 0; octave < 3; ++octave) {
        sum += weight * value_noise(x, y);
        all += weight;
        weight *= 0.5f;
        const double turned = 1.6 * x - 1.2 * y; // by 37 degrees and twice as fine
        y = 1.2 * x + 1.6 * y;
        x = turned;
    }
    return std::clamp((sum / all - 0.5f) * 1.8f + 0.5f, 0.0f, 1.0f);
}

Window heights_for_splat(const SplatGround& ground, const Window& points) {
    return heights_for_smooth(ground.smooth, shapes_for_splat(ground, points));
}

TexelPlanes splat_shares(const SplatPlan& plan, const SplatGround& ground, const Window& points, const SplatInput& in) {
    TexelPlanes planes(points, static_cast<int>(max_splat_names));
    planes.clear(); // of layers without a name
    const Evaluation evaluation(plan, ground, points, in);
    std::size_t i = 0;
    for (std::int32_t y = points.y; y < points.y + points.rows; ++y)
        for (std::int32_t x = points.x; x < points.x + points.columns; ++x, ++i) {
            const Layers shares = evaluation.at(x, y, i);
            for (std::size_t layer = 0; layer < plan.names.size(); ++layer) planes.channel[layer][i] = shares[layer];
        }
    return planes;
}

SplatImages open_splat_images(const SplatPlan& plan, const Frame& ground) {
    SplatImages images;
    for (const SplatRaster& raster : plan.rasters)
        images.push_back(open_raster_map(
            raster.path, ground, raster.kind == SplatRaster::Kind::classes ? RasterUse::classes : RasterUse::paint));
    return images;
}

// The rules of splat maps from JSON.

namespace {

using io::Failure;
using Json = nlohmann::json;

struct RangeKey {
    const char *name, *soft;
    SplatRange SplatRule::*field;
    double least, most; // of both numbers; an end there is open
    double most_soft, usual_soft;
    bool turns = false; // azimuths: low may be more than high
};
constexpr RangeKey range_keys[] = {
    {"height_m", "height_soft_m", &SplatRule::height_m, -1e6, 1e6, 1e6, 0},
    {"slope_deg", "slope_soft_deg", &SplatRule::slope_deg, 0, 90, 90, 0},
    {"curvature_per_km", "curvature_soft_per_km", &SplatRule::curvature, -1e6, 1e6, 1e6, 0},
    {"aspect_deg", "aspect_soft_deg", &SplatRule::aspect_deg, 0, 360, 180, 0, true},
    {"wetness", "wetness_soft", &SplatRule::wetness, -100, 100, 100, 1},
    {"noise", "noise_soft", &SplatRule::noise, 0, 1, 1, 0.1},
};
struct NumberKey {
    const char* name;
    double SplatRule::*field;
    double least, most;
};
constexpr NumberKey number_keys[] = {
    {"noise_m", &SplatRule::noise_m, 1, 1e6},
    {"fine", &SplatRule::fine, 0, 1},
    {"ragged", &SplatRule::ragged, 0, 2},
    {"opacity", &SplatRule::opacity, 0, 1},
};

bool is_number(const Json& json, double least, double most) {
    return json.is_number() && json.get<double>() >= least && json.get<double>() <= most;
}

std::optional<unsigned> whole_number(std::string_view text, int base, unsigned most) {
    unsigned value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (error != std::errc() || end != text.data() + text.size() || value > most) return {};
    return value;
}

class RuleReader {
public:
    RuleReader(const std::string& text, const std::string& file) : text_(text), file_(file) { plan_.text = text; }

    SplatPlan read() {
        const Json json = io::parse_json(text_, file_, io::JsonComments::yes);
        if (!json.is_object()) throw Failure(1, fmt::format("{}: is not a JSON object{}", file_, see));
        for (const auto& [key, value] : json.items())
            if (key != "rules" && key != "comment")
                throw Failure(1, fmt::format("{}: unknown field \"{}\"{}", file_, key, see));
        if (!json.contains("rules") || !json["rules"].is_array() || json["rules"].empty() ||
            json["rules"].size() > max_splat_rules)
            throw Failure(1,
                          fmt::format("{}: \"rules\" must be a list of 1 to {} rules{}", file_, max_splat_rules, see));
        for (const Json& rule : json["rules"]) add(rule);
        return std::move(plan_);
    }

private:
    static constexpr const char* see = "; docs/guides/materials.md has rules that work";

    [[noreturn]] void refuse(const std::string& what) const {
        throw Failure(1, fmt::format("{}:{}: rule {}{}: {}{}", file_, io::line_of_item(text_, "rules", number_),
                                     number_, name_.empty() ? "" : " (" + name_ + ")", what, see));
    }

    std::uint8_t layer_named(const Json& json, const char* where) {
        if (!json.is_string()) refuse(fmt::format("\"{}\" must name a material", where));
        const std::string name = json.get<std::string>();
        if (name.empty() || name.size() > io::max_material_name ||
            std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < ' ' || c == 127; }))
            refuse(fmt::format("\"{}\" must name a material in 1 to {} characters", where, io::max_material_name));
        const auto known = std::ranges::find(plan_.names, name);
        if (known != plan_.names.end()) return static_cast<std::uint8_t>(known - plan_.names.begin());
        if (plan_.names.size() == max_splat_names)
            refuse(fmt::format("\"{}\" would be the {}th material; a pack has {} at most", name, max_splat_names + 1,
                               max_splat_names));
        plan_.names.push_back(name);
        return static_cast<std::uint8_t>(plan_.names.size() - 1);
    }

    void add(const Json& json) {
        name_.clear();
        if (!json.is_object()) refuse("must be a JSON object");
        SplatRule rule;
        const int kinds = static_cast<int>(json.contains("layer")) + static_cast<int>(json.contains("classes")) +
                          static_cast<int>(json.contains("painted"));
        if (kinds != 1)
            refuse(kinds == 0 ? "names no layer; give \"layer\": a material, or \"classes\" or \"painted\": a raster"
                              : "\"layer\", \"classes\" and \"painted\" exclude each other; make rules of their own");
        if (json.contains("layer")) {
            rule.layer = layer_named(json["layer"], "layer");
            name_ = plan_.names[rule.layer];
        } else {
            add_raster(json);
            rule.raster = static_cast<int>(plan_.rasters.size()) - 1;
        }
        for (const auto& [key, value] : json.items()) take(json, key, value, rule);
        for (const RangeKey& known : range_keys)
            if (!(rule.*known.field).given && json.contains(known.soft) && known.field != &SplatRule::height_m &&
                known.field != &SplatRule::slope_deg && known.field != &SplatRule::noise)
                refuse(fmt::format("\"{}\" is of no use without \"{}\"", known.soft, known.name));
        plan_.rules.push_back(rule);
        ++number_;
    }

    void take(const Json& json, const std::string& key, const Json& value, SplatRule& rule) {
        for (const RangeKey& known : range_keys) {
            if (key == known.soft) {
                if (!is_number(value, 0, known.most_soft))
                    refuse(fmt::format("\"{}\" must be a number in 0..{}", key, known.most_soft));
                return;
            }
            if (key == known.name) return take_range(json, value, known, rule.*known.field);
        }
        for (const NumberKey& known : number_keys)
            if (key == known.name) {
                if (!is_number(value, known.least, known.most))
                    refuse(fmt::format("\"{}\" must be a number in {}..{}", key, known.least, known.most));
                rule.*known.field = value.get<double>();
                return;
            }
        const bool known = key == "layer" || key == "comment" || (key == "classes" && rule.raster >= 0) ||
                           (key == "layers" && json.contains("classes")) ||
                           ((key == "painted" || key == "colours" || key == "channels") && json.contains("painted"));
        if (!known) refuse(fmt::format("unknown field \"{}\"", key));
    }

    void take_range(const Json& json, const Json& value, const RangeKey& key, SplatRange& range) {
        const auto fail = [&] {
            refuse(fmt::format("\"{}\" must be two numbers in {}..{}{}, or null for no end", key.name, key.least,
                               key.most, key.turns ? ", clockwise" : ", the lower first"));
        };
        if (!value.is_array() || value.size() != 2) fail();
        double ends[2] = {key.least, key.most};
        for (std::size_t i = 0; i < 2; ++i) {
            if (value[i].is_null()) continue;
            if (!is_number(value[i], key.least, key.most)) fail();
            ends[i] = value[i].get<double>();
        }
        if (ends[0] > ends[1] && !key.turns) fail();
        range.given = true;
        range.low = ends[0], range.high = ends[1];
        range.open_low = !key.turns && ends[0] <= key.least;
        range.open_high = !key.turns && ends[1] >= key.most;
        range.soft = key.usual_soft;
        if (json.contains(key.soft) && json[key.soft].is_number()) range.soft = json[key.soft].get<double>();
    }

    void add_raster(const Json& json) {
        const bool classes = json.contains("classes");
        const char* const key = classes ? "classes" : "painted";
        if (!json[key].is_string() || json[key].get<std::string>().empty() ||
            json[key].get<std::string>().find('\0') != std::string::npos)
            refuse(fmt::format("\"{}\" must name a raster file", key));
        SplatRaster raster;
        raster.path = json[key].get<std::string>();
        name_ = raster.path;
        if (!is_gdal_name(raster.path) && std::filesystem::path(raster.path).is_relative())
            raster.path = (std::filesystem::path(file_).parent_path() / raster.path).lexically_normal().string();
        if (classes)
            read_classes(json, raster);
        else if (json.contains("colours") == json.contains("channels"))
            refuse("an image needs either \"colours\", {\"#rrggbb\": material}, or \"channels\", materials of red, "
                   "green, blue and alpha");
        else if (json.contains("colours"))
            read_colours(json["colours"], raster);
        else
            read_channels(json["channels"], raster);
        std::ranges::sort(raster.layers);
        raster.layers.erase(std::unique(raster.layers.begin(), raster.layers.end()), raster.layers.end());
        plan_.rasters.push_back(std::move(raster));
    }

    void read_classes(const Json& json, SplatRaster& raster) {
        if (!json.contains("layers") || !json["layers"].is_object() || json["layers"].empty())
            refuse("a raster of classes needs \"layers\", {\"class\": material}");
        raster.of_class.assign(65536, no_layer);
        for (const auto& [number, name] : json["layers"].items()) {
            const auto value = whole_number(number, 10, 65535);
            if (!value) refuse(fmt::format("class \"{}\" must be a whole number in 0..65535", number));
            raster.of_class[*value] = layer_named(name, "layers");
            raster.layers.push_back(raster.of_class[*value]);
        }
    }

    void read_colours(const Json& json, SplatRaster& raster) {
        raster.kind = SplatRaster::Kind::colours;
        if (!json.is_object() || json.empty() || json.size() > 64)
            refuse("\"colours\" must be 1 to 64 of {\"#rrggbb\": material}");
        for (const auto& [colour, name] : json.items()) {
            const auto value = colour.size() == 7 && colour[0] == '#'
                                   ? whole_number(std::string_view(colour).substr(1), 16, 0xffffff)
                                   : std::nullopt;
            if (!value) refuse(fmt::format("colour \"{}\" must be #rrggbb", colour));
            const std::uint8_t layer = layer_named(name, "colours");
            raster.colours.push_back(
                {{static_cast<std::uint8_t>(*value >> 16), static_cast<std::uint8_t>(*value >> 8 & 255),
                  static_cast<std::uint8_t>(*value & 255)},
                 layer});
            raster.layers.push_back(layer);
        }
    }

    void read_channels(const Json& json, SplatRaster& raster) {
        raster.kind = SplatRaster::Kind::weights;
        if (!json.is_array() || json.empty() || json.size() > 4)
            refuse("\"channels\" must be a list of 1 to 4 materials, null for a channel without");
        for (std::size_t i = 0; i < json.size(); ++i) {
            if (json[i].is_null()) continue;
            raster.of_channel[i] = layer_named(json[i], "channels");
            raster.layers.push_back(raster.of_channel[i]);
        }
        if (raster.layers.empty()) refuse("\"channels\" must name a material");
    }

    const std::string &text_, &file_;
    SplatPlan plan_;
    std::size_t number_ = 0;
    std::string name_; // of the rule that is read, for messages
};

} // namespace

std::string SplatPlan::stored_names() const {
    std::string all;
    for (const std::string& name : names) all += name + '\n';
    return all;
}

bool SplatPlan::wants_wetness() const {
    return std::ranges::any_of(rules, [](const SplatRule& rule) { return rule.wetness.given; });
}

SplatPlan parse_splat(const std::string& text, const std::string& file) {
    return RuleReader(text, file).read();
}

SplatPlan read_splat(const std::string& path) {
    return parse_splat(io::read_text(path), path);
}

} // namespace fjell::baker
