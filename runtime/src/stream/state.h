// What a stream keeps in the host's memory.
//
// Two parts. Pages: every slot watches its own page and the pages below it; what is watched is tested against the views
// only when an eye has travelled as far as could have changed the answer (pages.cpp). Maps: every tile has a size of
// each map, and wants one (maps.cpp). Both speak with the client through one table of requests (requests.h).
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "cut/state.h"
#include "fjell/ground_maps.h"
#include "fjell/stream.h"
#include "shared/paint.h"

struct ZSTD_DCtx_s;

namespace fjell {

inline constexpr std::uint32_t max_page_requests = 256, max_map_requests = 64;
inline constexpr std::uint32_t max_requests = max_page_requests + max_map_requests;
inline constexpr std::uint32_t max_decoders = 16;

// Of the client's threads: each takes one while it decompresses.
struct Decoder {
    std::atomic<bool> taken;
    ZSTD_DCtx_s* zstd;
};

// A request's phases and who may end each. The frame's thread: vacant, ready, unreadable, damaged, unwanted, shown. The
// client: taken. Either one, by compare and exchange: offered.
enum class Phase : std::uint32_t { vacant, queued, in_flight, ready, unreadable, damaged, unwanted, shown };

struct Request {
    std::atomic<std::uint32_t> state; // generation << 3 | Phase
    std::atomic<float> score;         // of what is offered: how much it is wanted
    std::atomic<bool> cancelled;      // of what is taken: it need not be read
    ChunkId id;
    std::uint32_t chunks;
    std::uint64_t first_chunk, offset;
    std::uint32_t stored_bytes, raw_bytes;
    std::byte* raw; // room for raw_bytes
    // The frame's thread only.
    std::uint32_t watch; // of a page
    std::uint32_t layer; // of a map: reserved
    // Of a map that is there and is read again, because paint has changed over these samples. The client leaves only
    // what of its mips may be another, in `parts`, largest first. Of a horizon map, whenever it is read: samples that
    // were edited.
    bool repaints;
    edit::Rect painted;
    edit::MapRect parts[max_texture_log2];
};

// A page as the tests see it: a box around its vertices and the largest numbers of any. Metres.
struct Watch {
    float x0, x1, y0, y1, z0, z1;
    float error_m, radius_m;
};
enum class WatchState : std::uint8_t {
    idle,      // there is no such page
    missing,   // not loaded, and may be requested
    in_flight, // in the table
    failed,    // could not be read: not requested again
    loaded,
    evicting // released to the cut, until it has deactivated the vertices
};
// Slot s watches its own page at s * watches_per_slot and the pages below it after that; the tiles' coarsest pages come
// after all slots.
inline constexpr std::uint32_t watches_per_slot = 5;

// An eye that pages are wanted for: of a view, or where its motion will bring it.
struct WantedEye {
    double x, y, z;
    double focal_length_px; // times what the settings and the view's own threshold add to it
    bool predicted;
};

struct MapTile {
    std::uint32_t layer;
    std::uint32_t reserved; // layer for the size above, while it is in flight
    std::uint8_t size_log2; // that is there; 0: none
    std::uint8_t wanted_log2;
    std::uint8_t lower_log2; // while it fades to a smaller size: log2 of that; otherwise 0
    bool in_flight, failed, visible;
    // Sizes of mips to be read again, because paint has changed over samples of this tile, or for horizons the ground
    // around: a bit each, by log2.
    std::uint16_t repaint;
    std::uint8_t repaints; // requests on their way
    edit::Rect painted;
    float excess; // pixels that a texel of size_log2 covers, by those it may
};
struct MapArray { // one size
    std::uint32_t* free_layers;
    std::uint32_t free_count, count;
};
struct MapState {
    MapLayers sizes;
    MapArray arrays[max_texture_log2 + 1];
    MapTile* tiles;
    TileMap* shown;
    std::uint32_t tails_missing; // that have not failed
};

struct StreamState {
    BlockHead head;
    Pack own_pack; // the host's may move
    const Pack* pack;
    Terrain terrain_handle;
    TerrainData* terrain; // its data
    LiveCut cut;
    CutState* cut_state; // its data, or nullptr
    StreamBudget budget;
    std::uint32_t tiles, slots, watch_count;
    // Pages.
    std::uint64_t seen_ground; // of TerrainData::ground_changes
    std::uint64_t seen_awaits; // of EditsData::awaits_changes
    Watch* watches;
    float* due;     // the odometer at which the answer may change
    float* page_px; // as last tested: the threshold in pixels at which it ceases to be wanted
    WatchState* states;
    std::uint8_t* wants;         // 1: by a view or a stamp; 2: by a prediction
    std::uint64_t* missing_bits; // watches that are wanted and not there
    std::uint32_t* watch_page;   // page number in the terrain
    std::uint8_t* below;         // a slot's pages below that are loaded or in flight
    std::uint32_t* slot_watch;   // the watch of its page in the slot above (or the tile's), for each slot
    std::uint32_t* evicting;
    std::uint32_t evicting_count;
    std::uint64_t* failed_bits; // one a chunk
    // Eyes.
    WantedEye eyes[2 * max_cut_views];
    std::uint32_t eye_count;
    Vec3 last_eye[max_cut_views], last_speed[max_cut_views], speed[max_cut_views];
    View views[max_cut_views];
    Frustum frustums[max_cut_views];
    std::uint32_t view_count;
    double threshold_px; // pages that are wanted at it
    double odometer_m;
    std::uint32_t cursor; // of watches, when not all could be tested
    bool tested;          // all of them, for the present eyes
    bool moved;           // an eye has, since the update before
    bool contended;       // there is no slot but for who wants it more than another
    double now_s;
    // Maps.
    MapState maps[map_kinds];
    Watch* tile_box;
    std::uint32_t map_cursor, map_tested; // tiles since the last change
    MapCommand* commands;
    std::uint32_t command_count;
    std::uint64_t seen_paint;       // of PaintData::changes
    std::uint64_t seen_moved;       // of TerrainData::ground_changes, by horizon maps
    std::uint32_t ground_rests;     // updates since the last of them
    std::uint32_t horizons_waiting; // tiles whose horizons are read again when the ground is at rest
    MapPatch* patches;
    std::uint32_t patch_count, patch_room;
    // Requests: pages first.
    Request* requests;
    std::uint32_t request_count;
    std::uint32_t reserved_slots;   // page requests that are not vacant
    Decoder decoders[max_decoders]; // StreamBudget::decoders of them
    // The report.
    StreamReport report;
    StreamSettings settings;
    StreamFailure* failures;
    std::uint32_t failure_count;
    PageArrival* arrivals;
    std::uint32_t arrival_count;
    std::uint32_t slot_peak;
    std::uint64_t bytes_read, pages_read, mips_read, failed;
    std::uint64_t frame;
};
inline constexpr std::uint32_t max_arrivals = 4096, max_evictions = 64;

// The stream behind a handle, or nullptr: also when its terrain or its cut is gone.
[[nodiscard]] inline StreamState* find_stream(const Stream& stream) {
    StreamState* const s = find(stream);
    if (s == nullptr || find(s->terrain_handle) == nullptr) return nullptr;
    return s->cut_state == nullptr || find(s->cut) != nullptr ? s : nullptr;
}
inline constexpr Status no_stream{StatusCode::invalid_handle, "stream, or its terrain or cut"};

[[nodiscard]] inline bool has_failed(const StreamState& s, std::uint64_t chunk) {
    return (s.failed_bits[chunk / 64] >> chunk % 64 & 1) != 0;
}
void note_failure(StreamState& s, const ChunkId& id, std::uint64_t chunk, StatusCode code);

} // namespace fjell
