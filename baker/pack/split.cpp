#include "baker/pack/split.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <vector>

#include <fmt/format.h>
#include <xxhash.h>
#include <zstd.h>

#include "baker/read/pack_source.h"
#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "io/file.h"
#include "io/set_file.h"
#include "tree/order.h"

namespace fjell::baker {

namespace {

using io::Failure;

struct Rectangle {
    std::uint32_t x, y, tiles_x, tiles_y;
};

// What the header says of the heights in a rectangle, and nobody else.
void measure(const HeightSource& source, const Rectangle& r, PackHeader& h) {
    const auto side = static_cast<std::int32_t>(1u << h.tile_log2);
    const auto reader = source.reader();
    ReadStatistics statistics;
    std::vector<float> heights;
    h.voids = 0;
    const auto columns = static_cast<std::int32_t>(h.columns), rows = static_cast<std::int32_t>(h.rows);
    for (std::uint32_t ty = 0; ty < r.tiles_y; ++ty)
        for (std::uint32_t tx = 0; tx < r.tiles_x; ++tx) {
            io::check_interrupt();
            const std::int32_t x = static_cast<std::int32_t>(tx) * side, y = static_cast<std::int32_t>(ty) * side;
            // The last column and row are the next tile's first, but for the rectangle's last tile.
            const Window w{x + static_cast<std::int32_t>(r.x) * side, y + static_cast<std::int32_t>(r.y) * side,
                           tx + 1 == r.tiles_x ? columns - x : side, ty + 1 == r.tiles_y ? rows - y : side};
            heights.resize(w.area());
            reader->read(w, heights.data(), statistics);
        }
    h.voids = statistics.voids.count;
}

bool has_ground(const PackHeader& h) {
    return h.voids < std::uint64_t{h.columns} * h.rows;
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
        h.origin_m[axis] += cells[axis] * (h.crs_step[axis] > 0 ? h.crs_step[axis] : h.spacing_m[axis]);
    return h;
}

// A chunk of the part, and where the whole has it.
struct Copied {
    std::uint64_t chunk, from;
};

// In the order in which the whole has them: a prefix of the part is the part, coarser, too.
std::vector<Copied> chunks_of(const Pack& whole, const PackHeader& h, const Rectangle& r) {
    std::vector<Copied> chunks;
    for (std::uint64_t chunk = 0; chunk < chunk_count(h); ++chunk) {
        ChunkId id = chunk_id(h, chunk);
        if (id.kind == ChunkKind::corners) continue;
        if (id.kind != ChunkKind::crs && id.kind != ChunkKind::layers) // of no tile
            id.tile = (r.y + id.tile / r.tiles_x) * whole.header.tiles_x + r.x + id.tile % r.tiles_x;
        chunks.push_back({chunk, chunk_index(whole.header, id)});
    }
    std::sort(chunks.begin(), chunks.end(), [&](const Copied& a, const Copied& b) {
        return whole.entry(a.from).offset < whole.entry(b.from).offset;
    });
    return chunks;
}

class PartWriter {
public:
    PartWriter(const io::PackFile& whole, PackHeader h, io::AtomicFile& file)
        : whole_(whole), h_(h), file_(file), directory_(chunk_count(h)) {
        const PackHeader empty{}; // no magic number until the pack is complete
        file_.write(std::as_bytes(std::span(&empty, 1)));
    }
    void corners(const std::vector<std::byte>& of_whole, const Rectangle& r) {
        const std::size_t a_row = (r.tiles_x + std::size_t{1}) * 4, whole_row = (whole_.pack().header.tiles_x + 1) * 4;
        std::vector<std::byte> raw, stored;
        for (std::size_t y = 0; y <= r.tiles_y; ++y) {
            const auto from = of_whole.begin() + static_cast<std::ptrdiff_t>((r.y + y) * whole_row + r.x * 4);
            raw.insert(raw.end(), from, from + static_cast<std::ptrdiff_t>(a_row));
        }
        stored.resize(ZSTD_compressBound(raw.size()));
        const std::size_t size = ZSTD_compress(stored.data(), stored.size(), raw.data(), raw.size(), 3);
        if (ZSTD_isError(size)) throw Failure(3, fmt::format("cannot compress: {}", ZSTD_getErrorName(size)));
        stored.resize(size);
        directory_[0] = {file_.size(),
                         XXH3_64bits(stored.data(), size),
                         static_cast<std::uint32_t>(size),
                         static_cast<std::uint32_t>(raw.size()),
                         {}};
        file_.write(stored);
    }
    void copy(const Copied& chunk) {
        ChunkEntry entry = whole_.pack().entry(chunk.from);
        bytes_.resize(entry.stored_bytes);
        if (const int error = whole_.read(entry.offset, bytes_); error != 0) whole_.fail(error);
        if (XXH3_64bits(bytes_.data(), bytes_.size()) != entry.hash)
            throw Failure(1, whole_.path() + ": " + io::chunk_name(chunk_id(whole_.pack().header, chunk.from)) + ": " +
                                 message(Code::corrupt));
        entry.offset = file_.size();
        directory_[chunk.chunk] = entry;
        file_.write(bytes_);
    }
    // The pack's hash.
    std::uint64_t end(const std::vector<std::byte>& notes) {
        h_.notes_offset = notes.empty() ? 0 : file_.size();
        file_.write(notes);
        const auto bytes = std::as_bytes(std::span(directory_));
        h_.directory_offset = file_.size();
        h_.directory_count = directory_.size();
        h_.directory_hash = XXH3_64bits(bytes.data(), bytes.size());
        file_.write(bytes);
        h_.file_bytes = file_.size();
        h_.header_hash = XXH3_64bits(&h_, offsetof(PackHeader, header_hash));
        file_.write_at(0, std::as_bytes(std::span(&h_, 1)));
        return h_.directory_hash;
    }

private:
    const io::PackFile& whole_;
    PackHeader h_;
    io::AtomicFile& file_;
    std::vector<ChunkEntry> directory_;
    std::vector<std::byte> bytes_;
};

std::vector<std::byte> notes_of(const io::PackFile& file) {
    const PackHeader& h = file.pack().header;
    std::vector<std::byte> notes(static_cast<std::size_t>(h.notes_bytes));
    if (const int error = file.read(h.notes_offset, notes); error != 0) file.fail(error);
    if (!notes.empty() && XXH3_64bits(notes.data(), notes.size()) != h.notes_hash)
        throw Failure(1, file.path() + ": notes: " + message(Code::corrupt));
    return notes;
}

// The n-th of so many parts of a row of tiles, as even as they can be.
std::uint32_t part_begin(std::uint32_t n, std::uint32_t parts, std::uint32_t tiles) {
    return static_cast<std::uint32_t>(std::uint64_t{n} * tiles / parts);
}

} // namespace

SplitSummary split_pack(const std::string& pack, const std::string& folder, const SplitOptions& options,
                        const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    const io::PackFile file(pack);
    if (file.packs() != 1) throw Failure(1, pack + ": is a set already; give the one pack that is to be split");
    const PackHeader& whole = file.pack().header;
    if (options.packs_x < 1 || options.packs_y < 1 || options.packs_x > whole.tiles_x ||
        options.packs_y > whole.tiles_y)
        throw Failure(2, fmt::format("{}: has {} x {} tiles, which cannot be split into {} x {} packs; give fewer to "
                                     "--packs, or bake it with a smaller --tile",
                                     pack, whole.tiles_x, whole.tiles_y, options.packs_x, options.packs_y));
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw Failure(1, folder + ": cannot be made (" + error.message() + "); choose another folder");
    const PackSource source(pack);
    const std::vector<std::byte> notes = notes_of(file);
    std::vector<std::byte> corners;
    file.read_chunk({ChunkKind::corners, 0, 0}, corners);
    SplitSummary summary;
    io::SetFile set{whole.columns, whole.rows, 1u << whole.tile_log2, {whole.spacing_m[0], whole.spacing_m[1]}, {}};
    std::uint64_t done = 0;
    for (std::uint32_t py = 0; py < options.packs_y; ++py)
        for (std::uint32_t px = 0; px < options.packs_x; ++px) {
            const Rectangle r{
                part_begin(px, options.packs_x, whole.tiles_x), part_begin(py, options.packs_y, whole.tiles_y),
                part_begin(px + 1, options.packs_x, whole.tiles_x) - part_begin(px, options.packs_x, whole.tiles_x),
                part_begin(py + 1, options.packs_y, whole.tiles_y) - part_begin(py, options.packs_y, whole.tiles_y)};
            PackHeader h = header_of(whole, r);
            if (whole.voids != 0) measure(source, r, h);
            done += std::uint64_t{r.tiles_x} * r.tiles_y;
            if (!has_ground(h)) {
                ++summary.left_out;
                continue;
            }
            const std::string name = fmt::format("{}-{}.fjell", px, py);
            io::AtomicFile out((std::filesystem::path(folder) / name).string());
            PartWriter writer(file, h, out);
            writer.corners(corners, r);
            for (const Copied& chunk : chunks_of(file.pack(), h, r)) writer.copy(chunk);
            set.packs.push_back({name, r.x, r.y, r.tiles_x, r.tiles_y, writer.end(notes), true});
            summary.file_bytes += out.size();
            out.commit();
            if (progress) progress(done, std::uint64_t{whole.tiles_x} * whole.tiles_y);
        }
    io::AtomicFile index((std::filesystem::path(folder) / "set.json").string());
    const std::string text = io::set_file_text(set);
    index.write(std::as_bytes(std::span(text)));
    index.commit();
    summary.packs = static_cast<std::uint32_t>(set.packs.size());
    return summary;
}

} // namespace fjell::baker
