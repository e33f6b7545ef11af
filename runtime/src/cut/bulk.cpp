#include "cut/bulk.h"

#include <bit>

#include "cut/change.h"
#include "cut/judge.h"
#include "cut/mesh.h"
#include "cut/visit.h"

namespace fjell {

namespace {

// Bit i to bits 2i and 2i + 1.
std::uint32_t doubled(std::uint32_t v) {
    const std::uint32_t even = spread_bits(v);
    return even | even << 1;
}

// What two words of a row of 32 say.
std::uint32_t row_of(const BlockState* blocks, std::uint16_t BlockState::*mask) {
    return static_cast<std::uint32_t>(blocks[0].*mask) | static_cast<std::uint32_t>(blocks[1].*mask) << 16;
}

BlockState* block_at(CutState& s, const Site& site) {
    if (!exists(s, site)) return nullptr;
    const std::uint32_t vertex = find_vertex(s, site);
    return vertex == no_vertex ? nullptr : &s.blocks[vertex / block_lanes];
}

void set_bits(std::uint16_t& mask, std::uint32_t bits) {
    mask |= static_cast<std::uint16_t>(bits);
}

// A row of one page (or, of coarse steps, of one tile): up to 32 vertices in one or two blocks.
struct Row {
    std::uint32_t block; // number of the first
    std::uint32_t words;
};

// Ready lanes of a row are decided; active ones take slots. Returns them.
std::uint32_t decide(CutState& s, const Row& row, std::uint32_t parents0, std::uint32_t parents1) {
    std::uint32_t active = 0;
    s.slot_info[row.block / max_page_blocks].touched = true;
    for (std::uint32_t word = 0; word < row.words; ++word, parents0 >>= 16, parents1 >>= 16) {
        BlockState& b = s.blocks[row.block + word];
        set_bits(b.parent[0], parents0);
        set_bits(b.parent[1], parents1);
        if (b.ready() != 0) active |= build_block(s, row.block + word) << (16 * word);
    }
    return active;
}

// All squares of one step in one page, or one tile.
class Step {
public:
    Step(CutState& state, int z, std::int32_t i0, std::int32_t j0)
        : s(state), z_(z), i0_(i0), j0_(j0), n_(1 << state.steps[z].page_log2),
          words_(1u << state.steps[z].words_log2) {}

    // Centres: which of their parents are active follows from the coarser step.
    void centres() {
        const bool root = z_ == s.terrain->tree.tile_log2 - 1;
        for (std::int32_t j = 0; j < n_; ++j) {
            const Row row = row_at(PlaneKind::centre, j);
            if (root) {
                (void)decide(s, row, 1, 1);
                continue;
            }
            const std::int32_t jj = j0_ + j;
            BlockState* const sides_x = block_at(s, {z_ + 1, PlaneKind::side_x, i0_ >> 1, (jj + 1) >> 1});
            BlockState* const sides_y = block_at(s, {z_ + 1, PlaneKind::side_y, i0_ >> 1, jj >> 1});
            // One more side_y, east of the last square; often another page's.
            BlockState* const last_y = block_at(s, {z_ + 1, PlaneKind::side_y, (i0_ + n_) >> 1, jj >> 1});
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
            const std::uint32_t active = decide(s, row, parents0, parents1);
            if (active != 0) tell_sides(active, jj, half, sides_x, sides_y, last_y, shift_x, shift_last);
        }
    }

