// When a terrain that is streamed and may be edited has come to rest: for those that update its parts together.
#pragma once

#include <cstdint>

#include "fjell/cut.h"
#include "fjell/edit.h"
#include "fjell/stream.h"

namespace fjell::io {

[[nodiscard]] inline bool nothing_to_do(const CutReport& c, const StreamReport& s, const EditReport& e) {
    return e.waiting == e.held && e.moving == 0 && e.loose == 0 && e.samples == 0 && s.in_flight == 0 &&
           s.pages_left == 0 && s.mips_left == 0 && s.pages_inserted == 0 && s.mips_uploaded == 0 &&
           s.pages_evicting == 0 && (s.exhausted & stream_tests) == 0 && c.waiting == c.blocked && c.morphing == 0 &&
           c.activations == 0 && c.deactivations == 0 && (s.maps_converged || s.missing_mips > 0); // or mips fade in
}

// After each update: whether another one with the same views would change nothing. converged: all that the views want
// is loaded and drawn. quiet: how many updates in a row found nothing to do; kept by the caller.
[[nodiscard]] inline bool is_settled(bool converged, const CutReport& c, const StreamReport& s, const EditReport& e,
                                     std::uint32_t& quiet) {
    quiet = nothing_to_do(c, s, e) ? quiet + 1 : 0;
    const bool moving = e.waiting + e.moving != 0 || e.loose != 0;
    return (converged && !moving) || quiet > 1; // twice: what an update requests it may find out in the next one
}

} // namespace fjell::io
