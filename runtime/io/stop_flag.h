// What stops one call, where a signal stops the whole program: check_interrupt() asks the flag of its thread too, and
// parallel_for() (baker/store/parallel.h) hands it on to its threads.
#pragma once

#include <atomic>

namespace fjell::io {

[[nodiscard]] const std::atomic<bool>* stop_flag(); // of this thread; null: none
void set_stop_flag(const std::atomic<bool>* flag);

// While it lives, the flag is this thread's.
class StopScope {
public:
    explicit StopScope(const std::atomic<bool>* flag) : before_(stop_flag()) { set_stop_flag(flag); }
    ~StopScope() { set_stop_flag(before_); }
    StopScope(const StopScope&) = delete;
    StopScope& operator=(const StopScope&) = delete;

private:
    const std::atomic<bool>* before_;
};

} // namespace fjell::io
