// How long a test waits for what another thread or program does: until it is done, however slow the machine is. Only
// what never comes ends the wait, after three minutes: then the test says what it lacks, and not a limit of ctest.
#pragma once

#include <chrono>
#include <thread>

namespace fjell::test {

class Patience {
public:
    // Whether to look once more. The others have their turn first.
    [[nodiscard]] bool left() const {
        std::this_thread::yield();
        return std::chrono::steady_clock::now() < end_;
    }

private:
    std::chrono::steady_clock::time_point end_ = std::chrono::steady_clock::now() + std::chrono::minutes(3);
};

} // namespace fjell::test
