// The host's job system, as Fjell may use it: to build a mesh from nothing, or after a jump of the camera, on several
// threads. Everything else runs on the calling thread.
#pragma once

#include <cstdint>

#include "fjell/export.h"

FJELL_API_BEGIN
namespace fjell {

inline constexpr std::uint32_t max_cut_workers = 64;

// A parallel loop. run must call job(data, 0) to job(data, count - 1) once each, on any threads and in any order. It
// must return when all jobs have returned and their writes are visible to the caller. Fjell calls run on the thread
// that called Fjell: some dozens of times in an update that has much to build, and never in most updates. A job takes
// some microseconds to some milliseconds. It does not block or allocate, and the waiting thread may run it. The result
// does not depend on the number of threads or on the order. nullptr: jobs run on the calling thread.
struct JobSystem {
    void (*run)(void* user, std::uint32_t count, void (*job)(void* data, std::uint32_t index), void* data) = nullptr;
    void* user = nullptr; // the host's pointer, which is passed to run
};

} // namespace fjell
FJELL_API_END
