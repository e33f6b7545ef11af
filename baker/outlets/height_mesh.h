// Triangles over an array of heights, with a bound on their vertical error: the mesh without a pack.
//
// The errors are those of the vertex tree (errors/unsaturated.h), so the mesh has no cracks and every sample of ground
// lies within the bound of it. As the bound is one number and no camera moves, errors need not be nested: a vertex is
// there when its own error, or that of a vertex below it, is larger than the bound.
// Holes are exact: beside them every triangle is as small as cells are, so no hole is covered, and no ground is lost
// that the full resolution shows. Ownership: the mesh holds copies. Thread: any; works on several. O(samples) in time;
// 2 bits a sample of memory, 10 bytes a sample of a tile a thread, and twice the triangles. Deterministic: the same
// mesh, bit for bit, for any number of threads.
// Failure: Failure 1 for fewer than 2 x 2 samples, infinite heights or no height at all, 2 for a bound or a spacing
// that is none, 3 for too little memory or more vertices than 32 bits count.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "baker/read/height_array.h"
#include "baker/read/options.h"

namespace fjell::baker {

// Where the bound holds; beyond radius_m around it the mesh may be coarser with the distance, tile by tile.
struct MeshArea {
    double x_m = 0, z_m = 0; // from sample (0, 0), east and south
    double radius_m = 0;
    double growth = 0.01; // metres of error more, a metre farther away
};

struct HeightMeshOptions {
    double spacing_m[2] = {1, 1}; // from column to column, from row to row; > 0
    double max_error_m = 1;       // >= 0
    NoData nodata = NoData::hole; // NaN and masked numbers: hole, fill or refuse
    std::optional<MeshArea> area{};
    bool z_up = false; // x east, y north, z up; otherwise x east, y up, z south
    bool base = false; // HeightMesh::base
    int threads = 0;   // 0: all cores
};

struct HeightMesh {
    // Metres from sample (0, 0): column * spacing and row * spacing in float, and the array's height as a float.
    // Row by row; only vertices that triangles use.
    std::vector<std::array<float, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles; // counter-clockwise seen from above, tile by tile
    // Over the same vertices as few triangles as cover the same ground with the same edges around it: moved to one
    // height they are the plate that closes a solid.
    std::vector<std::array<std::uint32_t, 3>> base;
    // The largest vertical distance of the array's numbers from the triangles over them, measured at every sample, and
    // what rounding coordinates to float adds: at most max_error_m (of an area: in its tiles), or what the float of a
    // vertex is off, if that is more.
    double true_error_m = 0;
    double area_error_m = 0; // the same of the tiles that the area touches; all of them without one
};

[[nodiscard]] HeightMesh mesh_heights(const HeightArray& heights, const HeightMeshOptions& options);
// The same, and voids that are to be filled are holes: for WebAssembly, which fills nothing.
[[nodiscard]] HeightMesh mesh_unfilled(const HeightArray& heights, const HeightMeshOptions& options);
// Whether there are NaN or masked numbers. Fails as mesh_heights() does.
[[nodiscard]] bool has_voids(const HeightArray& heights, const HeightMeshOptions& options);

} // namespace fjell::baker
