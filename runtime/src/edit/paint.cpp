#include "edit/paint.h"

#include <algorithm>
#include <bit>
#include <thread>

#include "block_layout.h"
#include "shared/compiler.h"

namespace fjell::edit {

static_assert(paint_side == block_side); // block_samples() is of both

namespace {

struct Parts {
    std::size_t blocks, free_numbers, table, end;
    std::uint32_t table_size;
};
Parts parts_of(std::uint32_t blocks) {
    BlockLayout block(sizeof(PaintData));
    Parts p{};
    p.table_size = std::bit_ceil(2 * std::max(blocks, 1u));
    p.blocks = block.place(blocks, sizeof(PaintBlock));
    p.free_numbers = block.place(blocks, sizeof(std::uint32_t));
    p.table = block.place(p.table_size, sizeof(std::uint32_t));
    p.end = block.end();
    return p;
}

std::uint32_t home_of(const PaintData& p, std::int32_t x, std::int32_t y) {
    const std::uint64_t key = static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32 |
                              static_cast<std::uint64_t>(static_cast<std::uint32_t>(y));
    return static_cast<std::uint32_t>(key * 0x9e37'79b9'7f4a'7c15 >> 32) & (p.table_size - 1);
}

// The cell of a block, or the empty one where it would be. A table that changes meanwhile may lead anywhere within it.
std::uint32_t cell_of(const PaintData& p, std::int32_t x, std::int32_t y) {
    std::uint32_t at = home_of(p, x, y);
    for (std::uint32_t looks = 0; looks < p.table_size; ++looks, at = (at + 1) & (p.table_size - 1)) {
        const std::uint32_t number = load_relaxed(p.table[at]);
        if (number == no_index) break;
        const PaintBlock& b = p.blocks[number];
        if (load_relaxed(b.x) == x && load_relaxed(b.y) == y) break;
    }
    return at;
}

const PaintBlock* find_block_of(const void* object, std::int32_t x, std::int32_t y) {
    const PaintData& p = *static_cast<const PaintData*>(object);
    for (std::uint32_t tries = 0;; ++tries) {
        const std::uint32_t before = load_acquire(p.epoch);
        const std::uint32_t number = load_relaxed(p.table[cell_of(p, x, y)]);
        fence_acquire();
        if ((before & 1) == 0 && load_relaxed(p.epoch) == before)
            return number == no_index ? nullptr : &p.blocks[number];
        if (tries > 64) std::this_thread::yield(); // never on the frame's thread, which alone changes it
    }
}

class TableChange {
public:
    explicit TableChange(PaintData& p) : p_(p) {
        store_release(p_.epoch, p_.epoch + 1);
        fence_release();
    }
    ~TableChange() {
        fence_release();
        store_release(p_.epoch, p_.epoch + 1);
    }
    TableChange(const TableChange&) = delete;
    TableChange& operator=(const TableChange&) = delete;

private:
    PaintData& p_;
};

PaintBlock& add_block(PaintData& p, std::int32_t x, std::int32_t y) {
    const TableChange change(p);
    const std::uint32_t number = p.free_numbers[p.capacity - p.count - 1];
    PaintBlock& b = p.blocks[number];
    for (std::uint32_t k = 0; k < paint_words; ++k) {
        store_word_relaxed(&b.colours[k], 0);
        store_word_relaxed(&b.materials[k], 0);
    }
    const std::uint32_t cell = cell_of(p, x, y);
    store_release(b.x, x), store_release(b.y, y);
    store_release(p.table[cell], number);
    store_release(p.count, p.count + 1);
    return b;
}

void remove_block(PaintData& p, std::int32_t x, std::int32_t y) {
    const TableChange change(p);
    const std::uint32_t mask = p.table_size - 1;
    std::uint32_t cell = cell_of(p, x, y);
    const std::uint32_t number = p.table[cell];
    store_release(p.table[cell], no_index);
    for (std::uint32_t at = (cell + 1) & mask; p.table[at] != no_index; at = (at + 1) & mask) {
        const PaintBlock& b = p.blocks[p.table[at]];
        const std::uint32_t home = home_of(p, b.x, b.y);
        if (((at - home) & mask) < ((at - cell) & mask)) continue; // its search begins after the cell
        store_release(p.table[cell], p.table[at]);
        store_release(p.table[at], no_index);
        cell = at;
    }
    store_release(p.count, p.count - 1);
    p.free_numbers[p.capacity - p.count - 1] = number;
}

// Blocks that a stamp may change, in blocks.
struct Reach {
    Rect blocks;
    std::uint32_t across; // groups of 2 x 2
    explicit Reach(const Rect& samples)
        : blocks(samples.empty() ? Rect{}
                                 : Rect{samples.x0 >> paint_log2, samples.y0 >> paint_log2, samples.x1 >> paint_log2,
                                        samples.y1 >> paint_log2}),
          across(blocks.empty() ? 0 : static_cast<std::uint32_t>(blocks.columns() + 1) / 2) {}
    [[nodiscard]] Rect group(std::uint32_t n) const {
        const std::int32_t x = blocks.x0 + 2 * static_cast<std::int32_t>(n % across),
                           y = blocks.y0 + 2 * static_cast<std::int32_t>(n / across);
        return Rect{x, y, x + 1, y + 1}.within(blocks);
    }
    [[nodiscard]] std::uint32_t groups() const {
        return across == 0 ? 0 : across * (static_cast<std::uint32_t>(blocks.rows() + 1) / 2);
    }
};

// Has the budget room for all blocks that a stamp may need?
bool has_room(const PaintData& p, const StampGrid& grid, const Stamp& stamp, const Reach& reach) {
    if (stamp.shape == StampShape::unpaint) return true;
    std::uint32_t left = p.capacity - p.count;
    for (std::int32_t y = reach.blocks.y0; y <= reach.blocks.y1; ++y)
        for (std::int32_t x = reach.blocks.x0; x <= reach.blocks.x1; ++x) {
            if (!may_change(grid, stamp, block_samples(x, y)) || find_block_of(&p, x, y) != nullptr) continue;
            if (left-- == 0) return false;
        }
    return true;
}

// Of a group; what has changed, in samples.
Rect paint_group(PaintData& p, const StampGrid& grid, const Stamp& stamp, const Rect& group, const Rect& samples) {
    Rect changed;
    for (std::int32_t y = group.y0; y <= group.y1; ++y)
        for (std::int32_t x = group.x0; x <= group.x1; ++x) {
            const Rect own = block_samples(x, y);
            if (!may_change(grid, stamp, own)) continue;
            const std::uint32_t number = p.table[cell_of(p, x, y)];
            if (number == no_index && stamp.shape == StampShape::unpaint) continue;
            PaintBlock& b = number == no_index ? add_block(p, x, y) : p.blocks[number];
            if (paint_block(grid, stamp, b)) changed = changed.with(own.within(samples));
            if ((number == no_index || stamp.shape == StampShape::unpaint) && is_blank(b)) remove_block(p, x, y);
        }
    return changed;
}

} // namespace

std::size_t paint_bytes_of(std::uint32_t blocks) {
    return parts_of(blocks).end;
}

PaintData* make_paint(const PackHeader& header, std::uint32_t blocks, std::byte* memory) {
    const Parts at = parts_of(blocks);
    PaintData& p = *new (memory) PaintData{};
    p.header = header;
    p.capacity = blocks;
    p.blocks = reinterpret_cast<PaintBlock*>(memory + at.blocks);
    p.free_numbers = reinterpret_cast<std::uint32_t*>(memory + at.free_numbers);
    p.table = reinterpret_cast<std::uint32_t*>(memory + at.table);
    p.table_size = at.table_size;
    std::fill_n(p.table, p.table_size, no_index);
    for (std::uint32_t i = 0; i < blocks; ++i) p.free_numbers[i] = blocks - 1 - i;
    return &p;
}

void copy_block(const PaintBlock& from, PaintData& to) {
    add_block(to, from.x, from.y) = from;
}

PaintSource source_of(const PaintData& paint) {
    return {&paint, find_block_of};
}

PaintGrid grid_of_mip(const PackHeader& h, MapKind map, std::uint32_t tile, std::uint32_t side_log2) {
    const SampleIndex place{static_cast<std::int32_t>(tile % h.tiles_x), static_cast<std::int32_t>(tile / h.tiles_x)};
    return {h,
            map == MapKind::splat ? h.splat_log2 : h.colour_log2,
            side_log2,
            {place.column << h.tile_log2, place.row << h.tile_log2}};
}

bool paint_mip(const PaintData& paint, MapKind map, std::uint32_t tile, std::uint32_t side_log2, const MapRect& at,
               std::byte* blocks) {
    if (load_relaxed(paint.count) == 0 || at.columns == 0) return false;
    const PaintGrid grid = grid_of_mip(paint.header, map, tile, side_log2);
    const std::uint32_t side = 1u << side_log2;
    return map == MapKind::splat ? paint_splat(source_of(paint), grid, side, at, blocks)
                                 : paint_colours(source_of(paint), grid, side, at, blocks);
}

bool paint_piece(EditsData& e, Waiting& w, Refusal& refusal) {
    refusal = Refusal::none;
    if (e.paint == nullptr) {
        refusal = Refusal::no_maps;
        return true;
    }
    PaintData& p = *e.paint;
    const StampGrid grid(*e.terrain);
    const Rect samples = samples_of(grid, w.stamp);
    const Reach reach(samples);
    if (!w.fits) {
        if (!has_room(p, grid, w.stamp, reach)) {
            refusal = Refusal::paint;
            return true;
        }
        w.fits = true;
        w.piece = 0;
    }
    // The next group that it may change, and not yet the one after it.
    for (const std::uint32_t groups = reach.groups(); w.piece < groups;) {
        const Rect group = reach.group(w.piece++);
        const Rect own = block_samples(group.x0, group.y0).with(block_samples(group.x1, group.y1));
        if (!may_change(grid, w.stamp, own)) continue;
        if (const Rect changed = paint_group(p, grid, w.stamp, group, samples); !changed.empty())
            p.changed[p.changes++ % paint_change_log] = changed;
        return w.piece == groups;
    }
    return true;
}

} // namespace fjell::edit
