#include "edit/blocks.h"

#include "edit/areas.h"
#include "edit/errors.h"
#include "edit/locks.h"
#include "edit/radii.h"
#include "shared/compiler.h"

namespace fjell::edit {

namespace {

const Block* find_block(const EditsData& e, std::int32_t x, std::int32_t y) {
    return e.block_table.find(e.blocks, x, y);
}
std::size_t in_block(SampleIndex sample) {
    return static_cast<std::size_t>(sample.row & (block_side - 1)) * block_side +
           static_cast<std::size_t>(sample.column & (block_side - 1));
}
// The block that holds a sample which has been edited, otherwise null.
const Block* find_edited(const EditsData& e, SampleIndex sample) {
    const Block* const b = find_block(e, sample.column >> block_log2, sample.row >> block_log2);
    return b != nullptr && b->edited[in_block(sample)] != as_in_pack ? b : nullptr;
}

// Values count from another base, so that there is room for one more among them.
FJELL_COLD void rebase(std::int32_t& base, std::uint16_t* values, const std::uint16_t* edited, std::int32_t value) {
    StepRange all{value, value};
    for (std::size_t k = 0; k < block_side * block_side; ++k)
        if (edited[k] != as_in_pack) all.add(base + values[k]);
    const std::int32_t to = all.low - (as_in_pack - 1 - all.span()) / 2; // as much room below as above
    for (std::size_t k = 0; k < block_side * block_side; ++k)
        if (edited[k] != as_in_pack) values[k] = static_cast<std::uint16_t>(base + values[k] - to);
    base = to;
}
// Makes room for a value among those that count from a base; there is, or the stamp would have been refused.
void make_room(std::int32_t& base, std::uint16_t* values, const std::uint16_t* edited, std::int32_t value) {
    if (value < base || value - base >= as_in_pack) rebase(base, values, edited, value);
}

// Gives a block back.
void remove_block(EditsData& e, std::uint32_t cell) {
    const std::uint32_t number = e.block_table.remove(e.blocks, e.block_count, cell);
    if (e.block_holes != nullptr) e.block_holes[number] = e.block_holes[e.block_count];
}

// visit(x, y), in blocks, for the samples that vertices at these places stand at.
template <typename Visit>
void for_each_block(const TerrainData& t, const Rect& places, const Visit& visit) {
    const SampleIndex first = t.tree.sample({places.x0, places.y0}), last = t.tree.sample({places.x1, places.y1});
    for (std::int32_t y = first.row >> block_log2; y <= last.row >> block_log2; ++y)
        for (std::int32_t x = first.column >> block_log2; x <= last.column >> block_log2; ++x) visit(x, y);
}

Rect places_of_block(const TerrainData& t, const Block& b) {
    return places_of(t.tree, {b.x << block_log2, b.y << block_log2, (b.x << block_log2) + block_side - 1,
                              (b.y << block_log2) + block_side - 1});
}

// The cell of the table with a block's number: that of a new one, whose numbers count from around these heights, where
// there was none.
std::uint32_t block_cell_for(EditsData& e, std::int32_t x, std::int32_t y, std::int32_t before, std::int32_t after) {
    const std::uint32_t cell = e.block_table.cell(e.blocks, x, y);
    std::uint32_t& number = e.block_table.cells[cell];
    if (number != no_index) return cell;
    number = e.block_count++;
    Block& b = e.blocks[number];
    b = {};
    b.x = x, b.y = y;
    b.pack_base = before - as_in_pack / 2, b.base = after - as_in_pack / 2;
    std::fill_n(b.edited, block_side * block_side, as_in_pack);
    if (e.block_holes != nullptr) e.block_holes[number] = {};
    return cell;
}
// Of rows of 32 samples.
bool has_bit(const std::uint32_t (&rows)[block_side], std::size_t k) {
    return (rows[k / block_side] >> k % block_side & 1) != 0;
}
void set_bit(std::uint32_t (&rows)[block_side], std::size_t k, bool value) {
    const std::uint32_t bit = std::uint32_t{1} << k % block_side;
    rows[k / block_side] = (rows[k / block_side] & ~bit) | (value ? bit : 0);
}

// Sample k of a block, before and after. holes: the block's, or null.
void remember(Block& b, BlockHoles* holes, std::size_t k, const InPack& before, const InPack& after) {
    if (b.edited[k] == as_in_pack) {
        make_room(b.pack_base, b.pack, b.edited, before.steps);
        b.pack[k] = static_cast<std::uint16_t>(before.steps - b.pack_base);
        if (holes != nullptr) set_bit(holes->pack, k, before.hole), set_bit(holes->edited, k, before.hole);
        ++b.differing;
    }
    bool differs = false;
    if (holes != nullptr) {
        holes->differing -= has_bit(holes->edited, k) != has_bit(holes->pack, k);
        set_bit(holes->edited, k, after.hole);
        differs = after.hole != has_bit(holes->pack, k);
        holes->differing += differs;
    }
    if (after.steps == b.pack_base + b.pack[k] && !differs) {
        b.edited[k] = as_in_pack;
        --b.differing;
        return;
    }
    make_room(b.base, b.edited, b.edited, after.steps);
    b.edited[k] = static_cast<std::uint16_t>(after.steps - b.base);
    const std::int32_t off = after.steps - (b.pack_base + b.pack[k]);
    b.least_off = std::min(b.least_off, off);
    b.most_off = std::max(b.most_off, off);
}

bool fits(const StepRange& r) {
    return r.span() < as_in_pack - 1;
}
bool counts_from(std::int32_t base, const StepRange& r) {
    return r.empty() || (r.low >= base && r.high - base < as_in_pack);
}

} // namespace

void remember(EditsData& e, SampleIndex first, std::int32_t count, const Cell* before, const RowAfter& after) {
    const auto is_same = [&](std::int32_t k) {
        return after.steps[k] == before[k].steps && after.holes[k] == before[k].hole;
    };
    for (std::int32_t k = 0; k < count;) {
        const std::int32_t x = (first.column + k) >> block_log2,
                           end = std::min(count, ((x + 1) << block_log2) - first.column);
        while (k < end && is_same(k)) ++k;
        if (k == end) continue;
        const std::uint32_t cell = block_cell_for(e, x, first.row >> block_log2, before[k].steps, after.steps[k]);
        const std::uint32_t number = e.block_table.cells[cell];
        Block& b = e.blocks[number];
        BlockHoles* const holes = e.block_holes != nullptr ? e.block_holes + number : nullptr;
        for (; k < end; ++k)
            if (!is_same(k))
                remember(b, holes, in_block({first.column + k, first.row}), {before[k].steps, before[k].hole},
                         {after.steps[k], after.holes[k]});
        if (b.differing == 0) remove_block(e, cell);
    }
}

bool find_in_pack(const EditsData& e, SampleIndex sample, InPack& pack) {
    const Block* const b = find_edited(e, sample);
    if (b == nullptr) return false;
    pack.steps = b->pack_base + b->pack[in_block(sample)];
    if (e.block_holes != nullptr) pack.hole = has_bit(e.block_holes[b - e.blocks].pack, in_block(sample));
    return true;
}

bool has_block_at(const EditsData& e, std::int32_t x, std::int32_t y) {
    return find_block(e, x, y) != nullptr;
}

bool spans_fit(const EditsData& e, const Rect& places, const StepRange& heights, const StepRange& pack) {
    const TerrainData& t = *e.terrain;
    bool fit = fits(heights) && fits(pack);
    for_each_block(t, places, [&](std::int32_t x, std::int32_t y) {
        const Block* const b = find_block(e, x, y);
        if (b == nullptr || !fit || (counts_from(b->base, heights) && counts_from(b->pack_base, pack))) return;
        StepRange edited = heights, packed = pack;
        for (std::size_t k = 0; k < block_side * block_side; ++k) {
            if (b->edited[k] == as_in_pack) continue;
            edited.add(b->base + b->edited[k]);
            packed.add(b->pack_base + b->pack[k]);
        }
        fit = fits(edited) && fits(packed);
    });
    for_each_plane(0, t.tree.tile_log2 - 1, [&](const Plane& plane) {
        for_each_page(t, plane, plane.squares(places), [&](std::uint32_t page) {
            const PageEntry entry = t.page_table[page];
            if (!fit || entry.slot == no_index || counts_from(entry.base, heights)) return;
            const VertexRecord* const records = t.records + std::size_t{entry.slot} * t.page_capacity;
            StepRange all = heights;
            for (std::uint32_t k = 0; k < t.pages.page_vertices(page % t.pages_per_tile); ++k)
                all.add(entry.base + records[k].height);
            fit = all.span() <= 65535;
        });
    });
    return fit;
}

std::uint32_t missing_blocks(EditsData& e, const Rect& places) {
    const auto differs = [&](const Rect& samples) {
        for (std::int32_t y = samples.y0; y <= samples.y1; ++y)
            for (std::int32_t x = samples.x0; x <= samples.x1; ++x)
                if (const Cell& now = e.window.at({x, y});
                    e.piece.at({x, y}) != now.steps || e.piece.hole_at({x, y}) != now.hole)
                    return true;
        return false;
    };
    std::uint32_t count = 0;
    for_each_block(*e.terrain, places, [&](std::int32_t x, std::int32_t y) {
        const Rect samples{x << block_log2, y << block_log2, (x << block_log2) + block_side - 1,
                           (y << block_log2) + block_side - 1};
        count += find_block(e, x, y) == nullptr && differs(samples.within(places)) ? 1 : 0;
    });
    return count;
}

bool has_changed_holes(const EditsData& e, const Rect& places) {
    if (e.block_holes == nullptr) return false;
    const TerrainData& t = *e.terrain;
    const Rect r = places.within(grid_of(t.tree));
    bool has = false;
    if (r.empty()) return has;
    if (std::int64_t{r.columns()} * r.rows() < std::int64_t{e.block_count} << 2 * block_log2) {
        for_each_block(t, r, [&](std::int32_t x, std::int32_t y) {
            const Block* const b = has ? nullptr : find_block(e, x, y);
            has = has || (b != nullptr && e.block_holes[b - e.blocks].differing != 0);
        });
        return has;
    }
    for (std::uint32_t n = 0; n < e.block_count && !has; ++n)
        has = e.block_holes[n].differing != 0 && places_of_block(t, e.blocks[n]).meets(r);
    return has;
}

namespace {

// What has been edited where it may matter to a page, or to places.
struct Near {
    Rect places; // around all blocks
    StepRange off{0, 0};
    void add(const TerrainData& t, const Block& b) {
        places = places.with(places_of_block(t, b));
        off.add({b.least_off, b.most_off});
    }
    [[nodiscard]] double by_m(const TerrainData& t) const {
        return off.span() * static_cast<double>(t.header.quantum_m);
    }
};

template <typename IsNear>
Near blocks_near(const EditsData& e, const IsNear& is_near) {
    Near near;
    for (std::uint32_t n = 0; n < e.block_count; ++n)
        if (is_near(places_of_block(*e.terrain, e.blocks[n]))) near.add(*e.terrain, e.blocks[n]);
    return near;
}

// Is any block near? Looks them up where that are fewer than there are.
bool has_block(const EditsData& e, const Rect& places) {
    const TerrainData& t = *e.terrain;
    const Rect r = places.within(grid_of(t.tree));
    if (r.empty()) return false;
    const SampleIndex first = t.tree.sample({r.x0, r.y0}), last = t.tree.sample({r.x1, r.y1});
    const std::int64_t looks = (std::int64_t{last.column >> block_log2} - (first.column >> block_log2) + 1) *
                               ((last.row >> block_log2) - (first.row >> block_log2) + 1);
    bool has = false;
    if (looks < e.block_count)
        for_each_block(t, r, [&](std::int32_t x, std::int32_t y) { has = has || find_block(e, x, y) != nullptr; });
    else
        for (std::uint32_t n = 0; n < e.block_count && !has; ++n) has = places_of_block(t, e.blocks[n]).meets(r);
    return has;
}

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
        rect_ = {origin_.column + at.column * side, origin_.row + at.row * side,
                 origin_.column + (at.column + 1) * side, origin_.row + (at.row + 1) * side};
    }
    // Of its finest and its coarsest vertices.
    [[nodiscard]] int finest() const {
        if (z_ >= 0) return z_;
        return t_.pages.order == PageOrder::linear ? 0 : std::max(t_.tree.tile_log2 - page_squares_log2, 0);
    }
    [[nodiscard]] int coarsest() const { return z_ < 0 ? t_.tree.tile_log2 - 1 : z_; }
    // Do its spheres, or errors, depend on heights at these places?
    [[nodiscard]] bool is_near(const Rect& places) const {
        return places.grown(radius_reach << coarsest()).meets(rect_);
    }
    [[nodiscard]] Rect reach() const { return rect_.grown(radius_reach << coarsest()); }
    // Samples whose locks matter to its vertices, and to those below them.
    [[nodiscard]] Rect locks() const { return rect_.grown(error_reach(VertexKind::centre) << coarsest()); }
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

// Errors and spheres of a page's vertices are the pack's: larger by what its ground may have moved by, where that is
// near.
void grow(const EditsData& e, const DecodedPage& at, std::uint32_t count, const Near& edited, PageArrays& arrays) {
    const TerrainData& t = *e.terrain;
    const double by_m = edited.by_m(t);
    for (std::uint32_t k = 0; k < count; ++k) {
        const SampleIndex v = at.decoded(k);
        if (t.tree.is_corner(v)) continue;
        const std::int32_t out = error_reach(Tree::kind(v)) << Tree::step_log2(v);
        const Rect reach{v.column - out, v.row - out, v.column + out, v.row + out};
        // By each block, not by the rectangle around them: a vertex near one has parents near it too, in any page.
        if (!edited.places.meets(reach) || !has_block(e, reach)) continue;
        if (!arrays.errors_derived) { // otherwise bound_derived(), on those of the edited heights
            const auto by = [&](int) { return by_m; };
            arrays.errors[k] =
                static_cast<std::uint8_t>(std::min(grown_with_descendants(t, v, arrays.errors[k], by), 255u));
            if (has_changed_holes(e, reach)) arrays.errors[k] = std::max(arrays.errors[k], rim_code(e, v));
        }
        const float unit_m = t.header.level_radius_m[t.tree.level(v)];
        const double radius_m = static_cast<double>(unit_m * t.radii.factor[arrays.radii[k] & (radius_codes - 1)]) +
                                (levels_below(v) + 1) * by_m * (1 + 0x1p-10);
        arrays.radii[k] = static_cast<std::uint8_t>((arrays.radii[k] & void_bit) | t.radii.code_up(unit_m, radius_m));
    }
}

// Its own error is not known, but that it is not above its code.
void raise_locked(const EditsData& e, const DecodedPage& at, std::uint32_t count, PageArrays& arrays) {
    if (least_allowed(e, at.locks()) == no_lock) return;
    for (std::uint32_t k = 0; k < count; ++k)
        if (const SampleIndex v = at.decoded(k); arrays.errors[k] != 0 && !e.terrain->tree.is_corner(v))
            arrays.errors[k] = static_cast<std::uint8_t>(lock_at(e, v).raised(arrays.errors[k]));
}

// Places of a page with edits or locks that matter to it.
Rect changed_around(const EditsData& e, const DecodedPage& at, Rect edited) {
    for (std::uint32_t n = 0; n < e.lock_count; ++n) {
        const Rect block = block_samples(e.locks[n].x, e.locks[n].y);
        if (at.locks().meets(block)) edited = edited.with(block);
    }
    return edited;
}

} // namespace

