// A terrain as it lies in the host's block: the tables that every method and query reads.
//
// Decoded pages lie in slots of page_capacity records, 4 bytes a vertex; the page table says which slot holds a page.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "fjell/cut.h"
#include "fjell/terrain.h"
#include "fjell/view.h"
#include "handle.h"
#include "shared/order.h"
#include "shared/record.h"

namespace fjell {

inline constexpr std::uint32_t change_log = 256; // changes that TerrainData::changed_slots remembers

struct alignas(8) PageEntry { // read at once by queries of other threads
    std::uint32_t slot;       // no_index: not loaded
    std::int32_t base;        // height scale steps its heights are counted from
};

// Ground that edits (fjell/edit.h) have changed: places from first to last, both included. step_log2: errors and
// spheres of the vertices there, of this step; heights_changed: heights, and with them what lies around the places, of
// every step; errors_changed: errors alone, around the places, of every step. holes: samples there have become holes,
// or ground.
struct GroundChange {
    SampleIndex first, last;
    int step_log2;
    bool holes;
};
inline constexpr int heights_changed = -1, errors_changed = -2;
inline constexpr std::uint32_t ground_change_log = 1024; // changes that TerrainData::changed_ground remembers

namespace edit {
struct Rect;
}
// What raise_horizons() of edit/horizon_maps.h is.
using RaiseHorizons = void (*)(const TerrainData& terrain, const edit::Rect& edited, std::uint32_t tile,
                               std::uint32_t side_log2, std::byte* blocks);

// What all ground lies between, and the largest error of a vertex: the pack's own, and more after edits.
struct GroundRange {
    float low_m = 0, high_m = 0, error_m = 0;
    std::int32_t low_steps = 0, high_steps = 0;
};

// A tile corner's steps as it is stored: they are below 0 where edits have dug below the pack's lowest ground.
[[nodiscard]] constexpr std::int32_t corner_steps(std::uint32_t stored) {
    return static_cast<std::int32_t>(stored << 1) >> 1;
}

struct EditsData; // edit/state.h
struct PaintData; // edit/paint.h
struct MapPatch;

FJELL_API_BEGIN // companions are libraries of their own, and read vertices

    struct TerrainMemory; // what loading needs (pack/memory.h)

struct TerrainData {
    BlockHead head;
    PackHeader header{};
    Tree tree;
    PageLayout pages;
    HeightScale height_scale;
    float spacing_x_m = 1, spacing_z_m = 1;
    ErrorScale errors;
    RadiusScale radii;
    std::uint32_t pages_per_tile = 0, page_capacity = 0;
    std::uint32_t slot_count = 0;
    const PageEntry* page_table = nullptr;     // tile_count * pages_per_tile
    const VertexRecord* records = nullptr;     // slot_count * page_capacity
    const std::uint32_t* slot_page = nullptr;  // what each slot holds (tile * pages_per_tile + page), or no_index
    const std::uint32_t* slot_loads = nullptr; // how often a page was loaded into each slot
    const std::uint32_t* corners = nullptr;    // corner_count of them, as stored (corner_void_bit)
    std::uint32_t corner_count = 0;            // of the tiles that there are
    // Of a sparse terrain, otherwise null: numbers of tiles and of corners by their places, row by row (no_index: there
    // is none), and places by tile numbers.
    const std::uint32_t* tile_numbers = nullptr;
    const std::uint32_t* corner_numbers = nullptr;
    const std::uint32_t* tile_places = nullptr;
    std::uint32_t pages_missing = 0;
    std::uint64_t changes = 0; // pages loaded or unloaded so far; the n-th one in slot changed_slots[n % change_log]
    const std::uint32_t* changed_slots = nullptr;
    double missing_px = 0; // Terrain::missing_px()
    // The threshold at which a stream last looked for missing pages, and the views; 0: whoever loads pages says.
    double sought_px = 0;
    View sought_view[max_cut_views];
    std::uint32_t sought_views = 0;
    TerrainMemory* memory = nullptr;
    GroundRange range;
    EditsData* edits = nullptr;       // of this terrain; they are asked when a page comes
    std::uint64_t ground_changes = 0; // so far; the n-th is changed_ground[n % ground_change_log]
    const GroundChange* changed_ground = nullptr;
    PaintData* paint = nullptr; // of edits; clients of a stream read it on their threads
    // How horizon maps follow edits; null before there are ground maps, through which mips that are read again come.
    RaiseHorizons raise_horizons = nullptr;
    // Of the stream's last update: mips that were read again because paint or the ground has changed on them.
    const MapPatch* map_patches = nullptr;
    std::uint32_t map_patch_count = 0;
    // Odd while heights change under queries of other threads; what is read meanwhile may mix ground of before and
    // after, which differ by editing_m at most (query/steady.h).
    std::uint32_t ground_epoch = 0;
    float editing_m = 0;
    bool holes_made = false; // by edits, or they may make some (EditBudget::holes)

