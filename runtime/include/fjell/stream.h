// Streaming: pages of geometry and mips of maps that come and go as the views want them (DESIGN section 6).
//
// The runtime owns no file. update_stream() decides on the frame's thread what is wanted most; a client on another
// thread - io::StreamReader, an engine's loader, a test - asks with next_request(), reads the bytes and hands them in
// with provide(), which checks and decompresses them there. The next update_stream() takes them over. Geometry comes
// page by page, coarse steps first; maps mip by mip. The coarsest page and the smallest mips of every tile stay.
// docs/notes/streaming.md draws the states and who owns them.
//
// Memory: one piece from the host, stream_bytes() of it; all slots are fixed at creation. Threads: the frame's for
// update_stream(), retry_failed() and what they return; one client thread at a time for next_request(),
// still_wanted(), provide() and fail(). Neither waits for the other: there are no locks.
// Complexity of an update: O(pages that the eye's way may concern), at most StreamSettings' limits; a fixed order of
// decisions, so the same arrivals give the same pages.
// Failure: what cannot be read or is damaged is reported once and stays away; terrain is coarser there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/cut.h"
#include "fjell/pack.h"
#include "fjell/status.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

namespace fjell {

enum class MapKind : std::uint8_t { colour = 0, normal = 1 };
inline constexpr std::uint32_t map_kinds = 2;

// How many tiles may have a map of which size, by log2 of its texels a side; 0: that size is not kept. A renderer makes
// an array texture a size, with that many layers and all mips down to 4 x 4. Of the smallest size, tail_log2, there is
// one layer a tile, for good: layer = tile.
struct MapLayers {
    std::uint32_t tail_log2 = 0; // 0: the pack has no such map
    std::uint32_t top_log2 = 0;  // the pack's own size
    std::uint32_t layers[max_texture_log2 + 1] = {};
};

struct StreamBudget {
    // Page slots are the terrain's (TerrainBudget::page_slots); at least one a tile.
    std::uint32_t page_requests = 32; // pages asked for at a time, 1 to 256; some 16 KB each
    std::uint32_t map_requests = 16;  // mips asked for at a time, 1 to 64; the largest mip's bytes each
    std::uint64_t map_bytes = std::uint64_t{256} << 20; // of maps on the GPU; at least the tails of all tiles
    std::uint32_t tail_log2 = 6;                        // of the size that every tile keeps, 2 to 12
};
// The sizes that map_bytes buys: the same share for each size, but no more than one layer a tile, and the rest to the
// finest. O(1). Zeroes for a map that the pack does not have.
[[nodiscard]] MapLayers map_layers(const PackHeader& header, const StreamBudget& budget, MapKind kind);
// What they take on a GPU.
[[nodiscard]] std::uint64_t map_layer_bytes(const MapLayers& slots, MapKind kind);

struct StreamSettings {
    double texel_px = 1;                // pixels that a texel may cover; 0.1 to 100
    double lookahead_s = 0.5;           // how far ahead the eyes' motion is followed; 0: not at all
    double fade_s = 0.3;                // time in which a mip that has come fades in; 0 to 10
    double now_s = 0;                   // the host's clock; must not run backwards
    std::uint32_t pages = 16;           // taken over in a frame; some 10 to 20 us each
    std::uint32_t tests = 1u << 16;     // pages looked at in a frame, some 10 ns each
    std::uint32_t map_bytes = 1u << 20; // handed to the renderer in a frame, but always at least one mip
};

enum StreamBudgetBit : std::uint32_t {
    stream_page_slots = 1u << 0, // TerrainBudget::page_slots: wanted pages find no slot
    stream_map_bytes = 1u << 1,  // StreamBudget::map_bytes: wanted mips find no layer
    stream_pages = 1u << 2,      // StreamSettings::pages: more had come than were taken over
    stream_upload = 1u << 3,     // StreamSettings::map_bytes, the same
    stream_tests = 1u << 4,      // StreamSettings::tests: not all could be looked at
    stream_requests = 1u << 5    // StreamBudget::page_requests or map_requests: more is wanted than may be asked for
};
[[nodiscard]] const char* budget_field(StreamBudgetBit bit);

struct StreamFailure {
    ChunkId id;
    Code code = Code::ok; // corrupt, or unreadable when the client said so
};

// What became of a page, for recordings: replayed in this order, they give the same terrain.
enum class PageEvent : std::uint8_t {
    inserted, // insert_page
    released, // release_page was asked
    kept,     // keep_page: not released after all
    removed   // unload_page
};
struct PageArrival {
    std::uint32_t tile, page;
    PageEvent event;
};

struct StreamReport {
    std::uint64_t frame = 0;
    // Every page that the views want is there: the cut's bound is that of the whole terrain.
    bool converged = false;
    bool maps_converged = false; // every mip too, faded in
    bool complete = false;       // the coarsest page and the smallest mips of every tile are there
    // The largest error on screen that a missing page may hide (Terrain::missing_px); 1e7: anything, because an eye is
    // too near to what is missing, or not all could be looked at.
    double missing_px = 0;
    double missing_mips = 0;                       // levels that the blurriest tile in view lacks
    std::uint32_t exhausted = 0;                   // StreamBudgetBits
    std::uint32_t pages_wanted = 0;                // missing ones, as far as their parents are there
    std::uint32_t pages_taken = 0, pages_left = 0; // in this frame
    std::uint32_t pages_draining = 0;
    std::uint32_t mips_taken = 0, mips_left = 0;
    std::uint32_t requested = 0;                 // published or with the client
    std::uint32_t withdrawn = 0;                 // in this frame
    std::uint32_t failed = 0;                    // so far
    std::uint64_t bytes_read = 0;                // stored, so far, of what came
    std::uint64_t pages_read = 0, mips_read = 0; // so far
    std::uint64_t map_upload_bytes = 0;          // in this frame
    BudgetUse page_slots;
    std::uint64_t map_bytes_used = 0, map_bytes_capacity = 0;
    double update_us = 0;
};

struct StreamState; // opaque, lives in the host's memory
struct Stream {
    StreamState* state = nullptr;
};

[[nodiscard]] std::size_t stream_bytes(const Pack& pack, const Terrain& terrain, const StreamBudget& budget);
// pack: of open_index() or open_pack(); its directory is read here and in updates, so it must be in memory and outlive
// the stream, as must terrain and cut. cut: may be empty when the recursive method draws. memory: aligned to 64.
// Fails with out_of_range, budget_too_small (page slots, map_bytes), memory_too_small, not_supported (linear order).
Status create_stream(const Pack& pack, Terrain& terrain, LiveCut cut, const StreamBudget& budget,
                     std::span<std::byte> memory, Stream& stream);

// Takes over what has come, asks for what the views want, lets go of what they do not. Call it before update_cut(),
// with the same views and settings. No allocation, lock, system call, page fault or exception.
Status update_stream(Stream stream, std::span<const View> views, const CutSettings& cut, const StreamSettings& settings,
                     StreamReport& report);

// Of the last update, until the next one.
[[nodiscard]] std::span<const StreamFailure> stream_failures(Stream stream);
[[nodiscard]] std::span<const PageArrival> page_arrivals(Stream stream);
// Asks again for what has failed.
void retry_failed(Stream stream);

// --- maps, for the renderer
// -------------------------------------------------------------------------------------------

// To be carried out in order. First mips are copied inside the GPU, then blocks uploaded. layer of the array of size
// side_log2; mips count from that array's own mip 0.
struct MapCommand {
    MapKind map;
    std::uint8_t side_log2;
    std::uint8_t from_log2;   // the array whose mips are copied; 0: none. Those that both arrays have.
    std::uint8_t upload_mips; // from mip 0 on: 1, all of a tail's, or 0
    std::uint32_t tile;
    std::uint32_t layer, from_layer;
    std::span<const std::byte>
        blocks; // of upload_mips mips, largest first (fjell/texture.h); valid until the next update
};
[[nodiscard]] std::span<const MapCommand> map_commands(Stream stream);

// How a tile's map is drawn: from a layer, with no mip finer than `finest`, which counts from the pack's mip 0, moves
// with time and may lie between two mips. Neighbours blend theirs along the border: min_lod_grid().
struct TileMap {
    std::uint32_t layer = 0;
    std::uint8_t side_log2 = 0; // 0: nothing is there yet
    float finest = 0;
};
[[nodiscard]] std::span<const TileMap> tile_maps(Stream stream, MapKind kind); // one a tile; empty when there is no map
[[nodiscard]] MapLayers stream_map_layers(Stream stream, MapKind kind);

// The least mip at a tile's corners, the middles of its sides and its centre, row by row from the north-west: the
// largest of all tiles that share the place. Bilinear between them it is continuous over the whole terrain.
void min_lod_grid(std::span<const TileMap> maps, std::uint32_t tiles_x, std::uint32_t tile, float (&out)[9]);

// --- the client
// -------------------------------------------------------------------------------------------------------

struct StreamRequest {
    std::uint32_t ticket = 0; // 0: none
    ChunkId id;               // of maps the first of `chunks` mips that lie one after the other
    std::uint32_t chunks = 0;
    std::uint64_t offset = 0; // in the file
    std::uint32_t bytes = 0;
};
// What is wanted most at this moment; false: nothing is. The request is the client's until provide() or fail().
[[nodiscard]] bool next_request(Stream stream, StreamRequest& request);
// False: it need not be read; answer with fail(ticket, true).
[[nodiscard]] bool still_wanted(Stream stream, std::uint32_t ticket);
// stored: the file's bytes at offset, `bytes` of them; copied. Checks their hash and decompresses. corrupt: they were
// damaged, and the stream knows.
Status provide(Stream stream, std::uint32_t ticket, std::span<const std::byte> stored);
// Could not be read; or, when unwanted, was not.
void fail(Stream stream, std::uint32_t ticket, bool unwanted = false);

} // namespace fjell
