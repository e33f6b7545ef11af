#include "baker/outlets/areas.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "baker/read/vectors.h"

namespace fjell::baker {

Areas::Areas(const std::string& path, const HeightSource& field) : columns_(field.columns) {
    for (const VectorShape& shape : read_vectors(path, VectorGrid(field), "polygons")) {
        if (shape.kind != VectorKind::polygon) continue;
        for (const auto& ring : shape.parts)
            for (std::size_t i = 1; i < ring.size(); ++i) {
                if (ring[i - 1][1] == ring[i][1]) continue;
                const auto [a, b] =
                    std::minmax(ring[i - 1], ring[i], [](const auto& p, const auto& q) { return p[1] < q[1]; });
                edges_.push_back({a[0], a[1], b[0], b[1], areas_});
            }
        ++areas_;
    }
    if (edges_.empty()) throw Failure(1, fmt::format("{}: has no polygon", path));
    std::ranges::sort(edges_, {}, &Edge::y0);
    for (std::int32_t row = 0; row < field.rows; ++row)
        if (!inside(row).empty()) return;
    throw Failure(1,
                  fmt::format("{}: no sample lies in its polygons; they are elsewhere, or smaller than cells", path));
}

// Area by area, as a ring inside of another is a hole of it alone.
Areas::Runs Areas::inside(std::int32_t row) const {
    std::vector<std::pair<std::uint32_t, double>> crossings;
    for (const Edge& e : edges_) {
        if (e.y0 > row) break;
        if (e.y1 > row) crossings.emplace_back(e.area, e.x0 + (row - e.y0) / (e.y1 - e.y0) * (e.x1 - e.x0));
    }
    std::ranges::sort(crossings);
    Runs runs;
    const auto column = [&](double x) {
        return static_cast<std::int32_t>(std::clamp(std::ceil(x), 0.0, static_cast<double>(columns_)));
    };
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2)
        if (const std::pair run{column(crossings[i].second), column(crossings[i + 1].second)}; run.first < run.second)
            runs.push_back(run);
    std::ranges::sort(runs);
    Runs merged;
    for (const auto& run : runs)
        if (!merged.empty() && run.first <= merged.back().second)
            merged.back().second = std::max(merged.back().second, run.second);
        else
            merged.push_back(run);
    return merged;
}

} // namespace fjell::baker
