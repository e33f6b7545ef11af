// The cut's state from what the bulk pass has found: page by page, when its mesh is drawn already.
#include "cut/bulk_install.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "cut/bulk_rows.h"
#include "cut/state.h"

namespace fjell {

namespace {

class StepWriter {
public:
    StepWriter(Pages& pages, const BulkPass& bulk, const Mesh& mesh, const BulkSquares& at, const BulkMasks& masks)
        : pages_(pages), bulk_(bulk), slot_(at.slot), page_(bulk.pages[slot_]), taken_(mesh, bulk), at_(at),
          n_(static_cast<std::uint32_t>(at.n)), masks_(masks) {}

    // Returns how many parents are active.
    std::uint32_t step() {
        centres();
        // Children of sides: the finer centres of rows -1 to 2n - 1, those of even columns and those of odd ones.
        split_rows(masks_.finer, 2 * n_ + 1, even_, odd_);
        sides_x();
        sides_y();
        column();
        return parents_;
    }

private:
    // Rows that are other pages', or have nothing that might be active.
    void put_none(std::uint32_t first, std::uint32_t rows) {
        const std::uint32_t words_log2 = at_.step->words_log2;
        GroupState* const groups = pages_.groups + slot_ * max_page_groups + (std::size_t{first} << words_log2);
        std::fill_n(groups, rows << words_log2, GroupState{});
    }

    // Rows of a plane from `first` on. What the rim says of parents that do not exist comes after them.
    void put(std::uint32_t first, std::uint32_t rows, const std::uint32_t* parent0, const std::uint32_t* parent1) {
        const std::uint32_t words_log2 = at_.step->words_log2, *const active = page_.active + first;
        const std::uint32_t group = slot_ * max_page_groups + (first << words_log2);
        write_groups(pages_.groups + group, rows, 1u << words_log2,
                     {active, {parent0, parent1}, {child_[0], child_[1], child_[2], child_[3]}});
        parents_ += count_bits(parent0, rows) + count_bits(parent1, rows);
        put_slots(taken_, {&page_, first, rows}, pages_.vertex_slot + std::size_t{group} * group_lanes,
                  std::size_t{group_lanes} << words_log2);
    }

    void centres() {
        std::uint32_t parents[2][page_squares];
        const std::uint32_t first = at_.row(VertexKind::centre, 0);
        if (!centre_parents(pages_, bulk_, at_, parents)) return put_none(first, n_);
        for (std::uint32_t j = 0; j < n_; ++j) {
            const std::uint32_t active = page_.active[first + j];
            child_[0][j] = active & static_cast<std::uint32_t>(masks_.side_y[j]);
            child_[1][j] = active & static_cast<std::uint32_t>(masks_.side_y[j] >> 1);
            child_[2][j] = active & masks_.side_x[j];
            child_[3][j] = active & masks_.side_x[j + 1];
        }
        put(first, n_, parents[0], parents[1]);
    }
    void sides_x() {
        const std::uint32_t rows = n_ + (masks_.owns_south ? 1 : 0);
        std::uint32_t south[page_squares + 1];
        std::copy_n(masks_.centre + 1, n_, south);
        south[n_] = 0;
        for (std::uint32_t j = 0; j < rows; ++j) { // rows 2j - 1 and 2j
            const bool below = j != n_;
            child_[0][j] = even_[2 * j];
            child_[1][j] = odd_[2 * j];
            child_[2][j] = below ? even_[2 * j + 1] : 0;
            child_[3][j] = below ? odd_[2 * j + 1] : 0;
        }
        const std::uint32_t first = at_.row(VertexKind::side_x, 0);
        put(first, rows, masks_.centre, south);
        if (!masks_.owns_south) put_none(first + n_, 1);
    }
    void sides_y() {
        std::uint32_t west[page_squares];
        const std::uint32_t all = at_.all();
        for (std::uint32_t j = 0; j < n_; ++j) { // rows 2j and 2j + 1
            west[j] = (masks_.centre[j + 1] << 1 | masks_.west_centre[j]) & all;
            child_[0][j] = (odd_[2 * j + 1] << 1 | masks_.finer_west[2 * j]) & all;
            child_[1][j] = even_[2 * j + 1];
            child_[2][j] = (odd_[2 * j + 2] << 1 | masks_.finer_west[2 * j + 1]) & all;
            child_[3][j] = even_[2 * j + 2];
        }
        put(at_.row(VertexKind::side_y, 0), n_, west, masks_.centre + 1);
    }
    // East of the last squares, where the terrain ends: its lanes go south.
    void column() {
        if (!masks_.owns_east) return put_none(at_.column(), 1);
        std::uint32_t west = 0, child[4] = {};
        for (std::uint32_t j = 0; j < n_; ++j) {
            west |= (masks_.centre[j + 1] >> (n_ - 1) & 1) << j;
            for (std::uint32_t south = 0; south < 2; ++south)
                child[2 * south] |= (odd_[2 * j + 1 + south] >> (n_ - 1) & 1) << j;
        }
        for (std::size_t d = 0; d < 4; ++d) child_[d][0] = child[d];
        constexpr std::uint32_t none = 0;
        put(at_.column(), 1, &west, &none);
    }

