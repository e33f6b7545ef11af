// Streaming: pages of geometry and mips of maps, loaded and evicted as the views need them.
//
// The runtime opens no file. update_stream() decides on the frame's thread what is needed most; a client on another
// thread (io::StreamReader, an engine's loader, a test) polls stream_next_request(), reads the bytes and passes them to
// stream_provide(), which checks and decompresses them there. Several such threads may. The next update_stream()
// inserts them. Geometry is loaded page by page, coarse steps first; maps mip by mip. The coarsest page and the
// smallest mips of every tile are never evicted. docs/notes/streaming.md draws the states and who owns them.
//
// Memory: one piece from the host, stream_bytes() of it; all slots are fixed at creation. Threads: the frame's for
// update_stream(), stream_retry_failed() and what they return; client threads, StreamBudget::decoders at a time, for
// stream_next_request(), stream_still_wanted(), stream_provide() and stream_fail(). There are no locks. The frame's
// thread never waits for a client, nor a client for it. More threads than decoders in stream_provide() yield to each
// other until a decoder is free.
// Complexity of an update: O(pages whose answer the eye's motion may change), bounded by StreamSettings' limits. The
// order of decisions is fixed, so the same arrivals give the same pages.
// Failure: a chunk that cannot be read or is damaged is reported once and not requested again; terrain is coarser
// there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fjell/cut.h"
#include "fjell/export.h"
#include "fjell/handle.h"
#include "fjell/pack.h"
#include "fjell/status.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell {

// Which map of a tile.
enum class MapKind : std::uint8_t { colour = 0, normal = 1, horizon = 2, splat = 3 };
inline constexpr std::uint32_t map_kinds = 4;

// How many layers there are for each size of a map, by log2 of its texels a side; 0: that size is not used. A renderer
// creates one array texture a size, with that many layers and all mips down to 4 x 4. Of the smallest size, tail_log2,
// every tile has its own layer for good: layer = tile.
struct MapLayers {
    std::uint32_t tail_log2 = 0; // 0: there is no such map
    std::uint32_t top_log2 = 0;  // the pack's own size
    std::uint32_t layers[max_texture_log2 + 1] = {};
};

// What a stream may use: fixed at creation.
struct StreamBudget {
    // Page slots are the terrain's (TerrainBudget::page_slots); at least one a tile.
    std::uint32_t page_requests = 32; // pages in flight at a time, 1 to 256; max_page_raw_bytes() each
    std::uint32_t map_requests = 16;  // mips in flight at a time, 1 to 64; the largest mip's bytes each
    std::uint64_t map_bytes = std::uint64_t{256} << 20; // of maps on the GPU; at least the tails of all tiles
    std::uint32_t tail_log2 = 6;                        // of the size that every tile always has, 2 to 12
    std::uint32_t decoders = 1; // threads that decompress in stream_provide() at a time, 1 to 16; 160 KB each
    bool horizons = false;      // horizon maps too, of a pack that has them: for renderers that draw shadows
    bool splat = false;         // splat maps too: for renderers that draw materials
};
// The layers that fit map_bytes: an equal share for each size, but no more than one layer a tile; what remains goes to
// the finest. O(1). Zeroes for a map that the pack does not have, and for one that the budget does not want.
[[nodiscard]] MapLayers map_layers(const PackHeader& header, const StreamBudget& budget, MapKind kind);
// What they take on a GPU.
[[nodiscard]] std::uint64_t map_layer_bytes(const MapLayers& sizes, MapKind kind);

// What an update goes by, beside the settings of the cut.
struct StreamSettings {
    double texel_px = 1;                // pixels that a texel may cover; 0.1 to 100
    double lookahead_s = 0.5;           // how far ahead the eyes' motion is extrapolated; 0: not at all
    double fade_s = 0.3;                // time in which a new mip fades in; 0 to 10
    double now_s = 0;                   // the host's clock; must not run backwards
    std::uint32_t pages = 16;           // inserted in a frame at most; some 5 to 10 us each
    std::uint32_t tests = 1u << 16;     // pages tested in a frame at most, some 10 ns each
    std::uint32_t map_bytes = 1u << 20; // uploaded in a frame at most, but always at least one mip
};

// Bits of StreamReport::exhausted: the field that did not suffice.
enum StreamBudgetBit : std::uint32_t {
    stream_page_slots = 1u << 0, // TerrainBudget::page_slots: wanted pages find no slot
    stream_map_bytes = 1u << 1,  // StreamBudget::map_bytes: wanted mips find no layer
    stream_pages = 1u << 2,      // StreamSettings::pages: more had arrived than were inserted
    stream_upload = 1u << 3,     // StreamSettings::map_bytes, the same
    stream_tests = 1u << 4,      // StreamSettings::tests: not all could be tested
    stream_requests = 1u << 5    // StreamBudget::page_requests or map_requests: more is wanted than may be in flight
};
// The field that a single bit stands for.
[[nodiscard]] const char* budget_field(StreamBudgetBit bit);

// A chunk that could not be loaded.
struct StreamFailure {
    ChunkId id;
    StatusCode code = StatusCode::ok; // corrupt, or unreadable when the client said so
};

// What happened to a page, for recordings: replayed in this order, the events give the same terrain.
enum class PageEvent : std::uint8_t {
    inserted, // insert_page
    released, // cut_release_page
    kept,     // cut_cancel_release
    removed   // unload_page
};
// A page, and what happened to it.
struct PageArrival {
    std::uint32_t tile, page;
    PageEvent event;
};

