// Our I/O thread: the client of a Stream (fjell/stream.h) that reads from a file. An engine's loader is another.
//
// It asks for what is wanted most, reads it, hands it in, and asks again. When nothing is wanted it sleeps for half a
// millisecond: the frame's thread could only wake it by entering the kernel.
// Ownership: stream and read() must outlive the reader. Thread: it is one; counters may be read from any. Destroying it
// stops it at any moment, whatever it is doing, and joins it: after at most one read that is under way. Every request
// that it took has been answered by then. Failure: a read that fails is handed to stream_fail() and counted; it goes
// on.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "fjell/export.h"
#include "fjell/io/pack_file.h"
#include "fjell/stream.h"

FJELL_API_BEGIN
namespace fjell::io {

// For benchmarks and tests: a slower disk.
struct StreamReaderOptions {
    // As from a slower disk, for benchmarks and tests. 0: as fast as it goes.
    double bytes_per_s = 0;
    double latency_s = 0; // before every read
};

// What was read so far.
struct StreamReaderCounters {
    std::uint64_t reads = 0, bytes = 0; // that succeeded
    std::uint64_t pages = 0, mips = 0;  // in them
    std::uint64_t unwanted = 0;         // requests that were withdrawn before they were read
    std::uint64_t errors = 0;           // reads that failed
    std::uint64_t damaged = 0;          // read, but refused by stream_provide()
    int last_error = 0;                 // errno of the last one that failed
    double read_s = 0;                  // in reads, with what options add
    double provide_s = 0;               // in checking and decompressing
};

// Reads until it is destroyed.
class StreamReader {
public:
    // read: 0 or an errno, as PackFile::read; called from the reader's thread.
    using Read = std::function<int(std::uint64_t offset, std::span<std::byte> to)>;
    StreamReader(Stream stream, Read read, const StreamReaderOptions& options = {});
    StreamReader(Stream stream, const PackFile& file, const StreamReaderOptions& options = {})
        : StreamReader(
              stream, [&file](std::uint64_t offset, std::span<std::byte> to) { return file.read(offset, to); },
              options) {}
    ~StreamReader() = default; // the thread goes first: it stops and is joined
    StreamReader(const StreamReader&) = delete;
    StreamReader& operator=(const StreamReader&) = delete;

    [[nodiscard]] StreamReaderCounters counters() const;

private:
    using Clock = std::chrono::steady_clock;
    void run(const std::stop_token& stop);
    void serve(const StreamRequest& request, const std::stop_token& stop);
    // False: it was to stop instead.
    bool wait_until(Clock::time_point when, const std::stop_token& stop);

    const Stream stream_;
    const Read read_;
    const StreamReaderOptions options_;
    std::vector<std::byte> bytes_;
    Clock::time_point line_free_{}; // when what was read so far has gone through at bytes_per_s
    std::mutex lock_;
    std::condition_variable_any stopped_;
    std::atomic<std::uint64_t> reads_{0}, read_bytes_{0}, pages_{0}, mips_{0}, unwanted_{0}, errors_{0}, damaged_{0};
    std::atomic<std::uint64_t> read_ns_{0}, provide_ns_{0};
    std::atomic<int> last_error_{0};
    std::jthread thread_; // last, so that all it uses is there before and after it
};

} // namespace fjell::io
FJELL_API_END
