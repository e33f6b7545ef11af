// A navigation mesh around some walkers, whose tiles follow them and the ground.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>

#include <DetourNavMesh.h>

#include <fjell/fjell.h>

namespace server {

class Navmesh {
public:
    Navmesh() = default;
    ~Navmesh() { dtFreeNavMesh(mesh_); }
    Navmesh(const Navmesh&) = delete;
    Navmesh& operator=(const Navmesh&) = delete;

    // Empty, or one sentence.
    [[nodiscard]] std::string create(const fjell::Terrain& terrain);
    // A walker of that terrain is there: the 3 x 3 tiles around it are wanted until the next tick.
    void want(const fjell::Terrain& terrain, fjell::Vec3 at_m);
    // The ground of that terrain has changed there: tiles that look at a sample in one of these are made again. Returns
    // how many.
    int changed(const fjell::Terrain& terrain, std::span<const fjell::GroundRect> rects);
    // Makes up to `most` tiles that are missing or whose ground has changed or become finer, and drops what nobody
    // wants.
    void tick(int most, const fjell::Terrain& whole);
    // There is a polygon within a cell of that place.
    [[nodiscard]] bool stands(fjell::Vec3 at_m, float cell_m) const;

    [[nodiscard]] std::uint64_t made() const { return made_; }
    [[nodiscard]] std::uint64_t remade() const { return remade_; }
    [[nodiscard]] std::uint64_t dropped() const { return dropped_; }
    [[nodiscard]] bool done() const; // every wanted tile is made, from the ground as it is
    [[nodiscard]] const std::string& broken() const { return broken_; }

private:
    struct Tile {
        const fjell::Terrain* terrain = nullptr; // whose ground
        dtTileRef ref = 0;
        bool made = false, finest = false, changed = false;
        float error_m = 0;
        std::uint64_t wanted = 0;
    };
    using Key = std::pair<int, int>;
    bool finer(Key key, const Tile& tile) const;
    void make(Key key, Tile& tile, const fjell::Terrain& whole);

    dtNavMesh* mesh_ = nullptr;
    std::map<Key, Tile> tiles_;
    std::uint64_t tick_ = 0, made_ = 0, remade_ = 0, dropped_ = 0;
    std::string broken_;
};

// Bytes that Recast and Detour hold at most, counted from the first call of count_memory() on.
void count_memory();
[[nodiscard]] std::size_t most_bytes();

} // namespace server
