// The triangles of a mesh of right isosceles triangles: a triangle is cut at the middle of its hypotenuse wherever that
// place is a vertex.
#pragma once

#include "shared/tree.h"

namespace fjell::baker {

// apex, then the ends of the hypotenuse, counter-clockwise. is_vertex(place); draw(apex, a, b) gets each triangle that
// is not cut, in the order of a depth-first walk. O(triangles).
template <typename IsVertex, typename Draw>
void bisect_triangle(SampleIndex apex, SampleIndex a, SampleIndex b, const IsVertex& is_vertex, const Draw& draw) {
    const std::int32_t x = a.column + b.column, y = a.row + b.row;
    const SampleIndex middle{x / 2, y / 2};
    if ((x & 1) == 0 && (y & 1) == 0 && is_vertex(middle)) {
        bisect_triangle(middle, apex, a, is_vertex, draw);
        bisect_triangle(middle, b, apex, is_vertex, draw);
    } else {
        draw(apex, a, b);
    }
}

} // namespace fjell::baker
