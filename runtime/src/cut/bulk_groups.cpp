#include "cut/bulk_groups.h"

#include <algorithm>

#include "cut/group_words.h"
#include "cut/slot_grid.h"

namespace fjell {

namespace {

class StepWriter {
public:
    StepWriter(Pages& pages, const BulkPass& bulk, const Mesh& mesh, const BulkSquares& at, const BulkMasks& masks)
        : pages_(pages), bulk_(bulk), slot_(at.slot), page_(bulk.pages[slot_]), taken_(mesh, bulk), at_(at),
          n_(static_cast<std::uint32_t>(at.n)), masks_(masks) {}

    // Returns how many parents are active.
    std::uint32_t step() {
        centres();
        // Children of sides: the finer centres of rows -1 to 2n - 1, those of even columns and those of odd ones.
        split_rows(masks_.finer, 2 * n_ + 1, even_, odd_);
        sides_x();
        sides_y();
        column();
        return parents_;
    }

private:
    // Rows that are other pages', or have nothing that might be active.
    void put_none(std::uint32_t first, std::uint32_t rows) {
        const std::uint32_t words_log2 = at_.step->words_log2;
        GroupState* const groups = pages_.groups + slot_ * max_page_groups + (std::size_t{first} << words_log2);
        std::fill_n(groups, rows << words_log2, GroupState{});
    }

    // Rows of a plane from `first` on. What the rim says of parents that do not exist comes after them.
    void put(std::uint32_t first, std::uint32_t rows, const std::uint32_t* parent0, const std::uint32_t* parent1) {
        const std::uint32_t words_log2 = at_.step->words_log2, *const active = page_.active + first;
        const std::uint32_t group = slot_ * max_page_groups + (first << words_log2);
        write_groups(pages_.groups + group, rows, 1u << words_log2,
                     {active, {parent0, parent1}, {child_[0], child_[1], child_[2], child_[3]}});
        parents_ += count_bits(parent0, rows) + count_bits(parent1, rows);
        put_slots(taken_, {&page_, first, rows}, pages_.vertex_slot + std::size_t{group} * group_lanes,
                  std::size_t{group_lanes} << words_log2);
    }

    void centres() {
        std::uint32_t parents[2][page_squares];
        const std::uint32_t first = at_.row(VertexKind::centre, 0);
        if (!centre_parents(pages_, bulk_, at_, parents)) return put_none(first, n_);
        for (std::uint32_t j = 0; j < n_; ++j) {
            const std::uint32_t active = page_.active[first + j];
            child_[0][j] = active & static_cast<std::uint32_t>(masks_.side_y[j]);
            child_[1][j] = active & static_cast<std::uint32_t>(masks_.side_y[j] >> 1);
            child_[2][j] = active & masks_.side_x[j];
            child_[3][j] = active & masks_.side_x[j + 1];
        }
        put(first, n_, parents[0], parents[1]);
    }
    void sides_x() {
        const std::uint32_t rows = n_ + (masks_.owns_south ? 1 : 0);
        std::uint32_t south[page_squares + 1];
        std::copy_n(masks_.centre + 1, n_, south);
        south[n_] = 0;
        for (std::uint32_t j = 0; j < rows; ++j) { // rows 2j - 1 and 2j
            const bool below = j != n_;
            child_[0][j] = even_[2 * j];
            child_[1][j] = odd_[2 * j];
            child_[2][j] = below ? even_[2 * j + 1] : 0;
            child_[3][j] = below ? odd_[2 * j + 1] : 0;
        }
        const std::uint32_t first = at_.row(VertexKind::side_x, 0);
        put(first, rows, masks_.centre, south);
        if (!masks_.owns_south) put_none(first + n_, 1);
    }
    void sides_y() {
        std::uint32_t west[page_squares];
        const std::uint32_t all = at_.all();
        for (std::uint32_t j = 0; j < n_; ++j) { // rows 2j and 2j + 1
            west[j] = (masks_.centre[j + 1] << 1 | masks_.west_centre[j]) & all;
            child_[0][j] = (odd_[2 * j + 1] << 1 | masks_.finer_west[2 * j]) & all;
            child_[1][j] = even_[2 * j + 1];
            child_[2][j] = (odd_[2 * j + 2] << 1 | masks_.finer_west[2 * j + 1]) & all;
            child_[3][j] = even_[2 * j + 2];
        }
        put(at_.row(VertexKind::side_y, 0), n_, west, masks_.centre + 1);
    }
    // East of the last squares, where the terrain ends: its lanes go south.
    void column() {
        if (!masks_.owns_east) return put_none(at_.column(), 1);
        std::uint32_t west = 0, child[4] = {};
        for (std::uint32_t j = 0; j < n_; ++j) {
            west |= (masks_.centre[j + 1] >> (n_ - 1) & 1) << j;
            for (std::uint32_t south = 0; south < 2; ++south)
                child[2 * south] |= (odd_[2 * j + 1 + south] >> (n_ - 1) & 1) << j;
        }
        for (std::size_t d = 0; d < 4; ++d) child_[d][0] = child[d];
        constexpr std::uint32_t none = 0;
        put(at_.column(), 1, &west, &none);
    }

    Pages& pages_;
    const BulkPass& bulk_;
    const std::uint32_t slot_;
    const BulkPage& page_;
    const BulkSlots taken_;
    const BulkSquares& at_;
    const std::uint32_t n_; // squares a side
    const BulkMasks& masks_;
    std::uint32_t even_[2 * page_squares + 1], odd_[2 * page_squares + 1];
    std::uint32_t child_[4][page_squares + 1];
    std::uint32_t parents_ = 0;
};

} // namespace

void write_step(Pages& pages, BulkPass& bulk, const Mesh& mesh, const BulkSquares& at, const BulkMasks& masks) {
    BulkPage& page = bulk.pages[at.slot];
    page.parents += StepWriter(pages, bulk, mesh, at, masks).step();
    page.has_groups = true;
}

} // namespace fjell
