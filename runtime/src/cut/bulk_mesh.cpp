// The bulk pass' triangles: page by page on the way down, when it is known which vertices are active.

#include <algorithm>
#include <bit>

#include "cut/bulk_install.h"
#include "cut/bulk_rows.h"
#include "cut/state.h"
#include "shared/compiler.h"

namespace fjell {

namespace {

// Triangles of one page after the other.
class Emitter {
public:
    Emitter(Pages& pages, BulkPass& bulk, Mesh& mesh, bool morphs, std::uint32_t worker = 0)
        : pages_(pages), b(bulk), mesh_(mesh), down_(b.descents[worker]), slots_(mesh, bulk), morphs_(morphs) {}

    // The next page; false: all tiles are done.
    bool step() {
        while (down_.depth != 0 || b.at != mesh_.tile_count) {
            if (down_.depth != 0 ? next() : begin(b.at++)) return true;
        }
        return false;
    }
    // All of a tile.
    void tile(std::uint32_t number) {
        (void)begin(number);
        while (down_.depth != 0) (void)next();
    }

private:
    // The tile's first page. False: it has none.
    bool begin(std::uint32_t number) {
        down_.tile = number;
        return begin_tile();
    }
    // What comes after it. False: nothing does here.
    bool next() {
        const BulkPlace& place = down_.places[down_.depth - 1];
        if (place.rows != 1u << pages_.grid.steps[z_now()].page_log2) {
            resume();
            return true;
        }
        if (place.quarter != quarters()) return descend();
        --down_.depth;
        return false;
    }

    // z of the place on top: the root's is the coarsest.
    [[nodiscard]] int z_now() const { return pages_.grid.terrain->tree.tile_log2 - static_cast<int>(down_.depth); }
    // Pages of the next step under one of this.
    [[nodiscard]] std::uint32_t quarters() const {
        const int z = z_now();
        return z == 0 ? 0 : pages_.grid.steps[z - 1].log2 > page_squares_log2 ? 4 : 1;
    }

    // The tile's last segment, written without going through its list.
    void open() {
        const BulkTile& list = b.tiles[down_.tile];
        out_ = {mesh_.indices, mesh_.triangle_of, 0, 0};
        if (list.last_segment == no_index) return;
        out_.next = (list.last_segment << mesh_.segment_log2) + list.in_last;
        if (list.reserved != no_index)
            out_.end = (list.last_segment + 1) << mesh_.segment_log2; // or each one is looked at
    }
    void close() {
        TileStack& list = b.tiles[down_.tile];
        if (list.last_segment == no_index) return;
        const std::uint32_t in_last = out_.next - (list.last_segment << mesh_.segment_log2);
        if (b.beside)
            mesh_.dirty_triangles.mark_range((list.last_segment << mesh_.segment_log2) + list.in_last, out_.next);
        list.total += in_last - list.in_last;
        list.in_last = in_last;
    }
    std::uint32_t take(const MeshTriangle& t) {
        BulkTile& own = b.tiles[down_.tile];
        const std::uint32_t list = own.reserved != no_index ? down_.tile : list_for(mesh_, down_.tile, t);
        if (own.reserved != no_index && needs_segment(mesh_, own))
            push_segment(mesh_, own, down_.tile, mesh_.free_segments[--own.reserved]);
        const std::uint32_t slot = take_triangle(mesh_, b.tiles[list], list);
        if (b.beside) mesh_.dirty_triangles.mark(slot);
        return slot;
    }
    void triangle(const MeshTriangle& t, std::uint32_t direction) {
        close();
        put_triangle(mesh_, take(t), t, t.right * 4 + direction);
        open();
    }
    // One of a tile that has no others. Its key is the drawn mesh's until this one is.
    std::uint32_t base_triangle(const MeshTriangle& t) {
        const std::uint32_t slot = take(t);
        put_corners(mesh_, slot, t);
        return slot;
    }

