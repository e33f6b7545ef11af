// The pack: one file, little-endian. Header, chunks, directory. Format description: docs/pack-format.md.
//
// `open_pack` checks the header and the directory of bytes the host has read or mapped; it touches no chunk. Each
// chunk can then be found in O(1), checked and decoded on its own.
// Ownership: `Pack` points into the host's bytes, which must outlive it. Thread: a Pack is immutable and shareable.
// Failure: a Status that names the field; never undefined behaviour, whatever the bytes.
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
// Bits of PackHeader::features: what not every pack has. A reader refuses those that it does not know.
enum PackFeatures : std::uint64_t {
    pack_has_horizons = 1,
    pack_has_splat = 2,
    pack_is_sparse = 4 // a pack set that does not cover its terrain (fjell/pack_set.h): in memory only, never in a file
};
inline constexpr std::uint32_t max_layer_bytes = 512; // 16 names of 31 characters and their newlines
// Changes with every stored layout; also detects a byte-swapped file.
inline constexpr std::uint64_t pack_layout_hash = 0x46a1'0004'0004'1020ull;
inline constexpr int min_tile_log2 = 1;
inline constexpr int max_tile_log2 = 12; // tile-local coordinates must fit 16 bits twice over
inline constexpr std::uint32_t max_texture_log2 = 12;
inline constexpr std::uint32_t max_columns = 1u << 20;
inline constexpr double min_spacing_m = 1e-3, max_spacing_m = 1e6;
inline constexpr std::uint64_t max_sparse_tiles = 1u << 26; // places for tiles of a sparse terrain, 8 bytes each
inline constexpr double max_extent_m = 1e8; // squares of distances must stay far from float's largest value

// How vertices lie in pages: by levels, in planes or along a Z-curve, or row by row.
enum class PageOrder : std::uint32_t { planar = 0, hierarchical_z = 1, linear = 2 };
// What a vertex' error is: the true largest one, or that at the vertex alone (no bound).
enum class ErrorEstimate : std::uint32_t { max = 0, midpoint = 1 };
// What a chunk holds.
enum class ChunkKind : std::uint32_t {
    corners = 0,  // of all tiles: the mesh that is there when no page is
    geometry = 1, // pages, tile by tile
    colour = 2,   // mips, tile by tile
    normal = 3,   // the same
    crs = 4,      // well-known text
    horizon = 5,  // mips, tile by tile
    layers = 6,   // names of the materials that splat maps speak of: text, each ends with a newline
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
    std::uint32_t columns, rows;    // samples, at least 2
    std::uint32_t tiles_x, tiles_y; // the fewest that cover them
    std::uint32_t tile_log2;
    PageOrder order;
    ErrorEstimate estimate;
    float nesting;             // mu
    double spacing_m[2];       // along columns (x) and rows (y)
    double crs_origin[2];      // of sample (0, 0), in CRS axes and units, which may be feet
    float base_m, quantum_m;   // the vertical height scale
    float min_m, max_m;        // heights that occur
    float max_error_m;         // the largest world-space error of any vertex
    std::uint32_t colour_log2; // texels a side of mip 0; 0: no colour
    std::uint32_t normal_log2; // texels a side of mip 0; 0: no normal map
    std::uint32_t crs_bytes;   // of the WKT; 0: no CRS
    float error_floor_m;       // ErrorScale: the error of code 1
    float error_ratio;         // and of each code to the one before
    std::uint32_t error_nesting_steps;
    std::uint32_t height_steps;              // the highest that occurs
    std::uint64_t voids;                     // samples that are holes
    float level_radius_m[2 * max_tile_log2]; // RadiusScale's unit for each level, root first; 0 beyond the last
    double crs_step[2];                      // from sample to sample in CRS units, east and south; 0: not known
    std::uint64_t notes_offset, notes_hash;  // of how it was baked (JSON, for tools): where, and its XXH3
    std::uint64_t notes_bytes;               // 0: none
    std::uint32_t horizon_log2;              // texels a side of mip 0; 0: no horizon map
    std::uint32_t tiles_held;                // of a sparse terrain: tiles that are there; 0: all of them
    std::uint32_t splat_log2;                // texels a side of mip 0; 0: no splat map
    std::uint32_t layer_bytes;               // of the materials' names; 0: no splat map
    std::uint64_t features;                  // PackFeatures
    std::uint64_t reserved[21];              // zero
    std::uint64_t header_hash;               // XXH3 of all bytes before this one
};
static_assert(sizeof(PackHeader) == 512 && offsetof(PackHeader, header_hash) == 504,
              "PackHeader is stored: change pack_version and pack_layout_hash with it");

