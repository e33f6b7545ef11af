// A rectangle of a grid.
#pragma once

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

} // namespace fjell::baker
