// What the sources of Route (editor/route.h) share.
#pragma once

#include <cstddef>
#include <span>

#include "flight/path.h"

namespace fjell::editor::route_parts {

[[nodiscard]] flight::ControlPoint point_of(const flight::Pose& pose);
// No way of one camera to the other but what numbers round to, through which no curve can be laid.
[[nodiscard]] bool same_place(const flight::ControlPoint& a, const flight::ControlPoint& b);
[[nodiscard]] double length_m(std::span<const flight::ControlPoint> points);
// Throws Failure (2) when times are too near each other, or the last is too late.
void require_apart(std::span<const double> times_s);
[[nodiscard]] std::size_t frames_for(double seconds);
// From there to that place, upright. Throws Failure (2) when it is straight above or below.
[[nodiscard]] flight::ControlPoint looking(const Vec3& from_m, const Vec3& at_m);

} // namespace fjell::editor::route_parts
