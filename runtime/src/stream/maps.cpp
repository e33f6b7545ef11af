// Mip streaming. A tile has one size of each map: a layer of the array texture of that size, with all smaller mips. The
// next larger size needs one mip from the file; the rest is copied from layer to layer on the GPU. Tiles that want
// less than they have keep it until a layer is needed elsewhere; then they fade to a smaller size first, so that
// neither coming nor going shows.
#include "stream/maps.h"

#include <algorithm>
#include <cmath>

#include "edit/horizon_maps.h"
#include "edit/paint.h"
#include "fjell/texture.h"
#include "stream/requests.h"
#include "stream/watch.h"

namespace fjell {

namespace {

constexpr std::uint32_t tiles_a_frame = 512;
constexpr std::uint32_t ground_is_at_rest = 16; // updates after the last change

std::uint32_t top_log2(const PackHeader& h, const StreamBudget& budget, MapKind kind) {
    switch (kind) {
    case MapKind::colour: return h.colour_log2;
    case MapKind::normal: return h.normal_log2;
    case MapKind::horizon: return budget.horizons ? h.horizon_log2 : 0;
    case MapKind::splat: return budget.splat ? h.splat_log2 : 0;
    }
    return 0;
}
std::uint64_t block_bytes(MapKind kind) {
    switch (kind) {
    case MapKind::colour: return colour_block_bytes;
    case MapKind::normal: return normal_block_bytes;
    case MapKind::horizon: return horizon_block_bytes;
    case MapKind::splat: break;
    }
    return splat_block_bytes;
}
// One layer of that size with all its mips.
std::uint64_t layer_bytes(std::uint32_t log2, MapKind kind) {
    std::uint64_t blocks = 0;
    for (std::uint32_t side = log2; side >= 2; --side) blocks += blocks_of(1u << side);
    return blocks * block_bytes(kind);
}

constexpr std::uint64_t most_layers = 2048; // that every OpenGL 4.5 has

std::uint32_t tail_of(const PackHeader& h, const StreamBudget& budget, MapKind kind) {
    return std::min(std::max(budget.tail_log2, 2u), top_log2(h, budget, kind));
}
std::uint64_t tails_bytes(const PackHeader& h, const StreamBudget& budget, MapKind kind) {
    if (top_log2(h, budget, kind) == 0) return 0;
    return std::uint64_t{tiles_of(h)} * layer_bytes(tail_of(h, budget, kind), kind);
}
// All that a kind could use beside its tails.
std::uint64_t all_bytes(const PackHeader& h, const StreamBudget& budget, MapKind kind) {
    std::uint64_t bytes = 0;
    const std::uint64_t layers = std::min<std::uint64_t>(tiles_of(h), most_layers);
    for (std::uint32_t log2 = tail_of(h, budget, kind) + 1; log2 <= top_log2(h, budget, kind); ++log2)
        bytes += layers * layer_bytes(log2, kind);
    return bytes;
}

// What a kind may spend beside its tails: a share by the bytes of one layer, and what the others cannot use. Together
// they spend no more than there is: who gets more than its share leaves all others all that they could use.
std::uint64_t share_of(const PackHeader& h, const StreamBudget& budget, MapKind kind) {
    std::uint64_t tails = 0, others = 0;
    double weights = 0, own = 0;
    for (std::uint32_t i = 0; i < map_kinds; ++i) {
        const auto k = static_cast<MapKind>(i);
        const std::uint32_t log2 = top_log2(h, budget, k);
        const double weight = log2 == 0 ? 0.0 : static_cast<double>(layer_bytes(log2, k));
        tails += tails_bytes(h, budget, k);
        weights += weight;
        if (k == kind)
            own = weight;
        else
            others += all_bytes(h, budget, k);
    }
    const std::uint64_t left = budget.map_bytes - std::min(budget.map_bytes, tails);
    const auto mine = static_cast<std::uint64_t>(static_cast<double>(left) * (own / std::max(weights, 1.0)));
    const std::uint64_t all = all_bytes(h, budget, kind), theirs = left - mine;
    return others < theirs ? std::min(all, left - others) : std::min(all, mine);
}

} // namespace

MapLayers map_layers(const PackHeader& h, const StreamBudget& budget, MapKind kind) {
    MapLayers sizes;
    for (const std::uint32_t log2 : {h.colour_log2, h.normal_log2, h.horizon_log2, h.splat_log2})
        if (log2 == 1 || log2 > max_texture_log2) return sizes;
    if (static_cast<std::uint32_t>(kind) >= map_kinds) return sizes;
    sizes.top_log2 = top_log2(h, budget, kind);
    if (sizes.top_log2 == 0) return sizes;
    sizes.tail_log2 = tail_of(h, budget, kind);
    const std::uint64_t tiles = tiles_of(h);
    sizes.layers[sizes.tail_log2] = static_cast<std::uint32_t>(tiles);
    std::uint64_t left = share_of(h, budget, kind);
    for (std::uint32_t log2 = sizes.tail_log2 + 1; log2 <= sizes.top_log2; ++log2) {
        const std::uint64_t bytes = layer_bytes(log2, kind), share = left / (sizes.top_log2 - log2 + 1);
        const std::uint64_t layers = std::min({tiles, share / bytes, most_layers});
        sizes.layers[log2] = static_cast<std::uint32_t>(layers);
        left -= layers * bytes;
    }
    return sizes;
}

std::uint64_t map_layer_bytes(const MapLayers& sizes, MapKind kind) {
    std::uint64_t bytes = 0;
    for (std::uint32_t log2 = 2; log2 <= max_texture_log2; ++log2)
        bytes += sizes.layers[log2] * layer_bytes(log2, kind);
    return bytes;
}

void begin_maps(StreamState& s) {
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
        MapState& m = s.maps[kind];
        if (m.sizes.top_log2 == 0) continue;
        for (std::uint32_t log2 = m.sizes.tail_log2 + 1; log2 <= m.sizes.top_log2; ++log2) {
            MapArray& array = m.arrays[log2];
            array.count = array.free_count = m.sizes.layers[log2];
            for (std::uint32_t i = 0; i < array.count; ++i) array.free_layers[i] = array.count - 1 - i;
        }
        for (std::uint32_t tile = 0; tile < s.tiles; ++tile) {
            m.tiles[tile] = {};
            m.tiles[tile].wanted_log2 = static_cast<std::uint8_t>(m.sizes.tail_log2);
            m.shown[tile] = {};
        }
    }
    for (std::uint32_t tile = 0; tile < s.tiles; ++tile) s.tile_box[tile] = tile_box(s, tile);
    s.seen_moved = s.terrain->ground_changes; // maps that come are of the ground as it is
}

