// Heights in the caller's memory: an array of any type and strides, such as NumPy's.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fjell::baker {

enum class NumberType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

// rows x columns numbers, row 0 in the north, column 0 in the west, and perhaps which of them are no heights. The
// caller's: it must outlive whoever reads it, and it is read in place. Whoever changes it meanwhile gets the old
// numbers or the new ones, and nothing worse.
struct HeightArray {
    const std::byte* first = nullptr; // of row 0, column 0; of any alignment
    NumberType type = NumberType::float32;
    std::int64_t columns = 0, rows = 0;
    std::ptrdiff_t column_bytes = 0, row_bytes = 0; // from column to column, from row to row; of any sign
    const std::byte* mask = nullptr;                // one byte a sample, not 0: no height; null: there is none
    std::ptrdiff_t mask_column_bytes = 0, mask_row_bytes = 0;

    // `count` numbers of a row from a column on, NaN where the mask says so.
    void read(std::int64_t row, std::int64_t column, std::int64_t count, double* to) const;
    void read(std::int64_t row, std::int64_t column, std::int64_t count, float* to) const;
    // Whole numbers, by their type.
    [[nodiscard]] bool whole() const { return type < NumberType::float32; }
};

} // namespace fjell::baker
