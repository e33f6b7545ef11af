// Numbers for people, in panels and in what jobs say.
#pragma once

#include <cstddef>
#include <cstdio>
#include <iterator>
#include <string>

namespace fjell::editor {

// A short text on the stack, so that panels allocate nothing.
struct NumberText {
    char text[32];
};

// A whole number in groups of three: 1,850. At least 0.
[[nodiscard]] inline NumberText count_text(double value) {
    char digits[32];
    const int n = std::snprintf(digits, sizeof digits, "%.0f", value < 1e18 ? value : 1e18);
    NumberText t{};
    std::size_t at = 0;
    for (int i = 0; i < n; ++i) {
        if (i != 0 && (n - i) % 3 == 0) t.text[at++] = ',';
        t.text[at++] = digits[i];
    }
    return t;
}
[[nodiscard]] inline std::string grouped(double value) {
    return count_text(value).text;
}

// Microseconds as milliseconds with three digits, "0.27", "38.0", "1,250"; without the unit.
[[nodiscard]] inline NumberText ms_text(double us) {
    const double ms = us / 1000;
    if (ms >= 999.5) return count_text(ms);
    NumberText t{};
    (void)std::snprintf(t.text, sizeof t.text, "%.*f", ms >= 99.95 ? 0 : ms >= 9.995 ? 1 : 2, ms);
    return t;
}

// A size in bytes with three digits: "12.3 MB". Units of 1,000; at least 0.
[[nodiscard]] inline NumberText byte_text(double bytes) {
    constexpr const char* units[] = {"B", "kB", "MB", "GB", "TB"};
    std::size_t unit = 0;
    for (; bytes >= 999.5 && unit + 1 < std::size(units); ++unit) bytes /= 1000; // 999.5 is written with four
    const int digits = unit == 0 || bytes >= 99.95 ? 0 : bytes >= 9.995 ? 1 : 2;
    NumberText t{};
    (void)std::snprintf(t.text, sizeof t.text, "%.*f %s", digits, bytes, units[unit]);
    return t;
}

} // namespace fjell::editor
