// Writes a pack beside its place and renames it when complete.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "fjell/pack.h"
#include "host/file.h"

namespace fjell::baker {

// One compressed chunk, ready to be written.
struct Chunk {
    ChunkId id;
    std::uint32_t raw_bytes;
    std::vector<std::byte> stored;
};
[[nodiscard]] Chunk compress_chunk(ChunkId id, std::span<const std::byte> raw, int zstd_level);

class PackWriter {
public:
    explicit PackWriter(const std::string& path);
    void begin(const PackHeader& header); // everything but offsets, counts and hashes
    // Chunks may come in any order, each one once.
    void add(const Chunk& chunk);
    std::uint64_t finish(); // the file's size

private:
    host::AtomicFile file_;
    PackHeader header_{};
    std::vector<ChunkEntry> directory_;
};

} // namespace fjell::baker