    bool begin_tile() {
        const SampleIndex tile = pages_.grid.terrain->tile_xy(down_.tile);
        const int z = pages_.grid.terrain->tree.tile_log2 - 1;
        SlotGrid& grid = down_.grids[z];
        const auto corner = [&](std::int32_t x, std::int32_t y) {
            return pages_.grid.terrain->corner_at(tile.column + x, tile.row + y);
        };
        for (std::int32_t y = 0; y < 2; ++y)
            for (std::int32_t x = 0; x < 2; ++x) grid.corner[y][x] = corner(x, y);
        const BulkSquares root = squares_at(pages_, z, tile.column, tile.row);
        const BulkPage* const found = found_in(b, root.slot);
        std::uint32_t(&base)[2] = b.bases[down_.tile];
        base[0] = base[1] = no_index;
        if (found == nullptr || found->active[root.row(VertexKind::centre, 0)] == 0) {
            const MeshTriangle halves[2] = {{corner(1, 0), corner(0, 0), corner(1, 1)},
                                            {corner(0, 1), corner(1, 1), corner(0, 0)}};
            for (std::size_t n = 0; n < 2; ++n) base[n] = base_triangle(halves[n]);
            return false;
        }
        page(root);
        return true;
    }

    // The next quarter of the place on top, when it has anything.
    bool descend() {
        BulkPlace& place = down_.places[down_.depth - 1];
        const int z = z_now();
        const std::int32_t finer = 1 << pages_.grid.steps[z - 1].page_log2, half = finer / 2;
        const auto quarter = static_cast<std::int32_t>(place.quarter++);
        const std::int32_t qx = quarter % 2 * half, qy = quarter / 2 * half;
        FJELL_ASSERT(qx < 1 << pages_.grid.steps[z].page_log2 && qy < 1 << pages_.grid.steps[z].page_log2);
        const BulkSquares at = squares_at(pages_, z - 1, 2 * (place.i0 + qx), 2 * (place.j0 + qy));
        const BulkPage* const found = found_in(b, at.slot);
        if (found == nullptr) return false;
        const auto rows = static_cast<std::uint32_t>(
            rows_in_use(found->active + at.row(VertexKind::centre, 0), static_cast<std::uint32_t>(finer)));
        if (rows == 0) return false;
        hand_down(down_.grids[z], down_.grids[z - 1], static_cast<std::uint32_t>(qx), static_cast<std::uint32_t>(qy),
                  static_cast<std::uint32_t>(half), rows);
        page(at);
        return true;
    }

