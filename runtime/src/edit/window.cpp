#include "edit/window.h"

#include <algorithm>
#include <iterator>

namespace fjell::edit {

Cell Ground::beyond(SampleIndex v) const {
    const Cell cell = cell_at(terrain, v);
    if (!cell.loaded && missing != nullptr) missing->note(v);
    return cell;
}

void read(const TerrainData& t, const Rect& rect, Window& window) {
    window.rect = rect.within(grid_of(t.tree));
    const bool all_loaded = t.pages_missing == 0;
    if (!all_loaded)
        for (std::int32_t y = window.rect.y0; y <= window.rect.y1; ++y)
            std::fill_n(&window.at({window.rect.x0, y}), window.rect.columns(), Cell{});
    window.loaded = true;
    std::fill(std::begin(window.written), std::end(window.written), Rect{});
    for_each_plane(0, t.tree.tile_log2 - 1, [&](const Plane& plane) {
        for_each_run(t, plane, plane.squares(window.rect), [&](const Run& run) {
            const PageEntry entry = t.page_table[run.page];
            if (entry.slot == no_index) {
                window.loaded = false;
                return;
            }
            const VertexRecord* const from = t.records + std::size_t{entry.slot} * t.page_capacity + run.index;
            Cell* const to = &window.at(plane.at(run.i, run.j));
            for (std::int32_t k = 0; k < run.count; ++k)
                to[static_cast<std::ptrdiff_t>(k) << (plane.z + 1)] = cell_of(entry.base, from[k]);
        });
    });
    for_each_corner(t, window.rect, [&](SampleIndex at, std::uint32_t) { window.at(at) = cell_at(t, at); });
    look_for_holes(t, window);
}

void look_for_holes(const TerrainData& t, Window& window) {
    window.complete = window.loaded;
    for (std::int32_t y = window.rect.y0; t.has_voids() && window.complete && y <= window.rect.y1; ++y) {
        const Cell* const row = &window.at({window.rect.x0, y});
        bool hole = false; // or-ed together: nothing ends the loop
        for (std::int32_t k = 0; k < window.rect.columns(); ++k) hole |= row[k].hole;
        window.complete = !hole;
    }
}

namespace {

// So that its vertices and these heights count from it in 16 bits. Readers of other threads find the page missing
// meanwhile (pack/publish.h).
void rebase_page(const TerrainData& t, std::uint32_t page, StepRange all) {
    TerrainMemory& m = *t.memory;
    PageEntry& entry = m.page_table[page];
    const PageEntry old = entry;
    VertexRecord* const records = m.records + std::size_t{old.slot} * t.page_capacity;
    const std::uint32_t count = t.pages.page_vertices(page % t.pages_per_tile);
    for (std::uint32_t k = 0; k < count; ++k) all.add(old.base + records[k].height);
    const std::int32_t base = all.low - (65535 - all.span()) / 2; // as much room below as above
    publish_entry(entry, {no_index, 0});
    begin_slot(m.slot_loads[old.slot]);
    for (std::uint32_t k = 0; k < count; ++k) {
        VertexRecord record = records[k];
        record.height = static_cast<std::uint16_t>(old.base + record.height - base);
        write_record(records + k, bits_as<std::uint32_t>(record));
    }
    publish_entry(entry, {old.slot, base});
}

} // namespace

void write_back(const TerrainData& t, Window& window, const StepRange& heights) {
    TerrainMemory& m = *t.memory;
    for_each_plane(0, t.tree.tile_log2 - 1, [&](const Plane& plane) {
        if (window.written[plane.z].empty()) return;
        for_each_run(t, plane, plane.squares(window.written[plane.z].within(window.rect)), [&](const Run& run) {
            PageEntry entry = t.page_table[run.page];
            if (entry.slot == no_index) return;
            const Cell* const from = &window.at(plane.at(run.i, run.j));
            VertexRecord* const to = m.records + std::size_t{entry.slot} * t.page_capacity + run.index;
            for (std::int32_t k = 0; k < run.count; ++k) {
                const Cell& cell = from[static_cast<std::ptrdiff_t>(k) << (plane.z + 1)];
                if (cell.steps < entry.base || cell.steps - entry.base > 65535) {
                    rebase_page(t, run.page, heights);
                    entry = t.page_table[run.page];
                }
                const VertexRecord old = to[k],
                                   record{static_cast<std::uint16_t>(cell.steps - entry.base), cell.error,
                                          static_cast<std::uint8_t>(cell.radius | (cell.hole ? void_bit : 0))};
                if (bits_as<std::uint32_t>(record) != bits_as<std::uint32_t>(old))
                    write_record(to + k, bits_as<std::uint32_t>(record));
            }
        });
    });
    for_each_corner(t, window.rect, [&](SampleIndex at, std::uint32_t number) {
        std::uint32_t& corner = m.corners[number];
        const Cell& cell = window.at(at);
        const std::uint32_t stored =
            (static_cast<std::uint32_t>(cell.steps) & ~corner_void_bit) | (cell.hole ? corner_void_bit : 0);
        if (stored != corner) store_word_relaxed(&corner, stored);
    });
}

} // namespace fjell::edit
