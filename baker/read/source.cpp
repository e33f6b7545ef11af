#include "baker/read/source.h"

#include <algorithm>
#include <tuple>

namespace fjell::baker {

void Tally::add(std::int32_t x, std::int32_t y) {
    add(Tally{1, x, y});
}

void Tally::add(const Tally& other) {
    if (other.count == 0) return;
    if (count == 0 || std::tie(other.row, other.column) < std::tie(row, column)) column = other.column, row = other.row;
    count += other.count;
}

void Census::add(const Census& other) {
    const Tally before = odd;
    voids.add(other.voids);
    odd.add(other.odd);
    if (before.count == 0 || std::tie(odd.row, odd.column) < std::tie(before.row, before.column)) odd_m = other.odd_m;
    per_unit = std::max(per_unit, other.per_unit);
    least_m = std::min(least_m, other.least_m);
    most_m = std::max(most_m, other.most_m);
}

} // namespace fjell::baker
