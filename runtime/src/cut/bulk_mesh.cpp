#include "cut/bulk_mesh.h"

#include <bit>
#include <cstring>

#include "cut/bulk_masks.h"
#include "cut/mesh.h"
#include "cut/morph.h"

namespace fjell {

namespace {

// Triangles of one page after the other.
class Emitter {
public:
    explicit Emitter(CutState& state) : s(state), b(state.bulk) {}

    // The next page; false: all tiles are done.
    bool step() {
        while (b.depth != 0 || b.at != s.terrain->tile_count()) {
            if (b.depth == 0) {
                tile_ = b.at++;
                if (begin_tile()) return true;
                continue;
            }
            const BulkPlace& place = b.places[b.depth - 1];
            tile_ = b.at - 1;
            if (place.quarter == quarters()) {
                --b.depth;
                continue;
            }
            if (descend()) return true;
        }
        return false;
    }

private:
    // z of the place on top: the root's is the coarsest.
    [[nodiscard]] int z_now() const { return s.terrain->tree.tile_log2 - static_cast<int>(b.depth); }
    // Pages of the next step under one of this.
    [[nodiscard]] std::uint32_t quarters() const {
        const int z = z_now();
        return z == 0 ? 0 : s.steps[z - 1].log2 > page_squares_log2 ? 4 : 1;
    }

    // The tile's last segment, written without going through its list.
    void open() {
        const TileStack& list = b.tiles[tile_];
        next_ = end_ = 0;
        if (list.last_segment == no_index) return;
        next_ = (list.last_segment << s.segment_log2) + list.in_last;
        end_ = (list.last_segment + 1) << s.segment_log2;
    }
    void close() {
        TileStack& list = b.tiles[tile_];
        if (list.last_segment == no_index) return;
        const std::uint32_t in_last = next_ - (list.last_segment << s.segment_log2);
        if (b.beside) s.dirty_triangles.mark_range((list.last_segment << s.segment_log2) + list.in_last, next_);
        list.total += in_last - list.in_last;
        list.in_last = in_last;
    }
    std::uint32_t triangle(std::uint32_t tile, const MeshTriangle& t, std::uint32_t direction, bool named = true) {
        const std::uint32_t list = list_for(s, tile, t);
        if (list == tile_) close();
        const std::uint32_t slot = take_triangle(s, b.tiles[list], list), key = t.right * 4 + direction;
        const std::uint32_t before = s.triangle_of[key];
        write_triangle(s, slot, t, key);
        if (!named) s.triangle_of[key] = before;
        if (list == tile_) open();
        return slot;
    }

    bool begin_tile() {
        const auto tx = static_cast<std::int32_t>(tile_) % s.tiles_x, ty = static_cast<std::int32_t>(tile_) / s.tiles_x;
        const int z = s.terrain->tree.tile_log2 - 1;
        SlotGrid& grid = b.grids[z];
        const auto corner = [&](std::int32_t x, std::int32_t y) {
            return static_cast<std::uint32_t>((ty + y) * (s.tiles_x + 1) + tx + x);
        };
        for (std::int32_t y = 0; y < 2; ++y)
            for (std::int32_t x = 0; x < 2; ++x) grid.corner[y][x] = corner(x, y);
        const BulkSquares root = squares_at(s, z, tx, ty);
        const BulkPage* const found = found_in(s, root.slot);
        std::uint32_t(&base)[2] = b.bases[tile_];
        base[0] = base[1] = no_index;
        if (found == nullptr || found->active[root.row(VertexKind::centre, 0)] == 0) {
            open();
            // Their keys are the drawn mesh's until this one is.
            base[0] = triangle(tile_, {corner(1, 0), corner(0, 0), corner(1, 1)}, 2, false);
            base[1] = triangle(tile_, {corner(0, 1), corner(1, 1), corner(0, 0)}, 1, false);
            close();
            return false;
        }
        page(root);
        return true;
    }

