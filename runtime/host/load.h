// A pack from a file, for tools: bytes, directory and, when asked, its geometry. Throws Failure with exit code 1 for a
// pack that is damaged or of another version, 3 for a disk that fails.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "fjell/pack.h"
#include "fjell/terrain.h"

namespace fjell::host {

struct AlignedDelete {
    void operator()(std::byte* block) const;
};
using AlignedBlock = std::unique_ptr<std::byte[], AlignedDelete>;
[[nodiscard]] AlignedBlock make_block(std::size_t bytes); // aligned to 2 MB, uninitialised, on huge pages if it may

struct LoadedPack {
    std::string path;
    std::vector<std::byte> file;
    Pack pack;          // points into file
    AlignedBlock block; // records, when loaded
    Terrain terrain;    // points into block
    std::string crs;    // WKT; empty: none
};

enum class LoadTerrain : bool { no, yes };
[[nodiscard]] LoadedPack load_pack(const std::string& path, LoadTerrain what);

// Decodes every chunk; throws Failure naming the first one that is damaged. Returns how many there are.
std::uint64_t check_all_chunks(const LoadedPack& loaded);

} // namespace fjell::host
