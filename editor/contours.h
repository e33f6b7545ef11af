// The heights that are written beside contours: where in the picture, and which.
//
// Looked for along columns of the picture, with rays at the ground: where two neighbours lie on both sides of a
// contour, it is pinned down between them. Thread: the frame's. Memory: fixed. Complexity: some 400 rays, once the view
// has come to rest; none while it moves, and no label is shown then.
#pragma once

#include <array>
#include <cstddef>

#include "fjell/terrain.h"
#include "fjell/view.h"

namespace fjell::editor {

struct ContourLabel {
    double x = 0, y = 0; // in the picture, in shares of its width and height
    double height_m = 0;
};

struct ContourLabels {
    std::array<ContourLabel, 40> all{};
    std::size_t count = 0;
    View of{}; // that they were found for, or that the last frame had
    double every_m = 0;
    bool found = false;
};

// After a frame's update. every_m: between contours; 0: they are not shown. changed: heights have, since the call
// before. apart_px: between two labels.
void update_contour_labels(ContourLabels& labels, const Terrain& terrain, const View& view, double every_m,
                           bool changed, double apart_px);

} // namespace fjell::editor
