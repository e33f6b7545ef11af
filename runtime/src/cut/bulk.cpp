#include "cut/bulk.h"

#include <bit>

#include "cut/change.h"
#include "cut/judge.h"
#include "cut/mesh.h"
#include "cut/morph.h"
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

// The blocks of one step in one page or, of coarse steps, in one tile.
struct Part {
    const StepBlocks* step;
    std::uint32_t first; // block of the page
    std::int32_t n;      // squares a side
    [[nodiscard]] std::uint32_t row(PlaneKind kind, std::int32_t j) const { // j: 0..n for side_x
        const std::uint32_t plane = kind == PlaneKind::centre   ? step->centres
                                    : kind == PlaneKind::side_x ? step->sides_x
                                                                : step->sides_y;
        return first + plane + (static_cast<std::uint32_t>(j) << step->words_log2);
    }
};
Part part_at(const CutState& s, int z, std::int32_t i0, std::int32_t j0) {
    const StepBlocks& step = s.steps[z];
    return {&step, find_vertex(s, {z, PlaneKind::centre, i0, j0}) / block_lanes - step.centres, 1 << step.page_log2};
}

// All squares of one step in one page, or one tile.
class Step {
public:
    Step(CutState& state, int z, std::int32_t i0, std::int32_t j0)
        : s(state), part_(part_at(state, z, i0, j0)), z_(z), i0_(i0), j0_(j0), n_(part_.n),
          words_(1u << part_.step->words_log2) {}

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
    [[nodiscard]] Row row_at(PlaneKind kind, std::int32_t j) const { return {part_.row(kind, j), words_}; }
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
    const Part part_;
    const int z_;
    const std::int32_t i0_, j0_; // first square, over the terrain
    const std::int32_t n_;       // squares a side
    const std::uint32_t words_;
};

// How many vertices are active in the page of a square; 0 where there is none.
std::uint32_t active_at(const CutState& s, const Site& centre) {
    if (!exists(s, centre)) return 0;
    const std::uint32_t vertex = find_vertex(s, centre);
    return vertex == no_vertex ? 0 : s.slot_info[vertex / block_lanes / max_page_blocks].active;
}

// Every page of a step, or every tile of a coarse one, that is loaded.
template <typename Do>
void for_each_part(CutState& s, int z, const Do& act) {
    const StepBlocks& step = s.steps[z];
    const std::int32_t parts = 1 << (step.log2 - step.page_log2), n = 1 << step.page_log2;
    for (std::int32_t tile_y = 0; tile_y < s.tiles_y; ++tile_y)
        for (std::int32_t tile_x = 0; tile_x < s.tiles_x; ++tile_x)
            for (std::int32_t by = 0; by < parts; ++by)
                for (std::int32_t bx = 0; bx < parts; ++bx) {
                    const Site first{z, PlaneKind::centre, (tile_x << step.log2) + bx * n, (tile_y << step.log2) + by * n};
                    if (find_vertex(s, first) != no_vertex) act(first);
                }
}

// Centres of a step. Without an active centre in the page over it no vertex of a page can have an active parent there.
void build_centres(CutState& s, int z) {
    const bool root = z == s.terrain->tree.tile_log2 - 1;
    for_each_part(s, z, [&](const Site& first) {
        if (root || active_at(s, {z + 1, PlaneKind::centre, first.i >> 1, first.j >> 1}) != 0)
            Step(s, z, first.i, first.j).centres();
    });
}
// And its sides, some of which have a parent in the page to their north or west.
void build_sides(CutState& s, int z) {
    for_each_part(s, z, [&](const Site& first) {
        if (active_at(s, first) != 0 || active_at(s, {z, PlaneKind::centre, first.i - 1, first.j}) != 0 ||
            active_at(s, {z, PlaneKind::centre, first.i, first.j - 1}) != 0)
            Step(s, z, first.i, first.j).sides();
    });
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
        const auto tx = static_cast<std::int32_t>(number) % s.tiles_x, ty = static_cast<std::int32_t>(number) / s.tiles_x;
        const int z = s.terrain->tree.tile_log2 - 1;
        tile_ = number;
        open();
        SlotGrid& grid = grid_of(z);
        for (std::int32_t y = 0; y < 2; ++y)
            for (std::int32_t x = 0; x < 2; ++x)
                grid(2 * x, 2 * y) = static_cast<std::uint32_t>((ty + y) * (s.tiles_x + 1) + tx + x);
        if (find_vertex(s, {z, PlaneKind::centre, tx, ty}) == no_vertex || !page(z, tx, ty)) base(grid);
        close();
    }