    // A page with active centres, whose grid has the corners of its squares.
    void page(const BulkSquares& at) {
        down_.places[down_.depth++] = {at.i0, at.j0, 0, 0};
        gather(at);
        scatter();
        // Where nothing that is drawn stays, its state may be written at once, from the same masks.
        if (!b.beside && at.n == static_cast<std::int32_t>(page_squares)) write_step(pages_, b, mesh_, at, masks_);
        rows();
    }
    // More of its rows.
    void resume() {
        const BulkPlace& place = down_.places[down_.depth - 1];
        gather(squares_at(pages_, z_now(), place.i0, place.j0));
        rows();
    }
    void gather(const BulkSquares& at) {
        at_ = at;
        grid_ = &down_.grids[at.z];
        masks_.gather(pages_, b, at);
        masks_.gather_finer(pages_, b, at);
        // A side has an active centre in its row, or the row to the north.
        rows_ = static_cast<std::uint32_t>(rows_in_use(masks_.centre + 1, static_cast<std::uint32_t>(at.n)));
    }
    // A unit of work: a quarter of a full page.
    void rows() {
        BulkPlace& place = down_.places[down_.depth - 1];
        const auto first = static_cast<std::int32_t>(place.rows), end = b.beside ? std::min(first + 8, at_.n) : at_.n;
        place.rows = static_cast<std::uint32_t>(end);
        open();
        std::uint32_t left =
            rows_ & static_cast<std::uint32_t>((std::uint64_t{1} << end) - (std::uint64_t{1} << first));
        if (morphs_) flatten_rows(left);
        const FanPage of{grid_,        masks_.centre + 1, masks_.side_x, masks_.side_y,
                         masks_.finer, masks_.finer_west, at_.all()};
        const std::uint32_t on_border = border_rows(left);
        while (left != 0) {
            // Those up to the next one with a side on the tile's border.
            const std::uint32_t stop = left & on_border, before = stop == 0 ? left : left & ((stop & -stop) - 1);
            left = (left & ~before) | fan_rows(out_, of, before);
            if (left == 0) break;
            row(std::countr_zero(left)); // that one, or one for which the segment has no room
            left &= left - 1;
        }
        if (end == at_.n && south_border() && masks_.side_x[end] != 0) border_sides_x(end);
        close();
    }
    [[nodiscard]] bool is_border(std::int32_t square) const { return (square & ((1 << at_.step->log2) - 1)) == 0; }
    [[nodiscard]] bool south_border() const { return is_border(at_.j0 + at_.n); }
    // Of some rows those with a side on the border of the tile, but for the one south of all.
    [[nodiscard]] std::uint32_t border_rows(std::uint32_t rows) const {
        const std::uint64_t west = is_border(at_.i0) ? 1 : 0,
                            east = is_border(at_.i0 + at_.n) ? std::uint64_t{1} << at_.n : 0;
        std::uint32_t on_border = is_border(at_.j0) && masks_.side_x[0] != 0 ? 1 : 0;
        for (std::uint32_t left = (west | east) != 0 ? rows : 0; left != 0; left &= left - 1)
            if ((masks_.side_y[std::countr_zero(left)] & (west | east)) != 0) on_border |= left & -left;
        return on_border;
    }
    // One row, in whatever room there is.
    void row(std::int32_t j) {
        centre_row(j);
        if (masks_.side_x[j] != 0 && is_border(at_.j0 + j))
            border_sides_x(j);
        else if (masks_.side_x[j] != 0)
            side_x_row(j);
        auto own = static_cast<std::uint32_t>(masks_.side_y[j]) & at_.all();
        if (is_border(at_.i0) && (own & 1) != 0) {
            border_side(VertexKind::side_y, 0, j, drawn_y(j, 0));
            own &= ~1u;
        }
        if (own != 0) side_y_row(j, own);
        if (is_border(at_.i0 + at_.n) && (masks_.side_y[j] >> at_.n & 1) != 0)
            border_side(VertexKind::side_y, at_.n, j, drawn_y(j, at_.n));
    }

    // --- slots

    [[nodiscard]] std::uint32_t slot_in(const BulkPage& page, std::uint32_t row, std::uint32_t lane) const {
        const std::uint32_t before = page.active[row] & ((1u << lane) - 1);
        return slots_[page.number + page.first[row] + static_cast<std::uint32_t>(std::popcount(before))];
    }
    void scatter() {
        const BulkPage& own = *masks_.own;
        SlotGrid& g = *grid_;
        const std::int32_t n = at_.n;
        const auto count = static_cast<std::uint32_t>(n);
        put_slots(slots_, {&own, at_.row(VertexKind::centre, 0), count}, g.centre[1] + 1, std::size(g.centre[0]));
        put_slots(slots_, {&own, at_.row(VertexKind::side_x, 0), count}, g.side_x[0], std::size(g.side_x[0]));
        put_slots(slots_, {&own, at_.row(VertexKind::side_y, 0), count}, g.side_y[0], std::size(g.side_y[0]));
        for (std::uint32_t left = rows_; left != 0; left &= left - 1) {
            const std::int32_t j = std::countr_zero(left);
            if ((masks_.side_y[j] & 1) != 0 && masks_.west != nullptr)
                g.centre[j + 1][0] = slot_in(*masks_.west, at_.row(VertexKind::centre, j), count - 1);
            if ((masks_.side_y[j] >> n & 1) != 0)
                g.side_y[j][n] = masks_.owns_east ? slot_in(own, at_.column(), static_cast<std::uint32_t>(j))
                                                  : slot_in(*masks_.east, at_.row(VertexKind::side_y, j), 0);
        }
        if (masks_.north != nullptr && masks_.side_x[0] != 0)
            put_slots(slots_, {masks_.north, at_.row(VertexKind::centre, n - 1), 1}, g.centre[0] + 1, 0);
        if (masks_.side_x[n] != 0) {
            const BulkPage& of = masks_.owns_south ? own : *masks_.south;
            put_slots(slots_, {&of, at_.row(VertexKind::side_x, masks_.owns_south ? n : 0), 1}, g.side_x[n], 0);
        }
    }