namespace {

void give_layer(MapState& m, std::uint32_t log2, std::uint32_t layer) {
    if (log2 <= m.sizes.tail_log2) return; // a tile's own
    MapArray& array = m.arrays[log2];
    FJELL_ASSERT(layer < array.count && array.free_count < array.count); // or it was given back twice
    array.free_layers[array.free_count++] = layer;
}

MapState& map_of(StreamState& s, const Request& r) {
    return s.maps[map_of_chunks(r.id.kind)];
}
std::uint32_t requested_log2(const MapState& m, const Request& r) {
    return m.sizes.top_log2 - r.id.item;
}

// Bits of the mips that a request for a size brings.
std::uint32_t sizes_of_request(const MapState& m, std::uint32_t log2) {
    return log2 == m.sizes.tail_log2 ? (2u << log2) - 1 : 1u << log2;
}

void end_map_request(StreamState& s, Request& r, bool failed) {
    MapState& m = map_of(s, r);
    MapTile& tile = m.tiles[r.id.tile];
    if (r.repaints) { // what is shown stays
        --tile.repaints;
        if (!failed) tile.repaint |= static_cast<std::uint16_t>(sizes_of_request(m, requested_log2(m, r)));
        set_phase(r, Phase::vacant);
        return;
    }
    tile.in_flight = false;
    tile.failed = failed;
    give_layer(m, requested_log2(m, r), r.layer);
    s.map_tested = 0;
    set_phase(r, Phase::vacant);
}

// The blocks stay in the request's room until the next update.
void show(StreamState& s, Request& r) {
    MapState& m = map_of(s, r);
    MapTile& tile = m.tiles[r.id.tile];
    const std::uint32_t log2 = requested_log2(m, r);
    FJELL_ASSERT(tile.in_flight && s.command_count < s.request_count + max_evictions);
    s.commands[s.command_count++] = {static_cast<MapKind>(map_of_chunks(r.id.kind)),
                                     static_cast<std::uint8_t>(log2),
                                     tile.size_log2,
                                     static_cast<std::uint8_t>(r.chunks),
                                     r.id.tile,
                                     r.layer,
                                     tile.layer,
                                     {r.raw, r.raw_bytes}};
    TileMap& shown = m.shown[r.id.tile];
    if (tile.size_log2 == 0)
        shown.min_lod = static_cast<float>(m.sizes.top_log2 - log2); // nothing to fade from
    else
        give_layer(m, tile.size_log2, tile.layer);
    tile.size_log2 = static_cast<std::uint8_t>(log2);
    tile.excess /= 2;
    tile.layer = r.layer;
    tile.in_flight = false;
    shown.layer = tile.layer;
    shown.side_log2 = tile.size_log2;
    s.map_tested = 0;
    set_phase(r, Phase::shown);
}

// Parts of mips that were read again. publish_patches() puts in where they belong by then.
void show_again(StreamState& s, Request& r) {
    MapState& m = map_of(s, r);
    const std::byte* from = r.raw;
    for (std::uint32_t i = 0; i < r.chunks; ++i) {
        const edit::MapRect& part = r.parts[i];
        const std::size_t bytes = std::size_t{part.columns} * part.rows / 16 *
                                  (r.id.kind == ChunkKind::splat ? splat_block_bytes : colour_block_bytes);
        if (bytes != 0)
            s.patches[s.patch_count++] = {.map = static_cast<MapKind>(map_of_chunks(r.id.kind)),
                                          .side_log2 = static_cast<std::uint8_t>(requested_log2(m, r) - i),
                                          .mip = 0,
                                          .tile = r.id.tile,
                                          .layer = 0,
                                          .x = part.x,
                                          .y = part.y,
                                          .columns = part.columns,
                                          .rows = part.rows,
                                          .blocks = {from, bytes}};
        from += bytes;
    }
    --m.tiles[r.id.tile].repaints;
    set_phase(r, Phase::shown);
}

} // namespace

