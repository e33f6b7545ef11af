// Draws a terrain mesh with OpenGL 4.5: textured and lit, or in a mode that shows how it is made; wireframe over any.
//
// One multi-draw for all tiles. What changes from frame to frame goes through persistently mapped memory, in three
// regions that the CPU fills in turn, so neither side waits for the other; docs/notes/renderer.md has the figures.
// Positions are counted from the eye in whole samples, so coordinates far from the origin do not shake and tiles meet
// bit for bit. Depth is reversed and float: distant ridges do not fight. Units: metres and pixels; angles in degrees
// where the name says so. Colours in files and pictures are sRGB. Ownership: the renderer owns its buffers and
// textures; the Pack's bytes are read only in create(), the mesh's spans and MapCommands' blocks only in upload() and
// draw(). Mode::residency reads the terrain's page table, and is refused once that is destroyed. Thread: the context's;
// where pages are loaded, also the one that does it. One may make it in a context and
// thread of its own while another draws: leave_context(). Memory, all at creation but for the mode residency's 1 byte a
// square of 64 x 64 samples, set_heights() and set_layers(): 12 bytes a vertex (28 with morph), 4 an index, the maps,
// and three times ring_bytes, 132 bytes a range and 2 KB. Complexity of an upload: a MeshView's dirty vertices and all
// its indices, or a CutMesh's written slots and nothing else, in the same few GL calls however they lie; of a draw: the
// ranges, then one draw call and the sky. A debug mode's first draw compiles its shader, as the first with layers does.
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

// What there is room for: fixed at creation.
struct RendererOptions {
    std::uint32_t vertices = 1u << 18; // slots, as in the method's budget; 12 bytes each
    std::uint32_t indices = 1u << 20;  // 4 bytes each
    float anisotropy = 0;              // texture samples along the steep direction; 0: 8. Ignored in software: too dear
    std::uint32_t ranges = 0;          // draw ranges a frame; a CutMesh has up to one a segment. At least one a tile
    bool morph = false;                // room for a CutMesh's morph vertices: 16 bytes a vertex
    // Uploads that a frame may write without moving on to the next of three regions, in bytes: 32 a written vertex
    // slot, 16 a triangle slot, and map blocks. 0: an eighth of all slots, 1 MB at least. More than that in a frame is
    // right too, but may wait for the GPU.
    std::uint32_t ring_bytes = 0;
    // Streamed maps (stream_map_layers()): array textures of these sizes, empty at first. top_log2 0: all of the pack's
    // map is loaded at creation. At most 8 sizes of each kind.
    MapLayers colour{}, normal{}, horizon{}, splat{};
    bool horizons =
        true; // load those of a whole pack, for LightSettings::shadows: often four times the bytes of its other maps
    bool splat_maps = true; // load those of a whole pack, for LayerSettings::splat: 8 bytes a texel
    LightSettings light{};  // of the first draw: its shaders are compiled at creation; others when first used
    // Textures of set_layers(), in bytes: finest mips are left out until they fit. Ten materials of 512 texels a side
    // take 7 MB.
    std::uint64_t material_bytes = std::uint64_t{64} << 20;
    std::uint32_t texture_side = 0; // texels a side that set_heights() uses at most; 0: as many as the driver takes
};

// Slots for the mesh of a cut of that budget, with morphing. map_bytes: what a frame may bring of streamed maps
// (StreamSettings::map_bytes); 0: none.
[[nodiscard]] RendererOptions room_for(const CutBudget& budget, std::uint32_t map_bytes);

// What the picture shows.
enum class Mode : std::uint8_t {
    shaded,
    levels,    // every triangle in its level's colour (fjell/gl/palette.h)
    distance,  // logarithmic: white at the near plane, black beyond the terrain
    tiles,     // every tile in a colour that its neighbours do not have
    mips,      // by the mip that colours, or else normals, are drawn from; nothing there yet: black
    residency, // by the finest step of geometry that is loaded over each place, whatever is drawn of it
    error      // by how far the drawn surface is above or below the full resolution, in pixels; needs set_heights()
};

// The terrain's heights, every 2^step_log2-th sample of each row and column; a last one that would lie beyond the rim
// stands there. io::read_heights() reads them from a pack.
struct HeightGrid {
    std::int32_t columns = 0, rows = 0;
    std::uint32_t step_log2 = 0;
    std::span<const float> heights_m; // row by row; NaN: a hole
};

