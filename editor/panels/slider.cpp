#include "editor/panels/slider.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>

namespace fjell::editor {

namespace {

constexpr double zero_stretch = 0.04; // of the slider, where 0 is allowed on a logarithmic one

// The smallest value above 0 that such a slider gives.
double floor_of(const flight::ProfileKey& key) {
    return key.kind == flight::KeyKind::number ? key.most * 1e-6 : 1;
}

double three_digits(double value) {
    if (value == 0) return 0;
    const double step = std::pow(10, std::floor(std::log10(std::abs(value))) - 2);
    return step < 1 ? std::round(value / step) / std::round(1 / step) : std::round(value / step) * step;
}

} // namespace

double slider_share(const flight::ProfileKey& key, double value) {
    const double v = std::clamp(value, key.least, key.most);
    if (!key.logarithmic) return (v - key.least) / (key.most - key.least);
    if (key.least > 0) return std::log(v / key.least) / std::log(key.most / key.least);
    if (v == 0) return 0;
    const double floor = floor_of(key);
    return zero_stretch + (1 - zero_stretch) * std::max(std::log(v / floor), 0.0) / std::log(key.most / floor);
}

double slider_value(const flight::ProfileKey& key, double share) {
    if (!(share > 0)) return key.least;
    if (share >= 1) return key.most;
    double value = 0;
    if (!key.logarithmic) {
        value = key.least + share * (key.most - key.least);
    } else if (key.least > 0) {
        value = key.least * std::pow(key.most / key.least, share);
    } else {
        if (share < zero_stretch) return 0;
        const double floor = floor_of(key);
        value = floor * std::pow(key.most / floor, (share - zero_stretch) / (1 - zero_stretch));
    }
    value = three_digits(value);
    if (key.kind != flight::KeyKind::number) value = std::round(value);
    return std::clamp(value, key.least, key.most);
}

ShownUnit shown_unit(const flight::ProfileKey& key) {
    return std::strcmp(key.unit, "us") == 0 ? ShownUnit{"ms", 1e-3} : ShownUnit{key.unit, 1};
}

void write_value(const flight::ProfileKey& key, double value, char* to, int size) {
    if (key.zero != nullptr && value == 0)
        (void)std::snprintf(to, static_cast<std::size_t>(size), "%s", key.zero);
    else
        (void)std::snprintf(to, static_cast<std::size_t>(size), key.kind == flight::KeyKind::number ? "%.7g" : "%.0f",
                            value * shown_unit(key).share);
}

bool typed_value(const flight::ProfileKey& key, std::string_view text, double& value) {
    while (text.starts_with(' ')) text.remove_prefix(1);
    while (text.ends_with(' ')) text.remove_suffix(1);
    if (key.zero != nullptr && text == key.zero) {
        value = 0;
        return true;
    }
    double read = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), read);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(read)) return false;
    const double share = shown_unit(key).share;
    value = share == 1 ? read : std::round(read / share * 1e3) / 1e3; // or 16.667 ms would be 16667.000000000002 us
    return true;
}

} // namespace fjell::editor
