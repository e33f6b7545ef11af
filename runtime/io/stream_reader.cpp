#include "fjell/io/stream_reader.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace fjell::io {

namespace {

constexpr std::chrono::microseconds idle_sleep{500};

std::uint64_t nanoseconds(std::chrono::steady_clock::duration d) {
    return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(d).count());
}

} // namespace

StreamReader::StreamReader(Stream stream, Read read, const StreamReaderOptions& options)
    : stream_(stream), read_(std::move(read)), options_(options) {
    for (std::uint32_t i = 0; i < std::max(options.threads, 1u); ++i)
        threads_.emplace_back([this](const std::stop_token& stop) { run(stop); });
}

StreamReader::~StreamReader() {
    for (std::jthread& thread : threads_) thread.request_stop(); // all of them, before the first is waited for
}

void StreamReader::run(const std::stop_token& stop) {
    std::vector<std::byte> bytes;
    while (!stop.stop_requested()) {
        StreamRequest request;
        if (!stream_next_request(stream_, request)) {
            std::this_thread::sleep_for(idle_sleep);
        } else if (!stream_still_wanted(stream_, request.ticket)) {
            (void)stream_fail(stream_, request.ticket, true);
            ++unwanted_;
        } else {
            serve(request, bytes, stop);
        }
    }
}

StreamReader::Clock::time_point StreamReader::arrival_of(std::uint32_t bytes) {
    const auto duration = [](double s) {
        return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
    };
    auto arrival = Clock::now();
    if (options_.latency_s > 0) arrival += duration(options_.latency_s);
    if (options_.bytes_per_s > 0) {
        const std::lock_guard hold(lock_);
        arrival = line_free_ = std::max(line_free_, arrival) + duration(bytes / options_.bytes_per_s);
    }
    return arrival;
}

void StreamReader::serve(const StreamRequest& request, std::vector<std::byte>& bytes, const std::stop_token& stop) {
    const auto start = Clock::now();
    const auto ready = arrival_of(request.bytes);
    if (!wait_until(ready, stop)) {
        (void)stream_fail(stream_, request.ticket, true);
        return;
    }
    if (bytes.size() < request.bytes) bytes.resize(request.bytes);
    const std::span to = std::span(bytes).first(request.bytes);
    const int error = read_(request.offset, to);
    const auto read = Clock::now();
    read_ns_ += nanoseconds(read - start);
    if (error != 0) {
        (void)stream_fail(stream_, request.ticket);
        last_error_ = error;
        ++errors_;
        return;
    }
    const Status status = stream_provide(stream_, request.ticket, to);
    provide_ns_ += nanoseconds(Clock::now() - read);
    ++reads_;
    read_bytes_ += request.bytes;
    (request.id.kind == ChunkKind::geometry ? pages_ : mips_) += request.chunks;
    if (!status.ok()) ++damaged_;
}

bool StreamReader::wait_until(Clock::time_point when, const std::stop_token& stop) {
    if (when <= Clock::now()) return true;
    std::unique_lock hold(lock_);
    stopped_.wait_until(hold, stop, when, [] { return false; });
    return !stop.stop_requested();
}

StreamReaderCounters StreamReader::counters() const {
    StreamReaderCounters c;
    c.reads = reads_;
    c.bytes = read_bytes_;
    c.pages = pages_;
    c.mips = mips_;
    c.unwanted = unwanted_;
    c.errors = errors_;
    c.damaged = damaged_;
    c.last_error = last_error_;
    c.read_s = static_cast<double>(read_ns_.load()) * 1e-9;
    c.provide_s = static_cast<double>(provide_ns_.load()) * 1e-9;
    return c;
}

} // namespace fjell::io
