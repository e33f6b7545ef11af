#include "cut/bulk.h"

#include <bit>
#include <utility>

#include "cut/refine.h"

namespace fjell {

namespace {

// Bit i to bits 2i and 2i + 1.
std::uint32_t doubled(std::uint32_t v) {
    const std::uint32_t even = spread_bits(v);
    return even | even << 1;
}

// What two words of a row of 32 say.
std::uint32_t row_of(const GroupState* groups, std::uint16_t GroupState::*mask) {
    return static_cast<std::uint32_t>(groups[0].*mask) | static_cast<std::uint32_t>(groups[1].*mask) << 16;
}

GroupState* group_at(CutState& s, const Site& site) {
    if (!exists(s, site)) return nullptr;
    const std::uint32_t vertex = find_vertex(s, site);
    return vertex == no_index ? nullptr : &s.groups[vertex / group_lanes];
}

void set_bits(std::uint16_t& mask, std::uint32_t bits) {
    mask |= static_cast<std::uint16_t>(bits);
}

// A row of one page (or, of coarse steps, of one tile): up to 32 vertices in one or two groups.
struct Row {
    std::uint32_t group; // number of the first
    std::uint32_t words;
};

// Ready lanes of a row are decided; active ones take slots. Returns them.
std::uint32_t activate_row(CutState& s, const Row& row, std::uint32_t parents0, std::uint32_t parents1) {
    std::uint32_t active = 0;
    touch(s, row.group / max_page_groups);
    for (std::uint32_t word = 0; word < row.words; ++word, parents0 >>= 16, parents1 >>= 16) {
        GroupState& b = s.groups[row.group + word];
        set_bits(b.parent[0], parents0);
        set_bits(b.parent[1], parents1);
        if (b.ready() != 0) active |= build_group(s, row.group + word) << (16 * word);
    }
    return active;
}

// All squares of one step in one page, or one tile.
class Step {
public:
    Step(CutState& state, int z, std::int32_t i0, std::int32_t j0)
        : s(state), groups_(page_step_at(state, z, i0, j0)), z_(z), i0_(i0), j0_(j0), n_(groups_.n),
          words_(1u << groups_.step->words_log2) {}

    // Centres: which of their parents are active follows from the coarser step.
    void centres() {
        const bool root = z_ == s.terrain->tree.tile_log2 - 1;
        for (std::int32_t j = 0; j < n_; ++j) {
            const Row row = row_at(VertexKind::centre, j);
            if (root) {
                (void)activate_row(s, row, 1, 1);
                continue;
            }
            const std::int32_t jj = j0_ + j;
            GroupState* const sides_x = group_at(s, {z_ + 1, VertexKind::side_x, i0_ >> 1, (jj + 1) >> 1});
            GroupState* const sides_y = group_at(s, {z_ + 1, VertexKind::side_y, i0_ >> 1, jj >> 1});
            // One more side_y, east of the last square; often another page's.
            GroupState* const last_y = group_at(s, {z_ + 1, VertexKind::side_y, (i0_ + n_) >> 1, jj >> 1});
            const auto half = static_cast<std::uint32_t>(n_ / 2);
            const std::uint32_t lanes = (1u << half) - 1;
            const std::uint32_t shift_x = lane_of(z_ + 1, i0_ >> 1), shift_last = last_lane(jj >> 1);
            std::uint32_t x = sides_x ? sides_x->active >> shift_x & lanes : 0;
            std::uint32_t y = sides_y ? sides_y->active >> shift_x & lanes : 0;
            const std::uint32_t y_last = last_y ? last_y->active >> shift_last & 1u : 0;
            if ((x | y | y_last) == 0) continue;
            std::uint32_t parents0 = doubled(x);
            auto parents1 = static_cast<std::uint32_t>(
                (static_cast<std::uint64_t>(doubled(y)) | static_cast<std::uint64_t>(3 * y_last) << (2 * half)) >> 1);
            if (n_ < 32) {
                parents0 &= (1u << n_) - 1;
                parents1 &= (1u << n_) - 1;
            }
            const std::uint32_t active = activate_row(s, row, parents0, parents1);
            if (active != 0) add_children_of_sides(active, jj, half, sides_x, sides_y, last_y, shift_x, shift_last);
        }
    }

