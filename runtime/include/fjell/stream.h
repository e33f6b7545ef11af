// Streaming: pages of geometry and mips of maps are loaded and evicted as the views need them.
//
// The runtime opens no file. update_stream() decides on the frame's thread what is needed most. A client on another
// thread (io::StreamReader, an engine's loader, a test) asks stream_next_request(), reads those bytes and passes them
// to stream_provide(), which checks and decompresses them on the client's thread. The next update_stream() takes them
// over. A client may have several threads. Geometry is loaded page by page, coarse steps first, and maps mip by mip.
// The coarsest page and the smallest mips of every tile are never evicted. docs/notes/streaming.md draws the states and
// who owns them.
//
// Memory: one block from the host, of stream_bytes() bytes. All slots are fixed at creation.
// Threads: update_stream(), stream_retry_failed() and what they return belong to the frame's thread.
// stream_next_request(), stream_still_wanted(), stream_provide*() and stream_fail() belong to the client's threads.
// There are no locks. The frame's thread never waits for a client, and a client never waits for the frame. Client
// threads wait for each other in one case: if more of them than StreamBudget::decoders are in stream_provide(), they
// yield until a decoder is free.
// Complexity of an update: O(pages whose answer the eye's motion may change), limited by StreamSettings. The order of
// decisions is fixed, so the same arrivals give the same pages.
// Failure: a chunk that cannot be read or is damaged is reported once and not requested again. The terrain stays
// coarser there.
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

// The maps of a tile.
enum class MapKind : std::uint8_t { colour = 0, normal = 1, horizon = 2, splat = 3 };
inline constexpr std::uint32_t map_kinds = 4;

// How many layers each size of a map has. layers[i] is for maps of 2^i texels a side; 0: that size is not used. A
// renderer creates one array texture for each size, with that many layers and with all mips down to 4 x 4. In the
// smallest size, tail_log2, every tile has a layer of its own for good: the layer's number is the tile's.
struct MapLayers {
    std::uint32_t tail_log2 = 0; // 0: the pack has no such map
    std::uint32_t top_log2 = 0;  // the pack's own size
    std::uint32_t layers[max_texture_log2 + 1] = {};
};

// What a stream may use. Fixed at creation. Page slots are the terrain's (TerrainBudget::page_slots); the stream needs
// at least one for each tile.
struct StreamBudget {
    // Pages in flight at a time, 1 to 256, of max_page_raw_bytes() each.
    std::uint32_t page_requests = 32;
    // Mips in flight at a time, 1 to 64, of the largest mip's bytes each.
    std::uint32_t map_requests = 16;
    std::uint64_t map_bytes = std::uint64_t{256} << 20; // maps on the GPU, at least the smallest mips of all tiles
    // The size that every tile always has, as log2 of its texels a side, 2 to 12.
    std::uint32_t tail_log2 = 6;
    // Threads that may decompress in stream_provide() at a time, 1 to 16, of 160 KB each.
    std::uint32_t decoders = 1;
    // Load horizon maps too, if the pack has them: for renderers that draw shadows.
    bool horizons = false;
    // Load splat maps too, if the pack has them: for renderers that draw materials.
    bool splat = false;
};
// How map_bytes is divided among the sizes of a map. Each size gets an equal share, but no more than one layer for each
// tile; the rest goes to the finest size. O(1). All zero for a map that the pack does not have or the budget does not
// want.
[[nodiscard]] MapLayers map_layers(const PackHeader& header, const StreamBudget& budget, MapKind kind);
// Bytes that these layers take on a GPU.
[[nodiscard]] std::uint64_t map_layer_bytes(const MapLayers& sizes, MapKind kind);

// The settings of an update, beside those of the cut. They may change from frame to frame.
struct StreamSettings {
    double texel_px = 1;            // pixels that a texel may cover, 0.1 to 100
    double lookahead_s = 0.5;       // how far ahead the eyes' motion is extrapolated; 0: not at all
    double fade_s = 0.3;            // time in which a new mip fades in, 0 to 10
    double now_s = 0;               // the host's clock; must not run backwards
    std::uint32_t pages = 16;       // inserted in a frame at most; some 5 to 10 us each
    std::uint32_t tests = 1u << 16; // pages tested in a frame at most, some 10 ns each
    // Bytes uploaded in a frame at most. One mip is always allowed.
    std::uint32_t map_bytes = 1u << 20;
};

