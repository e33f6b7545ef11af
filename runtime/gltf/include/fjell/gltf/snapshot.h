// The snapshot: the mesh of a frame as it stands, as binary glTF 2.0, for any viewer, DCC program or checker.
//
// What is drawn is in the file, and nothing else: the tiles that the frame draws, with the heights that it draws,
// morphed or not, as far as its budgets and the pages that are loaded went. What such a mesh keeps to is worked out
// for it (bound_error_px), not taken from a report that speaks of another one.
//
// One node, mesh and material a tile, named "tile COLUMN ROW"; positions are metres relative to the tile's corner, the
// node's translation (doubles in JSON) puts it in place. Axes as everywhere: x east, y up, z south. Normals come from
// the full-resolution heights as far as they are loaded. The colour map is embedded as PNG, with whatever the caller
// paints over it (SnapshotOptions::paint); so is a normal texture that
// turns the interpolated normals into the baked ones, so shading does not change with the level of detail. Of a pack
// with horizon maps the share of the sky that each place sees is the material's occlusion texture. All textures of a
// file are of one size. The camera is a glTF camera.
//
// scenes[0].extras.fjell, for checkers: error_px (as it was asked for), error_bound_px (no sample under the file's
// mesh is farther from it on screen, the quantum's share apart; 1e7: no bound is known), corner_safe (it holds in
// pixels of the picture too, not only angles), converged (nothing waits, and error_bound_px is no more than
// error_px), morphed (heights between two levels), lagging (work, pages or vertices that morph by time were waiting),
// culled (what the camera does not see was not refined), quantum_m, viewport [w, h], fov_y_deg, eye [x, y, z],
// spacing_m [x, z], origin_m (of sample (0, 0), along the axes of the CRS), crs_origin and crs_step (origin and spacing
// in units of the CRS, such as feet; crs_step is null where that is not known), crs (WKT or null), size [columns,
// rows], vertices and triangles (in the file: a border vertex counts once a tile), pack_hash (16 hexadecimal digits, as
// `fjell-bake info
// --json` has it).
//
// Tiles meet exactly: a tile's width is rounded to float once and every translation is a whole multiple of it, so a
// border vertex has one place, bit for bit, whichever tile it is read from. The price is a relative 2^-24 of the
// position.
//
// Ownership: a Snapshot holds copies; nothing else is kept after a call. Thread: take_snapshot on the one that updates
// the method, O(triangles); write_snapshot on any, and calls for different paths may run at once. Memory: some 60 bytes
// a vertex of the snapshot; the file's content is held until it is written, at most max_file_bytes. Complexity of
// writing: O(triangles + texels), mostly PNG encoding. Failure: io::Failure, whose text is one line that says what to
// do: 1 a pack that cannot be read or a place that cannot be written to, 2 what the caller gave, 3 the disk or too
// little memory, 130 stopped. The path then holds what it held before.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "fjell/cut.h"
#include "fjell/export.h"
#include "fjell/mesh.h"
#include "fjell/pack.h"
#include "fjell/recursive.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell::io {
class LiveTerrain; // fjell/io/live_terrain.h
class PackFile;
} // namespace fjell::io
namespace fjell::gltf {

// What the mesh is a picture of. take_snapshot() of a method finds it out.
struct SnapshotInfo {
    View view;                 // as make_view() makes them: glTF's cameras look at the picture's middle
    double error_px = 1;       // as it was asked for, > 0
    double error_bound_px = 1; // what this mesh keeps, > 0
    bool corner_safe = false;
    bool converged = false; // error_bound_px <= error_px, and nothing waits
    bool morphed = false;   // heights are between two levels
    bool lagging = false;   // something waits
    bool culled = false;    // refined for what the camera sees only
};

// A tile's colours before they are written, row by row from its north-west; outermost texel centres lie on its border.
struct TileTexels {
    std::uint32_t tile = 0;
    std::uint32_t side = 0;                     // texels a side
    double x_m = 0, z_m = 0;                    // where the first one's centre lies, from sample (0, 0)
    double step_x_m = 1, step_z_m = 1;          // from centre to centre
    std::span<const float> height_m, slope_deg; // of the file's mesh, and the baked normal's where there is one
    std::span<std::uint8_t> rgb;                // sRGB, 3 bytes each; of a pack without colours middle grey
};

// What to write, and how large it may get.
struct SnapshotOptions {
    std::uint32_t max_texture_px = 1024; // texels a side of an embedded texture; costs up to 3 bytes each
    // 0: as fine as the maps are; else the coarsest mip whose texels are no wider, in metres. Of what `paint` paints,
    // which has no finest mip: texels are no wider, as far as max_texture_px goes.
    double texel_m = 0;
    std::uint64_t max_file_bytes = 0xffff'ffff; // glTF counts a file's bytes in 32 bits; less is allowed, more is not
    bool write =
        true; // false: all but the file, which tells its counts and its size to the byte; the path may be empty
    // Paints over the colours of each tile, such as fjell::gl::GroundColour with its layers. May throw.
    std::function<void(const TileTexels& texels)> paint = {};
    // After every tile, on the caller's thread. False stops: exit code 130, and the path holds what it held before.
    std::function<bool(std::uint64_t done, std::uint64_t total)> progress = {};
};

// What is in a snapshot, and in its file.
struct SnapshotCounts {
    std::uint32_t tiles = 0;
    std::uint64_t vertices = 0, triangles = 0; // as in extras
    bool converged = false;
    double error_bound_px = 0;
    // Of the file only. Texels a side; 0: the pack has no colour.
    std::uint32_t texture_px = 0;
    std::uint32_t normal_px = 0;    // the same of the normal texture
    std::uint32_t occlusion_px = 0; // and of the occlusion: of packs with horizon maps
    std::uint64_t file_bytes = 0;
};

// A frame's mesh, copied: to write it nothing of the method or the terrain is needed any more.
class Snapshot {
public:
    struct Content;
    [[nodiscard]] bool empty() const { return content_ == nullptr; }
    [[nodiscard]] SnapshotInfo info() const;     // defaults when empty
    [[nodiscard]] SnapshotCounts counts() const; // of the mesh

private:
    friend struct SnapshotAccess;
    std::shared_ptr<const Content> content_;
};

// Of the method's last update, which was for this view with these settings and reported this. Degenerate triangles and
// vertices that no triangle uses are left out, and so are tiles that the frame does not draw.
[[nodiscard]] Snapshot take_snapshot(const Terrain& terrain, LiveCut cut, const View& view, const CutSettings& settings,
                                     const CutReport& report);
[[nodiscard]] Snapshot take_snapshot(const Terrain& terrain, RecursiveMethod method, const View& view,
                                     const RefineSettings& settings, const FrameReport& report);
// Of a LiveTerrain's last update, which was for this view. Writing the copy may be another thread's.
// Example:
//     const fjell::gltf::Snapshot snapshot = fjell::gltf::take_snapshot(ground, view); // between two updates
//     fjell::gltf::write_snapshot(ground, snapshot, out);                              // on any thread
[[nodiscard]] Snapshot take_snapshot(const io::LiveTerrain& terrain, const View& view);
// Of any mesh, list or strips, of which the caller knows what it keeps.
[[nodiscard]] Snapshot take_snapshot(const Terrain& terrain, const MeshView& mesh, const SnapshotInfo& info);

// A file of that name is what its ending says: .glb, or a device or a pipe (or a folder, which is
// refused as one).
[[nodiscard]] bool is_snapshot_name(const std::string& path);
// Writes path, which ends in .glb, beside its place and renames it. pack: the terrain's, with its bytes; or the file
// that has them, which is read meanwhile.
SnapshotCounts write_snapshot(const Pack& pack, const Snapshot& snapshot, const std::string& path,
                              const SnapshotOptions& options = {});
SnapshotCounts write_snapshot(const io::PackFile& file, const Snapshot& snapshot, const std::string& path,
                              const SnapshotOptions& options = {});
SnapshotCounts write_snapshot(const io::LiveTerrain& terrain, const Snapshot& snapshot, const std::string& path,
                              const SnapshotOptions& options = {});
// Both at once.
SnapshotCounts write_snapshot(const Pack& pack, const Terrain& terrain, const MeshView& mesh, const SnapshotInfo& info,
                              const std::string& path, const SnapshotOptions& options = {});

// Not a frame's mesh: the whole terrain, not only what the camera sees, refined to error_px (or View::max_error_px, if
// set) by a recursive method of its own (isotropic metric, culling off) whose budget grows until the mesh converges: 8
// bytes a terrain vertex and what the mesh needs.
SnapshotCounts export_snapshot(const Pack& pack, const Terrain& terrain, const View& view, double error_px,
                               const std::string& path, const SnapshotOptions& options = {});
// The same without the file, to be written by write_snapshot().
[[nodiscard]] Snapshot take_refined(const Terrain& terrain, const View& view, double error_px);

} // namespace fjell::gltf
FJELL_API_END