private:
    SlotGrid& grid_of(int z) { return reinterpret_cast<SlotGrid*>(s.bulk_grids)[z]; }

    // The tile's last chunk, written without a look at its list.
    void open() {
        const TileList& list = s.tiles[tile_];
        next_ = end_ = 0;
        if (list.last_chunk == nil) return;
        next_ = (list.last_chunk << s.chunk_log2) + list.in_last;
        end_ = (list.last_chunk + 1) << s.chunk_log2;
    }
    void close() {
        TileList& list = s.tiles[tile_];
        if (list.last_chunk == nil) return;
        const std::uint32_t in_last = next_ - (list.last_chunk << s.chunk_log2);
        list.total += in_last - list.in_last;
        list.in_last = in_last;
    }
    void triangle(std::uint32_t tile, const MeshTriangle& t, std::uint32_t direction) {
        const std::uint32_t list = list_for(s, tile, t);
        if (list == tile_) close();
        put_triangle(s, take_triangle(s, list), t, t.right * 4 + direction);
        if (list == tile_) open();
    }

    void base(SlotGrid& grid) {
        const std::uint32_t nw = grid(0, 0), ne = grid(2, 0), sw = grid(0, 2), se = grid(2, 2);
        triangle(tile_, {ne, nw, se}, 2);
        triangle(tile_, {sw, se, nw}, 1);
    }

    // The triangles around a vertex: direction d lies between corners[d][0] and corners[d][1].
    void fan(std::uint32_t v, const std::uint32_t (&corners)[4][2], std::uint32_t drawn) {
        if (s.some_hidden || next_ + 4 > end_) {
            for (std::uint32_t d = 0; d < 4; ++d)
                if (drawn >> d & 1) triangle(tile_, {v, corners[d][0], corners[d][1]}, d);
            return;
        }
        // All four are written, the next over one that is not drawn: no branch can be mispredicted.
        for (std::uint32_t d = 0; d < 4; ++d) {
            const std::uint32_t is_drawn = drawn >> d & 1;
            std::uint32_t* const t = s.indices + std::size_t{next_} * 3;
            t[0] = v, t[1] = corners[d][0], t[2] = corners[d][1];
            s.names[next_] = v * 4 + d;
            s.made[v * 4 + d] = next_ | (is_drawn - 1); // nil when not
            next_ += is_drawn;
        }
    }

    // Slots of a row's active vertices, to every other place of the grid. Answers whether there are any.
    bool spread(SlotGrid& grid, std::uint32_t block, std::int32_t count, std::int32_t x, std::int32_t y) {
        std::uint32_t any = 0;
        std::uint32_t* to = &grid(x, y);
        for (std::int32_t done = 0; done < count; done += block_lanes, ++block, to += 2 * block_lanes) {
            if (s.blocks[block].active == 0) continue;
            any |= s.blocks[block].active;
            const std::uint32_t* const from = s.slots + std::size_t{block} * block_lanes;
            if (count < static_cast<std::int32_t>(block_lanes))
                for (std::int32_t lane = 0; lane < count; ++lane) to[2 * lane] = from[lane];
            else
                for (std::uint32_t lane = 0; lane < block_lanes; ++lane) to[2 * lane] = from[lane];
        }
        return any != 0;
    }
    void one(SlotGrid& grid, const Site& site, std::int32_t x, std::int32_t y) {
        if (!exists(s, site)) return;
        const std::uint32_t vertex = find_vertex(s, site);
        if (vertex != no_vertex) grid(x, y) = s.slots[vertex];
    }

    // The grid has the corners of the page's squares. False when no centre is active, and so nothing below.
    bool page(int z, std::int32_t i0, std::int32_t j0) {
        SlotGrid& grid = grid_of(z);
        const Part part = part_at(s, z, i0, j0);
        const std::int32_t n = part.n;
        bool any = false, below = false;
        for (std::int32_t j = 0; j < n; ++j)
            any = spread(grid, part.row(PlaneKind::centre, j), n, 1, 2 * j + 1) || any;
        if (!any) return false;
        for (std::int32_t j = 0; j < n; ++j) {
            below = spread(grid, part.row(PlaneKind::side_x, j), n, 1, 2 * j) || below;
            below = spread(grid, part.row(PlaneKind::side_y, j), n, 0, 2 * j + 1) || below;
        }
        below = borders(grid, z, i0, j0, n) || below;
        rows(grid, z, i0, j0, part);
        if (below && z > 0) descend(grid, z, i0, j0, n);
        return true;
    }

    // What lies around the page and belongs to its neighbours: apexes to the north and west, sides to the south and east.
    bool borders(SlotGrid& grid, int z, std::int32_t i0, std::int32_t j0, std::int32_t n) {
        const Site north{z, PlaneKind::centre, i0, j0 - 1}, south{z, PlaneKind::side_x, i0, j0 + n};
        if (exists(s, north))
            if (const std::uint32_t v = find_vertex(s, north); v != no_vertex)
                (void)spread(grid, v / block_lanes, n, 1, -1);
        bool below = false;
        if (const std::uint32_t v = find_vertex(s, south); v != no_vertex)
            below = spread(grid, v / block_lanes, n, 1, 2 * n);
        for (std::int32_t j = 0; j < n; ++j) {
            one(grid, {z, PlaneKind::centre, i0 - 1, j0 + j}, -1, 2 * j + 1);
            const std::uint32_t v = find_vertex(s, {z, PlaneKind::side_y, i0 + n, j0 + j});
            if (v == no_vertex || !(s.blocks[v / block_lanes].active & bit_of(v))) continue;
            grid(2 * n, 2 * j + 1) = s.slots[v];
            below = true;
        }
        return below;
    }

    void rows(SlotGrid& grid, int z, std::int32_t i0, std::int32_t j0, const Part& part) {
        z_ = z;
        corner_ = {2 * i0, 2 * j0};
        const std::int32_t n = part.n, tile_side = (1 << part.step->log2) - 1;
        for (std::int32_t j = 0; j < n; ++j) {
            centre_row(grid, part.row(PlaneKind::centre, j), n, 2 * j + 1);
            const bool north_border = ((j0 + j) & tile_side) == 0;
            side_row(grid, {z, PlaneKind::side_x, i0, j0 + j}, part.row(PlaneKind::side_x, j), n, 2 * j, north_border);
            side_row(grid, {z, PlaneKind::side_y, i0, j0 + j}, part.row(PlaneKind::side_y, j), n, 2 * j + 1,
                     (i0 & tile_side) == 0);
        }
        if (j0 + n == s.tiles_y << part.step->log2)
            side_row(grid, {z, PlaneKind::side_x, i0, j0 + n}, part.row(PlaneKind::side_x, n), n, 2 * n, true);
        if (i0 + n == s.tiles_x << part.step->log2)
            for (std::int32_t j = 0; j < n; ++j) {
                const Site site{z, PlaneKind::side_y, i0 + n, j0 + j};
                const std::uint32_t v = find_vertex(s, site);
                const BlockState& b = s.blocks[v / block_lanes];
                if (b.active & bit_of(v)) border_side(grid, site, 2 * n, 2 * j + 1, drawn_by(b, v % block_lanes));
            }
    }

    [[nodiscard]] static std::uint32_t drawn_by(const BlockState& b, std::uint32_t lane) {
        std::uint32_t drawn = 0;
        for (std::uint32_t d = 0; d < 4; ++d) drawn |= (~static_cast<std::uint32_t>(b.child[d]) >> lane & 1u) << d;
        return drawn;
    }

    void descend(SlotGrid& grid, int z, std::int32_t i0, std::int32_t j0, std::int32_t n) {
        const std::int32_t finer = 1 << s.steps[z - 1].page_log2; // squares of a page there: 2n, or n in four pages
        for (std::int32_t qy = 0; qy < 2 * n; qy += finer)
            for (std::int32_t qx = 0; qx < 2 * n; qx += finer) {
                if (active_at(s, {z - 1, PlaneKind::centre, 2 * i0 + qx, 2 * j0 + qy}) == 0) continue;
                SlotGrid& to = grid_of(z - 1);
                for (std::int32_t y = 0; y <= finer; ++y) {
                    const std::uint32_t* const from = &grid(qx, qy + y);
                    std::uint32_t* const row = &to(0, 2 * y);
                    for (std::int32_t x = 0; x <= finer; ++x) row[2 * x] = from[x];
                }
                (void)page(z - 1, 2 * i0 + qx, 2 * j0 + qy);
            }
    }

    void centre_row(SlotGrid& grid, std::uint32_t block, std::int32_t count, std::int32_t y) {
        for (std::int32_t x0 = 1; x0 < 2 * count; x0 += 2 * static_cast<std::int32_t>(block_lanes), ++block) {
            const BlockState& b = s.blocks[block];
            for (std::uint32_t active = b.active; active != 0; active &= active - 1) {
                const auto lane = static_cast<std::uint32_t>(std::countr_zero(active));
                const std::int32_t x = x0 + 2 * static_cast<std::int32_t>(lane);
                const std::uint32_t nw = grid(x - 1, y - 1), ne = grid(x + 1, y - 1), sw = grid(x - 1, y + 1),
                                    se = grid(x + 1, y + 1), v = grid(x, y);
                fan(v, {{nw, sw}, {se, ne}, {ne, nw}, {sw, se}}, drawn_by(b, lane));
                // Squares alternate which diagonal a centre splits (parent_bearing).
                const bool falling = ((x >> 1) + (y >> 1)) % 2 == 0;
                flatten(v, x, y, falling ? nw : ne, falling ? se : sw);
            }
        }
    }

    void side_row(SlotGrid& grid, const Site& first, std::uint32_t block, std::int32_t count, std::int32_t y, bool border) {
        const bool side_x = first.kind == PlaneKind::side_x;
        for (std::int32_t along = 0; along < count; along += static_cast<std::int32_t>(block_lanes), ++block) {
            const BlockState& b = s.blocks[block];
            for (std::uint32_t active = b.active; active != 0; active &= active - 1) {
                const auto lane = static_cast<std::uint32_t>(std::countr_zero(active));
                const std::int32_t i = along + static_cast<std::int32_t>(lane), x = 2 * i + (side_x ? 1 : 0);
                if (border && (side_x || i == 0)) {
                    border_side(grid, {first.z, first.kind, first.i + i, first.j}, x, y, drawn_by(b, lane));
                    continue;
                }
                const std::uint32_t v = grid(x, y), west = grid(x - 1, y), east = grid(x + 1, y), north = grid(x, y - 1),
                                    south = grid(x, y + 1);
                fan(v, {{north, west}, {east, north}, {west, south}, {south, east}}, drawn_by(b, lane));
                flatten(v, x, y, side_x ? west : north, side_x ? east : south);
            }
        }
    }

    // A side between two tiles, or on the terrain's rim: each triangle belongs to the tile of its apex.
    void border_side(SlotGrid& grid, const Site& site, std::int32_t x, std::int32_t y, std::uint32_t drawn) {
        const bool side_x = site.kind == PlaneKind::side_x;
        const std::uint32_t v = grid(x, y), west = grid(x - 1, y), east = grid(x + 1, y), north = grid(x, y - 1),
                            south = grid(x, y + 1);
        const MeshTriangle quadrants[4] = {{v, north, west}, {v, east, north}, {v, west, south}, {v, south, east}};
        for (std::uint32_t d = 0; d < 4; ++d) {
            const Site apex = parent_site(site, static_cast<int>(side_x ? d >> 1 : d & 1));
            if ((drawn >> d & 1) != 0 && exists(s, apex)) triangle(tile_of(apex), quadrants[d], d);
        }
        flatten(v, x, y, side_x ? west : north, side_x ? east : south);
    }

    [[nodiscard]] std::uint32_t tile_of(const Site& centre) const {
        const std::int32_t log2 = s.steps[centre.z].log2;
        return static_cast<std::uint32_t>((centre.j >> log2) * s.tiles_x + (centre.i >> log2));
    }

    // x, y: in the grid of the page in work.
    void flatten(std::uint32_t v, std::int32_t x, std::int32_t y, std::uint32_t a, std::uint32_t b) {
        if (s.morph_now.morph == Morph::none) return;
        const Coord at{(corner_.x + x) << z_, (corner_.y + y) << z_};
        s.morph[v].flat_m = flat_height(s, v, at, z_, (x & y & 1) != 0, a, b);
    }

    CutState& s;
    std::uint32_t tile_ = 0;
    std::uint32_t next_ = 0, end_ = 0; // slots of the tile's last chunk
    int z_ = 0;
    Coord corner_; // of the page in work, in its steps
};

} // namespace

bool build_all(CutState& s) {
    for (int z = s.terrain->tree.tile_log2 - 1; z >= 0; --z) {
        build_centres(s, z);
        build_sides(s, z);
        if (s.short_of != 0) return false;
    }
    // Every active vertex has split a triangle into two, twice unless it lies on the rim.
    const std::uint32_t most = 2 * s.terrain->tile_count() + 2 * (s.budget.vertices - free_vertices(s) - corner_slots(s));
    const std::uint32_t chunks = (most >> s.chunk_log2) + s.terrain->tile_count() + 4;
    if (chunks > s.chunk_count) {
        s.short_of |= cut_budget_triangles;
        return false;
    }
    Emitter emitter(s);
    for (std::uint32_t tile = 0; tile < s.terrain->tile_count(); ++tile) emitter.tile(tile);
    return true;
}

} // namespace fjell
