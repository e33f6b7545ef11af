// A pack that is streamed: its file, the stream over the session's terrain, and the thread that reads.
//
// Ownership: all of it; the terrain and the cut are the session's and must outlive it. Thread: the frame's; the reader
// has its own. Failure: io::Failure, 1 for an unusable budget. What cannot be read later on is one line to the
// listener, two counts, and coarser terrain.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "fjell/io/load.h"
#include "fjell/io/pack_file.h"
#include "fjell/io/stream_reader.h"
#include "fjell/stream.h"
#include "session/options.h"

namespace fjell::session {

class StreamedPack {
public:
    explicit StreamedPack(std::shared_ptr<const io::PackFile> file) : file_(std::move(file)) {}

    // Begins to stream into a terrain of which no page is loaded. cut: empty for the recursive method.
    void begin(const FlightOptions& options, Terrain& terrain, LiveCut cut);
    // Hears of the first chunk that could not be read or was damaged, within update(): "PACK: page 3 of tile 1: why",
    // without a line's end. A damaged pack may have hundreds of them: the others are counted. While nothing fails
    // nothing is allocated.
    void on_failure(std::function<void(const std::string&)> listener) { listener_ = std::move(listener); }
    // One update_stream(), before the method's own.
    const StreamReport& update(std::span<const View> views, const CutSettings& cut, const StreamSettings& settings);

    [[nodiscard]] Stream stream() const { return stream_; }
    [[nodiscard]] const StreamReport& report() const { return report_; }
    [[nodiscard]] io::StreamReaderCounters reader() const { return reader_->counters(); }
    [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_; }
    // What was damaged, and what the disk did not give.
    [[nodiscard]] std::uint64_t corrupt() const { return corrupt_; }
    [[nodiscard]] std::uint64_t unreadable() const { return unreadable_; }

private:
    void tell(const StreamFailure& failure);

    std::shared_ptr<const io::PackFile> file_;
    io::AlignedMemory memory_;
    std::size_t memory_bytes_ = 0;
    Stream stream_;
    StreamReport report_;
    std::uint64_t corrupt_ = 0, unreadable_ = 0;
    std::function<void(const std::string&)> listener_;
    std::unique_ptr<io::StreamReader> reader_; // last: it stops before what it reads for goes
};

} // namespace fjell::session
