#include "gl/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include <epoxy/gl.h>

#include "gl/objects.h"
#include "gl/palette.h"
#include "gl/shaders.h"
#include "gl/textures.h"

namespace fjell::gl {
namespace {

// As glMultiDrawElementsIndirect reads it.
struct DrawCommand {
    std::uint32_t index_count, instances, first_index;
    std::int32_t base_vertex;
    std::uint32_t base_instance; // selects the TileBlock: attribute 2 advances once an instance
};
static_assert(sizeof(DrawCommand) == 20, "OpenGL prescribes this layout");

constexpr unsigned frame_binding = 0, colour_unit = 0, normal_unit = 1;
constexpr unsigned vertex_slot = 0, tile_slot = 1, morph_slot = 2;

Buffer make_buffer(std::size_t bytes) {
    unsigned name = 0;
    glCreateBuffers(1, &name);
    glNamedBufferStorage(name, static_cast<GLsizeiptr>(bytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
    return Buffer(name);
}

void write_buffer(const Buffer& buffer, std::size_t first, std::size_t bytes, const void* data) {
    if (bytes != 0)
        glNamedBufferSubData(buffer.get(), static_cast<GLintptr>(first), static_cast<GLsizeiptr>(bytes), data);
}

float to_linear(std::uint8_t srgb) {
    const double c = srgb / 255.0;
    return static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

bool is_software() {
    const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    return name != nullptr && (std::strstr(name, "llvmpipe") || std::strstr(name, "softpipe"));
}

void set4(float (&to)[4], double a, double b, double c, double d) {
    const double from[4] = {a, b, c, d};
    for (int i = 0; i < 4; ++i) to[i] = static_cast<float>(from[i]);
}

// Camera-relative scene to clip space. w = d, the distance along forward; z = near (far - d) / (far - near), so that
// z / w is 1 at near and 0 at far: reversed, because a float's precision lies near 0, where perspective crowds depths.
void view_projection(const View& view, float (&columns)[16]) {
    const Vec3 right = cross(view.forward, view.up);
    const double tangent = std::tan(view.fov_y_rad / 2), aspect = static_cast<double>(view.width_px) / view.height_px;
    const double range = view.far_m - view.near_m;
    const double r[3] = {right.x, right.y, right.z}, u[3] = {view.up.x, view.up.y, view.up.z};
    const double f[3] = {view.forward.x, view.forward.y, view.forward.z};
    for (int j = 0; j < 3; ++j) {
        columns[4 * j] = static_cast<float>(r[j] / (tangent * aspect));
        columns[4 * j + 1] = static_cast<float>(u[j] / tangent);
        columns[4 * j + 2] = static_cast<float>(-view.near_m / range * f[j]);
        columns[4 * j + 3] = static_cast<float>(f[j]);
    }
    for (int i = 12; i < 16; ++i) columns[i] = 0;
    columns[14] = static_cast<float>(view.near_m * view.far_m / range);
}

// The eye's cell: positions are counted from its first sample (see shaders.cpp).
struct EyeCell {
    std::int64_t column, row;
};
EyeCell eye_cell(const View& view, double spacing_x, double spacing_z) {
    const auto cell = [](double metres, double spacing) {
        return static_cast<std::int64_t>(std::floor(std::clamp(metres / spacing, -1e9, 1e9)));
    };
    return {cell(view.eye_m.x, spacing_x), cell(view.eye_m.z, spacing_z)};
}

} // namespace

struct Renderer::State {
    PackHeader header{};
    double spacing_x_m = 1, spacing_z_m = 1, diagonal_m = 1;
    RendererOptions options;
    TerrainTextures textures;
    Buffer vertices, morph, indices, tiles, commands, frame;
    MorphFrame morph_frame; // of the cut uploaded last
    VertexArray terrain_array, empty_array;
    Program terrain[3][2]; // by Mode, without and with wireframe
    Program sky;
    const MeshVertex* uploaded = nullptr; // whose vertices the buffer holds
    std::size_t uploaded_count = 0;
    const std::uint32_t* kept_indices = nullptr; // of a live cut, which the buffer holds; null: it holds one draw's
    bool drawn = false;                          // since the last upload
    std::vector<TileBlock> tile_blocks;
    std::vector<DrawCommand> draw_commands;
    DrawStats stats;

    std::string make_programs();
    void make_buffers();
    [[nodiscard]] std::size_t range_capacity() const;
    std::string check(const MeshView& mesh, const View& view) const;
    bool begin_upload(const MeshView& mesh);
    void count(std::size_t bytes) { stats.bytes_uploaded += bytes; }
    void upload_indices(const MeshView& mesh);
    FrameBlock make_frame(const View& view, const DrawOptions& options) const;
    void write_tiles(const MeshView& mesh);
    void draw_picture(GLenum primitive, const DrawOptions& options) const;
};

std::string Renderer::State::make_programs() {
    const std::string common = common_shader();
    const std::string maps = std::string(textures.colour.get() ? "#define COLOUR_MAP\n" : "") +
                             (textures.normal.get() ? "#define NORMAL_MAP\n" : "");
    const char* const modes[3] = {"", "#define LEVELS\n", "#define DISTANCE\n"};
    std::string error;
    for (int mode = 0; mode < 3; ++mode)
        for (int wire = 0; wire < 2 && error.empty(); ++wire) {
            const bool per_triangle = wire != 0 || mode == static_cast<int>(Mode::levels);
            std::string before = maps;
            before += modes[mode];
            before += wire ? "#define WIREFRAME\n" : "";
            before += common;
            terrain[mode][wire] =
                make_program({"terrain", std::move(before), terrain_vertex_shader(),
                              per_triangle ? terrain_geometry_shader() : "", terrain_fragment_shader()},
                             error);
        }
    if (error.empty()) sky = make_program({"sky", common, sky_vertex_shader(), "", sky_fragment_shader()}, error);
    return error;
}

void Renderer::State::make_buffers() {
    const std::size_t ranges = range_capacity();
    vertices = make_buffer(std::size_t{options.vertices} * sizeof(MeshVertex));
    indices = make_buffer(std::size_t{options.indices} * sizeof(std::uint32_t));
    tiles = make_buffer(ranges * sizeof(TileBlock));
    commands = make_buffer(ranges * sizeof(DrawCommand));
    frame = make_buffer(sizeof(FrameBlock));
    tile_blocks.reserve(ranges);
    draw_commands.reserve(ranges);

    unsigned name = 0;
    glCreateVertexArrays(1, &name);
    empty_array = VertexArray(name);
    glCreateVertexArrays(1, &name);
    terrain_array = VertexArray(name);
    glVertexArrayVertexBuffer(name, vertex_slot, vertices.get(), 0, sizeof(MeshVertex));
    glVertexArrayVertexBuffer(name, tile_slot, tiles.get(), 0, sizeof(TileBlock));
    glVertexArrayBindingDivisor(name, tile_slot, 1);
    glVertexArrayElementBuffer(name, indices.get());
    glVertexArrayAttribIFormat(name, 0, 2, GL_INT, offsetof(MeshVertex, column));
    glVertexArrayAttribFormat(name, 1, 1, GL_FLOAT, GL_FALSE, offsetof(MeshVertex, height_m));
    glVertexArrayAttribIFormat(name, 2, 4, GL_INT, 0);
    for (unsigned attribute = 0; attribute < 3; ++attribute) {
        glEnableVertexArrayAttrib(name, attribute);
        glVertexArrayAttribBinding(name, attribute, attribute == 2 ? tile_slot : vertex_slot);
    }
    if (!options.morph) return;
    morph = make_buffer(std::size_t{options.vertices} * sizeof(MorphVertex));
    glVertexArrayVertexBuffer(name, morph_slot, morph.get(), 0, sizeof(MorphVertex));
    glVertexArrayAttribFormat(name, 3, 4, GL_FLOAT, GL_FALSE, 0);
    glEnableVertexArrayAttrib(name, 3);
    glVertexArrayAttribBinding(name, 3, morph_slot);
}

Renderer::Renderer() : state_(std::make_unique<State>()) {}
Renderer::~Renderer() = default;
const DrawStats& Renderer::stats() const {
    return state_->stats;
}
void Renderer::invalidate() {
    state_->uploaded = nullptr;
    state_->kept_indices = nullptr;
}

std::unique_ptr<Renderer> Renderer::create(const Terrain& terrain, const Pack& pack, const RendererOptions& options,
                                           std::string& error) {
    error.clear();
    std::unique_ptr<Renderer> result(new Renderer);
    State& s = *result->state_;
    s.header = terrain.header;
    s.options = options;
    s.spacing_x_m = terrain.spacing_x_m;
    s.spacing_z_m = terrain.spacing_z_m;
    s.diagonal_m = std::hypot(s.spacing_x_m * (terrain.header.columns - 1), s.spacing_z_m * (terrain.header.rows - 1));
    if (options.vertices == 0 || options.indices == 0) {
        error = "RendererOptions::vertices and ::indices must not be 0: give them the method's budget";
        return nullptr;
    }
    // llvmpipe walks an ellipse of texels whose size it does not bound where uv is extrapolated at the rim of tiny
    // multisampled triangles: frames of half a minute were seen.
    const float anisotropy = is_software() ? 1.0f : options.anisotropy > 0 ? options.anisotropy : 8.0f;
    error = load_textures(pack, anisotropy, s.textures);
    if (error.empty()) error = s.make_programs();
    if (!error.empty()) return nullptr;
    s.stats.texture_bytes = s.textures.bytes;
    while (glGetError() != GL_NO_ERROR) {
    } // so that the check below speaks of these buffers
    s.make_buffers();
    if (glGetError() == GL_NO_ERROR) return result;
    error = "the GPU has no room for the mesh buffers: lower RendererOptions::vertices, ::indices or ::ranges";
    return nullptr;
}

std::size_t Renderer::State::range_capacity() const {
    return std::max<std::size_t>(std::size_t{header.tiles_x} * header.tiles_y, options.ranges);
}

std::string Renderer::State::check(const MeshView& mesh, const View& view) const {
    if (const Status status = validate(view); !status.ok())
        return std::string("the view cannot be drawn: ") + status.field + ": " + message(status.code);
    if (mesh.vertices.size() > options.vertices)
        return "the mesh has " + std::to_string(mesh.vertices.size()) +
               " vertex slots: raise RendererOptions::vertices";
    if (mesh.indices.size() > options.indices)
        return "the mesh has " + std::to_string(mesh.indices.size()) + " indices: raise RendererOptions::indices";
    if (mesh.tiles.size() > range_capacity())
        return "the mesh has " + std::to_string(mesh.tiles.size()) + " ranges: raise RendererOptions::ranges";
    const std::uint32_t tile_count = header.tiles_x * header.tiles_y;
    bool good = mesh.dirty_begin <= mesh.dirty_end && mesh.dirty_end <= mesh.vertices.size();
    for (const TileRange& range : mesh.tiles)
        good = good && range.tile < tile_count && range.first_index <= mesh.indices.size() &&
               range.index_count <= mesh.indices.size() - range.first_index;
    return good ? std::string() : "the mesh is not of this terrain: a tile or a range lies outside it";
}

// Whether this mesh must be uploaded whole.
bool Renderer::State::begin_upload(const MeshView& mesh) {
    if (std::exchange(drawn, false)) stats.bytes_uploaded = 0;
    const bool whole = uploaded != mesh.vertices.data() || uploaded_count != mesh.vertices.size();
    uploaded = mesh.vertices.data();
    uploaded_count = mesh.vertices.size();
    return whole;
}

std::string Renderer::upload(const MeshView& mesh) {
    State& s = *state_;
    s.morph_frame = {};
    if (mesh.vertices.size() > s.options.vertices || mesh.dirty_end > mesh.vertices.size() ||
        mesh.dirty_begin > mesh.dirty_end)
        return "the mesh has more vertex slots than RendererOptions::vertices, or its dirty range lies outside them";
    const bool whole = s.begin_upload(mesh);
    s.kept_indices = nullptr;
    const std::size_t begin = whole ? 0 : mesh.dirty_begin, end = whole ? mesh.vertices.size() : mesh.dirty_end;
    write_buffer(s.vertices, begin * sizeof(MeshVertex), (end - begin) * sizeof(MeshVertex),
                 mesh.vertices.data() + begin);
    s.count((end - begin) * sizeof(MeshVertex));
    return {};
}

std::string Renderer::upload(const CutMesh& cut) {
    State& s = *state_;
    const MeshView& mesh = cut.mesh;
    if (!s.options.morph) return "a live cut needs RendererOptions::morph";
    if (mesh.vertices.size() > s.options.vertices || mesh.indices.size() > s.options.indices)
        return "the cut has more slots than RendererOptions::vertices or ::indices: give them the cut's budget";
    if (cut.morph.size() != mesh.vertices.size())
        return "the cut's morph vertices are not one for one with its vertices";
    const auto vertices = [&](std::size_t first, std::size_t count) {
        write_buffer(s.vertices, first * sizeof(MeshVertex), count * sizeof(MeshVertex), mesh.vertices.data() + first);
        write_buffer(s.morph, first * sizeof(MorphVertex), count * sizeof(MorphVertex), cut.morph.data() + first);
        s.count(count * (sizeof(MeshVertex) + sizeof(MorphVertex)));
    };
    constexpr std::size_t triangle_bytes = 3 * sizeof(std::uint32_t);
    const auto triangles = [&](std::size_t first, std::size_t count) {
        write_buffer(s.indices, first * triangle_bytes, count * triangle_bytes, mesh.indices.data() + 3 * first);
        s.count(count * triangle_bytes);
    };
    s.morph_frame = cut.frame;
    const bool other_indices = std::exchange(s.kept_indices, mesh.indices.data()) != mesh.indices.data();
    if (s.begin_upload(mesh) || other_indices) {
        vertices(0, mesh.vertices.size());
        triangles(0, mesh.indices.size() / 3);
    } else {
        for_each_run(cut.vertex_bits, cut.vertex_words, vertices);
        for_each_run(cut.triangle_bits, cut.triangle_words, triangles);
    }
    return {};
}

void Renderer::State::upload_indices(const MeshView& mesh) {
    if (kept_indices != nullptr && kept_indices == mesh.indices.data()) return;
    kept_indices = nullptr;
    glInvalidateBufferData(indices.get()); // the last picture may still be reading the old ones
    write_buffer(indices, 0, mesh.indices.size_bytes(), mesh.indices.data());
    count(mesh.indices.size_bytes());
}

FrameBlock Renderer::State::make_frame(const View& view, const DrawOptions& options_now) const {
    FrameBlock block{};
    view_projection(view, block.view_projection);
    const EyeCell cell = eye_cell(view, spacing_x_m, spacing_z_m);
    const double high = static_cast<float>(view.eye_m.y);
    set4(block.eye, view.eye_m.x - static_cast<double>(cell.column) * spacing_x_m,
         view.eye_m.z - static_cast<double>(cell.row) * spacing_z_m, high, view.eye_m.y - high);
    const SampleToTexel colour = sample_to_texel(header.colour_log2, header.tile_log2);
    const SampleToTexel normal = sample_to_texel(header.normal_log2, header.tile_log2);
    set4(block.grid, spacing_x_m, spacing_z_m, colour.scale, colour.offset);
    const double farthest_m = std::max(1.5 * diagonal_m, 2 * view.near_m);
    set4(block.grid2, normal.scale, normal.offset, view.near_m, 1 / std::log2(farthest_m / view.near_m));
    constexpr double degree = 3.14159265358979323846 / 180;
    const double azimuth = options_now.sun_azimuth_deg * degree, elevation = options_now.sun_elevation_deg * degree;
    set4(block.sun, std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
         -std::cos(azimuth) * std::cos(elevation), options_now.lit ? 1 : 0);
    const double haze_m = options_now.haze_m == 0 ? 1.5 * diagonal_m : options_now.haze_m;
    set4(block.haze, haze_m > 0 ? 1 / haze_m : 0, view.forward.x, view.forward.y, view.forward.z);
    const double tangent = std::tan(view.fov_y_rad / 2), aspect = static_cast<double>(view.width_px) / view.height_px;
    const Vec3 x = cross(view.forward, view.up) * (tangent * aspect), y = view.up * tangent;
    set4(block.ray_x, x.x, x.y, x.z, 0);
    set4(block.ray_y, y.x, y.y, y.z, 0);
    set4(block.line, 0.01, 0.01, 0.012, 1);
    block.tile[0] = static_cast<std::int32_t>(header.tile_log2);
    block.tile[2] = static_cast<std::int32_t>(cell.column);
    block.tile[3] = static_cast<std::int32_t>(cell.row);
    const MorphFrame& m = morph_frame;
    if (m.morph != Morph::none) set4(block.morph, m.views, m.now_s, 1 / m.morph_s, 0);
    for (std::uint32_t i = 0; i < m.views; ++i) {
        const MorphView& v = m.view[i];
        set4(block.morph_eye[i], v.eye_x - view.eye_m.x, v.eye_y - view.eye_m.y, v.eye_z - view.eye_m.z, 0);
        set4(block.morph_reach[i], v.q_start, v.q_full, 0, 0);
    }
    for (int level = 0; level < max_triangle_levels; ++level) {
        const Rgb8 rgb = level_rgb(level, static_cast<int>(header.tile_log2));
        set4(block.level[level], to_linear(rgb[0]), to_linear(rgb[1]), to_linear(rgb[2]), 1);
    }
    return block;
}

void Renderer::State::write_tiles(const MeshView& mesh) {
    tile_blocks.clear();
    draw_commands.clear();
    stats.tiles = stats.triangles = 0;
    for (const TileRange& range : mesh.tiles) {
        if (range.index_count == 0) continue;
        const auto tile = static_cast<std::int32_t>(range.tile);
        if (tile_blocks.empty() || tile_blocks.back().layer != tile) { // a tile's ranges follow each other
            const std::int64_t column = range.tile % header.tiles_x, row = range.tile / header.tiles_x;
            tile_blocks.push_back({static_cast<std::int32_t>(column << header.tile_log2),
                                   static_cast<std::int32_t>(row << header.tile_log2), tile, 0});
            ++stats.tiles;
        }
        const auto instance = static_cast<std::uint32_t>(tile_blocks.size() - 1);
        draw_commands.push_back({range.index_count, 1, range.first_index, 0, instance});
        stats.triangles += range.triangles;
    }
    write_buffer(tiles, 0, tile_blocks.size() * sizeof(TileBlock), tile_blocks.data());
    write_buffer(commands, 0, draw_commands.size() * sizeof(DrawCommand), draw_commands.data());
}

void Renderer::State::draw_picture(GLenum primitive, const DrawOptions& now) const {
    glUseProgram(terrain[static_cast<int>(now.mode)][now.wireframe ? 1 : 0].get());
    glBindVertexArray(terrain_array.get());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands.get());
    glMultiDrawElementsIndirect(primitive, GL_UNSIGNED_INT, nullptr, static_cast<GLsizei>(draw_commands.size()), 0);
    if (now.sky && now.mode != Mode::distance) {
        glDepthMask(GL_FALSE);
        glUseProgram(sky.get());
        glBindVertexArray(empty_array.get());
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
}

std::string Renderer::draw(const MeshView& mesh, const View& view, const DrawOptions& options, const Target& target) {
    if (std::string error = state_->check(mesh, view); !error.empty()) return error;
    if (std::string error = upload(mesh); !error.empty()) return error;
    return draw_uploaded(mesh, view, options, target);
}

std::string Renderer::draw(const CutMesh& mesh, const View& view, const DrawOptions& options, const Target& target) {
    if (std::string error = state_->check(mesh.mesh, view); !error.empty()) return error;
    if (std::string error = upload(mesh); !error.empty()) return error;
    return draw_uploaded(mesh.mesh, view, options, target);
}

std::string Renderer::draw_uploaded(const MeshView& mesh, const View& view, const DrawOptions& options,
                                    const Target& target) {
    State& s = *state_;
    if (std::string error = s.check(mesh, view); !error.empty()) return error;
    if (s.uploaded != mesh.vertices.data()) return "the mesh was not uploaded: call upload() after the update";
    s.upload_indices(mesh);
    s.drawn = true;
    s.write_tiles(mesh);
    const FrameBlock block = s.make_frame(view, options);
    write_buffer(s.frame, 0, sizeof block, &block);

    // All state we depend on: a user interface may have drawn in this context in between.
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer());
    glViewport(0, 0, static_cast<GLsizei>(target.width()), static_cast<GLsizei>(target.height()));
    for (const GLenum off : {GL_BLEND, GL_SCISSOR_TEST, GL_STENCIL_TEST, GL_RASTERIZER_DISCARD}) glDisable(off);
    for (const GLenum on : {GL_DEPTH_TEST, GL_CULL_FACE, GL_FRAMEBUFFER_SRGB, GL_MULTISAMPLE}) glEnable(on);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glCullFace(GL_BACK);
    glFrontFace(GL_CCW);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glDepthFunc(GL_GEQUAL);
    const float black[4] = {0, 0, 0, 1}, farthest = 0;
    glClearNamedFramebufferfv(target.framebuffer(), GL_COLOR, 0, black);
    glClearNamedFramebufferfv(target.framebuffer(), GL_DEPTH, 0, &farthest);
    glBindBufferBase(GL_UNIFORM_BUFFER, frame_binding, s.frame.get());
    glBindTextureUnit(colour_unit, s.textures.colour.get());
    glBindTextureUnit(normal_unit, s.textures.normal.get());
    glBindSampler(colour_unit, 0);
    glBindSampler(normal_unit, 0);

    s.draw_picture(mesh.topology == Topology::strip ? GL_TRIANGLE_STRIP : GL_TRIANGLES, options);

    glDepthMask(GL_TRUE);
    glDisable(GL_CULL_FACE);
    glDepthFunc(GL_LESS);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glBindVertexArray(0);
    ++s.stats.frames;
    return {};
}

} // namespace fjell::gl