    // Sides: the centres of the page, and of those to its north and west, must have been decided.
    void sides() {
        for (std::int32_t j = 0; j < n_; ++j) {
            GroupState* const here = &s.groups[row_at(VertexKind::centre, j).group];
            GroupState* const north = j > 0 ? &s.groups[row_at(VertexKind::centre, j - 1).group]
                                            : group_at(s, {z_, VertexKind::centre, i0_, j0_ - 1});
            const std::uint32_t centres = active_row(here);
            const bool rim_north = j0_ + j == 0, rim_west = i0_ == 0;
            const std::uint32_t above = rim_north ? all() : north ? active_row(north) : 0;
            if ((above | centres) != 0 && (centres != 0 || !rim_north)) {
                const std::uint32_t x = activate_row(s, row_at(VertexKind::side_x, j), above, centres);
                if (x != 0) {
                    add_children(here, 2, x);
                    if (!rim_north) add_children(north, 3, x);
                }
            }
            GroupState* const west = rim_west ? nullptr : group_at(s, {z_, VertexKind::centre, i0_ - 1, j0_ + j});
            const std::uint32_t lane = lane_of(z_, i0_ - 1);
            const std::uint32_t left = rim_west ? 1u : west ? west->active >> lane & 1u : 0;
            if (centres != 0 || (left != 0 && !rim_west)) {
                const std::uint32_t y =
                    activate_row(s, row_at(VertexKind::side_y, j), (centres << 1 | left) & all(), centres);
                if (y != 0) {
                    add_children(here, 0, y);
                    add_children(here, 1, y >> 1);
                    if ((y & 1) != 0 && west) set_bits(west->child[1], 1u << lane);
                }
            }
        }
        rims();
    }

private:
    [[nodiscard]] std::uint32_t all() const { return n_ == 32 ? ~0u : (1u << n_) - 1; }
    [[nodiscard]] Row row_at(VertexKind kind, std::int32_t j) const { return {groups_.row(kind, j), words_}; }
    // The lane of a column of squares in its group.
    [[nodiscard]] std::uint32_t lane_of(int z, std::int32_t i) const {
        return static_cast<std::uint32_t>(i & ((1 << s.steps[z].log2) - 1)) % group_lanes;
    }
    // Of the side_y east of the last square, in the coarser step.
    [[nodiscard]] std::uint32_t last_lane(std::int32_t j) const {
        return find_vertex(s, {z_ + 1, VertexKind::side_y, (i0_ + n_) >> 1, j}) % group_lanes;
    }
    [[nodiscard]] std::uint32_t active_row(const GroupState* first) const {
        return words_ == 2 ? row_of(first, &GroupState::active) : first->active;
    }
    void add_children(GroupState* first, std::size_t direction, std::uint32_t bits) const {
        set_bits(first[0].child[direction], bits & (words_ == 2 ? 0xffffu : all()));
        if (words_ == 2) set_bits(first[1].child[direction], bits >> 16);
    }

    // Which child of which parent each active centre is follows from its square's parity (parent_bearing).
    void add_children_of_sides(std::uint32_t active, std::int32_t jj, std::uint32_t half, GroupState* sides_x,
                               GroupState* sides_y, GroupState* last_y, std::uint32_t shift_x,
                               std::uint32_t shift_last) const {
        const bool odd = (jj & 1) != 0;
        const std::uint32_t even_columns = even_bits(active), odd_columns = even_bits(active >> 1);
        if (sides_x) {
            set_bits(sides_x->child[odd ? 0 : 2], even_columns << shift_x);
            set_bits(sides_x->child[odd ? 1 : 3], odd_columns << shift_x);
        }
        const std::size_t of_odd = odd ? 2 : 0, of_even = odd ? 3 : 1;
        const std::uint32_t lanes = (1u << half) - 1;
        if (sides_y) {
            set_bits(sides_y->child[of_even], even_columns << shift_x);
            set_bits(sides_y->child[of_odd], (odd_columns << 1 & lanes) << shift_x);
        }
        if (last_y && (odd_columns >> (half - 1) & 1) != 0) set_bits(last_y->child[of_odd], 1u << shift_last);
    }

    // The terrain's south and east rim: sides with one parent.
    void rims() {
        const std::int32_t rows = s.tiles_y << s.steps[z_].log2, columns = s.tiles_x << s.steps[z_].log2;
        if (j0_ + n_ == rows) {
            GroupState* const north = &s.groups[row_at(VertexKind::centre, n_ - 1).group];
            if (const std::uint32_t centres = active_row(north); centres != 0) {
                const std::uint32_t x = activate_row(s, row_at(VertexKind::side_x, n_), centres, all());
                add_children(north, 3, x);
            }
        }
        if (i0_ + n_ != columns) return;
        for (std::int32_t j = 0; j < n_; j += group_lanes) {
            const std::uint32_t first = find_vertex(s, {z_, VertexKind::side_y, columns, j0_ + j});
            std::uint32_t centres = 0;
            const std::int32_t lanes = n_ < static_cast<std::int32_t>(group_lanes) ? n_ : group_lanes;
            for (std::int32_t lane = 0; lane < lanes; ++lane)
                centres |= (active_row(&s.groups[row_at(VertexKind::centre, j + lane).group]) >> (n_ - 1) & 1u) << lane;
            if (centres == 0) continue;
            const std::uint32_t y = activate_row(s, {first / group_lanes, 1}, centres, (1u << lanes) - 1);
            for (std::int32_t lane = 0; lane < lanes; ++lane)
                if ((y >> lane & 1) != 0)
                    add_children(&s.groups[row_at(VertexKind::centre, j + lane).group], 1, 1u << (n_ - 1));
        }
    }

