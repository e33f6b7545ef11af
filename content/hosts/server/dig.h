// A crater under a walker: only the tiles of the navigation mesh that look at it are made again.
#pragma once

#include <string>
#include <vector>

#include "navmesh.h"
#include "zones.h"

namespace server {

struct Dug {
    std::string broken;                    // the promise that was; empty: none
    int tiles = 0, touched = 0, again = 0; // wanted, in reach of the crater, and made again
    std::vector<double> ms;                // what each of those took
};

// The first walker of that zone stands still. whole: the same ground in memory, which gets the same crater. The zone's
// loader runs.
[[nodiscard]] Dug dig(Zone& zone, ground::Yardstick& whole, Navmesh& navmesh);

} // namespace server
