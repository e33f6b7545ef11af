// The pack: one file, little-endian, with a header, chunks and a directory. docs/pack-format.md describes the format.
//
// open_pack() checks the header and the directory of a file that the host has read or mapped; it reads no chunk.
// Afterwards each chunk is found in O(1), and is checked and decoded on its own.
// Ownership: a Pack points into the host's bytes, which must outlive it. Thread: a Pack is immutable and can be shared.
// Failure: a Status that names the field. No bytes cause undefined behaviour.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/export.h"
#include "fjell/status.h"

FJELL_API_BEGIN
namespace fjell {

inline constexpr char pack_magic[8] = {'F', 'J', 'E', 'L', 'L', 'P', 'K', '\n'};
inline constexpr std::uint32_t pack_version = 8;
// Bits of PackHeader::features: parts that not every pack has. A reader refuses a pack with bits that it does not know.
enum PackFeatures : std::uint64_t {
    pack_has_horizons = 1,
    pack_has_splat = 2,
    pack_is_sparse = 4 // a pack set that does not cover its terrain (fjell/pack_set.h): in memory only, never in a file
};
inline constexpr std::uint32_t max_layer_bytes = 512; // 16 names of 31 characters and their newlines
// Changes with every stored layout. It also detects a file of the other byte order.
inline constexpr std::uint64_t pack_layout_hash = 0x46a1'0004'0004'1020ull;
inline constexpr int min_tile_log2 = 1;
inline constexpr int max_tile_log2 = 12; // tile-local coordinates must fit 16 bits twice over
inline constexpr std::uint32_t max_texture_log2 = 12;
inline constexpr std::uint32_t max_columns = 1u << 20;
inline constexpr double min_spacing_m = 1e-3, max_spacing_m = 1e6;
inline constexpr std::uint64_t max_sparse_tiles = 1u << 26; // places for tiles of a sparse terrain, 8 bytes each
inline constexpr double max_extent_m = 1e8; // squares of distances must stay far from float's largest value

// How vertices are ordered in pages: by levels in planes, by levels along a Z-curve, or row by row.
enum class PageOrder : std::uint32_t { planar = 0, hierarchical_z = 1, linear = 2 };
// What the error of a vertex is: the largest one under it, which is a bound, or the one at the vertex alone, which is
// not.
enum class ErrorEstimate : std::uint32_t { max = 0, midpoint = 1 };
// What a chunk holds.
enum class ChunkKind : std::uint32_t {
    corners = 0,  // of all tiles: the mesh when no page is loaded
    geometry = 1, // pages, tile by tile
    colour = 2,   // mips, tile by tile
    normal = 3,   // mips, tile by tile
    crs = 4,      // well-known text
    horizon = 5,  // mips, tile by tile
    layers = 6,   // names of the materials in splat maps: text, a newline after each
    splat = 7     // mips, tile by tile
};

// The pack's first 512 bytes.
struct PackHeader {
    char magic[8];
    std::uint32_t version;
    std::uint32_t header_bytes;
    std::uint64_t layout_hash;
    std::uint64_t file_bytes;
    std::uint64_t directory_offset;
    std::uint64_t directory_count;  // chunks
    std::uint64_t directory_hash;   // XXH3 of the directory; with the chunk hashes in it, it names the pack's content
    std::uint32_t columns, rows;    // samples, at least 2 along each side
    std::uint32_t tiles_x, tiles_y; // the fewest tiles that cover them
    std::uint32_t tile_log2;
    PageOrder order;
    ErrorEstimate estimate;
    float nesting;       // mu
    double spacing_m[2]; // along columns (x) and rows (y)
    // Where sample (0, 0) is, in the axes and units of the CRS, which may be feet.
    double crs_origin[2];
    float base_m, quantum_m;   // the scale of heights
    float min_m, max_m;        // the lowest and the highest height
    float max_error_m;         // the largest world-space error of any vertex
    std::uint32_t colour_log2; // texels a side of mip 0; 0: no colour
    std::uint32_t normal_log2; // texels a side of mip 0; 0: no normal map
    std::uint32_t crs_bytes;   // bytes of the WKT; 0: no CRS
    float error_floor_m;       // the scale of errors: the error of code 1
    float error_ratio;         // and the ratio of a code's error to that of the code before
    std::uint32_t error_nesting_steps;
    std::uint32_t height_steps; // the highest height, in steps of the scale
    std::uint64_t voids;        // samples that are holes
    // The scale of radii: its unit for each level, root first; 0 beyond the last level.
    float level_radius_m[2 * max_tile_log2];
    // From sample to sample in CRS units, east and south; 0: not known.
    double crs_step[2];
    // Where the notes are that say how it was baked (JSON, for tools), and their XXH3.
    std::uint64_t notes_offset, notes_hash;
    std::uint64_t notes_bytes;  // 0: none
    std::uint32_t horizon_log2; // texels a side of mip 0; 0: no horizon map
    // Tiles that a sparse terrain has; 0: all of them.
    std::uint32_t tiles_held;
    std::uint32_t splat_log2;   // texels a side of mip 0; 0: no splat map
    std::uint32_t layer_bytes;  // bytes of the materials' names; 0: no splat map
    std::uint64_t features;     // PackFeatures
    std::uint64_t reserved[21]; // zero
    std::uint64_t header_hash;  // XXH3 of all bytes before this one
};
static_assert(sizeof(PackHeader) == 512 && offsetof(PackHeader, header_hash) == 504,
              "PackHeader is stored: change pack_version and pack_layout_hash with it");

// The number of tiles that a pack has. Tiles are numbered row by row; the missing tiles of a sparse terrain have no
// number.
[[nodiscard]] inline std::uint32_t tiles_of(const PackHeader& h) {
    return h.tiles_held != 0 ? h.tiles_held : h.tiles_x * h.tiles_y;
}
// Bytes that follow a pack's chunks in its file, from directory_offset on: the directory. In a sparse terrain the
// places of its tiles (tile_y * tiles_x + tile_x) follow, ascending, 4 bytes each.
[[nodiscard]] inline std::uint64_t directory_bytes(const PackHeader& h);

// A bound of the vertices of a page and its borders, known without reading the page: from how far one of them may be
// wanted. Streaming decides by it which pages to read. Rounded outwards. Zero for chunks that are not geometry.
struct PageBound {
    // Heights, from low << bound_shift() to ((high + 1) << bound_shift()) - 1 height scale steps.
    std::uint16_t low, high;
    std::uint8_t error; // the largest code
    // The code of a radius that none exceeds, in the unit of bound_level().
    std::uint8_t radius;
    std::uint16_t reserved; // zero
};
// A record of the directory: where a chunk is.
struct ChunkEntry {
    std::uint64_t offset;       // from the beginning of the file
    std::uint64_t hash;         // XXH3 of the stored bytes
    std::uint32_t stored_bytes; // zstd frame
    std::uint32_t raw_bytes;    // after decoding
    PageBound bound;            // of geometry only
};
static_assert(sizeof(ChunkEntry) == 32 && offsetof(ChunkEntry, bound) == 24,
              "ChunkEntry is stored: change pack_version and pack_layout_hash with it");
inline std::uint64_t directory_bytes(const PackHeader& h) {
    return h.directory_count * sizeof(ChunkEntry) + std::uint64_t{h.tiles_held} * sizeof(std::uint32_t);
}
// How many HeightScale steps one step of PageBound's heights covers, as a shift.
[[nodiscard]] inline std::uint32_t bound_shift(const PackHeader& h) {
    const auto bits = static_cast<std::uint32_t>(std::bit_width(h.height_steps));
    return bits > 16 ? bits - 16 : 0;
}

// The head of a page's decompressed bytes. The arrays that it announces follow (docs/pack-format.md).
struct PageHead {
    std::int32_t base;        // height scale steps that the page's heights are relative to
    std::uint8_t flags;       // PageFlags
    std::uint8_t reserved[3]; // zero
};
static_assert(sizeof(PageHead) == 8, "PageHead is stored: change pack_version and pack_layout_hash with it");
// Bits of PageHead::flags.
enum PageFlags : std::uint8_t {
    page_wide = 1, // height residuals have a high byte
    // Errors are stored. Otherwise they follow from heights (step 1 only).
    page_errors = 2,
    // A bit for each vertex says whether it is a hole.
    page_voids = 4
};
// Radii of any page but page 0. Each is for 4 x 4 squares: 8 x 8 for centres, 8 x 9 for side_x, 9 x 8 for side_y.
inline constexpr std::uint32_t radius_squares_log2 = 2;
inline constexpr std::uint32_t page_radii = 64 + 72 + 72;
// The largest size of a decompressed page with this many vertices, in bytes.
[[nodiscard]] constexpr std::uint32_t max_page_raw_bytes(std::uint32_t vertices) {
    return static_cast<std::uint32_t>(sizeof(PageHead)) + 4 * vertices + page_radii + (vertices + 7) / 8;
}
// The stored height of a tile corner is in height scale steps. The highest bit marks a hole.
inline constexpr std::uint32_t corner_void_bit = 0x80000000;

// Mips of a map. Mip m of a map with 2^k texels a side has 2^(k-m) texels a side; the smallest mip has 4. In every mip
// the first and last texel centres are on the tile's border, and both neighbours compress the same values there. So
// clamp-to-edge shows no seam. Colour is BC1 of sRGB. Normal is BC5 of the east and south components of the unit
// normal, from which up follows. Horizon is 16 planes of BC4 side by side. Splat is four weights and materials a texel,
// not compressed. fjell/texture.h has the details.
[[nodiscard]] constexpr std::uint32_t mip_count(std::uint32_t log2_side) {
    return log2_side < 2 ? 0 : log2_side - 1;
}

// An opened pack. It points into the host's bytes.
struct Pack {
    PackHeader header{};
    // The whole file. Empty for a pack that is streamed (open_index).
    std::span<const std::byte> bytes;
    const std::byte* directory = nullptr; // of directory_bytes() bytes, unaligned