void upload_maps(StreamState& s) {
    for (std::uint32_t i = s.budget.page_requests; i < s.request_count; ++i) {
        Request& r = s.requests[i];
        switch (phase_of(r)) {
        case Phase::damaged:
        case Phase::unreadable:
            note_failure(s, r.id, r.first_chunk,
                         phase_of(r) == Phase::damaged ? StatusCode::corrupt : StatusCode::unreadable);
            end_map_request(s, r, true);
            break;
        case Phase::unwanted: end_map_request(s, r, false); break;
        default: break;
        }
    }
    while (Request* const r = best_ready(s, s.budget.page_requests, s.request_count)) {
        if (r->repaints && s.patch_count + r->chunks > s.patch_room) break; // the next update goes on
        if (s.report.mips_uploaded != 0 && s.report.map_upload_bytes + r->raw_bytes > s.settings.map_bytes) {
            s.report.exhausted |= stream_upload;
            break;
        }
        ++s.report.mips_uploaded;
        s.report.map_upload_bytes += r->raw_bytes;
        s.bytes_read += r->stored_bytes;
        s.mips_read += r->chunks;
        r->repaints ? show_again(s, *r) : show(s, *r);
    }
}

namespace {

float score_of(const MapTile& tile) {
    return tile.excess * (tile.visible ? 8.0f : 1.0f) + (tile.size_log2 == 0 ? 5e8f : 0.0f);
}

void test_tile(StreamState& s, std::uint32_t index) {
    const Watch& box = s.tile_box[index];
    // Pixels that a metre takes, at the nearest point to any eye.
    double px_m = 0;
    for (std::uint32_t i = 0; i < s.view_count; ++i)
        px_m = std::max(px_m, focal_length_px(s.views[i]) / std::max(distance_m(box, s.views[i].eye_m), 1e-3));
    const TerrainData& t = *s.terrain;
    const double tile_m = static_cast<double>(std::max(t.spacing_x_m, t.spacing_z_m)) * t.tree.side();
    const bool visible = may_be_seen(s, box);
    for (MapState& m : s.maps) {
        if (m.sizes.top_log2 == 0) continue;
        MapTile& tile = m.tiles[index];
        const auto excess = [&](std::uint32_t log2) {
            return tile_m / ((1u << log2) - 1) * px_m / s.settings.texel_px;
        };
        std::uint32_t wanted = m.sizes.tail_log2;
        while (wanted < m.sizes.top_log2 && excess(wanted) > 1) ++wanted;
        tile.wanted_log2 = static_cast<std::uint8_t>(wanted);
        tile.visible = visible;
        tile.excess = static_cast<float>(std::min(excess(std::max<std::uint32_t>(tile.size_log2, 2)), 1e7));
    }
}

// The tile that wants its layer of that size least, begins to give it back. False: all want theirs more.
bool make_room(StreamState& s, MapState& m, std::uint32_t log2, float score) {
    std::uint32_t least = no_index;
    float least_score = score / 2;
    for (std::uint32_t i = 0; i < s.tiles; ++i) {
        const MapTile& tile = m.tiles[i];
        if (tile.size_log2 != log2 || tile.in_flight) continue;
        if (tile.lower_log2 != 0) return true; // one is on its way
        // How much it would lack without it.
        const float lacks = tile.wanted_log2 < log2 ? 0 : 2 * score_of(tile);
        if (lacks < least_score) least = i, least_score = lacks;
    }
    if (least == no_index) return false;
    MapTile& tile = m.tiles[least];
    std::uint32_t lower = log2 - 1;
    while (lower > m.sizes.tail_log2 && m.arrays[lower].free_count == 0) --lower;
    tile.reserved = lower == m.sizes.tail_log2 ? least : m.arrays[lower].free_layers[--m.arrays[lower].free_count];
    tile.lower_log2 = static_cast<std::uint8_t>(lower);
    return true;
}

// A vacant entry, or one whose offer is wanted less than half as much.
Request* request_for(StreamState& s, float score) {
    if (Request* const vacant = vacant_request(s, true)) return vacant;
    Request* least = nullptr;
    float least_score = score / 2;
    for (std::uint32_t i = s.budget.page_requests; i < s.request_count; ++i) {
        Request& r = s.requests[i];
        if (phase_of(r) != Phase::queued || r.repaints || r.score.load(std::memory_order_relaxed) >= least_score)
            continue;
        least = &r;
        least_score = r.score.load(std::memory_order_relaxed);
    }
    if (!least || !claim(*least, Phase::vacant)) return nullptr;
    end_map_request(s, *least, false);
    ++s.report.cancelled;
    return least;
}

// full: sizes, by kind, whose layers are all taken and that room is being made for. False: the table is full.
bool request_map(StreamState& s, const Candidate& c, std::uint32_t (&full)[map_kinds]) {
    MapState& m = s.maps[c.kind];
    MapTile& tile = m.tiles[c.which];
    const bool tail = tile.size_log2 == 0;
    const std::uint32_t log2 = tail ? m.sizes.tail_log2 : tile.size_log2 + 1u;
    const ChunkId id{chunks_of_map(c.kind), c.which, m.sizes.top_log2 - log2};
    const std::uint64_t chunk = chunk_index(s.pack->header, id);
    if (has_failed(s, chunk)) {
        tile.failed = true;
        return true;
    }
    if (!tail && m.arrays[log2].free_count == 0) {
        if (!(full[c.kind] >> log2 & 1) && !make_room(s, m, log2, static_cast<float>(c.score)))
            s.report.exhausted |= stream_map_bytes;
        full[c.kind] |= 1u << log2;
        return true;
    }
    Request* const r = request_for(s, static_cast<float>(c.score));
    if (!r) return false;
    r->repaints = false; // before a client may see it
    if (id.kind == ChunkKind::horizon) r->painted = edit::edited_near(*s.terrain, id.tile);
    if (!queue_request(s, *r, id, tail ? m.sizes.tail_log2 - 1 : 1, static_cast<float>(c.score))) {
        note_failure(s, id, chunk, StatusCode::corrupt);
        tile.failed = true;
        return true;
    }
    tile.repaint &= static_cast<std::uint16_t>(~sizes_of_request(m, log2)); // it will be painted as it is by then
    r->layer = tail ? c.which : m.arrays[log2].free_layers[--m.arrays[log2].free_count];
    tile.in_flight = true;
    return true;
}

void review_maps(StreamState& s) {
    for (std::uint32_t i = s.budget.page_requests; i < s.request_count; ++i) {
        Request& r = s.requests[i];
        const Phase phase = phase_of(r);
        if (phase != Phase::queued && phase != Phase::in_flight) continue;
        if (r.repaints) continue;
        MapState& m = map_of(s, r);
        const MapTile& tile = m.tiles[r.id.tile];
        const bool wanted = tile.size_log2 == 0 || tile.wanted_log2 > tile.size_log2;
        if (!wanted && claim(r, Phase::vacant)) {
            end_map_request(s, r, false);
            ++s.report.cancelled;
            continue;
        }
        if (wanted) r.score.store(score_of(tile), std::memory_order_relaxed);
        r.cancelled.store(!wanted, std::memory_order_relaxed);
    }
}

// Moves what is shown towards what is there; a tile that fades to a smaller size gives its layer back when nothing of
// it shows.
bool fade(StreamState& s, MapState& m, std::uint32_t index, float step) {
    MapTile& tile = m.tiles[index];
    TileMap& shown = m.shown[index];
    if (tile.size_log2 == 0) return true;
    const auto target = static_cast<float>(m.sizes.top_log2 - (tile.lower_log2 ? tile.lower_log2 : tile.size_log2));
    shown.min_lod =
        shown.min_lod < target ? std::min(shown.min_lod + step, target) : std::max(shown.min_lod - step, target);
    if (shown.min_lod != target) return false;
    if (tile.lower_log2 == 0) return true;
    if (s.command_count == s.request_count + max_evictions) return false;
    const auto kind = static_cast<MapKind>(&m - s.maps);
    s.commands[s.command_count++] = {kind, tile.lower_log2, tile.size_log2, 0, index, tile.reserved, tile.layer, {}};
    give_layer(m, tile.size_log2, tile.layer);
    tile.size_log2 = tile.lower_log2;
    tile.layer = tile.reserved;
    tile.lower_log2 = 0;
    tile.excess *= 2;
    shown.layer = tile.layer;
    shown.side_log2 = tile.size_log2;
    s.map_tested = 0;
    return true;
}

// Whether the tile has all it wants, and shows it.
bool satisfied(StreamState& s, std::uint32_t kind, std::uint32_t index, float step, Best& best) {
    MapState& m = s.maps[kind];
    const bool faded = fade(s, m, index, step);
    const MapTile& tile = m.tiles[index];
    const bool tail = tile.size_log2 == 0;
    m.tails_missing += tail;
    const bool painted = (tile.repaint & ((2u << tile.size_log2) - 1)) == 0 && tile.repaints == 0;
    if (!painted && s.ground_rests < ground_is_at_rest && kind == static_cast<std::uint32_t>(MapKind::horizon))
        ++s.horizons_waiting;
    if (!tail && tile.wanted_log2 <= tile.size_log2) return faded && painted;
    const double lacks = tile.wanted_log2 - std::max<int>(tile.size_log2, 2);
    if (tile.visible) s.report.missing_mips = std::max(s.report.missing_mips, lacks);
    if (!tile.in_flight && !tile.failed && tile.lower_log2 == 0) best.offer({index, kind, score_of(tile)});
    return false;
}

// visit(number): of the tiles that lie over samples.
template <typename Visit>
void for_each_tile_over(const TerrainData& t, const edit::Rect& samples, const Visit& visit) {
    const auto tile_near = [&](std::int32_t sample, std::uint32_t tiles) {
        return std::clamp(sample >> t.header.tile_log2, 0, static_cast<std::int32_t>(tiles) - 1);
    };
    for (std::int32_t y = tile_near(samples.y0, t.header.tiles_y); y <= tile_near(samples.y1, t.header.tiles_y); ++y)
        for (std::int32_t x = tile_near(samples.x0, t.header.tiles_x); x <= tile_near(samples.x1, t.header.tiles_x);
             ++x)
            visit(t.tile_at(x, y));
}

// Which mips of which tiles paint has changed.
void note_painted(StreamState& s, const edit::Rect& samples) {
    const TerrainData& t = *s.terrain;
    for (const MapKind map : {MapKind::colour, MapKind::splat}) {
        MapState& m = s.maps[static_cast<std::uint32_t>(map)];
        if (m.sizes.top_log2 == 0) continue;
        const std::int32_t reach = t.tree.side(); // the widest texels' is less
        for_each_tile_over(t, samples.grown(reach), [&](std::uint32_t number) {
            MapTile& tile = m.tiles[number];
            for (std::uint32_t log2 = 2; log2 <= m.sizes.top_log2; ++log2)
                if (edit::grid_of_mip(t.header, map, number, log2).texels_over(samples, 1u << log2).columns != 0) {
                    if (tile.repaint == 0 && tile.repaints == 0) tile.painted = {};
                    tile.painted = tile.painted.with(samples);
                    tile.repaint |= static_cast<std::uint16_t>(1u << log2);
                }
        });
    }
}
void follow_paint(StreamState& s) {
    const PaintData* const paint = s.terrain->paint;
    if (paint == nullptr || paint->changes == s.seen_paint) return;
    if (s.seen_paint > paint->changes || paint->changes - s.seen_paint > paint_change_log) {
        note_painted(s, {0, 0, s.terrain->tree.columns() - 1, s.terrain->tree.rows() - 1});
        s.seen_paint = paint->changes;
    }
    for (; s.seen_paint != paint->changes; ++s.seen_paint)
        note_painted(s, paint->changed[s.seen_paint % paint_change_log]);
}

// Which horizons see ground that has moved.
void note_moved(StreamState& s, const edit::Rect& samples) {
    MapState& m = s.maps[static_cast<std::uint32_t>(MapKind::horizon)];
    for_each_tile_over(*s.terrain, samples.grown(edit::horizon_reach), [&](std::uint32_t number) {
        m.tiles[number].repaint = static_cast<std::uint16_t>((2u << m.sizes.top_log2) - 4);
    });
    s.ground_rests = 0;
}
void follow_horizons(StreamState& s) {
    const TerrainData& t = *s.terrain;
    if (s.maps[static_cast<std::uint32_t>(MapKind::horizon)].sizes.top_log2 == 0 || t.raise_horizons == nullptr) return;
    if (s.ground_rests < ground_is_at_rest) ++s.ground_rests;
    if (t.ground_changes == s.seen_moved) return;
    if (t.ground_changes - s.seen_moved > ground_change_log || t.changed_ground == nullptr) {
        note_moved(s, {0, 0, t.tree.columns() - 1, t.tree.rows() - 1});
        s.seen_moved = t.ground_changes;
    }
    for (; s.seen_moved != t.ground_changes; ++s.seen_moved) {
        const GroundChange& change = t.changed_ground[s.seen_moved % ground_change_log];
        if (change.step_log2 != heights_changed) continue;
        const SampleIndex first = t.tree.sample(change.first), last = t.tree.sample(change.last);
        note_moved(s, {first.column, first.row, last.column, last.row});
    }
}

// Reads mips again that are there and that paint has changed, as long as there is room in the table; and horizons when
// the ground is at rest, as one that moves all the time would have them read all the time.
void request_repaints(StreamState& s) {
    for (const MapKind map : {MapKind::colour, MapKind::splat, MapKind::horizon}) {
        const auto kind = static_cast<std::uint32_t>(map);
        MapState& m = s.maps[kind];
        if (map == MapKind::horizon && s.ground_rests < ground_is_at_rest) continue;
        for (std::uint32_t i = 0; m.sizes.top_log2 != 0 && i < s.tiles; ++i) {
            MapTile& tile = m.tiles[i];
            // One after the other: of two of a mip the later one, with more paint, might be shown first.
            if (tile.size_log2 == 0 || tile.repaints != 0) continue;
            // Coarse mips first: a tail is small.
            for (std::uint32_t log2 = m.sizes.tail_log2; log2 <= tile.size_log2; ++log2) {
                const std::uint32_t sizes = sizes_of_request(m, log2);
                if ((tile.repaint & sizes) == 0) continue;
                Request* const r = vacant_request(s, true);
                if (r == nullptr) return;
                const ChunkId id{chunks_of_map(kind), i, m.sizes.top_log2 - log2};
                tile.repaint &= static_cast<std::uint16_t>(~sizes);
                if (has_failed(s, chunk_index(s.pack->header, id))) continue;
                r->repaints = true;
                r->painted = map == MapKind::horizon ? edit::edited_near(*s.terrain, i) : tile.painted;
                if (queue_request(s, *r, id, log2 == m.sizes.tail_log2 ? log2 - 1 : 1, score_of(tile))) ++tile.repaints;
            }
        }
    }
}

} // namespace

