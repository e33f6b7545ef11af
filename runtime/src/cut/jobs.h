// Work on several threads of the host's, where it gave us any.
#pragma once

#include <algorithm>
#include <atomic>

#include "cut/state.h"

namespace fjell {

[[nodiscard]] inline std::uint32_t worker_count(const BulkPass& bulk, const Frame& frame) {
    return frame.settings.jobs.run == nullptr ? 1 : bulk.workers;
}

// work(n, worker) for n from 0 to count - 1, each once. Those of one worker run one after the other.
template <typename Work>
void run_jobs(const BulkPass& bulk, const Frame& frame, std::uint32_t count, const Work& work) {
    const std::uint32_t workers = std::min(worker_count(bulk, frame), count);
    if (workers < 2) {
        for (std::uint32_t n = 0; n < count; ++n) work(n, 0);
        return;
    }
    struct Shared {
        const Work& work;
        std::uint32_t count;
        std::atomic<std::uint32_t> next;
    } shared{work, count, 0};
    const auto job = [](void* data, std::uint32_t worker) {
        Shared& of = *static_cast<Shared*>(data);
        for (std::uint32_t n; (n = of.next.fetch_add(1, std::memory_order_relaxed)) < of.count;) of.work(n, worker);
    };
    frame.settings.jobs.run(frame.settings.jobs.user, workers, job, &shared);
}

} // namespace fjell
