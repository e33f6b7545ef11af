// The snapshot: the mesh of one frame as binary glTF 2.0, for any viewer, DCC program or checker.
//
// One node, mesh and material a tile; positions are metres relative to the tile's corner, the node's translation
// (doubles in JSON) puts it in place. Axes as everywhere: x east, y up, z south. Normals come from the full-resolution
// heights, so shading does not change with the level of detail; the colour map is embedded as PNG. The camera is a
// glTF camera.
//
// scenes[0].extras.fjell, for checkers: error_px (requested), error_px_effective, quantum_m, viewport [w, h],
// fov_y_deg, eye [x, y, z], spacing_m [x, z], origin_m (of sample (0, 0), CRS axes), crs (WKT or null), size [columns,
// rows], converged, morphed, vertices and triangles (in the file: a border vertex counts once a tile), pack_hash (16
// hexadecimal digits, as `fjell-bake info --json` has it).
//
// Tiles meet exactly: a tile's width is rounded to float once and every translation is a whole multiple of it, so a
// border vertex has one place, bit for bit, whichever tile it is read from. The price is a relative 2^-24 of the
// position.
//
// Ownership: nothing is kept after a call. Thread: any; calls for different paths may run at once. Memory: the file's
// content is held until it is written, at most max_file_bytes. Complexity: O(triangles + texels), mostly PNG encoding.
// Failure: a result with an exit code and one line that says what to do; the path then holds what it held before.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "fjell/export.h"
#include "fjell/mesh.h"
#include "fjell/pack.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell::gltf {

// What the mesh is a picture of, from the method's report.
struct SnapshotInfo {
    View view;                     // as make_view() makes them: glTF's cameras look at the picture's middle
    double error_px = 1;           // requested, > 0
    double error_px_effective = 1; // what the budgets allowed
    bool converged = false;        // effective == requested
    bool morphed = false;          // heights are between two levels
};

// What to write, and how large it may get.
struct SnapshotOptions {
    std::uint32_t max_texture_px = 1024;        // texels a side of an embedded texture; costs up to 3 bytes each
    std::uint64_t max_file_bytes = 0xffff'ffff; // glTF counts a file's bytes in 32 bits; less is allowed, more is not
    bool write =
        true; // false: all but the file, which tells its counts and its size to the byte; the path may be empty
    // After every tile, on the caller's thread. False stops: exit code 130, and the path holds what it held before.
    std::function<bool(std::uint64_t done, std::uint64_t total)> progress = {};
};

// What was written, or why nothing was.
struct [[nodiscard]] SnapshotResult {
    int exit_code = 0;   // 0 done, 1 the input is at fault, 2 usage, 3 the machine (disk, memory) is, 130 stopped
    std::string message; // one line, the remedy in it; empty when done
    std::uint32_t tiles = 0;
    std::uint64_t vertices = 0, triangles = 0; // as in extras
    bool converged = false;
    std::uint32_t texture_px = 0; // texels a side; 0: the pack has no colour
    std::uint64_t file_bytes = 0;
    [[nodiscard]] bool ok() const { return exit_code == 0; }
};

// Writes path beside its place and renames it. terrain: loaded from pack. mesh: Topology::triangles; degenerate
// triangles and vertices that no triangle uses are left out, and so are tiles that the mesh does not hold.
SnapshotResult write_snapshot(const Pack& pack, const Terrain& terrain, const MeshView& mesh, const SnapshotInfo& info,
                              const std::string& path, const SnapshotOptions& options = {});

// The whole terrain, not only what the frustum sees, refined to error_px (or View::error_px, if set) by a recursive
// method of its own (isotropic metric, culling off) whose budget grows until the mesh converges: 8 bytes a terrain
// vertex and what the mesh needs.
SnapshotResult export_snapshot(const Pack& pack, const Terrain& terrain, const View& view, double error_px,
                               const std::string& path, const SnapshotOptions& options = {});

} // namespace fjell::gltf
FJELL_API_END
