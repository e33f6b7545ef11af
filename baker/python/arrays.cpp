#include "arrays.h"

#include <string>

namespace fjell::python {

namespace py = pybind11;
using baker::NumberType;

namespace {

NumberType type_of(const py::array& heights) {
    const py::dtype type = heights.dtype();
    const auto bytes = type.itemsize();
    const bool native = type.byteorder() != '>';
    if (native && type.kind() == 'b') return NumberType::uint8;
    if (native && type.kind() == 'f' && bytes == 4) return NumberType::float32;
    if (native && type.kind() == 'f' && bytes == 8) return NumberType::float64;
    if (native && (type.kind() == 'i' || type.kind() == 'u'))
        for (int log2 = 0; log2 < 4; ++log2)
            if (bytes == py::ssize_t{1} << log2)
                return static_cast<NumberType>(2 * log2 + (type.kind() == 'u' ? 1 : 0));
    throw py::type_error("heights: has dtype " + std::string(py::str(static_cast<const py::handle&>(type))) +
                         "; give whole numbers or floats of 32 or 64 bits");
}
static_assert(static_cast<int>(NumberType::uint64) == 7, "types of whole numbers are in pairs, by their size");

} // namespace

baker::HeightArray height_array(const py::array& heights, const py::object& mask) {
    if (heights.ndim() != 2)
        throw py::value_error("heights: has " + std::to_string(heights.ndim()) +
                              " dimensions; give two, rows and columns");
    baker::HeightArray array;
    array.first = static_cast<const std::byte*>(heights.data());
    array.type = type_of(heights);
    array.rows = heights.shape(0), array.columns = heights.shape(1);
    array.row_bytes = heights.strides(0), array.column_bytes = heights.strides(1);
    if (mask.is_none()) return array;
    const auto marks = py::array::ensure(mask);
    if (!marks || marks.dtype().kind() != 'b' || marks.ndim() != 2 || marks.shape(0) != array.rows ||
        marks.shape(1) != array.columns)
        throw py::value_error("mask: give bools of the shape of heights");
    array.mask = static_cast<const std::byte*>(marks.data());
    array.mask_row_bytes = marks.strides(0), array.mask_column_bytes = marks.strides(1);
    return array;
}

} // namespace fjell::python
