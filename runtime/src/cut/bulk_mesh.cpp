// The bulk pass' triangles: page by page on the way down, when it is known which vertices are active.
#include <bit>

#include "cut/bulk.h"
#include "cut/mesh.h"
#include "cut/morph.h"

namespace fjell {

namespace {

// Slots of the vertices in and around one page, by their place on the grid of its step: x, y from -1 to 2n.
// Only those of active vertices mean anything.
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
        const auto tx = static_cast<std::int32_t>(number) % s.tiles_x,
                   ty = static_cast<std::int32_t>(number) / s.tiles_x;
        const int z = s.terrain->tree.tile_log2 - 1;
        tile_ = number;
        open();
        SlotGrid& grid = grid_of(z);
        for (std::int32_t y = 0; y < 2; ++y)
            for (std::int32_t x = 0; x < 2; ++x)
                grid(2 * x, 2 * y) = static_cast<std::uint32_t>((ty + y) * (s.tiles_x + 1) + tx + x);
        if (find_vertex(s, {z, VertexKind::centre, tx, ty}) == no_index || !page(z, tx, ty)) base(grid);
        close();
    }

private:
    SlotGrid& grid_of(int z) { return reinterpret_cast<SlotGrid*>(s.bulk_grids)[z]; }

    // The tile's last segment, written without going through its list.
    void open() {
        const TileList& list = s.tiles[tile_];
        next_ = end_ = 0;
        if (list.last_segment == no_index) return;
        next_ = (list.last_segment << s.segment_log2) + list.in_last;
        end_ = (list.last_segment + 1) << s.segment_log2;
    }
    void close() {
        TileList& list = s.tiles[tile_];
        if (list.last_segment == no_index) return;
        const std::uint32_t in_last = next_ - (list.last_segment << s.segment_log2);
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
            s.key_of[next_] = v * 4 + d;
            s.triangle_of[v * 4 + d] = next_ | (is_drawn - 1); // no_index when not
            next_ += is_drawn;
        }
    }

    // Slots of a row's active vertices, to every other place of the grid. Answers whether there are any.
    bool scatter_slots(SlotGrid& grid, std::uint32_t group, std::int32_t count, std::int32_t x, std::int32_t y) {
        std::uint32_t any = 0;
        std::uint32_t* to = &grid(x, y);
        for (std::int32_t done = 0; done < count; done += group_lanes, ++group, to += 2 * group_lanes) {
            if (s.groups[group].active == 0) continue;
            any |= s.groups[group].active;
            const std::uint32_t* const from = s.vertex_slot + std::size_t{group} * group_lanes;
            if (count < static_cast<std::int32_t>(group_lanes))
                for (std::int32_t lane = 0; lane < count; ++lane) to[2 * lane] = from[lane];
            else
                for (std::uint32_t lane = 0; lane < group_lanes; ++lane) to[2 * lane] = from[lane];
        }
        return any != 0;
    }
    void scatter_slot(SlotGrid& grid, const Site& site, std::int32_t x, std::int32_t y) {
        if (!exists(s, site)) return;
        const std::uint32_t vertex = find_vertex(s, site);
        if (vertex != no_index) grid(x, y) = s.vertex_slot[vertex];
    }

    // The grid has the corners of the page's squares. False when no centre is active, and so nothing below.
    bool page(int z, std::int32_t i0, std::int32_t j0) {
        SlotGrid& grid = grid_of(z);
        const PageStep groups = page_step_at(s, z, i0, j0);
        const std::int32_t n = groups.n;
        bool any = false, below = false;
        for (std::int32_t j = 0; j < n; ++j)
            any = scatter_slots(grid, groups.row(VertexKind::centre, j), n, 1, 2 * j + 1) || any;
        if (!any) return false;
        for (std::int32_t j = 0; j < n; ++j) {
            below = scatter_slots(grid, groups.row(VertexKind::side_x, j), n, 1, 2 * j) || below;
            below = scatter_slots(grid, groups.row(VertexKind::side_y, j), n, 0, 2 * j + 1) || below;
        }
        below = borders(grid, z, i0, j0, n) || below;
        rows(grid, z, i0, j0, groups);
        if (below && z > 0) descend(grid, z, i0, j0, n);
        return true;
    }

    // What lies around the page and belongs to its neighbours: apexes to the north and west, sides to the south and
    // east.
    bool borders(SlotGrid& grid, int z, std::int32_t i0, std::int32_t j0, std::int32_t n) {
        const Site north{z, VertexKind::centre, i0, j0 - 1}, south{z, VertexKind::side_x, i0, j0 + n};
        if (exists(s, north))
            if (const std::uint32_t v = find_vertex(s, north); v != no_index)
                (void)scatter_slots(grid, v / group_lanes, n, 1, -1);
        bool below = false;
        if (const std::uint32_t v = find_vertex(s, south); v != no_index)
            below = scatter_slots(grid, v / group_lanes, n, 1, 2 * n);
        for (std::int32_t j = 0; j < n; ++j) {
            scatter_slot(grid, {z, VertexKind::centre, i0 - 1, j0 + j}, -1, 2 * j + 1);
            const std::uint32_t v = find_vertex(s, {z, VertexKind::side_y, i0 + n, j0 + j});
            if (v == no_index || !(s.groups[v / group_lanes].active & bit_of(v))) continue;
            grid(2 * n, 2 * j + 1) = s.vertex_slot[v];
            below = true;
        }
        return below;
    }

    void rows(SlotGrid& grid, int z, std::int32_t i0, std::int32_t j0, const PageStep& groups) {
        z_ = z;
        corner_ = {2 * i0, 2 * j0};
        const std::int32_t n = groups.n, tile_side = (1 << groups.step->log2) - 1;
        for (std::int32_t j = 0; j < n; ++j) {
            centre_row(grid, groups.row(VertexKind::centre, j), n, 2 * j + 1);
            const bool north_border = ((j0 + j) & tile_side) == 0;
            side_row(grid, {z, VertexKind::side_x, i0, j0 + j}, groups.row(VertexKind::side_x, j), n, 2 * j,
                     north_border);
            side_row(grid, {z, VertexKind::side_y, i0, j0 + j}, groups.row(VertexKind::side_y, j), n, 2 * j + 1,
                     (i0 & tile_side) == 0);
        }
        if (j0 + n == s.tiles_y << groups.step->log2)
            side_row(grid, {z, VertexKind::side_x, i0, j0 + n}, groups.row(VertexKind::side_x, n), n, 2 * n, true);
        if (i0 + n == s.tiles_x << groups.step->log2)
            for (std::int32_t j = 0; j < n; ++j) {
                const Site site{z, VertexKind::side_y, i0 + n, j0 + j};
                const std::uint32_t v = find_vertex(s, site);
                const GroupState& b = s.groups[v / group_lanes];
                if (b.active & bit_of(v)) border_side(grid, site, 2 * n, 2 * j + 1, drawn_by(b, v % group_lanes));
            }
    }

    [[nodiscard]] static std::uint32_t drawn_by(const GroupState& b, std::uint32_t lane) {
        std::uint32_t drawn = 0;
        for (std::uint32_t d = 0; d < 4; ++d) drawn |= (~static_cast<std::uint32_t>(b.child[d]) >> lane & 1u) << d;
        return drawn;
    }

    void descend(SlotGrid& grid, int z, std::int32_t i0, std::int32_t j0, std::int32_t n) {
        const std::int32_t finer = 1 << s.steps[z - 1].page_log2; // squares of a page there: 2n, or n in four pages
        for (std::int32_t qy = 0; qy < 2 * n; qy += finer)
            for (std::int32_t qx = 0; qx < 2 * n; qx += finer) {
                if (active_in_page_of(s, {z - 1, VertexKind::centre, 2 * i0 + qx, 2 * j0 + qy}) == 0) continue;
                SlotGrid& to = grid_of(z - 1);
                for (std::int32_t y = 0; y <= finer; ++y) {
                    const std::uint32_t* const from = &grid(qx, qy + y);
                    std::uint32_t* const row = &to(0, 2 * y);
                    for (std::int32_t x = 0; x <= finer; ++x) row[2 * x] = from[x];
                }
                (void)page(z - 1, 2 * i0 + qx, 2 * j0 + qy);
            }
    }

    void centre_row(SlotGrid& grid, std::uint32_t group, std::int32_t count, std::int32_t y) {
        for (std::int32_t x0 = 1; x0 < 2 * count; x0 += 2 * static_cast<std::int32_t>(group_lanes), ++group) {
            const GroupState& b = s.groups[group];
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

    void side_row(SlotGrid& grid, const Site& first, std::uint32_t group, std::int32_t count, std::int32_t y,
                  bool border) {
        const bool side_x = first.kind == VertexKind::side_x;
        for (std::int32_t along = 0; along < count; along += static_cast<std::int32_t>(group_lanes), ++group) {
            const GroupState& b = s.groups[group];
            for (std::uint32_t active = b.active; active != 0; active &= active - 1) {
                const auto lane = static_cast<std::uint32_t>(std::countr_zero(active));
                const std::int32_t i = along + static_cast<std::int32_t>(lane), x = 2 * i + (side_x ? 1 : 0);
                if (border && (side_x || i == 0)) {
                    border_side(grid, {first.z, first.kind, first.i + i, first.j}, x, y, drawn_by(b, lane));
                    continue;
                }
                const std::uint32_t v = grid(x, y), west = grid(x - 1, y), east = grid(x + 1, y),
                                    north = grid(x, y - 1), south = grid(x, y + 1);
                fan(v, {{north, west}, {east, north}, {west, south}, {south, east}}, drawn_by(b, lane));
                flatten(v, x, y, side_x ? west : north, side_x ? east : south);
            }
        }
    }

    // A side between two tiles, or on the terrain's rim: each triangle belongs to the tile of its apex.
    void border_side(SlotGrid& grid, const Site& site, std::int32_t x, std::int32_t y, std::uint32_t drawn) {
        const bool side_x = site.kind == VertexKind::side_x;
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
    std::uint32_t next_ = 0, end_ = 0; // slots of the tile's last segment
    int z_ = 0;
    Coord corner_; // of the page in work, in its steps
};

} // namespace

void emit_triangles(CutState& s) {
    Emitter emitter(s);
    for (std::uint32_t tile = 0; tile < s.terrain->tile_count(); ++tile) emitter.tile(tile);
}

} // namespace fjell
