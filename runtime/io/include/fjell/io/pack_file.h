// A pack that stays in its file, for streaming: header, directory, corners and CRS in memory, chunks read when asked
// for. Or a pack set that stays in its files (fjell/pack_set.h): a folder with a set.json, which then is one pack.
//
// Never mapped: a file that shrinks or a disk that fails is an error of one read, not a signal in the middle of a
// frame. Thread: immutable once open; read() from any thread, several at once. Failure: opening throws Failure with
// exit code 1 for a pack that is damaged or of another version, 3 for a disk that fails; read() answers with an errno.
// Of a set's files 32 are open at a time, whatever their number, and its folder, which may be moved; ESTALE (on Windows
// EIDRM) is read()'s answer when one that is opened again is another than it was. Paths are UTF-8, on Windows too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fjell/export.h"
#include "fjell/pack.h"

FJELL_API_BEGIN
namespace fjell::io {

// What people call a chunk: "page 3 of tile 1", "colour mip 0 of tile 2", "CRS".
[[nodiscard]] std::string chunk_name(ChunkId id);

// The materials that a pack's splat maps speak of, from the chunk `layers`: one name each.
[[nodiscard]] std::vector<std::string> layer_names(std::string_view text);

class SetParts; // the files of a set

// An open file, or an open set.
class PackFile {
public:
    explicit PackFile(const std::string& path); // of a pack, of a set's folder, or of its set.json
    ~PackFile();
    PackFile(const PackFile&) = delete;
    PackFile& operator=(const PackFile&) = delete;

    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] const Pack& pack() const { return pack_; }                      // of open_index(): without bytes
    [[nodiscard]] const std::string& crs() const { return crs_; }                 // WKT; empty: none
    [[nodiscard]] std::span<const std::byte> corners() const { return corners_; } // as stored: for create_terrain()
    [[nodiscard]] std::size_t packs() const; // that it consists of: 1 unless it is a set

    // All of the bytes from there on, however many calls it takes. 0, or what errno said; EIO where the file ends.
    [[nodiscard]] int read(std::uint64_t offset, std::span<std::byte> to) const noexcept;
    // A chunk, checked and decoded: raw_bytes of it. Throws Failure with exit code 1 when it is damaged or the file was
    // changed meanwhile, 3 when the disk fails.
    void read_chunk(ChunkId id, std::vector<std::byte>& raw) const;
    // Whether the file's length or header are not what they were when it was opened. One that was renamed over or
    // deleted stays as it was for whoever has it open.
    [[nodiscard]] bool changed() const noexcept;
    // Throws what a read that failed means: the file was changed (1), or the disk (3). error: what read() answered.
    [[noreturn]] void fail(int error) const;
    // What the system keeps of the file is forgotten, as far as it listens: for benchmarks of cold starts.
    void drop_cache() const noexcept;

private:
    void open_pack_file();
    void open_set_file(const std::string& set_file);
    void read_crs();
    [[nodiscard]] std::vector<std::byte> stored(ChunkId id) const;

    std::string path_, crs_;
    int fd_ = -1; // of a set: none
    std::unique_ptr<SetParts> set_;
    std::uint64_t file_bytes_ = 0; // when it was opened
    std::vector<std::byte> directory_, corners_;
    Pack pack_; // points into directory_, or the set's index
};

} // namespace fjell::io
FJELL_API_END
