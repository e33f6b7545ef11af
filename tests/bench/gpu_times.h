// What the GPU took, and what it was told: timer queries and counted calls, for gpu_flights.
//
// Thread and context: those of the caller, one context a process.
#pragma once

#include <cstdint>
#include <functional>

namespace fjell::bench {

// Nanoseconds between two commands, as the GPU's own clock has them.
class GpuTimer {
public:
    GpuTimer();
    ~GpuTimer();
    GpuTimer(const GpuTimer&) = delete;
    GpuTimer& operator=(const GpuTimer&) = delete;
    void begin() const;
    void end() const;
    [[nodiscard]] double us() const; // waits for the GPU

private:
    unsigned query_ = 0;
};

// Whether timer queries tell the truth here: a known load four times over must take about four times as long, and
// no longer than the CPU waits for it. A software renderer's do not, and are not asked.
[[nodiscard]] bool timers_are_real();
[[nodiscard]] bool in_software();

struct Calls {
    std::uint32_t calls = 0;      // draw calls, and dispatches of compute shaders
    std::uint32_t draws = 0;      // a multi-draw is as many as it holds
    std::uint32_t dispatches = 0; // of `calls`
};
// Counts what is called from now on, in this process.
void count_calls();
[[nodiscard]] Calls take_calls(); // since it was last asked

} // namespace fjell::bench
