// What auto-tuning is asked for: in the command, the dialog and the job alike.
#pragma once

#include <cstdint>

namespace fjell::editor {

enum class TuneMeasure : std::uint8_t { update, frame }; // update: the CPU's; frame: with upload, drawing and the GPU
inline constexpr const char* tune_measure_names[] = {"update", "frame"};

struct TuneSettings {
    TuneMeasure measure = TuneMeasure::update;
    double budget_us = 2000; // that p99 shall keep; 10 to 1e6
    // Of each flight, 10 to 100,000; 0: as many as the path has at 60 a second. Fewer fly the same path faster, and a
    // faster camera changes more in a frame.
    std::uint32_t frames = 0;
    double least_px = 0.25, most_px = 32; // where the threshold is looked for
    bool apply = false;                   // sets refine.error_px to what was found
};

// Throws io::Failure (2) that names the setting and its range.
void check(const TuneSettings& settings);

} // namespace fjell::editor
