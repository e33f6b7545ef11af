// Normal maps of moving ground (fjell/edit.h): the texels over heights that have changed are made anew.
//
// The maps of a pack have the normals of the pack's ground. After each update of edits and stream, update_ground_maps()
// makes patches of new texels for the maps that tiles show, in mips whose texels are at most 32 samples apart. The host
// uploads the patches over what its map commands have uploaded. A map that is streamed later has the pack's normals for
// as many frames as its patches wait (GroundMapsReport::waiting). Colours, splat maps and horizons stay the pack's.
//
// Memory: one block of the host's. Thread: the frame's. Nothing is allocated; never waits, never calls into the kernel.
// Complexity: O(texels made), at most GroundMapsBudget::texels, and O(changes) since the last call. Without changes
// O(1). An object serves one set of maps on one GPU; a second renderer has one of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/export.h"
#include "fjell/handle.h"
#include "fjell/pack.h"
#include "fjell/status.h"
#include "fjell/stream.h"
#include "fjell/terrain.h"

FJELL_API_BEGIN
namespace fjell {

struct GroundMapsData; // opaque, lives in the host's memory
class GroundMaps : public Handle<GroundMapsData> {};

struct GroundMapsBudget {
    // Changes that wait, 1 to 65,536, 24 bytes each. Of a tile that more change than that, all texels are made anew.
    std::uint32_t changes = 256;
    // Texels made in an update at most, 4,096 to 4,194,304: 1 byte each, and some 30 ns.
    std::uint32_t texels = 1u << 14;
};

// Texels of a mip. Upload the blocks to a rectangle of a layer, in the array of size side_log2. Sides and places are
// whole blocks of 4 x 4 texels.
struct MapPatch {
    MapKind map;
    std::uint8_t side_log2;
    std::uint8_t mip; // of that array
    std::uint32_t tile;
    std::uint32_t layer;
    std::uint32_t x, y, columns, rows;
    std::span<const std::byte> blocks; // row by row (fjell/texture.h); valid until the next update
};

struct GroundMapsReport {
    std::uint32_t patches = 0, texels = 0; // of this update
    // Changes and tiles whose texels are not made anew yet, because GroundMapsBudget::texels are spent.
    std::uint32_t waiting = 0;
    // Tiles with texels made from coarser ground, because pages are missing. They are made again when pages come.
    std::uint32_t coarse = 0;
    double update_us = 0;
};

// 0 for a header that check_ranges() refuses, or a budget out of range.
[[nodiscard]] std::size_t ground_maps_bytes(const PackHeader& header, const GroundMapsBudget& budget = {});
// Before or after the terrain's edits are created, or without edits. memory: at least ground_maps_bytes(), aligned to
// 64. The terrain must outlive it.
Status create_ground_maps(const Terrain& terrain, const GroundMapsBudget& budget, std::span<std::byte> memory,
                          GroundMaps& maps);
Status destroy_ground_maps(const GroundMaps& maps);

// Map commands (stream_map_commands()) that the host carries out: the maps that they write have the pack's normals.
Status note_map_commands(const GroundMaps& maps, std::span<const MapCommand> commands);
// After update_edits() and update_stream(). normals: how each tile's normal map is shown now, stream_tile_maps(), or
// the host's own for maps that it has loaded whole. Fails with out_of_range if that is not one for each tile.
Status update_ground_maps(const GroundMaps& maps, std::span<const TileMap> normals, GroundMapsReport& report);
// Of the last update, in order.
[[nodiscard]] std::span<const MapPatch> ground_map_patches(const GroundMaps& maps);

} // namespace fjell
FJELL_API_END
