#include "baker/write.h"

#include <cstring>
#include <memory>

#include <fmt/format.h>
#include <xxhash.h>
#include <zstd.h>

#include "baker/dem.h"

namespace fjell::baker {

namespace {

// One a thread, set for the kind of chunk. Residuals of heights are noise with hardly a match in them: looking for long
// ones only takes no more bytes, and leaves the decoder fewer.
ZSTD_CCtx* compressor(ChunkKind kind, int zstd_level) {
    thread_local const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
    if (!context) throw Failure(3, "cannot compress: not enough memory");
    const bool page = kind == ChunkKind::geometry;
    ZSTD_CCtx_reset(context.get(), ZSTD_reset_session_and_parameters);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, page ? 1 : zstd_level);
    if (page) ZSTD_CCtx_setParameter(context.get(), ZSTD_c_minMatch, 6);
    return context.get();
}

} // namespace

Chunk compress_chunk(ChunkId id, std::span<const std::byte> raw, int zstd_level) {
    Chunk chunk{id, static_cast<std::uint32_t>(raw.size()), {}};
    chunk.stored.resize(ZSTD_compressBound(raw.size()));
    const std::size_t size = ZSTD_compress2(compressor(id.kind, zstd_level), chunk.stored.data(), chunk.stored.size(),
                                            raw.data(), raw.size());
    if (ZSTD_isError(size)) throw Failure(3, fmt::format("cannot compress: {}", ZSTD_getErrorName(size)));
    chunk.stored.resize(size);
    return chunk;
}

PackWriter::PackWriter(const std::string& path) : file_(path) {
    const PackHeader empty{}; // no magic number until the pack is complete
    file_.write(std::as_bytes(std::span(&empty, 1)));
}

void PackWriter::begin(const PackHeader& header) {
    header_ = header;
    std::memcpy(header_.magic, pack_magic, sizeof pack_magic);
    header_.version = pack_version;
    header_.header_bytes = sizeof(PackHeader);
    header_.layout_hash = pack_layout_hash;
    directory_.assign(chunk_count(header_), {});
}

void PackWriter::add(const Chunk& chunk) {
    ChunkEntry& entry = directory_.at(chunk_index(header_, chunk.id));
    if (entry.offset != 0) throw std::logic_error("a chunk is written twice");
    entry.offset = file_.size();
    entry.hash = XXH3_64bits(chunk.stored.data(), chunk.stored.size());
    entry.stored_bytes = static_cast<std::uint32_t>(chunk.stored.size());
    entry.raw_bytes = chunk.raw_bytes;
    file_.write(chunk.stored);
}

std::uint64_t PackWriter::finish() {
    const auto bytes = std::as_bytes(std::span(directory_));
    header_.directory_offset = file_.size();
    header_.directory_count = directory_.size();
    header_.directory_hash = XXH3_64bits(bytes.data(), bytes.size());
    file_.write(bytes);
    header_.file_bytes = file_.size();
    header_.header_hash = XXH3_64bits(&header_, offsetof(PackHeader, header_hash));
    file_.write_at(0, std::as_bytes(std::span(&header_, 1)));
    const std::uint64_t size = file_.size();
    file_.commit();
    return size;
}

} // namespace fjell::baker
