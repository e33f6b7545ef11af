#include "baker/read/windows.h"

#include <algorithm>

namespace fjell::baker {

namespace {

// The first border after `at` when every `step` borders one is taken.
std::int64_t next_border(std::int64_t at, std::int64_t first, std::int64_t size, std::int64_t step) {
    std::int64_t block = (at - first) / size;
    if (at - first < block * size) --block; // towards minus infinity
    return first + (block + step) * size;
}

} // namespace

std::vector<Window> cut_along(const Window& area, const Blocks& blocks, std::size_t most) {
    const std::int64_t width = area.columns,
                       limit = static_cast<std::int64_t>(std::clamp<std::size_t>(most, 1, std::size_t{1} << 40));
    const std::int64_t right = std::int64_t{area.x} + area.columns, bottom = std::int64_t{area.y} + area.rows;
    Blocks b = blocks;
    const bool wide = b.columns >= area.columns;
    if (wide && width * b.rows > limit) // inside one block
        b = {b.columns, static_cast<std::int32_t>(std::max<std::int64_t>(1, limit / width)), b.x, area.y};
    const bool bands = wide || width * b.rows <= limit;
    const std::int64_t down = bands ? std::max<std::int64_t>(1, limit / (width * b.rows)) : 1;
    const std::int64_t along = std::max<std::int64_t>(1, limit / (std::int64_t{b.columns} * b.rows));
    std::vector<Window> windows;
    for (std::int64_t y = area.y, y_next = 0; y < bottom; y = y_next) {
        y_next = std::min(bottom, next_border(y, b.y, b.rows, down));
        for (std::int64_t x = area.x, x_next = 0; x < right; x = x_next) {
            x_next = bands ? right : std::min(right, next_border(x, b.x, b.columns, along));
            windows.push_back({static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                               static_cast<std::int32_t>(x_next - x), static_cast<std::int32_t>(y_next - y)});
        }
    }
    return windows;
}

} // namespace fjell::baker
