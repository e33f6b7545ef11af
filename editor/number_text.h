// Numbers for people, in panels and in what jobs say.
#pragma once

#include <cstddef>
#include <cstdio>
#include <iterator>
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

// A size in bytes with three digits: "12.3 MB". Units of 1,000; at least 0. Allocates nothing.
struct ByteText {
    char text[16];
};
[[nodiscard]] inline ByteText byte_text(double bytes) {
    constexpr const char* units[] = {"B", "kB", "MB", "GB", "TB"};
    std::size_t unit = 0;
    for (; bytes >= 999.5 && unit + 1 < std::size(units); ++unit) bytes /= 1000; // 999.5 is written with four
    const int digits = unit == 0 || bytes >= 99.95 ? 0 : bytes >= 9.995 ? 1 : 2;
    ByteText t;
    (void)std::snprintf(t.text, sizeof t.text, "%.*f %s", digits, bytes, units[unit]);
    return t;
}

} // namespace fjell::editor
