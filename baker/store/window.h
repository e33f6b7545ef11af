// A rectangle of a grid.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace fjell::baker {

// A rectangle of samples (or texels): [x, x + columns) by [y, y + rows), row 0 in the north.
struct Window {
    std::int32_t x = 0, y = 0, columns = 0, rows = 0;
    [[nodiscard]] std::size_t area() const {
        return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    }
    friend bool operator==(const Window&, const Window&) = default;
};

// What both cover; without area where that is nothing.
[[nodiscard]] constexpr Window common(const Window& a, const Window& b) {
    const std::int32_t x = std::max(a.x, b.x), y = std::max(a.y, b.y);
    const std::int32_t columns = std::min(a.x + a.columns, b.x + b.columns) - x,
                       rows = std::min(a.y + a.rows, b.y + b.rows) - y;
    return columns > 0 && rows > 0 ? Window{x, y, columns, rows} : Window{};
}

} // namespace fjell::baker
