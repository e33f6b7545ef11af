// A pack that stays in its file, for streaming. Header, directory, corners and CRS are in memory; chunks are read on
// demand. A pack set (fjell/pack_set.h), a folder with a set.json, is opened as one pack.
//
// The file is not mapped. So a file that shrinks or a disk that fails is an error of one read, and not a signal in the
// middle of a frame. Thread: immutable once open; read() may run on any thread, and on several at once. Failure:
// opening throws Failure with exit code 1 for a pack that is damaged or of another version, and with 3 if the disk
// fails. read() returns an errno.
// Of a set the folder and at most 32 files are open at a time; the folder may be moved. If a file is opened again and
// is not the same one any more, read() returns ESTALE (EIDRM on Windows). Paths are UTF-8, on Windows too.
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

// The name of a chunk for messages: "page 3 of tile 1", "colour mip 0 of tile 2", "CRS".
[[nodiscard]] std::string chunk_name(ChunkId id);

// The names of the materials in a pack's splat maps. text: the chunk `layers`.
[[nodiscard]] std::vector<std::string> layer_names(std::string_view text);

class SetParts; // the files of a set

// An open file, or an open set.
class PackFile {
public:
    explicit PackFile(const std::string& path); // a pack's file, a set's folder, or its set.json
    ~PackFile();
    PackFile(const PackFile&) = delete;
    PackFile& operator=(const PackFile&) = delete;

    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] const Pack& pack() const { return pack_; }                      // from open_index(): without bytes
    [[nodiscard]] const std::string& crs() const { return crs_; }                 // WKT; empty: none
    [[nodiscard]] std::span<const std::byte> corners() const { return corners_; } // as stored, for create_terrain()
    [[nodiscard]] std::size_t packs() const; // how many packs it consists of: 1 unless it is a set

    // Reads all of `to` from an offset of the file. Returns 0 or an errno; EIO if the file ends.
    [[nodiscard]] int read(std::uint64_t offset, std::span<std::byte> to) const noexcept;
    // Reads, checks and decodes a chunk. raw receives its raw_bytes. Throws Failure with exit code 1 if the chunk is
    // damaged or the file has changed, and with 3 if the disk fails.
    void read_chunk(ChunkId id, std::vector<std::byte>& raw) const;
    // Whether the file's length or header differ from those at opening. A file that was deleted, or replaced by a
    // rename, does not change for a program that has it open.
    [[nodiscard]] bool changed() const noexcept;
    // Throws the Failure that a failed read means: 1 if the file has changed, 3 if the disk fails. error: what read()
    // returned.
    [[noreturn]] void fail(int error) const;
    // Asks the system to drop its cache of the file: for benchmarks of cold starts.
    void drop_cache() const noexcept;

private:
    void open_pack_file();
    void open_set_file(const std::string& set_file);
    void read_crs();
    [[nodiscard]] std::vector<std::byte> stored(ChunkId id) const;

    std::string path_, crs_;
    int fd_ = -1; // -1 for a set
    std::unique_ptr<SetParts> set_;
    std::uint64_t file_bytes_ = 0; // when it was opened
    std::vector<std::byte> directory_, corners_;
    Pack pack_; // points into directory_, or the set's index
};

} // namespace fjell::io
FJELL_API_END
