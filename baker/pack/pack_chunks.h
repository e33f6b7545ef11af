// A pack's chunks as they lie in its file, for a pack that is made of them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "baker/pack/chunk_spool.h"
#include "fjell/io/pack_file.h"

namespace fjell::baker {

class PackChunks final : public ChunkSource {
public:
    explicit PackChunks(const io::PackFile& file) : file_(file) {} // keeps the reference
    [[nodiscard]] std::vector<ChunkEntry> entries() const override;
    void read(std::uint64_t offset, std::span<std::byte> to) const override;
    [[nodiscard]] std::string damage(std::uint64_t offset) const override;

private:
    const io::PackFile& file_;
};

} // namespace fjell::baker