    // The next quarter of the place on top, when it has anything.
    bool descend() {
        BulkPlace& place = b.places[b.depth - 1];
        const int z = z_now();
        const std::int32_t n = 1 << s.steps[z].page_log2, finer = 1 << s.steps[z - 1].page_log2, half = finer / 2;
        const auto quarter = static_cast<std::int32_t>(place.quarter++);
        const std::int32_t qx = quarter % 2 * half, qy = quarter / 2 * half; // n != half: four of them
        FJELL_ASSERT(qx < n && qy < n);
        const BulkSquares at = squares_at(s, z - 1, 2 * (place.i0 + qx), 2 * (place.j0 + qy));
        const BulkPage* const found = found_in(s, at.slot);
        if (found == nullptr) return false;
        std::uint32_t any = 0;
        for (std::int32_t j = 0; j < finer; ++j) any |= found->active[at.row(VertexKind::centre, j)];
        if (any == 0) return false;
        hand_down(b.grids[z], b.grids[z - 1], static_cast<std::uint32_t>(qx), static_cast<std::uint32_t>(qy),
                  static_cast<std::uint32_t>(half));
        page(at);
        return true;
    }

    // What stands around and in the squares from (qx, qy) on are the corners of the finer ones.
    static void hand_down(const SlotGrid& from, SlotGrid& to, std::uint32_t qx, std::uint32_t qy, std::uint32_t half) {
        const auto interleave_rows = [half](const std::uint32_t* even, const std::uint32_t* odd, std::uint32_t* out) {
            for (std::uint32_t i = 0; i < half; ++i) out[2 * i] = even[i], out[2 * i + 1] = odd[i];
            out[2 * half] = even[half];
        };
        for (std::uint32_t j = 0; j <= half; ++j) {
            interleave_rows(from.corner[qy + j] + qx, from.side_x[qy + j] + qx, to.corner[2 * j]);
            if (j != half)
                interleave_rows(from.side_y[qy + j] + qx, from.centre[qy + j + 1] + qx + 1, to.corner[2 * j + 1]);
        }
    }

    // A page with active centres, whose grid has the corners of its squares.
    void page(const BulkSquares& at) {
        at_ = at;
        grid_ = &b.grids[at.z];
        b.places[b.depth++] = {at.i0, at.j0, 0};
        masks_.gather(s, at);
        if (masks_.any_side) masks_.gather_finer(s, at);
        scatter();
        open();
        const std::int32_t tile_side = (1 << at.step->log2) - 1;
        const bool west_border = (at.i0 & tile_side) == 0;
        for (std::int32_t j = 0; j < at.n; ++j) {
            centre_row(j);
            const bool north_border = ((at.j0 + j) & tile_side) == 0;
            if (masks_.side_x[j] != 0) side_x_row(j, north_border);
            if (const std::uint32_t own = static_cast<std::uint32_t>(masks_.side_y[j]) & at.all(); own != 0)
                side_y_row(j, own, west_border);
        }
        if (masks_.owns_south && masks_.side_x[at.n] != 0) side_x_row(at.n, true);
        if (masks_.owns_east)
            for (std::int32_t j = 0; j < at.n; ++j)
                if (masks_.side_y[j] >> at.n & 1) border_side(VertexKind::side_y, at.n, j, drawn_y(j, at.n));
        close();
    }

    // --- slots

    void put_slots(std::uint32_t* to, std::uint32_t active, std::uint32_t first) const {
        for (; active != 0; active &= active - 1) to[std::countr_zero(active)] = bulk_slot(s, first++);
    }
    [[nodiscard]] std::uint32_t slot_in(const BulkPage& page, std::uint32_t row, std::uint32_t lane) const {
        const std::uint32_t before = page.active[row] & ((1u << lane) - 1);
        return bulk_slot(s, page.first[row] + static_cast<std::uint32_t>(std::popcount(before)));
    }
    void scatter() {
        const BulkPage& own = *masks_.own;
        SlotGrid& g = *grid_;
        const std::int32_t n = at_.n;
        for (std::int32_t j = 0; j < n; ++j) {
            const std::uint32_t c = at_.row(VertexKind::centre, j), x = at_.row(VertexKind::side_x, j),
                                y = at_.row(VertexKind::side_y, j);
            put_slots(g.centre[j + 1] + 1, own.active[c], own.first[c]);
            put_slots(g.side_x[j], own.active[x], own.first[x]);
            put_slots(g.side_y[j], own.active[y], own.first[y]);
            if ((masks_.side_y[j] & 1) != 0 && masks_.west != nullptr)
                g.centre[j + 1][0] = slot_in(*masks_.west, c, static_cast<std::uint32_t>(n) - 1);
            if ((masks_.side_y[j] >> n & 1) != 0)
                g.side_y[j][n] = masks_.owns_east ? slot_in(own, at_.column(), static_cast<std::uint32_t>(j))
                                                  : slot_in(*masks_.east, y, 0);
        }
        if (masks_.north != nullptr && masks_.side_x[0] != 0) {
            const std::uint32_t row = at_.row(VertexKind::centre, n - 1);
            put_slots(g.centre[0] + 1, masks_.north->active[row], masks_.north->first[row]);
        }
        if (masks_.side_x[n] != 0) {
            const BulkPage& of = masks_.owns_south ? own : *masks_.south;
            const std::uint32_t row = at_.row(VertexKind::side_x, masks_.owns_south ? n : 0);
            put_slots(g.side_x[n], of.active[row], of.first[row]);
        }
    }

