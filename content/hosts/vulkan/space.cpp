#include "space.h"

#include <cmath>

namespace vulkan {

bool Origin::follow(Vector eye_m, const fjell::Terrain& terrain) {
    const Vector off{eye_m.x - position_m_.x, eye_m.y - position_m_.y, eye_m.z - position_m_.z};
    if (placed_ && std::hypot(off.x, off.y, off.z) < rebase_m) return false;
    const double dx = terrain.header().spacing_m[0], dz = terrain.header().spacing_m[1];
    column_ = std::int32_t(std::floor(eye_m.x / dx));
    row_ = std::int32_t(std::floor(-eye_m.y / dz));
    position_m_ = {column_ * dx, -row_ * dz, std::floor(eye_m.z)}; // a whole number: a float holds it
    placed_ = true;
    return true;
}

std::array<float, 3> Origin::relative(Vector place_m) const {
    return {float(place_m.x - position_m_.x), float(place_m.y - position_m_.y), float(place_m.z - position_m_.z)};
}

std::array<float, 16> clip_from_world(const fjell::View& view, const Origin& origin) {
    const Vector ahead = from_scene(view.forward), up = from_scene(view.up),
                 right = from_scene(fjell::cross(view.forward, view.up));
    const double wide = view.right - view.left, high = view.top - view.bottom;
    const auto row = [&](Vector along, double times, double off, double of_ahead) {
        return std::array<double, 4>{along.x * times - ahead.x * of_ahead, along.y * times - ahead.y * of_ahead,
                                     along.z * times - ahead.z * of_ahead, off};
    };
    std::array<double, 4> rows[4] = {row(right, 2 / wide, 0, (view.right + view.left) / wide),
                                     row(up, 2 / high, 0, (view.top + view.bottom) / high),
                                     {0, 0, 0, view.near_m},
                                     {ahead.x, ahead.y, ahead.z, 0}};
    const Vector from = origin.position_m(), eye = from_scene(view.eye_m);
    const double eye_m[] = {eye.x - from.x, eye.y - from.y, eye.z - from.z}; // in doubles: both may be far away
    std::array<float, 16> columns{};
    for (std::size_t r = 0; r < 4; ++r) {
        for (std::size_t c = 0; c < 3; ++c) {
            rows[r][3] -= rows[r][c] * eye_m[c];
            columns[4 * c + r] = float(rows[r][c]);
        }
        columns[12 + r] = float(rows[r][3]);
    }
    return columns;
}

} // namespace vulkan
