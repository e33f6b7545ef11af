#include "walk.h"

#include <algorithm>
#include <cmath>

namespace game {

fjell::View walker(const fjell::Terrain& terrain, double x_m, double z_m, fjell::Vec3 ahead) {
    const fjell::GroundHeight ground = fjell::ground_height(terrain, x_m, z_m);
    const double eye_m = ground.height_m + ground.error_m + 1.8; // never below what may still come
    return fjell::make_view({x_m, eye_m, z_m}, ahead, {0, 1, 0}, 1.0, 640, 360, 0.5, 1e5);
}

fjell::View drone(const fjell::View& walker) {
    const fjell::Vec3 ahead = walker.forward, from = walker.eye_m + fjell::Vec3{-4000 * ahead.x, 2500, -4000 * ahead.z};
    return fjell::make_view(from, {ahead.x, -0.35, ahead.z}, {0, 1, 0}, 1.0, walker.width_px, walker.height_px, 0.5,
                            1e5);
}

fjell::View strip(const fjell::View& whole, std::uint32_t part, std::uint32_t parts) {
    fjell::View view = whole; // tangents divide evenly, angles would not
    const double width = (whole.right - whole.left) / parts;
    view.left = whole.left + width * part;
    view.right = view.left + width;
    view.width_px = whole.width_px / parts;
    return view;
}

double sight_m(const fjell::Terrain& terrain, const fjell::View& walker, double most_m) {
    const fjell::GroundHit hit = fjell::cast_ray(terrain, walker.eye_m, walker.forward, most_m);
    return hit.hit ? hit.distance_m : most_m;
}

std::optional<fjell::Stamp> crater_ahead(const fjell::Terrain& terrain, const fjell::View& view, double most_m) {
    const fjell::GroundHit hit = fjell::cast_ray(terrain, view.eye_m, view.forward, most_m);
    if (!hit.hit) return {};
    fjell::Stamp crater;
    crater.shape = fjell::StampShape::crater;
    crater.x_m = hit.position_m.x, crater.z_m = hit.position_m.z;
    crater.radius_m = float(std::max({3.0, 4 * terrain.header().spacing_m[0], 4 * terrain.header().spacing_m[1]}));
    crater.falloff_m = crater.radius_m / 2, crater.amount_m = crater.radius_m / 3;
    return crater;
}

fjell::SampleIndex sample_at(const fjell::Terrain& terrain, fjell::Vec3 place_m) {
    return {static_cast<std::int32_t>(std::floor(place_m.x / terrain.header().spacing_m[0])),
            static_cast<std::int32_t>(std::floor(place_m.z / terrain.header().spacing_m[1]))};
}

std::vector<float> collider(const fjell::Terrain& terrain, fjell::SampleIndex middle, float& error_m) {
    std::vector<float> heights_m(33 * 33);
    error_m = fjell::ground_patch(terrain, middle - fjell::SampleIndex{16, 16}, 0, 33, heights_m).error_m;
    return heights_m;
}

} // namespace game
