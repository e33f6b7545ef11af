// The cut's state from what the bulk pass has found: page by page, when its mesh is drawn already.
#include <algorithm>
#include <bit>
#include <utility>

#include "cut/bulk.h"
#include "cut/bulk_groups.h"
#include "cut/jobs.h"
#include "cut/lag.h"
#include "cut/mesh.h"
#include "cut/pages.h"

namespace fjell {

namespace {

// A page's groups, a plane of a step at a time: all of them, so that nobody has to clear them before.
class Installer {
public:
    Installer(Pages& pages, BulkPass& bulk, const Mesh& mesh, std::uint32_t slot)
        : pages_(pages), bulk_(bulk), mesh_(mesh), slot_(slot), page_(bulk.pages[slot]) {}

    // Writes nothing but them, their vertices' slots, and how many there are. Returns how many parents are active.
    std::uint32_t page() {
        PageState& info = pages_.state[slot_];
        if (!page_.has_groups) steps();
        mark_absent_parents(pages_, slot_);
        info.active = page_.wanted;
        info.used = page_.wanted != 0;
        return page_.parents - (info.shape == 0 ? 2 : 0); // a root's do not exist
    }

private:
    void steps() {
        const PageState& info = pages_.state[slot_];
        const int finest =
                      info.shape == 0 ? std::max(pages_.grid.terrain->tree.tile_log2 - page_squares_log2, 0) : info.z,
                  coarsest = info.shape == 0 ? pages_.grid.terrain->tree.tile_log2 - 1 : info.z;
        if (info.shape == 0) zero_groups(pages_, slot_); // it has lanes of no vertex
        // Below a step without sides nothing is active, but for what neighbours have beside it.
        for (int z = coarsest; z >= finest; --z)
            if (z == coarsest || masks_.any_side || has_neighbours(z)) step(z);
    }
    // Are centres active along the page's west or north border?
    [[nodiscard]] bool has_neighbours(int z) const {
        const BulkSquares at = listed_squares(pages_, slot_, z);
        const BulkPage* const north = found_at(pages_, bulk_, z, at.i0, at.j0 - 1);
        if (row_bits(north, at.row(VertexKind::centre, at.n - 1)) != 0) return true;
        const BulkPage* const west = found_at(pages_, bulk_, z, at.i0 - 1, at.j0);
        std::uint32_t any = 0;
        for (std::int32_t j = 0; west != nullptr && j < at.n; ++j) any |= west->active[at.row(VertexKind::centre, j)];
        return (any >> (at.n - 1) & 1) != 0;
    }

    void step(int z) {
        const BulkSquares at = listed_squares(pages_, slot_, z);
        masks_.gather(pages_, bulk_, at);
        masks_.gather_finer(pages_, bulk_, at);
        write_step(pages_, bulk_, mesh_, at, masks_);
    }

