// Numbers for people, in what jobs say.
#pragma once

#include <cstddef>
#include <string>

#include <fmt/format.h>

namespace fjell::editor {

// A whole number in groups of three: 1,850. At least 0.
[[nodiscard]] inline std::string grouped(double value) {
    const std::string digits = fmt::format("{:.0f}", value);
    std::string text;
    for (std::size_t i = 0; i < digits.size(); ++i) {
        if (i != 0 && (digits.size() - i) % 3 == 0) text += ',';
        text += digits[i];
    }
    return text;
}

[[nodiscard]] inline std::string megabytes(double bytes) {
    return fmt::format("{:.{}f} MB", bytes / 1e6, bytes < 1e7 ? 2 : 1);
}

} // namespace fjell::editor
