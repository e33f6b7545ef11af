#include "cut/bulk.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "cut/evaluate.h"
#include "cut/refine.h"
#include "cut/state.h"
#include "shared/compiler.h"

namespace fjell {

BulkPage& visit_page(Pages& pages, Work& work, BulkPass& bulk, const Visibility& visibility, std::uint32_t slot) {
    BulkPage& page = bulk.pages[slot];
    if (page.build == bulk.build) return page;
    const PageState& info = pages.state[slot];
    page.build = bulk.build;
    page.wanted = 0;
    page.grades = 0;
    page.has_groups = false;
    page.parents = 0;
    std::fill_n(page.active, bulk_rows, 0);
    std::fill_n(page.ticks, page_ticks, unscheduled);
    bulk.visited[bulk.visited_count++] = slot;
    if (info.shape == 0) { // its root has been decided
        const BulkRoot& root = bulk.tiles[info.tile].root;
        page.ticks[0] = root.ticks;
        page.grades = root.grades;
    } else if (bulk.beside) {
        watch_visited_page(pages, work, visibility, slot);
    }
    return page;
}

namespace {

// Steps of which a page 0 has several: of it all are decided before its vertices are placed.
bool is_coarse(const Grid& grid, int z) {
    return grid.steps[z].page_log2 < page_squares_log2;
}

// Of the pages whose vertices are placed: of coarse steps all that were visited, since those are pages 0.
std::uint32_t placed_page(const Grid& grid, const BulkPass& bulk, std::uint32_t n) {
    return is_coarse(grid, bulk.z) ? bulk.visited[n] : bulk.listed[1][n];
}

// Pages under one with active centres.
std::uint32_t quarters_of(const Grid& grid, int z) {
    return grid.steps[z].log2 > page_squares_log2 ? 4 : 1; // a tile has one page otherwise
}

// The page that squares lie in has a state then. False: it is not loaded, or there is none to be had.
bool attach_squares(CutState& s, BulkSquares& at) {
    if (at.slot != no_index) return true;
    const std::uint32_t page = place_of(s.pages.grid, {at.z, VertexKind::centre, at.i0, at.j0}).page;
    if (!attach_page(s.pages, s.work, s.mesh, s.visibility, page)) s.bulk.no_pages = true;
    if (s.pages.page_groups[page] == no_index) return false;
    at.slot = s.pages.page_groups[page] / max_page_groups;
    return true;
}

void visit_at(CutState& s, int z, std::int32_t i, std::int32_t j) {
    BulkSquares squares = squares_at(s.pages, z, i, j);
    if (attach_squares(s, squares)) (void)visit_page(s.pages, s.work, s.bulk, s.visibility, squares.slot);
}

// The next page whose centres are to be decided: those under pages with active centres. No other can have an active
// parent.
bool next_squares(const Pages& pages, const BulkPass& b, BulkSquares& squares) {
    const std::uint32_t quarters = quarters_of(pages.grid, b.z);
    if (b.at == b.end) return false;
    const BulkSquares above = listed_squares(pages, b.listed[0][b.at / quarters], b.z + 1);
    const auto quarter = static_cast<std::int32_t>(b.at % quarters);
    squares = squares_at(pages, b.z, 2 * above.i0 + quarter % 2 * above.n, 2 * above.j0 + quarter / 2 * above.n);
    return true;
}

// The page's centres that are ready, in its masks. False: none is, or the page is being evicted. Where that takes
// frames it may be kept after all before its state is whole, and nobody would look at it again: there they wait.
bool find_ready(CutState& s, BulkSquares& at) {
    std::uint32_t parents[2][page_squares];
    if (!centre_parents(s.pages, s.bulk, at, parents) || !attach_squares(s, at)) return false;
    BulkPage& page = visit_page(s.pages, s.work, s.bulk, s.visibility, at.slot);
    if (!s.bulk.beside && s.pages.state[at.slot].status == PageStatus::evicting) return false;
    std::uint32_t* const ready = page.active + at.row(VertexKind::centre, 0);
    std::uint32_t any = 0;
    for (std::int32_t j = 0; j < at.n; ++j) any |= ready[j] = parents[0][j] & parents[1][j];
    return any != 0;
}

// Sides that lie in the next pages have a parent here, and those pages have to know. Which rim sides exist is known.
void visit_neighbours(CutState& s, const BulkSquares& at) {
    const std::uint32_t* const centres = s.bulk.pages[at.slot].active + at.row(VertexKind::centre, 0);
    std::uint32_t east = 0;
    for (std::int32_t j = 0; j < at.n; ++j) east |= centres[j] >> (at.n - 1) & 1;
    if (centres[at.n - 1] != 0 && !ends_south(s.pages.grid, at)) visit_at(s, at.z, at.i0, at.j0 + at.n);
    if (east != 0 && !ends_east(s.pages.grid, at)) visit_at(s, at.z, at.i0 + at.n, at.j0);
}

// Where time counts, a full page is done in parts, so that a unit of work stays small.
constexpr std::uint32_t page_units = 4;
std::uint32_t units_of(const BulkPass& bulk, bool full) {
    return bulk.beside && full ? page_units : 1;
}
BulkUnit unit_of(const BulkPass& bulk, std::uint32_t slot, int z, std::int32_t rows, std::uint32_t units) {
    const std::int32_t a_unit = (rows + static_cast<std::int32_t>(units) - 1) / static_cast<std::int32_t>(units),
                       first = static_cast<std::int32_t>(bulk.part) * a_unit;
    BulkUnit unit{};
    unit.slot = slot;
    unit.z = z;
    unit.rows = {first, std::min(first + a_unit, rows)};
    unit.last = bulk.part + 1 == units;
    return unit;
}

// The next unit is as it says; after a page's last one comes the next page.
void advance(BulkPass& b, const BulkUnit& unit) {
    b.part = unit.last ? 0 : b.part + 1;
    b.at += unit.last;
}

bool next_centres(CutState& s, BulkUnit& unit) {
    BulkPass& b = s.bulk;
    BulkSquares at;
    if (!next_squares(s.pages, s.bulk, at)) return false;
    if (b.part == 0 && !find_ready(s, at)) {
        unit = {};
        unit.slot = no_index;
        unit.last = true;
    } else {
        unit = unit_of(s.bulk, at.slot, b.z, at.n, units_of(s.bulk, at.n == page_squares));
        const PageState& page = s.pages.state[at.slot];
        // Asked once a page: a view may move between its parts, and what is decided stays.
        unit.waits = b.beside && b.part == 0 &&
                     (page.status == PageStatus::evicting || (page.shape != 0 && !may_be_seen(s.pages, s.views, page)));
        if (unit.waits) unit.rows = {0, at.n}, unit.last = true;
    }
    advance(b, unit);
    return true;
}

bool next_sides(CutState& s, BulkUnit& unit) {
    BulkPass& b = s.bulk;
    if (b.at == b.end) return false;
    const BulkSquares at = listed_squares(s.pages, b.listed[1][b.at], b.z);
    if (b.part == 0) visit_neighbours(s, at);
    unit = unit_of(s.bulk, at.slot, b.z, at.n, units_of(s.bulk, at.n == page_squares));
    advance(b, unit);
    return true;
}

bool next_vertices(const Pages& pages, BulkPass& b, BulkUnit& unit) {
    if (b.at == b.end) return false;
    const std::uint32_t slot = placed_page(pages.grid, b, b.at), shape = pages.state[slot].shape;
    const std::uint32_t rows =
        shape == 0 ? pages.grid.shapes[0].count : pages.grid.shapes[1].count / 2; // rows of two groups
    unit = unit_of(b, slot, 0, static_cast<std::int32_t>(rows), units_of(b, shape != 0));
    advance(b, unit);
    return true;
}

bool next_unit(CutState& s, BulkUnit& unit) {
    switch (s.bulk.phase) {
    case BulkPhase::centres: return next_centres(s, unit);
    case BulkPhase::sides: return next_sides(s, unit);
    default: return next_vertices(s.pages, s.bulk, unit);
    }
}

bool has_centres(const BulkPass& bulk, const BulkSquares& at) {
    const std::uint32_t* const centres = bulk.pages[at.slot].active + at.row(VertexKind::centre, 0);
    return std::any_of(centres, centres + at.n, [](std::uint32_t row) { return row != 0; });
}

// What a unit has found, put together: in the order of units.
void merge(const Pages& pages, BulkPass& b, Mesh& mesh, Frame& frame, const BulkUnit& unit) {
    if (unit.slot == no_index) return;
    BulkPage& page = b.pages[unit.slot];
    if (b.phase == BulkPhase::vertices) {
        const PageState& info = pages.state[unit.slot];
        b.tiles[info.tile].planned += unit.own;
        const auto add = [&](std::int32_t x, std::int32_t y, std::uint32_t more) {
            if (x < 0 || y < 0 || more == 0) return;
            if (const std::uint32_t tile = pages.grid.terrain->tile_at(x, y); tile != no_index)
                b.tiles[tile].planned += more;
        };
        add(info.tile_x - 1, info.tile_y, unit.west);
        add(info.tile_x, info.tile_y - 1, unit.north);
        if (!b.beside) return; // all slots are written
        charge_work(b, frame, unit.wanted * parts_a_placed_vertex);
        const BulkSlots slots(mesh, b);
        const std::uint32_t first = page.number + page.first[unit.rows.first];
        for (std::uint32_t n = first; n != first + unit.wanted; ++n) mesh.dirty_vertices.mark(slots[n]);
        return;
    }
    page.wanted = static_cast<std::uint16_t>(page.wanted + unit.wanted);
    page.grades = static_cast<std::uint8_t>(std::max<std::uint32_t>(page.grades, unit.grades));
    b.taken += unit.wanted;
    const std::uint32_t evaluated = unit.waits ? 0 : unit.groups;
    frame.report.evaluations += evaluated;
    charge_work(b, frame, evaluated * parts_a_group);
    if (b.phase == BulkPhase::centres && unit.last && !unit.waits &&
        has_centres(b, listed_squares(pages, unit.slot, unit.z)))
        b.listed[1][b.listed_count[1]++] = unit.slot;
}

// Parents of the centres of 2 x 2 squares under each of half x half coarser ones, whose sides are in rows from `x` and
// `y` on, the first one's at bit i. last: of the row of side_x south of them; east: a bit a row, of the column east of
// their side_y. False: none is active.
template <typename Count>
bool spread_parents(Count half, int i, const std::uint32_t* x, const std::uint32_t* y, std::uint32_t last,
                    const std::uint32_t* east, std::uint32_t (&parents)[2][page_squares]) {
    const std::uint32_t lanes = (1u << half) - 1;
    std::uint32_t xs[page_squares / 2 + 1], any = last >> i & lanes;
    for (std::int32_t j = 0; j < half; ++j) any |= xs[j] = x[j] >> i & lanes;
    xs[half] = last >> i & lanes;
    std::uint32_t ys[page_squares / 2]; // one more than the squares
    for (std::int32_t j = 0; j < half; ++j) any |= ys[j] = (y[j] >> i & lanes) | east[j] << half;
    if (any == 0) return false;
    for (std::int32_t j = 0; j <= half; ++j) xs[j] = doubled(xs[j]);
    for (std::int32_t j = 0; j < half; ++j) ys[j] = spread_bits(ys[j] & lanes) | spread_bits(ys[j] >> 1) << 1;
    for (std::int32_t j = 0; j < half; ++j) {
        parents[0][2 * j] = xs[j];
        parents[0][2 * j + 1] = xs[j + 1];
        parents[1][2 * j] = parents[1][2 * j + 1] = ys[j];
    }
    return true;
}

} // namespace

bool centre_parents(const Pages& pages, const BulkPass& bulk, const BulkSquares& at,
                    std::uint32_t (&parents)[2][page_squares]) {
    if (at.z == pages.grid.terrain->tree.tile_log2 - 1) {
        parents[0][0] = parents[1][0] = 1;
        return true;
    }
    // Their parents are sides of one quarter of a coarser page, or of all of a coarser step of the tile.
    const BulkSquares up = squares_at(pages, at.z + 1, at.i0 >> 1, at.j0 >> 1);
    const BulkPage* const page = found_in(bulk, up.slot);
    if (page == nullptr) return false;
    const std::int32_t half = at.n / 2, i = (at.i0 >> 1) - up.i0, j0 = (at.j0 >> 1) - up.j0;
    const std::uint32_t *const x = page->active + up.row(VertexKind::side_x, j0), *const y =
                                                                                      page->active +
                                                                                      up.row(VertexKind::side_y, j0);
    const bool next_south = j0 + half == up.n && !ends_south(pages.grid, up);
    const std::uint32_t last =
        next_south ? row_bits(found_at(pages, bulk, up.z, up.i0, up.j0 + up.n), up.row(VertexKind::side_x, 0))
                   : x[half];
    std::uint32_t east[page_squares / 2] = {};
    if (i + half != up.n) {
        for (std::int32_t j = 0; j < half; ++j) east[j] = y[j] >> (i + half) & 1;
    } else if (ends_east(pages.grid, up)) {
        for (std::int32_t j = 0; j < half; ++j) east[j] = page->active[up.column()] >> (j0 + j) & 1;
    } else if (const BulkPage* const next = found_at(pages, bulk, up.z, up.i0 + up.n, up.j0); next != nullptr) {
        for (std::int32_t j = 0; j < half; ++j) east[j] = next->active[up.row(VertexKind::side_y, j0 + j)] & 1;
    }
    constexpr std::integral_constant<std::int32_t, page_squares / 2> full; // vectors, where the number is known
    return half == full ? spread_parents(full, i, x, y, last, east, parents)
                        : spread_parents(half, i, x, y, last, east, parents);
}

std::uint32_t unit_limit(const BulkPass& bulk, const Frame& frame) {
    const std::uint32_t workers = worker_count(bulk, frame);
    if (workers == 1) return 1;
    if (!bulk.beside) return most_units;
    // So many that one after the other would all be done too: the number of workers changes nothing.
    constexpr std::uint32_t most_items = max_page_vertices * parts_a_placed_vertex / parts_an_item + 1;
    const std::uint32_t items = frame.item_limit - std::min(frame.report.work, frame.item_limit);
    return std::max(1u, std::min({4 * workers, frame.settings.visits - frame.report.visits, items / most_items}));
}

void charge_work(BulkPass& b, Frame& frame, std::uint32_t parts) {
    b.parts += parts;
    const std::uint32_t left = frame.item_limit - std::min(frame.report.work, frame.item_limit),
                        items = std::min(b.parts / parts_an_item, left);
    frame.report.work += items;
    b.parts -= items * parts_an_item;
}

void begin_bulk(const Pages& pages, BulkPass& b, const Mesh& mesh, bool beside) {
    FJELL_ASSERT(b.phase == BulkPhase::idle);
    if (++b.build == 0) { // as good as never
        for (std::uint32_t slot = 0; slot < pages.count; ++slot) b.pages[slot].build = 0;
        b.build = 1;
    }
    b.beside = beside;
    b.no_pages = false;
    b.taken = b.numbered = b.visited_count = b.listed_count[0] = b.listed_count[1] = b.at = b.part = 0;
    b.next_centres = b.first_listed = 0;
    b.free_before = beside ? mesh.free_vertex_count : 0;
    b.fresh_before = beside ? mesh.fresh_vertex : mesh.corner_count;
    b.z = pages.grid.terrain->tree.tile_log2 - 1;
    b.phase = BulkPhase::roots;
    std::fill_n(b.travelled_m, grade_count, 0.0);
    for (std::uint32_t i = 0; i <= mesh.tile_count; ++i) b.tiles[i].planned = 2;
}

void drop_bulk(Pages& pages, BulkPass& b, Mesh& mesh) {
    FJELL_ASSERT(b.phase < BulkPhase::releasing);
    for (std::uint32_t i = 0; b.phase != BulkPhase::idle && i < b.visited_count; ++i) note_idle(pages, b.visited[i]);
    // Slots that have been written in vain, beyond those that a mesh with fewer vertices will take.
    if (b.phase != BulkPhase::idle && !b.beside)
        mesh.dirty_vertices.mark_range(b.fresh_before, b.fresh_before + b.numbered);
    b.phase = BulkPhase::idle;
}

namespace {

BulkStatus stop(Pages& pages, BulkPass& bulk, Mesh& mesh, BulkStatus status) {
    if (status == BulkStatus::built)
        bulk.phase = BulkPhase::built;
    else
        drop_bulk(pages, bulk, mesh);
    return status;
}

// A page's north and west neighbours come before it in every list, or with it: tiles go row by row, and quarters of
// pages do. So their centres are known when its sides are decided.
void begin_centres(const Grid& grid, BulkPass& b) {
    const std::uint32_t all = quarters_of(grid, b.z) * b.listed_count[0];
    b.at = b.next_centres;
    b.end = b.next_centres = is_coarse(grid, b.z) ? all : std::min(b.at + b.pages_together, all);
    b.first_listed = b.listed_count[1];
    b.phase = BulkPhase::centres;
}
void begin_sides(BulkPass& b) {
    b.at = b.first_listed;
    b.end = b.listed_count[1];
    b.phase = BulkPhase::sides;
}
// They get their numbers.
void begin_vertices(const Grid& grid, BulkPass& b) {
    const bool coarse = is_coarse(grid, b.z);
    b.at = coarse ? 0 : b.first_listed;
    b.end = coarse ? b.visited_count : b.listed_count[1];
    for (std::uint32_t n = b.at; n != b.end; ++n) {
        BulkPage& page = b.pages[placed_page(grid, b, n)];
        page.number = std::exchange(b.numbered, b.numbered + page.wanted);
    }
    FJELL_ASSERT(b.numbered == b.taken);
    b.phase = BulkPhase::vertices;
}

// Those of the next step, under pages with active centres. False: there is none, or nothing in it.
bool begin_finer(const Grid& grid, BulkPass& b) {
    if (b.z == 0 || b.listed_count[1] == 0) return false;
    std::swap(b.listed[0], b.listed[1]);
    b.listed_count[0] = std::exchange(b.listed_count[1], 0u);
    --b.z;
    b.next_centres = 0;
    begin_centres(grid, b);
    return true;
}

// No unit of the phase is left.
BulkStatus next_phase(Pages& pages, BulkPass& b, Mesh& mesh) {
    b.part = 0;
    if (b.phase == BulkPhase::centres) {
        begin_sides(b);
        return BulkStatus::unfinished;
    }
    const bool last = b.z == 0 || b.listed_count[1] == 0;
    if (b.phase == BulkPhase::sides && (!is_coarse(pages.grid, b.z) || last || !is_coarse(pages.grid, b.z - 1))) {
        begin_vertices(pages.grid, b);
        return BulkStatus::unfinished;
    }
    if (b.next_centres != quarters_of(pages.grid, b.z) * b.listed_count[0]) {
        begin_centres(pages.grid, b);
        return BulkStatus::unfinished;
    }
    if (begin_finer(pages.grid, b)) return BulkStatus::unfinished;
    if (!has_segments(b, mesh)) return stop(pages, b, mesh, BulkStatus::no_triangles);
    begin_triangles(pages.grid, b, mesh);
    b.phase = BulkPhase::triangles;
    return BulkStatus::unfinished;
}

// Those that come next. None after one with which a capacity might be spent: it would have been in vain, and leave
// other pages with states than where units are done one by one.
std::uint32_t next_units(CutState& s, BulkUnit (&units)[most_units]) {
    const BulkPass& b = s.bulk;
    const std::uint32_t limit = unit_limit(s.bulk, s.frame), sides_too = b.phase == BulkPhase::sides ? 2 : 1;
    std::uint32_t count = 0, most = 0;
    while (count != limit && !b.no_pages && next_unit(s, units[count])) {
        const BulkUnit& unit = units[count++];
        if (unit.slot == no_index || b.phase == BulkPhase::vertices) continue;
        most += static_cast<std::uint32_t>(unit.rows.end - unit.rows.first + 1) * page_squares * sides_too;
        if (most > bulk_capacity(s.bulk, s.mesh) - b.taken) break;
    }
    return count;
}

BulkStatus step_tiles(Pages& pages, BulkPass& bulk, Mesh& mesh, const Morphing& morphing, Frame& frame) {
    const bool morphs = morphing.now.morph != Morph::none;
    // A step writes triangles of one tile, and to the list of what is not drawn.
    const BulkTile& hidden = bulk.tiles[mesh.tile_count];
    const std::uint32_t tile = bulk.descents[0].tile, before = bulk.tiles[tile].total, hidden_before = hidden.total;
    if (bulk.beside && step_triangles(pages, bulk, mesh, morphs)) {
        const std::uint32_t now = bulk.descents[0].tile,
                            made = bulk.tiles[now].total - (now == tile ? before : 0) + hidden.total - hidden_before;
        charge_work(bulk, frame, made / triangles_a_part);
        return BulkStatus::unfinished;
    }
    if (!bulk.beside) build_tiles(pages, bulk, mesh, morphs, frame);
    return stop(pages, bulk, mesh, BulkStatus::built);
}

} // namespace

BulkStatus step_bulk(CutState& s) {
    BulkPass& b = s.bulk;
    FJELL_ASSERT(b.phase != BulkPhase::idle && b.phase <= BulkPhase::triangles);
    b.units = 1;
    if (b.phase == BulkPhase::triangles) return step_tiles(s.pages, s.bulk, s.mesh, s.morphing, s.frame);
    if (b.phase == BulkPhase::roots) {
        if (!step_roots(s)) begin_sides(s.bulk);
        return b.taken > bulk_capacity(s.bulk, s.mesh) ? stop(s.pages, s.bulk, s.mesh, BulkStatus::no_vertices)
                                                       : BulkStatus::unfinished;
    }
    BulkUnit units[most_units];
    const std::uint32_t count = next_units(s, units);
    if (count == 0) return next_phase(s.pages, s.bulk, s.mesh);
    run_jobs(s.bulk, s.frame, count, [&](std::uint32_t n, std::uint32_t) {
        if (b.phase == BulkPhase::vertices)
            place_unit(s.pages, b, s.mesh, s.views, units[n]);
        else
            decide_unit(s.pages, s.work.schedule, b, s.views, units[n]);
    });
    for (std::uint32_t n = 0; n < count; ++n) merge(s.pages, s.bulk, s.mesh, s.frame, units[n]);
    b.units = count;
    if (b.taken > bulk_capacity(s.bulk, s.mesh)) return stop(s.pages, s.bulk, s.mesh, BulkStatus::no_vertices);
    return b.no_pages ? stop(s.pages, s.bulk, s.mesh, BulkStatus::no_pages) : BulkStatus::unfinished;
}

// --- the roots of all tiles. A large terrain has hundreds, most of which nobody wants: those are decided side by side,
// and of a page 0 that has nothing else the pass writes no more than when to look again.

namespace {

constexpr std::uint32_t tiles_a_step = 64;

// The root's group is the first of page 0; no_index: that has no state.
std::uint32_t root_group(const Pages& pages, std::uint32_t tile) {
    return pages.page_groups[tile * pages.grid.pages_per_tile];
}

bool decide_root(CutState& s, std::uint32_t tile, std::uint32_t group) {
    const std::uint32_t vertex = group * group_lanes, slot = group / max_page_groups;
    // What keeps a vertex that is active lets it stay for longer than this slack says.
    const Evaluation v = evaluate_vertex(s.pages, s.views, vertex, site_of(s.pages, vertex), false);
    const auto ticks_a_metre = static_cast<float>(1 / tick_m(s.work.schedule, s.work.schedule.pages[slot]));
    const auto ticks = static_cast<std::uint16_t>(std::min(v.slack_m * ticks_a_metre, float{most_ticks}));
    s.bulk.tiles[tile].root = {static_cast<std::uint16_t>(soon + ticks),
                               static_cast<std::uint8_t>(grade_of(v.code) + 1)};
    ++s.frame.report.evaluations;
    charge_work(s.bulk, s.frame, parts_a_group);
    return v.wanted;
}

} // namespace

bool step_roots(CutState& s) {
    BulkPass& b = s.bulk;
    const std::uint32_t first = b.at, end = std::min(first + tiles_a_step, s.mesh.tile_count);
    for (std::uint32_t tile = first; tile != end; ++tile)
        if (const std::uint32_t group = root_group(s.pages, tile); group != no_index) {
            FJELL_PREFETCH(records_of(s.pages, group / max_page_groups));
            FJELL_PREFETCH(s.pages.groups + group);
        }
    for (; b.at != end; ++b.at) {
        b.tiles[b.at].root = {unscheduled, 0};
        const std::uint32_t group = root_group(s.pages, b.at), slot = group / max_page_groups;
        if (group == no_index) continue;
        const PageState& page = s.pages.state[slot];
        if (b.beside) watch_visited_page(s.pages, s.work, s.visibility, slot);
        const bool evicting = page.status == PageStatus::evicting, wanted = !evicting && decide_root(s, b.at, group);
        if (evicting && b.beside) b.tiles[b.at].root = {spent, 1}; // it may be kept after all, so it waits
        if (wanted || !is_clear(page)) (void)visit_page(s.pages, s.work, s.bulk, s.visibility, slot);
        if (!wanted) continue;
        BulkPage& found = b.pages[slot];
        found.active[0] = 1;
        ++found.wanted;
        ++b.taken;
        b.listed[1][b.listed_count[1]++] = slot;
    }
    return end != s.mesh.tile_count;
}

bool step_install_roots(Pages& pages, Work& work, BulkPass& b, const Mesh& mesh) {
    const std::uint32_t first = b.at, end = std::min(first + tiles_a_step, mesh.tile_count);
    for (; b.at != end; ++b.at) {
        const std::uint32_t group = root_group(pages, b.at), slot = group / max_page_groups;
        if (group == no_index || found_in(b, slot) != nullptr) continue;
        pages.groups[group].queue = unqueued; // it may have waited
        const BulkRoot& root = b.tiles[b.at].root;
        if (root.grades != 0)
            restart_group(work.schedule, slot, 0, root.ticks, root.grades - 1u, b.travelled_m);
        else
            clear_page_schedule(work.schedule, slot);
    }
    return end != mesh.tile_count;
}

// --- when the pass runs: for a rebuild at once, after a jump of the camera in as many frames as it takes.

void finish_bulk(CutState& s) {
    BulkPass& b = s.bulk;
    while (b.phase == BulkPhase::triangles) (void)step_bulk(s);
    if (b.phase == BulkPhase::built) install_mesh(s);
    while (b.phase >= BulkPhase::releasing && step_install(s)) {
    }
    drop_bulk(s.pages, s.bulk, s.mesh);
}

BulkStatus build_bulk(CutState& s) {
    begin_bulk(s.pages, s.bulk, s.mesh, false);
    BulkStatus status = BulkStatus::unfinished;
    while (status == BulkStatus::unfinished) status = step_bulk(s);
    if (status != BulkStatus::built) return status;
    install_mesh(s);
    finish_bulk(s);
    return status;
}

namespace {

// Is it worth while to build anew what is seen, beside what there is? Not where there is hardly any room.
bool may_build_beside(const Mesh& mesh) {
    const std::uint32_t free = free_vertices(mesh);
    return free >= (mesh.capacity - free) / 4;
}

// It takes states of pages that it finds, while those of what is drawn stay.
bool needs_pages(const Pages& pages) {
    return may_lack_pages(pages) && free_pages(pages) < pages.count / 2;
}

} // namespace

bool run_bulk(CutState& s) {
    BulkPass& b = s.bulk;
    // A page that the host has unloaded without waiting takes its vertices along, at once.
    if (b.phase != BulkPhase::idle && has_lost_pages(s.pages)) finish_bulk(s);
    b.again = b.again || s.views.leapt;
    CutReport& r = s.frame.report;
    charge_work(s.bulk, s.frame, 0); // what the frames before could not pay
    while (!out_of_items(s.frame)) {
        // One that is dropped at every jump would never come to its end.
        const bool under_way = b.phase != BulkPhase::idle;
        if (b.again && b.phase < BulkPhase::triangles && !(under_way && b.begun_again)) {
            b.begun_again = b.begun_again || under_way;
            drop_bulk(s.pages, s.bulk, s.mesh);
            if (needs_pages(s.pages) && reclaim_page(s.pages, s.work, s.mesh, s.morphing)) {
                ++r.visits;
                if (out_of_time(s.frame, true)) break;
                continue;
            }
            b.again = false;
            sync_pages(s); // a slot may hold another page by now
            if (may_build_beside(s.mesh)) {
                watch_visited_pages(s);
                begin_bulk(s.pages, s.bulk, s.mesh, true);
            } else if (r.visits != 0) {
                ++r.visits; // or a replay that ends after the one before would still mean to begin
            }
        }
        if (b.phase == BulkPhase::idle) return false;
        if (b.phase >= BulkPhase::releasing) {
            s.views.jumped = step_install(s) && s.views.jumped;
            r.visits += b.units;
        } else {
            const BulkStatus status = step_bulk(s);
            r.visits += b.units;
            if (status == BulkStatus::built) {
                r.deactivations += s.mesh.capacity - free_vertices(s.mesh) - s.mesh.corner_count;
                r.activations += b.taken;
                install_mesh(s);
            } else if (status != BulkStatus::unfinished) {
                b.begun_again = false;
                return false; // one by one, then
            }
        }
        if (out_of_time(s.frame, true)) break;
    }
    if (b.phase != BulkPhase::idle && out_of_items(s.frame)) r.exhausted |= cut_budget_work;
    return b.phase != BulkPhase::idle;
}

} // namespace fjell
