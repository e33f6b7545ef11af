#include "edit/locks.h"

#include <algorithm>

#include "shared/stamp.h"

namespace fjell::edit {

namespace {

// f(x, y) for the blocks that these samples lie in.
template <typename F>
void for_each_block(const Rect& samples, const F& f) {
    if (samples.empty()) return;
    for (std::int32_t y = samples.y0 >> block_log2; y <= samples.y1 >> block_log2; ++y)
        for (std::int32_t x = samples.x0 >> block_log2; x <= samples.x1 >> block_log2; ++x) f(x, y);
}
Rect field_of(const EditsData& e) {
    return {0, 0, e.terrain->tree.columns() - 1, e.terrain->tree.rows() - 1};
}

} // namespace

std::uint8_t least_allowed(const EditsData& e, const Rect& samples) {
    std::uint8_t least = no_lock;
    const Rect all = e.lock_count == 0 ? Rect{} : samples.within(field_of(e));
    if (all.empty()) return least;
    const auto see = [&](const LockBlock& b) {
        const Rect own = block_samples(b.x, b.y), part = own.within(all);
        if (b.least >= least || part.empty()) return;
        if (all.contains(own)) {
            least = b.least;
            return;
        }
        for (std::int32_t y = part.y0; y <= part.y1; ++y) {
            const std::uint8_t* const row = b.allowed + (y - own.y0) * block_side + (part.x0 - own.x0);
            for (std::int32_t k = 0; k < part.columns(); ++k) least = std::min(least, row[k]);
        }
    };
    const std::int64_t looks = (std::int64_t{all.x1 >> block_log2} - (all.x0 >> block_log2) + 1) *
                               ((all.y1 >> block_log2) - (all.y0 >> block_log2) + 1);
    if (looks < e.lock_count)
        for_each_block(all, [&](std::int32_t x, std::int32_t y) {
            if (const LockBlock* const b = e.lock_table.find(e.locks, x, y)) see(*b);
        });
    else
        for (std::uint32_t n = 0; n < e.lock_count && least != 0; ++n) see(e.locks[n]);
    return least;
}

LockAt lock_at(const EditsData& e, SampleIndex v) {
    const std::int32_t s = 1 << Tree::step_log2(v);
    return {least_allowed(e, {v.column - s, v.row - s, v.column + s, v.row + s}),
            e.terrain->errors.always(e.terrain->tree.level(v))};
}

WindowLocks::WindowLocks(const EditsData& e, Window& window) : window_(window) {
    if (e.lock_count == 0) return;
    const Rect all = window.rect.within(field_of(e));
    const auto at = [&](std::int32_t x, std::int32_t y) {
        return window.allowed + static_cast<std::ptrdiff_t>(y - window.rect.y0) * window_side + (x - window.rect.x0);
    };
    for_each_block(all, [&](std::int32_t x, std::int32_t y) {
        const LockBlock* const b = e.lock_table.find(e.locks, x, y);
        if (b == nullptr) return;
        if (!any_) std::fill_n(window.allowed, window_side * window.rect.rows(), no_lock);
        any_ = true;
        const Rect own = block_samples(x, y), part = own.within(all);
        for (std::int32_t row = part.y0; row <= part.y1; ++row)
            std::copy_n(b->allowed + (row - own.y0) * block_side + (part.x0 - own.x0), part.columns(),
                        at(part.x0, row));
    });
    if (any_) widen(1); // squares of a cell
}

// Each square to the north west of four, in place. Those that reach beyond the window stay.
void WindowLocks::widen(std::int32_t by) {
    const std::int32_t columns = window_.rect.columns() - by, rows = window_.rect.rows() - by;
    for (std::int32_t y = 0; y < rows; ++y) {
        std::uint8_t* const row = window_.allowed + y * window_side;
        const std::uint8_t* const below = row + by * window_side;
        for (std::int32_t x = 0; x < columns; ++x) row[x] = std::min(row[x], below[x]);
        for (std::int32_t x = 0; x < columns; ++x) row[x] = std::min(row[x], std::min(row[x + by], below[x + by]));
    }
}

void WindowLocks::begin_step(int z) {
    if (!any_) return;
    for (const std::int32_t step = 1 << z; step_ < step;) {
        step_ = step_ == 0 ? 1 : 2 * step_;
        widen(step_); // to twice the step a side
    }
}

bool has_room_for(const EditsData& e, const Stamp& stamp) {
    if (stamp.shape == StampShape::unlock) return true;
    const StampGrid grid(*e.terrain);
    const Rect samples = samples_of(grid, stamp);
    std::uint32_t left = e.budget.locks - e.lock_count;
    bool fits = true;
    for_each_block(samples, [&](std::int32_t x, std::int32_t y) {
        if (!fits || !may_change(grid, stamp, block_samples(x, y).within(samples)) ||
            e.lock_table.find(e.locks, x, y) != nullptr)
            return;
        fits = left-- != 0;
    });
    return fits;
}

Rect lock_samples(EditsData& e, const Stamp& stamp, const Rect& samples) {
    const StampGrid grid(*e.terrain);
    const bool locks = stamp.shape == StampShape::lock;
    const std::uint8_t allowed = e.terrain->errors.code_down(stamp.amount_m);
    Rect changed;
    for_each_block(samples.within(samples_of(grid, stamp)), [&](std::int32_t x, std::int32_t y) {
        const Rect own = block_samples(x, y), part = own.within(samples).within(samples_of(grid, stamp));
        if (!may_change(grid, stamp, part)) return;
        const std::uint32_t cell = e.lock_table.cell(e.locks, x, y);
        LockBlock* b = e.lock_table.find(e.locks, x, y);
        for (std::int32_t row = part.y0; row <= part.y1; ++row)
            for (std::int32_t column = part.x0; column <= part.x1; ++column) {
                if ((b == nullptr && !locks) || !locks_sample(grid, stamp, {column, row})) continue;
                if (b == nullptr) {
                    e.lock_table.cells[cell] = e.lock_count;
                    b = &e.locks[e.lock_count++];
                    b->x = x, b->y = y;
                    std::fill_n(b->allowed, block_side * block_side, no_lock);
                }
                std::uint8_t& at = b->allowed[(row - own.y0) * block_side + (column - own.x0)];
                const std::uint8_t now = locks ? std::min(at, allowed) : no_lock;
                if (now == at) continue;
                at = now;
                changed = changed.with({column, row, column, row});
            }
        if (b == nullptr) return;
        b->least = *std::min_element(b->allowed, b->allowed + block_side * block_side);
        if (b->least == no_lock) (void)e.lock_table.remove(e.locks, e.lock_count, cell);
    });
    return changed;
}

} // namespace fjell::edit
