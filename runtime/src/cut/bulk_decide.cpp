// What the bulk pass does to rows of a page: which of their vertices are wanted, and where they are written.
//
// What is decided is evaluated row by row as it lies, because the answers are rows of bits again; what does not lie in
// rows of 32, and what is written to its slots, is picked first, from as many rows as it takes. All of it reads what
// coarser steps have found and writes to one page, so that units may run on any threads.
#include <algorithm>
#include <bit>
#include <utility>

#include "cut/bulk_rows.h"
#include "cut/evaluate.h"
#include "cut/state.h"
#include "shared/compiler.h"
#include "shared/record.h"

namespace fjell {

namespace {

constexpr std::uint32_t most_picks = 512;

// Vertices of one page and step, taken from its rows.
struct Picks {
    std::uint32_t count = 0;
    std::uint64_t picked[most_picks]; // as PickedLanes has them, then row * page_squares + lane

    [[nodiscard]] std::uint32_t lane(std::uint32_t n) const { return static_cast<std::uint32_t>(picked[n] >> 32); }
    [[nodiscard]] bool has_room() const { return count + page_squares <= most_picks; }
    // So that whole groups can be evaluated: the last one, again.
    void pad() {
        for (std::uint32_t n = count; n % group_lanes != 0; ++n) picked[n] = picked[count - 1];
    }
};

// A page's rows, to pick from.
class Rows {
public:
    Rows(const Pages& pages, std::uint32_t slot)
        : pages_(pages), slot_(slot), info_(pages.state[slot]), shape_(pages.grid.shapes[info_.shape]),
          words_log2_(info_.shape == 0 ? 0 : 1), records_(records_of(pages, slot)) {}

    [[nodiscard]] const GroupShape& group(std::uint32_t row) const { return shape_.groups[row << words_log2_]; }
    [[nodiscard]] VertexKind kind(std::uint32_t row) const { return group(row).kind; }
    [[nodiscard]] int z(std::uint32_t row) const { return info_.z + group(row).z; }
    [[nodiscard]] std::uint32_t words_log2() const { return words_log2_; }
    // Its lanes lie side by side, and all 32 exist.
    [[nodiscard]] bool is_whole(std::uint32_t row) const {
        return words_log2_ != 0 && pages_.grid.hz_places == nullptr && group(row).stride == 1;
    }
    // A run of whole rows of one kind; ready has a word for each.
    [[nodiscard]] PageRows rows(std::uint32_t first, std::uint32_t count, const std::uint32_t* ready) const {
        const GroupShape& of = group(first);
        return {records_ + of.first,
                page_squares + (of.kind == VertexKind::side_y ? 1 : 0),
                count,
                ready,
                info_.x0 + (std::int32_t{of.x} << info_.z),
                info_.y0 + (std::int32_t{of.y} << info_.z),
                info_.z,
                info_.base,
                pages_.grid.level_unit_m[2 * info_.z + (of.kind == VertexKind::centre ? 0 : 1)]};
    }

    void pick(std::uint32_t row, std::uint32_t lanes, Picks& to) const {
        FJELL_ASSERT(to.has_room());
        const GroupShape& first = group(row);
        const std::uint64_t place = first.first | std::uint32_t{first.x} << 16 | std::uint32_t{first.y} << 24 |
                                    std::uint64_t{row * page_squares} << 32,
                            apart = first.stride | (first.along_y ? 2u << 24 : 2u << 16) | std::uint64_t{1} << 32;
        FJELL_PREFETCH(records_ + first.first);
        FJELL_PREFETCH(records_ + first.first + group_lanes);
        std::uint32_t count = to.count;
        for (; lanes != 0; lanes &= lanes - 1)
            to.picked[count++] = place + static_cast<std::uint32_t>(std::countr_zero(lanes)) * apart;
        if (pages_.grid.hz_places != nullptr) place_hz(row, to, count);
        to.count = count;
    }
    // Those of one step and kind.
    [[nodiscard]] PickedLanes lanes(Picks& picks) const {
        picks.pad();
        const std::uint32_t row = picks.lane(0) / page_squares;
        return {records_,    picks.picked,
                picks.count, info_.x0,
                info_.y0,    z(row),
                info_.base,  pages_.grid.level_unit_m[2 * z(row) + (group(row).kind == VertexKind::centre ? 0 : 1)]};
    }
    [[nodiscard]] bool is_void_at(std::uint64_t picked) const { return is_void(records_[picked & 0xffff]); }

