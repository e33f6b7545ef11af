// Commands that shape the camera path: its points' places, times and targets, how fast it flies, and whether it closes.
// Part of editor/command.h, which every other file includes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "editor/route.h"

namespace fjell::editor {

struct SelectPoint {
    std::size_t point = 0;
    bool looks = true; // from there
};
struct InsertPoint {                  // on the path, where it is at that share of its time
    std::optional<double> share = {}; // none: where it is being played
};
struct PlacePoint { // over that place: at that height, or as high above the ground as it was
    std::size_t point = 0;
    double x_m = 0, z_m = 0;
    bool dragging = false; // more of the same follows: one step of undo
    std::optional<double> y_m = {};
};
} // namespace fjell::editor
