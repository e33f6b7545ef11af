// Colours by height and steepness: for terrain without an image, and where an image has no pixels.
//
// Flat ground has the colour of `stops` (linear between them, constant outside). Steeper ground passes from one layer
// to the next: up to `from_degrees` it has the colour of the layer before, from `degrees` on this one's; between, in
// proportion to the cosine of its steepness. All in sRGB.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fjell::baker {

struct Ramp {
    struct Stop {
        double height_m;
        double rgb[3]; // 0..255
        friend bool operator==(const Stop&, const Stop&) = default;
    };
    struct Layer {
        double from_degrees, degrees;
        std::vector<Stop> stops; // one: the same colour at every height
        friend bool operator==(const Layer&, const Layer&) = default;
    };
    std::vector<Stop> stops;
    bool relative = false; // heights are 0..1 of the terrain's range
    std::vector<Layer> slopes;
    friend bool operator==(const Ramp&, const Ramp&) = default;
};
// content/README.md has the format. Throws Failure.
[[nodiscard]] Ramp read_ramp(const std::string& path);
[[nodiscard]] Ramp parse_ramp(const std::string& text, const std::string& name); // name: of the file, for messages
// Meadow, forest, scree, rock and snow over the terrain's range of heights: content/ramps/alpine.json.
[[nodiscard]] Ramp default_ramp();
// The default for terrain of that range, in metres. Heights below 0 are taken for water: content/ramps/sea.json, with
// the default ramp above it if there is land, or over all of the range.
[[nodiscard]] Ramp default_ramp(double least_m, double most_m);
// The ramp in metres for terrain of that range; one that is in metres already comes back as it is.
[[nodiscard]] Ramp absolute(const Ramp& ramp, double least_m, double most_m);

// A ramp in metres, ready to be asked for many texels. Remembers where it was: one a thread.
class RampPainter {
public:
    explicit RampPainter(const Ramp& ramp);
    // up: the normal's. rgb: sRGB, 0..255. O(1) where heights change little from call to call.
    void paint(float height_m, float up, float (&rgb)[3]);
    // The same of many texels side by side, as light 0..1: to[c][i] is bit for bit what light_of_srgb makes of paint().
    void paint_light(const float* heights_m, const float* up, std::size_t count, float* const (&to)[3]) const;

private:
    struct Piece; // of a row
    struct Stop {
        float height_m, rgb[3], per_metre[3]; // towards the next one
    };
    struct Layer {
        float from_up, per_up; // no part of it above from_up, all of it at from_up - 1 / per_up
        std::vector<Stop> stops;
        std::size_t at = 0;
    };
    static std::vector<Stop> prepare(const std::vector<Ramp::Stop>& stops);
    static void ask(Layer& layer, float height_m, float (&rgb)[3]);
    static void ask(const Layer& layer, const Piece& piece, float* const (&rgb)[3]);
    void paint_piece(Piece& piece, float* const (&to)[3]) const;
    std::vector<Layer> layers_;
};

// 0..1 of light for 0..255 of sRGB: straight between whole codes, which is within 10^-5 of the curve.
class LightOfSrgb {
public:
    [[nodiscard]] static const LightOfSrgb& table();
    [[nodiscard]] float at(float code) const {
        const auto v = static_cast<std::size_t>(static_cast<std::int32_t>(code));
        return light_[v] + (light_[v + 1] - light_[v]) * (code - static_cast<float>(static_cast<std::int32_t>(code)));
    }
    void replace(float* codes, std::size_t count) const; // by their light

private:
    LightOfSrgb();
    std::array<float, 257> light_{};
};
[[nodiscard]] inline float light_of_srgb(float code) {
    return LightOfSrgb::table().at(code);
}
// And back; light in 65,535ths.
[[nodiscard]] const std::uint8_t* srgb_of_light(); // 65,536 codes

// log2 texels a side that keep a source of that many pixels a tile: at most max_log2.
[[nodiscard]] std::uint32_t fitting_log2(double texels_per_tile, std::uint32_t max_log2);

} // namespace fjell::baker
