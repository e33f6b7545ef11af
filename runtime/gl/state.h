// What a Renderer holds, and the steps that its calls are made of.
//
// Internal to runtime/gl: renderer.cpp sets up, uploads and draws, frame.cpp computes a draw's numbers.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "fjell/gl/renderer.h"
#include "fjell/ground_maps.h"
#include "fjell/io/load.h"
#include "gl/layers.h"
#include "gl/lighting.h"
#include "gl/maps.h"
#include "gl/objects.h"
#include "gl/scatter.h"
#include "gl/shaders.h"
#include "gl/surround.h"
#include "gl/terrain_textures.h"

namespace fjell::gl {

inline constexpr int mode_count = 7;

// As glMultiDrawElementsIndirect reads it.
struct DrawCommand {
    std::uint32_t index_count, instances, first_index;
    std::int32_t base_vertex;
    std::uint32_t base_instance; // selects the TileBlock: attribute 2 advances once an instance
};
static_assert(sizeof(DrawCommand) == 20, "OpenGL prescribes this layout");

// A draw's numbers in the ring.
struct DrawData {
    RingSlice frame, tiles, commands;
    std::size_t tile_bytes = 0;
    std::uint32_t command_count = 0;
};

struct Renderer::State {
    Terrain terrain;
    PackHeader header{};
    double spacing_x_m = 1, spacing_z_m = 1, diagonal_m = 1;
    RendererOptions options;
    Maps maps;
    io::AlignedMemory ground_memory;
    GroundMaps ground_maps; // if there are normals, colours or splat maps
    std::uint64_t paint_cursor = 0;
    Residency residency;
    Heights heights;
    Ring ring;
    Scatter scatter;
    MeshBuffers mesh;
    MorphFrame morph_frame; // of the cut uploaded last
    VertexArray terrain_array, empty_array;
    Lighting lighting;
    Surround surround;
    Layers ground_layers;
    unsigned light_bits = 0; // of the draw
    // By Mode, wireframe, borders, all_there() and, of the shaded mode, the light's variant; made at first use.
    Program programs[mode_count][2][2][2][light_variants];
    Program sky[2];                       // with the simple and with the physical air
    const MeshVertex* uploaded = nullptr; // whose vertices the buffer holds
    std::size_t uploaded_count = 0;
    const std::uint32_t* kept_indices = nullptr; // of a live cut, which the buffer holds; null: it holds one draw's
    bool drawn = false;                          // since the last upload
    DrawStats stats;

    // The first texture unit of splat maps: behind those of horizons.
    [[nodiscard]] unsigned splat_unit() const { return horizon_unit + maps.kind[2].sizes; }
    // renderer.cpp
    // On the surface: a variant of the shader has them all.
    [[nodiscard]] static bool draws_lines(const DrawOptions& now) {
        return now.tile_borders || now.page_borders || now.contour_m > 0 || now.slope;
    }
    [[nodiscard]] bool all_there(Mode mode) const { return maps.all_there && mode <= Mode::distance; }
    [[nodiscard]] Program& program_of(const DrawOptions& now) {
        const bool borders = draws_lines(now);
        return programs[static_cast<int>(now.mode)][now.wireframe ? 1 : 0][borders ? 1 : 0][all_there(now.mode) ? 1 : 0]
                       [now.mode != Mode::shaded ? 0
                        : now.lit                ? light_bits
                                                 : light_none];
    }
    void make_program_of(const DrawOptions& now);
    void make_sky_program();
    [[nodiscard]] static bool draws_surround(const DrawOptions& now) {
        return now.sky && now.lit && now.haze && now.mode == Mode::shaded;
    }
    void prepare_surround();
    void make_buffers();
    void make_arrays();
    [[nodiscard]] std::size_t range_capacity() const;
    [[nodiscard]] std::size_t ring_bytes() const;
    [[nodiscard]] std::size_t draw_bytes(std::size_t ranges) const;
    void check(const MeshView& mesh, const View& view) const;
    void prepare(const DrawOptions& now);
    void set_up(const Target& target, const DrawOptions& now) const;
    void bind_maps(Mode mode) const;
    void draw_picture(const DrawData& data, unsigned primitive, const DrawOptions& now);
    void begin_frame();
    bool begin_upload(const MeshView& mesh);
    void upload_indices(const MeshView& mesh);
    // frame.cpp
    FrameBlock make_frame(const View& view, const DrawOptions& now) const;
    void set_error(const View& view, const DrawOptions& now, FrameBlock& block) const;
    void set_light(const View& view, const DrawOptions& now, FrameBlock& block) const;
    void set_ambient(const SkyLight& ground, double sun_y, FrameBlock& block) const;
    void set_layers(const View& view, const DrawOptions& now, FrameBlock& block) const;
    void set_shadow(const Vec3& sun, FrameBlock& block) const;
    void set_noise(const View& view, FrameBlock& block, double shrunk) const;
    TileBlock make_tile(std::uint32_t tile, std::uint32_t index) const;
    DrawData write_draw(const MeshView& mesh, const View& view, const DrawOptions& now);
};

// Adds the time until it goes out of scope.
class Stopwatch {
public:
    explicit Stopwatch(double& us) : us_(us) {}
    ~Stopwatch() {
        us_ += std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start_).count();
    }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;

private:
    double& us_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace fjell::gl
