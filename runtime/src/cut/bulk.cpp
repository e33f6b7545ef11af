#include "cut/bulk.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "compiler.h"
#include "cut/evaluate.h"
#include "cut/pages.h"
#include "cut/sight.h"
#include "pack/record.h"

namespace fjell {

namespace {

BulkPage& visit(CutState& s, std::uint32_t slot) {
    BulkPage& page = s.bulk.pages[slot];
    if (page.build == s.bulk.build) return page;
    page.build = s.bulk.build;
    page.grades = 0;
    std::fill_n(page.active, bulk_rows, 0);
    std::fill_n(page.ticks, page_ticks, unscheduled);
    s.bulk.visited[s.bulk.visited_count++] = slot;
    return page;
}

// The page that squares lie in has a state then. False: it is not loaded, or there is none to be had.
bool attach_squares(CutState& s, BulkSquares& at) {
    if (at.slot != no_index) return true;
    const std::uint32_t page = place_of(s, {at.z, VertexKind::centre, at.i0, at.j0}).page;
    if (!attach_page(s, page)) s.bulk.no_pages = true;
    if (s.page_groups[page] == no_index) return false;
    at.slot = s.page_groups[page] / max_page_groups;
    return true;
}

void visit_at(CutState& s, int z, std::int32_t i, std::int32_t j) {
    BulkSquares squares = squares_at(s, z, i, j);
    if (attach_squares(s, squares)) (void)visit(s, squares.slot);
}

std::uint32_t row_bits(const BulkPage* page, std::uint32_t row) {
    return page == nullptr ? 0 : page->active[row];
}

// Decides rows of one page's vertices.
class Decider {
public:
    Decider(CutState& state, const BulkSquares& squares)
        : s(state), at_(squares), page_(visit(state, squares.slot)),
          ticks_a_metre_(1 / tick_m(state.schedule, state.schedule.pages[squares.slot])) {}

    [[nodiscard]] const BulkPage& page() const { return page_; }

    void add(std::uint32_t row, std::uint32_t ready) {
        if (ready == 0) return;
        const std::uint32_t words = 1u << at_.step->words_log2, first = row << at_.step->words_log2;
        for (std::uint32_t word = 0; word < words; ++word, ready >>= group_lanes) {
            const std::uint32_t lanes = ready & 0xffff;
            if (lanes == 0) continue;
            groups_[count_++] = {static_cast<std::uint16_t>(first + word), static_cast<std::uint16_t>(lanes)};
            prefetch(first + word);
        }
    }
    // All that were added. Those that nobody sees can wait: they are due.
    void postpone() {
        page_.grades = std::max(page_.grades, count_ != 0 ? 1u : 0u);
        for (std::uint32_t i = 0; i < count_; ++i) page_.ticks[groups_[i].number] = spent;
    }
    void decide() {
        for (std::uint32_t i = 0; i < count_; ++i) decide(groups_[i].number, groups_[i].ready);
        s.report.evaluations += count_;
    }

private:
    struct Ready {
        std::uint16_t number, ready;
    };

    void prefetch(std::uint32_t number) const {
        const VertexRecord* const records = s.terrain->records + std::size_t{at_.slot} * s.terrain->page_capacity +
                                            s.shapes[s.page_state[at_.slot].shape].groups[number].first;
        FJELL_PREFETCH(records);
        FJELL_PREFETCH(records + group_lanes - 1);
    }

    void decide(std::uint32_t number, std::uint32_t ready) {
        VertexRecord gathered[group_lanes];
        LaneGroup lanes = lanes_of(s, at_.slot * max_page_groups + number, gathered);
        lanes.inactive = ready;
        LaneAnswers answers;
        LaneNumbers numbers;
        evaluate_and_keep(criterion_of(s, at_.slot * max_page_groups + number), lanes, answers, numbers);
        if (bulk_capacity(s) -
            s.bulk.taken<group_lanes&& static_cast<std::uint32_t>(std::popcount(answers.wanted))> bulk_capacity(s) -
            s.bulk.taken) {
            s.bulk.no_vertices = true;
            return;
        }
        const double ticks = static_cast<double>(answers.slack_m) * ticks_a_metre_;
        page_.ticks[number] =
            static_cast<std::uint16_t>(soon + static_cast<std::uint32_t>(std::min(ticks, double{most_ticks})));
        page_.grades = std::max(page_.grades, grade_of(answers.code) + 1);
        const std::uint32_t row = number >> at_.step->words_log2, word = number - (row << at_.step->words_log2);
        if (page_.active[row] == 0) page_.first[row] = s.bulk.taken;
        page_.active[row] |= answers.wanted << (group_lanes * word);
        place(lanes, answers.wanted, numbers);
    }

