// NumPy's arrays as heights, and ours as NumPy's, without copying either.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "baker/read/array_source.h"

namespace fjell::python {

// heights: two dimensions, a dtype of NumberType in native byte order; mask: None, or bools of the same shape. Reads
// them in place: both must outlive it. Raises TypeError or ValueError that names the argument.
[[nodiscard]] baker::HeightArray height_array(const pybind11::array& heights, const pybind11::object& mask);

// An array that owns what was a vector, reshaped to `shape`.
template <typename T, typename Element>
pybind11::array_t<T> array_of(std::vector<Element>&& elements, std::vector<pybind11::ssize_t> shape) {
    auto owned = std::make_unique<std::vector<Element>>(std::move(elements));
    const T* const first = reinterpret_cast<const T*>(owned->data());
    const pybind11::capsule owner(owned.get(), [](void* vector) { delete static_cast<std::vector<Element>*>(vector); });
    (void)owned.release();
    return pybind11::array_t<T>(std::move(shape), first, owner);
}

} // namespace fjell::python
