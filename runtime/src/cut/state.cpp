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

static_assert(cut_vertex_bytes == sizeof(MeshVertex) + 4 * 4 + 1 + 4 + cut_morph_bytes &&
                  cut_morph_bytes == sizeof(MorphVertex) + 2 * 4 && cut_triangle_bytes == 3 * 4 &&
                  cut_page_slot_bytes == sizeof(LoadedPage) &&
                  cut_page_bytes == max_page_groups * (sizeof(GroupState) + sizeof(QueueNode) + group_lanes * 4) +
                                        sizeof(PageState) + page_ticks * 2 + sizeof(PageSchedule) + sizeof(AwakePage) +
                                        sizeof(HiddenBound) + sizeof(BulkPage) + 7 * 4,
              "hosts size their budgets by these: change them in fjell/cut.h with lay_out()");

// Where its parts lie. Returns the bytes of all; at: nullptr to know no more than that.
std::size_t lay_out(const TerrainData& t, const CutBudget& b, std::byte* at, CutState& s) {
    BlockLayout block(sizeof(CutState));
    const auto part = [&]<typename T>(T*& pointer, std::uint64_t count) {
        const std::size_t offset = block.place(count, sizeof(T));
        if (at != nullptr) pointer = reinterpret_cast<T*>(at + offset);
    };
    const std::uint64_t pages = pages_of(t, b), groups = pages * max_page_groups, vertices = b.vertices;
    const std::uint64_t segments = segments_of(b), triangles = segments * b.segment_triangles,
                        morphing = b.morph ? vertices : 0;
    part(s.pages.page_groups, t.page_count());
    part(s.pages.loaded, t.slot_count);
    part(s.pages.groups, groups);
    part(s.work.queues.nodes, groups);
    part(s.pages.vertex_slot, groups * group_lanes);
    part(s.pages.state, pages);
    part(s.pages.free, pages);
    part(s.pages.idle, pages);
    part(s.pages.evicting, pages);
    part(s.work.schedule.ticks, pages * page_ticks);
    part(s.work.schedule.pages, pages);
    part(s.work.schedule.awake, pages);
    part(s.work.schedule.bounds, pages);
    part(s.work.schedule.next_due, pages);
    part(s.mesh.vertices, vertices);
    if (b.morph) part(s.mesh.morph, vertices); // otherwise it stays null
    part(s.mesh.triangle_of, vertices * 4);
    part(s.mesh.hole, vertices);
    part(s.mesh.free_vertices, vertices);
    part(s.mesh.indices, triangles * 3);
    part(s.mesh.tiles, t.tile_count() + 1);
    part(s.mesh.segment_tile, segments);
    part(s.mesh.segment_below, segments);
    part(s.mesh.free_segments, segments);
    for (DirtyBits* dirty : {&s.mesh.dirty_vertices, &s.mesh.untaken_vertices}) {
        part(dirty->bits, vertices / 64 + 1);
        part(dirty->words, vertices / 64 + 1);
    }
    for (DirtyBits* dirty : {&s.mesh.dirty_triangles, &s.mesh.untaken_triangles}) {
        part(dirty->bits, triangles / 64 + 1);
        part(dirty->words, triangles / 64 + 1);
    }
    part(s.mesh.ranges, segments);
    if (t.pages.order == PageOrder::hierarchical_z) part(s.pages.grid.hz_places, 2 * max_page_vertices);
    part(s.bulk.descents, b.workers);
    SlotGrid* grids = nullptr;
    const auto steps = static_cast<std::uint32_t>(t.tree.tile_log2);
    part(grids, std::uint64_t{steps} * b.workers);
    for (std::uint32_t worker = 0; at != nullptr && worker < b.workers; ++worker)
        s.bulk.descents[worker].grids = grids + std::size_t{steps} * worker;
    part(s.morphing.late_s, morphing);
    part(s.morphing.out, morphing);
    part(s.bulk.pages, pages);
    part(s.bulk.visited, pages);
    part(s.bulk.listed[0], pages);
    part(s.bulk.listed[1], pages);
    part(s.bulk.tiles, t.tile_count() + 1);
    part(s.bulk.bases, t.tile_count());
    return block.end();
}
std::size_t bytes_of(const TerrainData& t, const CutBudget& b) {
    CutState parts{};
    return lay_out(t, b, nullptr, parts);
}

