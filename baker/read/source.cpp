#include "baker/read/source.h"

#include <algorithm>
#include <tuple>

namespace fjell::baker {

void ReadStatistics::add(const ReadStatistics& other) {
    const Tally before = implausible;
    voids.add(other.voids);
    implausible.add(other.implausible);
    if (before.count == 0 || std::tie(implausible.row, implausible.column) < std::tie(before.row, before.column))
        implausible_m = other.implausible_m;
    per_unit = std::max(per_unit, other.per_unit);
    least_m = std::min(least_m, other.least_m);
    most_m = std::max(most_m, other.most_m);
    ends.add(other.ends);
}

} // namespace fjell::baker
