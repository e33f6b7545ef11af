// The recursive method: its memory, how it begins, what a renderer sees of it; and an update, passes until one fits the
// budget. A capacity that does not suffice raises the threshold, because stopping half-way would crack.
#include "recursive/state.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "block_layout.h"
#include "recursive/emit.h"
#include "recursive/pass.h"

namespace fjell {

namespace {

constexpr std::uint32_t max_vertices = 0x7ffffffe; // the highest bit of a slot marks holes

std::uint64_t state_count(const TerrainData& terrain) {
    return std::uint64_t{terrain.slot_count} * terrain.page_capacity + std::uint64_t{terrain.tile_count()} * 4;
}

// Where its parts lie; one function for the size and for the placement, so they cannot disagree.
struct Layout {
    std::size_t statuses, slots, step_pages, slot_pages, vertices, owners, free_slots, indices, tiles, x_m2, z_m2, end;
};

static_assert(recursive_vertex_bytes == sizeof(MeshVertex) + 2 * 4,
              "hosts size their budgets by this: change it in fjell/recursive.h with layout_of()");

Layout layout_of(const TerrainData& terrain, const RecursiveBudget& budget) {
    Layout l{};
    BlockLayout block(sizeof(RecursiveState));
    const auto place = [&](std::uint64_t count, std::size_t bytes) { return block.place(count, bytes); };
    l.statuses = place(state_count(terrain), sizeof(std::uint16_t));
    l.slots = place(state_count(terrain), sizeof(std::uint32_t));
    l.step_pages = place(std::uint64_t{terrain.tile_count()} * entries_per_tile(terrain.pages), sizeof(StepPageEntry));
    l.slot_pages = place(terrain.slot_count, sizeof(std::uint32_t));
    l.vertices = place(budget.vertices, sizeof(MeshVertex));
    l.owners = place(budget.vertices, sizeof(std::uint32_t));
    l.free_slots = place(budget.vertices, sizeof(std::uint32_t));
    l.indices = place(budget.indices, sizeof(std::uint32_t));
    l.tiles = place(terrain.tile_count(), sizeof(TileRange));
    l.x_m2 = place(std::uint64_t{terrain.pages.side()} + 1, sizeof(float));
    l.z_m2 = place(std::uint64_t{terrain.pages.side()} + 1, sizeof(float));
    l.end = block.end();
    return l;
}

// Enters what a page slot holds now into the table of step pages. Answers whether its vertices were known.
bool move_page(RecursiveState& s, std::uint32_t slot) {
    const TerrainData& terrain = *s.terrain;
    const auto set = [&](std::uint32_t page, bool loaded) {
        if (page == no_index) return;
        // The page may have moved to another slot, which then says so itself, sooner or later.
        const PageEntry now = terrain.page_table[page];
        if (now.slot != (loaded ? slot : no_index)) return;
        const StepPageEntry entry{loaded ? slot * terrain.page_capacity : no_index, loaded ? now.base : 0};
        set_step_page(terrain, page % terrain.pages_per_tile, entry,
                      s.step_pages + std::size_t{page / terrain.pages_per_tile} * s.step_pages_per_tile);
    };
    const std::uint32_t before = std::exchange(s.slot_pages[slot], terrain.slot_page[slot]);
    set(before, false);
    set(s.slot_pages[slot], true);
    return before != no_index;
}

Status check_budget(const TerrainData& terrain, const RecursiveBudget& budget) {
    const std::uint64_t tiles = terrain.tile_count();
    if (state_count(terrain) >= no_index)
        return {StatusCode::out_of_range, "terrain: more than 4,294,967,294 vertices"};
    if (budget.vertices > max_vertices)
        return {StatusCode::out_of_range, "RecursiveBudget::vertices (at most 2^31 - 2)"};
    if (budget.vertices < tiles * 4) return {StatusCode::budget_too_small, "RecursiveBudget::vertices (4 a tile)"};
    if (budget.indices < tiles * 9) return {StatusCode::budget_too_small, "RecursiveBudget::indices (9 a tile)"};
    return {};
}

} // namespace

std::size_t recursive_bytes(const Terrain& terrain, const RecursiveBudget& budget) {
    const TerrainData* const t = find(terrain);
    return t != nullptr && check_budget(*t, budget).ok() ? layout_of(*t, budget).end : 0;
}

Status create_recursive(const Terrain& handle, const RecursiveBudget& budget, std::span<std::byte> memory,
                        RecursiveMethod& method) {
    const TerrainData* const found = find(handle);
    if (found == nullptr) return {StatusCode::invalid_handle, "terrain"};
    const TerrainData& terrain = *found;
    if (Status fits = check_budget(terrain, budget); !fits.ok()) return fits;
    const std::uint64_t tiles = terrain.tile_count(), count = state_count(terrain);
    const Layout l = layout_of(terrain, budget);
    if (memory.size() < l.end) return {StatusCode::memory_too_small, "memory"};
    std::byte* at = memory.data();
    if (reinterpret_cast<std::uintptr_t>(at) % block_alignment != 0)
        return {StatusCode::out_of_range, "memory alignment"};
    std::memset(at, 0, l.end); // touches every page now rather than in a frame

    auto& s = *new (at) RecursiveState{};
    s.terrain_handle = handle;
    s.terrain = &terrain;
    s.budget = budget;
    s.statuses = reinterpret_cast<std::uint16_t*>(at + l.statuses);
    s.slots = reinterpret_cast<std::uint32_t*>(at + l.slots);
    s.vertices = reinterpret_cast<MeshVertex*>(at + l.vertices);
    s.owners = reinterpret_cast<std::uint32_t*>(at + l.owners);
    s.free_slots = reinterpret_cast<std::uint32_t*>(at + l.free_slots);
    s.indices = reinterpret_cast<std::uint32_t*>(at + l.indices);
    s.tiles = reinterpret_cast<TileRange*>(at + l.tiles);
    s.x_m2 = reinterpret_cast<float*>(at + l.x_m2);
    s.z_m2 = reinterpret_cast<float*>(at + l.z_m2);
    s.state_count = static_cast<std::size_t>(count);
    s.slot_pages = reinterpret_cast<std::uint32_t*>(at + l.slot_pages);
    for (std::uint32_t i = 0; i < terrain.slot_count; ++i) s.slot_pages[i] = no_index;
    s.step_pages = reinterpret_cast<StepPageEntry*>(at + l.step_pages);
    s.step_pages_per_tile = entries_per_tile(terrain.pages);
    for (std::uint64_t i = 0; i < tiles * s.step_pages_per_tile; ++i) s.step_pages[i] = {no_index, 0};
    s.seen_changes = terrain.changes - 1;
    for (std::uint64_t i = 0; i < count; ++i) s.slots[i] = no_index;
    for (std::uint32_t i = 0; i < budget.vertices; ++i) {
        s.owners[i] = no_index;
        s.free_slots[i] = budget.vertices - 1 - i;
    }
    s.free_count = budget.vertices;
    sync_pages(s);
    HandleAccess::begin(s, method);
    return {};
}

Status destroy_recursive(RecursiveMethod method) {
    return HandleAccess::end(method) ? Status{} : no_recursive;
}

void sync_pages(RecursiveState& s) {
    const TerrainData& terrain = *s.terrain;
    if (s.seen_ground != terrain.ground_changes) { // vertices stand elsewhere: all are written anew
        s.seen_ground = terrain.ground_changes;
        s.free_count = s.budget.vertices;
        for (std::uint32_t i = 0; i < s.budget.vertices; ++i) {
            s.free_slots[i] = s.budget.vertices - 1 - i;
            if (s.owners[i] != no_index) s.slots[std::exchange(s.owners[i], no_index)] = no_index;
        }
        for (std::uint32_t slot = 0; slot < terrain.slot_count; ++slot) (void)move_page(s, slot);
    }
    if (s.seen_changes == terrain.changes) return;
    s.seen_changes = terrain.changes;
    for (std::uint32_t slot = 0; slot < terrain.slot_count; ++slot) {
        if (s.slot_pages[slot] == terrain.slot_page[slot]) continue;
        if (!move_page(s, slot)) continue;
        std::uint32_t* const slots = s.slots + std::size_t{slot} * terrain.page_capacity;
        for (std::uint32_t i = 0; i < terrain.page_capacity; ++i) {
            if (slots[i] == no_index) continue;
            const std::uint32_t vertex = std::exchange(slots[i], no_index) & ~hole_flag;
            s.owners[vertex] = no_index;
            s.free_slots[s.free_count++] = vertex;
        }
    }
}

MeshView recursive_mesh(RecursiveMethod method) {
    const RecursiveState* const found = find_recursive(method);
    if (found == nullptr) return {};
    const RecursiveState& s = *found;
    return {s.topology,
            {s.vertices, s.budget.vertices},
            {s.indices, s.index_count},
            {s.tiles, s.tile_count},
            s.dirty_begin < s.dirty_end ? s.dirty_begin : 0,
            s.dirty_end};
}

// --- an update

namespace {

constexpr double step_up = 1.25, step_down = 1 / 1.05;

// Where to start: where the last frame ended, a step finer when it had room to spare.
double first_threshold(const RecursiveState& s, double requested_px) {
    if (!s.exhausted || s.effective_px <= requested_px) return requested_px;
    const bool room = s.last_selected < s.budget.vertices / 5 * 4 && s.last_indices < s.budget.indices / 5 * 4;
    return std::max(requested_px, room ? s.effective_px * step_down : s.effective_px);
}

} // namespace

Status update_recursive(RecursiveMethod method, const View& view, const RefineSettings& settings, FrameReport& report) {
    RecursiveState* const found = find_recursive(method);
    if (found == nullptr) return no_recursive;
    RecursiveState& s = *found;
    if (Status v = validate(view); !v.ok()) return v;
    if (!(settings.max_error_px >= 1e-3 && settings.max_error_px <= 1e6))
        return {StatusCode::out_of_range, "RefineSettings::max_error_px"};
    if (settings.metric == Metric::depth && !settings.cull)
        return {StatusCode::out_of_range,
                "RefineSettings::cull (the depth metric needs it: behind the eye depth means nothing)"};
    sync_pages(s);
    s.topology = settings.topology;
    s.dirty_begin = s.budget.vertices;
    s.dirty_end = 0;
    report = {};
    report.frame = ++s.frame;
    const double requested_px = view_max_error_px(view, settings.max_error_px);
    report.error_px_requested = requested_px;

    const double corner = settings.corner_safe ? corner_factor(view) : 1;
    double threshold_px = first_threshold(s, requested_px);
    std::uint32_t exhausted = threshold_px > requested_px ? s.exhausted : 0;
    PassResult result;
    for (;; threshold_px *= step_up, ++report.restarts) {
        result = run_pass(s, view, settings, threshold_px / corner);
        report.vertices_written += result.written;
        report.buffer_clearings += result.clearings;
        exhausted |= result.exhausted;
        if (!result.exhausted) break;
    }
    s.effective_px = threshold_px;
    s.exhausted = report.exhausted = exhausted;
    s.last_selected = result.selected;
    s.last_indices = s.index_count;
    report.vertices = result.selected;
    report.triangles = result.triangles;
    report.tiles = result.tiles;
    report.error_bound_px = threshold_px;
    report.converged = threshold_px <= requested_px;
    return {};
}

// --- the vertex buffer

namespace {

void clear_unused(RecursiveState& s, PassResult& result) {
    if (result.clearings) return; // what is left is all of this pass
    ++result.clearings;
    for (std::uint32_t slot = s.budget.vertices; slot-- > 0;) {
        if (s.owners[slot] == no_index || is_selected(s, s.owners[slot])) continue;
        s.slots[s.owners[slot]] = no_index;
        s.owners[slot] = no_index;
        s.free_slots[s.free_count++] = slot;
    }
}

} // namespace

std::uint32_t insert_vertex(RecursiveState& s, std::uint32_t index, const MeshVertex& vertex, bool hole,
                            PassResult& result) {
    if (s.free_count == 0) clear_unused(s, result);
    if (s.free_count == 0) return no_index;
    const std::uint32_t slot = s.free_slots[--s.free_count];
    s.vertices[slot] = vertex;
    s.owners[slot] = index;
    s.dirty_begin = std::min(s.dirty_begin, slot);
    s.dirty_end = std::max(s.dirty_end, slot + 1);
    ++result.written;
    return s.slots[index] = slot | (hole ? hole_flag : 0);
}

} // namespace fjell