    Pages& pages_;
    BulkPass& bulk_;
    const Mesh& mesh_;
    const std::uint32_t slot_;
    BulkPage& page_;
    BulkMasks masks_;
};

// What was active in a page gives its slots back.
void release(Pages& pages, Mesh& mesh, std::uint32_t slot) {
    PageState& page = pages.state[slot];
    for (std::uint32_t n = 0; page.active != 0 && n < pages.grid.shapes[page.shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        for (std::uint32_t left = pages.groups[number].active; left != 0; left &= left - 1, --page.active) {
            const std::uint32_t vertex =
                pages.vertex_slot[number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(left))];
            mesh.free_vertices[mesh.free_vertex_count++] = vertex;
        }
    }
}

// The two triangles that a tile's root splits, or that it is.
void name_bases(const Grid& grid, const BulkPass& bulk, const Mesh& mesh, std::uint32_t tile) {
    const Coord place = grid.terrain->tile_xy(tile);
    mesh.triangle_of[grid.terrain->corner_at(place.x + 1, place.y) * 4 + 2] = bulk.bases[tile][0];
    mesh.triangle_of[grid.terrain->corner_at(place.x, place.y + 1) * 4 + 1] = bulk.bases[tile][1];
}

} // namespace

void install_mesh(CutState& s) {
    BulkPass& b = s.bulk;
    FJELL_ASSERT(b.phase == BulkPhase::built);
    for (std::uint32_t i = 0; i <= s.mesh.tile_count; ++i) {
        TileList& list = s.mesh.tiles[i];
        for (std::uint32_t segment = list.last_segment; segment != no_index; segment = s.mesh.segment_below[segment])
            s.mesh.free_segments[s.mesh.free_segment_count++] = segment;
        static_cast<TileStack&>(list) = b.tiles[i];
        if (i != s.mesh.tile_count) name_bases(s.pages.grid, s.bulk, s.mesh, i);
    }
    if (b.beside) {
        s.mesh.mapped = std::min(b.taken, b.free_before);
        s.mesh.fresh_vertex = b.fresh_before + (b.taken - s.mesh.mapped);
    } else {
        s.mesh.free_vertex_count = 0;
        s.mesh.fresh_vertex = b.fresh_before + b.taken;
    }
    s.work.queues.work_ranks = 0;
    s.morphing.late_count = s.morphing.out_count = 0;
    forget_late_pages(s.pages, s.morphing, s.frame, true);
    clear_queues(s.work.queues);
    forget_due(s.work.schedule);
    b.phase = BulkPhase::releasing;
    b.at = 0;
}

namespace {

void install_pages(Pages& pages, Work& work, BulkPass& b, const Mesh& mesh, const Frame& frame) {
    std::uint32_t parents[most_units];
    const std::uint32_t* const slots = b.visited + b.at;
    b.units = std::min(unit_limit(b, frame), b.visited_count - b.at);
    run_jobs(b, frame, b.units,
             [&](std::uint32_t n, std::uint32_t) { parents[n] = Installer(pages, b, mesh, slots[n]).page(); });
    for (std::uint32_t n = 0; n < b.units; ++n) {
        clear_page_schedule(work.schedule, slots[n]); // roots, again
        count_parents(pages, slots[n], parents[n]);
        const BulkPage& page = b.pages[slots[n]];
        if (page.grades != 0) install_ticks(work.schedule, slots[n], page.ticks, page.grades - 1u, b.travelled_m);
    }
    b.at += b.units;
}

} // namespace

bool step_install(CutState& s) {
    BulkPass& b = s.bulk;
    b.units = 1;
    if (b.phase == BulkPhase::releasing) {
        while (b.at != s.pages.fresh) {
            const std::uint32_t slot = b.at++;
            const PageState& page = s.pages.state[slot];
            const bool used = page.parents != 0 || s.work.schedule.pages[slot].awake != no_index;
            if (page.page == no_index || !used) continue;
            if (is_clear(page) && found_in(s.bulk, slot) == nullptr) continue; // its root comes last
            if (b.beside) release(s.pages, s.mesh, slot);
            clear_page_schedule(s.work.schedule, slot);
            if (found_in(s.bulk, slot) != nullptr) { // its groups are all written, when their lines come anyway
                forget_active(s.pages, slot);
                return true;
            }
            clear_page(s.pages, slot);
            note_idle(s.pages, slot);
            return true;
        }
        b.phase = BulkPhase::installing;
        b.at = 0;
    }
    if (b.phase == BulkPhase::installing) {
        if (b.at != b.visited_count) {
            install_pages(s.pages, s.work, s.bulk, s.mesh, s.frame);
            return true;
        }
        b.phase = BulkPhase::installing_roots;
        b.at = 0;
    }
    if (b.at != s.mesh.tile_count && step_install_roots(s.pages, s.work, s.bulk, s.mesh)) return true;
    // The stack's entries that said which slots were taken go, and those above them come down.
    constexpr std::uint32_t at_once = 1u << 14;
    if (s.mesh.mapped != 0) {
        const std::uint32_t above = s.mesh.free_vertex_count - b.free_before,
                            count = std::min({s.mesh.mapped, above, at_once});
        std::copy_n(s.mesh.free_vertices + (s.mesh.free_vertex_count - count), count,
                    s.mesh.free_vertices + (b.free_before - s.mesh.mapped));
        s.mesh.mapped -= count;
        s.mesh.free_vertex_count -= count;
        if (count != above && s.mesh.mapped != 0) return true;
        s.mesh.free_vertex_count -= s.mesh.mapped;
        s.mesh.mapped = 0;
    }
    b.phase = BulkPhase::idle;
    return false;
}

} // namespace fjell
