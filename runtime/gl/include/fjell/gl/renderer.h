// An OpenGL 4.5 renderer for a terrain mesh: textured and lit, or in a mode that shows how the mesh is made, with
// wireframe over any of them.
//
// One multi-draw draws all tiles. Data that changes from frame to frame goes through persistently mapped memory, in
// three regions that the CPU fills in turn, so neither side waits for the other; docs/notes/renderer.md has the
// figures. Positions are relative to the eye in whole samples, so coordinates far from the origin do not shake, and
// tiles meet bit for bit. Depth is reversed and float, so distant ridges do not flicker.
// Units: metres and pixels; angles in degrees where the name says so. Colours in files and pictures are sRGB.
// Ownership: the renderer owns its buffers and textures. It reads the Pack's bytes only in create(), and the mesh's
// spans and the blocks of MapCommands only in upload() and draw(). Mode::residency reads the terrain's page table, and
// is refused after the terrain is destroyed.
// Thread: the context's; if pages are loaded while it draws, on the thread that loads them. A renderer may be made in a
// context and thread of its own while another one draws: leave_context().
// Memory: 12 bytes a vertex (28 with morphing), 4 an index, the maps, three times ring_bytes, 132 bytes a range and 2
// KB, all at creation. Mode::residency takes 1 byte for each square of 64 x 64 samples later; set_heights() and
// set_layers() take memory when they are called.
// Complexity of an upload: O(dirty vertices and all indices) for a MeshView, and O(written slots) for a CutMesh, in the
// same few GL calls. Of a draw: O(ranges), one draw call and the sky. The first draw of a debug mode, and the first
// with layers, compiles a shader.
// Failure: io::Failure, 3, with one line that says which number to change; the target keeps its former picture.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "fjell/cut.h"
#include "fjell/export.h"
#include "fjell/gl/layers.h"
#include "fjell/gl/light.h"
#include "fjell/gl/target.h"
#include "fjell/ground_maps.h"
#include "fjell/mesh.h"
#include "fjell/pack.h"
#include "fjell/stream.h"
#include "fjell/terrain.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell::io {
class LiveTerrain; // fjell/io/live_terrain.h
struct Materials;  // fjell/io/materials.h
} // namespace fjell::io
namespace fjell::gl {

// What there is room for. Fixed at creation.
struct RendererOptions {
    std::uint32_t vertices = 1u << 18; // slots as in the method's budget, 12 bytes each
    std::uint32_t indices = 1u << 20;  // 4 bytes each
    // Texture samples along the steep direction; 0: 8. Ignored when the GPU is software, where it is too slow.
    float anisotropy = 0;
    // Draw ranges a frame, at least one for each tile. A CutMesh has up to one for each segment.
    std::uint32_t ranges = 0;
    // Room for the morph vertices of a CutMesh: 16 bytes a vertex.
    bool morph = false;
    // Bytes that a frame may upload before it moves on to the next of three regions: 32 for a written vertex slot, 16
    // for a triangle slot, and the blocks of maps. 0: an eighth of all slots, at least 1 MB. A frame may upload more,
    // but may then wait for the GPU.
    std::uint32_t ring_bytes = 0;
    // Streamed maps (stream_map_layers()): array textures of these sizes, empty at first, at most 8 sizes for each
    // kind. With top_log2 0 the whole map of the pack is loaded at creation.
    MapLayers colour{}, normal{}, horizon{}, splat{};
    bool horizons =
        // Load the horizon maps of a whole pack, for LightSettings::shadows. They often take four times the bytes of
        // all other maps.
        true;
    // Load the splat maps of a whole pack, for LayerSettings::splat: 8 bytes a texel.
    bool splat_maps = true;
    // The light of the first draw, whose shaders are compiled at creation. Other shaders are compiled when first used.
    LightSettings light{};
    // Textures of set_layers(), in bytes. The finest mips are left out until the rest fits. Ten materials of 512 texels
    // a side take 7 MB.
    std::uint64_t material_bytes = std::uint64_t{64} << 20;
    // What show_ground() may use, if there are normal maps.
    GroundMapsBudget ground{};
    // Texels a side that set_heights() uses at most; 0: as many as the driver allows.
    std::uint32_t texture_side = 0;
};

// Options with room for the mesh of a cut with this budget, with morphing. map_bytes: what a frame may upload of
// streamed maps (StreamSettings::map_bytes); 0: nothing.
[[nodiscard]] RendererOptions room_for(const CutBudget& budget, std::uint32_t map_bytes);

// What the picture shows. This is the complete list of modes; wireframe is DrawOptions::wireframe.
enum class Mode : std::uint8_t {
    shaded,
    levels, // every triangle in the colour of its level (fjell/gl/palette.h)
    // Distance on a logarithmic scale: white at the near plane, black beyond the terrain.
    distance,
    tiles, // every tile in a colour that differs from its neighbours'
    // By the mip that colours, or else normals, are drawn from; black where nothing is loaded.
    mips,
    // By the finest step of geometry that is loaded at each place, whatever is drawn there.
    residency,
    // By how far the drawn surface is above or below the full resolution, in pixels. Needs set_heights().
    error
};

// The terrain's heights: every 2^step_log2-th sample of each row and column. If the last one would be beyond the rim,
// it is at the rim. io::read_heights() reads them from a pack.
struct HeightGrid {
    std::int32_t columns = 0, rows = 0;
    std::uint32_t step_log2 = 0;
    std::span<const float> heights_m; // row by row; NaN: a hole
};

// The options of a draw.
struct DrawOptions {
    Mode mode = Mode::shaded;
    bool wireframe = false; // draw the edges of triangles over the picture
    // Lines on the surface, over any mode: around tiles, and around squares of 64 x 64 samples, which are the pages of
    // the finest step (none in linear order, whose pages are rows). They fade out where they would be closer than 6
    // pixels.
    bool tile_borders = false, page_borders = false;
    // Over any mode but distance. contour_m: metres between lines of equal height, every fifth of which is wider; 0:
    // none. slope: slopes from 15, 25, 35 and 45 degrees on, in palette.h's slope_rgb.
    double contour_m = 0;
    bool slope = false;
    bool sky = true; // false: black
    // False: bare colours, to compare. Mode::shaded then has no haze, tone curve or water either.
    bool lit = true;
    // Mode::shaded: haze before the ground. The other modes are never hazed.
    bool haze = true;
    LightSettings light{};
    LayerSettings layers{}; // Mode::shaded, lit; needs set_layers()
    double time_s = 0;      // moves the waves of the water
    // Mode::error: vertical metres * lambda / distance from an eye in any direction, as the cut measures errors.
    // The error that is red: the promised threshold. Larger errors are white.
    float error_full_px = 1;
    std::optional<Vec3> error_eye_m{}; // the eye that the mesh was refined for; none: the view's
    // The lambda of that eye; 0: the view's.
    double error_lambda_px = 0;
    bool hatch = false; // draw larger errors as stripes, not white
    // Draw only these rows of the target, counted from below: to spread a picture over frames, band by band. end_row 0:
    // all rows.
    std::uint32_t first_row = 0, end_row = 0;
};

// What uploads and draws have done.
struct DrawStats {
    std::uint64_t frames = 0;
    // In the last draw: bytes of vertices, morph vertices and indices (of records, if slots were scattered), bytes of
    // maps, and the CPU's time for both, in GL calls and copies.
    std::uint64_t bytes_uploaded = 0, map_bytes_uploaded = 0;
    double upload_us = 0;
    // How many uploads and draws have waited because the GPU was three regions behind, so far.
    std::uint64_t ring_waits = 0;
    std::uint32_t ground_waiting = 0;       // changes and tiles whose texels show_ground() has not made anew yet
    std::uint64_t texture_bytes = 0;        // resident
    std::uint32_t tiles = 0, triangles = 0; // of the last draw
};

// A renderer of one terrain in one context.
class Renderer {
public:
    // Makes a renderer. The terrain must be the pack's. O(texels).
    [[nodiscard]] static std::unique_ptr<Renderer> create(const Terrain& terrain, const Pack& pack,
                                                          const RendererOptions& options);
    // Makes a renderer with room for the mesh of a LiveTerrain, with morphing, and for its streamed maps. Of the
    // options only light, anisotropy, material_bytes and texture_side are used.
    [[nodiscard]] static std::unique_ptr<Renderer> create(const io::LiveTerrain& terrain,
                                                          const RendererOptions& options = {});
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    // Uploads what the last update wrote. draw() does it too. Call it after updates that are not drawn, or their dirty
    // ranges are lost. A mesh that differs from the last one in address or size is uploaded whole.
    void upload(const MeshView& mesh);
    // The same for a live cut, whose indices stay on the GPU too. Needs RendererOptions::morph. changes: from
    // cut_take_changes(), after one update or several.
    void upload(const CutMesh& mesh, const CutChanges& changes);
    // Carries out stream_map_commands(), each once and in order: copies within the GPU, then uploads of blocks.
    void upload(std::span<const MapCommand> commands);
    // Uploads everything that the last update of a LiveTerrain has changed: map commands, the map of each tile, normals
    // of moved ground, and the mesh. Call it after every update that is not drawn.
    void upload(io::LiveTerrain& terrain);
    // Sets the heights that Mode::error compares with. They are copied, 4 bytes a sample. With a step above 1, places
    // where the mesh is as fine as the grid stay grey, because only coarser places can be compared. An empty grid frees
    // them.
    void set_heights(const HeightGrid& grid);
    // Sets what DrawOptions::layers draws near ground with. The bytes that `materials` points into are read here and
    // not kept. Empty materials and rules free them. The next draw with layers compiles its shader. names: those of the
    // pack's chunk `layers` (io::layer_names()), which its splat maps refer to. Each must be a material or water_layer.
    void set_layers(const io::Materials& materials, std::span<const LayerRule> rules,
                    std::span<const std::string> names = {});
    // Sets which map each tile is drawn with: stream_tile_maps() of each kind, one for each tile. An empty span leaves
    // that kind as it is. Copied. No streamed map shows before the first call.
    void show_maps(std::span<const TileMap> colour, std::span<const TileMap> normal,
                   std::span<const TileMap> horizon = {}, std::span<const TileMap> splat = {});
    // Moving ground: makes texels of the normal maps anew where heights have changed, and of the colour and splat maps
    // where paint has, as fjell/ground_maps.h says. Call it after each update of a terrain with edits. At most
    // RendererOptions::ground.texels at a time; DrawStats::ground_waiting says what is left for the next call.
    void show_ground();
    // Makes the next upload a whole one. That is faster after rebuild_cut(). It is necessary if changes were taken and
    // not uploaded.
    void invalidate();

    // Uploads the mesh and draws it. view.width_px and height_px give the aspect ratio; the picture fills the target.
    void draw(const MeshView& mesh, const View& view, const DrawOptions& options, const Target& target);
    void draw(const CutMesh& mesh, const CutChanges& changes, const View& view, const DrawOptions& options,
              const Target& target);
    // The same for a LiveTerrain.
    void draw(io::LiveTerrain& terrain, const View& view, const DrawOptions& options, const Target& target);
    // Draws without an upload, for hosts that called upload() after the update. The indices of a mesh that is not a
    // CutMesh's are uploaded even here.
    void draw_uploaded(const MeshView& mesh, const View& view, const DrawOptions& options, const Target& target);
    // Draws almost nothing with these options, so that the driver compiles its shaders now and not in the first frame,
    // where a software driver takes half a second. target: of any size, with the samples of later pictures; its picture
    // is overwritten. The next upload is a whole one.
    void rehearse(const DrawOptions& options, const Target& target);
    // Call this in the context that has made the renderer, before another context that shares objects with it goes on,
    // on any thread. It frees what contexts do not share, and waits for the GPU.
    void leave_context();
    [[nodiscard]] const DrawStats& stats() const;

private:
    Renderer();
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace fjell::gl
FJELL_API_END
