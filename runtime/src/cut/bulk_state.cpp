// The cut's state from what the bulk pass has found: page by page, when its mesh is drawn already.
#include <algorithm>
#include <bit>
#include <utility>

#include "cut/bulk.h"
#include "cut/bulk_masks.h"
#include "cut/jobs.h"
#include "cut/lag.h"
#include "cut/mesh.h"
#include "cut/pages.h"

namespace fjell {

namespace {

// A page's groups.
class Installer {
public:
    Installer(CutState& state, std::uint32_t slot) : s(state), slot_(slot), page_(s.bulk.pages[slot]), taken_(state) {}

    // Writes nothing but them, their vertices' slots, and how many there are. Returns how many parents are active.
    std::uint32_t page() {
        PageState& info = s.page_state[slot_];
        const int finest = info.shape == 0 ? std::max(s.terrain->tree.tile_log2 - page_squares_log2, 0) : info.z,
                  coarsest = info.shape == 0 ? s.terrain->tree.tile_log2 - 1 : info.z;
        std::uint32_t active = 0;
        for (int z = coarsest; z >= finest; --z) active += step(z);
        info.active = static_cast<std::uint16_t>(active);
        return parents_ - (info.shape == 0 ? 2 : 0); // a root's do not exist
    }

private:
    std::uint32_t step(int z) {
        const PageState& info = s.page_state[slot_];
        const StepGroups& step = s.steps[z];
        at_ = {&step,
               slot_,
               z,
               (info.tile_x << step.log2) + info.i0,
               (info.tile_y << step.log2) + info.j0,
               1 << step.page_log2};
        masks_.gather(s, at_);
        if (masks_.any_side) masks_.gather_finer(s, at_);
        const std::int32_t n = at_.n;
        std::uint32_t parents[2][page_squares], active = 0;
        if (centre_parents(s, at_, parents))
            for (std::int32_t j = 0; j < n; ++j) active += centres(j, parents[0][j], parents[1][j]);
        const std::uint32_t all = at_.all();
        for (std::int32_t j = 0; j < n; ++j) {
            const std::uint32_t c = masks_.centre[j + 1], left = masks_.west_centre(at_, j);
            if ((masks_.centre[j] | c) != 0) active += sides_x(j, masks_.centre[j], c);
            if ((c | left) != 0) active += sides_y(j, (c << 1 | left) & all, c);
        }
        if (masks_.owns_south && masks_.centre[n] != 0) active += sides_x(n, masks_.centre[n], 0);
        if (masks_.owns_east) active += column();
        return active;
    }

    // Lanes of one row, in one or two groups. What the rim says of parents that do not exist stays.
    std::uint32_t put(std::uint32_t row, std::uint32_t parent0, std::uint32_t parent1,
                      const std::uint32_t (&child)[4]) {
        const std::uint32_t words_log2 = at_.step->words_log2, active = page_.active[row];
        const std::uint32_t first = slot_ * max_page_groups + (row << words_log2);
        for (std::uint32_t word = 0; word < 1u << words_log2; ++word) {
            const auto part = [word](std::uint32_t bits) {
                return static_cast<std::uint16_t>(bits >> (group_lanes * word));
            };
            GroupState& group = s.groups[first + word];
            group.active = part(active);
            group.parent[0] |= part(parent0);
            group.parent[1] |= part(parent1);
            for (std::size_t d = 0; d < 4; ++d) group.child[d] = part(child[d]);
        }
        parents_ += static_cast<std::uint32_t>(std::popcount(parent0 | std::uint64_t{parent1} << 32));
        std::uint32_t number = page_.number + page_.first[row];
        std::uint32_t* const slots = s.vertex_slot + std::size_t{first} * group_lanes;
        const BulkSlots taken = taken_;
        for (std::uint32_t left = active; left != 0; left &= left - 1) slots[std::countr_zero(left)] = taken[number++];
        return static_cast<std::uint32_t>(std::popcount(active));
    }

    std::uint32_t centres(std::int32_t j, std::uint32_t parent0, std::uint32_t parent1) {
        if ((parent0 | parent1) == 0) return 0;
        const auto y = static_cast<std::uint32_t>(masks_.side_y[j]),
                   y_east = static_cast<std::uint32_t>(masks_.side_y[j] >> 1);
        const std::uint32_t row = at_.row(VertexKind::centre, j), active = page_.active[row];
        return put(row, parent0, parent1,
                   {y & active, y_east & active, masks_.side_x[j] & active, masks_.side_x[j + 1] & active});
    }
    std::uint32_t sides_x(std::int32_t j, std::uint32_t north, std::uint32_t south) {
        const std::uint64_t up = masks_.finer_row(2 * j - 1), down = masks_.finer_row(2 * j);
        return put(at_.row(VertexKind::side_x, j), north, south,
                   {even_of(up), even_of(up >> 1), even_of(down), even_of(down >> 1)});
    }
    std::uint32_t sides_y(std::int32_t j, std::uint32_t west, std::uint32_t east) {
        const std::uint64_t up = masks_.finer_row(2 * j), down = masks_.finer_row(2 * j + 1), all = at_.all();
        const auto shifted = [&](std::uint64_t row, std::int32_t j2) { return row << 1 | masks_.finer_west_of(j2); };
        std::uint32_t child[4] = {even_of(shifted(up, 2 * j)), even_of(up), even_of(shifted(down, 2 * j + 1)),
                                  even_of(down)};
        for (std::uint32_t& of : child) of &= static_cast<std::uint32_t>(all);
        return put(at_.row(VertexKind::side_y, j), west, east, child);
    }
    // East of the last squares, where the terrain ends: its lanes go south.
    std::uint32_t column() {
        std::uint32_t west = 0, child[4] = {};
        for (std::int32_t j = 0; j < at_.n; ++j) {
            west |= (masks_.centre[j + 1] >> (at_.n - 1) & 1) << j;
            for (std::int32_t south = 0; south < 2; ++south)
                child[2 * south] |= static_cast<std::uint32_t>(masks_.finer_row(2 * j + south) >> (2 * at_.n - 1) & 1)
                                    << j;
        }
        return west == 0 ? 0 : put(at_.column(), west, 0, child);
    }