    // Sides: all centres of the step must have been decided.
    void sides() {
        for (std::int32_t j = 0; j < n_; ++j) {
            BlockState* const here = &s.blocks[row_at(PlaneKind::centre, j).block];
            BlockState* const north =
                j > 0 ? &s.blocks[row_at(PlaneKind::centre, j - 1).block]
                      : block_at(s, {z_, PlaneKind::centre, i0_, j0_ - 1});
            const std::uint32_t centres = active_row(here);
            const bool rim_north = j0_ + j == 0, rim_west = i0_ == 0;
            const std::uint32_t above = rim_north ? all() : north ? active_row(north) : 0;
            if ((above | centres) != 0 && (centres != 0 || !rim_north)) {
                const std::uint32_t x = decide(s, row_at(PlaneKind::side_x, j), above, centres);
                if (x != 0) {
                    add_children(here, 2, x);
                    if (!rim_north) add_children(north, 3, x);
                }
            }
            BlockState* const west = rim_west ? nullptr : block_at(s, {z_, PlaneKind::centre, i0_ - 1, j0_ + j});
            const std::uint32_t lane = lane_of(z_, i0_ - 1);
            const std::uint32_t left = rim_west ? 1u : west ? west->active >> lane & 1u : 0;
            if (centres != 0 || (left != 0 && !rim_west)) {
                const std::uint32_t y = decide(s, row_at(PlaneKind::side_y, j), (centres << 1 | left) & all(), centres);
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
    [[nodiscard]] Row row_at(PlaneKind kind, std::int32_t j) const {
        const std::uint32_t vertex = find_vertex(s, {z_, kind, i0_, j0_ + j});
        return {vertex / block_lanes, words_};
    }
    // The lane of a column of squares in its block.
    [[nodiscard]] std::uint32_t lane_of(int z, std::int32_t i) const {
        return static_cast<std::uint32_t>(i & ((1 << s.steps[z].log2) - 1)) % block_lanes;
    }
    // Of the side_y east of the last square, in the coarser step.
    [[nodiscard]] std::uint32_t last_lane(std::int32_t j) const {
        return find_vertex(s, {z_ + 1, PlaneKind::side_y, (i0_ + n_) >> 1, j}) % block_lanes;
    }
    [[nodiscard]] std::uint32_t active_row(const BlockState* first) const {
        return words_ == 2 ? row_of(first, &BlockState::active) : first->active;
    }
    void add_children(BlockState* first, std::size_t direction, std::uint32_t bits) const {
        set_bits(first[0].child[direction], bits & (words_ == 2 ? 0xffffu : all()));
        if (words_ == 2) set_bits(first[1].child[direction], bits >> 16);
    }

    // Which child of which parent each active centre is follows from its square's parity (parent_bearing).
    void tell_sides(std::uint32_t active, std::int32_t jj, std::uint32_t half, BlockState* sides_x, BlockState* sides_y,
                    BlockState* last_y, std::uint32_t shift_x, std::uint32_t shift_last) const {
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
            BlockState* const north = &s.blocks[row_at(PlaneKind::centre, n_ - 1).block];
            if (const std::uint32_t centres = active_row(north); centres != 0) {
                const std::uint32_t x = decide(s, row_at(PlaneKind::side_x, n_), centres, all());
                add_children(north, 3, x);
            }
        }
        if (i0_ + n_ != columns) return;
        for (std::int32_t j = 0; j < n_; j += block_lanes) {
            const std::uint32_t first = find_vertex(s, {z_, PlaneKind::side_y, columns, j0_ + j});
            std::uint32_t centres = 0;
            const std::int32_t lanes = n_ < static_cast<std::int32_t>(block_lanes) ? n_ : block_lanes;
            for (std::int32_t lane = 0; lane < lanes; ++lane)
                centres |= (active_row(&s.blocks[row_at(PlaneKind::centre, j + lane).block]) >> (n_ - 1) & 1u) << lane;
            if (centres == 0) continue;
            const std::uint32_t y =
                decide(s, {first / block_lanes, 1}, centres, (1u << lanes) - 1);
            for (std::int32_t lane = 0; lane < lanes; ++lane)
                if ((y >> lane & 1) != 0)
                    add_children(&s.blocks[row_at(PlaneKind::centre, j + lane).block], 1, 1u << (n_ - 1));
        }
    }

    CutState& s;
    const int z_;
    const std::int32_t i0_, j0_; // first square, over the terrain
    const std::int32_t n_;       // squares a side
    const std::uint32_t words_;
};

// Every page of a step, or every tile of a coarse one, that is loaded.
template <typename Do>
void for_each_part(CutState& s, int z, const Do& act) {
    const StepBlocks& step = s.steps[z];
    const std::int32_t parts = 1 << (step.log2 - step.page_log2), n = 1 << step.page_log2;
    for (std::int32_t tile_y = 0; tile_y < s.tiles_y; ++tile_y)
        for (std::int32_t tile_x = 0; tile_x < s.tiles_x; ++tile_x)
            for (std::int32_t by = 0; by < parts; ++by)
                for (std::int32_t bx = 0; bx < parts; ++bx) {
                    const std::int32_t i0 = (tile_x << step.log2) + bx * n, j0 = (tile_y << step.log2) + by * n;
                    if (find_vertex(s, {z, PlaneKind::centre, i0, j0}) != no_vertex) act(i0, j0);
                }
}

// Slots of the vertices in and around one page, by their place on the lattice of its step: x, y from -1 to 2n. Only
// those of active vertices mean anything.
struct SlotGrid {
    static constexpr std::int32_t pitch = 2 * page_squares + 2;
    std::uint32_t at[pitch * pitch];
    [[nodiscard]] std::uint32_t& operator()(std::int32_t x, std::int32_t y) { return at[(y + 1) * pitch + x + 1]; }
};
static_assert(sizeof(SlotGrid) == bulk_grid_bytes);

// Triangles of one page of a step after the other, on the way down.
class Emitter {
public:
    explicit Emitter(CutState& state) : s(state) {}

    void tile(std::uint32_t number) {
        const std::int32_t tx = static_cast<std::int32_t>(number) % s.tiles_x, ty = static_cast<std::int32_t>(number) / s.tiles_x;
        tile_ = number;
        SlotGrid& grid = grid_of(s.terrain->tree.tile_log2 - 1);
        for (std::int32_t y = 0; y < 2; ++y)
            for (std::int32_t x = 0; x < 2; ++x)
                grid(2 * x, 2 * y) = static_cast<std::uint32_t>((ty + y) * (s.tiles_x + 1) + tx + x);
        if (find_vertex(s, {s.terrain->tree.tile_log2 - 1, PlaneKind::centre, tx, ty}) == no_vertex) {
            base(grid);
            return;
        }
        if (!page(s.terrain->tree.tile_log2 - 1, tx, ty)) base(grid);
    }

private:
    SlotGrid& grid_of(int z) { return reinterpret_cast<SlotGrid*>(s.bulk_grids)[z]; }

    void base(SlotGrid& grid) {
        const std::uint32_t nw = grid(0, 0), ne = grid(2, 0), sw = grid(0, 2), se = grid(2, 2);
        triangle(tile_, ne, nw, se, 2);
        triangle(tile_, sw, se, nw, 1);
    }

    void triangle(std::uint32_t tile, std::uint32_t right, std::uint32_t a, std::uint32_t b, std::uint32_t direction) {
        const MeshTriangle t{right, a, b};
        put_triangle(s, take_triangle(s, list_for(s, tile, t)), t, right * 4 + direction);
    }

    // Slots of a row's active vertices, to every other place of the grid.
    std::uint32_t spread(SlotGrid& grid, const Site& first, std::int32_t count, std::int32_t x, std::int32_t y) {
        std::uint32_t active = 0;
        if (!exists(s, first)) return 0;
        const std::uint32_t vertex = find_vertex(s, first);
        if (vertex == no_vertex) return 0;
        for (std::int32_t word = 0; word * 16 < count; ++word) {
            const std::uint32_t block = vertex / block_lanes + static_cast<std::uint32_t>(word);
            for (std::uint32_t lanes = s.blocks[block].active; lanes != 0; lanes &= lanes - 1) {
                const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
                grid(x + 2 * (word * 16 + static_cast<std::int32_t>(lane)), y) = s.slots[block * block_lanes + lane];
            }
            active |= static_cast<std::uint32_t>(s.blocks[block].active) << (16 * word);
        }
        return active;
    }
    void one(SlotGrid& grid, const Site& site, std::int32_t x, std::int32_t y) {
        if (!exists(s, site)) return;
        const std::uint32_t vertex = find_vertex(s, site);
        if (vertex != no_vertex && (s.blocks[vertex / block_lanes].active & bit_of(vertex))) grid(x, y) = s.slots[vertex];
    }

    // The grid has the corners of the page's squares. False when no centre is active, and so nothing below.
    bool page(int z, std::int32_t i0, std::int32_t j0) {
        SlotGrid& grid = grid_of(z);
        const std::int32_t n = 1 << s.steps[z].page_log2;
        std::uint32_t any = 0;
        for (std::int32_t j = 0; j < n; ++j)
            any |= spread(grid, {z, PlaneKind::centre, i0, j0 + j}, n, 1, 2 * j + 1);
        if (any == 0) return false;
        (void)spread(grid, {z, PlaneKind::centre, i0, j0 - 1}, n, 1, -1);
        std::uint32_t below = 0;
        for (std::int32_t j = 0; j <= n; ++j) {
            below |= spread(grid, {z, PlaneKind::side_x, i0, j0 + j}, n, 1, 2 * j);
            if (j == n) break;
            one(grid, {z, PlaneKind::centre, i0 - 1, j0 + j}, -1, 2 * j + 1);
            below |= spread(grid, {z, PlaneKind::side_y, i0, j0 + j}, n, 0, 2 * j + 1);
            one(grid, {z, PlaneKind::side_y, i0 + n, j0 + j}, 2 * n, 2 * j + 1);
        }
        const bool south_rim = j0 + n == s.tiles_y << s.steps[z].log2, east_rim = i0 + n == s.tiles_x << s.steps[z].log2;
        for (std::int32_t j = 0; j < n; ++j) {
            row(grid, {z, PlaneKind::centre, i0, j0 + j}, n, 1, 2 * j + 1);
            row(grid, {z, PlaneKind::side_x, i0, j0 + j}, n, 1, 2 * j);
            row(grid, {z, PlaneKind::side_y, i0, j0 + j}, n, 0, 2 * j + 1);
            if (east_rim) row(grid, {z, PlaneKind::side_y, i0 + n, j0 + j}, 1, 2 * n, 2 * j + 1);
        }
        if (south_rim) row(grid, {z, PlaneKind::side_x, i0, j0 + n}, n, 1, 2 * n);
        if (below != 0 && z > 0) descend(grid, z, i0, j0, n);
        return true;
    }

    void descend(SlotGrid& grid, int z, std::int32_t i0, std::int32_t j0, std::int32_t n) {
        const std::int32_t finer = 1 << s.steps[z - 1].page_log2; // squares of a page there: 2n, or n in four pages
        for (std::int32_t qy = 0; qy < 2 * n; qy += finer)
            for (std::int32_t qx = 0; qx < 2 * n; qx += finer) {
                if (find_vertex(s, {z - 1, PlaneKind::centre, 2 * i0 + qx, 2 * j0 + qy}) == no_vertex) continue;
                SlotGrid& to = grid_of(z - 1);
                for (std::int32_t y = 0; y <= finer; ++y)
                    for (std::int32_t x = 0; x <= finer; ++x) to(2 * x, 2 * y) = grid(qx + x, qy + y);
                (void)page(z - 1, 2 * i0 + qx, 2 * j0 + qy);
            }
    }

    // The triangles of a row of vertices.
    void row(SlotGrid& grid, const Site& first, std::int32_t count, std::int32_t x0, std::int32_t y) {
        const std::uint32_t vertex = find_vertex(s, first);
        const bool centre = first.kind == PlaneKind::centre;
        for (std::int32_t word = 0; word * 16 < count; ++word) {
            const BlockState& b = s.blocks[vertex / block_lanes + static_cast<std::uint32_t>(word)];
            std::uint32_t active = b.active;
            if (count == 1) active &= bit_of(vertex);
            for (; active != 0; active &= active - 1) {
                const auto lane = static_cast<std::uint32_t>(std::countr_zero(active));
                const std::int32_t x = x0 + (count == 1 ? 0 : 2 * (word * 16 + static_cast<std::int32_t>(lane)));
                std::uint32_t drawn = 0;
                for (std::uint32_t d = 0; d < 4; ++d) drawn |= (~static_cast<std::uint32_t>(b.child[d]) >> lane & 1u) << d;
                if (centre)
                    around_centre(grid, x, y, drawn);
                else
                    around_side(grid, first, word * 16 + static_cast<std::int32_t>(count == 1 ? 0 : lane), x, y, drawn);
            }
        }
    }

    void around_centre(SlotGrid& grid, std::int32_t x, std::int32_t y, std::uint32_t drawn) {
        const std::uint32_t v = grid(x, y), nw = grid(x - 1, y - 1), ne = grid(x + 1, y - 1), sw = grid(x - 1, y + 1),
                            se = grid(x + 1, y + 1);
        if (drawn & 1) triangle(tile_, v, nw, sw, 0);
        if (drawn & 2) triangle(tile_, v, se, ne, 1);
        if (drawn & 4) triangle(tile_, v, ne, nw, 2);
        if (drawn & 8) triangle(tile_, v, sw, se, 3);
        flatten(v, first_end_is_nw(x, y) ? nw : ne, first_end_is_nw(x, y) ? se : sw);
    }

    // Squares alternate; see parent_bearing. In a tile's only square of its first step the diagonal is nw to se.
    [[nodiscard]] static bool first_end_is_nw(std::int32_t x, std::int32_t y) { return ((x >> 1) + (y >> 1)) % 2 == 0; }

    void around_side(SlotGrid& grid, const Site& first, std::int32_t along, std::int32_t x, std::int32_t y,
                     std::uint32_t drawn) {
        const bool side_x = first.kind == PlaneKind::side_x;
        const Site site{first.z, first.kind, first.i + along, first.j};
        const std::uint32_t v = grid(x, y);
        const bool low = exists(s, parent_site(site, 0)), high = exists(s, parent_site(site, 1));
        const std::uint32_t tile_low = low ? tile_of(parent_site(site, 0)) : 0, tile_high = high ? tile_of(parent_site(site, 1)) : 0;
        const std::uint32_t west = grid(x - 1, y), east = grid(x + 1, y), north = grid(x, y - 1), south = grid(x, y + 1);
        // Quadrants: north-west, north-east, south-west, south-east. Apexes lie north and south, or west and east.
        const bool there[4] = {low, side_x ? low : high, side_x ? high : low, high};
        const std::uint32_t tiles[4] = {tile_low, side_x ? tile_low : tile_high, side_x ? tile_high : tile_low, tile_high};
        if (drawn & 1 && there[0]) triangle(tiles[0], v, north, west, 0);
        if (drawn & 2 && there[1]) triangle(tiles[1], v, east, north, 1);
        if (drawn & 4 && there[2]) triangle(tiles[2], v, west, south, 2);
        if (drawn & 8 && there[3]) triangle(tiles[3], v, south, east, 3);
        flatten(v, side_x ? west : north, side_x ? east : south);
    }

    [[nodiscard]] std::uint32_t tile_of(const Site& centre) const {
        const std::int32_t log2 = s.steps[centre.z].log2;
        return static_cast<std::uint32_t>((centre.j >> log2) * s.tiles_x + (centre.i >> log2));
    }

    void flatten(std::uint32_t v, std::uint32_t a, std::uint32_t b) {
        s.morph[v].flat_m = (s.vertices[a].height_m + s.vertices[b].height_m) * 0.5f;
    }

    CutState& s;
    std::uint32_t tile_ = 0;
};

} // namespace

bool build_all(CutState& s) {
    for (int z = s.terrain->tree.tile_log2 - 1; z >= 0; --z) {
        for_each_part(s, z, [&](std::int32_t i0, std::int32_t j0) { Step(s, z, i0, j0).centres(); });
        for_each_part(s, z, [&](std::int32_t i0, std::int32_t j0) { Step(s, z, i0, j0).sides(); });
        if (s.report.exhausted != 0) return false;
    }
    // Every active vertex has split a triangle into two, twice unless it lies on the rim.
    const std::uint32_t most = 2 * s.terrain->tile_count() + 2 * (s.budget.vertices - free_vertices(s) - corner_slots(s));
    const std::uint32_t chunks = (most >> s.chunk_log2) + s.terrain->tile_count() + 4;
    if (chunks > s.chunk_count) {
        s.report.exhausted |= cut_budget_triangles;
        return false;
    }
    Emitter emitter(s);
    for (std::uint32_t tile = 0; tile < s.terrain->tile_count(); ++tile) emitter.tile(tile);
    return true;
}

} // namespace fjell
