#include "baker/shard/shard_chunks.h"

#include <algorithm>

namespace fjell::baker {

void ChunkFile::append(ChunkBatch batch) {
    std::unique_lock hold(lock_);
    const std::uint64_t at = end_;
    end_ += batch.bytes().size();
    for (const ChunkBatch::Entry& e : batch.entries()) {
        ChunkEntry entry = e.entry;
        entry.offset += at;
        index_.put(chunk_index(layout_, e.id));
        index_.put(entry);
    }
    hold.unlock();
    file_.write(at, batch.bytes());
}

std::vector<std::byte> ChunkFile::index() const {
    return index_.bytes;
}

ShardChunks::ShardChunks(const ShardPlan& plan, const PackHeader& layout, const ChunkSpool& own,
                         const ShardGround& ground)
    : plan_(plan), own_(own), entries_(chunk_count(layout)) {
    std::uint64_t begin = 0;
    for (const ShardStep& step : shard_steps(plan.rounds)) {
        if (step.kind != ShardStep::Kind::errors) continue;
        for (int shard = 1; shard <= plan.shards; ++shard) {
            if (ground.idles(shard)) continue;
            const ShardRecord record = require_record(plan, step, shard);
            const std::uint64_t bytes = record.files.at("chunks").bytes;
            const std::string path = plan.file(step, shard, "chunks");
            files_.push_back({begin, bytes, path, step, shard});
            const std::vector<std::byte> index = read_parcel(plan, step, shard, "index");
            for (ParcelReader from(index); !from.ended();) {
                const auto chunk = from.get<std::uint64_t>();
                auto entry = from.get<ChunkEntry>();
                entry.offset += begin;
                entries_.at(chunk) = entry;
            }
            begin += bytes + 1; // so that no run of chunks leads from one file into the next
        }
    }
    own_begin_ = begin;
    const std::vector<ChunkEntry> rest = own.entries();
    for (std::size_t i = 0; i < rest.size(); ++i)
        if (rest[i].stored_bytes != 0) {
            entries_[i] = rest[i];
            entries_[i].offset += own_begin_;
        }
}

const ShardChunks::File* ShardChunks::file_at(std::uint64_t offset) const {
    if (offset >= own_begin_ || files_.empty()) return nullptr;
    const auto after = std::upper_bound(files_.begin(), files_.end(), offset,
                                        [](std::uint64_t at, const File& file) { return at < file.begin; });
    return &*(after - 1);
}

void ShardChunks::read(std::uint64_t offset, std::span<std::byte> to) const {
    if (to.empty()) return;
    const File* const file = file_at(offset);
    if (file == nullptr) return own_.read(offset - own_begin_, to);
    const std::lock_guard hold(lock_);
    const auto found = std::find_if(open_.begin(), open_.end(), [&](const Open& open) { return open.file == file; });
    if (found != open_.end()) {
        std::rotate(found, found + 1, open_.end());
    } else {
        if (open_.size() == most_open) open_.erase(open_.begin());
        open_.push_back({file, WorkFile::complete(file->path, file->bytes)});
    }
    open_.back().work.read(offset - file->begin, to);
}

std::string ShardChunks::damage(std::uint64_t offset) const {
    const File* const file = file_at(offset);
    return file ? plan_.damage(file->step, file->shard, file->path) : own_.damage(offset);
}

} // namespace fjell::baker
