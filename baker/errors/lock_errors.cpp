#include "baker/errors/lock_errors.h"

#include <algorithm>
#include <vector>

namespace fjell::baker {

namespace {

LockCodes stricter(LockCodes a, LockCodes b) {
    return {std::min(a.allowed, b.allowed), std::max(a.raise, b.raise)};
}

// What holds somewhere in squares of side 2^z, their borders included.
struct LockedSquares {
    SampleIndex first; // counted in squares
    std::int32_t columns = 0, rows = 0;
    std::vector<LockCodes> codes;

    [[nodiscard]] LockCodes at(std::int32_t x, std::int32_t y) const { // any beyond
        x -= first.column, y -= first.row;
        if (x < 0 || y < 0 || x >= columns || y >= rows) return {};
        return codes[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)];
    }
    [[nodiscard]] LockCodes of_four(std::int32_t x, std::int32_t y) const { // with those to the south and east
        return stricter(stricter(at(x, y), at(x + 1, y)), stricter(at(x, y + 1), at(x + 1, y + 1)));
    }
};

// Of samples to squares of one cell, or of squares to those of twice their side.
LockedSquares merged(const LockedSquares& from, SampleIndex first, std::int32_t columns, std::int32_t rows,
                     std::int32_t step) {
    LockedSquares to{first, columns, rows, {}};
    to.codes.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    for (std::int32_t y = first.row; y < first.row + rows; ++y)
        for (std::int32_t x = first.column; x < first.column + columns; ++x)
            to.codes.push_back(from.of_four(x * step, y * step));
    return to;
}

std::uint8_t with_locks(std::uint8_t code, LockCodes codes, std::uint8_t always) {
    const int counted = code == 0 ? 0 : std::min(code + codes.raise, 255); // which choose_scales() has left room for
    return code > codes.allowed ? std::max(static_cast<std::uint8_t>(counted), always)
                                : static_cast<std::uint8_t>(counted);
}

} // namespace

void raise_locked(const LockedRegion& in, VertexPlanes<std::uint8_t>& finest, Patch<std::uint8_t>* coarser) {
    const Region& r = in.region;
    const std::int32_t columns = r.last.column - r.first.column, rows = r.last.row - r.first.row;
    // One sample around it: both regions beside a border say the same of its finest vertices.
    const Window window{r.first.column - 1, r.first.row - 1, columns + 3, rows + 3};
    LockedSquares squares{{window.x, window.y}, window.columns, window.rows, in.locks.over(window, in.scales.errors)};
    if (squares.codes.empty()) return;
    squares = merged(squares, {window.x, window.y}, columns + 2, rows + 2, 1);

    const int leaves = 2 * in.tree.tile_log2 - 1; // the level of the finest sides
    const auto raise = [&](std::uint8_t& code, SampleIndex v, int z, bool centre) {
        const LockCodes codes = squares.of_four((v.column >> z) - 1, (v.row >> z) - 1);
        code = with_locks(code, codes, static_cast<std::uint8_t>(in.scales.errors.always(leaves - 2 * z - centre)));
    };
    for (std::int32_t j = 0; j <= rows / 2; ++j) {
        const std::int32_t y = r.first.row + 2 * j;
        for (std::int32_t i = 0; i <= columns / 2; ++i) {
            const std::int32_t x = r.first.column + 2 * i;
            if (i < columns / 2) raise(finest.side_x.row(j)[i], {x + 1, y}, 0, false);
            if (j < rows / 2) raise(finest.side_y.row(j)[i], {x, y + 1}, 0, false);
            if (i < columns / 2 && j < rows / 2) raise(finest.centre.row(j)[i], {x + 1, y + 1}, 0, true);
        }
    }
    if (!coarser) return;
    // From here on inside only, as errors are measured: the larger one of both regions counts.
    LockedSquares inside{r.first, columns, rows, {}};
    for (std::int32_t y = r.first.row; y < r.last.row; ++y)
        for (std::int32_t x = r.first.column; x < r.last.column; ++x) inside.codes.push_back(squares.at(x, y));
    squares = std::move(inside);
    for (int z = 1; z < in.tree.tile_log2; ++z) {
        squares = merged(squares, {r.first.column >> z, r.first.row >> z}, columns >> z, rows >> z, 2);
        const std::int32_t s = 1 << z;
        for (std::int32_t y = r.first.row; y <= r.last.row; y += s)
            for (std::int32_t x = r.first.column; x <= r.last.column; x += s) {
                const bool odd_x = (x >> z) & 1, odd_y = (y >> z) & 1;
                if (odd_x || odd_y) raise(*coarser->at(x / 2, y / 2), {x, y}, z, odd_x && odd_y);
            }
    }
}

std::uint64_t always_drawn(const StepInput& step) {
    const int side_level = 2 * (step.tree.tile_log2 - 1 - step.z) + 1;
    const auto count = [&](const VertexPlane<std::uint8_t>& plane, int level) {
        const std::uint32_t least = step.scales.errors.always(level);
        std::uint64_t all = 0;
        for (std::int32_t j = 0; j < step.ny; ++j)
            for (std::int32_t i = 0; i < step.nx; ++i) all += plane.row(j)[i] >= least;
        return all;
    };
    return count(step.error.side_x, side_level) + count(step.error.side_y, side_level) +
           count(step.error.centre, side_level - 1);
}

} // namespace fjell::baker