void request_maps(StreamState& s, double seconds) {
    follow_paint(s);
    follow_horizons(s);
    if (s.moved) s.map_tested = 0;
    for (std::uint32_t n = 0; n < tiles_a_frame && s.map_tested < s.tiles; ++n) {
        test_tile(s, s.map_cursor);
        ++s.map_tested;
        s.map_cursor = s.map_cursor + 1 == s.tiles ? 0 : s.map_cursor + 1;
    }
    review_maps(s);
    const float step = s.settings.fade_s > 0 ? static_cast<float>(std::max(seconds, 0.0) / s.settings.fade_s) : 1e9f;
    s.report.maps_converged = s.map_tested >= s.tiles;
    s.horizons_waiting = 0;
    Best best;
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
        if (s.maps[kind].sizes.top_log2 == 0) continue;
        s.maps[kind].tails_missing = 0;
        for (std::uint32_t i = 0; i < s.tiles; ++i)
            if (!satisfied(s, kind, i, step, best)) s.report.maps_converged = false;
    }
    best.sort();
    std::uint32_t full[map_kinds] = {};
    for (std::uint32_t i = 0; i < best.count; ++i)
        if (!request_map(s, best.at[i], full)) {
            s.report.exhausted |= stream_requests;
            break;
        }
    if (!s.report.maps_converged && (s.seen_paint != 0 || s.seen_moved != 0)) request_repaints(s);
}

