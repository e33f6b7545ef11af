// Detail layers: what near ground is made of. Materials (fjell/io/materials.h), where the pack's splat maps say
// (fjell/texture.h); for a pack without them, where rules lay them over each other, by height, steepness and noise,
// evaluated in every pixel from what the shader has.
//
// Rules are laid in order, the last one uppermost, as a painter does: each covers its opacity of what lies below it
// wherever the place is within its ranges. The first one is the ground under all of them, wherever it is asked for.
// Units: metres, degrees, and shares from 0 to 1. Ownership: plain values. Thread: any. Complexity: O(rules). Failure:
// validate() throws io::Failure, 3, which names the field, or the rule and the field, and the range.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell::gl {

inline constexpr std::uint32_t max_layer_rules = 16;
// The name in a splat map that is drawn as a lake, at any distance, unless a material is called so.
inline constexpr const char* water_layer = "water";
inline constexpr double min_layer_distance_m = 1, max_layer_distance_m = 100'000;
inline constexpr double max_layer_relief = 4;

struct LayerSettings {
    bool on = false;          // no more than Renderer::set_layers() has been given
    double distance_m = 4000; // from so far on the ground is as it was baked; from 0.4 of it on it fades. 1 to 100,000
    double tint = 0.4;        // how far a material takes on its map's colour; 0: its own, 1: the map's. 0 to 1
    bool splat = true;        // from splat maps, of a pack that has them; false: from rules all the same
    double relief = 1;        // how strongly its bumps catch the light, 0 to 4
};

// Where a range is open, it has no soft edge.
inline constexpr double open_height_m = 1e6;

struct LayerRule {
    std::uint32_t material = 0; // of Materials::records
    double height_m[2] = {-open_height_m, open_height_m};
    double height_soft_m = 0; // metres over which it comes and goes, half of them on each side of a range's end
    double slope_deg[2] = {0, 90};
    double slope_soft_deg = 0;
    double noise[2] = {0, 1}; // of noise that is anywhere between 0 and 1, mostly in the middle
    double noise_soft = 0.1;
    double fine = 0.3;   // of that noise: 0 patches of 60 m, 1 of 8 m
    double ragged = 0.5; // how much of a soft edge the noise displaces it by, 0 to 2
    double opacity = 1;
};

// Throws io::Failure, 3: "LayerSettings::tint must be a number from 0 to 1".
void validate(const LayerSettings& settings);
// 1: "rule 2: slope_deg must be two numbers from 0 to 90, the lower first". materials: how many there are.
void validate(std::span<const LayerRule> rules, std::size_t materials);

// How much of each rule shows at a place, as shaders compute it: shares[i] of rules[i], 1 in all (or none, where no
// rule is). patches, spots: the two noises there, 0 to 1; 0.5 is their middle.
void layer_shares(std::span<const LayerRule> rules, double height_m, double slope_deg, double patches, double spots,
                  std::span<double> shares);

} // namespace fjell::gl
FJELL_API_END
