#include "ground_shape.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace physics {

float GroundShape::make(const fjell::Terrain& terrain, fjell::SampleIndex first) {
    constexpr std::size_t count = std::size_t{patch_side} * patch_side;
    m_shapeType = FAST_CONCAVE_MESH_PROXYTYPE;
    setMargin(ground_margin_m);
    first_ = first;
    spacing_x_m_ = terrain.spacing_x_m(), spacing_z_m_ = terrain.spacing_z_m();
    heights_m_.resize(count);
    bool holes[count];
    const auto started = std::chrono::steady_clock::now();
    const fjell::GroundPatch patch = fjell::ground_patch(terrain, first, 0, patch_side, heights_m_, holes);
    const std::chrono::duration<float, std::micro> took = std::chrono::steady_clock::now() - started;
    error_m_ = patch.error_m;
#ifdef PLANT_NOT_HELD
    error_m_ = 0;
#endif
    finest_ = patch.finest;
    holes_.assign(holes, holes + count);
#ifdef PLANT_CLOSED_HOLES
    std::fill(holes_.begin(), holes_.end(), std::uint8_t{0});
#endif
    // Near zero floats are finest: what is far from the scene's origin lies in the transform of the body.
    const auto [low, high] = std::minmax_element(heights_m_.begin(), heights_m_.end());
    base_m_ = *low;
    high_m_ = *high - *low;
    for (float& height_m : heights_m_) height_m -= static_cast<float>(base_m_);
    float rise_x_m = 0, rise_z_m = 0;
    for (std::size_t i = 0; i + patch_side < count; ++i) { // along both sides of a cell
        if (i % patch_side != patch_cells) rise_x_m = std::max(rise_x_m, std::abs(heights_m_[i + 1] - heights_m_[i]));
        rise_z_m = std::max(rise_z_m, std::abs(heights_m_[i + patch_side] - heights_m_[i]));
    }
    steepest_ = std::hypot(rise_x_m / spacing_x_m_, rise_z_m / spacing_z_m_);
    return took.count();
}

btVector3 GroundShape::sample(int x, int y) const {
    return {static_cast<float>(x) * spacing_x_m_, heights_m_[static_cast<std::size_t>(y * patch_side + x)],
            static_cast<float>(y) * spacing_z_m_};
}

void GroundShape::process(btTriangleCallback* callback, int id, const int (&corners)[3][2]) const {
    btVector3 triangle[3];
    for (int k = 0; k < 3; ++k) {
        const auto [x, y] = corners[k];
        if (holes_[static_cast<std::size_t>(y * patch_side + x)] != 0) return; // the ground is open here
        triangle[k] = sample(x, y);
    }
    callback->processTriangle(triangle, 0, id);
}

// Called for each body near the ground in every step: only the cells under the body's box are looked at.
void GroundShape::processAllTriangles(btTriangleCallback* callback, const btVector3& low, const btVector3& high) const {
    const auto cell = [](float at_m, float spacing_m) {
        return static_cast<int>(std::clamp(std::floor(at_m / spacing_m), -1.0f, static_cast<float>(patch_cells)));
    };
    const int from_x = std::max(cell(low.x(), spacing_x_m_), 0), from_y = std::max(cell(low.z(), spacing_z_m_), 0);
    const int to_x = std::min(cell(high.x(), spacing_x_m_), patch_cells - 1);
    const int to_y = std::min(cell(high.z(), spacing_z_m_), patch_cells - 1);
    for (int y = from_y; y <= to_y; ++y)
        for (int x = from_x; x <= to_x; ++x) {
            const int id = 2 * (y * patch_cells + x);
            // The vertices of a vertex tree have their diagonals from the even corner to the odd one: from north-west
            // to south-east where column and row have an even sum, counted in the terrain and not in the patch.
            bool falling = ((first_.column + x + first_.row + y) & 1) == 0;
#ifdef PLANT_WRONG_DIAGONALS
            falling = true;
#endif
            if (falling) {
                process(callback, id, {{x, y}, {x, y + 1}, {x + 1, y + 1}});
                process(callback, id + 1, {{x, y}, {x + 1, y + 1}, {x + 1, y}});
            } else {
                process(callback, id, {{x, y}, {x, y + 1}, {x + 1, y}});
                process(callback, id + 1, {{x + 1, y}, {x, y + 1}, {x + 1, y + 1}});
            }
        }
}

void GroundShape::getAabb(const btTransform& at, btVector3& low, btVector3& high) const {
    const btVector3 margin(getMargin(), getMargin(), getMargin()); // a patch is never turned
    low = at.getOrigin() - margin;
    high = at.getOrigin() + margin +
           btVector3(patch_cells * spacing_x_m_, high_m_, static_cast<float>(patch_cells) * spacing_z_m_);
}

} // namespace physics
