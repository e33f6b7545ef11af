// Vertices of a terrain by their places in the tree, for code that changes them: the frame's thread only.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "pack/memory.h"
#include "pack/publish.h"
#include "shared/stamp.h"
#include "shared/terrain_data.h"

namespace fjell::edit {

// Height scale steps from low to high.
struct StepRange {
    std::int32_t low = INT32_MAX, high = INT32_MIN;
    [[nodiscard]] bool empty() const { return high < low; }
    [[nodiscard]] std::int32_t span() const { return empty() ? 0 : high - low; }
    void add(std::int32_t steps) { low = std::min(low, steps), high = std::max(high, steps); }
    void add(const StepRange& r) { low = std::min(low, r.low), high = std::max(high, r.high); }
};

// All places of vertices, those beyond the terrain's rim among them.
[[nodiscard]] inline Rect grid_of(const Tree& tree) {
    return {0, 0, tree.grid_columns() - 1, tree.grid_rows() - 1};
}
// Where vertices stand at one of these samples: those beyond the rim stand at the last ones.
[[nodiscard]] inline Rect places_of(const Tree& tree, Rect samples) {
    if (samples.x1 >= tree.columns() - 1) samples.x1 = tree.grid_columns() - 1;
    if (samples.y1 >= tree.rows() - 1) samples.y1 = tree.grid_rows() - 1;
    return samples;
}

// One plane of one step: squares i by j, counted over the terrain.
struct Plane {
    int z;
    VertexKind kind;
    [[nodiscard]] SampleIndex at(std::int32_t i, std::int32_t j) const {
        return {((2 * i) << z) + (kind == VertexKind::side_y ? 0 : 1 << z),
                ((2 * j) << z) + (kind == VertexKind::side_x ? 0 : 1 << z)};
    }
    // Squares of all its vertices.
    [[nodiscard]] Rect all(const Tree& tree) const {
        const int log2 = tree.tile_log2 - 1 - z;
        return {0, 0, (tree.tiles_x << log2) - (kind == VertexKind::side_y ? 0 : 1),
                (tree.tiles_y << log2) - (kind == VertexKind::side_x ? 0 : 1)};
    }
    // Where the vertices of squares lie.
    [[nodiscard]] Rect places(const Rect& squares) const {
        if (squares.empty()) return {};
        const SampleIndex first = at(squares.x0, squares.y0), last = at(squares.x1, squares.y1);
        return {first.column, first.row, last.column, last.row};
    }
    // Squares of those that lie in a rectangle of places.
    [[nodiscard]] Rect squares(const Rect& r) const {
        const auto first = [&](std::int32_t at, bool odd) { // the least i with 2 i s (+ s) >= at
            const std::int32_t from = odd ? at - (1 << z) : at;
            return (from + (2 << z) - 1) >> (z + 1);
        };
        const auto last = [&](std::int32_t at, bool odd) { return (odd ? at - (1 << z) : at) >> (z + 1); };
        const bool odd_x = kind != VertexKind::side_y, odd_y = kind != VertexKind::side_x;
        return {first(r.x0, odd_x), first(r.y0, odd_y), last(r.x1, odd_x), last(r.y1, odd_y)};
    }
};
inline constexpr VertexKind sides_then_centres[3] = {VertexKind::side_x, VertexKind::side_y, VertexKind::centre};

// f(plane) for all planes of steps 2^first to 2^last, children before their parents.
template <typename F>
void for_each_plane(int first, int last, const F& f) {
    for (int z = first; z <= last; ++z)
        for (const VertexKind kind : sides_then_centres) f(Plane{z, kind});
}
// Up the tree from what changes, from step 2^first to 2^last: changed = visit(plane, squares) of all planes, children
// before their parents. squares: own(plane), and the parents of what has changed; some may lie beyond the terrain.
template <typename Own, typename Visit>
void go_up(int first, int last, const Own& own, const Visit& visit) {
    Rect finer; // centres of the step before that have changed
    for (int z = first; z <= last; ++z) {
        const Plane side_x{z, VertexKind::side_x}, side_y{z, VertexKind::side_y}, centre{z, VertexKind::centre};
        const Rect at = finer.empty() ? Rect{} : Rect{finer.x0 >> 1, finer.y0 >> 1, finer.x1 >> 1, finer.y1 >> 1};
        const Rect along_x = finer.empty() ? at : Rect{at.x0, at.y0, at.x1, (finer.y1 + 1) >> 1},
                   along_y = finer.empty() ? at : Rect{at.x0, at.y0, (finer.x1 + 1) >> 1, at.y1};
        const Rect x = visit(side_x, own(side_x).with(along_x)), y = visit(side_y, own(side_y).with(along_y));
        Rect todo = own(centre);
        if (!x.empty()) todo = todo.with({x.x0, x.y0 - 1, x.x1, x.y1});
        if (!y.empty()) todo = todo.with({y.x0 - 1, y.y0, y.x1, y.y1});
        finer = visit(centre, todo);
    }
}
// f(place, number) for the corners of tiles in a rectangle of places.
template <typename F>
void for_each_corner(const TerrainData& t, const Rect& places, const F& f) {
    const int log2 = t.tree.tile_log2;
    const Rect r = places.within(grid_of(t.tree));
    for (std::int32_t y = (r.y0 + t.tree.side() - 1) >> log2; y << log2 <= r.y1; ++y)
        for (std::int32_t x = (r.x0 + t.tree.side() - 1) >> log2; x << log2 <= r.x1; ++x)
            f(SampleIndex{x << log2, y << log2}, t.corner_at(x, y));
}
// How far, in steps, a vertex' error depends on heights: its diamond's reach, and that of its children.
[[nodiscard]] constexpr std::int32_t error_reach(VertexKind kind) {
    return kind == VertexKind::centre ? 3 : 2;
}
// Squares of vertices whose errors may have changed with the ground in these places.
[[nodiscard]] inline Rect around(const Tree& tree, const Plane& plane, const Rect& places) {
    return plane.squares(places.grown(error_reach(plane.kind) << plane.z)).within(plane.all(tree));
}

// Where vertices of one row lie: `count` records from `index` on in a page of the table; in planar order only is it
// more than one.
struct Run {
    std::uint32_t page, index;
    std::int32_t i, j, count;
};

// Calls f(Run) for all of `squares` of a plane, once for each page that holds a vertex: borders are in several.
template <typename F>
void for_each_run(const TerrainData& t, const Plane& plane, Rect squares, const F& f) {
    const int log2 = t.tree.tile_log2 - 1 - plane.z; // of the squares a side of a tile
    const std::int32_t n = 1 << log2;
    squares = squares.within(plane.all(t.tree));
    if (squares.empty()) return;
    // Closed along the axis on whose lines the vertices lie.
    const std::int32_t more_i = plane.kind == VertexKind::side_y ? 1 : 0,
                       more_j = plane.kind == VertexKind::side_x ? 1 : 0;
    const auto first_of = [](std::int32_t at, std::int32_t size, std::int32_t more) {
        return (at - more) / size - ((at - more) < 0);
    };
    for (std::int32_t ty = std::max(first_of(squares.y0, n, more_j), 0);
         ty <= std::min(squares.y1 >> log2, t.tree.tiles_y - 1); ++ty)
        for (std::int32_t tx = std::max(first_of(squares.x0, n, more_i), 0);
             tx <= std::min(squares.x1 >> log2, t.tree.tiles_x - 1); ++tx) {
            const Rect in_tile{std::max(squares.x0 - (tx << log2), 0), std::max(squares.y0 - (ty << log2), 0),
                               std::min(squares.x1 - (tx << log2), n - 1 + more_i),
                               std::min(squares.y1 - (ty << log2), n - 1 + more_j)};
            if (in_tile.empty()) continue;
            const std::uint32_t tile_page = t.tile_at(tx, ty) * t.pages_per_tile;
            if (t.pages.order == PageOrder::linear) {
                for (std::int32_t j = in_tile.y0; j <= in_tile.y1; ++j)
                    for (std::int32_t i = in_tile.x0; i <= in_tile.x1; ++i) {
                        const SampleIndex v = plane.at(i, j);
                        const PagePlace at = t.pages.place_as<PageOrder::linear>(static_cast<std::uint32_t>(v.column),
                                                                                 static_cast<std::uint32_t>(v.row));
                        f(Run{tile_page + at.page, at.index, (tx << log2) + i, (ty << log2) + j, 1});
                    }
                continue;
            }
            const StepLayout step = t.pages.step_layout(plane.z);
            const auto side = static_cast<std::int32_t>(step.page_side), pages = 1 << step.pages_log2;
            for (std::int32_t py = std::max(first_of(in_tile.y0, side, more_j), 0);
                 py <= std::min(in_tile.y1 / side, pages - 1); ++py)
                for (std::int32_t px = std::max(first_of(in_tile.x0, side, more_i), 0);
                     px <= std::min(in_tile.x1 / side, pages - 1); ++px) {
                    const Rect in_page{std::max(in_tile.x0 - px * side, 0), std::max(in_tile.y0 - py * side, 0),
                                       std::min(in_tile.x1 - px * side, side - 1 + more_i),
                                       std::min(in_tile.y1 - py * side, side - 1 + more_j)};
                    if (in_page.empty()) continue;
                    const std::uint32_t page =
                        tile_page + (step.pages_log2 == 0 && step.page_side != page_squares
                                         ? 0
                                         : t.pages.page_at(plane.z, static_cast<std::uint32_t>(px),
                                                           static_cast<std::uint32_t>(py)));
                    const std::int32_t i0 = (tx << log2) + px * side, j0 = (ty << log2) + py * side;
                    for (std::int32_t j = in_page.y0; j <= in_page.y1; ++j) {
                        const auto index = [&](std::int32_t i) {
                            const auto pi = static_cast<std::uint32_t>(i), pj = static_cast<std::uint32_t>(j);
                            return step.offset +
                                   (t.pages.order == PageOrder::planar
                                        ? page_index<PageOrder::planar>(step.page_side, plane.kind, pi, pj)
                                        : page_index<PageOrder::hierarchical_z>(step.page_side, plane.kind, pi, pj));
                        };
                        if (t.pages.order == PageOrder::planar) {
                            f(Run{page, index(in_page.x0), i0 + in_page.x0, j0 + j, in_page.columns()});
                        } else {
                            for (std::int32_t i = in_page.x0; i <= in_page.x1; ++i)
                                f(Run{page, index(i), i0 + i, j0 + j, 1});
                        }
                    }
                }
        }
}

// f(page) for the pages of the table that hold vertices of these squares; some more than once.
template <typename F>
void for_each_page(const TerrainData& t, const Plane& plane, const Rect& squares, const F& f) {
    std::uint32_t last = no_index;
    for_each_run(t, plane, squares, [&](const Run& run) {
        if (run.page == last) return;
        last = run.page;
        f(run.page);
    });
}

// One vertex that is no corner of a tile; null: its page is not loaded.
struct Found {
    const VertexRecord* record = nullptr;
    std::int32_t base = 0;
};
[[nodiscard]] inline Found find_record(const TerrainData& t, SampleIndex v) {
    const std::int32_t l = t.tree.tile_log2, tx = std::min(v.column >> l, t.tree.tiles_x - 1),
                       ty = std::min(v.row >> l, t.tree.tiles_y - 1);
    const PagePlace at =
        t.pages.place(static_cast<std::uint32_t>(v.column - (tx << l)), static_cast<std::uint32_t>(v.row - (ty << l)));
    const PageEntry entry = t.page_table[std::size_t{t.tile_at(tx, ty)} * t.pages_per_tile + at.page];
    if (entry.slot == no_index) return {};
    return {t.records + std::size_t{entry.slot} * t.page_capacity + at.index, entry.base};
}

// What is known of a place. A tile's corner has neither error nor radius.
struct Cell {
    std::int32_t steps = 0; // on the height scale
    std::uint8_t error = 0, radius = 0;
    bool hole = false, loaded = false;
};
static_assert(sizeof(Cell) == 8 && offsetof(Cell, error) == 4 && offsetof(Cell, radius) == 5 &&
                  offsetof(Cell, hole) == 6 && offsetof(Cell, loaded) == 7,
              "cell_of() puts a cell together as one word");
// In one word, because a window is read of some ten thousand.
[[nodiscard]] inline Cell cell_of(std::int32_t base, VertexRecord record) {
    const auto bits = bits_as<std::uint32_t>(record);
    const std::uint32_t steps = static_cast<std::uint32_t>(base) + (bits & 0xffff),
                        codes = (bits >> 16 & 0x7fff) | bits >> 31 << 16 | 1u << 24;
    return bits_as<Cell>(std::uint64_t{codes} << 32 | steps);
}
[[nodiscard]] inline Cell cell_at(const TerrainData& t, SampleIndex v) {
    if (t.tree.is_corner(v)) {
        const std::uint32_t stored = t.corners[t.corner_at(v.column >> t.tree.tile_log2, v.row >> t.tree.tile_log2)];
        return {corner_steps(stored), 0, 0, (stored & corner_void_bit) != 0, true};
    }
    const Found found = find_record(t, v);
    return found.record == nullptr ? Cell{} : cell_of(found.base, *found.record);
}

// change(record) of one vertex, in all pages that hold it.
template <typename Change>
void change_record(const TerrainData& t, const Plane& plane, std::int32_t i, std::int32_t j, const Change& change) {
    for_each_run(t, plane, {i, j, i, j}, [&](const Run& run) {
        const std::uint32_t slot = t.page_table[run.page].slot;
        if (slot == no_index) return;
        VertexRecord* const to = t.memory->records + std::size_t{slot} * t.page_capacity + run.index;
        VertexRecord record = *to;
        change(record);
        write_record(to, bits_as<std::uint32_t>(record));
    });
}

// Levels of the tree below a vertex.
[[nodiscard]] inline std::uint32_t levels_below(SampleIndex v) {
    return 2u * static_cast<std::uint32_t>(Tree::step_log2(v)) + (Tree::kind(v) == VertexKind::centre ? 1u : 0u);
}

} // namespace fjell::edit
