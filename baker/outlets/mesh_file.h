// A height field as one mesh in a file: as few triangles as keep every sample within a vertical error, without cracks.
//
// The mesh is that of mesh_heights(). Coordinates are metres from sample (0, 0), east and south of it. Formats:
//   .glb  glTF 2.0: x east, y up, z south; normals of the full resolution; asset.extras.fjell says what holds;
//   .ply  binary: x east, y north, z up; comments say what holds;
//   .obj  text: x east, y up, z south; comments say what holds;
//   .stl  binary, a closed solid for printing: x east, y north, z up, with walls and a base; its header says the error.
// The rim of a polygon follows the cells, as that of a hole does.
// Quantised, a .glb has columns, rows and steps of height as whole numbers of 16 bits: the bound takes the rounding in.
// O(samples); memory: 4 bytes a sample (9 while holes are filled), 24 a vertex and 24 a triangle. The file is replaced
// whole. Throws Failure: 1 the source, a bound closer than float coordinates are, or a format that cannot hold so much;
// 2 an unknown ending; 3 the disk, too little memory.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "baker/bake/bake.h"
#include "baker/read/source.h"
#include "gltf/mesh.h"

namespace fjell::baker {

struct MeshFileOptions {
    double max_error_m = 1;                     // >= 0
    std::optional<std::uint64_t> max_triangles; // instead: the smallest error found whose mesh has no more
    gltf::GlbPacking packing{};                 // of .glb
    std::string maps_of{};                      // a pack of the same ground, whose maps a .glb gets as textures:
    bool colours = false;                       // its colours
    bool occlusion = false;                     // what share of the sky ground sees
    bool normal_map = false;                    // of .glb: normals of all samples as a texture; needs no pack
    std::string polygon{};                      // a vector file: samples outside of its polygons are left out
    double base_m = -1; // of .stl: from its lowest ground down to its base; below 0: 1/20 of the longer side
    bool write = true;  // false: all but the file; the summary is that of the file, to the byte
    int threads = 0;    // 0: all cores
    Progress progress{};
};

struct MeshFileSummary {
    std::int32_t columns = 0, rows = 0;
    std::uint64_t vertices = 0, triangles = 0, bytes = 0; // of the file, walls and base included
    std::uint64_t ground_triangles = 0;                   // without them
    std::uint64_t holes = 0;                              // samples without a height: left open, or filled
    std::uint64_t left_out = 0;                           // samples outside of the polygons
    double max_error_m = 0;                               // asked for, or found for max_triangles
    double true_error_m = 0;                              // no sample is farther above or below the mesh
    double mesh_s = 0;                                    // what meshing alone took
};

MeshFileSummary write_mesh_file(const HeightSource& source, const MeshFileOptions& options, const std::string& path);

} // namespace fjell::baker
