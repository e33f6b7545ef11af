// A thread of gameplay: asks for heights and rays around the walkers while pages stream.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include <fjell/fjell.h>

#include "zones.h"

namespace server {

// What all threads share. The zones' handles do not change while threads run.
struct Shared {
    std::array<Zone, zones> zone;
    ground::Yardstick whole;
    std::atomic<std::uint32_t> tick{0}; // notified; a thread may be ticks behind
    std::atomic<bool> stop{false};
    [[nodiscard]] double now_s() const { return tick * tick_s; }
};

struct Answers {
    std::uint64_t heights = 0, rays = 0, checked = 0, finest = 0;
    double height_s = 0, ray_s = 0; // of this thread's processor time
    std::string broken;             // the first answer that was further off than it said; empty: none
};

// In every tick, until `stop`. No query waits for another thread or for pages.
void ask(const Shared& shared, int thread, Answers& answers);

} // namespace server