    CutState& s;
    const PageStep groups_;
    const int z_;
    const std::int32_t i0_, j0_; // first square, over the terrain
    const std::int32_t n_;       // squares a side
    const std::uint32_t words_;
};

// One page of a step, or one tile of a coarse one. A side's parents in other pages lie to its north and west, where
// centres have been decided; there, whose page has active vertices counts.
bool build_page(CutState& s, const Site& first, bool may_have_centres) {
    Step page(s, first.z, first.i, first.j);
    if (may_have_centres) page.centres();
    const bool active = active_in_page_of(s, first) != 0;
    if (active || active_in_page_of(s, {first.z, VertexKind::centre, first.i - 1, first.j}) != 0 ||
        active_in_page_of(s, {first.z, VertexKind::centre, first.i, first.j - 1}) != 0)
        page.sides();
    return active;
}

// What the bulk pass has found active, page by page of one step.
struct BuiltPages {
    std::uint32_t* slots;
    std::uint32_t count = 0;
};

// A step with at most one page a tile: every tile.
void build_tiles(CutState& s, int z, BuiltPages& built) {
    const StepGroups& step = s.steps[z];
    const bool root = z == s.terrain->tree.tile_log2 - 1;
    for (std::int32_t tile_y = 0; tile_y < s.tiles_y; ++tile_y)
        for (std::int32_t tile_x = 0; tile_x < s.tiles_x; ++tile_x) {
            const Site first{z, VertexKind::centre, tile_x << step.log2, tile_y << step.log2};
            const std::uint32_t vertex = find_vertex(s, first);
            if (vertex == no_index) continue;
            // Without an active centre in the page over it no vertex of a page can have an active parent there.
            const bool below =
                root || active_in_page_of(s, {z + 1, VertexKind::centre, first.i >> 1, first.j >> 1}) != 0;
            if (build_page(s, first, below)) built.slots[built.count++] = vertex / group_lanes / max_page_groups;
        }
}

// A finer step: only pages under those that have active vertices, parent by parent, which keeps north and west first.
// And their neighbours to the east and south, which nobody else comes to: those have parents of theirs.
void build_below(CutState& s, int z, const BuiltPages& above, BuiltPages& built) {
    constexpr std::int32_t n = page_squares;
    const auto is_built = [&](const Site& first) {
        return active_in_page_of(s, {z + 1, VertexKind::centre, first.i >> 1, first.j >> 1}) != 0;
    };
    for (std::uint32_t at = 0; at < above.count; ++at) {
        const PageSlot& parent = s.page_slot[above.slots[at]];
        const std::int32_t i0 = 2 * ((parent.tile_x << s.steps[z + 1].log2) + parent.i0),
                           j0 = 2 * ((parent.tile_y << s.steps[z + 1].log2) + parent.j0);
        for (std::int32_t quarter = 0; quarter < 4; ++quarter) {
            const Site first{z, VertexKind::centre, i0 + quarter % 2 * n, j0 + quarter / 2 * n};
            const std::uint32_t vertex = find_vertex(s, first);
            if (vertex == no_index || !build_page(s, first, true)) continue;
            built.slots[built.count++] = vertex / group_lanes / max_page_groups;
            for (const Site& next :
                 {Site{z, VertexKind::centre, first.i + n, first.j}, Site{z, VertexKind::centre, first.i, first.j + n}})
                if (exists(s, next) && find_vertex(s, next) != no_index && !is_built(next))
                    (void)build_page(s, next, false);
        }
    }
}

} // namespace

bool build_all(CutState& s) {
    BuiltPages above{s.bulk_pages[0]}, built{s.bulk_pages[1]};
    for (int z = s.terrain->tree.tile_log2 - 1; z >= 0; --z) {
        built.count = 0;
        if (s.steps[z].log2 <= page_squares_log2)
            build_tiles(s, z, built);
        else
            build_below(s, z, above, built);
        if (s.full_capacities != 0) return false;
        std::swap(above, built);
    }
    // Every active vertex has split a triangle into two, twice unless it lies on the rim.
    const std::uint32_t most =
        2 * s.terrain->tile_count() + 2 * (s.budget.vertices - free_vertices(s) - corner_slots(s));
    // Every tile's last segment may be nearly empty, and that of what is not drawn; two stay back for deactivations. No
    // more, or the smallest budget that is taken could never be filled.
    const std::uint32_t segments = (most >> s.segment_log2) + s.terrain->tile_count() + (s.some_hidden ? 1 : 0) + 2;
    if (segments > s.segment_count) {
        s.full_capacities |= cut_budget_triangles;
        return false;
    }
    emit_triangles(s);
    return true;
}

} // namespace fjell