void paint_request(const StreamState& s, Request& r) {
    const PaintData* const paint = load_acquire(s.terrain->paint);
    const std::uint32_t kind = map_of_chunks(r.id.kind), top_log2 = s.maps[kind].sizes.top_log2;
    const auto map = static_cast<MapKind>(kind);
    const std::size_t texel_bytes = map == MapKind::splat ? splat_texel_bytes : 0; // otherwise blocks of 4 x 4
    const auto raise = load_acquire(s.terrain->raise_horizons);
    std::byte *mip = r.raw, *to = r.raw;
    for (std::uint32_t i = 0; i < r.chunks; ++i) {
        const std::uint32_t log2 = top_log2 - (r.id.item + i), side = 1u << log2;
        edit::MapRect at{0, 0, side, side};
        if (map == MapKind::horizon) { // all planes of a mip are one picture
            if (raise != nullptr) raise(*s.terrain, r.painted, r.id.tile, log2, mip);
            r.parts[i] = {0, 0, side * horizon_planes_across, side * horizon_planes_across};
            to = mip += blocks_of(side) * block_bytes(map);
            continue;
        }
        if (r.repaints) at = edit::grid_of_mip(s.terrain->header, map, r.id.tile, log2).texels_over(r.painted, side);
        if (paint != nullptr) (void)edit::paint_mip(*paint, map, r.id.tile, log2, at, mip);
        std::byte* const next = mip + blocks_of(side) * block_bytes(map);
        if (r.repaints) {
            r.parts[i] = at;
            const std::size_t step = texel_bytes != 0 ? 1 : 4,
                              cell = texel_bytes != 0 ? texel_bytes : colour_block_bytes;
            for (std::size_t row = at.y / step; row < (at.y + at.rows) / step; ++row, to += at.columns / step * cell)
                std::memmove(to, mip + (row * (side / step) + at.x / step) * cell, at.columns / step * cell);
        }
        mip = next;
    }
    if (r.repaints) r.raw_bytes = static_cast<std::uint32_t>(to - r.raw);
}