Status check_budget(const TerrainData& t, const CutBudget& b) {
    if (t.pages.order == PageOrder::linear)
        return {StatusCode::not_supported,
                "terrain in linear order (bake with --order planar, or use the recursive method)"};
    if (b.vertices > 1u << 28) return {StatusCode::out_of_range, "CutBudget::vertices (at most 2^28)"};
    if (b.triangles > 1u << 29) return {StatusCode::out_of_range, "CutBudget::triangles (at most 2^29)"};
    if (b.segment_triangles < 8 || b.segment_triangles > 65536 || !std::has_single_bit(b.segment_triangles))
        return {StatusCode::out_of_range, "CutBudget::segment_triangles (8 to 65,536, a power of two)"};
    if (b.views < 1 || b.views > max_cut_views) return {StatusCode::out_of_range, "CutBudget::views (1 to 8)"};
    if (b.workers < 1 || b.workers > max_cut_workers) return {StatusCode::out_of_range, "CutBudget::workers (1 to 64)"};
    if (std::uint64_t{pages_of(t, b)} * max_page_vertices > 0xfffffff0u)
        return {StatusCode::out_of_range, "CutBudget::vertices (states for 1,369,568 pages at most)"};
    if (b.vertices < corner_count(t)) return {StatusCode::budget_too_small, "CutBudget::vertices (4 a tile)"};
    if (segments_of(b) < least_segments(t))
        return {StatusCode::budget_too_small, "CutBudget::triangles (a segment a tile, and 3)"};
    return {};
}

// Place of each group's lanes in hierarchical Z-order, for a page of each shape.
void make_hz_places(const Grid& grid) {
    const PageLayout& hz = grid.terrain->pages;
    const PageLayout planar{hz.tile_log2, PageOrder::planar};
    for (std::uint32_t shape = 0; shape < (hz.pages_per_tile() > 1 ? 2u : 1u); ++shape)
        for (std::uint32_t n = 0; n < grid.shapes[shape].count; ++n) {
            const GroupShape& group = grid.shapes[shape].groups[n];
            for (std::uint32_t lane = 0; lane < group.lanes; ++lane) {
                // The first page of either kind has the same place in its tile in both orders.
                const SampleIndex c = planar.coord({shape, group.first + group.stride * lane});
                std::uint32_t place = 0;
                if (shape == 0) {
                    place = hz.place(static_cast<std::uint32_t>(c.column), static_cast<std::uint32_t>(c.row)).index;
                } else {
                    const Site at = site_at(c);
                    place = page_index<PageOrder::hierarchical_z>(
                        page_squares, at.kind, static_cast<std::uint32_t>(at.i), static_cast<std::uint32_t>(at.j));
                }
                grid.hz_places[(shape * max_page_groups + n) * group_lanes + lane] = static_cast<std::uint16_t>(place);
            }
        }
}

void begin_grid(const TerrainData& terrain, const Terrain& handle, Grid& grid) {
    grid.handle = handle;
    grid.terrain = &terrain;
    grid.pages_per_tile = terrain.pages_per_tile;
    grid.tiles_x = terrain.tree.tiles_x;
    grid.tiles_y = terrain.tree.tiles_y;
    grid.shapes[0] = make_page_shape(terrain.pages, true);
    grid.shapes[1] = make_page_shape(terrain.pages, false);
    for (int z = 0; z < terrain.tree.tile_log2; ++z) {
        grid.steps[z] = make_step_groups(terrain.pages, z);
        const int level = 2 * (terrain.tree.tile_log2 - 1 - z);
        grid.level_unit_m[2 * z] = terrain.header.level_radius_m[level];
        grid.level_unit_m[2 * z + 1] = terrain.header.level_radius_m[level + 1];
    }
    if (grid.hz_places != nullptr) make_hz_places(grid);
}

// No view yet.
Criterion criterion_for(const TerrainData& terrain) {
    Criterion c{};
    c.error_m = terrain.errors.metres;
    c.radius_factor = terrain.radii.factor;
    c.base_m = terrain.height_scale.base_m;
    c.quantum_m = terrain.height_scale.quantum_m;
    c.spacing_x_m = terrain.spacing_x_m;
    c.spacing_z_m = terrain.spacing_z_m;
    c.last_x = terrain.tree.columns() - 1;
    c.last_y = terrain.tree.rows() - 1;
    return c;
}

void make_corners(const Grid& grid, Mesh& mesh) {
    const TerrainData& t = *grid.terrain;
    const auto make = [&](std::int32_t x, std::int32_t y) {
        const std::uint32_t slot = t.corner_at(x, y);
        const SampleIndex at = t.tree.sample({x * t.tree.side(), y * t.tree.side()});
        const std::uint32_t stored = t.corners[slot];
        const float height_m = t.height_scale.height_m(corner_steps(stored));
        mesh.vertices[slot] = {at.column, at.row, height_m};
        if (mesh.morph != nullptr) mesh.morph[slot] = {height_m, 0, 0, activated_long_ago_s};
        mesh.hole[slot] = t.has_voids() && (stored & corner_void_bit) != 0;
        mesh.dirty_vertices.mark(slot);
    };
    // Of a sparse terrain some more than once: places without a tile have none.
    for (std::uint32_t tile = 0; t.is_sparse() && tile < t.tile_count(); ++tile)
        for (std::int32_t k = 0; k < 4; ++k) make(t.tile_xy(tile).column + k % 2, t.tile_xy(tile).row + k / 2);
    for (std::int32_t y = 0; !t.is_sparse() && y <= grid.tiles_y; ++y)
        for (std::int32_t x = 0; x <= grid.tiles_x; ++x) make(x, y);
}

} // namespace

