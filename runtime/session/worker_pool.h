// Threads for the cut's jobs: what an engine has anyway, for programs that have none.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "fjell/jobs.h"

namespace fjell::session {

// Threads: jobs() may be used by one at a time, which works too while it waits. Failure: std::system_error when a
// thread cannot be started.
class WorkerPool {
public:
    explicit WorkerPool(std::uint32_t workers); // with the one that asks
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    [[nodiscard]] JobSystem jobs() { return {&WorkerPool::run, this}; }

private:
    struct Loop { // that is run
        std::uint32_t count = 0, next = 0, done = 0;
        void (*job)(void* data, std::uint32_t index) = nullptr;
        void* data = nullptr;
    };
    static void run(void* user, std::uint32_t count, void (*job)(void*, std::uint32_t), void* data);
    void work();
    // Jobs that nobody has begun. The lock is held, but not while they are done.
    void help(std::unique_lock<std::mutex>& lock);

    std::mutex mutex_;
    std::condition_variable begun_, ended_;
    Loop loop_;
    bool stop_ = false;
    std::vector<std::jthread> threads_; // last: they end before what they use goes
};

} // namespace fjell::session