void publish_patches(StreamState& s) {
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < s.patch_count; ++i) {
        MapPatch p = s.patches[i];
        const MapTile& tile = s.maps[static_cast<std::uint32_t>(p.map)].tiles[p.tile];
        if (p.side_log2 > tile.size_log2) continue; // it has been given back
        p.mip = static_cast<std::uint8_t>(tile.size_log2 - p.side_log2);
        p.side_log2 = tile.size_log2;
        p.layer = tile.layer;
        s.patches[kept++] = p;
    }
    s.patch_count = kept;
    s.terrain->map_patches = s.patches;
    s.terrain->map_patch_count = kept;
}

void forget_failed_maps(StreamState& s) {
    for (MapState& m : s.maps)
        for (std::uint32_t i = 0; m.sizes.top_log2 != 0 && i < s.tiles; ++i) m.tiles[i].failed = false;
}

// --- how fine a tile's neighbourhood is

namespace {

// A place on a border belongs to two tiles and a corner to four. Each of them takes the largest over all its owners, so
// they agree there; between the nine places they interpolate the same two numbers along a border, in the same way.
// number(column, row): of a tile, or no_index where there is none.
template <typename Number>
void fill_grid(std::span<const TileMap> maps, std::int64_t column, std::int64_t row, std::uint32_t tile,
               const Number& number, float (&out)[9]) {
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            float most = maps[tile].min_lod;
            for (std::int64_t j = std::max<std::int64_t>(row + std::min(y, 0), 0); j <= row + std::max(y, 0); ++j)
                for (std::int64_t i = std::max<std::int64_t>(column + std::min(x, 0), 0); i <= column + std::max(x, 0);
                     ++i)
                    if (const std::uint32_t of = number(i, j); of != no_index) most = std::max(most, maps[of].min_lod);
            out[3 * (y + 1) + x + 1] = most;
        }
}

} // namespace

