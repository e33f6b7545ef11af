// Chunks of a pack, compressed as they are made, in any order.
#pragma once

#include <cstddef>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "baker/pack/encode_page.h"
#include "baker/store/store.h"
#include "fjell/pack.h"

namespace fjell::baker {

// Some chunks on their way to the spool. One thread's.
class ChunkBatch {
public:
    void add(ChunkId id, std::span<const std::byte> raw, int zstd_level);
    void add_page(ChunkId id, const EncodedPage& page);

    struct Entry {
        ChunkId id;
        ChunkEntry entry; // offset: in bytes()
    };
    [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }
    // Leaves out those for which it is not true.
    template <typename Keeps>
    void keep_if(const Keeps& keeps) {
        std::erase_if(entries_, [&](const Entry& e) { return !keeps(e.id); });
    }
    [[nodiscard]] const Buffer<std::byte>& bytes() const { return bytes_; }

private:
    friend class ChunkSpool;
    void enter(ChunkId id, std::size_t from, std::size_t raw_bytes, const PageBound& bound); // bytes_ from `from` on
    std::vector<Entry> entries_;
    Buffer<std::byte> bytes_;
};

// Where stages leave chunks, in any order, from any thread.
class ChunkSink {
public:
    ChunkSink() = default;
    ChunkSink(const ChunkSink&) = delete;
    ChunkSink& operator=(const ChunkSink&) = delete;
    virtual ~ChunkSink() = default;
    virtual void append(ChunkBatch batch) = 0;
};

// All chunks of a pack, for putting it together.
class ChunkSource {
public:
    ChunkSource() = default;
    ChunkSource(const ChunkSource&) = delete;
    ChunkSource& operator=(const ChunkSource&) = delete;
    virtual ~ChunkSource() = default;
    // Directory entries by chunk_index, their offsets counted as read() does. One without bytes is missing.
    [[nodiscard]] virtual std::vector<ChunkEntry> entries() const = 0;
    virtual void read(std::uint64_t offset, std::span<std::byte> to) const = 0;
    // A line for a chunk that is not what its entry says.
    [[nodiscard]] virtual std::string damage(std::uint64_t offset) const = 0;
};

// What a spool holds, for a later run to go on with.
struct SpoolState {
    std::uint64_t bytes = 0; // of its chunks
    Digest chunks, entries;
};

// Compressed chunks in a work file, one behind the other. Any thread may append.
class ChunkSpool : public ChunkSink, public ChunkSource {
public:
    // Paths: empty: in memory. found: what an earlier run has left that counts; what lies behind is overwritten.
    ChunkSpool(const std::string& data_path, const std::string& entries_path, const PackHeader& layout,
               const SpoolState& found);
    [[nodiscard]] bool has_found() const; // whether what was to be found is there, to the byte. Reads all of it.
    void append(ChunkBatch batch) override;
    [[nodiscard]] SpoolState state() const; // of all batches so far; no append() at the same time
    [[nodiscard]] std::vector<ChunkEntry> entries() const override;
    void read(std::uint64_t offset, std::span<std::byte> to) const override;
    [[nodiscard]] std::string damage(std::uint64_t offset) const override;

private:
    PackHeader layout_;
    std::uint64_t count_;
    WorkFile data_, entries_;
    SpoolState found_;
    std::mutex lock_; // of what follows
    std::uint64_t end_;
    // In memory: pieces that batches are copied into, one behind the other.
    struct Piece {
        std::uint64_t begin;
        std::size_t used;
        ZeroedMemory memory;
    };
    [[nodiscard]] std::byte* room_for(std::size_t bytes); // at end_
    bool in_memory_;
    std::vector<Piece> pieces_;
};

} // namespace fjell::baker