    [[nodiscard]] bool may_be_offscreen() const { return info_.offscreen != 0; }
    // Of a row's lanes those that no view sees.
    [[nodiscard]] std::uint32_t offscreen(std::uint32_t row) const {
        if (info_.offscreen == 0) return 0;
        std::uint32_t lanes = 0;
        for (std::uint32_t word = 0; word < 1u << words_log2_; ++word) {
            const std::uint32_t number = slot_ * max_page_groups + (row << words_log2_) + word;
            if (is_offscreen(pages_, number)) lanes |= 0xffffu << (group_lanes * word);
        }
        return lanes;
    }

private:
    void place_hz(std::uint32_t row, Picks& to, std::uint32_t end) const {
        const std::size_t first = (std::size_t{info_.shape} * max_page_groups + (row << words_log2_)) * group_lanes;
        for (std::uint32_t n = to.count; n < end; ++n)
            to.picked[n] =
                (to.picked[n] & ~std::uint64_t{0xffff}) | pages_.grid.hz_places[first + to.lane(n) % page_squares];
    }

    const Pages& pages_;
    const std::uint32_t slot_;
    const PageState& info_;
    const PageShape& shape_;
    const std::uint32_t words_log2_;
    const VertexRecord* const records_;
};

// Decides rows of one page's vertices, of one step and kind.
class Decider {
public:
    Decider(const Pages& pages, const Schedule& schedule, BulkPass& bulk, const Views& views, BulkUnit& unit)
        : views_(views), rows_(pages, unit.slot), page_(bulk.pages[unit.slot]), unit_(unit),
          ticks_a_metre_(static_cast<float>(1 / tick_m(schedule, schedule.pages[unit.slot]))) {}

    // The rows are what is wanted of `ready`, from now on; once all has been decided. Rows of one kind, a word each.
    void add(std::uint32_t first, std::uint32_t count, const std::uint32_t* ready) {
        if (rows_.is_whole(first)) return decide_whole(first, count, ready);
        for (std::uint32_t n = 0; n < count; ++n) add(first + n, ready[n]);
    }
    void add(std::uint32_t row, std::uint32_t ready) {
        page_.active[row] = 0;
        if (ready == 0) return;
        unit_.groups += (ready & 0xffff) != 0;
        unit_.groups += ready >> group_lanes != 0;
        const std::uint32_t off = rows_.offscreen(row) & ready;
        if (off != 0) add(row, off, offscreen_, views_.offscreen_criterion);
        if (off != ready) add(row, ready & ~off, seen_, views_.criterion);
    }
    // All that were added can wait: nobody sees them, and they are due.
    void postpone(std::uint32_t row) {
        for (std::uint32_t word = 0, ready = page_.active[row]; ready != 0; ++word, ready >>= group_lanes)
            if ((ready & 0xffff) != 0)
                page_.ticks[(row << rows_.words_log2()) + word] = spent, unit_.grades = 1, ++unit_.groups;
        page_.active[row] = 0;
    }
    void finish() {
        decide(seen_, views_.criterion);
        decide(offscreen_, views_.offscreen_criterion);
    }

private:
    void add(std::uint32_t row, std::uint32_t ready, Picks& picks, const Criterion& criterion) {
        if (!picks.has_room()) decide(picks, criterion);
        rows_.pick(row, ready, picks);
    }
    void decide_whole(std::uint32_t first, std::uint32_t count, const std::uint32_t* ready) {
        std::fill_n(page_.active + first, count, 0);
        if (!rows_.may_be_offscreen()) return decide_whole(first, count, ready, views_.criterion);
        std::uint32_t seen[page_squares + 1], off[page_squares + 1], any_seen = 0, any_off = 0;
        for (std::uint32_t n = 0; n < count; ++n) {
            off[n] = ready[n] != 0 ? ready[n] & rows_.offscreen(first + n) : 0;
            seen[n] = ready[n] & ~off[n];
            any_seen |= seen[n];
            any_off |= off[n];
        }
        if (any_seen != 0) decide_whole(first, count, seen, views_.criterion);
        if (any_off != 0) decide_whole(first, count, off, views_.offscreen_criterion);
    }
    void decide_whole(std::uint32_t first, std::uint32_t count, const std::uint32_t* ready,
                      const Criterion& criterion) {
        RowAnswers answers{page_.active + first, page_.ticks + (first << rows_.words_log2()), 0, 0, 0};
        evaluate_rows(criterion, rows_.rows(first, count, ready), ticks_a_metre_, answers);
        if (answers.groups == 0) return;
        unit_.grades = std::max(unit_.grades, grade_of(answers.code) + 1);
        unit_.wanted += answers.count;
        unit_.groups += answers.groups;
    }

