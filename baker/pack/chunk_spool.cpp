#include "baker/pack/chunk_spool.h"

#include <algorithm>
#include <cstring>
#include <memory>

#include <fmt/format.h>
#include <xxhash.h>
#include <zstd.h>

#include "baker/pack/compress_page.h"
#include "fjell/io/failure.h"

namespace fjell::baker {

namespace {

// One a thread.
ZSTD_CCtx* compressor() {
    thread_local const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
    if (!context) throw io::Failure(3, "cannot compress: not enough memory");
    return context.get();
}

} // namespace

void ChunkBatch::add(ChunkId id, std::span<const std::byte> raw, int zstd_level) {
    const std::size_t from = bytes_.size();
    bytes_.resize(from + ZSTD_compressBound(raw.size()));
    const std::size_t size =
        ZSTD_compressCCtx(compressor(), bytes_.data() + from, bytes_.size() - from, raw.data(), raw.size(), zstd_level);
    if (ZSTD_isError(size)) throw io::Failure(3, fmt::format("cannot compress: {}", ZSTD_getErrorName(size)));
    bytes_.resize(from + size);
    enter(id, from, raw.size(), {});
}

void ChunkBatch::add_page(ChunkId id, const EncodedPage& page) {
    const std::size_t from = bytes_.size();
    compress_page(page.bytes, page.low_end, bytes_);
    enter(id, from, page.bytes.size(), page.bound);
}

void ChunkBatch::enter(ChunkId id, std::size_t from, std::size_t raw_bytes, const PageBound& bound) {
    const std::size_t size = bytes_.size() - from;
    entries_.push_back({id,
                        {from, XXH3_64bits(bytes_.data() + from, size), static_cast<std::uint32_t>(size),
                         static_cast<std::uint32_t>(raw_bytes), bound}});
}

ChunkSpool::ChunkSpool(const std::string& data_path, const std::string& entries_path, const PackHeader& layout,
                       const SpoolState& found)
    : layout_(layout), count_(chunk_count(layout)), entries_(entries_path, count_ * sizeof(ChunkEntry)), found_(found),
      end_(found.bytes), in_memory_(data_path.empty()) {
    if (!in_memory_) data_ = WorkFile(data_path, WorkFile::grows);
}

bool ChunkSpool::has_found() const {
    if (data_.size() < found_.bytes || data_.digest(found_.bytes) != found_.chunks) return false;
    // Entries of the stage that was interrupted are there or not: those count whose chunks do.
    std::vector<ChunkEntry> all = entries();
    for (ChunkEntry& entry : all)
        if (entry.offset >= found_.bytes) entry = {};
    return digest_of(0, std::as_bytes(std::span(all))) == found_.entries;
}

std::byte* ChunkSpool::room_for(std::size_t bytes) {
    constexpr std::size_t piece_bytes = std::size_t{16} << 20;
    if (pieces_.empty() || pieces_.back().memory.size() - pieces_.back().used < bytes)
        pieces_.push_back({end_, 0, ZeroedMemory(std::max(bytes, piece_bytes))});
    Piece& last = pieces_.back();
    std::byte* const at = last.memory.data() + last.used;
    last.used += bytes;
    return at;
}

void ChunkSpool::append(ChunkBatch batch) {
    std::unique_lock hold(lock_);
    const std::uint64_t at = end_;
    std::byte* const to = in_memory_ ? room_for(batch.bytes_.size()) : nullptr;
    end_ += batch.bytes_.size();
    hold.unlock();
    if (in_memory_)
        std::copy(batch.bytes_.begin(), batch.bytes_.end(), to);
    else
        data_.write(at, batch.bytes_);
    for (const ChunkBatch::Entry& e : batch.entries_) {
        ChunkEntry entry = e.entry;
        entry.offset += at;
        entries_.write(chunk_index(layout_, e.id) * sizeof entry, std::as_bytes(std::span(&entry, 1)));
    }
}

void ChunkSpool::read(std::uint64_t offset, std::span<std::byte> to) const {
    if (!in_memory_) return data_.read(offset, to);
    auto piece = std::upper_bound(pieces_.begin(), pieces_.end(), offset,
                                  [](std::uint64_t at, const Piece& p) { return at < p.begin; }) -
                 1;
    for (; !to.empty(); ++piece) {
        const std::size_t from = offset - piece->begin, count = std::min(to.size(), piece->used - from);
        std::memcpy(to.data(), piece->memory.data() + from, count);
        to = to.subspan(count);
        offset += count;
    }
}

std::string ChunkSpool::damage(std::uint64_t) const {
    return "the work folder was damaged while the bake ran; bake again, on another disk if it happens again";
}

SpoolState ChunkSpool::state() const {
    SpoolState now{end_, found_.chunks, found_.entries};
    now.chunks += data_.written();
    now.entries += entries_.written();
    return now;
}

std::vector<ChunkEntry> ChunkSpool::entries() const {
    std::vector<ChunkEntry> all(count_);
    entries_.read(0, std::as_writable_bytes(std::span(all)));
    return all;
}

} // namespace fjell::baker