    Pages& pages_;
    const BulkPass& bulk_;
    const std::uint32_t slot_;
    const BulkPage& page_;
    const BulkSlots taken_;
    const BulkSquares& at_;
    const std::uint32_t n_; // squares a side
    const BulkMasks& masks_;
    std::uint32_t even_[2 * page_squares + 1], odd_[2 * page_squares + 1];
    std::uint32_t child_[4][page_squares + 1];
    std::uint32_t parents_ = 0;
};

} // namespace

void write_step(Pages& pages, BulkPass& bulk, const Mesh& mesh, const BulkSquares& at, const BulkMasks& masks) {
    BulkPage& page = bulk.pages[at.slot];
    page.parents += StepWriter(pages, bulk, mesh, at, masks).step();
    page.has_groups = true;
}

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
void name_bases(const Grid& grid, const BulkPass& bulk, Mesh& mesh, std::uint32_t tile) {
    const SampleIndex place = grid.terrain->tile_xy(tile);
    mesh.triangle_of[grid.terrain->corner_at(place.column + 1, place.row) * 4 + 2] = bulk.bases[tile][0];
    mesh.triangle_of[grid.terrain->corner_at(place.column, place.row + 1) * 4 + 1] = bulk.bases[tile][1];
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
    s.morphing.late_count = s.morphing.out_count = 0;
    forget_late_pages(s.pages, s.mesh, s.morphing, s.frame, true);
    clear_queues(s.work.queues);
    forget_due(s.work.schedule);
    b.phase = BulkPhase::releasing;
    b.at = 0;
    b.begun_again = false;
}

namespace {

void install_pages(Pages& pages, Work& work, BulkPass& b, const Mesh& mesh, Frame& frame) {
    std::uint32_t parents[most_units];
    const std::uint32_t* const slots = b.visited + b.at;
    b.units = std::min(unit_limit(b, frame), b.visited_count - b.at);
    run_jobs(b, frame, b.units,
             [&](std::uint32_t n, std::uint32_t) { parents[n] = Installer(pages, b, mesh, slots[n]).page(); });
    for (std::uint32_t n = 0; n < b.units; ++n) {
        clear_page_schedule(work.schedule, slots[n]); // roots, again
        count_parents(pages, slots[n], parents[n]);
        const BulkPage& page = b.pages[slots[n]];
        charge_work(b, frame, page.wanted / states_a_part + 1);
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
            if (b.beside) {
                charge_work(b, s.frame, page.active / states_a_part + 1);
                release(s.pages, s.mesh, slot);
            }
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