    [[nodiscard]] std::uint32_t tile_count() const { return tiles_of(header); }
    [[nodiscard]] bool is_sparse() const { return tile_numbers != nullptr; }
    // The number of the tile at a place in the grid; no_index: there is none, so that nothing is there.
    [[nodiscard]] std::uint32_t tile_at(std::int32_t x, std::int32_t y) const {
        const std::size_t place = static_cast<std::size_t>(y) * header.tiles_x + static_cast<std::size_t>(x);
        return tile_numbers != nullptr ? tile_numbers[place] : static_cast<std::uint32_t>(place);
    }
    [[nodiscard]] bool has_tile(std::int32_t x, std::int32_t y) const {
        return tile_numbers == nullptr || tile_at(x, y) != no_index;
    }
    [[nodiscard]] SampleIndex tile_xy(std::uint32_t tile) const {
        const std::uint32_t place = tile_places != nullptr ? tile_places[tile] : tile;
        return {static_cast<std::int32_t>(place % header.tiles_x), static_cast<std::int32_t>(place / header.tiles_x)};
    }
    // The tile that a sample is read from: the one that begins there, at tile_; on the border of one that is not there
    // the neighbour to the west, the north or both that has it too.
    [[nodiscard]] SampleIndex tile_with(SampleIndex v, SampleIndex tile_) const {
        if (has_tile(tile_.column, tile_.row)) return tile_;
        const std::int32_t west = tile_.column != 0 && v.column == tile_.column * tree.side() ? 1 : 0,
                           north = tile_.row != 0 && v.row == tile_.row * tree.side() ? 1 : 0;
        if (west != 0 && has_tile(tile_.column - 1, tile_.row)) return {tile_.column - 1, tile_.row};
        if (north != 0 && has_tile(tile_.column, tile_.row - 1)) return {tile_.column, tile_.row - 1};
        if (west != 0 && north != 0 && has_tile(tile_.column - 1, tile_.row - 1))
            return {tile_.column - 1, tile_.row - 1};
        return tile_;
    }
    // The same of corners of tiles: one of a tile that there is.
    [[nodiscard]] std::uint32_t corner_at(std::int32_t x, std::int32_t y) const {
        const std::size_t place =
            static_cast<std::size_t>(y) * (header.tiles_x + std::size_t{1}) + static_cast<std::size_t>(x);
        return corner_numbers != nullptr ? corner_numbers[place] : static_cast<std::uint32_t>(place);
    }
    [[nodiscard]] std::uint32_t page_count() const { return tile_count() * pages_per_tile; }
    // In the tiles that there are: there may be some.
    [[nodiscard]] bool has_voids() const { return header.voids != 0 || holes_made; }

    // Position of a sample, one fixed float expression: the baker measures radii with the very same one.
    [[nodiscard]] float x_m(std::int32_t column) const { return static_cast<float>(column) * spacing_x_m; }
    [[nodiscard]] float z_m(std::int32_t row) const { return static_cast<float>(row) * spacing_z_m; }

    // One vertex with its numbers decoded; slow and convenient. Any vertex of the grid, also beyond the
    // terrain's rim. Tile corners have neither error nor radius. `loaded` false: its page is missing, and nothing else
    // is set. `in_tile` false: it belongs to no tile that there is; then it is a hole that stands on the terrain's
    // lowest height, so that what flies at a height over the ground has one.
    struct Vertex {
        bool loaded = false, hole = false, in_tile = true;
        std::int32_t steps = 0; // on the height scale
        std::uint8_t error_code = 0;
        float height_m = 0, error_m = 0, radius_m = 0;
    };
    [[nodiscard]] Vertex vertex(SampleIndex v) const;
    [[nodiscard]] float height_m(SampleIndex sample) const { return vertex(sample).height_m; }
    // A sample without a height. Its vertex stands on a smooth continuation of the ground around the hole.
    [[nodiscard]] bool is_hole(SampleIndex sample) const { return (has_voids() || is_sparse()) && vertex(sample).hole; }
    // Bilinear height of the full-resolution grid; positions outside are clamped to the rim, NaN to its beginning.
    // Needs their pages.
    [[nodiscard]] double ground_m(double x, double z) const;
};

FJELL_API_END

// Of one bake: the header holds the hash of the directory, and that one of every chunk. By bytes, as it is stored: it
// has no padding, and a NaN would differ from itself.
[[nodiscard]] inline bool same_pack(const PackHeader& a, const PackHeader& b) {
    // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
    return std::memcmp(&a, &b, sizeof a) == 0;
}

} // namespace fjell
