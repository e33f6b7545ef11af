// Instructions a frame, counted by valgrind: what an update costs in energy, as far as instructions say, and the same
// on a machine that is busy as on one that is not.
//
// A child process, this program again under callgrind, flies the case and counts in counted_refine() alone: neither
// loading, nor settling on the first view. What a processor runs of vector instructions is what callgrind offers, AVX2
// at most. Thread: one. Failure: io::Failure, 1 when valgrind or the child fails, 130 when interrupted.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "lab/world.h"

namespace fjell::lab {

// How the child is started: this program and its arguments, but for the case.
struct Counting {
    std::vector<std::string> command;
    std::string log; // callgrind's, a file
};

// The mean of the flight's updates. None where valgrind is not installed: that is said once, on the error output.
[[nodiscard]] std::optional<double> instructions_a_frame(const Counting& counting, const Recipe& recipe,
                                                         std::size_t number, std::size_t frames);
// What the child does.
void fly_counted(const Recipe& recipe, const Case& c, World& world);

} // namespace fjell::lab
