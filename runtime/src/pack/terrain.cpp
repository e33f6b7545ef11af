#include "fjell/terrain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <new>
#include <utility>

#define ZSTD_STATIC_LINKING_ONLY // a decoder in the caller's memory
#include <zstd.h>

#include "block_layout.h"
#include "edit/blocks.h"
#include "pack/memory.h"
#include "pack/page_loops.h"
#include "pack/publish.h"
#include "shared/hash.h"
#include "validate.h"

namespace fjell {

namespace {

std::uint32_t slots_of(const PackHeader& h, const TerrainBudget& budget, const PageLayout& pages) {
    const std::uint32_t all = tiles_of(h) * pages.pages_per_tile();
    return budget.page_slots == 0 ? all : std::min(budget.page_slots, all);
}

// One function for the size and for the placement, so they cannot disagree.
struct Layout {
    std::size_t memory, page_table, records, slot_page, slot_loads, free_slots, corners, tile_numbers, corner_numbers,
        tile_places, tile_corners, zstd, raw, end;
};

Layout layout_of(const PackHeader& h, const TerrainBudget& budget) {
    const PageLayout pages = pages_of(h);
    const std::uint64_t places = std::uint64_t{h.tiles_x} * h.tiles_y,
                        corner_places = (std::uint64_t{h.tiles_x} + 1) * (std::uint64_t{h.tiles_y} + 1);
    const std::uint64_t tiles = h.tiles_held != 0 ? h.tiles_held : places, slots = slots_of(h, budget, pages);
    const bool sparse = h.tiles_held != 0;
    Layout l{};
    BlockLayout block(sizeof(TerrainData));
    const auto place = [&](std::uint64_t count, std::size_t bytes) { return block.place(count, bytes); };
    l.memory = place(1, sizeof(TerrainMemory));
    l.records = place(slots * pages.page_capacity(), sizeof(VertexRecord));
    l.page_table = place(tiles * pages.pages_per_tile(), sizeof(PageEntry));
    l.slot_page = place(slots, sizeof(std::uint32_t));
    l.slot_loads = place(slots, sizeof(std::uint32_t));
    l.free_slots = place(slots, sizeof(std::uint32_t));
    l.corners = place(chunk_raw_bytes(h, {ChunkKind::corners, 0, 0}), 1);
    l.tile_numbers = place(sparse ? places : 0, sizeof(std::uint32_t));
    l.corner_numbers = place(sparse ? corner_places : 0, sizeof(std::uint32_t));
    l.tile_places = place(sparse ? tiles : 0, sizeof(std::uint32_t));
    l.tile_corners = place(sparse ? 4 * tiles : 0, sizeof(std::uint32_t));
    l.zstd = place(1, ZSTD_estimateDCtxSize());
    l.raw = place(1, max_page_raw_bytes(pages.page_capacity()));
    l.end = block.end();
    return l;
}

// For each place of a page in hierarchical Z-order the number of its vertex in planar order.
void permute(const PageLayout& pages, std::uint32_t page, std::uint16_t* vertex_at) {
    const PageLayout planar{pages.tile_log2, PageOrder::planar};
    for (std::uint32_t i = 0; i < planar.page_vertices(page); ++i) {
        const SampleIndex c = planar.coord({page, i});
        const PagePlace to = pages.place(static_cast<std::uint32_t>(c.column), static_cast<std::uint32_t>(c.row));
        vertex_at[to.index] = static_cast<std::uint16_t>(i);
    }
}

// Checks the stored bytes and decompresses them into memory.raw.
Status fetch(const Pack& pack, ChunkId id, TerrainMemory& memory, std::span<const std::byte>& raw) {
    if (pack.bytes.empty()) return {StatusCode::not_supported, "page of a streamed pack (insert_page)"};
    if (pack.directory == nullptr) return {StatusCode::wrong_pack, "pack"};
    const ChunkEntry e = pack.entry(chunk_index(pack.header, id));
    const std::byte* const stored = pack.bytes.data() + e.offset;
    if (e.raw_bytes > memory.raw_bytes || hash_of(stored, e.stored_bytes) != e.hash)
        return {StatusCode::corrupt, "geometry page"};
    const std::size_t written = ZSTD_decompressDCtx(memory.zstd, memory.raw, e.raw_bytes, stored, e.stored_bytes);
    if (ZSTD_isError(written) || written != e.raw_bytes) return {StatusCode::corrupt, "geometry page"};
    raw = {memory.raw, written};
    return {};
}

// The loaded pages of one tile, as derived errors need them.
struct TilePages {
    const TerrainData& terrain;
    const PageEntry* table; // of the tile
    SampleIndex tile;