    void decide(Picks& picks, const Criterion& criterion) {
        if (picks.count == 0) return;
        std::uint16_t wanted[most_picks / group_lanes];
        std::int32_t ticks[most_picks];
        PickedAnswers answers{wanted, ticks, 0};
        evaluate_picked(criterion, rows_.lanes(picks), ticks_a_metre_, answers);
        unit_.grades = std::max(unit_.grades, grade_of(answers.code) + 1);
        const std::uint32_t to_group =
            page_squares_log2 - rows_.words_log2(); // a coarse row is a group, a full one two
        for (std::uint32_t n = 0; n < picks.count; ++n) {
            std::uint16_t& of = page_.ticks[picks.lane(n) >> to_group];
            of = std::min(of, static_cast<std::uint16_t>(soon + static_cast<std::uint32_t>(ticks[n])));
        }
        for (std::uint32_t first = 0; first < picks.count; first += group_lanes) {
            const std::uint32_t left = std::min(picks.count - first, group_lanes);
            std::uint32_t bits = wanted[first / group_lanes] & ((1u << left) - 1);
            for (; bits != 0; bits &= bits - 1, ++unit_.wanted) {
                const std::uint32_t lane = picks.lane(first + static_cast<std::uint32_t>(std::countr_zero(bits)));
                page_.active[lane / page_squares] |= 1u << lane % page_squares;
            }
        }
        picks.count = 0;
    }

    const Views& views_;
    const Rows rows_;
    BulkPage& page_;
    BulkUnit& unit_;
    const float ticks_a_metre_;
    Picks seen_, offscreen_;
};

// Sides that are ready, from the centres around them.
void decide_sides(const Pages& pages, const BulkPass& bulk, const BulkSquares& at, const BulkRows& part,
                  Decider& page) {
    const std::uint32_t* const centres = bulk.pages[at.slot].active + at.row(VertexKind::centre, 0);
    const BulkPage* const north = found_at(pages, bulk, at.z, at.i0, at.j0 - 1);
    const BulkPage* const west = found_at(pages, bulk, at.z, at.i0 - 1, at.j0);
    const bool north_ends = ends_north(pages.grid, at), west_ends = ends_west(pages.grid, at);
    const auto above = [&](std::int32_t j) {
        if (j != 0) return centres[j - 1];
        return north_ends ? at.all() : row_bits(north, at.row(VertexKind::centre, at.n - 1));
    };
    std::uint32_t ready[page_squares] = {};
    const auto count = static_cast<std::uint32_t>(part.end - part.first);
    for (std::int32_t j = part.first; j < part.end; ++j) ready[j - part.first] = centres[j] & above(j);
    page.add(at.row(VertexKind::side_x, part.first), count, ready);
    // The terrain's south and east rim: sides with one parent.
    if (part.end == at.n && ends_south(pages.grid, at)) page.add(at.row(VertexKind::side_x, at.n), centres[at.n - 1]);
    for (std::int32_t j = part.first; j < part.end; ++j) {
        const std::uint32_t left = west_ends ? 1 : row_bits(west, at.row(VertexKind::centre, j)) >> (at.n - 1) & 1;
        ready[j - part.first] = centres[j] & (centres[j] << 1 | left);
    }
    page.add(at.row(VertexKind::side_y, part.first), count, ready);
    if (part.end == at.n && ends_east(pages.grid, at)) {
        std::uint32_t east = 0;
        for (std::int32_t j = 0; j < at.n; ++j) east |= (centres[j] >> (at.n - 1) & 1) << j;
        page.add(at.column(), east);
    }
}

// Every active vertex has split two triangles into two each, but on the terrain's rim one; on a tile's border they are
// those of two tiles. What is not its own tile's, of a row.
void leave_triangles(const Pages& pages, const GroupShape& row, std::uint32_t active, BulkUnit& unit) {
    if (row.kind == VertexKind::centre) return;
    const PageState& page = pages.state[unit.slot];
    if (row.kind == VertexKind::side_x) {
        const bool last = row.j0 == 1u << pages.grid.steps[page.z + row.z].page_log2, first = page.j0 + row.j0 == 0;
        if (!first && !last) return;
        const auto all = static_cast<std::uint32_t>(std::popcount(active));
        unit.own -= all;
        if (first) unit.north += all;
    } else if (row.along_y) {
        unit.own -= static_cast<std::uint32_t>(std::popcount(active));
    } else if (page.i0 == 0) {
        unit.own -= active & 1;
        unit.west += active & 1;
    }
}

MorphVertex* morph_at(const Mesh& mesh, std::uint32_t slot) {
    return mesh.morph == nullptr ? nullptr : mesh.morph + slot;
}

// Writes a page's vertices, as the pass numbers them.
class Placer {
public:
    Placer(const Rows& rows, const BulkPass& bulk, Mesh& mesh, const Views& views, std::uint32_t number)
        : mesh_(mesh), views_(views), rows_(rows), slots_(mesh, bulk), number_(number) {}