// Bits of StreamReport::exhausted. Each names the field that did not suffice.
enum StreamBudgetBit : std::uint32_t {
    stream_page_slots = 1u << 0, // TerrainBudget::page_slots: wanted pages find no slot
    stream_map_bytes = 1u << 1,  // StreamBudget::map_bytes: wanted mips find no layer
    stream_pages = 1u << 2,      // StreamSettings::pages: more pages had arrived than were inserted
    stream_upload = 1u << 3,     // StreamSettings::map_bytes: more mips had arrived than were uploaded
    stream_tests = 1u << 4,      // StreamSettings::tests: not all pages could be tested
    // StreamBudget::page_requests or map_requests: more is wanted than may be in flight.
    stream_requests = 1u << 5
};
// The name of the field that one bit belongs to.
[[nodiscard]] const char* budget_field(StreamBudgetBit bit);

// A chunk that could not be loaded.
struct StreamFailure {
    ChunkId id;
    StatusCode code = StatusCode::ok; // corrupt, or unreadable if the client reported that
};

// What happened to a page, for recordings. Replayed in the same order, the events give the same terrain.
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
    // Every page that the views want is loaded, so the bound of the cut is that of the whole terrain.
    bool converged = false;
    bool maps_converged = false; // every mip is loaded and faded in too
    // The coarsest page and the smallest mips of every tile are loaded.
    bool complete = false;
    // The largest error on screen that a missing page may hide (Terrain::missing_px). 1e7: no bound is known, because
    // an eye is too near to what is missing or not all pages could be tested.
    double missing_px = 0;
    // How many levels the blurriest tile in view lacks.
    double missing_mips = 0;
    std::uint32_t exhausted = 0;    // StreamBudgetBits
    std::uint32_t pages_wanted = 0; // missing pages whose coarser page is loaded
    // In this frame. pages_left: arrived, but not inserted yet.
    std::uint32_t pages_inserted = 0, pages_left = 0;
    std::uint32_t pages_evicting = 0;
    // mips_left: arrived, or horizons that are read again when the ground is at rest.
    std::uint32_t mips_uploaded = 0, mips_left = 0;
    std::uint32_t in_flight = 0;                 // requests that are queued or with the client
    std::uint32_t cancelled = 0;                 // requests cancelled in this frame
    std::uint32_t failed = 0;                    // chunks, so far
    std::uint64_t bytes_read = 0;                // so far, as stored in the file
    std::uint64_t pages_read = 0, mips_read = 0; // so far
    std::uint64_t map_upload_bytes = 0;          // in this frame
    BudgetUse page_slots;
    std::uint64_t map_bytes_used = 0, map_bytes_capacity = 0;
    double update_us = 0;
};

struct StreamState; // opaque, lives in the host's memory
using Stream = Handle<StreamState>;

// Bytes that create_stream() needs. 0 for a budget that create_stream() refuses.
[[nodiscard]] std::size_t stream_bytes(const Pack& pack, const Terrain& terrain, const StreamBudget& budget);
// Makes a stream. pack: from open_index() or open_pack(); its directory must stay in memory, because updates read it.
// Pack, terrain and cut must outlive the stream. cut: empty if the recursive method draws. memory: at least
// stream_bytes(), aligned to 64. From now on only the stream may load and unload pages of the terrain, because it does
// not notice what others load. Fails with out_of_range, budget_too_small (page slots or map_bytes), memory_too_small,
// or not_supported (linear order).
Status create_stream(const Pack& pack, const Terrain& terrain, LiveCut cut, const StreamBudget& budget,
                     std::span<std::byte> memory, Stream& stream);
// Ends the stream. The pages that it has loaded stay. The client must have stopped before.
Status destroy_stream(Stream stream);

// Inserts what has arrived, requests what the views want, and evicts what they do not want. Call it before
// update_cut(), with the same views and settings. If a terrain has several cuts, pass the views of all of them: a cut
// whose views are left out reports, while any page is missing, the error that no mesh of the terrain can exceed. No
// allocation, lock, system call, page fault or exception.
Status update_stream(Stream stream, std::span<const View> views, const CutSettings& cut, const StreamSettings& settings,
                     StreamReport& report);

