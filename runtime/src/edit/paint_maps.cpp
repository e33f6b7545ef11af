// fjell/ground_maps.h: maps under paint, for whoever loads them himself, and copies of it.
#include <algorithm>
#include <cstring>
#include <new>

#include "block_layout.h"
#include "edit/paint.h"
#include "fjell/ground_maps.h"
#include "shared/compiler.h"

namespace fjell {

using namespace edit;

namespace {

Status paint_with(const PaintData* paint, const PackHeader& h, MapKind map, std::uint32_t tile, std::uint32_t side_log2,
                  std::span<std::byte> blocks, bool& changed) {
    changed = false;
    if (map != MapKind::colour && map != MapKind::splat) return {StatusCode::out_of_range, "map"};
    const bool splat = map == MapKind::splat;
    if (tile >= tiles_of(h)) return {StatusCode::out_of_range, "tile"};
    if (side_log2 < 2 || side_log2 > (splat ? h.splat_log2 : h.colour_log2))
        return {StatusCode::out_of_range, "side_log2"};
    const std::uint32_t side = 1u << side_log2;
    if (blocks.size() != blocks_of(side) * (splat ? splat_block_bytes : colour_block_bytes))
        return {StatusCode::out_of_range, "blocks"};
    if (paint != nullptr) changed = paint_mip(*paint, map, tile, side_log2, {0, 0, side, side}, blocks.data());
    return {};
}

const PaintData* paint_of(const TerrainData& t) {
    return load_acquire(t.paint);
}

} // namespace

Status paint_map(const Terrain& terrain, MapKind map, std::uint32_t tile, std::uint32_t side_log2,
                 std::span<std::byte> blocks, bool& changed) {
    const TerrainData* const t = find(terrain);
    if (t == nullptr) return {StatusCode::invalid_handle, "terrain"};
    return paint_with(paint_of(*t), t->header, map, tile, side_log2, blocks, changed);
}

Status paint_map(const Paint& paint, MapKind map, std::uint32_t tile, std::uint32_t side_log2,
                 std::span<std::byte> blocks, bool& changed) {
    const PaintData* const p = find(paint);
    if (p == nullptr) return {StatusCode::invalid_handle, "paint"};
    return paint_with(p, p->header, map, tile, side_log2, blocks, changed);
}

std::uint32_t take_paint_changes(const Terrain& terrain, std::uint64_t& cursor, std::span<GroundRect> rects,
                                 bool& lost) {
    lost = false;
    const TerrainData* const t = find(terrain);
    const PaintData* const p = t == nullptr ? nullptr : paint_of(*t);
    if (p == nullptr || rects.empty()) return 0;
    if (cursor > p->changes || p->changes - cursor > paint_change_log) {
        lost = true;
        cursor = p->changes;
        rects[0] = {{0, 0}, {t->tree.columns() - 1, t->tree.rows() - 1}};
        return 1;
    }
    std::uint32_t count = 0;
    for (; cursor < p->changes && count < rects.size(); ++cursor) {
        const Rect& r = p->changed[cursor % paint_change_log];
        rects[count++] = {{r.x0, r.y0}, {r.x1, r.y1}};
    }
    return count;
}

std::size_t paint_bytes(const Terrain& terrain) {
    const TerrainData* const t = find(terrain);
    const PaintData* const p = t == nullptr ? nullptr : paint_of(*t);
    return p == nullptr || p->count == 0 ? 0 : paint_bytes_of(p->count);
}

Status copy_paint(const Terrain& terrain, std::span<std::byte> memory, Paint& paint) {
    const TerrainData* const t = find(terrain);
    if (t == nullptr) return {StatusCode::invalid_handle, "terrain"};
    const PaintData* const from = paint_of(*t);
    if (from == nullptr || from->count == 0) return {StatusCode::not_supported, "terrain (there is no paint on it)"};
    if (memory.size() < paint_bytes_of(from->count)) return {StatusCode::memory_too_small, "memory"};
    if (reinterpret_cast<std::uintptr_t>(memory.data()) % block_alignment != 0)
        return {StatusCode::out_of_range, "memory alignment"};
    std::memset(memory.data(), 0, paint_bytes_of(from->count));
    PaintData& p = *make_paint(from->header, from->count, memory.data());
    for (std::uint32_t cell = 0; cell < from->table_size; ++cell)
        if (from->table[cell] != no_index) copy_block(from->blocks[from->table[cell]], p);
    HandleAccess::begin(p, paint);
    return {};
}

} // namespace fjell
