// Chunks of a pack: compressed as they are made, in any order, and put together in the order in which they are wanted.
#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "baker/bake/store.h"
#include "fjell/pack.h"
#include "io/file.h"

namespace fjell::baker {

// Some chunks on their way to the spool, one thread's.
class ChunkBatch {
public:
    void add(ChunkId id, std::span<const std::byte> raw, int zstd_level, const PageBound& bound = {});

private:
    friend class ChunkSpool;
    struct Entry {
        ChunkId id;
        ChunkEntry entry; // offset: in bytes_
    };
    std::vector<Entry> entries_;
    std::vector<std::byte> bytes_;
};

// Compressed chunks in a work file, by the order in which they came. Any thread may append.
class ChunkSpool {
public:
    ChunkSpool(const std::string& data_path, const std::string& entries_path, const PackHeader& layout,
               std::uint64_t bytes_so_far);
    void append(ChunkBatch batch);
    [[nodiscard]] std::uint64_t bytes(); // what has come, whole batches
    // What a chunk's bytes are worth: entries with offsets in the spool, by chunk_index.
    [[nodiscard]] std::vector<ChunkEntry> entries() const;
    void read(std::uint64_t offset, std::span<std::byte> to) const;

private:
    PackHeader layout_;
    std::uint64_t count_;
    WorkFile data_, entries_;
    std::mutex lock_; // of what follows
    std::uint64_t end_;
    // In memory: batches as they came, and where each begins.
    bool in_memory_;
    std::vector<std::vector<std::byte>> batches_;
    std::vector<std::uint64_t> begins_;
};

// Copies the spool's chunks to the file in the order given and completes header and directory. Every chunk of the pack
// must be in the sequence once. moved(n): n chunks are there. Returns the file's size; it is not yet committed.
std::uint64_t assemble_pack(PackHeader header, const ChunkSpool& spool, const std::vector<ChunkId>& sequence,
                            io::AtomicFile& file, const std::function<void(std::uint64_t)>& moved);

} // namespace fjell::baker