    // --- triangles

    // As many as the segment has room for four at a time; then one by one, into the next.
    void fan_row(const CentreRow& row, std::uint32_t active) {
        for (;;) {
            active = fan_centres(out_, row, active);
            if (active == 0) return;
            const auto i = static_cast<std::size_t>(std::countr_zero(active));
            const std::uint32_t v = row.slots[i], nw = row.norths[i], ne = row.norths[i + 1], sw = row.souths[i],
                                se = row.souths[i + 1];
            fan({{v, nw, sw}, {v, se, ne}, {v, ne, nw}, {v, sw, se}},
                (static_cast<std::uint32_t>(row.sides_y >> i) & 3) | (row.north >> i & 1) << 2 |
                    (row.south >> i & 1) << 3);
            active &= active - 1;
        }
    }
    void fan_row(const SideRow& row, std::uint32_t active) {
        for (;;) {
            active = fan_sides(out_, row, active);
            if (active == 0) return;
            const auto i = static_cast<std::size_t>(std::countr_zero(active));
            const std::uint32_t v = row.slots[i], west = row.ends[i], east = row.ends[i + 1], north = row.norths[i],
                                south = row.souths[i];
            fan({{v, north, west}, {v, east, north}, {v, west, south}, {v, south, east}},
                static_cast<std::uint32_t>((row.up >> 2 * i & 3) | (row.down >> 2 * i & 3) << 2));
            active &= active - 1;
        }
    }
    // The triangles around a vertex, by direction.
    FJELL_NOINLINE void fan(const MeshTriangle (&triangles)[4], std::uint32_t drawn) {
        std::fill_n(mesh_.triangle_of + std::size_t{triangles[0].right} * 4, 4, no_index);
        for (std::uint32_t d = 0; d < 4; ++d)
            if (drawn >> d & 1) triangle(triangles[d], d);
    }

    void centre_row(std::int32_t j) {
        const SlotGrid& g = *grid_;
        const std::uint32_t* const up = g.corner[j];
        const std::uint32_t* const down = g.corner[j + 1];
        const std::uint32_t* const slots = g.centre[j + 1] + 1;
        fan_row(CentreRow{slots, up, down, ~masks_.side_y[j], ~masks_.side_x[j], ~masks_.side_x[j + 1]},
                masks_.centre[j + 1]);
    }

    [[nodiscard]] std::uint32_t drawn_x(std::int32_t j, std::int32_t i) const {
        const std::uint64_t up = masks_.finer_row(2 * j - 1), down = masks_.finer_row(2 * j);
        return ~static_cast<std::uint32_t>((up >> 2 * i & 3) | (down >> 2 * i & 3) << 2) & 15;
    }
    // The columns 2i - 1 and 2i.
    [[nodiscard]] std::uint32_t drawn_y(std::int32_t j, std::int32_t i) const {
        const auto two = [&](std::int32_t row) {
            const std::uint64_t of = masks_.finer_row(row);
            const std::uint64_t at_it = i == static_cast<std::int32_t>(page_squares) ? 0 : of >> 2 * i & 1;
            return (i == 0 ? masks_.finer_west[row] : of >> (2 * i - 1) & 1) | at_it << 1;
        };
        return ~static_cast<std::uint32_t>(two(2 * j) | two(2 * j + 1) << 2) & 15;
    }

