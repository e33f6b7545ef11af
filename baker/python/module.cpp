// The native half of the package `fjell`: calls with plain arguments, which the Python files beside it make pleasant.
#include <pybind11/pybind11.h>

#include "baking.h"
#include "fjell/io/failure.h"
#include "fjell/version.h"

namespace py = pybind11;

PYBIND11_MODULE(_native, module) {
    py::register_exception_translator([](std::exception_ptr thrown) {
        try {
            if (thrown) std::rethrow_exception(thrown);
        } catch (const fjell::io::Failure& failure) {
            // 1 the input is at fault, 2 the arguments; 3 the machine.
            PyErr_SetString(failure.exit_code == 3 ? PyExc_OSError : PyExc_ValueError, failure.what());
        }
    });
    fjell::python::add_baking(module);
    fjell::python::add_terrain(module);
    module.attr("version") = FJELL_VERSION_STRING;
}
