#include "baker/read/height_array.h"

#include <cstring>
#include <limits>

namespace fjell::baker {

namespace {

template <typename From, typename To>
void read_as(const std::byte* from, std::ptrdiff_t step, std::int64_t count, To* to) {
    for (std::int64_t i = 0; i < count; ++i, from += step) {
        From number;
        std::memcpy(&number, from, sizeof number);
        to[i] = static_cast<To>(number);
    }
}

template <typename To>
void read_row(const HeightArray& a, std::int64_t row, std::int64_t column, std::int64_t count, To* to) {
    const std::byte* const from = a.first + row * a.row_bytes + column * a.column_bytes;
    const std::ptrdiff_t step = a.column_bytes;
    switch (a.type) {
    case NumberType::int8: read_as<std::int8_t>(from, step, count, to); break;
    case NumberType::uint8: read_as<std::uint8_t>(from, step, count, to); break;
    case NumberType::int16: read_as<std::int16_t>(from, step, count, to); break;
    case NumberType::uint16: read_as<std::uint16_t>(from, step, count, to); break;
    case NumberType::int32: read_as<std::int32_t>(from, step, count, to); break;
    case NumberType::uint32: read_as<std::uint32_t>(from, step, count, to); break;
    case NumberType::int64: read_as<std::int64_t>(from, step, count, to); break;
    case NumberType::uint64: read_as<std::uint64_t>(from, step, count, to); break;
    case NumberType::float32: read_as<float>(from, step, count, to); break;
    case NumberType::float64: read_as<double>(from, step, count, to); break;
    }
    if (!a.mask) return;
    const std::byte* masked = a.mask + row * a.mask_row_bytes + column * a.mask_column_bytes;
    for (std::int64_t i = 0; i < count; ++i, masked += a.mask_column_bytes)
        if (*masked != std::byte{0}) to[i] = std::numeric_limits<To>::quiet_NaN();
}

} // namespace

void HeightArray::read(std::int64_t row, std::int64_t column, std::int64_t count, double* to) const {
    read_row(*this, row, column, count, to);
}
void HeightArray::read(std::int64_t row, std::int64_t column, std::int64_t count, float* to) const {
    read_row(*this, row, column, count, to);
}

} // namespace fjell::baker
