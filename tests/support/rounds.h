// How much random tests do. By default enough to notice what breaks often, so that everyone runs them; with
// FJELL_TEST_ROUNDS=full, as ./dev test --long sets it, all of it.
#pragma once

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

// A number of rounds, frames or bytes, or of what a test must have met in them: by default the first one.
template <typename Number = int>
[[nodiscard]] Number rounds(std::type_identity_t<Number> brief, std::type_identity_t<Number> full) {
    return full_rounds() ? full : brief;
}

// A list of what a test tries: by default the first ones of it.
template <typename T>
[[nodiscard]] std::vector<T> first_of(std::size_t brief, std::initializer_list<T> all) {
    return std::vector<T>(all.begin(), all.begin() + (full_rounds() || brief > all.size() ? all.size() : brief));
}

} // namespace fjell::test
