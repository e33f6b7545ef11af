// A loop over independent items on several threads. The result must not depend on who does what: items only write their
// own places.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "fjell/io/failure.h"
#include "io/stop_flag.h"

namespace fjell::baker {

[[nodiscard]] inline int resolve_threads(int asked) {
    return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// Calls body(i) for i in [0, count). The first exception stops the loop and is rethrown here.
template <typename Body>
void parallel_for(std::int64_t count, int threads, const Body& body) {
    const auto workers = static_cast<int>(std::min<std::int64_t>(threads, count));
    if (workers <= 1) {
        for (std::int64_t i = 0; i < count; ++i) {
            io::check_interrupt();
            body(i);
        }
        return;
    }
    std::atomic<std::int64_t> next{0};
    std::exception_ptr error;
    std::mutex error_lock;
    const auto work = [&, stop = io::stop_flag()] {
        const io::StopScope scope(stop);
        try {
            for (std::int64_t i = next++; i < count; i = next++) {
                io::check_interrupt();
                body(i);
            }
        } catch (...) {
            const std::lock_guard hold(error_lock);
            if (!error) error = std::current_exception();
            next = count;
        }
    };
    std::vector<std::thread> pool;
    pool.reserve(static_cast<std::size_t>(workers));
    try {
        for (int t = 1; t < workers; ++t) pool.emplace_back(work);
    } catch (const std::system_error&) {
        // The system gives no more threads: those that exist do the work.
    }
    work();
    for (std::thread& t : pool) t.join();
    if (error) std::rethrow_exception(error);
}

} // namespace fjell::baker
