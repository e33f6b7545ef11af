#include "fjell/gl/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <utility>

#include <epoxy/gl.h>

#include "fjell/io/live_terrain.h"
#include "gl/fail.h"
#include "gl/state.h"

namespace fjell::gl {

namespace {

using Switches = std::initializer_list<GLenum>;

constexpr unsigned frame_binding = 0, tiles_binding = 0, colour_unit = 0, normal_unit = max_map_sizes;
constexpr unsigned vertex_slot = 0, tile_slot = 1, morph_slot = 2;

Buffer make_buffer(std::size_t bytes) {
    unsigned name = 0;
    glCreateBuffers(1, &name);
    glNamedBufferStorage(name, static_cast<GLsizeiptr>(bytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
    return Buffer(name);
}

bool is_software() {
    const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    return name != nullptr && (std::strstr(name, "llvmpipe") || std::strstr(name, "softpipe"));
}

std::string arrays_define(const char* name, const MapArrays& arrays) {
    return arrays.present() ? std::string("#define ") + name + " " + std::to_string(arrays.sizes) + "\n" : "";
}

std::string light_defines(unsigned bits) {
    std::string defines = bits == light_none ? "" : "#define LIT\n";
    if ((bits & light_air) != 0) defines += "#define AIR\n";
    if ((bits & light_detail) != 0) defines += "#define DETAIL\n";
    if ((bits & light_water) != 0) defines += "#define WATER\n";
    if ((bits & light_layers) != 0) defines += "#define LAYERS\n";
    if ((bits & light_shadows) != 0) defines += "#define SHADOWS\n";
    if ((bits & light_splat) != 0) defines += "#define SPLAT\n";
    if ((bits & light_lakes) != 0) defines += "#define LAKES\n";
    return defines;
}

// GL guarantees 128 MB to a buffer that a shader writes.
void check_limits(const RendererOptions& options) {
    if (options.vertices == 0 || options.indices == 0)
        fail("RendererOptions::vertices and ::indices must not be 0: give them the method's budget");
    GLint64 most = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
    const auto bytes = std::max<GLint64>(GLint64{options.vertices} * GLint64{sizeof(MorphVertex)},
                                         GLint64{options.indices} * GLint64{sizeof(std::uint32_t)});
    if (!options.morph || bytes <= most) return;
    fail("RendererOptions::vertices and ::indices make buffers of " + std::to_string(bytes) +
         " bytes and this GPU's shaders write at most " + std::to_string(most) + ": lower them");
}

} // namespace

void Renderer::State::make_program_of(const DrawOptions& now) {
    const Mode mode = now.mode;
    Program& program = program_of(now);
    if (program.get() != 0) return;
    const char* const modes[mode_count] = {"#define SHADED\n", "#define LEVELS\n", "#define DISTANCE\n",
                                           "#define TILES\n",  "#define MIPS\n",   "#define RESIDENCY\n",
                                           "#define ERROR\n"};
    std::string before = arrays_define("COLOUR_MAPS", maps.kind[0]) + arrays_define("NORMAL_MAPS", maps.kind[1]) +
                         arrays_define("HORIZON_MAPS", maps.kind[2]) + arrays_define("SPLAT_MAPS", maps.kind[3]) +
                         "#define SPLAT_UNIT " + std::to_string(splat_unit()) + "\n";
    before += modes[static_cast<int>(mode)];
    if (all_there(mode)) before += "#define ALL_THERE\n";
    if (now.wireframe) before += "#define WIREFRAME\n";
    if (draws_lines(now)) before += "#define BORDERS\n";
    const bool shaded = mode == Mode::shaded;
    if (shaded) before += light_defines(now.lit ? light_bits : light_none);
    before += common_shader();
    std::string fragment = terrain_fragment_shader();
    if (shaded && now.lit) fragment += std::string(light_shader()) + layers_shader() + ground_light_shader();
    fragment += std::string(overlay_shader()) + terrain_main_shader();
    const bool per_triangle = now.wireframe || mode == Mode::levels || mode == Mode::error;
    program = make_program({"terrain", std::move(before), terrain_vertex_shader(),
                            per_triangle ? terrain_geometry_shader() : "", std::move(fragment)});
}

void Renderer::State::make_sky_program() {
    Program& program = sky[light_bits & light_air];
    if (program.get() == 0)
        program = make_program({"sky", light_defines(light_bits & light_air) + common_shader(), sky_vertex_shader(), "",
                                std::string(light_shader()) + sky_fragment_shader()});
}

void Renderer::State::prepare_surround() {
    surround.follow(terrain, maps);
    Program& program = surround.program[light_bits & light_air];
    if (program.get() == 0)
        program =
            make_program({"surround", light_defines(light_bits & light_air) + common_shader(), surround_vertex_shader(),
                          "", std::string(light_shader()) + surround_fragment_shader()});
}

void Renderer::State::make_buffers() {
    mesh.vertices = make_buffer(std::size_t{options.vertices} * sizeof(MeshVertex));
    mesh.indices = make_buffer(std::size_t{options.indices} * sizeof(std::uint32_t));
    if (options.morph) mesh.morph = make_buffer(std::size_t{options.vertices} * sizeof(MorphVertex));
}

// Contexts do not share these: made by the first draw in each.
void Renderer::State::make_arrays() {
    if (terrain_array.get() != 0) return;
    unsigned name = 0;
    glCreateVertexArrays(1, &name);
    empty_array = VertexArray(name);
    glCreateVertexArrays(1, &name);
    terrain_array = VertexArray(name);
    glVertexArrayVertexBuffer(name, vertex_slot, mesh.vertices.get(), 0, sizeof(MeshVertex));
    glVertexArrayBindingDivisor(name, tile_slot, 1); // its buffer is the ring, at each draw's place
    glVertexArrayElementBuffer(name, mesh.indices.get());
    glVertexArrayAttribIFormat(name, 0, 2, GL_INT, offsetof(MeshVertex, column));
    glVertexArrayAttribFormat(name, 1, 1, GL_FLOAT, GL_FALSE, offsetof(MeshVertex, height_m));
    glVertexArrayAttribIFormat(name, 2, 4, GL_INT, 0);
    for (unsigned attribute = 0; attribute < 3; ++attribute) {
        glEnableVertexArrayAttrib(name, attribute);
        glVertexArrayAttribBinding(name, attribute, attribute == 2 ? tile_slot : vertex_slot);
    }
    if (!options.morph) return;
    glVertexArrayVertexBuffer(name, morph_slot, mesh.morph.get(), 0, sizeof(MorphVertex));
    glVertexArrayAttribFormat(name, 3, 4, GL_FLOAT, GL_FALSE, 0);
    glEnableVertexArrayAttrib(name, 3);
    glVertexArrayAttribBinding(name, 3, morph_slot);
}

Renderer::Renderer() : state_(std::make_unique<State>()) {}
Renderer::~Renderer() = default;
const DrawStats& Renderer::stats() const {
    return state_->stats;
}

std::unique_ptr<Renderer> Renderer::create(const Terrain& terrain, const Pack& pack, const RendererOptions& options) {
    std::unique_ptr<Renderer> result(new Renderer);
    State& s = *result->state_;
    s.terrain = terrain;
    s.header = terrain.header();
    s.options = options;
    // As queries count: a float's spacing is off by up to 2^-25 of it, which a million columns away is a thirtieth of a
    // cell.
    s.spacing_x_m = terrain.header().spacing_m[0];
    s.spacing_z_m = terrain.header().spacing_m[1];
    s.diagonal_m =
        std::hypot(s.spacing_x_m * (terrain.header().columns - 1), s.spacing_z_m * (terrain.header().rows - 1));
    if (!terrain.valid()) fail("the terrain's handle is empty or destroyed; create a terrain first");
    check_limits(options);
    // llvmpipe walks an ellipse of texels whose size it does not bound where uv is extrapolated at the rim of tiny
    // multisampled triangles: frames of half a minute were seen.
    const float anisotropy = is_software() ? 1.0f : options.anisotropy > 0 ? options.anisotropy : 8.0f;
    make_maps(pack, {options.colour, options.normal, options.horizon, options.splat},
              {anisotropy, options.horizons, options.splat_maps}, s.maps);
    const auto has = [&](MapKind kind) { return s.maps.kind[static_cast<std::uint32_t>(kind)].present(); };
    if (has(MapKind::normal) || has(MapKind::colour) || has(MapKind::splat)) {
        const std::size_t bytes = ground_maps_bytes(s.header, options.ground);
        s.ground_memory = io::allocate(bytes);
        if (const Status made =
                create_ground_maps(terrain, options.ground, {s.ground_memory.get(), bytes}, s.ground_maps);
            !made.ok())
            fail(std::string("RendererOptions::ground: ") + made.field + ": " + message(made.code));
    }
    s.prepare({.light = options.light});
    if (options.morph) s.scatter.create();
    s.stats.texture_bytes = s.maps.bytes;
    while (glGetError() != GL_NO_ERROR) {
    } // so that the check below speaks of these buffers
    s.make_buffers();
    s.ring.create(s.ring_bytes() + s.draw_bytes(s.range_capacity()), "RendererOptions::ring_bytes or ::ranges");
    if (glGetError() != GL_NO_ERROR)
        fail("the GPU has no room for the mesh buffers: lower RendererOptions::vertices, ::indices or ::ranges");
    return result;
}

RendererOptions room_for(const CutBudget& budget, std::uint32_t map_bytes) {
    RendererOptions room;
    room.vertices = budget.vertices;
    room.indices = 3 * budget.triangles;
    room.ranges = budget.triangles / budget.segment_triangles;
    room.morph = true;
    if (map_bytes != 0) // as without, and what a frame may bring of maps
        room.ring_bytes =
            std::max(4 * budget.vertices + 2 * budget.triangles, 1u << 20) + std::min(map_bytes, 1u << 28);
    return room;
}

std::unique_ptr<Renderer> Renderer::create(const io::LiveTerrain& terrain, const RendererOptions& options) {
    RendererOptions room = room_for(terrain.options().cut, terrain.settings.stream.map_bytes);
    room.anisotropy = options.anisotropy;
    room.light = options.light;
    room.material_bytes = options.material_bytes;
    room.texture_side = options.texture_side;
    room.colour = stream_map_layers(terrain.stream(), MapKind::colour);
    room.normal = stream_map_layers(terrain.stream(), MapKind::normal);
    room.horizon = stream_map_layers(terrain.stream(), MapKind::horizon);
    room.splat = stream_map_layers(terrain.stream(), MapKind::splat);
    return create(terrain.terrain(), terrain.pack(), room);
}

void Renderer::upload(io::LiveTerrain& terrain) {
    upload(terrain.take_map_commands());
    show_maps(terrain.tile_maps(MapKind::colour), terrain.tile_maps(MapKind::normal),
              terrain.tile_maps(MapKind::horizon), terrain.tile_maps(MapKind::splat));
    show_ground();
    upload(terrain.frame().mesh, terrain.take_changes());
}

void Renderer::draw(io::LiveTerrain& terrain, const View& view, const DrawOptions& options, const Target& target) {
    upload(terrain);
    draw_uploaded(terrain.frame().mesh.mesh, view, options, target);
}

std::size_t Renderer::State::range_capacity() const {
    return std::max<std::size_t>(tiles_of(header), options.ranges);
}

std::size_t Renderer::State::ring_bytes() const {
    if (options.ring_bytes != 0) return std::max<std::size_t>(options.ring_bytes, 1u << 16); // a row of blocks at least
    const std::size_t slots = options.morph ? std::size_t{options.vertices} * sizeof(VertexSlotRecord) +
                                                  std::size_t{options.indices} / 3 * sizeof(TriangleSlotRecord)
                                            : 0;
    return std::max<std::size_t>(slots / 8, 1u << 20);
}

// Every slice of the ring begins on a boundary of at most 256 bytes or the driver's alignment.
std::size_t Renderer::State::draw_bytes(std::size_t ranges) const {
    return ring.aligned(sizeof(FrameBlock)) + ring.aligned(ranges * sizeof(TileBlock)) +
           ring.aligned(ranges * sizeof(DrawCommand));
}

void Renderer::State::check(const MeshView& mesh_view, const View& view) const {
    if (const Status status = validate(view); !status.ok())
        fail(std::string("the view cannot be drawn: ") + status.field + ": " + message(status.code));
    if (mesh_view.vertices.size() > options.vertices)
        fail("the mesh has " + std::to_string(mesh_view.vertices.size()) +
             " vertex slots: raise RendererOptions::vertices");
    if (mesh_view.indices.size() > options.indices)
        fail("the mesh has " + std::to_string(mesh_view.indices.size()) + " indices: raise RendererOptions::indices");
    if (mesh_view.tiles.size() > range_capacity())
        fail("the mesh has " + std::to_string(mesh_view.tiles.size()) + " ranges: raise RendererOptions::ranges");
    const std::uint32_t tile_count = tiles_of(header);
    bool good = mesh_view.dirty_begin <= mesh_view.dirty_end && mesh_view.dirty_end <= mesh_view.vertices.size();
    for (const TileRange& range : mesh_view.tiles)
        good = good && range.tile < tile_count && range.first_index <= mesh_view.indices.size() &&
               range.index_count <= mesh_view.indices.size() - range.first_index;
    if (!good) fail("the mesh is not of this terrain: a tile or a range lies outside it");
}

// What a mode needs besides its shader.
void Renderer::State::prepare(const DrawOptions& now) {
    if (now.mode == Mode::error) {
        if (!heights.present()) fail("Mode::error has nothing to compare with: call set_heights() before");
        if (!(now.error_full_px > 0)) fail("DrawOptions::error_full_px must be above 0");
    }
    validate(now.layers);
    light_bits = lighting.variant(now.light);
    if (now.layers.on && ground_layers.present() && now.mode == Mode::shaded && now.lit &&
        lighting.units > static_cast<int>(material_normal_unit)) {
        const bool mapped = now.layers.splat && ground_layers.names != 0 && maps.kind[3].sizes != 0 &&
                            lighting.units >= static_cast<int>(splat_unit() + maps.kind[3].sizes);
        if (mapped || ground_layers.rules != 0) light_bits |= light_layers | (mapped ? light_splat : 0);
        if (mapped && ground_layers.lakes) light_bits |= light_lakes | light_water;
    }
    const auto horizons = static_cast<int>(maps.kind[2].sizes);
    if (now.light.shadows && horizons != 0 && lighting.units >= static_cast<int>(horizon_unit) + horizons)
        light_bits |= light_shadows;
    lighting.follow(now.light, light_bits);
    make_program_of(now);
    make_sky_program();
    if (draws_surround(now)) prepare_surround();
    if (now.mode == Mode::residency) residency.follow(terrain);
}

void Renderer::set_heights(const HeightGrid& grid) {
    return state_->heights.set(grid, state_->terrain, state_->options.texture_side);
}

void Renderer::set_layers(const io::Materials& materials, std::span<const LayerRule> rules,
                          std::span<const std::string> names) {
    State& s = *state_;
    s.ground_layers.set({materials, rules, names}, s.options.material_bytes, s.maps.anisotropy, is_software());
    s.stats.texture_bytes = s.maps.bytes + s.ground_layers.bytes;
}

void Renderer::State::set_up(const Target& target, const DrawOptions& now) const {
    // All state we depend on: a user interface may have drawn in this context in between.
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer());
    glViewport(0, 0, static_cast<GLsizei>(target.width()), static_cast<GLsizei>(target.height()));
    for (const GLenum off : Switches{GL_BLEND, GL_SCISSOR_TEST, GL_STENCIL_TEST, GL_RASTERIZER_DISCARD}) glDisable(off);
    for (const GLenum on : Switches{GL_DEPTH_TEST, GL_CULL_FACE, GL_FRAMEBUFFER_SRGB, GL_MULTISAMPLE}) glEnable(on);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glCullFace(GL_BACK);
    glFrontFace(GL_CCW);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glDepthFunc(GL_GEQUAL);
    if (now.end_row > now.first_row) { // clears keep to it too
        glEnable(GL_SCISSOR_TEST);
        glScissor(0, static_cast<GLint>(now.first_row), static_cast<GLsizei>(target.width()),
                  static_cast<GLsizei>(now.end_row - now.first_row));
    }
    const float black[4] = {0, 0, 0, 1}, farthest = 0;
    glClearNamedFramebufferfv(target.framebuffer(), GL_COLOR, 0, black);
    glClearNamedFramebufferfv(target.framebuffer(), GL_DEPTH, 0, &farthest);
}

void Renderer::State::bind_maps(Mode mode) const {
    const unsigned first_unit[map_kinds] = {colour_unit, normal_unit, horizon_unit, splat_unit()};
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
        // The GPU may not have such units.
        if ((kind == 2 && (light_bits & light_shadows) == 0) || (kind == 3 && (light_bits & light_splat) == 0))
            continue;
        for (std::uint32_t i = 0; i < maps.kind[kind].sizes; ++i) {
            glBindTextureUnit(first_unit[kind] + i, maps.kind[kind].array[i].get());
            glBindSampler(first_unit[kind] + i, 0);
        }
    }
    if (mode != Mode::residency && mode != Mode::error) return; // they have no use for colours
    glBindTextureUnit(colour_unit, mode == Mode::residency ? residency.texture() : heights.texture());
    glBindSampler(colour_unit, 0);
}

void Renderer::State::draw_picture(const DrawData& data, unsigned primitive, const DrawOptions& now) {
    const unsigned numbers = ring.buffer();
    glBindBufferRange(GL_UNIFORM_BUFFER, frame_binding, numbers, static_cast<GLintptr>(data.frame.offset),
                      sizeof(FrameBlock));
    glBindBufferRange(GL_SHADER_STORAGE_BUFFER, tiles_binding, numbers, static_cast<GLintptr>(data.tiles.offset),
                      static_cast<GLsizeiptr>(data.tile_bytes));
    glVertexArrayVertexBuffer(terrain_array.get(), tile_slot, numbers, static_cast<GLintptr>(data.tiles.offset),
                              sizeof(TileBlock));
    if (data.command_count != 0) {
        glUseProgram(program_of(now).get());
        glBindVertexArray(terrain_array.get());
        glBindBuffer(GL_DRAW_INDIRECT_BUFFER, numbers);
        glMultiDrawElementsIndirect(primitive, GL_UNSIGNED_INT, reinterpret_cast<const void*>(data.commands.offset),
                                    static_cast<GLsizei>(data.command_count), 0);
    }
    if (now.sky && now.mode != Mode::distance) {
        glDepthMask(GL_FALSE);
        glUseProgram(sky[light_bits & light_air].get());
        glBindVertexArray(empty_array.get());
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    if (!draws_surround(now)) return;
    glUseProgram(surround.program[light_bits & light_air].get());
    surround.draw();
}

void Renderer::draw(const MeshView& mesh, const View& view, const DrawOptions& options, const Target& target) {
    state_->check(mesh, view);
    upload(mesh);
    return draw_uploaded(mesh, view, options, target);
}

void Renderer::draw(const CutMesh& mesh, const CutChanges& changes, const View& view, const DrawOptions& options,
                    const Target& target) {
    state_->check(mesh.mesh, view);
    upload(mesh, changes);
    return draw_uploaded(mesh.mesh, view, options, target);
}

void Renderer::draw_uploaded(const MeshView& mesh, const View& view, const DrawOptions& options, const Target& target) {
    State& s = *state_;
    s.check(mesh, view);
    if (s.uploaded != mesh.vertices.data()) fail("the mesh was not uploaded: call upload() after the update");
    s.prepare(options);
    s.make_arrays();
    s.upload_indices(mesh);
    s.drawn = true;
    const DrawData data = s.write_draw(mesh, view, options);
    s.set_up(target, options);
    s.bind_maps(options.mode);
    s.lighting.bind();
    if ((s.light_bits & light_layers) != 0) s.ground_layers.bind();
    s.draw_picture(data, mesh.topology == Topology::strip ? GL_TRIANGLE_STRIP : GL_TRIANGLES, options);

    glDisable(GL_SCISSOR_TEST);
    glDepthMask(GL_TRUE);
    glDisable(GL_CULL_FACE);
    glDepthFunc(GL_LESS);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glBindVertexArray(0);
    ++s.stats.frames;
}

void Renderer::rehearse(const DrawOptions& options, const Target& target) {
    State& s = *state_;
    const View view = make_view({0, s.header.max_m + 1, 0}, {1, -1, 1}, {0, 1, 0}, 1, target.width(), target.height(),
                                0.1, 10 * (s.diagonal_m + 1));
    const auto low = static_cast<float>(s.header.min_m);
    const MeshVertex corners[3] = {{0, 0, low}, {0, 1, low}, {1, 0, low}};
    const std::uint32_t indices[3] = {0, 1, 2};
    const TileRange range{.tile = 0, .first_index = 0, .index_count = 3, .triangles = 1};
    MeshView mesh;
    mesh.vertices = corners;
    mesh.indices = indices;
    mesh.tiles = {&range, 1};
    mesh.dirty_end = 3;
    if (s.options.vertices < 3 || s.options.indices < 3) return;
    const DrawStats before = s.stats;
    draw(mesh, view, options, target);
    if (s.options.morph) rehearse_scatter(s.scatter, s.ring, s.mesh);
    invalidate(); // what was drawn is nobody's mesh
    s.stats = before;
}

void Renderer::leave_context() {
    state_->terrain_array = VertexArray();
    state_->empty_array = VertexArray();
    state_->surround.leave_context();
    glFinish(); // what another context reads then is there
}

namespace {

void write_buffer(const Buffer& buffer, std::size_t first, std::size_t bytes, const void* data) {
    if (bytes != 0)
        glNamedBufferSubData(buffer.get(), static_cast<GLintptr>(first), static_cast<GLsizeiptr>(bytes), data);
}

} // namespace

// What is uploaded after a draw belongs to the next one: counters start anew and the ring moves on.
void Renderer::State::begin_frame() {
    if (!std::exchange(drawn, false)) return;
    stats.bytes_uploaded = stats.map_bytes_uploaded = 0;
    stats.upload_us = 0;
    ring.next();
}

// Whether this mesh must be uploaded whole.
bool Renderer::State::begin_upload(const MeshView& view) {
    const bool whole = uploaded != view.vertices.data() || uploaded_count != view.vertices.size();
    uploaded = view.vertices.data();
    uploaded_count = view.vertices.size();
    return whole;
}

void Renderer::State::upload_indices(const MeshView& view) {
    if (kept_indices != nullptr && kept_indices == view.indices.data()) return;
    const Stopwatch watch(stats.upload_us);
    kept_indices = nullptr;
    glInvalidateBufferData(mesh.indices.get()); // the last picture may still be reading the old ones
    write_buffer(mesh.indices, 0, view.indices.size_bytes(), view.indices.data());
    stats.bytes_uploaded += view.indices.size_bytes();
}

void Renderer::invalidate() {
    state_->uploaded = nullptr;
    state_->kept_indices = nullptr;
}

void Renderer::upload(const MeshView& mesh) {
    State& s = *state_;
    s.morph_frame = {};
    if (mesh.vertices.size() > s.options.vertices || mesh.dirty_end > mesh.vertices.size() ||
        mesh.dirty_begin > mesh.dirty_end)
        fail("the mesh has more vertex slots than RendererOptions::vertices, or its dirty range lies outside them");
    s.begin_frame();
    const Stopwatch watch(s.stats.upload_us);
    const bool whole = s.begin_upload(mesh);
    s.kept_indices = nullptr;
    const std::size_t begin = whole ? 0 : mesh.dirty_begin, end = whole ? mesh.vertices.size() : mesh.dirty_end;
    write_buffer(s.mesh.vertices, begin * sizeof(MeshVertex), (end - begin) * sizeof(MeshVertex),
                 mesh.vertices.data() + begin);
    s.stats.bytes_uploaded += (end - begin) * sizeof(MeshVertex);
}

void Renderer::upload(const CutMesh& cut, const CutChanges& changes) {
    State& s = *state_;
    const MeshView& mesh = cut.mesh;
    if (!s.options.morph) fail("a live cut needs RendererOptions::morph");
    if (mesh.vertices.size() > s.options.vertices || mesh.indices.size() > s.options.indices)
        fail("the cut has more slots than RendererOptions::vertices or ::indices: give them the cut's budget");
    if (!cut.morph.empty() && cut.morph.size() != mesh.vertices.size())
        fail("the cut's morph vertices are not one for one with its vertices");
    s.begin_frame();
    const Stopwatch watch(s.stats.upload_us);
    s.morph_frame = cut.frame;
    const bool other_indices = std::exchange(s.kept_indices, mesh.indices.data()) != mesh.indices.data();
    if (s.begin_upload(mesh) || other_indices) { // three calls; the driver keeps its own copy
        write_buffer(s.mesh.vertices, 0, mesh.vertices.size_bytes(), mesh.vertices.data());
        if (!cut.morph.empty()) write_buffer(s.mesh.morph, 0, cut.morph.size_bytes(), cut.morph.data());
        write_buffer(s.mesh.indices, 0, mesh.indices.size_bytes(), mesh.indices.data());
        s.stats.bytes_uploaded += mesh.vertices.size_bytes() + cut.morph.size_bytes() + mesh.indices.size_bytes();
    } else {
        s.stats.bytes_uploaded += scatter(s.scatter, s.ring, cut, changes, s.mesh);
    }
    s.stats.ring_waits = s.ring.waits();
}

void Renderer::upload(std::span<const MapCommand> commands) {
    State& s = *state_;
    if (commands.empty()) return;
    s.begin_frame();
    const Stopwatch watch(s.stats.upload_us);
    run_commands(commands, s.maps, s.ring, s.stats.map_bytes_uploaded);
    (void)note_map_commands(s.ground_maps, commands);
    s.stats.ring_waits = s.ring.waits();
}

void Renderer::show_maps(std::span<const TileMap> colour, std::span<const TileMap> normal,
                         std::span<const TileMap> horizon, std::span<const TileMap> splat) {
    Maps& maps = state_->maps;
    for (const auto& [tiles, kind] : {std::pair(colour, MapKind::colour), std::pair(normal, MapKind::normal),
                                      std::pair(horizon, MapKind::horizon), std::pair(splat, MapKind::splat)})
        gl::show_maps(tiles, kind, maps);
}

void Renderer::show_ground() {
    State& s = *state_;
    const MapArrays& normals = s.maps.kind[static_cast<std::uint32_t>(MapKind::normal)];
    if (!s.ground_memory) return; // there are no maps that follow
    const Stopwatch watch(s.stats.upload_us);
    GroundRect painted[64];
    for (bool lost = false;;) {
        const std::uint32_t count = take_paint_changes(s.terrain, s.paint_cursor, painted, lost);
        if (count == 0) break;
        paint_tiles(s.terrain, {painted, count}, s.maps, s.stats.map_bytes_uploaded);
    }
    GroundMapsReport made;
    if (!update_ground_maps(s.ground_maps, normals.tiles, made).ok()) return; // its terrain has been destroyed
    run_patches(ground_map_patches(s.ground_maps), s.maps, s.stats.map_bytes_uploaded);
    s.stats.ground_waiting = made.waiting;
}

} // namespace fjell::gl
