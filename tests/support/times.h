// How long things take, and how it is told: benchmarks and the lab.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <vector>

namespace fjell::test {

using Clock = std::chrono::steady_clock;

[[nodiscard]] inline double us_since(Clock::time_point start) {
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}
// What this thread has worked: neighbours that take the core away are not in it.
[[nodiscard]] inline double worked_us() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}
// The value that a share of all does not exceed, one of those that occurred. Not of none.
[[nodiscard]] inline double rank(std::vector<double> v, double share) {
    std::sort(v.begin(), v.end());
    const auto n = static_cast<std::size_t>(std::ceil(share * static_cast<double>(v.size())));
    return v[std::clamp<std::size_t>(n, 1, v.size()) - 1];
}

} // namespace fjell::test