    void add(std::uint32_t row, std::uint32_t active) {
        const GroupShape& group = rows_.group(row);
        const std::uint32_t level = 2u * group.z + (group.kind == VertexKind::centre);
        if (level != level_ || !picks_.has_room()) place();
        level_ = level;
        rows_.pick(row, active, picks_);
    }
    void place() {
        if (picks_.count == 0) return;
        const std::uint32_t count = picks_.count, number = std::exchange(number_, number_ + count);
        const PickedLanes lanes = rows_.lanes(picks_);
        // Whole groups go where they belong, if that is one after the other; the rest from slot to slot.
        const std::uint32_t direct = slots_.are_consecutive(number) ? count / group_lanes * group_lanes : 0;
        if (direct != 0) {
            PickedLanes whole = lanes;
            whole.count = direct;
            place_picked(views_.criterion, whole, mesh_.vertices + slots_[number], morph_at(mesh_, slots_[number]));
        }
        for (std::uint32_t first = direct; first < count; first += group_lanes)
            scatter(lanes, first, std::min(count - first, group_lanes), number + first);
        if (direct == 0 || mesh_.some_hidden)
            for (std::uint32_t n = 0; n < count; ++n)
                mesh_.hole[slots_[number + n]] = rows_.is_void_at(picks_.picked[n]) ? hole_bit : 0;
        else
            std::fill_n(mesh_.hole + slots_[number], count, std::uint8_t{0});
        picks_.count = 0;
    }

private:
    void scatter(PickedLanes lanes, std::uint32_t first, std::uint32_t count, std::uint32_t number) {
        MeshVertex vertices[group_lanes];
        MorphVertex morph[group_lanes];
        lanes.picked += first;
        lanes.count = count;
        place_picked(views_.criterion, lanes, vertices, mesh_.morph != nullptr ? morph : nullptr);
        for (std::uint32_t n = 0; n < count; ++n) {
            mesh_.vertices[slots_[number + n]] = vertices[n];
            if (mesh_.morph != nullptr) mesh_.morph[slots_[number + n]] = morph[n];
        }
    }

