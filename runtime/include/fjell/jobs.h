// The host's job system, as Fjell may use it: to build what a camera sees from nothing, or after a jump, on several
// threads. Everything else runs on the thread that calls.
#pragma once

#include <cstdint>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

inline constexpr std::uint32_t max_cut_workers = 64;

// run calls job(data, 0) to job(data, count - 1), each once, on any threads and in any order, and returns when all of
// them have returned and what they wrote can be read: a parallel loop. It is called on the thread that called Fjell,
// some dozens of times in an update that has much to build, and not at all in most. A job takes some microseconds to
// some milliseconds, does not block or allocate, and may be run by the thread that waits. Results do not depend on how
// many threads there are, or on their order. nullptr: jobs run on the thread that calls.
struct JobSystem {
    void (*run)(void* user, std::uint32_t count, void (*job)(void* data, std::uint32_t index), void* data) = nullptr;
    void* user = nullptr; // the host's, passed on to run
};

} // namespace fjell
FJELL_API_END
