#include "baker/pack/assemble.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include <xxhash.h>

#include "fjell/io/failure.h"
#include "shared/order.h"

namespace fjell::baker {

namespace {

// Chunks that follow each other there are copied in one go, and compared with their hashes: what lies in files between
// here and the stage that made it may be damaged.
class Copier {
public:
    Copier(const ChunkSource& chunks, io::AtomicFile& file) : chunks_(chunks), file_(file) {}
    void add(const ChunkEntry& chunk) {
        if (chunk.offset != from_ + bytes_ || bytes_ + chunk.stored_bytes > most) flush(), from_ = chunk.offset;
        bytes_ += chunk.stored_bytes;
        pending_.push_back(chunk);
    }
    void flush() {
        buffer_.resize(bytes_);
        chunks_.read(from_, buffer_);
        for (const ChunkEntry& c : pending_)
            if (XXH3_64bits(buffer_.data() + (c.offset - from_), c.stored_bytes) != c.hash)
                throw io::Failure(1, chunks_.damage(c.offset));
        file_.write(buffer_);
        bytes_ = 0;
        pending_.clear();
    }

private:
    static constexpr std::uint64_t most = std::uint64_t{4} << 20;
    const ChunkSource& chunks_;
    io::AtomicFile& file_;
    Buffer<std::byte> buffer_;
    std::vector<ChunkEntry> pending_;
    std::uint64_t from_ = 0, bytes_ = 0;
};

} // namespace

std::vector<ChunkId> chunk_sequence(const PackHeader& header) {
    const PageLayout layout = pages_of(header);
    std::vector<ChunkId> sequence{{ChunkKind::corners, 0, 0}};
    const std::uint32_t tiles = header.tiles_x * header.tiles_y, pages = layout.pages_per_tile();
    const auto add_pages = [&](std::uint32_t from, std::uint32_t to) {
        for (std::uint32_t tile = 0; tile < tiles; ++tile)
            for (std::uint32_t page = from; page < to; ++page) sequence.push_back({ChunkKind::geometry, tile, page});
    };
    if (layout.order == PageOrder::linear) {
        add_pages(0, pages);
    } else {
        add_pages(0, 1);
        for (std::uint32_t page = 1; page < pages;) {
            std::uint32_t end = page;
            while (end < pages && layout.page_step_log2(end) == layout.page_step_log2(page)) ++end;
            add_pages(page, end);
            page = end;
        }
    }
    const auto add_maps = [&](ChunkKind kind, std::uint32_t log2_side) {
        for (std::uint32_t tile = 0; tile < tiles; ++tile)
            for (std::uint32_t mip = 0; mip < mip_count(log2_side); ++mip) sequence.push_back({kind, tile, mip});
    };
    add_maps(ChunkKind::colour, header.colour_log2);
    add_maps(ChunkKind::normal, header.normal_log2);
    add_maps(ChunkKind::horizon, header.horizon_log2);
    add_maps(ChunkKind::splat, header.splat_log2);
    if (header.crs_bytes) sequence.push_back({ChunkKind::crs, 0, 0});
    if (header.layer_bytes) sequence.push_back({ChunkKind::layers, 0, 0});
    return sequence;
}

std::uint64_t assemble_pack(PackHeader header, const ChunkSource& chunks, const std::vector<ChunkId>& sequence,
                            const std::string& notes, io::AtomicFile& file,
                            const std::function<void(std::uint64_t)>& moved) {
    std::memcpy(header.magic, pack_magic, sizeof pack_magic);
    header.version = pack_version;
    header.features = features_of(header);
    header.header_bytes = sizeof(PackHeader);
    header.layout_hash = pack_layout_hash;
    const PackHeader empty{}; // no magic number until the pack is complete
    file.write(std::as_bytes(std::span(&empty, 1)));

    std::vector<ChunkEntry> directory = chunks.entries();
    Copier copier(chunks, file);
    std::uint64_t end = sizeof(PackHeader), done = 0;
    for (const ChunkId& id : sequence) {
        ChunkEntry& entry = directory.at(chunk_index(header, id));
        if (entry.stored_bytes == 0) throw std::logic_error("a chunk is missing");
        copier.add(entry);
        entry.offset = end;
        end += entry.stored_bytes;
        if (++done % 1024 == 0) moved(done);
    }
    copier.flush();
    if (done != directory.size()) throw std::logic_error("a chunk is missing from the sequence");
    header.notes_offset = notes.empty() ? 0 : file.size();
    header.notes_bytes = notes.size();
    header.notes_hash = notes.empty() ? 0 : XXH3_64bits(notes.data(), notes.size());
    file.write(std::as_bytes(std::span(notes)));
    const auto bytes = std::as_bytes(std::span(directory));
    header.directory_offset = file.size();
    header.directory_count = directory.size();
    header.directory_hash = XXH3_64bits(bytes.data(), bytes.size());
    file.write(bytes);
    header.file_bytes = file.size();
    header.header_hash = XXH3_64bits(&header, offsetof(PackHeader, header_hash));
    file.write_at(0, std::as_bytes(std::span(&header, 1)));
    return header.directory_hash;
}

} // namespace fjell::baker
