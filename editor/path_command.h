// Commands that shape the camera path: its points' places, times and targets, how fast it flies, and whether it closes.
// Part of editor/command.h, which every other file includes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "editor/route.h"

namespace fjell::editor {

inline constexpr const char* pace_names[] = {"constant", "ease"};

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
struct TimePoint { // when it is passed, between its neighbours; the last one: the duration
    std::size_t point = 0;
    double time_s = 0;
    bool dragging = false;
};
struct PaceStretch { // mean speed from that point to the next; the times after it follow
    std::size_t point = 0;
    double m_s = 0;
    bool dragging = false;
};
struct PacePath {
    Pace pace = Pace::constant;
};
struct AimPath { // the camera looks at that place on the ground, from one point to another
    double x_m = 0, z_m = 0;
    std::size_t first = 0, last = most_points;
};
struct FreePath { // or at none
    std::size_t first = 0, last = most_points;
};
struct ClosePath {
    bool on = false;
};
struct CirclePath { // a path once around what the camera looks at: a turntable
    double seconds = 20;
};

} // namespace fjell::editor
