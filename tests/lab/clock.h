// What this thread has worked: neighbours that take the core away are not in it.
#pragma once

#include <ctime>

namespace fjell::lab {

[[nodiscard]] inline double worked_us() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

} // namespace fjell::lab
