// One vertex as it is stored and loaded: height on the vertical lattice, error and radius rounded up.
//
// Errors and radii are bfloat16: the upper half of an IEEE float (8 exponent, 7 mantissa bits), so decoding is a shift.
// They are rounded up, never to nearest, so that what they bound stays bounded (DESIGN invariant 2); the cost is at
// most 1/128 of the value.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace fjell {

struct VertexRecord {
    std::uint16_t height;   // lattice steps above base
    std::uint16_t error;    // world-space error in metres, bfloat16, rounded up
    std::uint16_t radius;   // bounding radius in metres, bfloat16, rounded up
    std::uint16_t reserved; // zero
};
static_assert(sizeof(VertexRecord) == 8 && offsetof(VertexRecord, radius) == 4,
              "VertexRecord is part of the loaded layout: change pack_version and layout_hash with it");

[[nodiscard]] constexpr float from_bfloat16(std::uint16_t upper) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(upper) << 16);
}

// The smallest storable value not below `value`. value: finite and >= 0; beyond the range it saturates to infinity.
[[nodiscard]] constexpr std::uint16_t to_bfloat16_up(double value) {
    float f = static_cast<float>(value);
    std::uint32_t bits = std::bit_cast<std::uint32_t>(f);
    if (static_cast<double>(f) < value) ++bits; // the next float up; values are not negative
    return static_cast<std::uint16_t>((bits + 0xffffu) >> 16);
}

// The vertical lattice: height = base + steps * quantum, one fixed float expression.
struct Lattice {
    float base_m = 0;
    float quantum_m = 1;
    [[nodiscard]] constexpr float height_m(std::uint16_t steps) const {
        return base_m + static_cast<float>(steps) * quantum_m;
    }
};

} // namespace fjell