    [[nodiscard]] std::int32_t steps(std::uint32_t page, std::uint32_t index) const {
        const PageEntry entry = table[page];
        return entry.base + terrain.records[std::size_t{entry.slot} * terrain.page_capacity + index].height;
    }
    // Vertex (x, y) of the tile, seen from a page of step 1: in the closed page over it.
    [[nodiscard]] std::int32_t steps_over(SampleIndex position, std::uint32_t x, std::uint32_t y) const {
        const PageLayout& pages = terrain.pages;
        const auto side = static_cast<std::int32_t>(pages.side());
        const SampleIndex c{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)};
        if (((c.column | c.row) & (side - 1)) == 0) // not page 0's copy, which edits leave as it was
            return corner_steps(terrain.corners[terrain.corner_at(tile.column + (c.column >> pages.tile_log2),
                                                                  tile.row + (c.row >> pages.tile_log2))]);
        const int z = Tree::step_log2(c);
        const StepLayout step = pages.step_layout(z);
        const std::uint32_t px = step.pages_log2 == 0 ? 0 : static_cast<std::uint32_t>(position.column) >> z,
                            py = step.pages_log2 == 0 ? 0 : static_cast<std::uint32_t>(position.row) >> z;
        const std::uint32_t page = step.page_side == page_squares ? pages.page_at(z, px, py) : 0;
        const std::uint32_t i = (x >> (z + 1)) - px * step.page_side, j = (y >> (z + 1)) - py * step.page_side;
        const VertexKind kind = Tree::kind(c);
        const std::uint32_t index = pages.order == PageOrder::planar
                                        ? page_index<PageOrder::planar>(step.page_side, kind, i, j)
                                        : page_index<PageOrder::hierarchical_z>(step.page_side, kind, i, j);
        return steps(page, step.offset + index);
    }
};

// The page over a page of step 1 at step 2^z, or page 0.
std::uint32_t page_over(const PageLayout& pages, SampleIndex position, int z) {
    const StepLayout step = pages.step_layout(z);
    if (step.page_side != page_squares) return 0;
    return pages.page_at(z, static_cast<std::uint32_t>(position.column) >> z,
                         static_cast<std::uint32_t>(position.row) >> z);
}

bool coarser_pages_loaded(const PageLayout& pages, const PageEntry* table, SampleIndex position) {
    for (int z = 1; z < pages.tile_log2; ++z)
        if (table[page_over(pages, position, z)].slot == no_index) return false;
    return true;
}

// Heights of the squares' corners of a page of step 1.
void gather_corners(const TilePages& tile, SampleIndex position, CornerSteps& out) {
    const PageLayout& pages = tile.terrain.pages;
    const auto x0 = static_cast<std::uint32_t>(position.column) * page_squares,
               y0 = static_cast<std::uint32_t>(position.row) * page_squares; // in squares of step 1
    StepRows rows[page_squares_log2];
    for (int z = page_squares_log2; z > 0; --z) {
        const StepLayout step = pages.step_layout(z);
        const PageEntry entry = tile.table[page_over(pages, position, z)];
        rows[page_squares_log2 - z] = {tile.terrain.records + std::size_t{entry.slot} * tile.terrain.page_capacity +
                                           step.offset,
                                       entry.base,
                                       step.page_side,
                                       pages.order,
                                       (x0 >> z) % step.page_side,
                                       (y0 >> z) % step.page_side};
    }
    std::int32_t own[4];
    for (const std::uint32_t k : {0u, 1u, 2u, 3u})
        own[k] = tile.steps_over(position, 2 * (x0 + k % 2 * page_squares), 2 * (y0 + k / 2 * page_squares));
    refine_corners(own, rows, out);
}

void store(const TerrainData& terrain, std::uint32_t page, const TerrainMemory& memory, VertexRecord* to) {
    const PageArrays& from = memory.arrays;
    const std::uint32_t count = terrain.pages.page_vertices(page);
    if (terrain.pages.order != PageOrder::hierarchical_z) return write_page(from, count, to);
    write_permuted(from, count, page == 0 ? memory.root_vertex_at : memory.page_vertex_at, to);
}

Status insert(TerrainData& terrain, std::uint32_t tile, std::uint32_t page, std::span<const std::byte> raw) {
    if (tile >= terrain.tile_count() || page >= terrain.pages_per_tile) return {StatusCode::out_of_range, "page"};
    TerrainMemory& m = *terrain.memory;
    PageEntry* const table = m.page_table + std::size_t{tile} * terrain.pages_per_tile;
    if (table[page].slot != no_index) return {};
    if (m.free_count == 0) return {StatusCode::out_of_slots, "TerrainBudget::page_slots"};
    if (Status s = unpack_page(terrain.pages, page, raw, m.arrays); !s.ok()) return s;
    const bool edited = terrain.edits != nullptr && edit::restore_page(*terrain.edits, tile, page, m.arrays);
    if (m.arrays.errors_derived) {
        const SampleIndex position = terrain.pages.page_position(page);
        if (!coarser_pages_loaded(terrain.pages, table, position))
            return {StatusCode::coarser_page_first, "geometry page"};
        gather_corners({terrain, table, terrain.tile_xy(tile)}, position, m.coarse);
        derive_errors(m.coarse, terrain.errors, m.leaf, m.arrays);
        if (edited) edit::bound_derived(*terrain.edits, tile, page, m.arrays);
    }
    const std::uint32_t slot = m.free_slots[--m.free_count];
    FJELL_ASSERT(slot < terrain.slot_count && m.slot_page[slot] == no_index && terrain.pages_missing != 0);
    // The order that queries of other threads rely on: pack/publish.h.
    begin_slot(m.slot_loads[slot]);
    store(terrain, page, m, m.records + std::size_t{slot} * terrain.page_capacity);
    publish_entry(table[page], {slot, m.arrays.base});
    m.slot_page[slot] = tile * terrain.pages_per_tile + page;
    --terrain.pages_missing;
    m.changed_slots[terrain.changes++ % change_log] = slot;
    if (edited) edit::nest_over_page(*terrain.edits, tile, page);
    FJELL_WALK(terrain.changes, validate_terrain(terrain));
    return {};
}

// Which place has which tile and which corner; corners: room for four a tile. Corners that several tiles have must be
// equal, or packs of different ground lie side by side.
Status number_tiles(const Pack& pack, TerrainData& t, TerrainMemory& m, const std::uint32_t* tile_corners) {
    const std::size_t places = std::size_t{t.header.tiles_x} * t.header.tiles_y,
                      wide = t.header.tiles_x + std::size_t{1};
    const std::size_t corner_places = wide * (t.header.tiles_y + std::size_t{1});
    std::fill_n(m.tile_numbers, places, no_index);
    std::fill_n(m.corner_numbers, corner_places, no_index);
    const auto corner_place = [&](std::uint32_t tile, std::uint32_t k) {
        const std::size_t place = m.tile_places[tile];
        return (place / t.header.tiles_x + k / 2) * wide + place % t.header.tiles_x + k % 2;
    };
    for (std::uint32_t tile = 0; tile < t.tile_count(); ++tile) {
        m.tile_places[tile] = pack.tile_place(tile);
        m.tile_numbers[m.tile_places[tile]] = tile;
        for (std::uint32_t k = 0; k < 4; ++k) m.corner_numbers[corner_place(tile, k)] = 0;
    }
    t.corner_count = 0;
    for (std::size_t place = 0; place < corner_places; ++place)
        if (m.corner_numbers[place] != no_index) m.corner_numbers[place] = t.corner_count++;
    std::fill_n(m.corners, t.corner_count, no_index);
    for (std::uint32_t i = 0; i < 4 * t.tile_count(); ++i) {
        std::uint32_t& corner = m.corners[m.corner_numbers[corner_place(i / 4, i % 4)]];
        if (corner != no_index && corner != tile_corners[i])
            return {StatusCode::corrupt, "corners (tiles that meet there differ)"};
        corner = tile_corners[i];
    }
    t.tile_numbers = m.tile_numbers;
    t.corner_numbers = m.corner_numbers;
    t.tile_places = m.tile_places;
    return {};
}

// Decodes the corners, and finds room for each tile.
Status read_corners(const Pack& pack, std::span<const std::byte> stored, std::byte* tile_corners, TerrainData& t,
                    TerrainMemory& m) {
    const PackHeader& h = pack.header;
    const ChunkId id{ChunkKind::corners, 0, 0};
    const std::size_t bytes = chunk_raw_bytes(h, id);
    std::byte* const to = h.tiles_held != 0 ? tile_corners : reinterpret_cast<std::byte*>(m.corners);
    if (Status s = decode_chunk(pack.entry(chunk_index(h, id)), stored, {to, bytes}); !s.ok())
        return {s.code, "corners"};
    const auto* const corners = reinterpret_cast<const std::uint32_t*>(to);
    for (std::size_t i = 0; i < bytes / sizeof(std::uint32_t); ++i)
        if ((corners[i] & ~corner_void_bit) > h.height_steps) return {StatusCode::corrupt, "corners"};
    if (h.tiles_held != 0) return number_tiles(pack, t, m, corners);
    t.corner_count = static_cast<std::uint32_t>(bytes / sizeof(std::uint32_t));
    return {};
}

} // namespace