    void place(const LaneGroup& lanes, std::uint32_t wanted, const LaneNumbers& numbers) {
        const BulkSlots slots(s);
        const std::uint32_t first = s.bulk.taken, dx = static_cast<std::uint32_t>(lanes.dx),
                            dy = static_cast<std::uint32_t>(lanes.dy), x0 = static_cast<std::uint32_t>(lanes.x0),
                            y0 = static_cast<std::uint32_t>(lanes.y0);
        const auto last_x = static_cast<std::uint32_t>(s.criterion.last_x),
                   last_y = static_cast<std::uint32_t>(s.criterion.last_y);
        const VertexRecord* const records = lanes.records;
        MeshVertex* const vertices = s.vertices;
        MorphVertex* const morph = s.morph;
        std::uint8_t* const hole = s.hole;
        std::uint32_t number = first;
        for (std::uint32_t left = wanted; left != 0; left &= left - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
            const std::uint32_t slot = slots[number++];
            vertices[slot] = {static_cast<std::int32_t>(std::min(x0 + lane * dx, last_x)),
                              static_cast<std::int32_t>(std::min(y0 + lane * dy, last_y)), numbers.height_m[lane]};
            morph[slot] = {0, numbers.error_m[lane], numbers.radius_m[lane], long_active_s};
            hole[slot] = is_void(records[lane]);
        }
        s.bulk.taken = number;
        if (s.bulk.beside)
            for (std::uint32_t n = first; n != number; ++n) s.dirty_vertices.mark(slots[n]);
    }

