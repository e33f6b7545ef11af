// The clock that the editor measures its own work with.
#pragma once

#include <chrono>

namespace fjell::editor {

using Clock = std::chrono::steady_clock;

[[nodiscard]] inline double microseconds(Clock::duration d) {
    return std::chrono::duration<double, std::micro>(d).count();
}

} // namespace fjell::editor