std::size_t terrain_bytes(const PackHeader& header, const TerrainBudget& budget) {
    if (!check_ranges(header).ok()) return 0;
    return layout_of(header, budget).end;
}

Status create_terrain(const Pack& pack, const TerrainBudget& budget, std::span<std::byte> memory, Terrain& terrain) {
    if (pack.bytes.empty()) return {StatusCode::not_supported, "terrain of a streamed pack (give its corners)"};
    const ChunkEntry corners = pack.entry(chunk_index(pack.header, {ChunkKind::corners, 0, 0}));
    if (corners.offset > pack.bytes.size() || corners.stored_bytes > pack.bytes.size() - corners.offset)
        return {StatusCode::truncated, "corners"};
    const auto stored = pack.bytes.subspan(static_cast<std::size_t>(corners.offset), corners.stored_bytes);
    return create_terrain(pack, stored, budget, memory, terrain);
}

Status create_terrain(const Pack& pack, std::span<const std::byte> corners, const TerrainBudget& budget,
                      std::span<std::byte> memory, Terrain& terrain) {
    const PackHeader& h = pack.header;
    if (Status s = check_ranges(h); !s.ok()) return s;
    if (pack.directory == nullptr) return {StatusCode::not_a_pack, "pack"};
    const Layout l = layout_of(h, budget);
    if (memory.size() < l.end) return {StatusCode::memory_too_small, "memory"};
    std::byte* const at = memory.data();
    if (reinterpret_cast<std::uintptr_t>(at) % block_alignment != 0)
        return {StatusCode::out_of_range, "memory alignment"};

    TerrainData& t = *new (at) TerrainData{}; // whatever was here is refused from now on
    t.header = h;
    t.tree = tree_of(h);
    t.pages = pages_of(h);
    t.height_scale = {h.base_m, h.quantum_m};
    t.spacing_x_m = static_cast<float>(h.spacing_m[0]);
    t.spacing_z_m = static_cast<float>(h.spacing_m[1]);
    t.errors = ErrorScale::make(h.error_floor_m, h.error_ratio, h.error_nesting_steps);
    t.radii = RadiusScale::make();
    t.pages_per_tile = t.pages.pages_per_tile();
    t.page_capacity = t.pages.page_capacity();
    t.slot_count = slots_of(h, budget, t.pages);
    t.pages_missing = t.page_count();
    t.range = {h.min_m, h.max_m, h.max_error_m, 0, static_cast<std::int32_t>(h.height_steps)};

    auto& m = *new (at + l.memory) TerrainMemory{};
    m.page_table = reinterpret_cast<PageEntry*>(at + l.page_table);
    m.records = reinterpret_cast<VertexRecord*>(at + l.records);
    m.slot_page = reinterpret_cast<std::uint32_t*>(at + l.slot_page);
    m.slot_loads = reinterpret_cast<std::uint32_t*>(at + l.slot_loads);
    m.free_slots = reinterpret_cast<std::uint32_t*>(at + l.free_slots);
    m.corners = reinterpret_cast<std::uint32_t*>(at + l.corners);
    m.tile_numbers = reinterpret_cast<std::uint32_t*>(at + l.tile_numbers);
    m.corner_numbers = reinterpret_cast<std::uint32_t*>(at + l.corner_numbers);
    m.tile_places = reinterpret_cast<std::uint32_t*>(at + l.tile_places);
    m.zstd = ZSTD_initStaticDCtx(at + l.zstd, ZSTD_estimateDCtxSize());
    if (!m.zstd) return {StatusCode::memory_too_small, "memory"};
    m.raw = at + l.raw;
    m.raw_bytes = max_page_raw_bytes(t.page_capacity);
    m.leaf = LeafErrors(t.errors, h.quantum_m);
    if (h.order == PageOrder::hierarchical_z) {
        permute({page_squares_log2 + 1, h.order}, 1, m.page_vertex_at);
        permute({std::min(t.pages.tile_log2, page_squares_log2), h.order}, 0, m.root_vertex_at);
    }
    for (std::uint32_t i = 0; i < t.page_count(); ++i) m.page_table[i] = {no_index, 0};
    for (std::uint32_t i = 0; i < t.slot_count; ++i) {
        m.slot_page[i] = no_index;
        m.slot_loads[i] = 0;
        m.free_slots[i] = t.slot_count - 1 - i;
    }
    m.free_count = t.slot_count;
    // Every page of memory is touched now, so that no frame faults; records are written before they are read.
    for (std::size_t i = l.records; i < l.page_table; i += 4096) at[i] = std::byte{0};
    if (Status s = read_corners(pack, corners, at + l.tile_corners, t, m); !s.ok()) return s;
    t.page_table = m.page_table;
    t.records = m.records;
    t.slot_page = m.slot_page;
    t.slot_loads = m.slot_loads;
    t.corners = m.corners;
    t.changed_slots = m.changed_slots;
    t.memory = &m;
    HandleAccess::begin(t, terrain);
    return {};
}