    CutState& s;
    const BulkSquares at_;
    BulkPage& page_;
    const double ticks_a_metre_;
    std::uint32_t count_ = 0;
    Ready groups_[max_page_groups];
};

// A full page is decided in parts, so that a unit of work stays small where time counts: the rows from `first` on.
struct Part {
    std::int32_t first, end;
};
std::uint32_t parts_of(const CutState& s, const BulkSquares& at) {
    return s.bulk.beside && at.n == static_cast<std::int32_t>(page_squares) ? 4 : 1;
}
Part part_of(const CutState& s, const BulkSquares& at, std::uint32_t part) {
    const std::int32_t rows = at.n / static_cast<std::int32_t>(parts_of(s, at)),
                       first = static_cast<std::int32_t>(part) * rows;
    return {first, first + rows};
}

// False: there is nothing to decide in any part.
bool decide_centres(CutState& s, BulkSquares& at, const Part& part) {
    std::uint32_t parents[2][page_squares];
    if (!centre_parents(s, at, parents) || !attach_squares(s, at)) return false;
    Decider page(s, at);
    if (s.page_state[at.slot].status == PageStatus::evicting) return false;
    const PageState& state = s.page_state[at.slot];
    const bool waits = s.bulk.beside && state.shape != 0 && !may_be_seen(s, state);
    for (std::int32_t j = waits ? 0 : part.first; j < (waits ? at.n : part.end); ++j)
        page.add(at.row(VertexKind::centre, j), parents[0][j] & parents[1][j]);
    if (waits)
        page.postpone();
    else
        page.decide();
    return !waits;
}

bool has_centres(const CutState& s, const BulkSquares& at) {
    const std::uint32_t* const centres = s.bulk.pages[at.slot].active + at.row(VertexKind::centre, 0);
    return std::any_of(centres, centres + at.n, [](std::uint32_t row) { return row != 0; });
}

// Of a page with active centres. Those to its north and west must have been decided.
void decide_sides(CutState& s, const BulkSquares& at, const Part& part) {
    Decider page(s, at);
    const std::uint32_t* const centres = page.page().active + at.row(VertexKind::centre, 0);
    const BulkPage* const north = found_at(s, at.z, at.i0, at.j0 - 1);
    const BulkPage* const west = found_at(s, at.z, at.i0 - 1, at.j0);
    for (std::int32_t j = part.first; j < part.end; ++j) {
        const std::uint32_t c = centres[j];
        const std::uint32_t above = j != 0       ? centres[j - 1]
                                    : at.j0 == 0 ? at.all()
                                                 : row_bits(north, at.row(VertexKind::centre, at.n - 1));
        const std::uint32_t left = at.i0 == 0 ? 1 : row_bits(west, at.row(VertexKind::centre, j)) >> (at.n - 1) & 1;
        page.add(at.row(VertexKind::side_x, j), c & above);
        page.add(at.row(VertexKind::side_y, j), c & (c << 1 | left));
    }
    if (part.end == at.n) {
        // The terrain's south and east rim: sides with one parent. Elsewhere those are the next page's, which has to
        // know.
        const std::uint32_t last = centres[at.n - 1];
        std::uint32_t east = 0;
        for (std::int32_t j = 0; j < at.n; ++j) east |= (centres[j] >> (at.n - 1) & 1) << j;
        if (at.j0 + at.n == s.tiles_y << at.step->log2)
            page.add(at.row(VertexKind::side_x, at.n), last);
        else if (last != 0)
            visit_at(s, at.z, at.i0, at.j0 + at.n);
        if (at.i0 + at.n == s.tiles_x << at.step->log2)
            page.add(at.column(), east);
        else if (east != 0)
            visit_at(s, at.z, at.i0 + at.n, at.j0);
    }
    page.decide();
}

// The squares of a step in a page that is listed.
BulkSquares listed_squares(const CutState& s, std::uint32_t slot, int z) {
    const PageState& page = s.page_state[slot];
    const StepGroups& step = s.steps[z];
    return {&step,
            slot,
            z,
            (page.tile_x << step.log2) + page.i0,
            (page.tile_y << step.log2) + page.j0,
            1 << step.page_log2};
}

// The next page whose centres are to be decided. A step with at most one page a tile: every tile's. A finer one: those
// under pages with active centres. No other can have an active parent.
bool next_squares(const CutState& s, BulkSquares& squares) {
    const BulkPass& b = s.bulk;
    const StepGroups& step = s.steps[b.z];
    if (step.log2 <= page_squares_log2) {
        if (b.at == s.terrain->tile_count()) return false;
        const auto tiles_x = static_cast<std::uint32_t>(s.tiles_x);
        squares = squares_at(s, b.z, static_cast<std::int32_t>(b.at % tiles_x) << step.log2,
                             static_cast<std::int32_t>(b.at / tiles_x) << step.log2);
        return true;
    }
    if (b.at == 4 * b.listed_count[0]) return false;
    const BulkSquares above = listed_squares(s, b.listed[0][b.at / 4], b.z + 1);
    const auto quarter = static_cast<std::int32_t>(b.at % 4);
    squares = squares_at(s, b.z, 2 * above.i0 + quarter % 2 * above.n, 2 * above.j0 + quarter / 2 * above.n);
    return true;
}

} // namespace

bool centre_parents(const CutState& s, const BulkSquares& at, std::uint32_t (&parents)[2][page_squares]) {
    if (at.z == s.terrain->tree.tile_log2 - 1) {
        parents[0][0] = parents[1][0] = 1;
        return true;
    }
    // Their parents are sides of one quarter of a coarser page, or of all of a coarser step of the tile.
    const BulkSquares up = squares_at(s, at.z + 1, at.i0 >> 1, at.j0 >> 1);
    const BulkPage* const page = found_in(s, up.slot);
    if (page == nullptr) return false;
    const std::int32_t half = at.n / 2, i = (at.i0 >> 1) - up.i0, j0 = (at.j0 >> 1) - up.j0;
    const std::uint32_t lanes = (1u << half) - 1;
    std::uint32_t x[page_squares / 2 + 1], y[page_squares / 2], any = 0;
    for (std::int32_t j = 0; j <= half; ++j) {
        const BulkPage* of = page;
        std::int32_t row = j0 + j;
        if (row == up.n && up.j0 + up.n != s.tiles_y << up.step->log2) { // the next page's
            of = found_at(s, up.z, up.i0, up.j0 + up.n);
            row = 0;
        }
        x[j] = row_bits(of, up.row(VertexKind::side_x, row)) >> i & lanes;
        any |= x[j];
    }
    const bool last = i + half == up.n, rim = up.i0 + up.n == s.tiles_x << up.step->log2;
    const BulkPage* const east = last && !rim ? found_at(s, up.z, up.i0 + up.n, up.j0) : nullptr;
    std::uint32_t y_last[page_squares / 2];
    for (std::int32_t j = 0; j < half; ++j) {
        y[j] = page->active[up.row(VertexKind::side_y, j0 + j)] >> i;
        if (last)
            y_last[j] = rim ? page->active[up.column()] >> (j0 + j) & 1
                            : row_bits(east, up.row(VertexKind::side_y, j0 + j)) & 1;
        else
            y_last[j] = y[j] >> half & 1;
        y[j] &= lanes;
        any |= y[j] | y_last[j];
    }
    if (any == 0) return false;
    for (std::int32_t j = 0; j <= half; ++j)
        if (x[j] != 0) x[j] = doubled(x[j]);
    for (std::int32_t j = 0; j < half; ++j)
        if ((y[j] | y_last[j]) != 0)
            y[j] = static_cast<std::uint32_t>((doubled(y[j]) | std::uint64_t{y_last[j]} * 3 << (2 * half)) >> 1) &
                   at.all();
    for (std::int32_t j = 0; j < half; ++j) {
        parents[0][2 * j] = x[j];
        parents[0][2 * j + 1] = x[j + 1];
        parents[1][2 * j] = parents[1][2 * j + 1] = y[j];
    }
    return true;
}

void begin_bulk(CutState& s, bool beside) {
    BulkPass& b = s.bulk;
    FJELL_ASSERT(b.phase == BulkPhase::idle);
    if (++b.build == 0) { // as good as never
        for (std::uint32_t slot = 0; slot < s.page_count; ++slot) b.pages[slot].build = 0;
        b.build = 1;
    }
    b.beside = beside;
    b.no_vertices = b.no_pages = false;
    b.taken = b.visited_count = b.listed_count[0] = b.listed_count[1] = b.at = b.part = 0;
    b.free_before = beside ? s.free_vertex_count : 0;
    b.fresh_before = beside ? s.fresh_vertex : corner_slots(s);
    b.z = s.terrain->tree.tile_log2 - 1;
    b.phase = BulkPhase::centres;
    std::fill_n(b.travelled_m, grade_count, 0.0);
}

void drop_bulk(CutState& s) {
    BulkPass& b = s.bulk;
    FJELL_ASSERT(b.phase < BulkPhase::releasing);
    for (std::uint32_t i = 0; b.phase != BulkPhase::idle && i < b.visited_count; ++i) note_idle(s, b.visited[i]);
    b.phase = BulkPhase::idle;
}

namespace {

BulkStatus stop(CutState& s, BulkStatus status) {
    if (status == BulkStatus::built)
        s.bulk.phase = BulkPhase::built;
    else
        drop_bulk(s);
    return status;
}

} // namespace

BulkStatus step_bulk(CutState& s) {
    BulkPass& b = s.bulk;
    FJELL_ASSERT(b.phase == BulkPhase::centres || b.phase == BulkPhase::sides || b.phase == BulkPhase::triangles);
    if (b.phase == BulkPhase::triangles) return step_triangles(s) ? BulkStatus::unfinished : stop(s, BulkStatus::built);
    if (b.no_vertices) return stop(s, BulkStatus::no_vertices);
    if (b.no_pages) return stop(s, BulkStatus::no_pages);
    if (b.phase == BulkPhase::centres) {
        BulkSquares squares;
        if (next_squares(s, squares)) {
            if (decide_centres(s, squares, part_of(s, squares, b.part))) {
                if (++b.part != parts_of(s, squares)) return BulkStatus::unfinished;
                if (has_centres(s, squares)) b.listed[1][b.listed_count[1]++] = squares.slot;
            }
            b.part = 0;
            ++b.at;
            return BulkStatus::unfinished;
        }
        b.phase = BulkPhase::sides;
        b.at = 0;
    }
    if (b.at != b.listed_count[1]) {
        const BulkSquares squares = listed_squares(s, b.listed[1][b.at], b.z);
        decide_sides(s, squares, part_of(s, squares, b.part));
        if (++b.part == parts_of(s, squares)) {
            b.part = 0;
            ++b.at;
        }
        return BulkStatus::unfinished;
    }
    if (b.z != 0 && b.listed_count[1] != 0) {
        std::swap(b.listed[0], b.listed[1]);
        b.listed_count[0] = std::exchange(b.listed_count[1], 0u);
        --b.z;
        b.at = 0;
        b.phase = BulkPhase::centres;
        return BulkStatus::unfinished;
    }
    b.phase = BulkPhase::triangles;
    return begin_triangles(s) ? BulkStatus::unfinished : stop(s, BulkStatus::no_triangles);
}

} // namespace fjell
