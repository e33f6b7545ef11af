#include "baker/vectors/ground_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include <fmt/format.h>

#include "baker/read/edited_source.h"

namespace fjell::baker {

namespace {

constexpr std::int32_t cells_of_read = 16; // a side, of what is read at once
constexpr float none_m = std::numeric_limits<float>::quiet_NaN();

std::uint64_t cell_key(std::int32_t cx, std::int32_t cy) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(cy)) << 32 | static_cast<std::uint32_t>(cx);
}
std::size_t index_in_cell(std::int32_t x, std::int32_t y) {
    return static_cast<std::size_t>(y % ground_cell) * ground_cell + static_cast<std::size_t>(x % ground_cell);
}

} // namespace

GroundCells::GroundCells(const HeightSource& source, std::string name)
    : name_(std::move(name)), columns_(source.columns), rows_(source.rows), reader_(source.reader()) {}

GroundCells::Cell& GroundCells::made(std::int32_t cx, std::int32_t cy) {
    constexpr std::size_t area = std::size_t{ground_cell} * ground_cell;
    if ((cells_.size() + 1) * area > most_edited_samples)
        throw Failure(1, fmt::format("{}: changes more than {} million samples; take some of its lines", name_,
                                     most_edited_samples >> 20));
    return cells_.emplace(cell_key(cx, cy), Cell(area, none_m)).first->second;
}

// Of whole cells, all of which are made.
void GroundCells::read(const Window& window) {
    window_.resize(window.area());
    ReadStatistics ignored;
    reader_->read(window, window_.data(), ignored);
    const float* from = window_.data();
    for (std::int32_t y = window.y; y < window.y + window.rows; ++y)
        for (std::int32_t x = window.x; x < window.x + window.columns;) {
            const std::int32_t end = std::min((x / ground_cell + 1) * ground_cell, window.x + window.columns);
            if (const auto cell = cells_.find(cell_key(x / ground_cell, y / ground_cell)); cell != cells_.end())
                std::copy(from, from + (end - x),
                          cell->second.begin() + static_cast<std::ptrdiff_t>(index_in_cell(x, y)));
            from += end - x, x = end;
        }
}

void GroundCells::load(std::span<const Sample> samples) {
    std::vector<std::uint64_t> missing;
    for (const Sample& s : samples)
        if (s.x >= 0 && s.y >= 0 && s.x < columns_ && s.y < rows_) {
            const std::uint64_t key = cell_key(s.x / ground_cell, s.y / ground_cell);
            if (missing.empty() || missing.back() != key) missing.push_back(key);
        }
    const auto x_of = [](std::uint64_t key) { return static_cast<std::int32_t>(key & 0xffff'ffff); };
    const auto y_of = [](std::uint64_t key) { return static_cast<std::int32_t>(key >> 32); };
    const auto group = [&](std::uint64_t key) {
        return std::pair(y_of(key) / cells_of_read, x_of(key) / cells_of_read);
    };
    std::ranges::sort(missing, {}, [&](std::uint64_t key) { return std::tuple(group(key), key); });
    missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
    std::erase_if(missing, [&](std::uint64_t key) { return cells_.contains(key); });
    for (std::size_t i = 0; i < missing.size();) {
        std::int32_t x0 = x_of(missing[i]), x1 = x0, y0 = y_of(missing[i]), y1 = y0;
        const auto own = group(missing[i]);
        for (; i < missing.size() && group(missing[i]) == own; ++i) {
            const std::int32_t x = x_of(missing[i]), y = y_of(missing[i]);
            x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
            (void)made(x, y);
        }
        const std::int32_t left = x0 * ground_cell, top = y0 * ground_cell;
        read({left, top, std::min((x1 + 1) * ground_cell, columns_) - left,
              std::min((y1 + 1) * ground_cell, rows_) - top});
    }
}

float GroundCells::at(std::int32_t x, std::int32_t y) {
    if (x < 0 || y < 0 || x >= columns_ || y >= rows_) return none_m;
    const auto found = cells_.find(cell_key(x / ground_cell, y / ground_cell));
    if (found != cells_.end()) return found->second[index_in_cell(x, y)];
    const Sample one{x, y};
    load({&one, 1});
    return at(x, y);
}

double GroundCells::between(double column, double row) {
    const auto corner = [](double at, std::int32_t count) {
        return std::clamp(static_cast<std::int32_t>(std::floor(at)), 0, std::max(count - 2, 0));
    };
    const std::int32_t x = corner(column, columns_), y = corner(row, rows_);
    const double u = column - x, v = row - y;
    const auto side = [&](std::int32_t at_y) {
        const double a = at(x, at_y), b = at(x + 1, at_y);
        return a + (b - a) * u;
    };
    const double north = side(y), south = side(y + 1);
    return north + (south - north) * v;
}

} // namespace fjell::baker