double growth_m(const EditsData& e, const Rect& places) {
    return blocks_near(e, [&](const Rect& block) { return block.meets(places); }).by_m(*e.terrain);
}

bool restore_page(const EditsData& e, std::uint32_t tile, std::uint32_t page, PageArrays& arrays) {
    const TerrainData& t = *e.terrain;
    const DecodedPage at(t, tile, page);
    const Near edited = blocks_near(e, [&](const Rect& block) { return at.is_near(block); });
    const std::uint32_t count = t.pages.page_vertices(page);
    if (edited.places.empty()) {
        if (!arrays.errors_derived) raise_locked(e, at, count, arrays);
        return least_allowed(e, at.locks()) != no_lock;
    }
    std::int32_t steps[max_page_vertices];
    StepRange all;
    for (std::uint32_t k = 0; k < count; ++k) {
        steps[k] = arrays.base + arrays.heights[k];
        const SampleIndex v = at.decoded(k);
        const SampleIndex sample = t.tree.sample(v);
        if (const Block* const b = t.tree.is_corner(v) ? nullptr : find_edited(e, sample)) {
            steps[k] = b->base + b->edited[in_block(sample)];
            if (e.block_holes != nullptr) {
                const bool hole = has_bit(e.block_holes[b - e.blocks].edited, in_block(sample));
                arrays.radii[k] = static_cast<std::uint8_t>((arrays.radii[k] & ~void_bit) | (hole ? void_bit : 0));
            }
        }
        all.add(steps[k]);
    }
    if (all.low < arrays.base || all.high - arrays.base > 65535) arrays.base = all.low;
    for (std::uint32_t k = 0; k < count; ++k) arrays.heights[k] = static_cast<std::uint16_t>(steps[k] - arrays.base);
    grow(e, at, count, edited, arrays);
    if (!arrays.errors_derived) raise_locked(e, at, count, arrays);
    return true;
}