Status destroy_terrain(const Terrain& terrain) {
    return HandleAccess::end(terrain) ? Status{} : Status{StatusCode::invalid_handle, "terrain"};
}

Status load_page(const Pack& pack, const Terrain& handle, std::uint32_t tile, std::uint32_t page) {
    TerrainData* const found = find(handle);
    if (found == nullptr) return {StatusCode::invalid_handle, "terrain"};
    TerrainData& terrain = *found;
    if (!same_pack(pack.header, terrain.header)) return {StatusCode::wrong_pack, "pack"};
    if (tile >= terrain.tile_count() || page >= terrain.pages_per_tile) return {StatusCode::out_of_range, "page"};
    TerrainMemory& m = *terrain.memory;
    if (m.page_table[std::size_t{tile} * terrain.pages_per_tile + page].slot != no_index) return {};
    if (m.free_count == 0) return {StatusCode::out_of_slots, "TerrainBudget::page_slots"};
    std::span<const std::byte> raw;
    if (Status s = fetch(pack, {ChunkKind::geometry, tile, page}, m, raw); !s.ok()) return s;
    return insert(terrain, tile, page, raw);
}

Status insert_page(const Terrain& terrain, std::uint32_t tile, std::uint32_t page, std::span<const std::byte> raw) {
    TerrainData* const found = find(terrain);
    if (found == nullptr) return {StatusCode::invalid_handle, "terrain"};
    return insert(*found, tile, page, raw);
}

