#include "baker/pack/write_set.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <xxhash.h>
#include <zstd.h>

#include "baker/pack/assemble.h"
#include "baker/pack/pack_chunks.h"
#include "baker/read/pack_source.h"
#include "baker/store/store.h"
#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "io/file.h"
#include "io/set_file.h"

namespace fjell::baker {

namespace {

using io::Failure;
namespace fs = std::filesystem;

struct Rectangle {
    std::uint32_t x, y, tiles_x, tiles_y;
};

// The n-th of so many parts of a row of tiles, as even as they can be.
std::uint32_t part_begin(std::uint32_t n, std::uint32_t parts, std::uint32_t tiles) {
    return static_cast<std::uint32_t>(std::uint64_t{n} * tiles / parts);
}

Rectangle rectangle_of(const SetGrid& grid, const PackHeader& whole, std::uint32_t px, std::uint32_t py) {
    const std::uint32_t x = part_begin(px, grid.packs_x, whole.tiles_x),
                        y = part_begin(py, grid.packs_y, whole.tiles_y);
    return {x, y, part_begin(px + 1, grid.packs_x, whole.tiles_x) - x,
            part_begin(py + 1, grid.packs_y, whole.tiles_y) - y};
}

PackHeader header_of(const PackHeader& whole, const Rectangle& r) {
    PackHeader h = whole;
    const std::uint32_t side = 1u << whole.tile_log2;
    h.columns = std::min(r.tiles_x * side + 1, whole.columns - r.x * side);
    h.rows = std::min(r.tiles_y * side + 1, whole.rows - r.y * side);
    h.tiles_x = r.tiles_x;
    h.tiles_y = r.tiles_y;
    // CRS axes: north is up.
    const double cells[2] = {static_cast<double>(r.x) * side, -static_cast<double>(r.y) * side};
    for (const int axis : {0, 1})
        h.crs_origin[axis] += cells[axis] * (h.crs_step[axis] > 0 ? h.crs_step[axis] : h.spacing_m[axis]);
    return h;
}

bool has_ground(const PackHeader& h) {
    return h.voids < std::uint64_t{h.columns} * h.rows;
}

// The whole's corners, decoded; its first chunk.
std::vector<std::byte> corners_of(const ChunkSource& chunks, const ChunkEntry& entry) {
    std::vector<std::byte> stored(entry.stored_bytes), raw(entry.raw_bytes);
    chunks.read(entry.offset, stored);
    if (XXH3_64bits(stored.data(), stored.size()) != entry.hash ||
        ZSTD_decompress(raw.data(), raw.size(), stored.data(), stored.size()) != raw.size())
        throw Failure(1, chunks.damage(entry.offset));
    return raw;
}

// The chunks of a rectangle as those of a pack: the whole's, but for the corners, of which it has its own.
class PartChunks final : public ChunkSource {
public:
    PartChunks(const PackHeader& whole, const ChunkSource& chunks, const std::vector<ChunkEntry>& entries,
               const std::vector<std::byte>& corners, const PackHeader& part, const Rectangle& r)
        : chunks_(chunks), entries_(chunk_count(part)) {
        for (std::uint64_t chunk = 1; chunk < entries_.size(); ++chunk) {
            ChunkId id = chunk_id(part, chunk);
            if (id.kind != ChunkKind::crs && id.kind != ChunkKind::layers)
                id.tile = (r.y + id.tile / r.tiles_x) * whole.tiles_x + r.x + id.tile % r.tiles_x;
            entries_[chunk] = entries[chunk_index(whole, id)];
        }
        cut_corners(corners, whole.tiles_x, r);
    }
    [[nodiscard]] std::vector<ChunkEntry> entries() const override { return entries_; }
    void read(std::uint64_t offset, std::span<std::byte> to) const override {
        if (offset < own_begin) return chunks_.read(offset, to);
        std::copy_n(corners_.begin() + static_cast<std::ptrdiff_t>(offset - own_begin), to.size(), to.begin());
    }
    [[nodiscard]] std::string damage(std::uint64_t offset) const override { return chunks_.damage(offset); }

private:
    static constexpr std::uint64_t own_begin = std::uint64_t{1} << 62; // in offsets of entries

    void cut_corners(const std::vector<std::byte>& of_whole, std::size_t whole_tiles_x, const Rectangle& r) {
        const std::size_t a_row = (r.tiles_x + std::size_t{1}) * 4, whole_row = (whole_tiles_x + 1) * 4;
        std::vector<std::byte> raw;
        for (std::size_t y = 0; y <= r.tiles_y; ++y) {
            const auto from = of_whole.begin() + static_cast<std::ptrdiff_t>((r.y + y) * whole_row + r.x * 4);
            raw.insert(raw.end(), from, from + static_cast<std::ptrdiff_t>(a_row));
        }
        corners_.resize(ZSTD_compressBound(raw.size()));
        const std::size_t size = ZSTD_compress(corners_.data(), corners_.size(), raw.data(), raw.size(), 3);
        if (ZSTD_isError(size)) throw Failure(3, fmt::format("cannot compress: {}", ZSTD_getErrorName(size)));
        corners_.resize(size);
        entries_[0] = {own_begin,
                       XXH3_64bits(corners_.data(), size),
                       static_cast<std::uint32_t>(size),
                       static_cast<std::uint32_t>(raw.size()),
                       {}};
    }