    [[nodiscard]] std::uint32_t tile_count() const { return tiles_of(header); }
    // Where a tile is: tile_y * tiles_x + tile_x. 0xffffffff for a tile beyond the last one, and in an empty pack.
    [[nodiscard]] std::uint32_t tile_place(std::uint32_t tile) const;
    // The directory's record of a chunk. All zero for a chunk that does not exist, and in an empty pack.
    [[nodiscard]] ChunkEntry entry(std::uint64_t chunk) const;
};

// Opens a pack from all bytes of its file. Checks magic, version, layout, hashes, ranges and the whole directory.
// O(directory). Allocates nothing.
Status open_pack(std::span<const std::byte> file, Pack& pack);

// Opens a pack whose chunks the host reads when they are wanted. header: the first 512 bytes of the file. directory:
// directory_bytes() bytes from directory_offset on. file_bytes: the length of the file.
Status open_index(std::span<const std::byte> header, std::span<const std::byte> directory, std::uint64_t file_bytes,
                  Pack& pack);
// Reads and checks the header alone. It says where the directory is and how large it is.
Status read_header(std::span<const std::byte> header, std::uint64_t file_bytes, PackHeader& out);

// Checks the ranges that open_pack() checks, so that a writer can check them first. Hashes and sizes are not checked.
Status check_ranges(const PackHeader& header);

// The name of a chunk. item: a page of geometry, a mip of a map, otherwise 0.
struct ChunkId {
    ChunkKind kind = ChunkKind::corners;
    // The tile's number (tiles_of()); 0 for chunks of the whole terrain.
    std::uint32_t tile = 0, item = 0;
};
inline constexpr std::uint64_t no_chunk = 0xffff'ffff'ffff'ffffull;
// The place of a chunk in the directory. The order is fixed: corners; geometry, colour and normal, each tile by tile;
// CRS; horizon, tile by tile; names of layers; splat, tile by tile. no_chunk if the pack has no such chunk. tile must
// be below tile_count(), and item below pages_per_tile() or mip_count(). O(1).
[[nodiscard]] std::uint64_t chunk_index(const PackHeader& header, ChunkId id);
// The name of the chunk at a place of the directory. tile and item are 0xffffffff if there is no such place.
[[nodiscard]] ChunkId chunk_id(const PackHeader& header, std::uint64_t chunk);
// The features that a pack with these maps and tiles has.
[[nodiscard]] constexpr std::uint64_t features_of(const PackHeader& header) {
    return (header.horizon_log2 != 0) * std::uint64_t{pack_has_horizons} +
           (header.splat_log2 != 0) * std::uint64_t{pack_has_splat} +
           (header.tiles_held != 0) * std::uint64_t{pack_is_sparse};
}
// How many chunks a pack with this header has.
[[nodiscard]] std::uint64_t chunk_count(const PackHeader& header);
// The size of a decoded chunk in bytes. For geometry it is the largest size that the page can have. 0 if the chunk does
// not exist.
[[nodiscard]] std::size_t chunk_raw_bytes(const PackHeader& header, ChunkId id);

// Checks a chunk's hash and decodes it into `out`, which must have exactly raw_bytes bytes. zstd may allocate, so do
// not call it on the frame's thread.
Status read_chunk(const Pack& pack, ChunkId id, std::span<std::byte> out);
// The same for bytes that the host has read: stored_bytes of them, from the entry's offset.
Status decode_chunk(const ChunkEntry& entry, std::span<const std::byte> stored, std::span<std::byte> out);

} // namespace fjell
FJELL_API_END
