// A tile as quantized-mesh 1.0, the terrain format of CesiumJS.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "baker/outlets/globe.h"
#include "baker/outlets/tile_mesh.h"

namespace fjell::baker {

struct EncodedTile {
    std::vector<std::byte> bytes;
    double low_m = 0, high_m = 0; // of its vertices
};
// height_step_m: that heights are whole multiples of, a power of two. normals: a unit vector for each vertex, written
// as the extension octvertexnormals; none: it is left out. The extension metadata says the error, and of a root what
// tiles lie below it: available, JSON as in layer.json from level 1 on, or nothing. Throws Failure 1 when the heights
// of one tile span more steps than 15 bits hold.
[[nodiscard]] EncodedTile encode_quantized_mesh(const TileMesh& mesh, double height_step_m,
                                                std::span<const GlobePlace> normals, const std::string& available);

// RFC 1952, without a name and a time: equal bytes give equal files.
[[nodiscard]] std::vector<std::byte> gzip(std::span<const std::byte> bytes);

} // namespace fjell::baker
