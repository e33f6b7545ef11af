// Chunks in the files that shards leave, and all of them as those of one pack.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "baker/pack/chunk_spool.h"
#include "baker/shard/plan_folder.h"
#include "baker/shard/shard_ground.h"

namespace fjell::baker {

// Appends chunks to a file and keeps their entries, 40 bytes a chunk.
class ChunkFile final : public ChunkSink {
public:
    ChunkFile(const std::string& path, const PackHeader& layout) : layout_(layout), file_(path, WorkFile::grows) {}
    void append(ChunkBatch batch) override;
    // Chunk numbers and entries: a parcel's bytes. No append() at the same time.
    [[nodiscard]] std::vector<std::byte> index() const;

private:
    PackHeader layout_;
    WorkFile file_;
    std::mutex lock_; // of what follows
    std::uint64_t end_ = 0;
    ParcelWriter index_;
};

// Those of all shards and steps, and of the merge's own spool.
class ShardChunks final : public ChunkSource {
public:
    ShardChunks(const ShardPlan& plan, const PackHeader& layout, const ChunkSpool& own, const ShardGround& ground);
    [[nodiscard]] std::vector<ChunkEntry> entries() const override { return entries_; }
    void read(std::uint64_t offset, std::span<std::byte> to) const override;
    [[nodiscard]] std::string damage(std::uint64_t offset) const override;

private:
    // Two a step and shard would be more than a system has descriptors for: few are open at a time.
    static constexpr std::size_t most_open = 32;
    struct File {
        std::uint64_t begin; // in offsets of entries
        std::uint64_t bytes;
        std::string path;
        ShardStep step;
        int shard;
    };
    struct Open {
        const File* file;
        WorkFile work;
    };
    [[nodiscard]] const File* file_at(std::uint64_t offset) const; // none: the spool
    const ShardPlan& plan_;
    const ChunkSpool& own_;
    std::uint64_t own_begin_ = 0;
    std::vector<File> files_;
    mutable std::mutex lock_;        // of what follows
    mutable std::vector<Open> open_; // the one used last at the end
    std::vector<ChunkEntry> entries_;
};

} // namespace fjell::baker
