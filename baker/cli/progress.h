// A progress bar with rate and time left, on a terminal only; also where Ctrl-C is noticed.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace fjell::baker {

class ProgressBar {
public:
    explicit ProgressBar(bool quiet); // quiet, or stderr not a terminal: draws nothing
    ~ProgressBar();                   // leaves the terminal's line clean
    // Throws Failure when the process was asked to stop, so that destructors remove what is half-written.
    void operator()(const char* stage, std::uint64_t done, std::uint64_t total);

private:
    bool draws_;
    bool drawn_ = false;
    std::string stage_;
    std::chrono::steady_clock::time_point start_, last_;
};

} // namespace fjell::baker