    [[nodiscard]] static std::uint32_t even_of(std::uint64_t v) {
        if (v == 0) return 0; // as most are
        return even_bits(static_cast<std::uint32_t>(v)) | even_bits(static_cast<std::uint32_t>(v >> 32)) << 16;
    }

    CutState& s;
    const std::uint32_t slot_;
    const BulkPage& page_;
    const BulkSlots taken_;
    BulkSquares at_{};
    BulkMasks masks_;
    std::uint32_t parents_ = 0;
};

// What was active in a page gives its slots back.
void release(CutState& s, std::uint32_t slot) {
    PageState& page = s.page_state[slot];
    for (std::uint32_t n = 0; page.active != 0 && n < s.shapes[page.shape].count; ++n) {
        const std::uint32_t number = slot * max_page_groups + n;
        for (std::uint32_t left = s.groups[number].active; left != 0; left &= left - 1, --page.active) {
            const std::uint32_t vertex =
                s.vertex_slot[number * group_lanes + static_cast<std::uint32_t>(std::countr_zero(left))];
            s.free_vertices[s.free_vertex_count++] = vertex;
        }
    }
}

// The two triangles that a tile's root splits, or that it is.
void name_bases(CutState& s, std::uint32_t tile) {
    const Coord place = s.terrain->tile_xy(tile);
    s.triangle_of[s.terrain->corner_at(place.x + 1, place.y) * 4 + 2] = s.bulk.bases[tile][0];
    s.triangle_of[s.terrain->corner_at(place.x, place.y + 1) * 4 + 1] = s.bulk.bases[tile][1];
}

} // namespace

void install_mesh(CutState& s) {
    BulkPass& b = s.bulk;
    FJELL_ASSERT(b.phase == BulkPhase::built);
    for (std::uint32_t i = 0; i <= s.terrain->tile_count(); ++i) {
        TileList& list = s.tiles[i];
        for (std::uint32_t segment = list.last_segment; segment != no_index; segment = s.segment_below[segment])
            s.free_segments[s.free_segment_count++] = segment;
        static_cast<TileStack&>(list) = b.tiles[i];
        if (i != s.terrain->tile_count()) name_bases(s, i);
    }
    if (b.beside) {
        b.mapped = std::min(b.taken, b.free_before);
        s.fresh_vertex = b.fresh_before + (b.taken - b.mapped);
    } else {
        s.free_vertex_count = 0;
        s.fresh_vertex = b.fresh_before + b.taken;
    }
    s.work_ranks = 0;
    s.late_count = s.morphing_out_count = 0;
    forget_late_pages(s, true);
    clear_queues(s.queues);
    forget_due(s.schedule);
    b.phase = BulkPhase::releasing;
    b.at = 0;
}

namespace {

void install_pages(CutState& s) {
    BulkPass& b = s.bulk;
    std::uint32_t parents[most_units];
    const std::uint32_t* const slots = b.visited + b.at;
    b.units = std::min(unit_limit(s), b.visited_count - b.at);
    run_jobs(s, b.units, [&](std::uint32_t n, std::uint32_t) { parents[n] = Installer(s, slots[n]).page(); });
    for (std::uint32_t n = 0; n < b.units; ++n) {
        clear_page_schedule(s.schedule, slots[n]); // roots, again
        count_parents(s, slots[n], parents[n]);
        const BulkPage& page = b.pages[slots[n]];
        if (page.grades != 0) install_ticks(s.schedule, slots[n], page.ticks, page.grades - 1u, b.travelled_m);
    }
    b.at += b.units;
}

} // namespace

bool step_install(CutState& s) {
    BulkPass& b = s.bulk;
    b.units = 1;
    if (b.phase == BulkPhase::releasing) {
        while (b.at != s.fresh_page) {
            const std::uint32_t slot = b.at++;
            const PageState& page = s.page_state[slot];
            const bool used = page.parents != 0 || s.schedule.pages[slot].awake != no_index;
            if (page.page == no_index || !used) continue;
            if (b.beside) release(s, slot);
            clear_page_schedule(s.schedule, slot);
            clear_page(s, slot);
            if (found_in(s, slot) == nullptr) note_idle(s, slot);
            return true;
        }
        b.phase = BulkPhase::installing;
        b.at = 0;
    }
    if (b.at != b.visited_count) {
        install_pages(s);
        return true;
    }
    // The stack's entries that said which slots were taken go, and those above them come down.
    constexpr std::uint32_t at_once = 1u << 14;
    if (b.mapped != 0) {
        const std::uint32_t above = s.free_vertex_count - b.free_before, count = std::min({b.mapped, above, at_once});
        std::copy_n(s.free_vertices + (s.free_vertex_count - count), count,
                    s.free_vertices + (b.free_before - b.mapped));
        b.mapped -= count;
        s.free_vertex_count -= count;
        if (count != above && b.mapped != 0) return true;
        s.free_vertex_count -= b.mapped;
        b.mapped = 0;
    }
    b.phase = BulkPhase::idle;
    return false;
}

} // namespace fjell
