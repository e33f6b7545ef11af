// What the recursion carries from triangle to triangle: corners, and which edges were seen before.
#pragma once

#include <cstdint>

namespace fjell {

// A vertex as the recursion carries it, in one register, which compilers would make two of a struct: pack_xy of its
// place below its slot.
using Corner = std::uint64_t;
[[nodiscard]] constexpr Corner make_corner(std::uint32_t xy, std::uint32_t slot) {
    return xy | std::uint64_t{slot} << 32;
}
[[nodiscard]] constexpr std::uint32_t xy_of(Corner c) {
    return static_cast<std::uint32_t>(c);
}
[[nodiscard]] constexpr std::uint32_t slot_of(Corner c) {
    return static_cast<std::uint32_t>(c >> 32);
}

// A triangle before it is entered. even: its vertex is a centre. hypotenuse, left, right: the triangle on the other
// side of this edge comes earlier in the recursion (left: from the apex to the left end). inside: nothing is left to
// ask but the distance.
struct Kind {
    bool even, hypotenuse, left, right, inside;
};
// Of the halves: the one at the left end comes first on even levels. The edge between them was seen by the first.
[[nodiscard]] constexpr Kind left_half(Kind k) {
    return {!k.even, k.left, !k.even, k.hypotenuse, k.inside};
}
[[nodiscard]] constexpr Kind right_half(Kind k) {
    return {!k.even, k.right, k.hypotenuse, k.even, k.inside};
}
[[nodiscard]] constexpr Kind inside(Kind k) {
    return {k.even, k.hypotenuse, k.left, k.right, true};
}

} // namespace fjell