void reset(CutState& s) {
    const TerrainData& t = *s.pages.grid.terrain;
    s.bulk.phase = BulkPhase::idle; // all pages become idle anyway
    s.mesh.mapped = 0;
    s.morphing.late_count = s.morphing.out_count = 0;
    for (std::uint32_t i = 0; i < corner_count(t) * 4; ++i) s.mesh.triangle_of[i] = no_index;
    s.mesh.free_vertex_count = 0;
    s.mesh.fresh_vertex = corner_count(t);
    free_all_segments(s.mesh);
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
        const SampleIndex at = pages.grid.terrain->tile_xy(tile);
        const auto slot = [&](std::int32_t x, std::int32_t y) {
            return pages.grid.terrain->corner_at(at.column + x, at.row + y);
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
    return t != nullptr && check_budget(*t, budget).ok() ? bytes_of(*t, budget) : 0;
}

Status create_cut(const Terrain& handle, const CutBudget& budget, std::span<std::byte> memory, LiveCut& cut) {
    const TerrainData* const found = find(handle);
    if (found == nullptr) return {StatusCode::invalid_handle, "terrain"};
    const TerrainData& terrain = *found;
    if (Status fits = check_budget(terrain, budget); !fits.ok()) return fits;
    const std::size_t bytes = bytes_of(terrain, budget);
    if (memory.size() < bytes) return {StatusCode::memory_too_small, "memory"};
    std::byte* const at = memory.data();
    if (reinterpret_cast<std::uintptr_t>(at) % block_alignment != 0)
        return {StatusCode::out_of_range, "memory alignment"};
    std::memset(at, 0, bytes); // touches every page now rather than in a frame

    auto& s = *new (at) CutState{};
    (void)lay_out(terrain, budget, at, s);
    s.budget = budget;
    begin_grid(terrain, handle, s.pages.grid);
    s.pages.count = pages_of(terrain, budget);
    s.pages.group_count = s.pages.count * max_page_groups;
    s.pages.tiles_waiting = terrain.tile_count();
    s.work.queues.groups = s.pages.groups;
    s.work.queues.group_count = s.pages.group_count;
    s.work.queues.schedule = &s.work.schedule;
    clear_queues(s.work.queues);
    s.work.schedule.slot_count = s.pages.count;
    begin_schedule(s.work.schedule, static_cast<double>(std::min(terrain.spacing_x_m, terrain.spacing_z_m)) / 32);
    s.bulk.workers = budget.workers;
    s.bulk.pages_together = bulk_pages_together;
    s.mesh.capacity = s.morphing.ring_size = budget.vertices;
    s.mesh.corner_count = terrain.corner_count;
    s.mesh.tile_count = terrain.tile_count();
    s.mesh.segment_count = segments_of(budget);
    s.mesh.segment_log2 = static_cast<std::uint32_t>(std::countr_zero(budget.segment_triangles));
    s.mesh.some_hidden = hides_some(terrain);
    s.views.evaluate = evaluate;
    s.views.worst_px = worst_px;
    s.views.criterion = s.views.offscreen_criterion = criterion_for(terrain);
    s.morphing.clock.timed_ticks = s.morphing.clock.arrived_ticks = -clock_ticks; // never
    for (std::uint32_t i = 0; i < s.pages.group_count; ++i) s.pages.groups[i].queue = unqueued;
    for (std::uint32_t i = 0; i < terrain.page_count(); ++i) s.pages.page_groups[i] = no_index;
    for (std::uint32_t i = 0; i < s.pages.count; ++i) s.pages.state[i].page = no_index;
    for (std::uint32_t i = 0; i < terrain.slot_count; ++i) s.pages.loaded[i].page = no_index;
    rescan_pages(s.pages);
    s.pages.seen_ground = s.pages.seen_bases = terrain.ground_changes;
    reset(s);
    begin_at_roots(s.pages, s.work, s.mesh);
    HandleAccess::begin(s, cut);
    return {};
}

Status destroy_cut(LiveCut cut) {
    return HandleAccess::end(cut) ? Status{} : no_cut;
}

} // namespace fjell