    // --- triangles

    // The triangles around a vertex: direction d lies between corners[d][0] and corners[d][1].
    void fan(std::uint32_t v, const std::uint32_t (&corners)[4][2], std::uint32_t drawn) {
        if (s.some_hidden || next_ + 4 > end_) {
            std::memset(s.triangle_of + std::size_t{v} * 4, 0xff, 16);
            for (std::uint32_t d = 0; d < 4; ++d)
                if (drawn >> d & 1) triangle(tile_, {v, corners[d][0], corners[d][1]}, d);
            return;
        }
        // All four are written, the next over one that is not drawn: no branch can be mispredicted.
        std::uint32_t* t = s.indices + std::size_t{next_} * 3;
        std::uint32_t keys[4];
        for (std::uint32_t d = 0; d < 4; ++d) {
            const std::uint32_t is_drawn = drawn >> d & 1;
            t[0] = v, t[1] = corners[d][0], t[2] = corners[d][1];
            s.key_of[next_] = v * 4 + d;
            keys[d] = next_ | (is_drawn - 1); // no_index when not
            next_ += is_drawn;
            t += 3 * is_drawn;
        }
        std::memcpy(s.triangle_of + std::size_t{v} * 4, keys, sizeof keys);
    }

    void centre_row(std::int32_t j) {
        const std::uint32_t active = masks_.centre[j + 1];
        if (active == 0) return;
        const SlotGrid& g = *grid_;
        const std::uint32_t* const up = g.corner[j];
        const std::uint32_t* const down = g.corner[j + 1];
        const std::uint64_t west = ~masks_.side_y[j], east = west >> 1;
        const std::uint32_t north = ~masks_.side_x[j], south = ~masks_.side_x[j + 1];
        for (std::uint32_t left = active; left != 0; left &= left - 1) {
            const auto i = static_cast<std::uint32_t>(std::countr_zero(left));
            const std::uint32_t nw = up[i], ne = up[i + 1], sw = down[i], se = down[i + 1], v = g.centre[j + 1][i + 1];
            const std::uint32_t drawn = static_cast<std::uint32_t>(west >> i & 1) |
                                        static_cast<std::uint32_t>(east >> i & 1) << 1 | (north >> i & 1) << 2 |
                                        (south >> i & 1) << 3;
            fan(v, {{nw, sw}, {se, ne}, {ne, nw}, {sw, se}}, drawn);
            // Squares alternate which diagonal a centre splits (parent_bearing).
            const std::int32_t square =
                at_.z == s.terrain->tree.tile_log2 - 1 ? 0 : at_.i0 + static_cast<std::int32_t>(i) + at_.j0 + j;
            const bool falling = square % 2 == 0;
            flatten(v, VertexKind::centre, static_cast<std::int32_t>(i), j, falling ? nw : ne, falling ? se : sw);
        }
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
            return (i == 0 ? masks_.finer_west_of(row) : of >> (2 * i - 1) & 1) | at_it << 1;
        };
        return ~static_cast<std::uint32_t>(two(2 * j) | two(2 * j + 1) << 2) & 15;
    }

