// Our I/O threads: the client of a Stream (fjell/stream.h) that reads from a file. An engine's loader is another.
//
// Each asks for what is wanted most, reads it, hands it in, and asks again. When nothing is wanted it sleeps for half a
// millisecond: the frame's thread could only wake it by entering the kernel.
// Ownership: stream and read() must outlive the reader. Thread: it has its own; counters may be read from any.
// Destroying it stops them at any moment, whatever they are doing, and joins them: after at most one read each that is
// under way. Every request that they took has been answered by then. Failure: a read that fails is handed to
// stream_fail() and counted; it goes on.
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
    // As from a slower disk, for benchmarks and tests. 0: as fast as it goes.
    double bytes_per_s = 0; // of all threads together
    double latency_s = 0;   // before every read
    // That read and decompress side by side; StreamBudget::decoders of the stream is what can. At least 1.
    std::uint32_t threads = 1;
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
    // read: 0 or an errno, as PackFile::read; called from the reader's threads, from several at once if it has several.
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
    // When so many bytes would have come from the disk that options name.
    Clock::time_point arrival_of(std::uint32_t bytes);
    // False: it was to stop instead.
    bool wait_until(Clock::time_point when, const std::stop_token& stop);

    const Stream stream_;
    const Read read_;
    const StreamReaderOptions options_;
    Clock::time_point line_free_{}; // when what was read so far has gone through at bytes_per_s
    std::mutex lock_;               // of line_free_, and to wait with
    std::condition_variable_any stopped_;
    std::atomic<std::uint64_t> reads_{0}, read_bytes_{0}, pages_{0}, mips_{0}, unwanted_{0}, errors_{0}, damaged_{0};
    std::atomic<std::uint64_t> read_ns_{0}, provide_ns_{0};
    std::atomic<int> last_error_{0};
    std::vector<std::jthread> threads_; // last, so that all they use is there before and after them
};

} // namespace fjell::io
FJELL_API_END
