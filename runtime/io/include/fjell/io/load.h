// A pack from a file, for tools: bytes, directory and, when asked, its geometry. Throws Failure with exit code 1 for a
// pack that is damaged or of another version, 3 for a disk that fails.
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
[[nodiscard]] AlignedMemory allocate(std::size_t bytes); // aligned to 2 MB, uninitialised, on huge pages if it may

// A pack in memory, with what lies in that memory.
struct LoadedPack {
    std::string path;
    std::vector<std::byte> file;
    Pack pack;            // points into file
    AlignedMemory memory; // records, when loaded
    Terrain terrain;      // points into memory
    std::string crs;      // WKT; empty: none
};

// Whether all pages are loaded too.
enum class LoadTerrain : bool { no, yes };
// Reads the whole file. Of a PackFile: of the file that it has open, whatever its name leads to now.
[[nodiscard]] LoadedPack load_pack(const std::string& path, LoadTerrain what);
[[nodiscard]] LoadedPack load_pack(const PackFile& file, LoadTerrain what);

// Decodes every chunk; throws Failure naming the first one that is damaged. Returns how many there are.
std::uint64_t check_all_chunks(const Pack& pack, const std::string& path);
std::uint64_t check_all_chunks(const PackFile& file); // one in memory at a time

} // namespace fjell::io
FJELL_API_END
