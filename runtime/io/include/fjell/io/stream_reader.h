// Threads that read for a Stream (fjell/stream.h) from a file. An engine may use its own loader instead.
//
// Each thread asks for the request that is wanted most, reads it, hands it in, and asks again. If nothing is wanted, it
// sleeps for half a millisecond, because the frame's thread could wake it only by entering the kernel.
// Ownership: stream and read() must outlive the reader. Thread: counters() may be called on any. The destructor may run
// at any time. It stops and joins the threads, each after at most the read that is under way, and every request that
// they have taken is answered by then. Failure: a read that fails is passed to stream_fail() and counted; the reader
// goes on.
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

struct StreamReaderOptions {
    // To imitate a slower disk in benchmarks and tests. 0: as fast as possible.
    double bytes_per_s = 0; // of all threads together
    double latency_s = 0;   // before every read
    // Threads that read and decompress side by side, at least 1. At most StreamBudget::decoders of them decompress at a
    // time.
    std::uint32_t threads = 1;
};

// What was read so far.
struct StreamReaderCounters {
    std::uint64_t reads = 0, bytes = 0; // that succeeded
    std::uint64_t pages = 0, mips = 0;  // in those reads
    // Requests that were cancelled before they were read.
    std::uint64_t unwanted = 0;
    std::uint64_t errors = 0;  // reads that failed
    std::uint64_t damaged = 0; // chunks that were read, but that stream_provide() refused
    int last_error = 0;        // errno of the last read that failed
    double read_s = 0;         // time spent in reads, with the delays of the options
    double provide_s = 0;      // time spent in checking and decompressing
};

// Reads until it is destroyed.
class StreamReader {
public:
    // Reads bytes at an offset; returns 0 or an errno, as PackFile::read() does. Called on the reader's threads, on
    // several at once if it has several.
    using Read = std::function<int(std::uint64_t offset, std::span<std::byte> to)>;
    StreamReader(Stream stream, Read read, const StreamReaderOptions& options = {});
    StreamReader(Stream stream, const PackFile& file, const StreamReaderOptions& options = {})
        : StreamReader(
              stream, [&file](std::uint64_t offset, std::span<std::byte> to) { return file.read(offset, to); },
              options) {}
    ~StreamReader();
    StreamReader(const StreamReader&) = delete;
    StreamReader& operator=(const StreamReader&) = delete;

    [[nodiscard]] StreamReaderCounters counters() const;

private:
    using Clock = std::chrono::steady_clock;
    void run(const std::stop_token& stop);
    void serve(const StreamRequest& request, std::vector<std::byte>& bytes, const std::stop_token& stop);
    // When so many bytes would have arrived from the disk that the options describe.
    Clock::time_point arrival_of(std::uint32_t bytes);
    // False: the reader is to stop.
    bool wait_until(Clock::time_point when, const std::stop_token& stop);

    const Stream stream_;
    const Read read_;
    const StreamReaderOptions options_;
    Clock::time_point line_free_{}; // when the bytes read so far have passed at bytes_per_s
    std::mutex lock_;               // protects line_free_, and is waited with
    std::condition_variable_any stopped_;
    std::atomic<std::uint64_t> reads_{0}, read_bytes_{0}, pages_{0}, mips_{0}, unwanted_{0}, errors_{0}, damaged_{0};
    std::atomic<std::uint64_t> read_ns_{0}, provide_ns_{0};
    std::atomic<int> last_error_{0};
    // Last, so that everything the threads use is created before them and destroyed after them.
    std::vector<std::jthread> threads_;
};

} // namespace fjell::io
FJELL_API_END