    Mesh& mesh_;
    const Views& views_;
    const Rows& rows_;
    const BulkSlots slots_;
    std::uint32_t number_, level_ = 0;
    Picks picks_;
};

} // namespace

void decide_unit(const Pages& pages, const Schedule& schedule, BulkPass& bulk, const Views& views, BulkUnit& unit) {
    if (unit.slot == no_index) return;
    const BulkSquares at = listed_squares(pages, unit.slot, unit.z);
    Decider page(pages, schedule, bulk, views, unit);
    if (bulk.phase == BulkPhase::sides) {
        decide_sides(pages, bulk, at, unit.rows, page);
    } else {
        const std::uint32_t first = at.row(VertexKind::centre, unit.rows.first);
        const auto count = static_cast<std::uint32_t>(unit.rows.end - unit.rows.first);
        std::uint32_t ready[page_squares];
        std::copy_n(bulk.pages[unit.slot].active + first, count, ready); // what is ready, until now
        for (std::uint32_t n = 0; unit.waits && n < count; ++n) page.postpone(first + n);
        if (!unit.waits) page.add(first, count, ready);
    }
    page.finish();
}

namespace {

// The first planes of a full page in rows of 32, its vertices in slots one after the other: row by row, without picking
// them first. first, end: rows. Returns the number of the next vertex.
std::uint32_t place_whole(const BulkPass& bulk, Mesh& mesh, const Views& views, const Rows& rows, const BulkPage& page,
                          std::uint32_t first, std::uint32_t end, std::uint32_t number) {
    constexpr std::uint32_t planes[4] = {0, page_squares, 2 * page_squares + 1, 3 * page_squares + 1};
    const std::uint32_t slot = BulkSlots(mesh, bulk)[number];
    std::uint32_t placed = 0;
    const auto plane = [&](std::uint32_t n) {
        const std::uint32_t from = std::max(first, planes[n]), to = std::max(std::min(end, planes[n + 1]), from);
        return rows.rows(std::min(from, planes[n + 1] - 1), to - from, page.active + from);
    };
    const auto place = [&](const PageRows* of, std::uint32_t count) {
        static_assert(hole_bit == 1);
        std::uint8_t* const holes = mesh.hole + slot + placed;
        const std::uint32_t more = place_rows(views.criterion, of, count, mesh.vertices + slot + placed,
                                              morph_at(mesh, slot + placed), mesh.some_hidden ? holes : nullptr);
        if (!mesh.some_hidden) std::fill_n(holes, more, std::uint8_t{0});
        placed += more;
    };
    const PageRows centres = plane(0), sides[2] = {plane(1), plane(2)};
    if (centres.count != 0) place(&centres, 1);
    if (sides[0].count + sides[1].count != 0) place(sides, 2);
    return number + placed;
}

template <typename Do>
void for_rows_in_use(const BulkPage& page, std::uint32_t first, std::uint32_t end, const Do& row) {
    for (; first < end; first += 64)
        for (std::uint64_t left = rows_in_use(page.active + first, std::min(end - first, 64u)); left != 0;
             left &= left - 1)
            row(first + static_cast<std::uint32_t>(std::countr_zero(left)));
}

} // namespace

void place_unit(const Pages& pages, BulkPass& bulk, Mesh& mesh, const Views& views, BulkUnit& unit) {
    BulkPage& page = bulk.pages[unit.slot];
    if (page.wanted == 0) return;
    const auto first = static_cast<std::uint32_t>(unit.rows.first), end = static_cast<std::uint32_t>(unit.rows.end);
    const std::uint32_t before = count_bits(page.active, first), column = 3 * page_squares + 1;
    const Rows rows(pages, unit.slot);
    // Its rows on the tile's border, and the column at the terrain's rim, may have triangles of other tiles.
    const PageState& info = pages.state[unit.slot];
    const bool inside = info.shape != 0 && info.i0 != 0 && info.j0 != 0;
    std::uint32_t in_page = before;
    page.first[first] = static_cast<std::uint16_t>(before);
    for_rows_in_use(page, first, end, [&](std::uint32_t row) {
        const std::uint32_t active = page.active[row];
        page.first[row] = static_cast<std::uint16_t>(in_page);
        in_page += static_cast<std::uint32_t>(std::popcount(active));
        if (!inside || row == 2 * page_squares || row == column) leave_triangles(pages, rows.group(row), active, unit);
    });
    unit.wanted = in_page - before;
    unit.own += 2 * unit.wanted;
    const std::uint32_t number = page.number + before;
    std::uint32_t next = first, done = 0;
    if (rows.is_whole(first) && BulkSlots(mesh, bulk).are_consecutive(number)) {
        next = std::min(end, column);
        done = place_whole(bulk, mesh, views, rows, page, first, next, number) - number;
    }
    Placer placer(rows, bulk, mesh, views, number + done);
    for_rows_in_use(page, next, end, [&](std::uint32_t row) { placer.add(row, page.active[row]); });
    placer.place();
}

} // namespace fjell