// What an update has done, and what is still missing.
struct StreamReport {
    std::uint64_t frame = 0;
    // Every page that the views want is loaded: the cut's bound is that of the whole terrain.
    bool converged = false;
    bool maps_converged = false; // every mip too, and faded in
    bool complete = false;       // the coarsest page and the smallest mips of every tile are loaded
    // The largest error on screen that a missing page may hide (Terrain::missing_px); 1e7: any, because an eye is too
    // near to what is missing, or not all pages could be tested.
    double missing_px = 0;
    double missing_mips = 0;                          // levels that the blurriest tile in view lacks
    std::uint32_t exhausted = 0;                      // StreamBudgetBits
    std::uint32_t pages_wanted = 0;                   // missing ones whose coarser page is loaded
    std::uint32_t pages_inserted = 0, pages_left = 0; // in this frame; left: arrived, not inserted yet
    std::uint32_t pages_evicting = 0;
    std::uint32_t mips_uploaded = 0, mips_left = 0;
    std::uint32_t in_flight = 0;                 // requests that are queued or with the client
    std::uint32_t cancelled = 0;                 // requests, in this frame
    std::uint32_t failed = 0;                    // so far
    std::uint64_t bytes_read = 0;                // so far, as stored in the file
    std::uint64_t pages_read = 0, mips_read = 0; // so far
    std::uint64_t map_upload_bytes = 0;          // in this frame
    BudgetUse page_slots;
    std::uint64_t map_bytes_used = 0, map_bytes_capacity = 0;
    double update_us = 0;
};

struct StreamState; // opaque, lives in the host's memory
using Stream = Handle<StreamState>;

// 0 for a budget that create_stream() refuses.
[[nodiscard]] std::size_t stream_bytes(const Pack& pack, const Terrain& terrain, const StreamBudget& budget);
// pack: of open_index() or open_pack(). Its directory is read here and in updates, so it must be in memory. Pack,
// terrain and cut must outlive the stream. cut: may be empty when the recursive method draws. From now on only the
// stream may load and unload pages of the terrain: it does not see what others do. memory: aligned to 64. Fails with
// out_of_range, budget_too_small (page slots, map_bytes), memory_too_small, not_supported (linear order).
Status create_stream(const Pack& pack, const Terrain& terrain, LiveCut cut, const StreamBudget& budget,
                     std::span<std::byte> memory, Stream& stream);
// Ends the stream; the pages that it has loaded stay. The client must have stopped.
Status destroy_stream(Stream stream);

// Inserts what has arrived, requests what the views want, evicts what they do not. Call it before update_cut(), with
// the same views and settings. Several cuts of one terrain: give it the views of all. A cut whose views it did not get
// claims what no mesh of the terrain exceeds while any page is missing. No allocation, lock, system call, page fault or
// exception.
Status update_stream(Stream stream, std::span<const View> views, const CutSettings& cut, const StreamSettings& settings,
                     StreamReport& report);

// Of the last update, until the next one.
[[nodiscard]] std::span<const StreamFailure> stream_failures(Stream stream);
// What happened to pages in the last update, in order; until the next one.
[[nodiscard]] std::span<const PageArrival> stream_page_arrivals(Stream stream);
// Allows what has failed to be requested again.
Status stream_retry_failed(Stream stream);

// --- maps, for the renderer ---

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
// Of the last update: carry them out after each one, drawn or not.
[[nodiscard]] std::span<const MapCommand> stream_map_commands(Stream stream);

// How a tile's map is sampled: from a layer, with no mip finer than min_lod. That counts from the pack's mip 0, changes
// over time and may lie between two mips. Neighbours blend theirs along the border: min_lod_grid().
struct TileMap {
    std::uint32_t layer = 0;
    std::uint8_t side_log2 = 0; // 0: nothing is loaded yet
    float min_lod = 0;
};
// One a tile, of the last update; empty when the pack has no such map.
[[nodiscard]] std::span<const TileMap> stream_tile_maps(Stream stream, MapKind kind);
// The layers that a renderer makes, fixed at creation.
[[nodiscard]] MapLayers stream_map_layers(Stream stream, MapKind kind);

// The min_lod at a tile's corners, the middles of its sides and its centre, row by row from the north-west: the largest
// of all tiles that share the place. Interpolated bilinearly it is continuous over the whole terrain.
// Fails with out_of_range for a tile beyond maps, or maps that are not whole rows of tiles_x.
Status min_lod_grid(std::span<const TileMap> maps, std::uint32_t tiles_x, std::uint32_t tile, float (&out)[9]);
// The same where tiles may be missing: maps: one for each of the terrain's.
Status min_lod_grid(std::span<const TileMap> maps, const Terrain& terrain, std::uint32_t tile, float (&out)[9]);

// --- the client ---

// What the client is to read.
struct StreamRequest {
    std::uint32_t ticket = 0; // 0: none
    ChunkId id;               // of maps the first of `chunks` mips that lie one after the other
    std::uint32_t chunks = 0;
    std::uint64_t offset = 0; // in the file
    std::uint32_t bytes = 0;
};
// The request that is wanted most; false: there is none. The client owns it until stream_provide() or stream_fail().
[[nodiscard]] bool stream_next_request(Stream stream, StreamRequest& request);
// False: the request was cancelled; answer with stream_fail(stream, ticket, true).
[[nodiscard]] bool stream_still_wanted(Stream stream, std::uint32_t ticket);
// stored: the file's bytes at offset, `bytes` of them; copied. Checks their hash and decompresses. Returns corrupt for
// damaged bytes; the stream then counts the chunk as failed.
Status stream_provide(Stream stream, std::uint32_t ticket, std::span<const std::byte> stored);
// The bytes could not be read; unwanted: were not read, because the request was cancelled.
Status stream_fail(Stream stream, std::uint32_t ticket, bool unwanted = false);

} // namespace fjell
FJELL_API_END
