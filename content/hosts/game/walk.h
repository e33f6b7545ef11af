// What stands and looks on the ground: a walker, a drone above, the parts of a large picture.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <fjell/fjell.h>

namespace game {

// 1.8 m above the ground at that place, looking ahead. Before its pages are loaded the ground is coarse.
[[nodiscard]] fjell::View walker(const fjell::Terrain& terrain, double x_m, double z_m, fjell::Vec3 ahead);
// From above and behind, at the same place.
[[nodiscard]] fjell::View drone(const fjell::View& walker);
// The part-th of so many upright strips of a picture: the same eye, other tangents.
[[nodiscard]] fjell::View strip(const fjell::View& whole, std::uint32_t part, std::uint32_t parts);
// How far the walker sees, in metres; most_m: nothing in the way.
[[nodiscard]] double sight_m(const fjell::Terrain& terrain, const fjell::View& walker, double most_m);
// What digs a crater where a camera looks: its radius is 4 samples, and 3 m at least. None: nothing is in the way.
[[nodiscard]] std::optional<fjell::Stamp> crater_ahead(const fjell::Terrain& terrain, const fjell::View& view,
                                                       double most_m);
// The sample to the north-west of a place.
[[nodiscard]] fjell::SampleIndex sample_at(const fjell::Terrain& terrain, fjell::Vec3 place_m);
// Heights around a sample, 33 a side, for a collider of the physics engine. error_m: how wrong they may still be.
[[nodiscard]] std::vector<float> collider(const fjell::Terrain& terrain, fjell::SampleIndex middle, float& error_m);

} // namespace game