Status unload_page(const Terrain& handle, std::uint32_t tile, std::uint32_t page) {
    TerrainData* const found = find(handle);
    if (found == nullptr) return {StatusCode::invalid_handle, "terrain"};
    TerrainData& terrain = *found;
    if (tile >= terrain.tile_count() || page >= terrain.pages_per_tile) return {StatusCode::out_of_range, "page"};
    TerrainMemory& m = *terrain.memory;
    PageEntry& entry = m.page_table[std::size_t{tile} * terrain.pages_per_tile + page];
    if (entry.slot == no_index) return {};
    const std::uint32_t slot = entry.slot;
    FJELL_ASSERT(m.slot_page[slot] == tile * terrain.pages_per_tile + page && m.free_count < terrain.slot_count);
    publish_entry(entry, {no_index, 0}); // before its slot is anyone else's
    m.slot_page[slot] = no_index;
    m.free_slots[m.free_count++] = slot;
    ++terrain.pages_missing;
    m.changed_slots[terrain.changes++ % change_log] = slot;
    FJELL_WALK(terrain.changes, validate_terrain(terrain));
    return {};
}

Status load_terrain(const Pack& pack, std::span<std::byte> memory, Terrain& terrain) {
    Terrain loaded;
    if (Status s = create_terrain(pack, {}, memory, loaded); !s.ok()) return s;
    for (std::uint32_t tile = 0; tile < loaded.tile_count(); ++tile)
        for (std::uint32_t page = 0; page < loaded.pages_per_tile(); ++page)
            if (Status s = load_page(pack, loaded, tile, page); !s.ok()) return s;
    terrain = loaded;
    return {};
}