    void side_x_row(std::int32_t j, bool border) {
        const SlotGrid& g = *grid_;
        for (std::uint32_t left = masks_.side_x[j]; left != 0; left &= left - 1) {
            const auto i = std::countr_zero(left);
            const std::uint32_t drawn = drawn_x(j, i);
            if (border) {
                border_side(VertexKind::side_x, i, j, drawn);
                continue;
            }
            const std::uint32_t v = g.side_x[j][i], west = g.corner[j][i], east = g.corner[j][i + 1],
                                north = g.centre[j][i + 1], south = g.centre[j + 1][i + 1];
            fan(v, {{north, west}, {east, north}, {west, south}, {south, east}}, drawn);
            flatten(v, VertexKind::side_x, i, j, west, east);
        }
    }
    void side_y_row(std::int32_t j, std::uint32_t active, bool border) {
        const SlotGrid& g = *grid_;
        for (std::uint32_t left = active; left != 0; left &= left - 1) {
            const auto i = std::countr_zero(left);
            const std::uint32_t drawn = drawn_y(j, i);
            if (border && i == 0) {
                border_side(VertexKind::side_y, i, j, drawn);
                continue;
            }
            const std::uint32_t v = g.side_y[j][i], west = g.centre[j + 1][i], east = g.centre[j + 1][i + 1],
                                north = g.corner[j][i], south = g.corner[j + 1][i];
            fan(v, {{north, west}, {east, north}, {west, south}, {south, east}}, drawn);
            flatten(v, VertexKind::side_y, i, j, north, south);
        }
    }

    // A side between two tiles, or on the terrain's rim: each triangle belongs to the tile of its apex.
    void border_side(VertexKind kind, std::int32_t i, std::int32_t j, std::uint32_t drawn) {
        const SlotGrid& g = *grid_;
        const bool side_x = kind == VertexKind::side_x;
        const std::uint32_t v = side_x ? g.side_x[j][i] : g.side_y[j][i], nw = g.corner[j][i];
        const std::uint32_t west = side_x ? nw : g.centre[j + 1][i], north = side_x ? g.centre[j][i + 1] : nw;
        const std::uint32_t east = side_x ? g.corner[j][i + 1] : i == at_.n ? no_index : g.centre[j + 1][i + 1];
        const std::uint32_t south = !side_x ? g.corner[j + 1][i] : j == at_.n ? no_index : g.centre[j + 1][i + 1];
        const MeshTriangle quadrants[4] = {{v, north, west}, {v, east, north}, {v, west, south}, {v, south, east}};
        std::memset(s.triangle_of + std::size_t{v} * 4, 0xff, 16);
        const Site site{at_.z, kind, at_.i0 + i, at_.j0 + j};
        for (std::uint32_t d = 0; d < 4; ++d) {
            const Site apex = parent_site(site, static_cast<int>(side_x ? d >> 1 : d & 1));
            if ((drawn >> d & 1) != 0 && exists(s, apex)) triangle(tile_of(apex), quadrants[d], d);
        }
        flatten(v, kind, i, j, side_x ? west : north, side_x ? east : south);
    }

    [[nodiscard]] std::uint32_t tile_of(const Site& centre) const {
        const std::int32_t log2 = s.steps[centre.z].log2;
        return static_cast<std::uint32_t>((centre.j >> log2) * s.tiles_x + (centre.i >> log2));
    }

    void flatten(std::uint32_t v, VertexKind kind, std::int32_t i, std::int32_t j, std::uint32_t a, std::uint32_t c) {
        if (s.morph_now.morph == Morph::none) return;
        const Coord at = site_coord({at_.z, kind, at_.i0 + i, at_.j0 + j});
        s.morph[v].flat_m = flat_height(s, v, at, at_.z, kind == VertexKind::centre, a, c);
    }

    CutState& s;
    BulkPass& b;
    std::uint32_t tile_ = 0;
    std::uint32_t next_ = 0, end_ = 0; // slots of the tile's last segment
    BulkSquares at_{};                 // the page in work
    SlotGrid* grid_ = nullptr;
    BulkMasks masks_;
};

} // namespace

bool begin_triangles(CutState& s) {
    // Every active vertex has split a triangle into two, twice unless it lies on the rim.
    const std::uint32_t most = 2 * s.terrain->tile_count() + 2 * s.bulk.taken;
    // Every tile's last segment may be nearly empty, and that of what is not drawn; two stay back for deactivations. No
    // more, or the smallest budget that is taken could never be filled.
    const std::uint32_t segments = (most >> s.segment_log2) + s.terrain->tile_count() + (s.some_hidden ? 1 : 0) + 2;
    if (segments > (s.bulk.beside ? s.free_segment_count : s.segment_count)) return false;
    if (!s.bulk.beside) free_all_segments(s);
    for (std::uint32_t i = 0; i <= s.terrain->tile_count(); ++i) s.bulk.tiles[i] = {no_index, 0, 0, 0};
    s.bulk.at = s.bulk.depth = 0;
    return true;
}

bool step_triangles(CutState& s) {
    Emitter emitter(s);
    return emitter.step();
}

} // namespace fjell
