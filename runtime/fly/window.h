// A flight in a window: along the path, or by keys and mouse.
#pragma once

#include <span>

#include "fly/options.h"
#include "session/log.h"
#include "session/session.h"

namespace fjell::session {

// Returns when the window is closed, or after options.frames frames when they were given. Throws Failure 3 when there
// is no display or no OpenGL 4.5. poses: the path, resampled; not empty.
void fly_in_window(const FlightOptions& options, Session& session, std::span<const Pose> poses, FlightLog& log,
                   Verification& verification);

} // namespace fjell::session
