#include "navmesh.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <DetourAlloc.h>
#include <DetourNavMeshQuery.h>
#include <RecastAlloc.h>

#include "nav_tile.h"

namespace server {

namespace {

// All on the thread of the ticks. Before each piece lies how long it is.
constexpr std::size_t head = alignof(std::max_align_t);
std::size_t held = 0, most = 0;
void* take(std::size_t bytes) {
    auto* const piece = static_cast<std::byte*>(std::malloc(bytes + head));
    if (piece == nullptr) return nullptr;
    *reinterpret_cast<std::size_t*>(piece) = bytes;
    held += bytes;
    most = std::max(most, held);
    return piece + head;
}
void give(void* what) {
    if (what == nullptr) return;
    std::byte* const piece = static_cast<std::byte*>(what) - head;
    held -= *reinterpret_cast<std::size_t*>(piece);
    std::free(piece);
}

} // namespace

void count_memory() {
    rcAllocSetCustom([](std::size_t bytes, rcAllocHint) { return take(bytes); }, give);
    dtAllocSetCustom([](std::size_t bytes, dtAllocHint) { return take(bytes); }, give);
}
std::size_t most_bytes() {
    return most;
}

std::string Navmesh::create(const fjell::Terrain& terrain) {
    if (terrain.spacing_x_m() != terrain.spacing_z_m()) return "Recast has square voxels, this pack no square cells";
    dtNavMeshParams p{};
    p.tileWidth = p.tileHeight = tile_cells * terrain.spacing_x_m();
    p.maxTiles = 128, p.maxPolys = 2048;
    mesh_ = dtAllocNavMesh();
    return mesh_ != nullptr && dtStatusSucceed(mesh_->init(&p)) ? "" : "no memory for the navigation mesh";
}

void Navmesh::want(const fjell::Terrain& terrain, fjell::Vec3 at_m) {
    const double tile_m = tile_cells * double(terrain.spacing_x_m());
    const int x = int(std::floor(at_m.x / tile_m)), z = int(std::floor(at_m.z / tile_m));
    for (int dz = -1; dz <= 1; ++dz)
        for (int dx = -1; dx <= 1; ++dx) {
            Tile& tile = tiles_[{x + dx, z + dz}];
            tile.terrain = &terrain;
            tile.wanted = tick_;
        }
}

int Navmesh::changed(const fjell::Terrain& terrain, std::span<const fjell::GroundRect> rects) {
    int count = 0;
    for (auto& [key, tile] : tiles_) {
        if (tile.terrain != &terrain || !tile.made || tile.changed) continue;
        const fjell::GroundRect looks_at = nav_samples(key.first, key.second);
        for (const fjell::GroundRect& r : rects)
            tile.changed =
                tile.changed || (r.first.column <= looks_at.last.column && r.last.column >= looks_at.first.column &&
                                 r.first.row <= looks_at.last.row && r.last.row >= looks_at.first.row);
        count += tile.changed;
    }
    return count;
}

bool Navmesh::done() const {
    for (const auto& [key, tile] : tiles_)
        if (!tile.made || tile.changed || finer(key, tile)) return false;
    return !tiles_.empty();
}

// A tile is made again when the error of its ground has become half of what it was, and when it is gone.
bool Navmesh::finer(Key key, const Tile& tile) const {
    if (tile.finest) return false;
    const fjell::GroundPatch now = nav_ground(*tile.terrain, key.first, key.second);
    return now.finest || now.error_m < tile.error_m / 2;
}

void Navmesh::make(Key key, Tile& tile, const fjell::Terrain& whole) {
    const NavTile built = make_nav_tile(*tile.terrain, key.first, key.second, whole);
    if (!built.made) {
        if (broken_.empty()) broken_ = "Recast could not build a tile";
        return;
    }
    const double allowed_m = double(built.error_m) + nav_allowed_m(*tile.terrain);
    char text[200];
    std::snprintf(text, sizeof text, "the navigation mesh of tile %d, %d is %.2f m off the ground, %.2f m allowed%s",
                  key.first, key.second, built.off_m, allowed_m, built.in_hole ? ", and closes a hole" : "");
    if (broken_.empty() && (built.off_m > allowed_m || (built.in_hole && built.finest))) broken_ = text;
    if (tile.ref != 0) mesh_->removeTile(tile.ref, nullptr, nullptr);
    tile.ref = 0;
    if (built.data != nullptr &&
        dtStatusFailed(mesh_->addTile(built.data, built.bytes, DT_TILE_FREE_DATA, 0, &tile.ref)))
        dtFree(built.data); // all tiles are taken
    ++(tile.made ? remade_ : made_);
    tile.made = true;
    tile.changed = false;
    tile.finest = built.finest;
    tile.error_m = built.error_m;
}

void Navmesh::tick(int most_tiles, const fjell::Terrain& whole) {
    for (auto at = tiles_.begin(); at != tiles_.end();) {
        auto& [key, tile] = *at;
        if (tile.wanted != tick_) {
            if (tile.ref != 0) mesh_->removeTile(tile.ref, nullptr, nullptr);
            dropped_ += tile.made;
            at = tiles_.erase(at);
            continue;
        }
        if (most_tiles > 0 && (!tile.made || tile.changed || finer(key, tile))) {
            make(key, tile, whole);
            --most_tiles;
        }
        ++at;
    }
    ++tick_;
}

bool Navmesh::stands(fjell::Vec3 at_m, float cell_m) const {
    dtNavMeshQuery query;
    if (dtStatusFailed(query.init(mesh_, 512))) return false;
    const float place[3] = {float(at_m.x), float(at_m.y), float(at_m.z)}, around[3] = {cell_m, 2 * cell_m, cell_m};
    const dtQueryFilter all;
    dtPolyRef found = 0;
    float nearest[3];
    return dtStatusSucceed(query.findNearestPoly(place, around, &all, &found, nearest)) && found != 0;
}

} // namespace server
