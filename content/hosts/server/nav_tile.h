// One tile of a navigation mesh, from a ground patch.
#pragma once

#include <fjell/fjell.h>

namespace server {

inline constexpr int tile_cells = 32; // of the terrain, a side

// What a tile became. data: for dtNavMesh::addTile(DT_TILE_FREE_DATA), or nullptr: nobody can stand there.
struct NavTile {
    bool made = false; // false: Recast had no memory
    unsigned char* data = nullptr;
    int bytes = 0;
    float error_m = 0; // of the ground that it was made from
    bool finest = false;
    double off_m = 0;     // how far a vertex is from the full-resolution ground at most
    bool in_hole = false; // a vertex is over a hole
};

// What the ground of a tile is now: to see whether it has become finer.
[[nodiscard]] fjell::GroundPatch nav_ground(const fjell::Terrain& terrain, int x, int z);

// The samples that a tile is made from: beyond its border too.
[[nodiscard]] fjell::GroundRect nav_samples(int x, int z);

// How far a vertex may be from the ground that it was made from: Recast counts in voxels, and agents climb.
[[nodiscard]] double nav_allowed_m(const fjell::Terrain& terrain);

// x, z: which tile. whole: the yardstick. Recast's working memory comes and goes with the call.
[[nodiscard]] NavTile make_nav_tile(const fjell::Terrain& terrain, int x, int z, const fjell::Terrain& whole);

} // namespace server
