// Where a flight begins that nobody has told where to: over all of a terrain, and of a sparse pack set, whose middle
// may be empty, over the ground nearest to it.
#pragma once

#include <functional>

#include "fjell/terrain.h"

namespace fjell::session {

// In metres, from sample (0, 0).
struct Area {
    double x_m = 0, z_m = 0, width_m = 1, depth_m = 1;
    [[nodiscard]] double longer_m() const { return width_m > depth_m ? width_m : depth_m; }
};

// A rectangle around the ground of neighbouring tiles, the one nearest to the middle among them; a terrain that is not
// sparse: all of it. has_ground: asked of 33 x 33 places a tile, of tiles from the middle on until one has some and of
// at most 256 beside that.
[[nodiscard]] Area start_area(const Terrain& terrain, const std::function<bool(double x_m, double z_m)>& has_ground);
// A rectangle around all tiles that are there.
[[nodiscard]] Area area_of_tiles(const Terrain& terrain);

} // namespace fjell::session
