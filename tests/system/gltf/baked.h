// What the glTF tests share: a baked terrain in memory, a folder that goes away, and node.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fjell/io/load.h"
#include "fjell/view.h"
#include "support/dem.h"
#include "support/temporary_folder.h"

namespace fjell::test {

using Folder = TemporaryFolder;

// A pack baked from dem, read back and loaded; the heights lie beside it as raw float32.
class BakedTerrain {
public:
    BakedTerrain(const Folder& folder, const baker::Dem& dem, const baker::BakeOptions& options);
    BakedTerrain(const BakedTerrain&) = delete;
    BakedTerrain& operator=(const BakedTerrain&) = delete;

    io::LoadedPack loaded;
    const Pack& pack = loaded.pack;
    const Terrain& terrain = loaded.terrain;
    std::string heights_argument; // for check.mjs
};

// Hills over hills with a sharp ridge and a flat lake: every level of detail has something to do.
[[nodiscard]] baker::Dem hills(std::int32_t columns, std::int32_t rows, double spacing_x_m, double spacing_z_m);

// Over the terrain's south rim, looking north and down.
[[nodiscard]] View view_of(const Terrain& terrain);

// Runs `node SCRIPT ARGUMENTS` among the installed packages.
struct NodeResult {
    int exit_code;
    std::string output;
};
[[nodiscard]] NodeResult node(const std::string& script, const std::string& arguments);

} // namespace fjell::test
