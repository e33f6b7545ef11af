// The snapshot: the mesh of a frame as binary glTF 2.0, for viewers, DCC programs and checkers.
//
// The file has what the frame draws: the tiles that it draws, with the heights that it draws, morphed or not, as far as
// budgets and loaded pages allow. The error bound of that mesh is computed for the file (bound_error_px()), not copied
// from a report.
//
// Each tile is a node with a mesh and a material, and is named "tile COLUMN ROW". Positions are metres relative to the
// tile's corner; the node's translation, in doubles, puts it in place. Axes as everywhere: x east, y up, z south.
// Normals come from the full-resolution heights as far as they are loaded. The colour map is embedded as PNG, with
// whatever the caller paints over it (SnapshotOptions::paint). A normal texture turns the interpolated normals into the
// baked ones, so shading does not change with the level of detail. In a pack with horizon maps the share of the sky
// that each place sees is the material's occlusion texture. All textures of a file have the same size. The camera is a
// glTF camera.
//
// scenes[0].extras.fjell has, for checkers:
// - error_px: the threshold that was asked for;
// - error_px_effective: no sample under the file's mesh is farther from it on screen, plus the quantum's share; 1e7: no
//   bound is known;
// - corner_safe: the bound is in pixels everywhere in the picture, not only as an angle;
// - converged: nothing waits, and error_px_effective is at most error_px;
// - morphed: heights are between two levels;
// - lagging: work, pages or vertices that morph by time were waiting;
// - culled: the ground outside the camera's view was not refined;
// - rounding_m: what 16 bits move a vertex up or down, at most. Its share adds to the bound as the quantum's does. 0 in
//   floats;
// - quantum_m, viewport [w, h], fov_y_deg, eye [x, y, z], spacing_m [x, z], size [columns, rows];
// - origin_m: of sample (0, 0), along the axes of the CRS; crs_origin and crs_step: origin and spacing in units of the
//   CRS, e.g. feet (crs_step is null if it is not known); crs: WKT or null;
// - vertices and triangles: in the file, where a border vertex counts once for each tile;
// - pack_hash: 16 hexadecimal digits, as `fjell-bake info --json` prints it.
//
// Tiles meet exactly. The width of a tile is rounded to float once, and every translation is a whole multiple of it. So
// a border vertex has one place, bit for bit, in all its tiles. The price is a relative 2^-24 of the position.
//
// Ownership: a Snapshot holds copies; a call keeps nothing else. Thread: take_snapshot() on the one that updates the
// method; write_snapshot() on any, and calls for different paths may run at once. Memory: some 60 bytes for each vertex
// of the snapshot. The content of the file is held until it is written, at most max_file_bytes. Complexity:
// take_snapshot() O(triangles); write_snapshot() O(triangles + texels), mostly PNG encoding.
// Failure: io::Failure, with one line that says what to do: 1 for a pack that cannot be read or a place that cannot be
// written to, 2 for a wrong argument, 3 for the disk or too little memory, 130 if it was stopped. The path then has
// what it had before.
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

// What the mesh is a picture of. take_snapshot() of a method fills it in.
struct SnapshotInfo {
    View view;                 // as make_view() makes it: glTF cameras look at the picture's middle
    double error_px = 1;       // the threshold that was asked for, > 0
    double error_bound_px = 1; // the error bound of this mesh, > 0
    bool corner_safe = false;
    bool converged = false; // nothing waits, and error_bound_px <= error_px
    bool morphed = false;   // heights are between two levels
    bool lagging = false;   // work, pages or morphing vertices wait
    bool culled = false;    // only the ground that the camera sees was refined
};

// The colours of a tile before they are written, row by row from the north-west. The outermost texel centres are on its
// border.
struct TileTexels {
    std::uint32_t tile = 0;
    std::uint32_t side = 0;            // texels a side
    double x_m = 0, z_m = 0;           // the centre of the first texel, from sample (0, 0)
    double step_x_m = 1, step_z_m = 1; // from centre to centre
    // Of the file's mesh; the slope is that of the baked normal if the pack has one.
    std::span<const float> height_m, slope_deg;
    std::span<std::uint8_t> rgb; // sRGB, 3 bytes each; middle grey if the pack has no colour
};

enum class SnapshotImage : std::uint8_t { png, jpeg };

