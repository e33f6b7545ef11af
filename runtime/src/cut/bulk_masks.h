// What the bulk pass has found in one page and around it, put together by rows.
#pragma once

#include "cut/bulk.h"

namespace fjell {

struct BulkMasks {
    // nullptr: nothing was found there.
    const BulkPage *own = nullptr, *north = nullptr, *west = nullptr, *south = nullptr, *east = nullptr;
    bool owns_south = false, owns_east = false; // the terrain ends there
    bool any_side = false;
    std::uint32_t centre[page_squares + 1]; // the first is the row north of the page
    std::uint32_t side_x[page_squares + 1]; // the last is the next page's, unless the terrain ends
    std::uint64_t side_y[page_squares];     // and so is the lane after the last
    // Centres of the finer step: rows -1 to 2n - 1; of the column to the west, a bit a row from 0 on.
    std::uint64_t finer[2 * page_squares + 2];
    std::uint64_t finer_west = 0;

    [[nodiscard]] std::uint64_t finer_row(std::int32_t j) const { return finer[j + 1]; }
    [[nodiscard]] std::uint64_t finer_west_of(std::int32_t j) const { return finer_west >> j & 1; }
    [[nodiscard]] std::uint32_t west_centre(const BulkSquares& at, std::int32_t j) const {
        return west == nullptr ? 0 : west->active[at.row(VertexKind::centre, j)] >> (at.n - 1) & 1;
    }

    void gather(const CutState& s, const BulkSquares& at) {
        own = found_in(s, at.slot);
        north = found_at(s, at.z, at.i0, at.j0 - 1);
        west = found_at(s, at.z, at.i0 - 1, at.j0);
        owns_south = ends_south(s, at);
        owns_east = ends_east(s, at);
        south = owns_south ? nullptr : found_at(s, at.z, at.i0, at.j0 + at.n);
        east = owns_east ? nullptr : found_at(s, at.z, at.i0 + at.n, at.j0);
        const auto row = [&](const BulkPage* page, VertexKind kind, std::int32_t j) -> std::uint32_t {
            return page == nullptr ? 0 : page->active[at.row(kind, j)];
        };
        centre[0] = row(north, VertexKind::centre, at.n - 1);
        std::uint64_t any = 0;
        const std::uint32_t column = owns_east ? own->active[at.column()] : 0;
        for (std::int32_t j = 0; j < at.n; ++j) {
            centre[j + 1] = row(own, VertexKind::centre, j);
            side_x[j] = row(own, VertexKind::side_x, j);
            const std::uint64_t last = (owns_east ? column >> j : row(east, VertexKind::side_y, j)) & 1;
            side_y[j] = row(own, VertexKind::side_y, j) | last << at.n;
            any |= side_x[j] | side_y[j];
        }
        side_x[at.n] = owns_south ? row(own, VertexKind::side_x, at.n) : row(south, VertexKind::side_x, 0);
        any_side = (any | side_x[at.n]) != 0;
        for (std::uint64_t& bits : finer) bits = 0;
        finer_west = 0;
    }

    void gather_finer(const CutState& s, const BulkSquares& at) {
        if (at.z == 0) return;
        const std::int32_t n = 1 << s.steps[at.z - 1].page_log2, i0 = 2 * at.i0, j0 = 2 * at.j0;
        const std::int32_t pages = 2 * at.n / n; // a side
        const auto rows = [&](std::int32_t i, std::int32_t j, const auto& take) {
            if (i < 0 || j < 0) return;
            const BulkSquares squares = squares_at(s, at.z - 1, i, j);
            const BulkPage* const page = found_in(s, squares.slot);
            if (page != nullptr) take(page->active + squares.row(VertexKind::centre, 0));
        };
        for (std::int32_t x = 0; x < pages; ++x) {
            rows(i0 + x * n, j0 - 1, [&](const std::uint32_t* of) { finer[0] |= std::uint64_t{of[n - 1]} << (x * n); });
            for (std::int32_t y = 0; y < pages; ++y)
                rows(i0 + x * n, j0 + y * n, [&](const std::uint32_t* of) {
                    for (std::int32_t j = 0; j < n; ++j) finer[1 + y * n + j] |= std::uint64_t{of[j]} << (x * n);
                });
        }
        for (std::int32_t y = 0; y < pages; ++y)
            rows(i0 - 1, j0 + y * n, [&](const std::uint32_t* of) {
                for (std::int32_t j = 0; j < n; ++j) finer_west |= std::uint64_t{of[j] >> (n - 1) & 1} << (y * n + j);
            });
    }
};

} // namespace fjell
