// A pack from a file, for tools: its bytes, its directory and, if asked, its geometry. Throws Failure with exit code 1
// for a pack that is damaged or of another version, and with 3 if the disk fails.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "fjell/export.h"
#include "fjell/io/pack_file.h"
#include "fjell/pack.h"
#include "fjell/terrain.h"

FJELL_API_BEGIN
namespace fjell::io {

// Frees what allocate() gave.
struct AlignedDelete {
    void operator()(std::byte* memory) const;
};
using AlignedMemory = std::unique_ptr<std::byte[], AlignedDelete>;
[[nodiscard]] AlignedMemory allocate(std::size_t bytes); // aligned to 2 MB, uninitialised, on huge pages if possible

// A pack in memory. pack and terrain point into it.
struct LoadedPack {
    std::string path;
    std::vector<std::byte> file;
    Pack pack;            // points into file
    AlignedMemory memory; // the terrain's memory, if it was loaded
    Terrain terrain;      // points into memory
    std::string crs;      // WKT; empty: none
};

// Whether all pages are loaded too.
enum class LoadTerrain : bool { no, yes };
// Reads the whole file. With a PackFile it reads the file that is open, even if its name belongs to another one by now.
[[nodiscard]] LoadedPack load_pack(const std::string& path, LoadTerrain what);
[[nodiscard]] LoadedPack load_pack(const PackFile& file, LoadTerrain what);

// Decodes every chunk. Throws a Failure that names the first damaged one. Returns the number of chunks.
std::uint64_t check_all_chunks(const Pack& pack, const std::string& path);
std::uint64_t check_all_chunks(const PackFile& file); // keeps one in memory at a time

} // namespace fjell::io
FJELL_API_END
