#include "baker/pack/split.h"

#include <algorithm>
#include <vector>

#include <xxhash.h>

#include "baker/read/pack_source.h"
#include "baker/store/store.h"
#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"

namespace fjell::baker {

namespace {

using io::Failure;

class PackChunks final : public ChunkSource {
public:
    explicit PackChunks(const io::PackFile& file) : file_(file) {}
    [[nodiscard]] std::vector<ChunkEntry> entries() const override {
        std::vector<ChunkEntry> all(file_.pack().header.directory_count);
        for (std::uint64_t chunk = 0; chunk < all.size(); ++chunk) all[chunk] = file_.pack().entry(chunk);
        return all;
    }
    void read(std::uint64_t offset, std::span<std::byte> to) const override {
        if (to.empty()) return;
        if (const int error = file_.read(offset, to); error != 0) file_.fail(error);
    }
    [[nodiscard]] std::string damage(std::uint64_t offset) const override {
        const PackHeader& h = file_.pack().header;
        std::uint64_t chunk = 0;
        while (chunk + 1 < h.directory_count && file_.pack().entry(chunk).offset != offset) ++chunk;
        return file_.path() + ": " + io::chunk_name(chunk_id(h, chunk)) + ": " + message(Code::corrupt);
    }

private:
    const io::PackFile& file_;
};

// Tile by tile, because that is how a pack is read.
std::uint64_t count_voids(const HeightSource& source, const Window& samples, std::int32_t side) {
    const auto reader = source.reader();
    ReadStatistics statistics;
    std::vector<float> heights;
    // The last column and row are the next tile's first, but for the window's last tile.
    const auto size = [&](std::int32_t at, std::int32_t all) { return all - at <= side + 1 ? all - at : side; };
    for (std::int32_t y = 0; y + 1 < samples.rows; y += side)
        for (std::int32_t x = 0; x + 1 < samples.columns; x += side) {
            io::check_interrupt();
            const Window w{samples.x + x, samples.y + y, size(x, samples.columns), size(y, samples.rows)};
            heights.resize(w.area());
            reader->read(w, heights.data(), statistics);
        }
    return statistics.voids.count;
}

std::string notes_of(const io::PackFile& file) {
    const PackHeader& h = file.pack().header;
    std::string notes(static_cast<std::size_t>(h.notes_bytes), '\0');
    if (const int error = file.read(h.notes_offset, std::as_writable_bytes(std::span(notes))); error != 0)
        file.fail(error);
    if (!notes.empty() && XXH3_64bits(notes.data(), notes.size()) != h.notes_hash)
        throw Failure(1, file.path() + ": notes: " + message(Code::corrupt));
    return notes;
}

} // namespace

SetSummary split_pack(const std::string& pack, const std::string& folder, const SetGrid& grid,
                      const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    const io::PackFile file(pack);
    if (file.packs() != 1) throw Failure(1, pack + ": is a set already; give the one pack that is to be split");
    const PackHeader& whole = file.pack().header;
    check_grid(grid, whole.tiles_x, whole.tiles_y, pack);
    make_set_folder(folder);
    WorkFolder work(set_work_name(folder));
    work.empty();
    work.keep(false);
    const PackSource source(pack);
    const PackChunks chunks(file);
    const std::string notes = notes_of(file);
    const auto voids = [&](const Window& samples) {
        return count_voids(source, samples, static_cast<std::int32_t>(1u << whole.tile_log2));
    };
    return write_set({whole, chunks, notes, voids}, grid, folder, work.path(), progress);
}

} // namespace fjell::baker
