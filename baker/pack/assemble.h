// A pack's chunks put together in the order in which they are wanted.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "baker/pack/chunk_spool.h"
#include "fjell/pack.h"
#include "io/file.h"

namespace fjell::baker {

// All chunks of a pack: page 0 of all tiles, then step by step, so that a prefix of the file is the whole terrain,
// coarser; then maps by kind. Linear order knows no steps: tile by tile.
[[nodiscard]] std::vector<ChunkId> chunk_sequence(const PackHeader& header);

// Copies the chunks to the file in the order given and completes header and directory. Every chunk of the pack
// must be in the sequence once. notes: what it says of its making (notes.h). moved(n): n chunks are there. Returns the
// pack's hash (directory_hash); the file is not yet committed.
std::uint64_t assemble_pack(PackHeader header, const ChunkSource& chunks, const std::vector<ChunkId>& sequence,
                            const std::string& notes, io::AtomicFile& file,
                            const std::function<void(std::uint64_t)>& moved);

} // namespace fjell::baker
