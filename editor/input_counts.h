// Input events that the window has delivered to frames so far. A program that drives the window, as tests do, waits
// until its event is counted instead of sleeping.
#pragma once

#include <cstdint>

namespace fjell::editor {

// All zero without a window. Counted in the frame whose panels see the event.
struct InputCounts {
    std::uint64_t keys = 0;       // pressed and released; no repeats
    std::uint64_t characters = 0; // typed
    std::uint64_t buttons = 0;    // of the mouse, pressed and released
    std::uint64_t scrolls = 0;    // of the wheel
    double pointer_px[2] = {};    // as this frame's panels see it; far outside while there is none
    bool focused = false;         // keys go to this window
};

} // namespace fjell::editor
