#include "baker/read/dem_source.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <xxhash.h>

#include "baker/place/placement.h"
#include "baker/read/windows.h"

namespace fjell::baker {

namespace {

class DemReader final : public HeightReader {
public:
    explicit DemReader(const Dem& dem) : dem_(dem) {}
    void read(const Window& window, float* to, Census& census) override {
        census.per_unit = 1; // the quantum is the Dem's own
        for (std::int32_t y = window.y; y < window.y + window.rows; ++y)
            for (std::int32_t x = window.x; x < window.x + window.columns; ++x, ++to) {
                *to = dem_.at(x, y);
                if (dem_.is_void(x, y) || std::isnan(*to)) {
                    *to = std::numeric_limits<float>::quiet_NaN();
                    census.voids.add(x, y);
                    continue;
                }
                census.least_m = std::min(census.least_m, *to);
                census.most_m = std::max(census.most_m, *to);
            }
    }

private:
    const Dem& dem_;
};

std::uint64_t hash(const void* bytes, std::size_t size) {
    return XXH3_64bits(bytes, size);
}

} // namespace

DemSource::DemSource(Dem dem) : dem_(std::move(dem)) {
    columns = dem_.columns;
    rows = dem_.rows;
    std::copy_n(dem_.spacing_m, 2, spacing_m);
    std::copy_n(dem_.origin_m, 2, origin_m);
    crs_wkt = dem_.crs_wkt;
    std::copy_n(dem_.crs_step, 2, crs_step);
    if (!(crs_step[0] > 0 && crs_step[1] > 0)) crs_step_of(spacing_m, crs_wkt, crs_step);
}

std::unique_ptr<HeightReader> DemSource::reader() const {
    return std::make_unique<DemReader>(dem_);
}

std::vector<Window> DemSource::windows(std::size_t most) const {
    return cut_along({0, 0, columns, rows}, {columns, 1, 0, 0}, most);
}

Settled DemSource::settle(const Census& census) const {
    if (!(census.least_m <= census.most_m))
        throw Failure(1, fmt::format("all {} x {} samples are holes; give a height field with heights", columns, rows));
    // Every multiple of the step is on a lattice that starts anywhere on it.
    return {dem_.native_quantum_m, dem_.native_quantum_m > 0 ? static_cast<double>(census.least_m) : 0,
            census.voids.count > 0};
}

std::string DemSource::identity() const {
    return fmt::format("{} x {} in memory, {} {} ({} {}) at {} {} step {} heights {:016x} voids {:016x} crs {:016x}",
                       columns, rows, spacing_m[0], spacing_m[1], crs_step[0], crs_step[1], origin_m[0], origin_m[1],
                       dem_.native_quantum_m, hash(dem_.heights_m.data(), dem_.heights_m.size() * sizeof(float)),
                       hash(dem_.voids.data(), dem_.voids.size()), hash(crs_wkt.data(), crs_wkt.size()));
}

} // namespace fjell::baker
