// One vertex as it is held in memory, and the scales that its numbers count on.
//
// Heights count steps of one vertical height scale over the whole terrain from their page's base, so that samples
// shared by two pages are equal bit for bit. Errors and radii are codes on geometric scales that the pack fixes:
// rounded up, never to nearest, so that what they bound stays bounded (invariant 2). Why these:
// docs/notes/records.md.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace fjell {

struct VertexRecord {
    std::uint16_t height; // height scale steps above the page's base
    std::uint8_t error;   // code on the pack's ErrorScale
    std::uint8_t radius;  // code on RadiusScale in the lower 7 bits; the highest one: a hole's vertex
};
static_assert(sizeof(VertexRecord) == 4 && offsetof(VertexRecord, radius) == 3,
              "VertexRecord is what pages decode to: change pack_version and pack_layout_hash with it");

inline constexpr std::uint8_t void_bit = 0x80;
inline constexpr std::uint32_t radius_codes = 128;
[[nodiscard]] constexpr bool is_void(VertexRecord r) {
    return (r.radius & void_bit) != 0;
}

// The vertical height scale: height = base + steps * quantum, one fixed float expression. steps: 0..max_height_steps,
// which floats hold exactly.
inline constexpr std::int32_t max_height_steps = 1 << 24;
struct HeightScale {
    float base_m = 0;
    float quantum_m = 1;
    [[nodiscard]] constexpr float height_m(std::int32_t steps) const {
        return base_m + static_cast<float>(steps) * quantum_m;
    }
};

// World-space errors in metres. Code 0 is no error at all, 1 is floor_m, each further one `ratio` times the one before,
// in float. `nesting_steps` codes are at least a factor of 1 + mu: a parent's code is its children's plus that many.
struct ErrorScale {
    float metres[256] = {};
    std::uint32_t nesting_steps = 1;

    static constexpr ErrorScale make(float floor_m, float ratio, std::uint32_t nesting_steps) {
        ErrorScale scale;
        scale.nesting_steps = nesting_steps;
        float value = floor_m;
        for (int code = 1; code < 256; ++code, value *= ratio) scale.metres[code] = value;
        return scale;
    }
    // The smallest code whose error is not below `error_m`; 255 when there is none.
    [[nodiscard]] constexpr std::uint8_t code_up(double error_m) const {
        std::uint32_t below = 0; // how many codes are; found without a branch, because none could be predicted
        for (std::uint32_t step = 128; step != 0; step /= 2)
            below += step * static_cast<std::uint32_t>(static_cast<double>(metres[below + step - 1]) < error_m);
        return static_cast<std::uint8_t>(below);
    }
    // The largest code below 255 whose error is not above `error_m`, which is at least 0. In float, as errors are:
    // half a step of 10 cm is not above 5 cm.
    [[nodiscard]] constexpr std::uint8_t code_down(float error_m) const {
        std::uint8_t code = 0;
        while (code < 254 && metres[code + 1] <= error_m) ++code;
        return code;
    }
    // The code of vertices of a level that locks keep in the mesh of any view that sees the terrain: nested, with some
    // codes left at the root for what stamps add.
    [[nodiscard]] constexpr std::uint32_t always(int level) const {
        constexpr std::uint32_t for_stamps = 8;
        return 255 - for_stamps - nesting_steps * static_cast<std::uint32_t>(level);
    }
    // What a parent's code must be at least.
    [[nodiscard]] constexpr std::uint32_t above(std::uint32_t child) const {
        return child == 0 ? 0 : child + nesting_steps;
    }
};

// Of a terrain's diagonal, the share that the error of ErrorScale::always() has on the finest level at least: a pixel
// from eighteen times as far away, at 935 pixels a radian (1,080 lines over 60 degrees).
inline constexpr double always_drawn_share = 1.0 / 50;

// A parent's sphere is larger by this factor than containment asks for: more than the roundings of a distance in float,
// so that spheres that touch nest in float arithmetic too. radius_rounding: of one such distance, and its sum.
inline constexpr double sphere_margin = 1 + 0x1p-16;
inline constexpr float radius_rounding = 1 + 0x1p-19f;

// Bounding radii: the level's own unit times ratio^code, in float.
struct RadiusScale {
    static constexpr float ratio = 1.03f;
    float factor[radius_codes] = {};

    static constexpr RadiusScale make() {
        RadiusScale scale;
        float value = 1;
        for (float& f : scale.factor) f = value, value *= ratio;
        return scale;
    }
    // The smallest code whose radius is not below `radius_m`; the last one when there is none.
    [[nodiscard]] constexpr std::uint8_t code_up(float unit_m, double radius_m) const {
        std::uint32_t low = 0, high = radius_codes - 1;
        while (low < high) {
            const std::uint32_t middle = (low + high) / 2;
            if (static_cast<double>(unit_m * factor[middle]) >= radius_m)
                high = middle;
            else
                low = middle + 1;
        }
        return static_cast<std::uint8_t>(low);
    }
};

} // namespace fjell