    const ChunkSource& chunks_;
    std::vector<ChunkEntry> entries_;
    std::vector<std::byte> corners_;
};

// Packs that the index of a folder names, or the list of those that an interrupted publish() has still to remove.
std::vector<std::string> named_in(const fs::path& index) {
    std::vector<std::string> names;
    try {
        for (const io::SetFilePack& pack : io::parse_set_file(io::read_text(index.string()), index.string()).packs)
            names.push_back(pack.file);
    } catch (const Failure&) { // none, or damaged: then it names nothing
    }
    return names;
}

// Packs of the set that is replaced, which the new one has no use for. Written down before the old index goes, which
// alone names them; as an index, though nobody opens it.
std::vector<std::string> note_old_packs(const io::SetFile& set, const fs::path& folder) {
    std::vector<std::string> old = named_in(folder / "set.json");
    const std::vector<std::string> before = named_in(folder / "set.old");
    old.insert(old.end(), before.begin(), before.end());
    std::sort(old.begin(), old.end());
    old.erase(std::unique(old.begin(), old.end()), old.end());
    std::erase_if(old, [&](const std::string& name) {
        return std::any_of(set.packs.begin(), set.packs.end(), [&](const auto& pack) { return pack.file == name; });
    });
    if (old.empty()) return old;
    io::SetFile list = set;
    list.packs.clear();
    for (const std::string& name : old) list.packs.push_back({name, 0, 0, 1, 1, 0, false});
    write_set_index(list, (folder / "set.old").string());
    return old;
}

// The index goes first and comes last.
void publish(const io::SetFile& set, const std::string& folder, const std::string& work) {
    const fs::path to(folder);
    const std::string index = (to / "set.json").string();
    std::error_code error;
    const std::vector<std::string> old = note_old_packs(set, to);
    fs::remove(index, error);
    if (error) errno = error.value(), io::disk_failure(index, "replace");
    for (const io::SetFilePack& pack : set.packs) {
        fs::rename(fs::path(work) / pack.file, to / pack.file, error);
        if (error) errno = error.value(), io::disk_failure((to / pack.file).string(), "rename");
    }
    write_set_index(set, index);
    bool gone = true; // what cannot be removed now stays in the list
    for (const std::string& name : old) gone = (fs::remove(to / name, error), !error) && gone;
    if (gone) fs::remove(to / "set.old", error);
}

} // namespace

Window tiles_of_pack(const SetGrid& grid, const Tree& tree, std::uint32_t px, std::uint32_t py) {
    const auto begin_x = [&](std::uint32_t n) {
        return static_cast<std::int32_t>(part_begin(n, grid.packs_x, static_cast<std::uint32_t>(tree.tiles_x)));
    };
    const auto begin_y = [&](std::uint32_t n) {
        return static_cast<std::int32_t>(part_begin(n, grid.packs_y, static_cast<std::uint32_t>(tree.tiles_y)));
    };
    return {begin_x(px), begin_y(py), begin_x(px + 1) - begin_x(px), begin_y(py + 1) - begin_y(py)};
}

void check_grid(const SetGrid& grid, std::uint32_t tiles_x, std::uint32_t tiles_y, const std::string& name) {
    if (grid.packs_x < 1 || grid.packs_y < 1 || grid.packs_x > tiles_x || grid.packs_y > tiles_y)
        throw Failure(2, fmt::format("{}: has {} x {} tiles, which cannot be split into {} x {} packs; give fewer to "
                                     "--packs, or bake it with a smaller --tile",
                                     name, tiles_x, tiles_y, grid.packs_x, grid.packs_y));
}

void make_set_folder(const std::string& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw Failure(1, folder + ": cannot be made (" + error.message() + "); choose another folder");
}

void write_set_index(const io::SetFile& set, const std::string& path) {
    io::AtomicFile file(path);
    const std::string text = io::set_file_text(set);
    file.write(std::as_bytes(std::span(text)));
    file.commit();
}

std::string set_work_name(const std::string& folder) {
    return (fs::path(folder) / "set").string();
}

SetSummary write_set(const SetInput& whole, const SetGrid& grid, const std::string& folder, const std::string& work,
                     const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    const PackHeader& h = whole.header;
    const std::vector<ChunkEntry> entries = whole.chunks.entries();
    const std::vector<std::byte> corners = corners_of(whole.chunks, entries.at(0));
    const std::uint32_t side = 1u << h.tile_log2;
    SetSummary summary;
    io::SetFile set{h.columns, h.rows, side, {h.spacing_m[0], h.spacing_m[1]}, {}};
    std::uint64_t done = 0;
    for (std::uint32_t py = 0; py < grid.packs_y; ++py)
        for (std::uint32_t px = 0; px < grid.packs_x; ++px) {
            const Rectangle r = rectangle_of(grid, h, px, py);
            PackHeader part = header_of(h, r);
            if (h.voids != 0)
                part.voids =
                    whole.voids({static_cast<std::int32_t>(r.x * side), static_cast<std::int32_t>(r.y * side),
                                 static_cast<std::int32_t>(part.columns), static_cast<std::int32_t>(part.rows)});
            done += std::uint64_t{r.tiles_x} * r.tiles_y;
            if (!has_ground(part)) {
                ++summary.left_out;
                continue;
            }
            const std::string name = fmt::format("{}-{}.fjell", px, py);
            io::AtomicFile out((fs::path(work) / name).string());
            const std::uint64_t hash =
                assemble_pack(part, PartChunks(h, whole.chunks, entries, corners, part, r), chunk_sequence(part),
                              whole.notes, out, [](std::uint64_t) { io::check_interrupt(); });
            set.packs.push_back({name, r.x, r.y, r.tiles_x, r.tiles_y, hash, true});
            summary.file_bytes += out.size();
            out.commit();
            if (progress) progress(done, std::uint64_t{h.tiles_x} * h.tiles_y);
        }
    summary.packs = static_cast<std::uint32_t>(set.packs.size());
    publish(set, folder, work);
    return summary;
}

namespace {

using io::Failure;

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
        throw Failure(1, file.path() + ": notes: " + message(StatusCode::corrupt));
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