void bound_derived(const EditsData& e, std::uint32_t tile, std::uint32_t page, PageArrays& arrays) {
    const TerrainData& t = *e.terrain;
    const DecodedPage at(t, tile, page);
    const std::uint32_t count = t.pages.page_vertices(page);
    const bool holes = has_changed_holes(e, at.reach());
    for (std::uint32_t k = 0; holes && k < count; ++k) {
        const SampleIndex v = at.decoded(k);
        if (t.tree.is_corner(v)) continue;
        const std::int32_t out = error_reach(Tree::kind(v)) << Tree::step_log2(v);
        if (has_changed_holes(e, {v.column - out, v.row - out, v.column + out, v.row + out}))
            arrays.errors[k] = std::max(arrays.errors[k], rim_code(e, v));
    }
    raise_locked(e, at, count, arrays);
}

void nest_over_page(EditsData& e, std::uint32_t tile, std::uint32_t page) {
    TerrainData& t = *e.terrain;
    const DecodedPage at(t, tile, page);
    const Near edited = blocks_near(e, [&](const Rect& block) { return at.is_near(block); });
    const VertexRecord* const records =
        t.records + std::size_t{t.page_table[std::size_t{tile} * t.pages_per_tile + page].slot} * t.page_capacity;
    for (std::uint32_t k = 0; k < t.pages.page_vertices(page); ++k) note_error(t, records[k].error);
    const Rect places = changed_around(e, at, edited.places).within(at.reach());
    const Ground ground(t, nullptr);
    for_each_plane(at.finest(), t.tree.tile_log2 - 1, [&](const Plane& plane) {
        const Rect squares = plane.squares(places.grown(radius_reach << plane.z)).within(plane.all(t.tree));
        if (!squares.empty()) push_change(e, plane.places(squares), plane.z);
        for (std::int32_t j = squares.y0; j <= squares.y1; ++j)
            for (std::int32_t i = squares.x0; i <= squares.x1; ++i) {
                const SampleIndex v = plane.at(i, j);
                const Cell own = ground.at(v);
                if (!own.loaded) continue;
                const std::uint32_t asked = asked_by_children(ground, v).code;
                if (asked > own.error) ground.set_error(plane, i, j, static_cast<std::uint8_t>(asked));
                note_error(t, std::max<std::uint32_t>(own.error, asked));
                contain_children(e, ground, plane, i, j);
            }
    });
    push_area(e, places, at.finest(), edited.places.empty() ? no_radii : at.finest());
}

} // namespace fjell::edit
