#include "watched.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "io/stop_flag.h"

namespace fjell::python {

namespace py = pybind11;

namespace {

struct Told {
    std::string stage;
    std::uint64_t done = 0, total = 0;
};

struct Shared {
    std::mutex lock;
    std::condition_variable changed;
    std::optional<Told> told; // what progress has not heard of
    bool finished = false;
    std::exception_ptr error;
    std::atomic<bool> stop{false};
};

void run(const std::function<void(const baker::Progress&)>& work, Shared& shared) {
    const io::StopScope scope(&shared.stop);
    std::exception_ptr error;
    try {
        work([&](const char* stage, std::uint64_t done, std::uint64_t total) {
            io::check_interrupt();
            const std::lock_guard hold(shared.lock);
            shared.told = Told{stage, done, total};
        });
    } catch (...) {
        error = std::current_exception();
    }
    const std::lock_guard hold(shared.lock);
    shared.error = error;
    shared.finished = true;
    shared.changed.notify_one();
}

// What Python has to say: a signal's handler, or progress. Null: nothing.
std::unique_ptr<py::error_already_set> ask_python(const py::object& progress, const std::optional<Told>& told) {
    const py::gil_scoped_acquire gil;
    try {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (told && !progress.is_none()) (void)progress(told->stage, told->done, told->total);
    } catch (const py::error_already_set& raised) {
        return std::make_unique<py::error_already_set>(raised);
    }
    return nullptr;
}

} // namespace

void run_watched(const std::function<void(const baker::Progress&)>& work, const py::object& progress) {
    constexpr std::chrono::milliseconds between_looks{50};
    Shared shared;
    std::unique_ptr<py::error_already_set> raised; // goes with the GIL
    {
        const py::gil_scoped_release without_gil;
        std::thread worker([&] { run(work, shared); });
        for (bool finished = false; !finished;) {
            std::optional<Told> told;
            {
                std::unique_lock hold(shared.lock);
                shared.changed.wait_for(hold, between_looks, [&] { return shared.finished; });
                finished = shared.finished;
                std::swap(told, shared.told);
            }
            if (raised || (finished && !told)) continue;
            raised = ask_python(progress, told);
            if (raised) shared.stop = true;
        }
        worker.join();
    }
    if (raised) throw py::error_already_set(*raised);
    if (shared.error) std::rethrow_exception(shared.error);
}

} // namespace fjell::python
