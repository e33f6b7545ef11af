// How wet ground is where only its shape counts: the topographic wetness index ln(a / tan b), where a is the area that
// drains through a metre of contour and b the slope (K. Beven and M. Kirkby, 1979). About 4 on ridges, 8 on slopes and
// 12 and more in valleys.
//
// Water runs over the whole terrain, so this alone of all that rules ask for cannot be made from a window. It is found
// on one coarse grid of bounded size, means of whole squares of samples, and interpolated. Depressions are filled first
// (R. Barnes and others, Priority-Flood, 2014, with a small rise so that filled ground drains), then each cell hands
// its water to all lower neighbours by slope (T. Freeman, 1991, exponent 1.1). Units: metres. Complexity: O(samples +
// cells log cells). Thread: one; immutable once made.
#pragma once

#include <cstdint>
#include <vector>

namespace fjell::baker {

inline constexpr std::int32_t max_wetness_cells = 1024; // a side of the grid

// Cell (x, y) covers samples [x << factor_log2, (x + 1) << factor_log2).
struct WetnessGrid {
    std::int32_t columns = 0, rows = 0;
    int factor_log2 = 0;
    double spacing_m[2] = {1, 1}; // of cells
};
// sample_columns, sample_rows: of the terrain; spacing_m: of its samples.
[[nodiscard]] WetnessGrid wetness_grid(std::int32_t sample_columns, std::int32_t sample_rows,
                                       const double (&spacing_m)[2]);

class Wetness {
public:
    // heights_m: of the cells, row by row, finite.
    Wetness(const WetnessGrid& grid, std::vector<float> heights_m);
    // As found before: what index() said.
    [[nodiscard]] static Wetness found(const WetnessGrid& grid, std::vector<float> index);
    [[nodiscard]] const std::vector<float>& index() const { return index_; }
    // At a sample, interpolated between the centres of cells.
    [[nodiscard]] float at(std::int32_t column, std::int32_t row) const;
    [[nodiscard]] float of_cell(std::int32_t x, std::int32_t y) const {
        return index_[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.columns) +
                      static_cast<std::size_t>(x)];
    }

private:
    Wetness() = default;
    WetnessGrid grid_;
    std::vector<float> index_;
};

} // namespace fjell::baker
