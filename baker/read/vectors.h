// Points, lines and polygons of a vector file (GeoPackage, GeoJSON, Shapefile, ...), in samples of a height field.
//
// O(points). Memory: 16 bytes a point. Throws Failure 1: no such file, none that GDAL reads as vectors, or a CRS that
// does not lead to the field's; 3: GDAL is missing.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "baker/read/source.h"

namespace fjell::baker {

// A grid in its CRS, as a height field has it, or a pack.
struct VectorGrid {
    std::string crs_wkt; // empty: coordinates are taken as they are
    std::array<double, 2> origin{0, 0};
    std::array<double, 2> step{1, 1}; // from sample to sample, eastwards and southwards, in units of the CRS

    VectorGrid() = default;
    explicit VectorGrid(const HeightSource& field);
};

enum class VectorKind { point, line, polygon };

struct VectorShape {
    using Place = std::array<double, 2>; // columns and rows; samples are at whole numbers
    VectorKind kind = VectorKind::point;
    // One of a point or a line, where a place that the grid's CRS does not know is NaN; of a polygon the ring around it
    // first, then those of its holes, each closed.
    std::vector<std::vector<Place>> parts;
    std::vector<std::pair<std::string, double>>
        numbers; // its attributes that are numbers, or text that is one: 6, "6", "6 m"

    [[nodiscard]] std::optional<double> number(const std::string& name) const;
};

// In the file's order, each in the CRS that its layer says, or in the grid's. What is collected comes one by one;
// curves come as lines. Sides are cut so that they are straight in the grid, too. what: "polygons", for the message.
// layer: of the file; empty: all of them.
[[nodiscard]] std::vector<VectorShape> read_vectors(const std::string& path, const VectorGrid& grid, const char* what,
                                                    const std::string& layer = {});

// What of a window's rows lies inside of a polygon: from its first sample to its last one, each whole stretch between
// two sides that cross the row. pieces: of its rings, in any order, where each begins with the place at which the one
// before ends. O(rows and places).
void for_stretches_inside(std::span<const std::span<const VectorShape::Place>> pieces, const Window& window,
                          const std::function<void(std::int32_t row, std::int32_t first, std::int32_t last)>& stretch);

} // namespace fjell::baker
