#include "edit/apply.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include "edit/measure.h"
#include "edit/stamp.h"

namespace fjell::edit {

namespace {

// --- blocks

std::uint32_t& block_cell(EditsData& e, std::int32_t x, std::int32_t y) {
    const std::uint32_t mask = e.block_table_size - 1;
    std::uint32_t at =
        (static_cast<std::uint32_t>(x) * 0x9e37'79b9u ^ static_cast<std::uint32_t>(y) * 0x85eb'ca6bu) & mask;
    while (e.block_table[at] != no_index && (e.blocks[e.block_table[at]].x != x || e.blocks[e.block_table[at]].y != y))
        at = (at + 1) & mask;
    return e.block_table[at];
}
Block* find_block(EditsData& e, SampleIndex sample) {
    const std::uint32_t number = block_cell(e, sample.column >> block_log2, sample.row >> block_log2);
    return number == no_index ? nullptr : &e.blocks[number];
}
std::size_t in_block(SampleIndex sample) {
    return static_cast<std::size_t>(sample.row & (block_side - 1)) * block_side +
           static_cast<std::size_t>(sample.column & (block_side - 1));
}
// Makes room for a value among a block's; there is, or the stamp would have been refused.
void rebase(std::int32_t& base, std::uint16_t* values, const std::uint16_t* edited, std::int32_t value) {
    const std::int32_t off = value - base;
    if (off >= 0 && off < as_in_pack) return;
    std::int32_t low = value, high = value;
    for (std::size_t k = 0; k < block_side * block_side; ++k) {
        if (edited[k] == as_in_pack) continue;
        low = std::min(low, base + values[k]);
        high = std::max(high, base + values[k]);
    }
    const std::int32_t span = high - low, room = (as_in_pack - 1 - span) / 2; // on both sides
    const std::int32_t to = low - room;
    for (std::size_t k = 0; k < block_side * block_side; ++k)
        if (edited[k] != as_in_pack) values[k] = static_cast<std::uint16_t>(base + values[k] - to);
    base = to;
}
void remember(EditsData& e, SampleIndex sample, std::int32_t before, std::int32_t after) {
    std::uint32_t& cell = block_cell(e, sample.column >> block_log2, sample.row >> block_log2);
    if (cell == no_index) {
        cell = e.block_count++;
        Block& b = e.blocks[cell];
        b = {};
        b.x = sample.column >> block_log2, b.y = sample.row >> block_log2;
        b.pack_base = before - as_in_pack / 2, b.base = after - as_in_pack / 2;
        std::fill_n(b.edited, block_side * block_side, as_in_pack);
    }
    Block& b = e.blocks[cell];
    const std::size_t k = in_block(sample);
    // Both move at once: what is edited is told by `edited`, whose values change with their base.
    if (b.edited[k] == as_in_pack) {
        rebase(b.pack_base, b.pack, b.edited, before);
        b.pack[k] = static_cast<std::uint16_t>(before - b.pack_base);
    }
    rebase(b.base, b.edited, b.edited, after);
    b.edited[k] = static_cast<std::uint16_t>(after - b.base);
}

// visit(x, y) for the blocks of the samples that vertices at these places stand at.
template <typename Visit>
void for_each_block(const TerrainData& t, const Rect& places, const Visit& visit) {
    const SampleIndex first = t.tree.sample({places.x0, places.y0}), last = t.tree.sample({places.x1, places.y1});
    for (std::int32_t y = first.row >> block_log2; y <= last.row >> block_log2; ++y)
        for (std::int32_t x = first.column >> block_log2; x <= last.column >> block_log2; ++x) visit(x, y);
}

// --- what lies around

void gather(const TerrainData& t, const Rect& rect, Window& w) {
    w.rect = rect.within(grid_of(t.tree));
    for (std::int32_t y = w.rect.y0; y <= w.rect.y1; ++y)
        std::fill_n(w.missing + w.index({w.rect.x0, y}), w.rect.columns(), std::uint8_t{1});
    const auto put = [&](SampleIndex v, std::int32_t steps, bool hole) {
        const std::size_t k = w.index(v);
        w.steps[k] = steps;
        w.missing[k] = 0;
        w.hole[k] = hole;
    };
    for (int z = 0; z < t.tree.tile_log2; ++z)
        for (const VertexKind kind : sides_then_centres) {
            const Plane plane{z, kind};
            for_each_run(t, plane, plane.squares(w.rect), [&](const Run& run) {
                const PageEntry entry = t.page_table[run.page];
                if (entry.slot == no_index) return;
                const VertexRecord* const from = t.records + std::size_t{entry.slot} * t.page_capacity + run.index;
                for (std::int32_t k = 0; k < run.count; ++k)
                    put(plane.at(run.i + k, run.j), entry.base + from[k].height, is_void(from[k]));
            });
        }
    const std::int32_t side = t.tree.side();
    for (std::int32_t y = (w.rect.y0 + side - 1) / side * side; y <= w.rect.y1; y += side)
        for (std::int32_t x = (w.rect.x0 + side - 1) / side * side; x <= w.rect.x1; x += side) {
            const Height h = height_at(t, {x, y});
            put({x, y}, h.steps, h.hole);
        }
}

// --- what a stamp makes of a piece

struct Change {
    Rect places;                    // where something changes
    std::int32_t low = 0, high = 0; // of the new heights, and of the old ones
    std::int32_t old_low = 0, old_high = 0;
    std::int32_t least_delta = 0, most_delta = 0; // of new over old, 0 among them
    std::int32_t samples = 0;
    bool number = false; // a height is none
};

// Into e.piece, from e.window.
Change evaluate(EditsData& e, const Stamp& stamp, const Rect& rect, bool checking) {
    const TerrainData& t = *e.terrain;
    const Window& w = e.window;
    e.piece.rect = rect;
    Change change;
    const double base_m = t.height_scale.base_m, quantum_m = t.height_scale.quantum_m;
    const Rect samples = samples_of(t, stamp);
    const Rect inside{0, 0, t.tree.columns() - 1, t.tree.rows() - 1};
    for (std::int32_t y = rect.y0; y <= rect.y1; ++y)
        for (std::int32_t x = rect.x0; x <= rect.x1; ++x) {
            const std::size_t k = w.index({x, y});
            std::int32_t& to = e.piece.changed[static_cast<std::size_t>(y - rect.y0) * piece_side +
                                               static_cast<std::size_t>(x - rect.x0)];
            to = w.steps[k];
            const SampleIndex sample = t.tree.sample({x, y});
            if (w.missing[k] != 0 || w.hole[k] != 0 || !samples.contains(sample)) continue;
            const std::int32_t before = to;
            const auto take = [&](std::int32_t steps) {
                to = steps;
                if (to == before) return;
                change.low = change.samples == 0 ? to : std::min(change.low, to);
                change.high = change.samples == 0 ? to : std::max(change.high, to);
                change.old_low = change.samples == 0 ? before : std::min(change.old_low, before);
                change.old_high = change.samples == 0 ? before : std::max(change.old_high, before);
                change.least_delta = std::min(change.least_delta, to - before);
                change.most_delta = std::max(change.most_delta, to - before);
                change.places = change.places.with({x, y, x, y});
                ++change.samples;
            };
            if (sample != SampleIndex{x, y}) { // it stands where that does, which was looked at before
                if (rect.contains(sample))
                    take(e.piece.changed[static_cast<std::size_t>(sample.row - rect.y0) * piece_side +
                                         static_cast<std::size_t>(sample.column - rect.x0)]);
                else if (!checking)
                    take(height_at(t, sample).steps);
                continue;
            }
            Surroundings now{base_m + to * quantum_m, 0, 0};
            std::int32_t pack = to;
            if (stamp.shape == StampShape::restore) {
                const Block* const block = find_block(e, sample);
                if (block == nullptr || block->edited[in_block(sample)] == as_in_pack) continue;
                pack = block->pack_base + block->pack[in_block(sample)];
                now.pack_m = base_m + pack * quantum_m;
            }
            if (stamp.shape == StampShape::smooth) {
                std::int64_t sum = 0;
                std::int32_t count = 0;
                for (std::int32_t dy = -1; dy <= 1; ++dy)
                    for (std::int32_t dx = -1; dx <= 1; ++dx) {
                        const SampleIndex v{sample.column + dx, sample.row + dy};
                        if (!inside.contains(v)) continue;
                        const Height h = Heights{t, &w}.at(v);
                        if (h.loaded && !h.hole) sum += h.steps, ++count;
                    }
                now.mean_m = base_m + static_cast<double>(sum) / count * quantum_m;
            }
            const double new_m = stamped_m(t, stamp, sample, now);
            if (std::isnan(new_m)) continue;
            const double steps = std::floor((new_m - base_m) / quantum_m + 0.5);
            if (!(std::abs(steps) < max_height_steps)) {
                change.number = true;
                continue;
            }
            // What goes all the way back is the pack's own, whatever rounding says.
            take(stamp.shape == StampShape::restore && new_m == now.pack_m ? pack : static_cast<std::int32_t>(steps));
        }
    return change;
}

// --- what is refused

// Would every vertex' sphere and error still have a code? Worked out as the baker works out its units
// (choose_radius_units), from the steepest step and the range of heights.
bool has_codes(const EditsData& e, double steepest_m, double range_m) {
    const TerrainData& t = *e.terrain;
    const double span = t.radii.factor[radius_codes - 1];
    const double sx = t.header.spacing_m[0], sz = t.header.spacing_m[1];
    double worst = 0;
    for (int z = 0; z < t.tree.tile_log2; ++z)
        for (const bool centre : {false, true}) {
            const double step = 1 << z;
            const bool along_axis = centre || z == 0;
            const double way =
                (along_axis ? step * std::max(sx, sz) : step / 2 * std::hypot(sx, sz)) + 2 * e.radius.ground_pad_m;
            const double climb = std::min(range_m, steepest_m * step) + e.radius.height_pad_m;
            worst =
                (std::hypot(way, climb) + worst) * (1 + 0x1p-16) + (z == 0 && !centre ? e.radius.half_quantum_m : 0);
            const double unit = e.radius.unit_m[2 * z + (centre ? 1 : 0)];
            // A thousandth more than the codes span: never met, for no ground is as steep everywhere.
            if (worst > unit * span * (1 + 0x1p-10)) return false;
            worst = std::max(worst * static_cast<double>(RadiusScale::ratio), unit);
            const auto level = static_cast<std::uint32_t>(2 * (t.tree.tile_log2 - 1 - z) + (centre ? 0 : 1));
            const double error_m = std::min(range_m, 4 * step * steepest_m);
            if (static_cast<double>(t.errors.metres[255]) < error_m ||
                t.errors.code_up(error_m) + t.errors.nesting_steps * level > 255)
                return false;
        }
    return true;
}

std::int32_t steepest_around(const EditsData& e, const Change& change) {
    const Window& w = e.window;
    const auto steps = [&](std::int32_t x, std::int32_t y) {
        if (e.piece.rect.contains({x, y}))
            return e.piece.changed[static_cast<std::size_t>(y - e.piece.rect.y0) * piece_side +
                                   static_cast<std::size_t>(x - e.piece.rect.x0)];
        return w.steps[w.index({x, y})];
    };
    const Rect r = change.places.grown(1).within(w.rect);
    std::int32_t most = 0;
    for (std::int32_t y = r.y0; y <= r.y1; ++y)
        for (std::int32_t x = r.x0; x <= r.x1; ++x) {
            if (w.missing[w.index({x, y})] != 0) continue;
            if (x < r.x1 && w.missing[w.index({x + 1, y})] == 0)
                most = std::max(most, std::abs(steps(x + 1, y) - steps(x, y)));
            if (y < r.y1 && w.missing[w.index({x, y + 1})] == 0)
                most = std::max(most, std::abs(steps(x, y + 1) - steps(x, y)));
        }
    return most;
}

// Do pages and blocks still span fewer than 65,536 steps with these heights?
bool spans_fit(EditsData& e, const Waiting& w) {
    const TerrainData& t = *e.terrain;
    const Rect& places = w.changed;
    const std::int32_t low = w.low, high = w.high;
    bool fit = high - low < as_in_pack - 1 && w.old_high - w.old_low < as_in_pack - 1;
    for_each_block(t, places, [&](std::int32_t x, std::int32_t y) {
        const std::uint32_t number = block_cell(e, x, y);
        if (number == no_index) return;
        const Block& b = e.blocks[number];
        std::int32_t least[2] = {low, w.old_low}, most[2] = {high, w.old_high};
        for (std::size_t k = 0; k < block_side * block_side; ++k) {
            if (b.edited[k] == as_in_pack) continue;
            const std::int32_t value[2] = {b.base + b.edited[k], b.pack_base + b.pack[k]};
            for (const std::size_t n : {0u, 1u})
                least[n] = std::min(least[n], value[n]), most[n] = std::max(most[n], value[n]);
        }
        fit = fit && most[0] - least[0] < as_in_pack - 1 && most[1] - least[1] < as_in_pack - 1;
    });
    for (int z = 0; z < t.tree.tile_log2 && fit; ++z)
        for (const VertexKind kind : sides_then_centres) {
            const Plane plane{z, kind};
            std::uint32_t last = no_index;
            for_each_run(t, plane, plane.squares(places), [&](const Run& run) {
                if (run.page == last || !fit) return;
                last = run.page;
                const PageEntry entry = t.page_table[run.page];
                if (entry.slot == no_index) return;
                const VertexRecord* const r = t.records + std::size_t{entry.slot} * t.page_capacity;
                std::uint16_t least = 0xffff, most = 0;
                const std::uint32_t count = t.pages.page_vertices(run.page % t.pages_per_tile);
                for (std::uint32_t k = 0; k < count; ++k)
                    least = std::min(least, r[k].height), most = std::max(most, r[k].height);
                fit = std::max(entry.base + most, high) - std::min(entry.base + least, low) < as_in_pack;
            });
        }
    return fit;
}

std::uint32_t new_blocks(EditsData& e, const Rect& places) {
    std::uint32_t count = 0;
    for_each_block(*e.terrain, places,
                   [&](std::int32_t x, std::int32_t y) { count += block_cell(e, x, y) == no_index ? 1 : 0; });
    return count;
}

// --- heights

// So that its vertices and these heights count from it in 16 bits. Readers of other threads find the page missing
// meanwhile (pack/publish.h).
void rebase_page(const TerrainData& t, std::uint32_t page, std::int32_t low, std::int32_t high) {
    TerrainMemory& m = *t.memory;
    PageEntry& entry = m.page_table[page];
    const PageEntry old = entry;
    VertexRecord* const r = m.records + std::size_t{old.slot} * t.page_capacity;
    const std::uint32_t count = t.pages.page_vertices(page % t.pages_per_tile);
    for (std::uint32_t k = 0; k < count; ++k) {
        low = std::min(low, old.base + r[k].height);
        high = std::max(high, old.base + r[k].height);
    }
    const std::int32_t base = low - (65535 - (high - low)) / 2;
    publish_entry(entry, {no_index, 0});
    begin_slot(m.slot_loads[old.slot]);
    for (std::uint32_t k = 0; k < count; ++k) {
        VertexRecord record = r[k];
        record.height = static_cast<std::uint16_t>(old.base + record.height - base);
        write_record(r + k, bits_as<std::uint32_t>(record));
    }
    publish_entry(entry, {old.slot, base});
}

void write_heights(EditsData& e, const Change& change) {
    const TerrainData& t = *e.terrain;
    TerrainMemory& m = *t.memory;
    const Window& w = e.window;
    for (int z = 0; z < t.tree.tile_log2; ++z)
        for (const VertexKind kind : sides_then_centres) {
            const Plane plane{z, kind};
            for_each_run(t, plane, plane.squares(change.places), [&](const Run& run) {
                PageEntry entry = t.page_table[run.page];
                if (entry.slot == no_index) return;
                if (change.low < entry.base || change.high - entry.base > 65535) {
                    rebase_page(t, run.page, change.low, change.high);
                    entry = t.page_table[run.page];
                }
                VertexRecord* const to = m.records + std::size_t{entry.slot} * t.page_capacity + run.index;
                for (std::int32_t k = 0; k < run.count; ++k) {
                    VertexRecord record = to[k];
                    const std::int32_t steps = w.steps[w.index(plane.at(run.i + k, run.j))];
                    const auto height = static_cast<std::uint16_t>(steps - entry.base);
                    if (height == record.height) continue;
                    record.height = height;
                    write_record(to + k, bits_as<std::uint32_t>(record));
                }
            });
        }
    const std::int32_t side = t.tree.side();
    for (std::int32_t y = (change.places.y0 + side - 1) / side * side; y <= change.places.y1; y += side)
        for (std::int32_t x = (change.places.x0 + side - 1) / side * side; x <= change.places.x1; x += side) {
            std::uint32_t& corner = m.corners[t.corner_at(x / side, y / side)];
            const std::uint32_t stored =
                (static_cast<std::uint32_t>(w.steps[w.index({x, y})]) & ~corner_void_bit) | (corner & corner_void_bit);
            store_word_relaxed(&corner, stored);
        }
}

// --- errors

// Vertices whose error or whose descendants' may have changed with the ground in these places: a diamond reaches s from
// its vertex, a child's vertex lies s or s / 2 away.
Rect around(const Rect& places, const Plane& plane) {
    return plane.squares(places.grown((plane.kind == VertexKind::centre ? 3 : 2) << plane.z));
}

void store_code(const TerrainData& t, const Plane& plane, std::int32_t i, std::int32_t j, std::uint32_t code) {
    for_each_run(t, plane, {i, j, i, j}, [&](const Run& run) {
        const std::uint32_t slot = t.page_table[run.page].slot;
        if (slot == no_index) return;
        VertexRecord* const to = t.memory->records + std::size_t{slot} * t.page_capacity + run.index;
        VertexRecord record = *to;
        record.error = static_cast<std::uint8_t>(code);
        write_record(to, bits_as<std::uint32_t>(record));
    });
}

std::uint32_t grown_code(const TerrainData& t, std::uint32_t code, double by_m) {
    return t.errors.code_up(static_cast<double>(t.errors.metres[code]) + by_m);
}

void note_error(TerrainData& t, std::uint32_t code) {
    if (t.errors.metres[code] > t.range.error_m) store_release(t.range.error_m, t.errors.metres[code]);
}

// Errors of all vertices around what has changed: measured where they are small, grown by what the change can add where
// they are not; and at least what their children ask for.
//
// Why growing suffices. Let the ground's heights change by d at each sample, least <= d <= most, 0 among them. Over an
// un-split diamond a sample differed from the surface by at most e. Now the sample has moved by d, and the surface over
// it by a mean of d's at its corners; these differ by at most most - least, so the new difference is at most
// e + (most - least). Codes round up, so they bound it; and each is raised to what its children ask for, from fine to
// coarse, so they nest.
void raise_errors(EditsData& e, const Change& change) {
    TerrainData& t = *e.terrain;
    const Heights heights{t, &e.window};
    const double by_m =
        static_cast<double>(change.most_delta - change.least_delta) * static_cast<double>(t.header.quantum_m);
    const bool midpoint = t.header.estimate == ErrorEstimate::midpoint;
    for (int z = 0; z < t.tree.tile_log2; ++z)
        for (const VertexKind kind : sides_then_centres) {
            const Plane plane{z, kind};
            const int log2 = t.tree.tile_log2 - 1 - z;
            const Rect squares = around(change.places, plane)
                                     .within({0, 0, (t.tree.tiles_x << log2) - (kind == VertexKind::side_y ? 0 : 1),
                                              (t.tree.tiles_y << log2) - (kind == VertexKind::side_x ? 0 : 1)});
            for (std::int32_t j = squares.y0; j <= squares.y1; ++j)
                for (std::int32_t i = squares.x0; i <= squares.x1; ++i) {
                    const SampleIndex v = plane.at(i, j);
                    const Found found = find_record(t, v);
                    if (found.record == nullptr) continue;
                    const Asked asked_for = asked_by_children(t, v);
                    const std::uint32_t before = found.record->error, asked = asked_for.code;
                    const std::int32_t s = 1 << z;
                    const bool affected = change.places.meets({v.column - s, v.row - s, v.column + s, v.row + s});
                    std::uint32_t code = before;
                    if (asked_for.all && affected && (z <= measured_at_once || midpoint)) {
                        const OwnError own = own_error(e, heights, v, asked);
                        code = own.exact ? own.code : std::max(grown_code(t, before, by_m), asked);
                    } else if (affected || !asked_for.all) {
                        code = std::max(grown_code(t, before, by_m), asked);
                    } else {
                        code = std::max(before, asked);
                    }
                    if (code == before) continue;
                    store_code(t, plane, i, j, code);
                    note_error(t, code);
                }
        }
}

void push_area(EditsData& e, const Rect& places, int radii_z) {
    // One that has not begun and is near takes it in.
    for (std::uint32_t i = 0; i < e.area_count; ++i) {
        Area& a = e.areas[i];
        if (a.begun || !a.places.grown(8).meets(places)) continue;
        const Rect both = a.places.with(places);
        if (std::int64_t{both.columns()} * both.rows() >
            2 * (std::int64_t{a.places.columns()} * a.places.rows() + std::int64_t{places.columns()} * places.rows()))
            continue;
        a.places = both;
        a.unmeasured = false;
        a.radii_z = std::min(a.radii_z, radii_z);
        a.radii_done = false;
        return;
    }
    if (e.area_count == e.budget.areas) { // the last two become one
        Area& last = e.areas[e.area_count - 1];
        last = {last.places.with(places), 0, 0, 0, 0, false, false, false, std::min(last.radii_z, radii_z), false};
        return;
    }
    e.areas[e.area_count++] = {places, 0, 0, 0, 0, false, false, false, radii_z, false};
}

Rect piece_at(const Rect& places, std::uint32_t n) {
    if (places.columns() <= piece_side && places.rows() <= piece_side) return n == 0 ? places : Rect{};
    // Blocks lie in one of them.
    const std::int32_t x0 = places.x0 & -piece_side, y0 = places.y0 & -piece_side;
    const auto across = static_cast<std::uint32_t>((places.x1 - x0) / piece_side + 1);
    const std::int32_t x = x0 + static_cast<std::int32_t>(n % across) * piece_side,
                       y = y0 + static_cast<std::int32_t>(n / across) * piece_side;
    return Rect{x, y, x + piece_side - 1, y + piece_side - 1}.within(places);
}

void apply(EditsData& e, const Change& change) {
    TerrainData& t = *e.terrain;
    Window& w = e.window;
    const auto by_m = static_cast<float>(change.most_delta - change.least_delta) * t.header.quantum_m;
    if (by_m > t.editing_m) store_release(t.editing_m, by_m);
    store_release(t.ground_epoch, t.ground_epoch + 1);
    fence_release();
    const Rect& places = change.places;
    for (std::int32_t y = places.y0; y <= places.y1; ++y)
        for (std::int32_t x = places.x0; x <= places.x1; ++x) {
            const std::size_t k = w.index({x, y});
            const std::int32_t to = e.piece.changed[static_cast<std::size_t>(y - e.piece.rect.y0) * piece_side +
                                                    static_cast<std::size_t>(x - e.piece.rect.x0)];
            if (to == w.steps[k]) continue;
            if (t.tree.sample({x, y}) == SampleIndex{x, y}) remember(e, {x, y}, w.steps[k], to);
            w.steps[k] = to;
        }
    for_each_block(t, places, [&](std::int32_t x, std::int32_t y) {
        const std::uint32_t number = block_cell(e, x, y);
        if (number == no_index) return;
        e.blocks[number].low_delta += change.least_delta;
        e.blocks[number].high_delta += change.most_delta;
    });
    GroundRange& r = t.range;
    if (change.low < r.low_steps) {
        store_release(r.low_steps, change.low);
        store_release(r.low_m, std::min(r.low_m, t.height_scale.height_m(change.low)));
    }
    if (change.high > r.high_steps) store_release(r.high_steps, change.high);
    store_release(r.high_m, std::max(r.high_m, t.height_scale.height_m(change.high)));
    write_heights(e, change);
    e.radii_unknown = false;
    (void)nest_radii(e, {t, &w}, places, static_cast<double>(by_m), 0, true);
    raise_errors(e, change);
    fence_release();
    store_release(t.ground_epoch, t.ground_epoch + 1);
    push_change(e, places, true, all_steps);
    push_area(e, places, e.radii_unknown ? 0 : no_radii);
}

} // namespace

bool all_loaded(const TerrainData& t, const Rect& places) {
    bool loaded = true;
    for (int z = 0; z < t.tree.tile_log2 && loaded; ++z)
        for (const VertexKind kind : sides_then_centres) {
            const Plane plane{z, kind};
            std::uint32_t last = no_index;
            for_each_run(t, plane, plane.squares(places), [&](const Run& run) {
                if (run.page == last) return;
                last = run.page;
                loaded = loaded && t.page_table[run.page].slot != no_index;
            });
        }
    return loaded;
}

bool apply_piece(EditsData& e, Waiting& w, Refusal& refusal, std::uint32_t& samples) {
    refusal = Refusal::none;
    Rect rect = piece_at(w.places, w.piece);
    if (rect.empty() && w.checking && w.piece != 0) { // all have been looked at
        const TerrainData& t = *e.terrain;
        if (w.changed.empty()) return true;
        const double quantum_m = t.header.quantum_m;
        const double low_m = std::min<double>(t.range.low_m, t.height_scale.height_m(w.low)),
                     high_m = std::max<double>(t.range.high_m, t.height_scale.height_m(w.high));
        if (w.blocks > e.budget.blocks - e.block_count)
            refusal = Refusal::blocks;
        else if (!spans_fit(e, w))
            refusal = Refusal::span;
        else if (!has_codes(e, w.steepest * quantum_m, high_m - low_m))
            refusal = Refusal::bound;
        if (refusal != Refusal::none) return true;
        w.checking = false;
        w.piece = 0;
        rect = piece_at(w.places, 0);
    }
    if (rect.empty()) return true;
    ++w.piece;
    const bool only = w.places.columns() <= piece_side && w.places.rows() <= piece_side;
    gather(*e.terrain, rect.grown(w.checking && !only ? 2 : window_margin), e.window);
    const Change change = evaluate(e, w.stamp, rect, w.checking);
    if (change.number) {
        refusal = Refusal::number;
        return true;
    }
    if (w.checking) {
        if (change.samples != 0) {
            w.low = w.changed.empty() ? change.low : std::min(w.low, change.low);
            w.high = w.changed.empty() ? change.high : std::max(w.high, change.high);
            w.old_low = w.changed.empty() ? change.old_low : std::min(w.old_low, change.old_low);
            w.old_high = w.changed.empty() ? change.old_high : std::max(w.old_high, change.old_high);
            w.changed = w.changed.with(places_of(e.terrain->tree, change.places));
            w.steepest = std::max(w.steepest, steepest_around(e, change));
            w.blocks += new_blocks(e, change.places);
        }
        return false;
    }
    if (change.samples != 0) apply(e, change);
    samples += static_cast<std::uint32_t>(change.samples);
    return false;
}

namespace {

std::uint32_t first_to_measure(const EditsData& e) {
    std::uint32_t i = 0;
    while (i < e.area_count && e.areas[i].unmeasured) ++i;
    return i;
}

} // namespace

bool has_area_to_measure(const EditsData& e) {
    return first_to_measure(e) != e.area_count;
}

void retry_unmeasured(EditsData& e) {
    if (e.seen_page_changes == e.terrain->changes) return;
    e.seen_page_changes = e.terrain->changes;
    for (std::uint32_t i = 0; i < e.area_count; ++i)
        if (e.areas[i].unmeasured) e.areas[i] = {e.areas[i].places, 0, 0, 0, 0, false, false, false, 0, false};
}

void flush_measured(EditsData& e) {
    if (e.measured.empty()) return;
    push_change(e, e.measured, false, static_cast<std::int8_t>(e.measured_z));
    e.measured = {};
}

namespace {

void note_measured(EditsData& e, SampleIndex v, int z) {
    if (z != e.measured_z) flush_measured(e);
    e.measured_z = z;
    e.measured = e.measured.with({v.column, v.row, v.column, v.row});
}

} // namespace

Measuring measure_item(EditsData& e) {
    TerrainData& t = *e.terrain;
    const std::uint32_t number = first_to_measure(e);
    Area& a = e.areas[number];
    if (a.radii_z != no_radii && !a.radii_done) { // of a page that has come back
        a.radii_done = true;
        e.radii_unknown = false;
        (void)nest_radii(e, {t, nullptr}, a.places, 0, a.radii_z, false);
        a.missed = a.missed || e.radii_unknown;
        return Measuring::item;
    }
    while (a.z < t.tree.tile_log2) {
        const Plane plane{a.z, sides_then_centres[a.plane]};
        const int log2 = t.tree.tile_log2 - 1 - a.z;
        const Rect squares = around(a.places, plane)
                                 .within({0, 0, (t.tree.tiles_x << log2) - (plane.kind == VertexKind::side_y ? 0 : 1),
                                          (t.tree.tiles_y << log2) - (plane.kind == VertexKind::side_x ? 0 : 1)});
        if (!a.begun) {
            a.begun = true;
            a.i = squares.x0, a.j = squares.y0;
        }
        if (squares.empty() || a.j > squares.y1) {
            if (++a.plane == 3) a.plane = 0, ++a.z;
            if (a.z < t.tree.tile_log2) {
                const Plane next{a.z, sides_then_centres[a.plane]};
                const int next_log2 = t.tree.tile_log2 - 1 - a.z;
                const Rect to =
                    around(a.places, next)
                        .within({0, 0, (t.tree.tiles_x << next_log2) - (next.kind == VertexKind::side_y ? 0 : 1),
                                 (t.tree.tiles_y << next_log2) - (next.kind == VertexKind::side_x ? 0 : 1)});
                a.i = to.x0, a.j = to.y0;
            }
            continue;
        }
        const std::int32_t i = a.i, j = a.j;
        if (++a.i > squares.x1) a.i = squares.x0, ++a.j;
        const SampleIndex v = plane.at(i, j);
        const Found found = find_record(t, v);
        if (found.record == nullptr) {
            a.missed = true;
            continue;
        }
        const Asked asked_for = asked_by_children(t, v);
        const std::uint32_t before = found.record->error, asked = asked_for.code;
        if (!asked_for.all) { // it stays as it is, which is a bound
            a.missed = true;
            if (asked > before) {
                store_code(t, plane, i, j, asked);
                note_error(t, asked);
                note_measured(e, v, a.z);
            }
            return Measuring::item;
        }
        const OwnError own = own_error(e, {t, nullptr}, v, asked);
        a.missed = a.missed || !own.exact;
        const std::uint32_t code = own.exact ? own.code : std::min(own.code, std::max(before, asked));
        if (code != before) {
            store_code(t, plane, i, j, std::max(code, asked));
            note_measured(e, v, a.z);
        }
        return Measuring::item;
    }
    const bool missed = a.missed;
    Area done = a;
    std::copy(e.areas + number + 1, e.areas + e.area_count, e.areas + number);
    --e.area_count;
    if (missed) {
        done = {done.places, 0, 0, 0, 0, false, true, false, no_radii, false};
        e.areas[e.area_count++] = done;
    }
    return Measuring::done;
}

// --- pages that come back

namespace {

// Places of a page's vertices in the order that they are decoded in, and its rectangle.
class DecodedPage {
public:
    DecodedPage(const TerrainData& t, std::uint32_t tile, std::uint32_t page)
        : t_(t), page_(page), planar_{t.tree.tile_log2, PageOrder::planar}, in_planar_(page) {
        const SampleIndex place = t.tile_xy(tile);
        origin_ = {place.column * t.tree.side(), place.row * t.tree.side()};
        z_ = t.pages.page_step_log2(page);
        if (z_ < 0) {
            rect_ = {origin_.column, origin_.row, origin_.column + t.tree.side(), origin_.row + t.tree.side()};
            return;
        }
        const SampleIndex at = t.pages.page_position(page);
        in_planar_ = planar_.page_at(z_, static_cast<std::uint32_t>(at.column), static_cast<std::uint32_t>(at.row));
        const std::int32_t side = static_cast<std::int32_t>(2 * page_squares) << z_;
        rect_ = Rect{0, 0, side, side};
        rect_ = {origin_.column + at.column * side, origin_.row + at.row * side,
                 origin_.column + (at.column + 1) * side, origin_.row + (at.row + 1) * side};
    }
    [[nodiscard]] const Rect& rect() const { return rect_; }
    [[nodiscard]] int z() const { // of its finest vertices
        if (z_ >= 0) return z_;
        return t_.pages.order == PageOrder::linear ? 0 : std::max(t_.tree.tile_log2 - page_squares_log2, 0);
    }
    [[nodiscard]] int coarsest_z() const { return z_ < 0 ? t_.tree.tile_log2 - 1 : z_; }
    [[nodiscard]] SampleIndex decoded(std::uint32_t k) const {
        return origin_ +
               (t_.pages.order == PageOrder::linear ? t_.pages.coord({page_, k}) : planar_.coord({in_planar_, k}));
    }
    [[nodiscard]] SampleIndex stored(std::uint32_t k) const { return origin_ + t_.pages.coord({page_, k}); }

private:
    const TerrainData& t_;
    std::uint32_t page_;
    PageLayout planar_;
    std::uint32_t in_planar_;
    SampleIndex origin_;
    int z_ = 0;
    Rect rect_;
};

Rect places_of_block(const TerrainData& t, const Block& b) {
    return places_of(t.tree, {b.x << block_log2, b.y << block_log2, (b.x << block_log2) + block_side - 1,
                              (b.y << block_log2) + block_side - 1});
}

} // namespace

double growth_m(const EditsData& e, const Rect& places) {
    const TerrainData& t = *e.terrain;
    std::int32_t least = 0, most = 0;
    for (std::uint32_t n = 0; n < e.block_count; ++n) {
        if (!places_of_block(t, e.blocks[n]).meets(places)) continue;
        least = std::min(least, e.blocks[n].low_delta);
        most = std::max(most, e.blocks[n].high_delta);
    }
    return (static_cast<double>(most) - least) * static_cast<double>(t.header.quantum_m);
}

bool restore_heights(EditsData& e, std::uint32_t tile, std::uint32_t page, PageArrays& arrays) {
    const TerrainData& t = *e.terrain;
    const DecodedPage at(t, tile, page);
    bool near = false;
    for (std::uint32_t n = 0; n < e.block_count && !near; ++n)
        near = places_of_block(t, e.blocks[n]).grown(radius_reach << at.coarsest_z()).meets(at.rect());
    if (!near) return false;
    const std::uint32_t count = t.pages.page_vertices(page);
    std::int32_t steps[max_page_vertices], low = INT32_MAX, high = INT32_MIN;
    for (std::uint32_t k = 0; k < count; ++k) {
        steps[k] = arrays.base + arrays.heights[k];
        const SampleIndex v = at.decoded(k);
        if ((arrays.radii[k] & void_bit) == 0 && !t.tree.is_corner(v)) {
            const SampleIndex sample = t.tree.sample(v);
            const Block* const b = find_block(e, sample);
            if (b != nullptr && b->edited[in_block(sample)] != as_in_pack)
                steps[k] = b->base + b->edited[in_block(sample)];
        }
        low = std::min(low, steps[k]);
        high = std::max(high, steps[k]);
    }
    if (low < arrays.base || high - arrays.base > 65535) arrays.base = low;
    for (std::uint32_t k = 0; k < count; ++k) arrays.heights[k] = static_cast<std::uint16_t>(steps[k] - arrays.base);
    return true;
}

void restore_bounds(EditsData& e, std::uint32_t tile, std::uint32_t page) {
    TerrainData& t = *e.terrain;
    const DecodedPage at(t, tile, page);
    Rect edited;
    std::int32_t least = 0, most = 0;
    for (std::uint32_t n = 0; n < e.block_count; ++n) {
        const Block& b = e.blocks[n];
        const Rect places = places_of_block(t, b);
        if (!places.grown(radius_reach << at.coarsest_z()).meets(at.rect())) continue;
        edited = edited.with(places);
        least = std::min(least, b.low_delta);
        most = std::max(most, b.high_delta);
    }
    if (edited.empty()) return;
    const double by_m = (static_cast<double>(most) - least) * static_cast<double>(t.header.quantum_m);
    const std::uint32_t slot = t.page_table[std::size_t{tile} * t.pages_per_tile + page].slot,
                        nesting = t.errors.nesting_steps;
    VertexRecord* const to = t.memory->records + std::size_t{slot} * t.page_capacity;
    for (std::uint32_t k = 0; k < t.pages.page_vertices(page); ++k) {
        const SampleIndex v = at.stored(k);
        if (t.tree.is_corner(v)) continue;
        const std::int32_t out = (Tree::kind(v) == VertexKind::centre ? 3 : 2) << Tree::step_log2(v); // as around()
        // By each block, not by the rectangle around them: a vertex near one has parents near it too, in any page.
        const Rect reach{v.column - out, v.row - out, v.column + out, v.row + out};
        bool near = false;
        if (edited.meets(reach))
            for (std::uint32_t n = 0; n < e.block_count && !near; ++n)
                near = places_of_block(t, e.blocks[n]).meets(reach);
        if (!near) continue;
        VertexRecord record = to[k];
        const std::uint32_t below = levels_below(v);
        if (!t.memory->arrays.errors_derived) {
            // As if each level below had grown on its own, and been handed up.
            std::uint32_t code = record.error;
            for (std::uint32_t d = 0; d <= below; ++d) {
                const std::uint32_t of = record.error > d * nesting ? record.error - d * nesting : 0;
                code = std::max(code, grown_code(t, of, by_m) + d * nesting);
                if (of == 0) break;
            }
            record.error = static_cast<std::uint8_t>(std::min(code, 255u));
            note_error(t, record.error);
        }
        const float unit_m = t.header.level_radius_m[t.tree.level(v)];
        const double radius_m = static_cast<double>(unit_m * t.radii.factor[record.radius & (radius_codes - 1)]) +
                                (below + 1) * by_m * (1 + 0x1p-10);
        record.radius = static_cast<std::uint8_t>((record.radius & void_bit) | t.radii.code_up(unit_m, radius_m));
        write_record(to + k, bits_as<std::uint32_t>(record));
    }
    // What is above nests over it again, until all is measured.
    const Rect places = edited.within(at.rect().grown(radius_reach << at.coarsest_z()));
    for (int z = at.z(); z < t.tree.tile_log2; ++z)
        for (const VertexKind kind : sides_then_centres) {
            const Plane plane{z, kind};
            const int log2 = t.tree.tile_log2 - 1 - z;
            const Rect squares = plane.squares(places.grown(radius_reach << z))
                                     .within({0, 0, (t.tree.tiles_x << log2) - (kind == VertexKind::side_y ? 0 : 1),
                                              (t.tree.tiles_y << log2) - (kind == VertexKind::side_x ? 0 : 1)});
            if (!squares.empty()) {
                const SampleIndex first = plane.at(squares.x0, squares.y0), last = plane.at(squares.x1, squares.y1);
                push_change(e, {first.column, first.row, last.column, last.row}, false, static_cast<std::int8_t>(z));
            }
            for (std::int32_t j = squares.y0; j <= squares.y1; ++j)
                for (std::int32_t i = squares.x0; i <= squares.x1; ++i) {
                    const SampleIndex v = plane.at(i, j);
                    const Found found = find_record(t, v);
                    if (found.record == nullptr) continue;
                    const std::uint32_t asked = asked_by_children(t, v).code;
                    if (asked > found.record->error) {
                        store_code(t, plane, i, j, asked);
                        note_error(t, asked);
                    }
                    contain_children(e, plane, i, j);
                }
        }
    push_area(e, places, at.z());
}

} // namespace fjell::edit
