// What takes long, called from Python: without the GIL, on a thread of its own, so that the calling one can look for
// Ctrl-C and tell progress meanwhile.
#pragma once

#include <functional>

#include <pybind11/pybind11.h>

#include "baker/bake/bake.h"

namespace fjell::python {

// Calls work(report) and returns when it has; report may be called from any thread. progress: called on this thread
// with (stage, done, total) at most every 50 ms, or None. Throws what work throws; and what progress or a signal's
// handler raised, once work has stopped at its next io::check_interrupt(). Called with the GIL.
void run_watched(const std::function<void(const baker::Progress& report)>& work,
                 const pybind11::object& progress = pybind11::none());

// The same with a result.
template <typename Work>
auto watched(const Work& work) {
    std::optional<decltype(work())> result;
    run_watched([&](const baker::Progress&) { result.emplace(work()); });
    return std::move(*result);
}

} // namespace fjell::python
