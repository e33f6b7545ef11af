// The smallest threshold whose flight keeps a time budget: how it is looked for, apart from what a flight is.
//
// Cost is taken to fall with a rising threshold (thesis 6.3 and 6.4 measured it so). The flights of one threshold do
// the same work frame by frame, so what they differ in is other programs, which make frames dearer and never cheaper,
// and which no threshold can help: each frame counts with its least time. More flights can then only lower the p99: a
// threshold is flown until it keeps the budget, three times at most, or once where half of all frames are far beyond
// it. What limits a threshold is told from the same least times and their parts. The search goes down from most_px by
// halves until one fails, which flies what is dear only once and gives the curve its span, and bisects the last octave
// on a logarithmic scale down to 1.5%. Should the threshold that was found have room to spare next to one that failed,
// the failed one is doubted, once, and flown again. Every threshold tried has three digits, rounded up, so that the one
// that is offered is one that was flown. In the end it is flown again, as if for the first time, and if it fails then,
// a larger one is looked for.
//
// Rejected: a fit of a power law through all flights. It needs fewer of them, but offers thresholds never flown, and a
// budget of vertices that is reached bends the curve.
//
// Thread: any. Failure: what `fly` throws gets out.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "editor/command.h"
#include "editor/jobs/jobs.h"

namespace fjell::editor {

// What one flight measured.
struct FlightCost {
    std::vector<double> times_us;     // of the frames that count, in their order; as many in every flight
    double vertices = 0, reached = 1; // as in TunePoint
    std::vector<CostParts> parts_us;  // of the same frames; empty: not known
};

struct TuneResult {
    double best_px = 0;                                       // 0: not even most_px keeps the budget
    std::vector<TunePoint> curve;                             // by falling threshold
    std::uint32_t flights = 0, expected = 0;                  // so far, and in all as far as one can tell
    [[nodiscard]] const TunePoint* at(double error_px) const; // null: was not flown
};

inline constexpr std::uint32_t most_flights = 48;
inline constexpr double least_reached = 0.99; // share of frames: as p99 is of times

// fly: one flight at a threshold. each: after every flight, with what is known by then.
[[nodiscard]] TuneResult find_threshold(const TuneSettings& settings,
                                        const std::function<FlightCost(double error_px)>& fly,
                                        const std::function<void(const TuneResult&)>& each);

// The part that most of the time goes to, and its share of it; none of no time.
struct LimitingPart {
    const char* name = nullptr;
    double share = 0;
};
[[nodiscard]] LimitingPart limiting_part(const CostParts& parts_us);

// To three digits: 1.2301 is 1.24.
[[nodiscard]] double rounded_up(double error_px);
// One line for people; settings: what was requested. flight: what was flown, "an orbit".
[[nodiscard]] std::string tune_text(const TuneResult& result, const TuneSettings& settings, const std::string& flight);
// threshold_px,p50_us,p99_us,max_us,vertices,frames,keeps,reached,flights: a line a threshold, falling.
[[nodiscard]] std::string tune_csv(const std::vector<TunePoint>& curve);

// Throws io::Failure (2) that names the setting and its range.
void check(const TuneSettings& settings);

} // namespace fjell::editor
