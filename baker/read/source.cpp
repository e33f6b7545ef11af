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

void ReadStatistics::add(const ReadStatistics& other) {
    const Tally before = implausible;
    voids.add(other.voids);
    implausible.add(other.implausible);
    if (before.count == 0 || std::tie(implausible.row, implausible.column) < std::tie(before.row, before.column))
        implausible_m = other.implausible_m;
    per_unit = std::max(per_unit, other.per_unit);
    least_m = std::min(least_m, other.least_m);
    most_m = std::max(most_m, other.most_m);
}

} // namespace fjell::baker