// Tiles that there are: what tile numbers count. Row by row; of a sparse terrain without those that are missing.
[[nodiscard]] inline std::uint32_t tiles_of(const PackHeader& h) {
    return h.tiles_held != 0 ? h.tiles_held : h.tiles_x * h.tiles_y;
}
// What follows a pack's chunks in its file, from directory_offset on: the directory, and of a sparse terrain its tiles'
// places (tile_y * tiles_x + tile_x), ascending, 4 bytes each.
[[nodiscard]] inline std::uint64_t directory_bytes(const PackHeader& h);

// What can be said of a page's vertices, its borders included, without reading it: how far away one of them may be
// wanted. Streaming decides by it which pages to read. Rounded outwards. Other chunks: zero.
struct PageBound {
    std::uint16_t low, high; // heights: low << bound_shift() to ((high + 1) << bound_shift()) - 1 height scale steps
    std::uint8_t error;      // the largest code
    std::uint8_t radius;     // code, on the unit of bound_level(), of a radius that none exceeds
    std::uint16_t reserved;  // zero
};
// Where a chunk lies: a record of the directory.
struct ChunkEntry {
    std::uint64_t offset;       // from the file's beginning
    std::uint64_t hash;         // XXH3 of the stored bytes
    std::uint32_t stored_bytes; // zstd frame
    std::uint32_t raw_bytes;    // after decoding
    PageBound bound;            // of geometry
};
static_assert(sizeof(ChunkEntry) == 32 && offsetof(ChunkEntry, bound) == 24,
              "ChunkEntry is stored: change pack_version and pack_layout_hash with it");
inline std::uint64_t directory_bytes(const PackHeader& h) {
    return h.directory_count * sizeof(ChunkEntry) + std::uint64_t{h.tiles_held} * sizeof(std::uint32_t);
}
// HeightScale steps that one step of PageBound's heights covers, as a shift.
[[nodiscard]] inline std::uint32_t bound_shift(const PackHeader& h) {
    const auto bits = static_cast<std::uint32_t>(std::bit_width(h.height_steps));
    return bits > 16 ? bits - 16 : 0;
}

// A page's bytes after decompression: this, then the arrays that it announces (docs/pack-format.md).
struct PageHead {
    std::int32_t base;        // height scale steps that heights are counted from
    std::uint8_t flags;       // PageFlags
    std::uint8_t reserved[3]; // zero
};
static_assert(sizeof(PageHead) == 8, "PageHead is stored: change pack_version and pack_layout_hash with it");
// Bits of PageHead::flags.
enum PageFlags : std::uint8_t {
    page_wide = 1,   // height residuals have a high byte
    page_errors = 2, // errors are stored; otherwise they follow from heights (step 1 only)
    page_voids = 4   // a bit a vertex: holes
};
// Radii of any page but page 0, one for 4 x 4 squares: 8 x 8 for centres, 8 x 9 for side_x, 9 x 8 for side_y.
inline constexpr std::uint32_t radius_squares_log2 = 2;
inline constexpr std::uint32_t page_radii = 64 + 72 + 72;
// The most and the fewest bytes that a page of that many vertices can decode from.
[[nodiscard]] constexpr std::uint32_t max_page_raw_bytes(std::uint32_t vertices) {
    return static_cast<std::uint32_t>(sizeof(PageHead)) + 4 * vertices + page_radii + (vertices + 7) / 8;
}
// A tile corner's stored height: height scale steps, the highest bit set for a hole.
inline constexpr std::uint32_t corner_void_bit = 0x80000000;

