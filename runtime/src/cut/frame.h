// The frame in work: what it may spend, and what it has done.
#pragma once

#include <chrono>
#include <cstdint>

#include "fjell/cut.h"

namespace fjell {

// The frame in work.
struct Frame {
    CutSettings settings;
    CutReport report;
    std::uint64_t number;
    std::uint32_t item_limit;
    bool lagging;                          // the frame before left work undone
    std::uint32_t full_capacities;         // CutBudgetBits of capacities at which a change has just failed
    std::uint32_t deactivations_when_full; // deactivations before it did
    std::uint32_t batches;                 // of groups, changed in this frame
    std::uint32_t examined;                // groups since the last batch, also of the frame before
    std::chrono::steady_clock::time_point started;
    double output_us;   // what the report of the last frame that lagged took
    double reserved_us; // of this frame's time, for its own
};

[[nodiscard]] inline bool out_of_items(const Frame& frame) {
    return frame.report.work >= frame.item_limit;
}
// Has the frame done what it may? Its time counts once it has done something.
[[nodiscard]] bool out_of_time(Frame& frame, bool done_something);
// A step of the bulk pass and a look at pages count too. Were one more group evaluated after the last that time
// allowed, a replay would spend that visit on the next of them.
[[nodiscard]] bool has_done_something(const Frame& frame);

} // namespace fjell
