// A camera that flies by keys and mouse. No window in here, so that it can be tested without one.
//
// Axes: x east, y up, z south. Heading counts clockwise from north, pitch upwards from the horizon; both in radians.
#pragma once

#include "fjell/view.h"
#include "session/path.h"

namespace fjell::session {

// -1, 0 or 1 each, or anything between.
struct Steering {
    double forward = 0, right = 0, up = 0; // movement
    double turn_right = 0, turn_up = 0;    // looking
};

struct FreeCamera {
    Vec3 position_m;
    double heading = 0, pitch = 0;
    double speed_m_s = 1;

    [[nodiscard]] Pose pose() const;
};

[[nodiscard]] FreeCamera free_camera(const Pose& pose, double speed_m_s);
// Moves for `seconds`. Never sinks below `least_above_m` over the ground, nor strays farther than ten times its
// extents.
void steer(FreeCamera& camera, const Steering& steering, double seconds, const Ground& ground, double least_above_m);
// Looks elsewhere; pitch stops short of straight up and down.
void look(FreeCamera& camera, double right_rad, double up_rad);

} // namespace fjell::session
