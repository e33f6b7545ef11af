// A flight without a window: frame by frame, with pictures and snapshots of some.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "fly/options.h"
#include "session/log.h"
#include "session/session.h"

namespace fjell::session {

// Pictures and snapshots of a streamed pack that lack what their views want.
struct Shortfall {
    std::size_t outputs = 0;
    int exit_code = 0; // 0: it was asked for, by --realtime
    std::string first; // one line: which one, what it lacks and what to do
};

// A frame that is drawn or exported waits for what its view wants, unless options.realtime; it says on standard error
// how far it is. Throws Failure as what it calls.
void fly_headless(const FlightOptions& options, Session& session, std::span<const Pose> poses, FlightLog& log,
                  Verification& verification, Shortfall& shortfall);

} // namespace fjell::session
