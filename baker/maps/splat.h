// Splat maps: which materials lie at a place, and how much of each shows, from rules over the ground's shape and from
// rasters of classes or paint.
//
// Rules are laid in order, the last one uppermost, as a painter does: each covers its opacity of what lies below it
// wherever the place is within its ranges. A rule with a raster lays the raster's materials where it has any. Ground
// that no rule covers keeps its colour map alone.
//
// A point's shares follow from its place, the heights around it, rasters and one coarse grid of wetness: never from the
// tile that it is computed for. So borders are equal bit for bit. Units: metres, degrees, shares from 0 to 1. Thread:
// pure functions. Complexity: O(points * rules).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "baker/maps/image.h"
#include "baker/maps/smooth.h"
#include "baker/maps/tent.h"
#include "baker/maps/wetness.h"
#include "fjell/texture.h"

namespace fjell::baker {

inline constexpr std::size_t max_splat_rules = 32;
inline constexpr std::uint8_t no_layer = 255;

// A value's range with soft edges: half of `soft` lies on each side of an end. An open end has no edge.
struct SplatRange {
    bool given = false;
    double low = 0, high = 0, soft = 0;
    bool open_low = true, open_high = true;
};

struct SplatRule {
    std::uint8_t layer = no_layer; // of SplatPlan::names; none: the raster says
    int raster = -1;               // of SplatPlan::rasters; -1: none
    SplatRange height_m, slope_deg;
    SplatRange curvature;  // 1 / km, the mean of both directions: ridges above 0, hollows below
    SplatRange aspect_deg; // the azimuth that the ground falls towards; low may be more than high: through north
    SplatRange wetness;    // wetness.h
    SplatRange noise;      // 0 to 1, mostly in the middle
    double noise_m = 500;  // wavelength of its patches
    double fine = 0.3;     // of the noise: 0 patches, 1 spots of an eighth
    double ragged = 0.5;   // how much of a soft edge of height and slope noise displaces it by
    double opacity = 1;
};

// What pixels stand for.
struct SplatRaster {
    enum class Kind : std::uint8_t { classes, colours, weights };
    Kind kind = Kind::classes;
    std::string path;
    std::vector<std::uint8_t> of_class; // classes: 65,536 layers, no_layer: none
    struct Painted {
        std::uint8_t rgb[3], layer;
    };
    std::vector<Painted> colours;
    std::uint8_t of_channel[4] = {no_layer, no_layer, no_layer, no_layer}; // weights: red, green, blue, alpha
    std::vector<std::uint8_t> layers;                                      // all that it may show
};

struct SplatPlan {
    std::vector<std::string> names; // of materials
    std::vector<SplatRule> rules;
    std::vector<SplatRaster> rasters;
    std::string text; // of the file

    // As the pack stores them: each ends with a newline.
    [[nodiscard]] std::string stored_names() const;
    [[nodiscard]] bool wants_wetness() const;
};

// Rules of a JSON file (docs/guides/materials.md); names of rasters start at its folder. Throws Failure 1, one line
// with file, line and rule.
[[nodiscard]] SplatPlan parse_splat(const std::string& text, const std::string& file);
[[nodiscard]] SplatPlan read_splat(const std::string& path);

// The plan's rasters, each ready to be read over the ground. Throws Failure 1: no such file, or one that lies
// elsewhere.
using SplatImages = std::vector<std::unique_ptr<ImageSource>>;
[[nodiscard]] SplatImages open_splat_images(const SplatPlan& plan, const Frame& ground);
// One a thread.
using SplatReaders = std::vector<std::unique_ptr<ImageReader>>;

// Points: every (1 << stride_log2)-th sample, the last ones on the rim.
struct SplatGround {
    std::int32_t columns = 0, rows = 0; // of samples
    double spacing_m[2] = {1, 1};
    int stride_log2 = 0;
    const Wetness* wetness = nullptr; // where a rule asks for it
    SmoothGround smooth{};            // what slopes and curvatures are taken from; the heights themselves by default
};
// The samples that a window of points is made from.
[[nodiscard]] Window heights_for_splat(const SplatGround& ground, const Window& points);
// Of each point a share for each of max_splat_names names. heights_m: heights_for_splat(). images, readers: of each
// raster.
struct SplatInput {
    const float* heights_m;
    const SplatImages& images;
    SplatReaders& readers;
};
[[nodiscard]] TexelPlanes splat_shares(const SplatPlan& plan, const SplatGround& ground, const Window& points,
                                       const SplatInput& in);

// Noise from 0 to 1 at a place in metres, with patches of about that wavelength.
[[nodiscard]] float splat_noise(double east_m, double south_m, double wavelength_m);

} // namespace fjell::baker
