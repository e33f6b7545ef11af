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
    ChunkKind kind;
    std::uint32_t tile, level, raw_bytes;
    std::vector<std::byte> stored;
};
[[nodiscard]] Chunk compress_chunk(ChunkKind kind, std::uint32_t tile, std::uint32_t level,
                                   std::span<const std::byte> raw, int zstd_level);

class PackWriter {
public:
    explicit PackWriter(const std::string& path);
    void begin(const PackHeader& header); // everything but offsets, counts and hashes
    // Chunks must come in directory order (chunk_index).
    void add(const Chunk& chunk);
    std::uint64_t finish(); // the file's size

private:
    host::AtomicFile file_;
    PackHeader header_{};
    std::vector<ChunkEntry> directory_;
};

} // namespace fjell::baker