Status min_lod_grid(std::span<const TileMap> maps, std::uint32_t tiles_x, std::uint32_t tile, float (&out)[9]) {
    if (tiles_x == 0 || maps.size() % tiles_x != 0) return {StatusCode::out_of_range, "tiles_x"};
    if (tile >= maps.size()) return {StatusCode::out_of_range, "tile"};
    const auto wide = static_cast<std::int64_t>(tiles_x), high = static_cast<std::int64_t>(maps.size()) / wide;
    fill_grid(
        maps, tile % tiles_x, tile / tiles_x, tile,
        [&](std::int64_t i, std::int64_t j) {
            return i < wide && j < high ? static_cast<std::uint32_t>(j * wide + i) : no_index;
        },
        out);
    return {};
}

Status min_lod_grid(std::span<const TileMap> maps, const Terrain& terrain, std::uint32_t tile, float (&out)[9]) {
    const TerrainData* const t = find(terrain);
    if (t == nullptr) return {StatusCode::invalid_handle, "terrain"};
    if (maps.size() != t->tile_count()) return {StatusCode::out_of_range, "maps"};
    if (tile >= maps.size()) return {StatusCode::out_of_range, "tile"};
    const SampleIndex place = t->tile_xy(tile);
    fill_grid(
        maps, place.column, place.row, tile,
        [&](std::int64_t i, std::int64_t j) {
            return i < t->tree.tiles_x && j < t->tree.tiles_y
                       ? t->tile_at(static_cast<std::int32_t>(i), static_cast<std::int32_t>(j))
                       : no_index;
        },
        out);
    return {};
}

} // namespace fjell
