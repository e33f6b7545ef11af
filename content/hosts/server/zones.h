// Where the focus points are: 64 of them walk, 8 in each of 8 zones.
#pragma once

#include <cmath>
#include <memory>
#include <numbers>

#include <fjell/fjell.h>

#include "../game/loader.h"
#include "../ground/streamed_ground.h"

namespace server {

inline constexpr int zones = 8;
inline constexpr double tick_s = 0.1;                     // of the walkers' time
inline constexpr int zone_walkers = fjell::max_cut_views; // a stream looks through so many views

// A stream has 8 views, so that each zone has a terrain, a stream and a loader of its own, all over one file. Their
// pages are few: what is far from a zone's walkers is coarse in its terrain.
struct Zone {
    ground::StreamedGround ground;
    std::unique_ptr<game::Loader> loader; // ends before the stream
};

// Where a walker is at a time. On any thread: it is a function of the time alone. y is 0.
[[nodiscard]] inline fjell::Vec3 walker_at(const fjell::Terrain& terrain, int zone, int walker, double now_s) {
    const double wide_m = double(terrain.extent_x_m()) / 4, deep_m = double(terrain.extent_z_m()) / 2;
    const double angle = now_s / 40 + 2 * std::numbers::pi * walker / zone_walkers;
    return {wide_m * (zone % 4 + 0.5 + 0.4 * std::cos(angle)), 0,
            deep_m * (zone / 4 + 0.5 + 0.4 * std::sin(angle * (1 + walker % 3)))};
}

} // namespace server
