// Detail layers: which materials (fjell/io/materials.h) near ground is drawn with. In a pack with splat maps
// (fjell/texture.h) the maps decide. In a pack without them rules decide, by height, steepness and noise; the shader
// evaluates them in every pixel.
//
// Rules are applied in order, as a painter works: each covers the earlier ones with its opacity wherever the place is
// within its ranges. The first rule is the ground under all others, and applies everywhere. Units: metres, degrees, and
// shares from 0 to 1. Ownership: plain values. Thread: any. Complexity: O(rules). Failure: validate() throws
// io::Failure, 3, that names the field, or the rule and the field, and the range.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell::gl {

inline constexpr std::uint32_t max_layer_rules = 16;
// The name in a splat map that is drawn as a lake at any distance, unless a material has that name.
inline constexpr const char* water_layer = "water";
inline constexpr double min_layer_distance_m = 1, max_layer_distance_m = 100'000;
inline constexpr double max_layer_relief = 4;

struct LayerSettings {
    bool on = false; // needs Renderer::set_layers()
    // Beyond this distance the ground is as it was baked. The layers fade from 0.4 of it on. 1 to 100,000.
    double distance_m = 4000;
    // How much a material takes on the colour of the map: 0 its own, 1 the map's. 0 to 1.
    double tint = 0.4;
    // Use the pack's splat maps. False: rules decide even if the pack has splat maps.
    bool splat = true;
    double relief = 1; // how strongly its bumps catch the light, 0 to 4
};

// The value of an open end of a range. An open end has no soft edge.
inline constexpr double open_height_m = 1e6;

struct LayerRule {
    std::uint32_t material = 0; // of Materials::records
    double height_m[2] = {-open_height_m, open_height_m};
    // Width in metres of the soft edge at each end of the range, half of it on each side of the end.
    double height_soft_m = 0;
    double slope_deg[2] = {0, 90};
    double slope_soft_deg = 0;
    double noise[2] = {0, 1}; // noise is between 0 and 1, mostly near 0.5
    double noise_soft = 0.1;
    double fine = 0.3; // of that noise: 0 for patches of 60 m, 1 for patches of 8 m
    // By how much of a soft edge the noise displaces it, 0 to 2.
    double ragged = 0.5;
    double opacity = 1;
};

// Throws io::Failure, 3: "LayerSettings::tint must be a number from 0 to 1".
void validate(const LayerSettings& settings);
// 1: "rule 2: slope_deg must be two numbers from 0 to 90, the lower first". materials: their number.
void validate(std::span<const LayerRule> rules, std::size_t materials);

// How much of each rule shows at a place, as shaders compute it: shares[i] is that of rules[i]. The shares add up to 1,
// or to 0 without rules. patches, spots: the two noises at the place, 0 to 1; 0.5 is their middle.
void layer_shares(std::span<const LayerRule> rules, double height_m, double slope_deg, double patches, double spots,
                  std::span<double> shares);

} // namespace fjell::gl
FJELL_API_END
