// Normal maps of moving ground (fjell/edit.h): the texels over heights that have changed are made anew.
//
// The maps of a pack have the normals of the pack's ground. After each update of edits and stream, update_ground_maps()
// makes patches of new texels for the maps that tiles show, in mips whose texels are at most 32 samples apart. The host
// uploads the patches over what its map commands have uploaded. A map that is streamed later has the pack's normals for
// as many frames as its patches wait (GroundMapsReport::waiting).
//
// Horizon maps of a stream follow when the ground has rested for 16 updates: mips are read again, and are among the
// patches. Horizons rise by what has moved within 128 samples, and never sink below the pack's.
//
// Colour and splat maps under paint (StampShape::paint) come painted from a stream: its clients paint what they hand
// in. Mips that are there already are read again, and are among the patches of a later update. A host that loads maps
// itself paints them with paint_map(), and again where take_paint_changes() says so.
//
// Memory: one block of the host's. Thread: the frame's. Nothing is allocated; never waits, never calls into the kernel.
// Complexity: O(texels made), at most GroundMapsBudget::texels, and O(changes) since the last call. Without changes
// O(1). An object serves one set of maps on one GPU; a second renderer has one of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/edit.h"
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
// whole blocks of 4 x 4 texels; of a horizon map a patch is a whole mip, in texels of its picture of 4 x 4 planes.
// Patches of normals are made here; those of the other maps are the stream's.
struct MapPatch {
    MapKind map;
    std::uint8_t side_log2;
    std::uint8_t mip; // of that array
    std::uint32_t tile;
    std::uint32_t layer;
    std::uint32_t x, y, columns, rows;
    std::span<const std::byte> blocks; // row by row (fjell/texture.h); valid until the next update, or the stream's
};

struct GroundMapsReport {
    std::uint32_t patches = 0; // of this update
    std::uint32_t texels = 0;  // that it has made
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
// Once after each update_edits() and update_stream(). normals: how each tile's normal map is shown now,
// stream_tile_maps(), or the host's own for maps that it has loaded whole. Fails with out_of_range if that is not one
// for each tile.
Status update_ground_maps(const GroundMaps& maps, std::span<const TileMap> normals, GroundMapsReport& report);
// Of the last update, in order.
[[nodiscard]] std::span<const MapPatch> ground_map_patches(const GroundMaps& maps);

// Puts the terrain's paint over a mip as the pack stores it: map is colour or splat, the mip has 2^side_log2 texels a
// side. changed: whether paint reaches it. Any thread; while the frame's thread paints, what it paints may be there
// in part. The edits must not be destroyed meanwhile. O(texels). Fails with out_of_range.
Status paint_map(const Terrain& terrain, MapKind map, std::uint32_t tile, std::uint32_t side_log2,
                 std::span<std::byte> blocks, bool& changed);
// Samples whose paint has changed since the consumer's last call, as take_ground_changes() gives heights. The frame's
// thread.
[[nodiscard]] std::uint32_t take_paint_changes(const Terrain& terrain, std::uint64_t& cursor,
                                               std::span<GroundRect> rects, bool& lost);

// A terrain's paint as it is now, for snapshots that are written later. paint_bytes(): 0 if there is none.
struct PaintData; // opaque, lives in the host's memory
class Paint : public Handle<PaintData> {};
[[nodiscard]] std::size_t paint_bytes(const Terrain& terrain);
// The frame's thread. memory: at least paint_bytes(), aligned to 64; the copy ends with it. Fails with not_supported if
// there is no paint.
Status copy_paint(const Terrain& terrain, std::span<std::byte> memory, Paint& paint);
Status paint_map(const Paint& paint, MapKind map, std::uint32_t tile, std::uint32_t side_log2,
                 std::span<std::byte> blocks, bool& changed);

} // namespace fjell
FJELL_API_END
