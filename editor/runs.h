// What benchmarks measured along their path, kept to be charted, compared and looked at place by place.
//
// A run keeps up to most_places places: stretches of the path, each by its dearest frame and its largest error. The
// first frame, which is built from nothing, is none of it. Thread: make_run() any, Runs the frame's. Memory: some 60 kB
// a run, most_runs of them; panels allocate nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "editor/command.h"
#include "session/log.h"
#include "session/path.h"

namespace fjell::editor {

inline constexpr std::size_t most_places = 512, most_runs = 8, worst_places = 10;

struct FlownPlace {
    session::Pose pose;      // of the dearest frame
    std::uint32_t frame = 0; // that one
    float update_us = 0;     // of it
    float error_px = 0;      // the largest effective threshold of the stretch; 1e6 and more: unbounded
    float measured_px = -1;  // the largest measured error, of the stretch or of the nearest that has one; -1: none has
    std::uint32_t vertices = 0;
    std::uint32_t exhausted = 0; // ExhaustedBits of any frame of the stretch
};

enum class WorstBy : std::uint8_t { time, error };
struct FlownRun {
    std::string name, profile; // of the CSV; of the profile's file
    double error_px = 0;       // requested
    double budget_us = 0;      // 0: none
    std::size_t frames = 0;    // that count
    double p50_us = 0, p99_us = 0, max_us = 0, error_p99_px = 0, vertices = 0, converged = 0; // means, shares
    std::vector<FlownPlace> places;
    // Places by falling cost, or by falling error where that is above the requested one. Two of them lie at least a
    // fiftieth of the path apart: a single hill is one place.
    std::array<std::vector<std::uint16_t>, 2> worst;

    [[nodiscard]] double share_of(std::size_t place) const {
        return places.size() < 2 ? 0 : static_cast<double>(place) / static_cast<double>(places.size() - 1);
    }
    [[nodiscard]] std::size_t place_at(double share) const; // of none: 0
};

// frames and poses: of the same flight, as many of one as of the other.
[[nodiscard]] FlownRun make_run(std::span<const session::FrameEntry> frames, std::span<const session::Pose> poses);

struct ChosenPlace {
    std::size_t run = 0, place = 0;
};
struct Runs {
    std::vector<std::shared_ptr<const FlownRun>> all; // the latest first
    std::optional<ChosenPlace> chosen;
    Heat heat = Heat::none;

    void add(std::shared_ptr<const FlownRun> run); // forgets the oldest when there are too many
    void forget(std::size_t run);
};

} // namespace fjell::editor
