// The host's world, as many engines have it: right-handed, x east, y north, z up, metres, positions in doubles. On the
// GPU they are floats that count from an origin, and the origin follows the eye. Fjell's scene: x east, y up, z south.
//
// Thread: any. Fails never.
#pragma once

#include <array>
#include <cstdint>

#include <fjell/fjell.h>

namespace vulkan {

// A place or a direction of the host's.
struct Vector {
    double x = 0, y = 0, z = 0; // east, north, up
};
[[nodiscard]] constexpr fjell::Vec3 to_scene(Vector v) {
    return {v.x, v.z, -v.y};
}
[[nodiscard]] constexpr Vector from_scene(fjell::Vec3 v) {
    return {v.x, -v.z, v.y};
}

// Where positions on the GPU count from: a sample, so that columns and rows are counted in whole numbers, and a height.
class Origin {
public:
    // Moves to the eye if it is farther away than this. True: it has.
    bool follow(Vector eye_m, const fjell::Terrain& terrain);
    [[nodiscard]] Vector position_m() const { return position_m_; }
    [[nodiscard]] std::int32_t column() const { return column_; }
    [[nodiscard]] std::int32_t row() const { return row_; }
    [[nodiscard]] std::array<float, 3> relative(Vector place_m) const; // rounded to float once, when it is small

private:
    bool placed_ = false;
    std::int32_t column_ = 0, row_ = 0;
    Vector position_m_;
};
inline constexpr double rebase_m = 1000; // floats are steps of 2^-14 m there

// From positions that count from the origin to clip space, column by column. Depth is reversed, and there is no far
// plane: near / depth is how far a place is along the direction of sight, 0 is infinitely far. y points up in clip
// space: Vulkan's viewport is given a negative height.
[[nodiscard]] std::array<float, 16> clip_from_world(const fjell::View& view, const Origin& origin);

} // namespace vulkan
