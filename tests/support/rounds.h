// How much random tests do. By default enough to notice what breaks often, so that everyone runs them; with
// FJELL_TEST_ROUNDS=full all of it. ./dev test --long also sets FJELL_TEST_TIMES=1: all of each list, and at most once
// the brief rounds. Brief rounds notice each fault of tests/faults, and seeds are fixed: more rounds find nothing new
// the next time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <initializer_list>
#include <string_view>
#include <type_traits>
#include <vector>

namespace fjell::test {

[[nodiscard]] inline bool full_rounds() {
    const char* const wanted = std::getenv("FJELL_TEST_ROUNDS");
    return wanted != nullptr && std::string_view(wanted) == "full";
}

// A number of rounds, frames or bytes, or of what a test must have met in them: by default the first one. A second one
// that is not larger is a step, and never limited: "at every byte" stays every byte.
template <typename Number = int>
[[nodiscard]] Number rounds(std::type_identity_t<Number> brief, std::type_identity_t<Number> full) {
    if (!full_rounds()) return brief;
    const char* const times = std::getenv("FJELL_TEST_TIMES");
    if (times == nullptr || full <= brief) return full;
    const double most = std::max(1.0, std::strtod(times, nullptr)) * static_cast<double>(brief);
    return most < static_cast<double>(full) ? static_cast<Number>(most) : full;
}

// A list of what a test tries: by default the first ones of it.
template <typename T>
[[nodiscard]] std::vector<T> first_of(std::size_t brief, std::initializer_list<T> all) {
    return std::vector<T>(all.begin(), all.begin() + (full_rounds() || brief > all.size() ? all.size() : brief));
}

} // namespace fjell::test