    void border_sides_x(std::int32_t j) {
        for (std::uint32_t left = masks_.side_x[j]; left != 0; left &= left - 1)
            border_side(VertexKind::side_x, std::countr_zero(left), j, drawn_x(j, std::countr_zero(left)));
    }
    void side_x_row(std::int32_t j) {
        const SlotGrid& g = *grid_;
        const std::uint64_t up = ~masks_.finer_row(2 * j - 1), down = ~masks_.finer_row(2 * j);
        fan_row(SideRow{g.side_x[j], g.corner[j], g.centre[j] + 1, g.centre[j + 1] + 1, up, down}, masks_.side_x[j]);
    }
    void side_y_row(std::int32_t j, std::uint32_t active) {
        const SlotGrid& g = *grid_;
        // Moved by a column, so that a side's own two come together.
        const auto columns = [&](std::int32_t row) { return ~(masks_.finer_row(row) << 1 | masks_.finer_west[row]); };
        const std::uint64_t up = columns(2 * j), down = columns(2 * j + 1);
        fan_row(SideRow{g.side_y[j], g.centre[j + 1], g.corner[j], g.corner[j + 1], up, down}, active);
    }

    // A side between two tiles, or on the terrain's rim: each triangle belongs to the tile of its apex, and is made
    // with that.
    void border_side(VertexKind kind, std::int32_t i, std::int32_t j, std::uint32_t drawn) {
        const SlotGrid& g = *grid_;
        const bool side_x = kind == VertexKind::side_x;
        const std::uint32_t v = side_x ? g.side_x[j][i] : g.side_y[j][i], nw = g.corner[j][i];
        const std::uint32_t west = side_x ? nw : g.centre[j + 1][i], north = side_x ? g.centre[j][i + 1] : nw;
        const std::uint32_t east = side_x ? g.corner[j][i + 1] : i == at_.n ? no_index : g.centre[j + 1][i + 1];
        const std::uint32_t south = !side_x ? g.corner[j + 1][i] : j == at_.n ? no_index : g.centre[j + 1][i + 1];
        const MeshTriangle quadrants[4] = {{v, north, west}, {v, east, north}, {v, west, south}, {v, south, east}};
        const Site site{at_.z, kind, at_.i0 + i, at_.j0 + j};
        const bool own = side_x ? j != at_.n || masks_.owns_south : i != at_.n || masks_.owns_east;
        for (std::uint32_t d = 0; d < 4; ++d) {
            const Site apex = parent_site(site, static_cast<int>(side_x ? d >> 1 : d & 1));
            const bool beyond = !exists(pages_.grid, apex);
            if (beyond ? !own : tile_of(apex) != down_.tile) continue;
            mesh_.triangle_of[std::size_t{v} * 4 + d] = no_index;
            if (!beyond && (drawn >> d & 1) != 0) triangle(quadrants[d], d);
        }
        if (morphs_ && own) flatten(v, kind, i, j, side_x ? west : north, side_x ? east : south);
    }

    [[nodiscard]] std::uint32_t tile_of(const Site& centre) const {
        const std::int32_t log2 = pages_.grid.steps[centre.z].log2;
        return pages_.grid.terrain->tile_at(centre.i >> log2, centre.j >> log2);
    }

    // Where vertices of some rows start when they morph: in the middle of the edges that they split. Those on the
    // tile's border have it from border_side().
    void flatten_rows(std::uint32_t rows) {
        const SlotGrid& g = *grid_;
        for (; rows != 0; rows &= rows - 1) {
            const std::int32_t j = std::countr_zero(rows);
            // Squares alternate which diagonal a centre splits (parent_bearing).
            const std::int32_t parity = at_.z == pages_.grid.terrain->tree.tile_log2 - 1 ? 0 : at_.i0 + at_.j0 + j;
            for (std::uint32_t left = masks_.centre[j + 1]; left != 0; left &= left - 1) {
                const std::int32_t i = std::countr_zero(left), falling = (parity + i) % 2 == 0;
                flatten(g.centre[j + 1][i + 1], VertexKind::centre, i, j, g.corner[j][i + 1 - falling],
                        g.corner[j + 1][i + falling]);
            }
            for (std::uint32_t left = is_border(at_.j0 + j) ? 0 : masks_.side_x[j]; left != 0; left &= left - 1) {
                const std::int32_t i = std::countr_zero(left);
                flatten(g.side_x[j][i], VertexKind::side_x, i, j, g.corner[j][i], g.corner[j][i + 1]);
            }
            const std::uint32_t own = at_.all() & (is_border(at_.i0) ? ~1u : ~0u);
            for (std::uint32_t left = static_cast<std::uint32_t>(masks_.side_y[j]) & own; left != 0; left &= left - 1) {
                const std::int32_t i = std::countr_zero(left);
                flatten(g.side_y[j][i], VertexKind::side_y, i, j, g.corner[j][i], g.corner[j + 1][i]);
            }
        }
    }
    void flatten(std::uint32_t v, VertexKind kind, std::int32_t i, std::int32_t j, std::uint32_t a, std::uint32_t c) {
        const SampleIndex at = site_coord({at_.z, kind, at_.i0 + i, at_.j0 + j});
        mesh_.morph[v].morph_from_m = flat_height(pages_.grid, mesh_, v, at, at_.z, kind == VertexKind::centre, a, c);
        if (b.beside) mesh_.dirty_vertices.mark(v); // it may have been placed in an earlier frame
    }

