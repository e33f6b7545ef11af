// A stream over a terrain, with its memory and the threads that read for it: from a pack's file, or from bytes in
// memory.
//
// Ownership: its own memory and threads; file or bytes, terrain and cut must outlive it. Thread: the frame's. Failure:
// io::Failure, 1 for an unusable budget. What cannot be read later on is counted, and coarser terrain.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "fjell/io/load.h"
#include "fjell/io/pack_file.h"
#include "fjell/io/stream_reader.h"
#include "fjell/stream.h"

FJELL_API_BEGIN
namespace fjell::io {

class PackStream {
public:
    // From a file; begin() must be called before anything else.
    explicit PackStream(const PackFile& file) : pack_(&file.pack()), name_(file.path()), file_(&file) {}
    // From a pack whose bytes are in memory. name: for messages.
    PackStream(const Pack& pack, std::string name) : pack_(&pack), name_(std::move(name)) {}

    // Begins to stream into a terrain of which no page is loaded. cut: empty for the recursive method.
    void begin(const Terrain& terrain, LiveCut cut, const StreamBudget& budget, const StreamReaderOptions& options);
    // One update_stream(), before the method's own. Allocates nothing.
    const StreamReport& update(std::span<const View> views, const CutSettings& cut, const StreamSettings& settings);

    [[nodiscard]] Stream stream() const { return stream_; }
    [[nodiscard]] const StreamReport& report() const { return report_; }
    [[nodiscard]] StreamReaderCounters reader() const { return reader_->counters(); }
    [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_; }
    // What was damaged, and what the disk did not give.
    [[nodiscard]] std::uint64_t corrupt() const { return corrupt_; }
    [[nodiscard]] std::uint64_t unreadable() const { return unreadable_; }
    // Of the first of them: "PACK: page 3 of tile 1: why", without a line's end; empty: none. Allocates.
    [[nodiscard]] std::string first_failure() const;

private:
    const Pack* pack_;
    std::string name_;
    const PackFile* file_ = nullptr; // none: in memory
    AlignedMemory memory_;
    std::size_t memory_bytes_ = 0;
    Stream stream_;
    StreamReport report_;
    std::uint64_t corrupt_ = 0, unreadable_ = 0;
    StreamFailure first_;
    std::unique_ptr<StreamReader> reader_; // last: it stops before what it reads for goes
};

} // namespace fjell::io
FJELL_API_END