// What to write, and how large it may get.
struct SnapshotOptions {
    // Texels a side of an embedded texture, each of which takes up to 3 bytes.
    std::uint32_t max_texture_px = 1024;
    // The largest texel of textures in metres; 0: as fine as the maps are. The coarsest mip that suffices is taken.
    // What `paint` paints has no finest mip, so it gets texels of this size, as far as max_texture_px allows.
    double texel_m = 0;
    // glTF counts the bytes of a file in 32 bits, so this is the largest limit.
    std::uint64_t max_file_bytes = 0xffff'ffff;
    bool write =
        // False: do everything but write the file; the counts and the size are exact. The path may be empty.
        true;
    // JPEG is smaller, and loses some. Normals and occlusion are always PNG.
    SnapshotImage colours = SnapshotImage::png;
    // 16 bits a number (KHR_mesh_quantization): half the size. extras say what the rounding moves.
    bool quantised = false;
    // Compressed (EXT_meshopt_compression). Readers need its decoder.
    bool meshopt = false;
    // Paints over the colours of each tile, e.g. fjell::gl::GroundColour with its layers. May throw.
    std::function<void(const TileTexels& texels)> paint = {};
    // Called after every tile, on the caller's thread. Return false to stop: exit code 130, and the path has what it
    // had before.
    std::function<bool(std::uint64_t done, std::uint64_t total)> progress = {};
};

// What is in a snapshot, and in its file.
struct SnapshotCounts {
    std::uint32_t tiles = 0;
    std::uint64_t vertices = 0, triangles = 0; // as in extras
    bool converged = false;
    double error_bound_px = 0;
    // Only of a file. Texels a side; 0: the pack has no colour.
    std::uint32_t texture_px = 0;
    std::uint32_t normal_px = 0;    // of the normal texture
    std::uint32_t occlusion_px = 0; // of the occlusion texture; 0: the pack has no horizon maps
    std::uint64_t file_bytes = 0;
};

// The mesh of a frame, copied. Writing it needs nothing of the method or the terrain any more.
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

// Copies the mesh of the method's last update. view, settings and report must be those of that update. Degenerate
// triangles, unused vertices, and tiles that the frame does not draw are left out.
[[nodiscard]] Snapshot take_snapshot(const Terrain& terrain, LiveCut cut, const View& view, const CutSettings& settings,
                                     const CutReport& report);
[[nodiscard]] Snapshot take_snapshot(const Terrain& terrain, RecursiveMethod method, const View& view,
                                     const RefineSettings& settings, const FrameReport& report);
// Copies the mesh of a LiveTerrain's last update, which must have been for this view. The copy may be written on
// another thread.
// Example:
//     const fjell::gltf::Snapshot snapshot = fjell::gltf::take_snapshot(ground, view); // between two updates
//     fjell::gltf::write_snapshot(ground, snapshot, out);                              // on any thread
[[nodiscard]] Snapshot take_snapshot(const io::LiveTerrain& terrain, const View& view);
// Copies any mesh, a list or strips. info: the caller says which error the mesh keeps.
[[nodiscard]] Snapshot take_snapshot(const Terrain& terrain, const MeshView& mesh, const SnapshotInfo& info);

// Whether a path can be written to: its name ends in .glb, or it is a device or a pipe. A folder counts too, and is
// refused when it is written to.
[[nodiscard]] bool is_snapshot_name(const std::string& path);
// Writes a file beside `path` and renames it. path must end in .glb. pack: the terrain's, with its bytes; or the file
// that has them, which is read meanwhile.
SnapshotCounts write_snapshot(const Pack& pack, const Snapshot& snapshot, const std::string& path,
                              const SnapshotOptions& options = {});
SnapshotCounts write_snapshot(const io::PackFile& file, const Snapshot& snapshot, const std::string& path,
                              const SnapshotOptions& options = {});
SnapshotCounts write_snapshot(const io::LiveTerrain& terrain, const Snapshot& snapshot, const std::string& path,
                              const SnapshotOptions& options = {});
// take_snapshot() and write_snapshot() in one call.
SnapshotCounts write_snapshot(const Pack& pack, const Terrain& terrain, const MeshView& mesh, const SnapshotInfo& info,
                              const std::string& path, const SnapshotOptions& options = {});

// Writes the whole terrain, not the mesh of a frame and not only what the camera sees. It is refined to error_px (or
// View::max_error_px, if set) by a recursive method of its own, with isotropic metric and without culling. Its budget
// grows until the mesh converges: 8 bytes for each vertex of the terrain, and what the mesh needs.
SnapshotCounts export_snapshot(const Pack& pack, const Terrain& terrain, const View& view, double error_px,
                               const std::string& path, const SnapshotOptions& options = {});
// The same without the file, which write_snapshot() can write.
[[nodiscard]] Snapshot take_refined(const Terrain& terrain, const View& view, double error_px);

} // namespace fjell::gltf
FJELL_API_END
