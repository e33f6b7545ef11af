// Grounds to fly over, without a terrain.
#pragma once

#include <cmath>

#include "session/path.h"

namespace fjell::test {

// 9 x 7 km at height 0.
[[nodiscard]] inline session::Ground plain() {
    session::Ground ground;
    ground.extent_x_m = 9000;
    ground.extent_z_m = 7000;
    ground.cell_m = 30;
    return ground;
}

// Three ridges across; the extents differ, as do the metres of a cell along them.
[[nodiscard]] inline session::Ground ridges() {
    session::Ground ground;
    ground.extent_x_m = 40000;
    ground.extent_z_m = 20000;
    ground.cell_m = 50;
    ground.height_m = [](double x, double z) { return 800 + 700 * std::sin(x / 2000) + 100 * std::cos(z / 700); };
    return ground;
}

} // namespace fjell::test
