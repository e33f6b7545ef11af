// A folder of tiles as one file: MBTiles (SQLite), or PMTiles 3, of which viewers read ranges.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "baker/outlets/globe.h"

namespace fjell::baker {

struct ArchiveTile {
    TileId id; // y from the south
    std::string path;
};
struct ArchiveAbout {
    std::string name, format; // format: png, webp, or quantized-mesh-1.0
    bool gzip = false;        // the tiles are gzip files
    DegreeBox bounds;
    std::string json; // all that a folder says of its tiles
};

enum class Archive : std::uint8_t { folder, mbtiles, pmtiles };
[[nodiscard]] Archive archive_of(const std::string& path); // by its ending

// The file is replaced whole; the bytes depend on the tiles alone. work: a folder for what is not done. Memory: 40
// bytes a tile. Throws Failure 3: the disk.
void write_archive(Archive kind, const std::vector<ArchiveTile>& tiles, const ArchiveAbout& about,
                   const std::string& path, const std::string& work);

} // namespace fjell::baker