// Textures. Mip m of a map with 2^k texels a side has 2^(k-m); the smallest has 4. The first and last texel centre of
// *every* mip lie on the tile's border, and both neighbours compress the same values there: no seam under
// clamp-to-edge. Colour is BC1 of sRGB, normal BC5 of the east and south components of the unit normal (up follows),
// horizon 16 planes of BC4 side by side, splat four weights and materials a texel, not compressed: fjell/texture.h.
[[nodiscard]] constexpr std::uint32_t mip_count(std::uint32_t log2_side) {
    return log2_side < 2 ? 0 : log2_side - 1;
}

// An opened pack: points into the host's bytes.
struct Pack {
    PackHeader header{};
    std::span<const std::byte> bytes;     // the whole file; empty for a pack that is streamed (open_index)
    const std::byte* directory = nullptr; // directory_bytes() of it, unaligned

    [[nodiscard]] std::uint32_t tile_count() const { return tiles_of(header); }
    // Where a tile lies: tile_y * tiles_x + tile_x. Of an empty pack, and beyond the last tile: 0xffffffff.
    [[nodiscard]] std::uint32_t tile_place(std::uint32_t tile) const;
    // Zeroes for a chunk that is not there, and of an empty pack.
    [[nodiscard]] ChunkEntry entry(std::uint64_t chunk) const;
};

// Checks magic, version, layout, hashes, ranges and the whole directory. O(directory). Allocates nothing.
Status open_pack(std::span<const std::byte> file, Pack& pack);

// The same from a file's first 512 bytes and what follows its chunks (directory_bytes() of it), for a host that reads
// chunks when they are wanted. file_bytes: how long the file is.
Status open_index(std::span<const std::byte> header, std::span<const std::byte> directory, std::uint64_t file_bytes,
                  Pack& pack);
// Reads and checks the header alone: it says where the directory lies and how large it is.
Status read_header(std::span<const std::byte> header, std::uint64_t file_bytes, PackHeader& out);

// The ranges that open_pack insists on, so that a writer can check them first. Hashes and sizes are not checked.
Status check_ranges(const PackHeader& header);

// What a chunk of the directory is. item: a page of geometry, a mip of a map, 0 otherwise.
struct ChunkId {
    ChunkKind kind = ChunkKind::corners;
    std::uint32_t tile = 0, item = 0; // tiles by number (tiles_of()); 0 for chunks of the whole terrain
};
inline constexpr std::uint64_t no_chunk = 0xffff'ffff'ffff'ffffull;
// Its place in the directory, a fixed order: corners; geometry, colour and normal, each tile by tile; CRS; horizon,
// tile by tile; names of layers; splat maps, tile by tile. no_chunk when the pack has no such chunk: tile <
// tile_count(), item below pages_per_tile() or mip_count(). O(1).
[[nodiscard]] std::uint64_t chunk_index(const PackHeader& header, ChunkId id);
// The way back. For a chunk that is not there an id that names none: tile and item are 0xffffffff.
[[nodiscard]] ChunkId chunk_id(const PackHeader& header, std::uint64_t chunk);
// The features that a pack with these maps and tiles has.
[[nodiscard]] constexpr std::uint64_t features_of(const PackHeader& header) {
    return (header.horizon_log2 != 0) * std::uint64_t{pack_has_horizons} +
           (header.splat_log2 != 0) * std::uint64_t{pack_has_splat} +
           (header.tiles_held != 0) * std::uint64_t{pack_is_sparse};
}
// How many chunks such a pack has.
[[nodiscard]] std::uint64_t chunk_count(const PackHeader& header);
// The size of a decoded chunk; for geometry the largest that its page can have. 0 when there is no such
// chunk.
[[nodiscard]] std::size_t chunk_raw_bytes(const PackHeader& header, ChunkId id);

// Checks the chunk's hash and decodes it into `out`, which must have exactly raw_bytes. zstd may allocate: not for the
// frame's thread.
Status read_chunk(const Pack& pack, ChunkId id, std::span<std::byte> out);
// The same for bytes that the host has read: stored_bytes of them, from the entry's offset.
Status decode_chunk(const ChunkEntry& entry, std::span<const std::byte> stored, std::span<std::byte> out);

} // namespace fjell
FJELL_API_END