// What a draw goes by.
struct DrawOptions {
    Mode mode = Mode::shaded;
    bool wireframe = false; // the triangles' edges over the picture
    // Lines on the surface, over any mode: around tiles, and around squares of 64 x 64 samples, the pages of the finest
    // step (none in linear order, whose pages are rows). Where they would lie closer than 6 pixels they fade out.
    bool tile_borders = false, page_borders = false;
    // Over any mode but distance: lines of equal height so many metres apart, every fifth one wider (0: none); and
    // slopes from 15, 25, 35 and 45 degrees on in palette.h's slope_rgb.
    double contour_m = 0;
    bool slope = false;
    bool sky = true;  // false: black
    bool lit = true;  // false: bare colours, to compare; with Mode::shaded without haze, film and water too
    bool haze = true; // Mode::shaded: air before the ground. Legends' colours are never hazed
    LightSettings light{};
    LayerSettings layers{}; // Mode::shaded, lit, after set_layers()
    double time_s = 0;      // moves the water's waves, and nothing else
    // Mode::error: vertical metres * lambda / distance from an eye, whatever their direction, as the cut measures them.
    float error_full_px = 1;           // what is red: the threshold that was promised; above it is white
    std::optional<Vec3> error_eye_m{}; // whose picture was refined; none: the view's
    double error_lambda_px = 0;        // that eye's; 0: the view's
    bool hatch = false;                // above it black and white stripes, not white
    // Rows of the target from below, these alone: to spread a picture over frames, band by band. end_row 0: all.
    std::uint32_t first_row = 0, end_row = 0;
};

// What uploads and draws have done.
struct DrawStats {
    std::uint64_t frames = 0;
    // For the last draw: of vertices, morph vertices and indices (records, when slots were scattered); of maps; and the
    // CPU's time for both, in GL calls and copies.
    std::uint64_t bytes_uploaded = 0, map_bytes_uploaded = 0;
    double upload_us = 0;
    std::uint64_t ring_waits = 0;           // uploads and draws that found the GPU three regions behind, so far
    std::uint64_t texture_bytes = 0;        // resident
    std::uint32_t tiles = 0, triangles = 0; // of the last draw
};

// Of one terrain in one context.
class Renderer {
public:
    // The terrain must be the pack's. O(texels).
    [[nodiscard]] static std::unique_ptr<Renderer> create(const Terrain& terrain, const Pack& pack,
                                                          const RendererOptions& options);
    // For a LiveTerrain: room for its mesh, with morphing, and for its streamed maps. Of options only what these do not
    // say counts: light, anisotropy, material_bytes, texture_side.
    [[nodiscard]] static std::unique_ptr<Renderer> create(const io::LiveTerrain& terrain,
                                                          const RendererOptions& options = {});
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    // Uploads what the last update wrote. draw() does it too; call it yourself after updates that are not drawn, or
    // their dirty ranges are lost. Another mesh than last time (by address or size) is uploaded whole.
    void upload(const MeshView& mesh);
    // The same for the live cut, whose indices are kept on the GPU too; needs RendererOptions::morph. changes: of
    // cut_take_changes(), after one update or several.
    void upload(const CutMesh& mesh, const CutChanges& changes);
    // Carries out the stream's stream_map_commands(), each once and in order: copies within the GPU, and blocks.
    void upload(std::span<const MapCommand> commands);
    // All that the last update of a LiveTerrain has brought: map commands, which tile shows which map, and the mesh.
    // After every update that is not drawn.
    void upload(io::LiveTerrain& terrain);
    // What Mode::error compares with; copied, 4 bytes a sample. Of a grid with a step above 1 places that are drawn as
    // fine stay grey: only what is coarser can be compared. An empty grid frees them.
    void set_heights(const HeightGrid& grid);
    // What DrawOptions::layers draws near ground with; the bytes that `materials` points into are read here and not
    // kept. Empty materials and rules free them. The next draw that has them on compiles its shader.
    // names: of the pack's chunk `layers` (io::layer_names()), which its splat maps speak of; all must be materials,
    // but water_layer.
    void set_layers(const io::Materials& materials, std::span<const LayerRule> rules,
                    std::span<const std::string> names = {});
    // How tiles are drawn from now on: the stream's stream_tile_maps() of each kind, one a tile; empty leaves
    // that kind as it is. Copied. Before it is called nothing of a streamed map shows.
    void show_maps(std::span<const TileMap> colour, std::span<const TileMap> normal,
                   std::span<const TileMap> horizon = {}, std::span<const TileMap> splat = {});
    // Makes the next upload a whole one: faster after rebuild_cut(), and needed when changes were taken and not
    // uploaded.
    void invalidate();

    // view.width_px and height_px give the aspect; the picture fills the target.
    void draw(const MeshView& mesh, const View& view, const DrawOptions& options, const Target& target);
    void draw(const CutMesh& mesh, const CutChanges& changes, const View& view, const DrawOptions& options,
              const Target& target);
    // The same of a LiveTerrain: uploads what its last update has brought, and draws it.
    void draw(io::LiveTerrain& terrain, const View& view, const DrawOptions& options, const Target& target);
    // Without the upload, for hosts that called it after the update. Indices of a mesh that is not a CutMesh's are
    // uploaded all the same.
    void draw_uploaded(const MeshView& mesh, const View& view, const DrawOptions& options, const Target& target);
    // A draw of next to nothing with these options, which the target then shows: drivers compile for the machine at the
    // first draw of a kind, in software for half a second. target: of any size, with the samples of pictures to come.
    // The next upload is a whole one.
    void rehearse(const DrawOptions& options, const Target& target);
    // In the context that has made this renderer, before it goes on in another one that shares objects with it, on
    // whatever thread: frees what contexts do not share, and waits for the GPU.
    void leave_context();
    [[nodiscard]] const DrawStats& stats() const;

private:
    Renderer();
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace fjell::gl
FJELL_API_END