// The failures of the last update. Valid until the next one.
[[nodiscard]] std::span<const StreamFailure> stream_failures(Stream stream);
// What happened to pages in the last update, in order. Valid until the next one.
[[nodiscard]] std::span<const PageArrival> stream_page_arrivals(Stream stream);
// Allows chunks that have failed to be requested again.
Status stream_retry_failed(Stream stream);

// --- maps, for the renderer ---

// One change of a map on the GPU. Carry out the commands in order. A command first copies mips inside the GPU, then
// uploads blocks. layer: in the array of size side_log2. Mips count from that array's own mip 0.
struct MapCommand {
    MapKind map;
    std::uint8_t side_log2;
    // The array from which the mips that both arrays have are copied; 0: none.
    std::uint8_t from_log2;
    // How many mips to upload from mip 0 on: 1, all of them for the smallest size, or 0.
    std::uint8_t upload_mips;
    std::uint32_t tile;
    std::uint32_t layer, from_layer;
    std::span<const std::byte>
        blocks; // of upload_mips mips, largest first (fjell/texture.h); valid until the next update
};
// The commands of the last update. Carry them out after each update, whether its mesh is drawn or not.
[[nodiscard]] std::span<const MapCommand> stream_map_commands(Stream stream);

// How a tile's map is sampled: from this layer, with no mip finer than min_lod. min_lod counts from the pack's mip 0,
// changes over time and may lie between two mips. Neighbouring tiles blend theirs along the border with min_lod_grid().
struct TileMap {
    std::uint32_t layer = 0;
    std::uint8_t side_log2 = 0; // 0: nothing is loaded yet
    float min_lod = 0;
};
// One for each tile, of the last update. Empty if the pack has no such map.
[[nodiscard]] std::span<const TileMap> stream_tile_maps(Stream stream, MapKind kind);
// The layers that a renderer makes. Fixed at creation.
[[nodiscard]] MapLayers stream_map_layers(Stream stream, MapKind kind);

// The min_lod at nine places of a tile, row by row from the north-west: its corners, the middles of its sides and its
// centre. Each is the largest of all tiles that share the place. Interpolated bilinearly, min_lod is continuous over
// the whole terrain. maps: one for each tile, row by row. Fails with out_of_range for a tile beyond maps, or if maps
// are not whole rows of tiles_x.
Status min_lod_grid(std::span<const TileMap> maps, std::uint32_t tiles_x, std::uint32_t tile, float (&out)[9]);
// The same for a terrain that may lack tiles. maps: one for each tile of the terrain, by number.
Status min_lod_grid(std::span<const TileMap> maps, const Terrain& terrain, std::uint32_t tile, float (&out)[9]);

// --- the client ---

// What the client is to read.
struct StreamRequest {
    std::uint32_t ticket = 0; // 0: none
    ChunkId id;               // of a map: the first of `chunks` mips that lie one after the other
    std::uint32_t chunks = 0;
    std::uint64_t offset = 0; // in the file
    std::uint32_t bytes = 0;
};
// Takes the request that is wanted most. False: nothing is wanted. The client owns the request until it calls
// stream_provide() or stream_fail() for it.
[[nodiscard]] bool stream_next_request(Stream stream, StreamRequest& request);
// Whether a request is still wanted. If not, answer it with stream_fail(stream, ticket, true).
[[nodiscard]] bool stream_still_wanted(Stream stream, std::uint32_t ticket);
// Hands in the bytes of a request. stored: StreamRequest::bytes of them from its offset; they are copied. Checks their
// hash and decompresses them. Returns corrupt for damaged bytes, which count as a failure of the chunk.
Status stream_provide(Stream stream, std::uint32_t ticket, std::span<const std::byte> stored);
// The same for bytes that the client has checked and decompressed elsewhere, by decode_chunk(): in another process or
// another module's memory. decoded: what StreamRequest::chunks hold, one after the other; copied. Returns corrupt if
// there are more or fewer of them than the directory says; bytes that cannot be a page count as a failure of the chunk
// when they are inserted.
Status stream_provide_decoded(Stream stream, std::uint32_t ticket, std::span<const std::byte> decoded);
// Reports that the bytes of a request could not be read. unwanted: they were not read, because the request was
// cancelled.
Status stream_fail(Stream stream, std::uint32_t ticket, bool unwanted = false);

} // namespace fjell
FJELL_API_END
