#pragma once

#include <pybind11/pybind11.h>

namespace fjell::python {

// mesh, bake, verify and info into the module.
void add_baking(pybind11::module_& module);
// Terrain and Frame.
void add_terrain(pybind11::module_& module);

} // namespace fjell::python