    Pages& pages_;
    BulkPass& b;
    Mesh& mesh_;
    BulkDescent& down_;
    const BulkSlots slots_;
    const bool morphs_;
    FanOut out_{};
    BulkSquares at_{}; // the page in work
    SlotGrid* grid_ = nullptr;
    BulkMasks masks_;
    std::uint32_t rows_ = 0; // of squares with active centres
};

} // namespace

bool has_segments(const BulkPass& bulk, const Mesh& mesh) {
    // Every active vertex has split a triangle into two, twice unless it lies on the rim.
    const std::uint32_t most = 2 * mesh.tile_count + 2 * bulk.taken;
    // Every tile's last segment may be nearly empty, and that of what is not drawn; two stay back for deactivations. No
    // more, or the smallest budget that is taken could never be filled.
    const std::uint32_t segments = (most >> mesh.segment_log2) + mesh.tile_count + (mesh.some_hidden ? 1 : 0) + 2;
    return segments <= (bulk.beside ? mesh.free_segment_count : mesh.segment_count);
}

namespace {

// May some of its triangles be hidden? Those are not counted before.
bool may_hide(const Grid& grid, std::uint32_t tile) {
    const TerrainData& t = *grid.terrain;
    const SampleIndex place = t.tile_xy(tile);
    return t.has_voids() || (t.tree.cut_x != 0 && place.column + 1 == grid.tiles_x) ||
           (t.tree.cut_y != 0 && place.row + 1 == grid.tiles_y);
}

} // namespace

// Each tile gets its segments, so that no order in which tiles are done can change who has which.
void begin_triangles(const Grid& grid, BulkPass& bulk, Mesh& mesh) {
    if (!bulk.beside) free_all_segments(mesh);
    const std::uint32_t a_segment = 1u << mesh.segment_log2;
    for (std::uint32_t i = 0; i <= mesh.tile_count; ++i) {
        BulkTile& tile = bulk.tiles[i];
        const bool hides = i == mesh.tile_count || may_hide(grid, i);
        tile = {{no_index, 0, 0, 0}, tile.planned, hides ? no_index : mesh.free_segment_count, tile.root};
        if (!hides) mesh.free_segment_count -= (tile.planned + a_segment - 1) >> mesh.segment_log2;
    }
    note_segments(mesh);
    bulk.at = bulk.descents[0].depth = 0;
}

void build_tiles(Pages& pages, BulkPass& bulk, Mesh& mesh, bool morphs, const Frame& frame) {
    run_jobs(bulk, frame, mesh.tile_count, [&](std::uint32_t tile, std::uint32_t worker) {
        if (bulk.tiles[tile].reserved != no_index) Emitter(pages, bulk, mesh, morphs, worker).tile(tile);
    });
    for (std::uint32_t tile = 0; tile < mesh.tile_count; ++tile)
        if (bulk.tiles[tile].reserved == no_index) Emitter(pages, bulk, mesh, morphs).tile(tile);
}

bool step_triangles(Pages& pages, BulkPass& bulk, Mesh& mesh, bool morphs) {
    return Emitter(pages, bulk, mesh, morphs).step();
}

} // namespace fjell