TerrainData::Vertex TerrainData::vertex(SampleIndex v) const {
    const std::int32_t side = tree.side();
    Vertex out, in_no_tile;
    in_no_tile.loaded = in_no_tile.hole = true;
    in_no_tile.in_tile = false;
    in_no_tile.height_m = range.low_m;
    if (tree.is_corner(v)) {
        const std::uint32_t corner = corner_at(v.column / side, v.row / side);
        if (corner == no_index) return in_no_tile;
        out.loaded = true;
        const std::uint32_t stored = corners[corner];
        out.hole = (stored & corner_void_bit) != 0;
        out.steps = corner_steps(stored);
        out.height_m = height_scale.height_m(out.steps);
        return out;
    }
    const std::int32_t tx = std::min(v.column / side, tree.tiles_x - 1), ty = std::min(v.row / side, tree.tiles_y - 1);
    const SampleIndex owner = tile_with(v, {tx, ty});
    const std::uint32_t tile = tile_at(owner.column, owner.row);
    if (tile == no_index) return in_no_tile;
    const PagePlace at = pages.place(static_cast<std::uint32_t>(v.column - owner.column * side),
                                     static_cast<std::uint32_t>(v.row - owner.row * side));
    const PageEntry entry = page_table[std::size_t{tile} * pages_per_tile + at.page];
    if (entry.slot == no_index) return out;
    const VertexRecord record = records[std::size_t{entry.slot} * page_capacity + at.index];
    out.loaded = true;
    out.hole = fjell::is_void(record);
    out.steps = entry.base + record.height;
    out.error_code = record.error;
    out.height_m = height_scale.height_m(out.steps);
    out.error_m = errors.metres[record.error];
    out.radius_m = header.level_radius_m[tree.level(v)] * radii.factor[record.radius & (radius_codes - 1)];
    return out;
}

