// A terrain as a pyramid of tiles for globes.
//
// Every tile's error is measured against all samples under it, and is below what viewers assume for its level. Tiles of
// one level have the same vertices where they meet (tile_mesh.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "baker/bake/bake.h"
#include "baker/outlets/globe.h"
#include "baker/read/source.h"
#include "gltf/mesh.h"

namespace fjell::baker {

enum class TilesFormat : std::uint8_t { quantized_mesh, tiles_3d, terrain_rgb, terrarium };
[[nodiscard]] constexpr bool is_raster(TilesFormat format) {
    return format == TilesFormat::terrain_rgb || format == TilesFormat::terrarium;
}

struct TilesOptions {
    TilesFormat format = TilesFormat::quantized_mesh;
    std::optional<Tiling> tiling{};   // none: mercator for pictures, which have no other, and geographic
    int max_level = -1;               // -1: of meshes the first whose error is below a fifth of the spacing of samples,
                                      // of pictures the first whose pixels are no wider than that at the equator
    int side_px = 512;                // of pictures
    bool webp = false;                // pictures as WebP, not as PNG
    bool normals = true, gzip = true; // gzip: of quantized-mesh alone
    gltf::GlbPacking packing;         // of 3D Tiles alone
    bool implicit_tree = false;       // of 3D Tiles alone: implicit_tileset.h
    std::string maps_of{};            // a pack, the source's
    bool colours = false;             // its colours as textures; of 3D Tiles alone
    bool water = false;               // the water in its splat maps as a mask; of quantized-mesh alone
    int threads = 0;                  // 0: all cores
    std::uint64_t memory_bytes = std::uint64_t{512} << 20; // for heights: what is larger lies in the work folder
    Progress progress;
};

struct LevelSummary {
    std::int32_t level = 0;
    double assumed_error_m = 0; // what viewers take its tiles' errors for; of pictures: nothing
    double error_m = 0;         // the largest of any tile
    std::uint64_t tiles = 0, vertices = 0, triangles = 0, bytes = 0;
    std::uint64_t above = 0; // tiles whose error is above the assumed one: cliffs that their grid is too coarse for
};
struct TilesSummary {
    std::vector<LevelSummary> levels;
    bool resumed = false;
};

inline constexpr int most_tile_level = 24;

// Writes FOLDER/{z}/{x}/{y}.terrain (quantized-mesh 1.0, y from the south) and, when all are there, layer.json. Bytes
// do not depend on the number of threads. As 3D Tiles 1.1: {z}/{x}/{y}.glb and tileset.json, from the finest level on
// that needs no more than four tiles; tiles have walls as deep as their own error and the coarser level's together.
// With an implicit tree the tiles, and .subtree files beside them, lie in a folder for each of the coarsest.
// As pictures: {z}/{x}/{y}.png or .webp, y from the north, and tiles.json (raster_tiles.h).
// A name that ends in .mbtiles or .pmtiles is one file, with what layer.json or tiles.json says in its metadata.
// Interrupted or failed, the same call goes on with the tiles that are missing: FOLDER.work says which. name: of the
// source, for messages. Throws Failure: 1 the source, or a folder that holds something else; 3 the disk.
TilesSummary write_tiles(const HeightSource& source, const std::string& name, const TilesOptions& options,
                         const std::string& folder);

} // namespace fjell::baker
