// The groups of a page from what the bulk pass has found in and around it.
#pragma once

#include <algorithm>
#include <type_traits>

#include "cut/bulk.h"

namespace fjell {

// What it has found in one page and around it, put together by rows.
struct BulkMasks {
    // nullptr: nothing was found there.
    const BulkPage *own = nullptr, *north = nullptr, *west = nullptr, *south = nullptr, *east = nullptr;
    bool owns_south = false, owns_east = false; // the terrain ends there
    bool any_side = false;
    std::uint32_t centre[page_squares + 1];  // the first is the row north of the page
    std::uint32_t side_x[page_squares + 1];  // the last is the next page's, unless the terrain ends
    std::uint64_t side_y[page_squares];      // and so is the lane after the last
    std::uint32_t west_centre[page_squares]; // a bit a row: of the column to the west
    // Centres of the finer step: rows -1 to 2n - 1; of the column to the west, a bit a row, rows from 0 on.
    std::uint64_t finer[2 * page_squares + 2];
    std::uint32_t finer_west[2 * page_squares];

    [[nodiscard]] std::uint64_t finer_row(std::int32_t j) const { return finer[j + 1]; }

    void gather(const Pages& pages, const BulkPass& bulk, const BulkSquares& at) {
        own = found_in(bulk, at.slot);
        north = found_at(pages, bulk, at.z, at.i0, at.j0 - 1);
        west = found_at(pages, bulk, at.z, at.i0 - 1, at.j0);
        owns_south = ends_south(pages.grid, at);
        owns_east = ends_east(pages.grid, at);
        south = owns_south ? nullptr : found_at(pages, bulk, at.z, at.i0, at.j0 + at.n);
        east = owns_east ? nullptr : found_at(pages, bulk, at.z, at.i0 + at.n, at.j0);
        if (at.n == static_cast<std::int32_t>(page_squares))
            gather_rows(at, std::integral_constant<std::int32_t, page_squares>()); // vectors, where the number is known
        else
            gather_rows(at, at.n);
    }

    // Once there are sides; without any, no finer centre is active.
    void gather_finer(const Pages& pages, const BulkPass& bulk, const BulkSquares& at) {
        if (at.z == 0 || !any_side) {
            std::fill(std::begin(finer), std::end(finer), std::uint64_t{0});
            std::fill(std::begin(finer_west), std::end(finer_west), 0u);
            return;
        }
        if (2 * at.n >= static_cast<std::int32_t>(page_squares)) // 2 x 2 pages under it, or one
            gather_finer_pages(pages, bulk, at, std::integral_constant<std::int32_t, page_squares>());
        else
            gather_finer_pages(pages, bulk, at, 2 * at.n);
    }

private:
    static constexpr std::uint32_t none[page_squares + 1] = {};

    [[nodiscard]] static const std::uint32_t* rows_of(const BulkPage* page, const BulkSquares& at, VertexKind kind) {
        return page == nullptr ? none : page->active + at.row(kind, 0);
    }

    template <typename Count>
    void gather_rows(const BulkSquares& at, Count n) {
        const std::uint32_t *const
            centres = rows_of(own, at, VertexKind::centre),
            *const wests = rows_of(west, at, VertexKind::centre), *const sides_x = rows_of(own, at, VertexKind::side_x),
            *const sides_y = rows_of(own, at, VertexKind::side_y), *const easts = rows_of(east, at, VertexKind::side_y);
        centre[0] = rows_of(north, at, VertexKind::centre)[n - 1];
        std::uint32_t any_x = 0;
        std::uint64_t any_y = 0;
        for (std::int32_t j = 0; j < n; ++j) {
            centre[j + 1] = centres[j];
            west_centre[j] = wests[j] >> (n - 1) & 1;
            side_x[j] = sides_x[j];
            any_x |= sides_x[j];
        }
        for (std::int32_t j = 0; j < n; ++j) {
            side_y[j] = sides_y[j] | std::uint64_t{easts[j] & 1} << n;
            any_y |= side_y[j];
        }
        if (owns_east) {
            const std::uint32_t column = own->active[at.column()];
            for (std::int32_t j = 0; j < n; ++j) side_y[j] |= std::uint64_t{column >> j & 1} << n;
            any_y |= column;
        }
        side_x[n] = owns_south ? sides_x[n] : rows_of(south, at, VertexKind::side_x)[0];
        any_side = (any_x | any_y | side_x[n]) != 0;
    }

    // n: squares a side of a page of the finer step.
    template <typename Count>
    void gather_finer_pages(const Pages& pages, const BulkPass& bulk, const BulkSquares& at, Count n) {
        const std::int32_t i0 = 2 * at.i0, j0 = 2 * at.j0, side = 2 * at.n / n; // in pages
        const auto centres = [&](std::int32_t i, std::int32_t j) -> const std::uint32_t* {
            if (i < 0 || j < 0) return none;
            const BulkSquares squares = squares_at(pages, at.z - 1, i, j);
            return rows_of(found_in(bulk, squares.slot), squares, VertexKind::centre);
        };
        finer[0] = centres(i0, j0 - 1)[n - 1];
        if (side == 2) finer[0] |= std::uint64_t{centres(i0 + n, j0 - 1)[n - 1]} << n;
        finer[1 + 2 * at.n] = 0; // beyond the page nobody asks, but for the terrain's last row of sides
        for (std::int32_t y = 0; y < side; ++y) {
            const std::uint32_t *const west_of = centres(i0 - 1, j0 + y * n), *const first = centres(i0, j0 + y * n),
                                       *const second = side == 2 ? centres(i0 + n, j0 + y * n) : none;
            std::uint64_t* const rows = finer + 1 + y * n;
            std::uint32_t* const wests = finer_west + y * n;
            for (std::int32_t j = 0; j < n; ++j) {
                rows[j] = first[j] | std::uint64_t{second[j]} << n;
                wests[j] = west_of[j] >> (n - 1) & 1;
            }
        }
    }
};

// Writes all groups of one step of a page, and the slots of their vertices; adds to BulkPage::parents. masks: gathered
// there, finer ones too. A page that is not page 0 has one step, and then all of its groups.
void write_step(Pages& pages, BulkPass& bulk, const Mesh& mesh, const BulkSquares& at, const BulkMasks& masks);

} // namespace fjell