double TerrainData::ground_m(double x, double z) const {
    const auto clamped = [](double at, std::int32_t count) { // NaN fails every comparison
        return at > 0 ? std::min(at, static_cast<double>(count - 1)) : 0;
    };
    const double column = clamped(x / header.spacing_m[0], tree.columns());
    const double row = clamped(z / header.spacing_m[1], tree.rows());
    const auto x0 = std::min(static_cast<std::int32_t>(column), tree.columns() - 2);
    const auto y0 = std::min(static_cast<std::int32_t>(row), tree.rows() - 2);
    const double u = column - x0, v = row - y0;
    const auto lerp = [](double a, double b, double t) { return a + (b - a) * t; };
    const double north = lerp(height_m({x0, y0}), height_m({x0 + 1, y0}), u);
    const double south = lerp(height_m({x0, y0 + 1}), height_m({x0 + 1, y0 + 1}), u);
    return lerp(north, south, v);
}

// --- what a host may ask a terrain by its handle

namespace {

// What a refused handle answers from.
const TerrainData& shown(const Terrain& terrain) {
    static constexpr TerrainData none = [] {
        TerrainData t{};
        t.spacing_x_m = t.spacing_z_m = 0;
        return t;
    }();
    const TerrainData* const found = find(terrain);
    return found != nullptr ? *found : none;
}

} // namespace

bool Terrain::valid() const {
    return find(*this) != nullptr;
}
const PackHeader& Terrain::header() const {
    return shown(*this).header;
}
std::uint32_t Terrain::columns() const {
    return header().columns;
}
std::uint32_t Terrain::rows() const {
    return header().rows;
}
float Terrain::spacing_x_m() const {
    return shown(*this).spacing_x_m;
}
float Terrain::spacing_z_m() const {
    return shown(*this).spacing_z_m;
}
float Terrain::x_m(std::int32_t column) const {
    return shown(*this).x_m(column);
}
float Terrain::z_m(std::int32_t row) const {
    return shown(*this).z_m(row);
}
float Terrain::extent_x_m() const {
    const TerrainData& t = shown(*this);
    return t.header.columns == 0 ? 0 : t.x_m(static_cast<std::int32_t>(t.header.columns) - 1);
}
float Terrain::extent_z_m() const {
    const TerrainData& t = shown(*this);
    return t.header.rows == 0 ? 0 : t.z_m(static_cast<std::int32_t>(t.header.rows) - 1);
}
bool Terrain::has_voids() const {
    return shown(*this).has_voids() || shown(*this).is_sparse();
}
std::uint32_t Terrain::tile_count() const {
    return shown(*this).tile_count();
}
std::uint32_t Terrain::tile_at(SampleIndex place) const {
    const TerrainData& t = shown(*this);
    if (place.column < 0 || place.row < 0 || place.column >= t.tree.tiles_x || place.row >= t.tree.tiles_y)
        return no_tile;
    static_assert(no_tile == no_index);
    return t.tile_at(place.column, place.row);
}
SampleIndex Terrain::tile_place(std::uint32_t tile) const {
    const TerrainData& t = shown(*this);
    return tile < t.tile_count() ? t.tile_xy(tile) : SampleIndex{-1, -1};
}
std::uint32_t Terrain::pages_per_tile() const {
    return shown(*this).pages_per_tile;
}
std::uint32_t Terrain::page_count() const {
    return shown(*this).page_count();
}
std::uint32_t Terrain::page_slots() const {
    return shown(*this).slot_count;
}
std::uint32_t Terrain::pages_loaded() const {
    return page_count() - pages_missing();
}
std::uint32_t Terrain::pages_missing() const {
    return shown(*this).pages_missing;
}
double Terrain::missing_px() const {
    return shown(*this).missing_px;
}

} // namespace fjell
