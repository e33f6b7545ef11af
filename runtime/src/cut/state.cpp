// The live cut's memory: how large, how laid out, and how it begins.
#include <algorithm>
#include <bit>
#include <cstring>
#include <new>
#include <utility>

#include "block_layout.h"
#include "cut/change.h"
#include "cut/evaluate.h"
#include "cut/state.h"

namespace fjell {

namespace {

std::uint32_t corner_count(const TerrainData& t) {
    return t.corner_count;
}
std::uint32_t segments_of(const CutBudget& b) {
    return b.triangles / b.segment_triangles;
}
bool hides_some(const TerrainData& t) {
    return t.has_voids() || t.tree.cut_x != 0 || t.tree.cut_y != 0;
}
// Every tile its base triangles; what is not drawn; and what deactivations keep back.
std::uint32_t least_segments(const TerrainData& t) {
    return t.tile_count() + 3;
}

std::uint32_t pages_of(const TerrainData& t, const CutBudget& b) {
    return cut_pages(b, t.slot_count, t.tile_count());
}

// Where its parts lie; one function for the size and for the placement, so they cannot disagree.
struct Layout {
    std::size_t page_groups, loaded, groups, nodes, vertex_slot, page_state, free_pages, idle_pages, evicting, ticks,
        schedules, awake, bounds, next_due, vertices, morph, triangle_of, hole, free_vertices, indices, tiles,
        segment_tile, segment_below, free_segments, vertex_bits[2], vertex_words[2], triangle_bits[2],
        triangle_words[2], ranges, hz_places, grids, descents, late_s, morphing_out, late_pages, bulk_pages,
        bulk_slots[3], bulk_tiles, bulk_bases, end;
};

static_assert(cut_vertex_bytes == sizeof(MeshVertex) + sizeof(MorphVertex) + 4 * 4 + 1 + 3 * 4 &&
                  cut_triangle_bytes == 3 * 4 && cut_page_slot_bytes == sizeof(LoadedPage) &&
                  cut_page_bytes == max_page_groups * (sizeof(GroupState) + sizeof(QueueNode) + group_lanes * 4) +
                                        sizeof(PageState) + page_ticks * 2 + sizeof(PageSchedule) + sizeof(AwakePage) +
                                        sizeof(HiddenBound) + sizeof(BulkPage) + 8 * 4,
              "hosts size their budgets by these: change them in fjell/cut.h with layout_of()");

Layout layout_of(const TerrainData& t, const CutBudget& b) {
    Layout l{};
    BlockLayout block(sizeof(CutState));
    const auto place = [&](std::uint64_t count, std::size_t bytes) { return block.place(count, bytes); };
    const std::uint64_t pages = pages_of(t, b), groups = pages * max_page_groups;
    const std::uint64_t segments = segments_of(b), triangles = segments * b.segment_triangles;
    l.page_groups = place(t.page_count(), 4);
    l.loaded = place(t.slot_count, sizeof(LoadedPage));
    l.groups = place(groups, sizeof(GroupState));
    l.nodes = place(groups, sizeof(QueueNode));
    l.vertex_slot = place(groups * group_lanes, 4);
    l.page_state = place(pages, sizeof(PageState));
    l.free_pages = place(pages, 4);
    l.idle_pages = place(pages, 4);
    l.evicting = place(pages, 4);
    l.ticks = place(pages * page_ticks, 2);
    l.schedules = place(pages, sizeof(PageSchedule));
    l.awake = place(pages, sizeof(AwakePage));
    l.bounds = place(pages, sizeof(HiddenBound));
    l.next_due = place(pages, 4);
    l.vertices = place(b.vertices, sizeof(MeshVertex));
    l.morph = place(b.vertices, sizeof(MorphVertex));
    l.triangle_of = place(b.vertices, 16);
    l.hole = place(b.vertices, 1);
    l.free_vertices = place(b.vertices, 4);
    l.indices = place(triangles, 12);
    l.tiles = place(t.tile_count() + 1, sizeof(TileList));
    l.segment_tile = place(segments, 4);
    l.segment_below = place(segments, 4);
    l.free_segments = place(segments, 4);
    for (int i = 0; i < 2; ++i) {
        l.vertex_bits[i] = place(b.vertices / 64 + 1, 8);
        l.vertex_words[i] = place(b.vertices / 64 + 1, 4);
        l.triangle_bits[i] = place(triangles / 64 + 1, 8);
        l.triangle_words[i] = place(triangles / 64 + 1, 4);
    }
    l.ranges = place(segments, sizeof(TileRange));
    l.hz_places = place(t.pages.order == Order::hierarchical_z ? 2 * max_page_vertices : 0, 2);
    l.grids = place(static_cast<std::size_t>(t.tree.tile_log2) * b.workers, sizeof(SlotGrid));
    l.descents = place(b.workers, sizeof(BulkDescent));
    l.late_s = place(b.vertices, 4);
    l.morphing_out = place(b.vertices, 4);
    l.late_pages = place(pages, 4);
    l.bulk_pages = place(pages, sizeof(BulkPage));
    for (std::size_t& slots : l.bulk_slots) slots = place(pages, 4);
    l.bulk_tiles = place(t.tile_count() + 1, sizeof(BulkTile));
    l.bulk_bases = place(t.tile_count(), 8);
    l.end = block.end();
    return l;
}

Status check_budget(const TerrainData& t, const CutBudget& b) {
    if (t.pages.order == Order::linear)
        return {Code::not_supported, "terrain in linear order (bake with --order planar, or use the recursive method)"};
    if (b.vertices > 1u << 28) return {Code::out_of_range, "CutBudget::vertices (at most 2^28)"};
    if (b.triangles > 1u << 29) return {Code::out_of_range, "CutBudget::triangles (at most 2^29)"};
    if (b.segment_triangles < 8 || b.segment_triangles > 65536 || !std::has_single_bit(b.segment_triangles))
        return {Code::out_of_range, "CutBudget::segment_triangles (8 to 65,536, a power of two)"};
    if (b.views < 1 || b.views > max_cut_views) return {Code::out_of_range, "CutBudget::views (1 to 8)"};
    if (b.workers < 1 || b.workers > max_cut_workers) return {Code::out_of_range, "CutBudget::workers (1 to 64)"};
    if (std::uint64_t{pages_of(t, b)} * max_page_vertices > 0xfffffff0u)
        return {Code::out_of_range, "CutBudget::vertices (states for 1,369,568 pages at most)"};
    if (b.vertices < corner_count(t)) return {Code::budget_too_small, "CutBudget::vertices (4 a tile)"};
    if (segments_of(b) < least_segments(t))
        return {Code::budget_too_small, "CutBudget::triangles (a segment a tile, and 3)"};
    return {};
}

// Place of each group's lanes in hierarchical Z-order, for a page of each shape.
void make_hz_places(const Grid& grid) {
    const PageLayout& hz = grid.terrain->pages;
    const PageLayout planar{hz.tile_log2, Order::planar};
    for (std::uint32_t shape = 0; shape < (hz.pages_per_tile() > 1 ? 2u : 1u); ++shape)
        for (std::uint32_t n = 0; n < grid.shapes[shape].count; ++n) {
            const GroupShape& group = grid.shapes[shape].groups[n];
            for (std::uint32_t lane = 0; lane < group.lanes; ++lane) {
                // The first page of either kind has the same place in its tile in both orders.
                const Coord c = planar.coord({shape, group.first + group.stride * lane});
                std::uint32_t place = 0;
                if (shape == 0) {
                    place = hz.place(static_cast<std::uint32_t>(c.x), static_cast<std::uint32_t>(c.y)).index;
                } else {
                    const Site at = site_at(c);
                    place = page_index<Order::hierarchical_z>(page_squares, at.kind, static_cast<std::uint32_t>(at.i),
                                                              static_cast<std::uint32_t>(at.j));
                }
                grid.hz_places[(shape * max_page_groups + n) * group_lanes + lane] = static_cast<std::uint16_t>(place);
            }
        }
}

void make_corners(const Grid& grid, Mesh& mesh) {
    const TerrainData& t = *grid.terrain;
    const auto make = [&](std::int32_t x, std::int32_t y) {
        const std::uint32_t slot = t.corner_at(x, y);
        const Coord at = t.tree.sample({x * t.tree.side(), y * t.tree.side()});
        const std::uint32_t stored = t.corners[slot];
        const float height_m = t.height_scale.height_m(static_cast<std::int32_t>(stored & ~corner_void_bit));
        mesh.vertices[slot] = {at.x, at.y, height_m};
        mesh.morph[slot] = {height_m, 0, 0, long_active_s};
        mesh.hole[slot] = t.has_voids() && (stored & corner_void_bit) != 0;
        mesh.dirty_vertices.mark(slot);
    };
    // Of a sparse terrain some more than once: places without a tile have none.
    for (std::uint32_t tile = 0; t.is_sparse() && tile < t.tile_count(); ++tile)
        for (std::int32_t k = 0; k < 4; ++k) make(t.tile_xy(tile).x + k % 2, t.tile_xy(tile).y + k / 2);
    for (std::int32_t y = 0; !t.is_sparse() && y <= grid.tiles_y; ++y)
        for (std::int32_t x = 0; x <= grid.tiles_x; ++x) make(x, y);
}

} // namespace

void reset(CutState& s) {
    const TerrainData& t = *s.pages.grid.terrain;
    s.bulk.phase = BulkPhase::idle; // all pages become idle anyway
    s.mesh.mapped = 0;
    s.work.queues.work_ranks = 0;
    s.morphing.late_count = s.morphing.out_count = 0;
    for (std::uint32_t i = 0; i < corner_count(t) * 4; ++i) s.mesh.triangle_of[i] = no_index;
    s.mesh.free_vertex_count = 0;
    s.mesh.fresh_vertex = corner_count(t);
    free_all_segments(s.mesh);
    forget_late_pages(s.pages, s.morphing, s.frame, true);
    make_corners(s.pages.grid, s.mesh);
    for (std::uint32_t slot = 0; slot < s.pages.fresh; ++slot) {
        if (s.pages.state[slot].page == no_index) continue;
        clear_page(s.pages, slot);
        note_idle(s.pages, slot);
    }
    clear_queues(s.work.queues);
    clear_schedule(s.work.schedule);
    sync_pages(s);
    clear_schedule(s.work.schedule); // of the roots of pages that have just come
}

void begin_at_roots(const Pages& pages, Work& work, Mesh& mesh) {
    for (std::uint32_t tile = 0; tile < mesh.tile_count; ++tile) {
        const Coord at = pages.grid.terrain->tile_xy(tile);
        const auto slot = [&](std::int32_t x, std::int32_t y) {
            return pages.grid.terrain->corner_at(at.x + x, at.y + y);
        };
        const std::uint32_t nw = slot(0, 0), ne = slot(1, 0), sw = slot(0, 1), se = slot(1, 1);
        for (const MeshTriangle& base : {MeshTriangle{ne, nw, se}, MeshTriangle{sw, se, nw}}) {
            const Bearing corner = base.right == ne ? Bearing::north_east : Bearing::south_west;
            append_triangle(mesh, list_for(mesh, tile, base), base,
                            base.right * 4 + static_cast<std::uint32_t>(child_number(corner)));
        }
        // The root's group is the first of page 0.
        if (const std::uint32_t root = pages.page_groups[tile * pages.grid.pages_per_tile]; root != no_index)
            make_due(work.schedule, root);
    }
}

std::size_t cut_bytes(const Terrain& terrain, const CutBudget& budget) {
    const TerrainData* const t = find(terrain);
    return t != nullptr && check_budget(*t, budget).ok() ? layout_of(*t, budget).end : 0;
}

Status create_cut(const Terrain& handle, const CutBudget& budget, std::span<std::byte> memory, LiveCut& cut) {
    const TerrainData* const found = find(handle);
    if (found == nullptr) return {Code::invalid_handle, "terrain"};
    const TerrainData& terrain = *found;
    if (Status fits = check_budget(terrain, budget); !fits.ok()) return fits;
    const Layout l = layout_of(terrain, budget);
    if (memory.size() < l.end) return {Code::memory_too_small, "memory"};
    std::byte* const at = memory.data();
    if (reinterpret_cast<std::uintptr_t>(at) % block_alignment != 0) return {Code::out_of_range, "memory alignment"};
    std::memset(at, 0, l.end); // touches every page now rather than in a frame

    auto& s = *new (at) CutState{};
    const auto part = [&]<typename T>(T*& pointer, std::size_t offset) { pointer = reinterpret_cast<T*>(at + offset); };
    s.pages.grid.handle = handle;
    s.pages.grid.terrain = &terrain;
    s.budget = budget;
    s.bulk.workers = budget.workers;
    s.mesh.capacity = s.morphing.ring_size = budget.vertices;
    s.mesh.corner_count = terrain.corner_count;
    s.mesh.tile_count = terrain.tile_count();
    s.pages.grid.pages_per_tile = terrain.pages_per_tile;
    s.pages.count = pages_of(terrain, budget);
    s.pages.group_count = s.pages.count * max_page_groups;
    s.pages.tiles_waiting = terrain.tile_count();
    s.pages.grid.tiles_x = terrain.tree.tiles_x;
    s.pages.grid.tiles_y = terrain.tree.tiles_y;
    s.pages.grid.shapes[0] = make_page_shape(terrain.pages, true);
    s.pages.grid.shapes[1] = make_page_shape(terrain.pages, false);
    for (int z = 0; z < terrain.tree.tile_log2; ++z) {
        s.pages.grid.steps[z] = make_step_groups(terrain.pages, z);
        const int level = 2 * (terrain.tree.tile_log2 - 1 - z);
        s.pages.grid.level_unit_m[2 * z] = terrain.header.level_radius_m[level];
        s.pages.grid.level_unit_m[2 * z + 1] = terrain.header.level_radius_m[level + 1];
    }
    s.views.evaluate = evaluate;
    s.views.worst_px = worst_px;
    s.morphing.clock.timed_ticks = -clock_ticks; // never
    part(s.pages.page_groups, l.page_groups);
    part(s.pages.loaded, l.loaded);
    part(s.pages.groups, l.groups);
    part(s.pages.vertex_slot, l.vertex_slot);
    part(s.pages.state, l.page_state);
    part(s.pages.free, l.free_pages);
    part(s.pages.idle, l.idle_pages);
    part(s.pages.evicting, l.evicting);
    s.work.queues.groups = s.pages.groups;
    part(s.work.queues.nodes, l.nodes);
    s.work.queues.group_count = s.pages.group_count;
    s.work.queues.schedule = &s.work.schedule;
    clear_queues(s.work.queues);
    part(s.work.schedule.ticks, l.ticks);
    part(s.work.schedule.pages, l.schedules);
    part(s.work.schedule.awake, l.awake);
    part(s.work.schedule.bounds, l.bounds);
    part(s.work.schedule.next_due, l.next_due);
    s.work.schedule.slot_count = s.pages.count;
    begin_schedule(s.work.schedule, static_cast<double>(std::min(terrain.spacing_x_m, terrain.spacing_z_m)) / 32);
    part(s.mesh.vertices, l.vertices);
    part(s.mesh.morph, l.morph);
    part(s.mesh.triangle_of, l.triangle_of);
    part(s.mesh.hole, l.hole);
    part(s.mesh.free_vertices, l.free_vertices);
    part(s.mesh.indices, l.indices);
    part(s.mesh.tiles, l.tiles);
    part(s.mesh.segment_tile, l.segment_tile);
    part(s.mesh.segment_below, l.segment_below);
    part(s.mesh.free_segments, l.free_segments);
    s.mesh.segment_count = segments_of(budget);
    s.mesh.segment_log2 = static_cast<std::uint32_t>(std::countr_zero(budget.segment_triangles));
    s.mesh.some_hidden = hides_some(terrain);
    const auto bits_part = [&](DirtyBits& dirty, std::size_t bits, std::size_t words) {
        part(dirty.bits, bits);
        part(dirty.words, words);
    };
    bits_part(s.mesh.dirty_vertices, l.vertex_bits[0], l.vertex_words[0]);
    bits_part(s.mesh.dirty_triangles, l.triangle_bits[0], l.triangle_words[0]);
    bits_part(s.mesh.untaken_vertices, l.vertex_bits[1], l.vertex_words[1]);
    bits_part(s.mesh.untaken_triangles, l.triangle_bits[1], l.triangle_words[1]);
    part(s.mesh.ranges, l.ranges);
    part(s.bulk.descents, l.descents);
    for (std::uint32_t worker = 0; worker < budget.workers; ++worker)
        part(s.bulk.descents[worker].grids,
             l.grids + sizeof(SlotGrid) * static_cast<std::size_t>(terrain.tree.tile_log2) * worker);
    s.bulk.pages_together = bulk_pages_together;
    part(s.bulk.pages, l.bulk_pages);
    part(s.bulk.visited, l.bulk_slots[0]);
    for (int i = 0; i < 2; ++i) part(s.bulk.listed[i], l.bulk_slots[i + 1]);
    part(s.bulk.tiles, l.bulk_tiles);
    part(s.bulk.bases, l.bulk_bases);
    part(s.morphing.late_s, l.late_s);
    part(s.morphing.out, l.morphing_out);
    part(s.morphing.late_pages, l.late_pages);
    if (terrain.pages.order == Order::hierarchical_z) {
        part(s.pages.grid.hz_places, l.hz_places);
        make_hz_places(s.pages.grid);
    }
    s.views.criterion.error_m = terrain.errors.metres;
    s.views.criterion.radius_factor = terrain.radii.factor;
    s.views.criterion.base_m = terrain.height_scale.base_m;
    s.views.criterion.quantum_m = terrain.height_scale.quantum_m;
    s.views.criterion.spacing_x_m = terrain.spacing_x_m;
    s.views.criterion.spacing_z_m = terrain.spacing_z_m;
    s.views.criterion.last_x = terrain.tree.columns() - 1;
    s.views.criterion.last_y = terrain.tree.rows() - 1;
    s.views.offscreen_criterion = s.views.criterion;
    for (std::uint32_t i = 0; i < s.pages.group_count; ++i) s.pages.groups[i].queue = unqueued;
    for (std::uint32_t i = 0; i < terrain.page_count(); ++i) s.pages.page_groups[i] = no_index;
    for (std::uint32_t i = 0; i < s.pages.count; ++i) s.pages.state[i].page = no_index;
    for (std::uint32_t i = 0; i < terrain.slot_count; ++i) s.pages.loaded[i].page = no_index;
    rescan_pages(s.pages);
    reset(s);
    begin_at_roots(s.pages, s.work, s.mesh);
    HandleAccess::begin(s, cut);
    return {};
}

Status destroy_cut(LiveCut cut) {
    return HandleAccess::end(cut) ? Status{} : no_cut;
}

} // namespace fjell
