#include "io/stamp_blocks.h"

#include <algorithm>
#include <cmath>

namespace fjell::io {

StampBlocks::StampBlocks(const PackHeader& pack)
    : columns_(pack.columns), rows_(pack.rows), spacing_m_{pack.spacing_m[0], pack.spacing_m[1]} {}

// Metres, both ends belong to it.
void StampBlocks::add(double x0, double z0, double x1, double z1, const Stamp& stamp) {
    constexpr double side = 32; // samples
    const double ends[] = {x0 / spacing_m_[0], z0 / spacing_m_[1], x1 / spacing_m_[0], z1 / spacing_m_[1]};
    double least[2] = {ends[0], ends[1]}, most[2] = {ends[2], ends[3]};
    if (stamp.columns > 0) {
        least[0] = std::max<double>(least[0], stamp.first.column),
        least[1] = std::max<double>(least[1], stamp.first.row);
        most[0] = std::min<double>(most[0], stamp.first.column + stamp.columns - 1);
        most[1] = std::min<double>(most[1], stamp.first.row + stamp.rows - 1);
    }
    const double last[] = {columns_ - 1.0, rows_ - 1.0};
    for (const int axis : {0, 1}) {
        least[axis] = std::max(least[axis], 0.0), most[axis] = std::min(most[axis], last[axis]);
        if (!(least[axis] <= most[axis])) return;
    }
    const auto is = [&](StampShape one, StampShape other) { return stamp.shape == one || stamp.shape == other; };
    std::unordered_set<std::uint64_t>& blocks = is(StampShape::paint, StampShape::unpaint) ? paint_
                                                : is(StampShape::lock, StampShape::unlock) ? locks_
                                                                                           : heights_;
    const auto block = [](double sample) { return static_cast<std::uint64_t>(sample / side); };
    const std::uint64_t columns = block(most[0]) - block(least[0]) + 1, rows = block(most[1]) - block(least[1]) + 1;
    if (blocks.size() + columns * rows > most_stamp_blocks) return;
    for (std::uint64_t y = block(least[1]); y <= block(most[1]); ++y)
        for (std::uint64_t x = block(least[0]); x <= block(most[0]); ++x) blocks.insert(y << 32 | x);
}

void StampBlocks::add(const KeptStamp& stamp) {
    const Stamp& s = stamp.plain;
    double out_m = static_cast<double>(s.radius_m) + static_cast<double>(s.falloff_m);
    if (s.shape == StampShape::lock) out_m += std::hypot(spacing_m_[0], spacing_m_[1]); // a cell more
    if (s.shape == StampShape::heights || (s.columns > 0 && s.radius_m == 0)) return add(0, 0, 1e9, 1e9, s);
    if (stamp.points.empty()) return add(s.x_m - out_m, s.z_m - out_m, s.x_m + out_m, s.z_m + out_m, s);
    for (std::size_t i = 1; i < stamp.points.size(); ++i) {
        const StampPoint &a = stamp.points[i - 1], &b = stamp.points[i];
        const double dx = b.x_m - a.x_m, dz = b.z_m - a.z_m;
        // In pieces, because the rectangle around a line that runs askew is mostly beside it.
        const double blocks = std::max(std::abs(dx) / spacing_m_[0], std::abs(dz) / spacing_m_[1]) / 32;
        const double parts = std::min(std::floor(blocks) + 1, 1e5);
        for (double k = 0; k < parts; ++k) {
            const double x0 = a.x_m + dx * k / parts, x1 = a.x_m + dx * (k + 1) / parts, z0 = a.z_m + dz * k / parts,
                         z1 = a.z_m + dz * (k + 1) / parts;
            add(std::min(x0, x1) - out_m, std::min(z0, z1) - out_m, std::max(x0, x1) + out_m, std::max(z0, z1) + out_m,
                s);
        }
    }
}

} // namespace fjell::io
