// Terrain: a pack that is streamed, refined and asked, for one JavaScript object. What LiveTerrain (fjell/io) is to
// C++, without threads and files: JavaScript reads what next_request() names, whenever it can.
//
// Memory: all of it at opening; update() and whatever follows it in a frame allocates nothing.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <new>
#include <vector>

#include "calls.h"
#include "fjell/fjell.h"
#include "io/quiet.h"

namespace fjell::web {

namespace {

struct AlignedFree {
    void operator()(std::byte* memory) const { ::operator delete (memory, std::align_val_t{64}); }
};
struct Block {
    std::unique_ptr<std::byte, AlignedFree> memory;
    std::size_t bytes = 0;
    void allocate(std::size_t wanted) {
        bytes = wanted;
        memory.reset(static_cast<std::byte*>(::operator new (wanted, std::align_val_t{64}, std::nothrow)));
        if (!memory) fail("out of memory: WebAssembly has 4 GB at most; take smaller budgets");
    }
    [[nodiscard]] std::span<std::byte> all() const { return {memory.get(), bytes}; }
};

// Slots that lie side by side, for upload. Two runs with few slots between them are one: a call costs more than that.
struct Runs {
    static constexpr std::uint32_t most = 2048, gap = 32;
    std::array<std::uint32_t, 2 * most> pairs; // first, count
    std::uint32_t count = 0;
    void add(std::uint32_t first, std::uint32_t slots) {
        if (count > 0) {
            std::uint32_t* const last = pairs.data() + 2 * (count - 1);
            if (first - (last[0] + last[1]) < gap || count == most) {
                last[1] = first + slots - last[0];
                return;
            }
        }
        pairs[2 * count] = first, pairs[2 * count + 1] = slots;
        ++count;
    }
};
// Words come in any order, and runs must not.
void take_runs(std::span<const std::uint64_t> bits, std::span<const std::uint32_t> words,
               std::vector<std::uint32_t>& sorted, Runs& runs) {
    sorted.assign(words.begin(), words.end());
    std::sort(sorted.begin(), sorted.end());
    runs.count = 0;
    for_each_run(bits, sorted, [&](std::uint32_t first, std::uint32_t count) { runs.add(first, count); });
}

constexpr std::size_t view_numbers = 18;

struct Ground {
    std::vector<std::byte> index; // header and directory
    Pack pack;
    Block terrain_block, edits_block, cut_block, stream_block;
    Terrain terrain;
    Edits edits;
    LiveCut cut;
    Stream stream;
    CutBudget cut_budget;
    CutSettings settings;
    StreamSettings stream_settings;
    EditSettings edit_settings;
    CutReport report;
    StreamReport stream_report;
    EditReport edit_report;
    std::uint32_t quiet = 0;
    std::array<View, max_cut_views> views;
    Runs vertex_runs, triangle_runs;
    std::vector<std::uint32_t> words;  // of changes, sorted
    std::vector<std::uint32_t> ranges; // to draw: first index, count
    std::vector<std::byte> staging;    // what was read, for ground_provide()
    std::vector<std::uint8_t> texels;  // a map's mip, decoded
};

double address(const void* memory) {
    return static_cast<double>(reinterpret_cast<std::uintptr_t>(memory));
}
Vec3 vector_at(const double* n) {
    return {n[0], n[1], n[2]};
}
void put(double* to, Vec3 v) {
    to[0] = v.x, to[1] = v.y, to[2] = v.z;
}

View view_at(const double* n) {
    View v;
    v.eye_m = vector_at(n);
    v.forward = vector_at(n + 3);
    v.up = vector_at(n + 6);
    v.left = n[9], v.right = n[10], v.bottom = n[11], v.top = n[12];
    v.width_px = static_cast<std::uint32_t>(n[13]), v.height_px = static_cast<std::uint32_t>(n[14]);
    v.near_m = n[15], v.far_m = n[16];
    v.max_error_px = n[17];
    return v;
}

CutBudget suited(CutBudget budget, const Terrain& terrain) { // as fjell::io::suited()
    while (budget.segment_triangles > 8 && budget.triangles / budget.segment_triangles < 4 * terrain.tile_count())
        budget.segment_triangles /= 2;
    return budget;
}

// The largest size of maps that fits: all tiles have them in this size for good, so nothing is copied on the GPU.
std::uint32_t tail_log2_of(const PackHeader& h, double bytes) {
    std::uint32_t log2 = std::max(h.colour_log2, h.normal_log2);
    while (log2 > 2 && 4.0 * h.tiles_x * h.tiles_y * std::exp2(2.0 * log2) > bytes) --log2; // missing tiles, too
    return std::max(log2, 2u);
}

// What one request may bring, as it is stored and decoded: a page, or mips that lie one after the other.
std::size_t largest_request(const Pack& pack) {
    const PackHeader& h = pack.header;
    std::uint64_t most = 0, stored = 0, decoded = 0;
    ChunkId last;
    for (std::uint64_t chunk = 0; chunk < h.directory_count; ++chunk) {
        const ChunkId id = chunk_id(h, chunk);
        const ChunkEntry e = pack.entry(chunk);
        const bool follows = id.kind != ChunkKind::geometry && id.kind == last.kind && id.tile == last.tile;
        stored = (follows ? stored : 0) + e.stored_bytes, decoded = (follows ? decoded : 0) + e.raw_bytes;
        most = std::max({most, stored, decoded});
        last = id;
    }
    return static_cast<std::size_t>(most);
}

// What is drawn, tile by tile; ranges that touch are one.
void list_ranges(Ground& g, std::span<const TileRange> tiles) {
    g.ranges.clear();
    for (const TileRange& t : tiles) {
        if (t.index_count == 0) continue;
        const std::size_t n = g.ranges.size();
        if (n > 0 && t.first_index + t.index_count == g.ranges[n - 2]) // a tile's segments come last first
            g.ranges[n - 2] = t.first_index, g.ranges[n - 1] += t.index_count;
        else if (n > 0 && g.ranges[n - 2] + g.ranges[n - 1] == t.first_index)
            g.ranges[n - 1] += t.index_count;
        else
            g.ranges.push_back(t.first_index), g.ranges.push_back(t.index_count);
    }
}

void open_stream(Ground& g, std::uint32_t pages, std::uint32_t maps, double map_bytes) {
    StreamBudget stream;
    stream.page_requests = pages, stream.map_requests = maps;
    if (map_bytes > 0) stream.tail_log2 = tail_log2_of(g.pack.header, map_bytes);
    // Maps stay in the size of the tail: a layer for each tile, and no other.
    StreamBudget all = stream;
    all.map_bytes = std::uint64_t{1} << 40;
    stream.map_bytes = 0;
    for (const MapKind kind : {MapKind::colour, MapKind::normal}) {
        MapLayers layers = map_layers(g.pack.header, all, kind);
        std::fill(layers.layers + layers.tail_log2 + 1, std::end(layers.layers), 0u);
        if (layers.tail_log2 != 0) stream.map_bytes += map_layer_bytes(layers, kind);
    }
    g.stream_block.allocate(std::max<std::size_t>(stream_bytes(g.pack, g.terrain, stream), 64));
    require(create_stream(g.pack, g.terrain, g.cut, stream, g.stream_block.all(), g.stream), "open");
    g.staging.resize(largest_request(g.pack));
    const std::uint32_t side = 1u << std::max(stream_map_layers(g.stream, MapKind::colour).tail_log2,
                                              stream_map_layers(g.stream, MapKind::normal).tail_log2);
    g.texels.resize(7 * std::size_t{side} * side); // RGBA, and then what it was decoded to
}

} // namespace

// --- opening. header: the first 512 bytes of the file.

// numbers: where the directory is, and how many bytes it has.
FJELL_CALL void pack_index(const std::byte* header, double file_bytes) {
    PackHeader h;
    require(read_header({header, sizeof(PackHeader)}, static_cast<std::uint64_t>(file_bytes), h), "pack");
    numbers[0] = static_cast<double>(h.directory_offset);
    numbers[1] = static_cast<double>(directory_bytes(h));
}

// index: header, then directory; copied. numbers: where the corners are, and their bytes; then 14 numbers of the pack.
// is_set: of several files. No file alone may be sparse.
FJELL_CALL Ground* ground_index(const std::byte* index, std::size_t bytes, double file_bytes, bool is_set) {
    auto g = std::make_unique<Ground>();
    g->index.assign(index, index + bytes);
    const std::span all(g->index);
    require(open_index(all.first(sizeof(PackHeader)), all.subspan(sizeof(PackHeader)),
                       static_cast<std::uint64_t>(file_bytes), g->pack),
            "pack");
    const PackHeader& h = g->pack.header;
    if (h.order == PageOrder::linear)
        fail("pack: is in linear order, which cannot be streamed; bake it with --order planar");
    if (h.tiles_held != 0 && !is_set) fail("pack: says that it lacks tiles; copy or bake it again");
    const ChunkEntry corners = g->pack.entry(chunk_index(h, {ChunkKind::corners, 0, 0}));
    const double facts[] = {static_cast<double>(corners.offset),
                            static_cast<double>(corners.stored_bytes),
                            static_cast<double>(h.columns),
                            static_cast<double>(h.rows),
                            h.spacing_m[0],
                            h.spacing_m[1],
                            static_cast<double>(h.min_m),
                            static_cast<double>(h.max_m),
                            static_cast<double>(h.quantum_m),
                            static_cast<double>(h.tiles_x),
                            static_cast<double>(h.tiles_y),
                            static_cast<double>(1u << h.tile_log2),
                            static_cast<double>(h.colour_log2),
                            static_cast<double>(h.normal_log2),
                            h.crs_origin[0],
                            h.crs_origin[1],
                            static_cast<double>(h.voids),
                            static_cast<double>(tiles_of(h) * std::uint64_t{pages_per_tile(h)})};
    std::copy(std::begin(facts), std::end(facts), numbers);
    return g.release();
}

// whole: all pages are loaded one by one (ground_page(), ground_insert()), and nothing is streamed.
// numbers: page slots (0: all pages), vertices, triangles, views, requests of pages, of maps, bytes of maps in RGBA (0:
// none), blocks of edits (0: none). Afterwards: bytes allocated, log2 of the maps' texels a side, of colour and normal.
FJELL_CALL void ground_open(Ground* g, const std::byte* corners, std::size_t bytes, bool whole) {
    PackHeader& h = g->pack.header;
    if (numbers[6] == 0) h.colour_log2 = h.normal_log2 = 0; // so that no map is read
    const auto count = [](int i) { return static_cast<std::uint32_t>(numbers[i]); };
    const std::uint64_t pages = tiles_of(h) * std::uint64_t{pages_per_tile(h)};
    const TerrainBudget slots{count(0) == 0 ? 0 : static_cast<std::uint32_t>(std::min<std::uint64_t>(count(0), pages))};
    g->terrain_block.allocate(terrain_bytes(h, slots));
    require(create_terrain(g->pack, {corners, bytes}, slots, g->terrain_block.all(), g->terrain), "open");
    if (count(7) != 0) {
        const EditBudget budget{.blocks = count(7), .holes = has_room_for_holes(h), .locks = count(7)};
        g->edits_block.allocate(edits_bytes(h, budget));
        require(create_edits(g->terrain, budget, g->edits_block.all(), g->edits), "open");
    }
    g->cut_budget = suited({.vertices = count(1), .triangles = count(2), .views = count(3)}, g->terrain);
    const std::size_t wanted = cut_bytes(g->terrain, g->cut_budget);
    g->cut_block.allocate(std::max<std::size_t>(wanted, 64));
    require(create_cut(g->terrain, g->cut_budget, g->cut_block.all(), g->cut), "open");
    if (!whole) open_stream(*g, count(4), count(5), numbers[6]);
    g->words.reserve(std::max(g->cut_budget.vertices, g->cut_budget.triangles) / 64 + 1);
    g->ranges.reserve(2 * (g->cut_budget.triangles / g->cut_budget.segment_triangles + 1));
    numbers[0] = static_cast<double>(g->terrain_block.bytes + g->edits_block.bytes + g->cut_block.bytes +
                                     g->stream_block.bytes + g->index.size() + g->texels.size());
    numbers[1] = stream_map_layers(g->stream, MapKind::colour).tail_log2;
    numbers[2] = stream_map_layers(g->stream, MapKind::normal).tail_log2;
    const CutMesh mesh = cut_mesh(g->cut);
    numbers[3] = address(mesh.mesh.vertices.data()), numbers[4] = static_cast<double>(mesh.mesh.vertices.size());
    numbers[5] = address(mesh.mesh.indices.data()), numbers[6] = static_cast<double>(mesh.mesh.indices.size());
    numbers[7] = address(mesh.morph.data()), numbers[8] = address(g->ranges.data());
    numbers[9] = static_cast<double>(g->ranges.capacity());
    numbers[10] = address(g->vertex_runs.pairs.data()), numbers[11] = address(g->triangle_runs.pairs.data());
    numbers[12] = address(g->staging.data()), numbers[13] = static_cast<double>(g->staging.size());
}
FJELL_CALL void ground_close(Ground* g) {
    delete g;
}

// --- a frame

// numbers, from 256 on: 18 for each view. From 0 on: settings; afterwards the report.
FJELL_CALL void ground_update(Ground* g, std::uint32_t views, double now_s) {
    for (std::size_t i = 0; i < views; ++i) g->views[i] = view_at(numbers + 256 + i * view_numbers);
    const std::span<const View> seen(g->views.data(), views);
    CutSettings& c = g->settings;
    c.max_error_px = numbers[0], c.hysteresis = numbers[1];
    c.max_work = numbers[2] > 0 ? static_cast<std::uint32_t>(numbers[2]) : unlimited_work;
    c.max_time_us = numbers[3];
    c.morph = static_cast<Morph>(numbers[4]), c.morph_s = numbers[5], c.offscreen_factor = numbers[6];
    c.now_s = g->stream_settings.now_s = now_s;
    g->stream_settings.pages = static_cast<std::uint32_t>(numbers[7]);
    g->stream_settings.texel_px = 100; // maps stay in one size
    if (g->edits_block.bytes != 0) require(update_edits(g->edits, seen, g->edit_settings, g->edit_report), "edits");
    if (g->stream_block.bytes != 0)
        require(update_stream(g->stream, seen, c, g->stream_settings, g->stream_report), "update");
    require(update_cut(g->cut, seen, c, g->report), "update");
    const CutMesh mesh = cut_mesh(g->cut);
    list_ranges(*g, mesh.mesh.tiles);
    const CutReport& r = g->report;
    const StreamReport& s = g->stream_report;
    const bool converged = r.converged && (s.converged || g->stream_block.bytes == 0);
    const bool settled = io::is_settled(converged, r, s, g->edit_report, g->quiet);
    const double report[] = {static_cast<double>(g->ranges.size() / 2),
                             converged ? 1.0 : 0.0,
                             settled ? 1.0 : 0.0,
                             static_cast<double>(r.vertices),
                             static_cast<double>(r.triangles),
                             static_cast<double>(r.triangles_drawn),
                             r.error_bound_px,
                             r.threshold_px,
                             static_cast<double>(r.waiting),
                             static_cast<double>(r.exhausted),
                             static_cast<double>(s.exhausted),
                             static_cast<double>(s.in_flight),
                             static_cast<double>(s.failed),
                             static_cast<double>(s.bytes_read),
                             static_cast<double>(s.pages_read),
                             s.missing_px,
                             s.complete ? 1.0 : 0.0,
                             r.prepare_us + r.refine_us + r.output_us,
                             s.update_us,
                             static_cast<double>(r.work),
                             static_cast<double>(r.activations),
                             static_cast<double>(r.deactivations),
                             static_cast<double>(s.maps_converged),
                             static_cast<double>(stream_map_commands(g->stream).size()),
                             static_cast<double>(mesh.frame.now_s),
                             static_cast<double>(mesh.frame.morph_s),
                             static_cast<double>(mesh.frame.views),
                             static_cast<double>(g->terrain.pages_loaded())};
    std::copy(std::begin(report), std::end(report), numbers);
    double* to = numbers + 64; // MorphView
    for (std::uint32_t i = 0; i < mesh.frame.views; ++i) {
        const MorphView& v = mesh.frame.view[i];
        for (const float n : {v.eye_x, v.eye_y, v.eye_z, v.start_per_error, v.full_per_error})
            *to++ = static_cast<double>(n);
    }
}
// numbers: runs of vertices, runs of triangles.
FJELL_CALL void ground_changes(Ground* g) {
    const CutChanges changes = cut_take_changes(g->cut);
    take_runs(changes.vertex_bits, changes.vertex_words, g->words, g->vertex_runs);
    take_runs(changes.triangle_bits, changes.triangle_words, g->words, g->triangle_runs);
    numbers[0] = g->vertex_runs.count, numbers[1] = g->triangle_runs.count;
}
// A map of a tile that has come, the `command`th of this frame. numbers: kind (0 colour, 1 normal), the tile's place
// among all places row by row, mips.
FJELL_CALL void ground_map(Ground* g, std::uint32_t command) {
    const MapCommand& m = stream_map_commands(g->stream)[command];
    const SampleIndex place = g->terrain.tile_place(m.layer); // maps stay in one size: a layer is a tile
    numbers[0] = static_cast<double>(m.map);
    numbers[1] = static_cast<double>(place.row) * g->pack.header.tiles_x + place.column, numbers[2] = m.upload_mips,
    numbers[3] = m.side_log2;
}
// Its mip as RGBA: colour, or east and south of the normal. Valid until the next call.
FJELL_CALL const std::uint8_t* ground_map_mip(Ground* g, std::uint32_t command, std::uint32_t mip) {
    const MapCommand& m = stream_map_commands(g->stream)[command];
    const bool colour = m.map == MapKind::colour;
    const std::size_t block_bytes = colour ? colour_block_bytes : normal_block_bytes, components = colour ? 3 : 2;
    std::uint32_t side = 1u << m.side_log2;
    std::size_t first = 0;
    for (std::uint32_t i = 0; i < mip; ++i, side /= 2) first += blocks_of(side) * block_bytes;
    const std::size_t texels = std::size_t{side} * side;
    const std::span blocks = m.blocks.subspan(first, blocks_of(side) * block_bytes);
    std::uint8_t* const rgba = g->texels.data();
    const std::span decoded(rgba + 4 * texels, components * texels);
    require(colour ? decode_colour(blocks, side, decoded) : decode_normal(blocks, side, decoded), "map");
    for (std::size_t i = 0; i < texels; ++i) {
        rgba[4 * i] = decoded[components * i], rgba[4 * i + 1] = decoded[components * i + 1];
        rgba[4 * i + 2] = colour ? decoded[components * i + 2] : 0, rgba[4 * i + 3] = 255;
    }
    return rgba;
}

// --- reading

// Whether something is to be read. numbers: ticket, offset, bytes, chunks; of each chunk four more: its bytes as they
// are stored and decoded, and the halves of its hash. Those are what chunk_decode() needs.
FJELL_CALL bool ground_next_request(Ground* g) {
    StreamRequest r;
    if (!stream_next_request(g->stream, r)) return false;
    numbers[0] = r.ticket, numbers[1] = static_cast<double>(r.offset), numbers[2] = r.bytes, numbers[3] = r.chunks;
    double* to = numbers + 4;
    for (std::uint32_t i = 0; i < r.chunks; ++i) {
        const ChunkEntry e = g->pack.entry(chunk_index(g->pack.header, r.id) + i);
        *to++ = e.stored_bytes, *to++ = e.raw_bytes;
        *to++ = static_cast<double>(e.hash >> 32), *to++ = static_cast<double>(e.hash & 0xffff'ffff);
    }
    return true;
}
// Decodes a chunk somewhere else, in a worker. False: it is not what its hash says.
FJELL_CALL bool chunk_decode(const std::byte* stored, std::size_t stored_bytes, std::byte* decoded,
                             std::size_t decoded_bytes, std::uint32_t hash_high, std::uint32_t hash_low) {
    ChunkEntry e{};
    e.hash = std::uint64_t{hash_high} << 32 | hash_low;
    e.stored_bytes = static_cast<std::uint32_t>(stored_bytes), e.raw_bytes = static_cast<std::uint32_t>(decoded_bytes);
    return decode_chunk(e, {stored, stored_bytes}, {decoded, decoded_bytes}).ok();
}
FJELL_CALL bool ground_still_wanted(Ground* g, std::uint32_t ticket) {
    return stream_still_wanted(g->stream, ticket);
}
// The bytes lie in the staging area. False: they are not what the pack says.
FJELL_CALL bool ground_provide(Ground* g, std::uint32_t ticket, std::size_t bytes, bool decoded) {
    const std::span given = std::span<const std::byte>(g->staging).first(std::min(bytes, g->staging.size()));
    return (decoded ? stream_provide_decoded(g->stream, ticket, given) : stream_provide(g->stream, ticket, given)).ok();
}
// Without a stream: where the page is that is loaded next. numbers: offset, bytes.
FJELL_CALL void ground_page(Ground* g, std::uint32_t page) {
    const PackHeader& h = g->pack.header;
    const std::uint32_t of_tile = pages_per_tile(h);
    const ChunkEntry e = g->pack.entry(chunk_index(h, {ChunkKind::geometry, page / of_tile, page % of_tile}));
    numbers[0] = static_cast<double>(e.offset), numbers[1] = e.stored_bytes;
}
FJELL_CALL void ground_insert(Ground* g, std::uint32_t page, const std::byte* stored, std::size_t bytes) {
    const PackHeader& h = g->pack.header;
    const std::uint32_t of_tile = pages_per_tile(h);
    const ChunkEntry e = g->pack.entry(chunk_index(h, {ChunkKind::geometry, page / of_tile, page % of_tile}));
    std::vector<std::byte> raw(e.raw_bytes);
    require(decode_chunk(e, {stored, bytes}, raw), "page");
    require(insert_page(g->terrain, page / of_tile, page % of_tile, raw), "page");
}
FJELL_CALL void ground_fail(Ground* g, std::uint32_t ticket, bool unwanted) {
    (void)stream_fail(g->stream, ticket, unwanted);
}
FJELL_CALL void ground_retry(Ground* g) {
    (void)stream_retry_failed(g->stream);
}

// --- questions

// numbers: whether there is ground, height, error, normal.
FJELL_CALL void ground_height_at(Ground* g, double x_m, double z_m) {
    const GroundHeight h = ground_height(g->terrain, x_m, z_m);
    numbers[0] = h.inside && !h.hole ? 1 : 0, numbers[1] = h.height_m, numbers[2] = static_cast<double>(h.error_m);
    put(numbers + 3, h.normal);
}
// numbers: origin, direction, how far. Afterwards: whether it hits, distance, position, normal, error.
FJELL_CALL void ground_ray(Ground* g) {
    const GroundHit h = cast_ray(g->terrain, vector_at(numbers), vector_at(numbers + 3), numbers[6]);
    numbers[0] = h.hit ? 1 : 0, numbers[1] = h.distance_m;
    put(numbers + 2, h.position_m);
    put(numbers + 5, h.normal);
    numbers[8] = static_cast<double>(h.error_m);
}
// The range of drawn triangles of a tile's segment, the `i`th. numbers: tile column, tile row, first index, count.
FJELL_CALL bool ground_tile(Ground* g, std::uint32_t i) {
    const std::span<const TileRange> tiles = cut_mesh(g->cut).mesh.tiles;
    if (i >= tiles.size()) return false;
    const SampleIndex place = g->terrain.tile_place(tiles[i].tile);
    numbers[0] = place.column, numbers[1] = place.row, numbers[2] = tiles[i].first_index,
    numbers[3] = tiles[i].index_count;
    return true;
}
// The height that a vertex is drawn at, morphed or not.
FJELL_CALL double ground_drawn_height(Ground* g, std::uint32_t vertex) {
    const CutMesh mesh = cut_mesh(g->cut);
    return static_cast<double>(
        morphed_height_m(g->terrain, mesh.mesh.vertices[vertex], mesh.morph[vertex], mesh.frame));
}

// --- changes of the ground

const char* why(const Status& status) {
    return *status.field ? status.field : message(status.code);
}

// numbers: shape, x, z, radius, falloff, amount, height, slope x, slope z, wavelength, seed; afterwards the stamp's
// number. Returns why it is refused, or an empty text.
FJELL_CALL const char* ground_edit(Ground* g) {
    Stamp s;
    static_assert(StampShape::unlock == static_cast<StampShape>(13)); // package/terrain.js numbers them too
    s.shape = static_cast<StampShape>(numbers[0]);
    s.x_m = numbers[1], s.z_m = numbers[2];
    s.radius_m = static_cast<float>(numbers[3]), s.falloff_m = static_cast<float>(numbers[4]);
    s.amount_m = static_cast<float>(numbers[5]), s.height_m = static_cast<float>(numbers[6]);
    s.slope_x = static_cast<float>(numbers[7]), s.slope_z = static_cast<float>(numbers[8]);
    s.wavelength_m = static_cast<float>(numbers[9]), s.seed = static_cast<std::uint32_t>(numbers[10]);
    StampId id = 0;
    const Status pushed = push_stamp(g->edits, s, id);
    numbers[0] = static_cast<double>(id);
    return pushed.ok() ? "" : why(pushed);
}

// numbers: its StampState. Returns why it is refused, or an empty text.
FJELL_CALL const char* ground_edit_state(Ground* g, double id) {
    const StampResult result = stamp_state(g->edits, static_cast<StampId>(id));
    numbers[0] = static_cast<double>(result.state);
    return result.state == StampState::refused ? why(result.status) : "";
}

} // namespace fjell::web
