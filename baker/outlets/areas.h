// Areas of a vector file over a height field: which samples lie in its polygons.
//
// O(edges + rows * edges that cross them). Throws Failure 1: no such file, none that GDAL reads as vectors, no polygon
// in it, a CRS that does not lead to the field's, or polygons beside the field.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "baker/read/source.h"

namespace fjell::baker {

class Areas {
public:
    // Polygons of all layers, in the CRS that they say, or in the field's. Where they overlap they are one area.
    Areas(const std::string& path, const HeightSource& field);

    // From a column to the one behind the last, ascending and apart: the samples of a row that lie inside.
    using Runs = std::vector<std::pair<std::int32_t, std::int32_t>>;
    [[nodiscard]] Runs inside(std::int32_t row) const;

private:
    struct Edge {
        double x0, y0, x1, y1; // columns and rows, y0 < y1
        std::uint32_t area;
    };
    std::int32_t columns_;
    std::uint32_t areas_ = 0;
    std::vector<Edge> edges_; // by y0
};

} // namespace fjell::baker
