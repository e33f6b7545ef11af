// fjell-fly's command line.
#pragma once

#include "session/options.h"

namespace fjell::session {

// Returns false when there is nothing left to do (--help, --version). Throws Failure: 2 for usage, 1 for a bad profile.
[[nodiscard]] bool parse_options(int argc, char** argv, FlightOptions& options);

} // namespace fjell::session
