// Which texels of normal maps are to be made anew, and in which order: changes as they come, then tiles whose map was
// written, by the blocks of edited samples in them.
#include "fjell/ground_maps.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstring>
#include <new>

#include "block_layout.h"
#include "edit/blocks.h"
#include "edit/horizon_maps.h"
#include "edit/normals.h"
#include "fjell/texture.h"

namespace fjell {

using namespace edit;

namespace {

// What is in work: a rectangle of samples, tile by tile, mip by mip, piece by piece.
struct Work {
    bool begun = false;
    GroundRect rect;
    SampleIndex first_tile, last_tile, tile; // places in the grid
    std::uint32_t mip = 0;
    std::int32_t piece = 0;
};
// The tile whose blocks are looked for; no_index: none.
struct TileWork {
    std::uint32_t tile = no_index;
    std::int32_t x = 0, y = 0; // the next block
};

constexpr std::uint32_t texels_of_piece = piece_texels * piece_texels;
constexpr std::uint32_t least_texels = 256; // that a patch counts as: so many patches there are at most

std::uint32_t most_patches(const GroundMapsBudget& budget) {
    return budget.texels / least_texels;
}
// And those of a stream: all mips of all its requests.
constexpr std::uint32_t most_stream_patches = 64 * max_texture_log2;

} // namespace

struct GroundMapsData {
    BlockHead head;
    Terrain handle;
    TerrainData* terrain;
    GroundMapsBudget budget;
    std::uint64_t ground_changes, page_changes; // TerrainData's, that were looked at
    GroundRect* changes;                        // a ring
    std::uint32_t first_change, change_count;
    // A bit a tile, in `words` words.
    std::uint64_t* due;    // texels over its edited blocks are to be made anew
    std::uint64_t* whole;  // all of its texels, when it is due
    std::uint64_t* made;   // has had patches
    std::uint64_t* coarse; // has texels of coarser ground
    std::uint32_t words, due_count, coarse_count, next_word;
    Work work;
    TileWork tile;
    MapPatch* patches;
    std::uint32_t patch_count, made_patches; // made here: those behind the stream's
    std::byte* blocks;                       // of the patches
    NormalScratch* scratch;
};

namespace {

struct Layout {
    std::size_t changes, bits, patches, blocks, scratch, end;
};
Layout layout_of(const PackHeader& h, const GroundMapsBudget& budget) {
    BlockLayout block(sizeof(GroundMapsData));
    Layout l{};
    l.changes = block.place(budget.changes, sizeof(GroundRect));
    l.bits = block.place(4 * (std::uint64_t{tiles_of(h)} / 64 + 1), sizeof(std::uint64_t));
    l.patches = block.place(most_patches(budget) + most_stream_patches, sizeof(MapPatch));
    l.blocks = block.place(budget.texels / 16, normal_block_bytes);
    l.scratch = block.place(1, sizeof(NormalScratch));
    l.end = block.end();
    return l;
}

Status check_budget(const GroundMapsBudget& budget) {
    if (budget.changes == 0 || budget.changes > 1u << 16)
        return {StatusCode::out_of_range, "GroundMapsBudget::changes"};
    if (budget.texels < texels_of_piece || budget.texels > 1u << 22)
        return {StatusCode::out_of_range, "GroundMapsBudget::texels"};
    return {};
}

bool has(const std::uint64_t* bits, std::uint32_t i) {
    return (bits[i / 64] >> (i % 64) & 1) != 0;
}
// Whether that changes anything.
bool set(std::uint64_t* bits, std::uint32_t i) {
    const bool is_new = !has(bits, i);
    bits[i / 64] |= std::uint64_t{1} << (i % 64);
    return is_new;
}
bool clear(std::uint64_t* bits, std::uint32_t i) {
    const bool was = has(bits, i);
    bits[i / 64] &= ~(std::uint64_t{1} << (i % 64));
    return was;
}

GroundMapsData* find_maps(const GroundMaps& maps) {
    GroundMapsData* const m = find(maps);
    return m != nullptr && find(m->handle) != nullptr ? m : nullptr;
}
constexpr Status no_maps{StatusCode::invalid_handle, "ground maps, or their terrain"};

// Places of the tiles with texels that look at samples of the rectangle.
void tiles_near(const TerrainData& t, const GroundRect& rect, SampleIndex& first, SampleIndex& last) {
    const auto tile = [&](std::int32_t sample, std::uint32_t tiles) {
        return std::clamp(sample >> t.header.tile_log2, 0, static_cast<std::int32_t>(tiles) - 1);
    };
    first = {tile(rect.first.column - normal_reach, t.header.tiles_x),
             tile(rect.first.row - normal_reach, t.header.tiles_y)};
    last = {tile(rect.last.column + normal_reach, t.header.tiles_x),
            tile(rect.last.row + normal_reach, t.header.tiles_y)};
}
template <typename Visit>
void for_each_tile(const TerrainData& t, SampleIndex first, SampleIndex last, const Visit& visit) {
    for (std::int32_t y = first.row; y <= last.row; ++y)
        for (std::int32_t x = first.column; x <= last.column; ++x)
            if (const std::uint32_t tile = t.tile_at(x, y); tile != no_index) visit(tile);
}

void make_due(GroundMapsData& m, std::uint32_t tile, bool whole) {
    if (set(m.due, tile)) ++m.due_count;
    if (whole) set(m.whole, tile);
}
void make_due_near(GroundMapsData& m, const GroundRect& rect, bool whole) {
    SampleIndex first, last;
    tiles_near(*m.terrain, rect, first, last);
    for_each_tile(*m.terrain, first, last, [&](std::uint32_t tile) { make_due(m, tile, whole); });
}

GroundRect samples_of_block(const Block& b) {
    const SampleIndex first{b.x << block_log2, b.y << block_log2};
    return {first, first + SampleIndex{block_side - 1, block_side - 1}};
}

void push_change(GroundMapsData& m, const GroundRect& rect) {
    if (m.change_count == m.budget.changes) return make_due_near(m, rect, true);
    m.changes[(m.first_change + m.change_count++) % m.budget.changes] = rect;
}

// What has changed since the last update.
void take_changes(GroundMapsData& m) {
    const TerrainData& t = *m.terrain;
    if (m.ground_changes == t.ground_changes) return;
    if (t.ground_changes - m.ground_changes > ground_change_log || t.changed_ground == nullptr) {
        // Nobody knows what: all that has been made, and all that is edited.
        for (std::uint32_t tile = 0; tile < t.tile_count(); ++tile)
            if (has(m.made, tile)) make_due(m, tile, true);
        for (std::uint32_t n = 0; t.edits != nullptr && n < t.edits->block_count; ++n)
            make_due_near(m, samples_of_block(t.edits->blocks[n]), false);
        m.ground_changes = t.ground_changes;
    }
    for (; m.ground_changes != t.ground_changes; ++m.ground_changes) {
        const GroundChange& change = t.changed_ground[m.ground_changes % ground_change_log];
        if (change.step_log2 == heights_changed)
            push_change(m, {t.tree.sample(change.first), t.tree.sample(change.last)});
    }
}

// Pages have come: tiles that were made from coarser ground around them are due.
void take_pages(GroundMapsData& m) {
    const TerrainData& t = *m.terrain;
    const std::uint64_t from = m.page_changes;
    m.page_changes = t.changes;
    if (m.coarse_count == 0 || from == t.changes) return;
    const auto is_due = [&](std::uint32_t tile) {
        if (!clear(m.coarse, tile)) return;
        --m.coarse_count;
        make_due(m, tile, false);
    };
    if (t.changes - from > change_log) {
        for (std::uint32_t tile = 0; tile < t.tile_count(); ++tile) is_due(tile);
        return;
    }
    for (std::uint64_t n = from; n != t.changes; ++n) {
        const std::uint32_t page = t.slot_page[t.changed_slots[n % change_log]];
        if (page == no_index) continue;
        const SampleIndex at = t.tile_xy(page / t.pages_per_tile);
        const SampleIndex first{std::max(at.column - 1, 0), std::max(at.row - 1, 0)},
            last{std::min(at.column + 1, static_cast<std::int32_t>(t.header.tiles_x) - 1),
                 std::min(at.row + 1, static_cast<std::int32_t>(t.header.tiles_y) - 1)};
        for_each_tile(t, first, last, is_due);
    }
}

void begin(GroundMapsData& m, const GroundRect& rect) {
    m.work = {};
    m.work.begun = true, m.work.rect = rect;
    tiles_near(*m.terrain, rect, m.work.first_tile, m.work.last_tile);
    m.work.tile = m.work.first_tile;
}

// The next blocks of the tile that were edited, one beside the other. False: there are no more.
bool begin_blocks(GroundMapsData& m, std::uint32_t& looks) {
    const TerrainData& t = *m.terrain;
    const SampleIndex place = t.tile_xy(m.tile.tile);
    const std::int32_t side = t.tree.side();
    const auto low = [&](std::int32_t at) { return std::max(at * side - normal_reach, 0) >> block_log2; };
    const auto high = [&](std::int32_t at) { return ((at + 1) * side + normal_reach) >> block_log2; };
    const std::int32_t first_x = low(place.column), last_x = high(place.column), last_y = high(place.row);
    if (m.tile.y < 0) m.tile.x = first_x, m.tile.y = low(place.row);
    for (; m.tile.y <= last_y; ++m.tile.y, m.tile.x = first_x)
        for (; m.tile.x <= last_x; ++m.tile.x, ++looks) {
            if (!has_block_at(*t.edits, m.tile.x, m.tile.y)) continue;
            const std::int32_t first = m.tile.x++;
            while (m.tile.x <= last_x && has_block_at(*t.edits, m.tile.x, m.tile.y)) ++m.tile.x, ++looks;
            const SampleIndex from{first << block_log2, m.tile.y << block_log2};
            begin(m, {from, {(m.tile.x << block_log2) - 1, from.row + block_side - 1}});
            m.work.first_tile = m.work.last_tile = m.work.tile = place;
            return true;
        }
    return false;
}

// False: nothing waits.
bool begin_next(GroundMapsData& m, std::uint32_t& looks) {
    if (m.tile.tile != no_index) {
        if (m.terrain->edits != nullptr && begin_blocks(m, looks)) return true;
        m.tile.tile = no_index;
    }
    if (m.change_count != 0) {
        begin(m, m.changes[m.first_change]);
        m.first_change = (m.first_change + 1) % m.budget.changes;
        --m.change_count;
        return true;
    }
    if (m.due_count == 0) return false;
    while (m.due[m.next_word] == 0) m.next_word = (m.next_word + 1) % m.words, ++looks;
    const auto tile = m.next_word * 64 + static_cast<std::uint32_t>(std::countr_zero(m.due[m.next_word]));
    clear(m.due, tile);
    --m.due_count;
    if (!clear(m.whole, tile)) {
        m.tile = {.tile = tile, .x = 0, .y = -1};
        return true;
    }
    const SampleIndex place = m.terrain->tile_xy(tile);
    const std::int32_t side = m.terrain->tree.side();
    begin(m, {{place.column * side, place.row * side}, {(place.column + 1) * side, (place.row + 1) * side}});
    m.work.first_tile = m.work.last_tile = m.work.tile = place;
    return true;
}

// A rectangle's piece: as many of them as it takes, alike in size.
struct Split {
    std::int32_t count, side;
    Split(std::int32_t texels, std::int32_t most)
        : count((texels + most - 1) / most), side((texels / 4 + count - 1) / count * 4) {}
};
bool piece_of(const TexelRect& all, std::int32_t most, std::int32_t number, TexelRect& piece) {
    if (all.empty()) return false;
    const Split x(all.columns, most), y(all.rows, most);
    if (number >= x.count * y.count) return false;
    const std::int32_t left = number % x.count * x.side, up = number / x.count * y.side;
    piece = {all.x + left, all.y + up, std::min(x.side, all.columns - left), std::min(y.side, all.rows - up)};
    return true;
}

// Makes the next piece of what is in work; at its end nothing is. False: there is no room for it in this update.
bool make_piece(GroundMapsData& m, std::span<const TileMap> normals, GroundMapsReport& report) {
    const TerrainData& t = *m.terrain;
    Work& w = m.work;
    for (; w.tile.row <= w.last_tile.row; ++w.tile.row, w.tile.column = w.first_tile.column)
        for (; w.tile.column <= w.last_tile.column; ++w.tile.column, w.mip = 0, w.piece = 0) {
            const std::uint32_t tile = t.tile_at(w.tile.column, w.tile.row);
            if (tile == no_index || normals[tile].side_log2 == 0 || normals[tile].side_log2 > t.header.normal_log2)
                continue;
            const TileMap& shown = normals[tile];
            for (; w.mip < mip_count(shown.side_log2); ++w.mip, w.piece = 0) {
                TexelRect piece;
                const std::uint32_t mip_log2 = shown.side_log2 - w.mip;
                if (!piece_of(texels_over(t, tile, mip_log2, w.rect), most_texels(t, mip_log2), w.piece, piece))
                    continue;
                if (report.texels + piece.texels() > m.budget.texels || m.made_patches == most_patches(m.budget))
                    return false;
                std::byte* const blocks = m.blocks + std::size_t{report.texels} / 16 * normal_block_bytes;
                if (!make_normals(m.handle, t, tile, mip_log2, piece, *m.scratch, blocks) && set(m.coarse, tile))
                    ++m.coarse_count;
                set(m.made, tile);
                ++m.made_patches;
                m.patches[m.patch_count++] = {.map = MapKind::normal,
                                              .side_log2 = shown.side_log2,
                                              .mip = static_cast<std::uint8_t>(w.mip),
                                              .tile = tile,
                                              .layer = shown.layer,
                                              .x = static_cast<std::uint32_t>(piece.x),
                                              .y = static_cast<std::uint32_t>(piece.y),
                                              .columns = static_cast<std::uint32_t>(piece.columns),
                                              .rows = static_cast<std::uint32_t>(piece.rows),
                                              .blocks = {blocks, piece.texels() / 16 * normal_block_bytes}};
                report.texels += piece.texels();
                ++w.piece;
                return true;
            }
        }
    w.begun = false;
    return true;
}

std::uint32_t waiting(const GroundMapsData& m) {
    return m.change_count + m.due_count + (m.work.begun ? 1 : 0) + (m.tile.tile != no_index ? 1 : 0);
}

} // namespace

std::size_t ground_maps_bytes(const PackHeader& header, const GroundMapsBudget& budget) {
    if (!check_ranges(header).ok() || !check_budget(budget).ok()) return 0;
    return layout_of(header, budget).end;
}

Status create_ground_maps(const Terrain& terrain, const GroundMapsBudget& budget, std::span<std::byte> memory,
                          GroundMaps& maps) {
    TerrainData* const t = find(terrain);
    if (t == nullptr) return {StatusCode::invalid_handle, "terrain"};
    if (Status s = check_budget(budget); !s.ok()) return s;
    const Layout l = layout_of(t->header, budget);
    if (memory.size() < l.end) return {StatusCode::memory_too_small, "memory"};
    std::byte* const at = memory.data();
    if (reinterpret_cast<std::uintptr_t>(at) % block_alignment != 0)
        return {StatusCode::out_of_range, "memory alignment"};
    std::memset(at, 0, l.end); // every page of memory is touched now
    GroundMapsData& m = *new (at) GroundMapsData{};
    m.handle = terrain;
    m.terrain = t;
    m.budget = budget;
    m.changes = reinterpret_cast<GroundRect*>(at + l.changes);
    m.words = t->tile_count() / 64 + 1;
    m.due = reinterpret_cast<std::uint64_t*>(at + l.bits);
    m.whole = m.due + m.words, m.made = m.whole + m.words, m.coarse = m.made + m.words;
    m.patches = reinterpret_cast<MapPatch*>(at + l.patches);
    m.blocks = at + l.blocks;
    m.scratch = reinterpret_cast<NormalScratch*>(at + l.scratch);
    // What was edited before is due when a map is shown: by its blocks.
    if (t->edits != nullptr)
        for (std::uint32_t n = 0; n < t->edits->block_count; ++n)
            make_due_near(m, samples_of_block(t->edits->blocks[n]), false);
    m.ground_changes = t->ground_changes, m.page_changes = t->changes;
    store_release(t->raise_horizons, RaiseHorizons{&raise_horizons});
    HandleAccess::begin(m, maps);
    return {};
}

Status destroy_ground_maps(const GroundMaps& maps) {
    return HandleAccess::end(maps) ? Status{} : no_maps;
}

Status note_map_commands(const GroundMaps& maps, std::span<const MapCommand> commands) {
    GroundMapsData* const m = find_maps(maps);
    if (m == nullptr) return no_maps;
    const EditsData* const e = m->terrain->edits;
    if (e == nullptr || e->block_count == 0) return {};
    for (const MapCommand& command : commands)
        if (command.map == MapKind::normal && command.tile < m->terrain->tile_count())
            make_due(*m, command.tile, false);
    return {};
}

Status update_ground_maps(const GroundMaps& maps, std::span<const TileMap> normals, GroundMapsReport& report) {
    GroundMapsData* const found = find_maps(maps);
    if (found == nullptr) return no_maps;
    GroundMapsData& m = *found;
    report = {};
    m.patch_count = std::min(m.terrain->map_patch_count, most_stream_patches);
    m.made_patches = 0;
    std::copy_n(m.terrain->map_patches, m.patch_count, m.patches);
    report.patches = m.patch_count;
    if (m.terrain->header.normal_log2 == 0) return {};
    if (normals.size() != m.terrain->tile_count()) return {StatusCode::out_of_range, "normals"};
    take_changes(m);
    take_pages(m);
    report.coarse = m.coarse_count;
    if (waiting(m) == 0) return {};
    const auto started = std::chrono::steady_clock::now();
    std::uint32_t looks = 0; // at blocks, each some 5 ns
    while (looks < m.budget.texels && (m.work.begun || begin_next(m, looks)))
        if (m.work.begun && !make_piece(m, normals, report)) break;
    report.patches = m.patch_count;
    report.waiting = waiting(m);
    report.coarse = m.coarse_count;
    report.update_us = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - started).count();
    return {};
}

std::span<const MapPatch> ground_map_patches(const GroundMaps& maps) {
    const GroundMapsData* const m = find_maps(maps);
    return m == nullptr ? std::span<const MapPatch>{} : std::span<const MapPatch>(m->patches, m->patch_count);
}

} // namespace fjell
