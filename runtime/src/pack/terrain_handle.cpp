// What a host may ask a terrain by its handle.
#include "pack/terrain_data.h"

namespace fjell {

namespace {

// What a refused handle answers from.
const TerrainData& shown(const Terrain& terrain) {
    static constexpr TerrainData none = [] {
        TerrainData t{};
        t.spacing_x_m = t.spacing_z_m = 0;
        return t;
    }();
    const TerrainData* const found = find(terrain);
    return found != nullptr ? *found : none;
}

} // namespace

bool Terrain::valid() const {
    return find(*this) != nullptr;
}
const PackHeader& Terrain::header() const {
    return shown(*this).header;
}
std::uint32_t Terrain::columns() const {
    return header().columns;
}
std::uint32_t Terrain::rows() const {
    return header().rows;
}
float Terrain::spacing_x_m() const {
    return shown(*this).spacing_x_m;
}
float Terrain::spacing_z_m() const {
    return shown(*this).spacing_z_m;
}
float Terrain::x_m(std::int32_t column) const {
    return shown(*this).x_m(column);
}
float Terrain::z_m(std::int32_t row) const {
    return shown(*this).z_m(row);
}
float Terrain::extent_x_m() const {
    const TerrainData& t = shown(*this);
    return t.header.columns == 0 ? 0 : t.x_m(static_cast<std::int32_t>(t.header.columns) - 1);
}
float Terrain::extent_z_m() const {
    const TerrainData& t = shown(*this);
    return t.header.rows == 0 ? 0 : t.z_m(static_cast<std::int32_t>(t.header.rows) - 1);
}
bool Terrain::has_voids() const {
    return shown(*this).has_voids() || shown(*this).is_sparse();
}
std::uint32_t Terrain::tile_count() const {
    return shown(*this).tile_count();
}
std::uint32_t Terrain::tile_at(Coord place) const {
    const TerrainData& t = shown(*this);
    if (place.x < 0 || place.y < 0 || place.x >= t.tree.tiles_x || place.y >= t.tree.tiles_y) return no_tile;
    static_assert(no_tile == no_index);
    return t.tile_at(place.x, place.y);
}
Coord Terrain::tile_place(std::uint32_t tile) const {
    const TerrainData& t = shown(*this);
    return tile < t.tile_count() ? t.tile_xy(tile) : Coord{-1, -1};
}
std::uint32_t Terrain::pages_per_tile() const {
    return shown(*this).pages_per_tile;
}
std::uint32_t Terrain::page_count() const {
    return shown(*this).page_count();
}
std::uint32_t Terrain::page_slots() const {
    return shown(*this).slot_count;
}
std::uint32_t Terrain::pages_loaded() const {
    return page_count() - pages_missing();
}
std::uint32_t Terrain::pages_missing() const {
    return shown(*this).pages_missing;
}
double Terrain::missing_px() const {
    return shown(*this).missing_px;
}

} // namespace fjell
