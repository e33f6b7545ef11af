// How much random tests do. By default enough to notice what breaks often, so that everyone runs them; with
// FJELL_TEST_ROUNDS=full, as ./dev test --long sets it, all of it.
#pragma once

#include <cstdlib>
#include <string_view>
#include <type_traits>

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

} // namespace fjell::test
