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

// Metres, whole and in groups of three: -235,930.
[[nodiscard]] inline NumberText metre_text(double m) {
    const NumberText t = count_text(m < 0 ? -m : m);
    if (m > -0.5) return t;
    NumberText negative{};
    (void)std::snprintf(negative.text, sizeof negative.text, "-%.30s", t.text);
    return negative;
}

// With the unit: "0.5 m/s", "4,096 m/s", "12.3 km/s". At least 0.
[[nodiscard]] inline NumberText speed_text(double m_s) {
    NumberText t{};
    if (m_s < 999.5)
        (void)std::snprintf(t.text, sizeof t.text, "%.3g m/s", m_s);
    else if (m_s < 9999.5)
        (void)std::snprintf(t.text, sizeof t.text, "%.20s m/s", count_text(m_s).text);
    else if (m_s < 999500)
        (void)std::snprintf(t.text, sizeof t.text, "%.3g km/s", m_s / 1000);
    else
        (void)std::snprintf(t.text, sizeof t.text, "%.20s km/s", count_text(m_s / 1000).text);
    return t;
}

// "350 m2", "12.3 ha", "4.56 km2". At least 0.
[[nodiscard]] inline NumberText area_text(double m2) {
    NumberText t{};
    if (m2 < 9999.5)
        (void)std::snprintf(t.text, sizeof t.text, "%.20s m2", count_text(m2).text);
    else if (m2 < 999'500)
        (void)std::snprintf(t.text, sizeof t.text, "%.3g ha", m2 * 1e-4);
    else if (m2 < 999.5e6)
        (void)std::snprintf(t.text, sizeof t.text, "%.4g km2", m2 * 1e-6);
    else
        (void)std::snprintf(t.text, sizeof t.text, "%.20s km2", count_text(m2 * 1e-6).text);
    return t;
}

// A path's last part.
[[nodiscard]] inline const char* file_name(const std::string& path) {
    const std::size_t slash = path.rfind('/');
    return path.c_str() + (slash == std::string::npos ? 0 : slash + 1);
}

// A position: "235,930 E  12,345 S  1,234 m".
struct PlaceText {
    char text[80];
};
[[nodiscard]] inline PlaceText place_text(double x_m, double y_m, double z_m) {
    PlaceText t{};
    (void)std::snprintf(t.text, sizeof t.text, "%.20s E  %.20s S  %.20s m", metre_text(x_m).text, metre_text(z_m).text,
                        metre_text(y_m).text);
    return t;
}

// Microseconds as milliseconds with three digits, "0.27", "38.0", "1,250"; without the unit.
[[nodiscard]] inline NumberText ms_text(double us) {
    const double ms = us / 1000;
    if (ms >= 999.5) return count_text(ms);
    NumberText t{};
    (void)std::snprintf(t.text, sizeof t.text, "%.*f", ms >= 99.95 ? 0 : ms >= 9.995 ? 1 : 2, ms);
    return t;
}

// The same to three digits however few they are, for what people compare and type: "0.0451", "3.98", "4", "1,250".
[[nodiscard]] inline NumberText fine_ms_text(double us) {
    const double ms = us / 1000;
    if (ms >= 99.95) return count_text(ms);
    NumberText t{};
    (void)std::snprintf(t.text, sizeof t.text, "%.3g", ms);
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
