#include "draw.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <iterator>

#include <fjell/glm.h>
#include <glm/gtc/type_ptr.hpp>

namespace game {

namespace {

std::string attach(GLuint program, GLenum stage, const std::string& path) {
    std::ifstream file(path);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const char* const source = text.c_str();
    const GLuint shader = glCreateShader(stage);
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    GLint good = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
    char log[1000] = "";
    if (!good) glGetShaderInfoLog(shader, sizeof log, nullptr, log);
    glAttachShader(program, shader);
    return good ? "" : path + ": " + log;
}

} // namespace

std::string Drawer::create(const std::string& shaders, const fjell::CutBudget& budget, const fjell::MapLayers& colour,
                           const fjell::MapLayers& normal) {
    program_ = glCreateProgram();
    if (std::string error = attach(program_, GL_VERTEX_SHADER, shaders + "/terrain.vert"); !error.empty()) return error;
    if (std::string error = attach(program_, GL_FRAGMENT_SHADER, shaders + "/terrain.frag"); !error.empty())
        return error;
    glLinkProgram(program_);
    GLint good = 0;
    glGetProgramiv(program_, GL_LINK_STATUS, &good);
    if (!good) return shaders + ": the shaders do not link";

    const auto make_buffer = [](GLuint& buffer, std::size_t bytes) {
        glCreateBuffers(1, &buffer);
        glNamedBufferStorage(buffer, GLsizeiptr(bytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
    };
    make_buffer(vertices_, budget.vertices * sizeof(fjell::MeshVertex));
    make_buffer(morphs_, budget.vertices * sizeof(fjell::MorphVertex));
    make_buffer(indices_, std::size_t{budget.triangles} * 3 * sizeof(std::uint32_t));

    glCreateVertexArrays(1, &format_);
    glVertexArrayElementBuffer(format_, indices_);
    glVertexArrayVertexBuffer(format_, 0, vertices_, 0, sizeof(fjell::MeshVertex));
    glVertexArrayVertexBuffer(format_, 1, morphs_, 0, sizeof(fjell::MorphVertex));
    glVertexArrayAttribIFormat(format_, 0, 2, GL_INT, offsetof(fjell::MeshVertex, column)); // integers: I
    glVertexArrayAttribFormat(format_, 1, 1, GL_FLOAT, GL_FALSE, offsetof(fjell::MeshVertex, height_m));
    glVertexArrayAttribFormat(format_, 2, 4, GL_FLOAT, GL_FALSE, 0);
    const GLuint source[] = {0, 0, 1};
    for (GLuint i = 0; i < 3; ++i) {
        glVertexArrayAttribBinding(format_, i, source[i]);
        glEnableVertexArrayAttrib(format_, i);
    }
    if (colour.top_log2 != 0) maps_[0].create(fjell::MapKind::colour, colour);
    if (normal.top_log2 != 0) maps_[1].create(fjell::MapKind::normal, normal);
    return {};
}

void Drawer::upload(const fjell::CutMesh& cut, const fjell::CutChanges& changes) {
    const auto send = [](GLuint buffer, const auto& items, std::size_t first, std::size_t count) {
        glNamedBufferSubData(buffer, GLintptr(first * sizeof items[0]), GLsizeiptr(count * sizeof items[0]),
                             &items[first]);
    };
    fjell::for_each_run(changes.vertex_bits, changes.vertex_words, [&](std::uint32_t first, std::uint32_t count) {
        send(vertices_, cut.mesh.vertices, first, count);
        send(morphs_, cut.morph, first, count);
    });
    fjell::for_each_run(changes.triangle_bits, changes.triangle_words, [&](std::uint32_t first, std::uint32_t count) {
        send(indices_, cut.mesh.indices, std::size_t{3} * first, std::size_t{3} * count);
    });
}

void Drawer::upload(std::span<const fjell::MapCommand> commands) {
    for (const fjell::MapCommand& command : commands) maps_[std::size_t(command.map)].carry_out(command);
}

void Drawer::upload(std::span<const fjell::MapPatch> patches) {
    for (const fjell::MapPatch& patch : patches) maps_[std::size_t(patch.map)].put(patch);
}

void Drawer::set_view(const fjell::Terrain& terrain, const fjell::View& view) const {
    const double dx = terrain.header().spacing_m[0], dz = terrain.header().spacing_m[1];
    const double column = std::floor(view.eye_m.x / dx), row = std::floor(view.eye_m.z / dz);
    const float high = float(view.eye_m.y);
    glUniform2f(at("spacing_m"), float(dx), float(dz));
    glUniform2i(at("eye_cell"), int(column), int(row));
    glUniform2f(at("eye_in_cell_m"), float(view.eye_m.x - column * dx), float(view.eye_m.z - row * dz));
    glUniform2f(at("eye_height_m"), high, float(view.eye_m.y - double(high)));
    const glm::dmat4 rotation{glm::dmat3(fjell::view_matrix(view))}; // positions count from the eye already
    const glm::mat4 clip_from_eye{fjell::reversed_projection(view) * rotation};
    glUniformMatrix4fv(at("clip_from_eye"), 1, GL_FALSE, glm::value_ptr(clip_from_eye));
}

void Drawer::set_morph(const fjell::MorphFrame& frame, const fjell::View& view) const {
    float eye[fjell::max_cut_views][3], q[fjell::max_cut_views][2];
    const std::uint32_t views = frame.morph == fjell::Morph::none ? 0 : frame.views;
    for (std::uint32_t i = 0; i < views; ++i) { // every view that refines counts, whichever is drawn
        const fjell::MorphView& m = frame.view[i];
        eye[i][0] = float(m.eye_x - view.eye_m.x);
        eye[i][1] = float(m.eye_y - view.eye_m.y);
        eye[i][2] = float(m.eye_z - view.eye_m.z);
        q[i][0] = m.start_per_error, q[i][1] = m.full_per_error;
    }
    glUniform1i(at("morph_views"), GLint(views));
    glUniform3fv(at("morph_eye_m"), GLsizei(views), eye[0]);
    glUniform2fv(at("morph_q"), GLsizei(views), q[0]);
    glUniform3f(at("morph_time_s"), frame.now_s, frame.morph_s, fjell::morph_clock_s);
}

void Drawer::set_tile(const fjell::Terrain& terrain, std::uint32_t tile, std::span<const fjell::TileMap> colour,
                      std::span<const fjell::TileMap> normal) const {
    const float cells = float(1u << terrain.header().tile_log2);
    const fjell::SampleIndex place =
        terrain.tile_place(tile); // where tiles are missing it does not follow from the number
    glUniform2f(at("tile_first"), float(place.column) * cells, float(place.row) * cells);
    glUniform1f(at("tile_cells"), cells);
    const std::span<const fjell::TileMap> tiles[] = {colour, normal};
    GLint layer[2] = {-1, -1};
    float texels[2] = {1, 1}, missing_mips[2] = {}, grid[2][9] = {};
    for (GLuint kind = 0; kind < 2; ++kind) {
        if (tiles[kind].empty() || tiles[kind][tile].side_log2 == 0) continue;
        const fjell::TileMap& map = tiles[kind][tile];
        layer[kind] = GLint(map.layer);
        texels[kind] = float(1u << maps_[kind].top_log2());
        missing_mips[kind] = float(maps_[kind].top_log2() - map.side_log2);
        (void)fjell::min_lod_grid(tiles[kind], terrain, tile, grid[kind]);
        glBindTextureUnit(kind, maps_[kind].array(map.side_log2));
    }
    glUniform1iv(at("layer"), 2, layer);
    glUniform1fv(at("texels"), 2, texels);
    glUniform1fv(at("missing_mips"), 2, missing_mips);
    glUniform1fv(at("min_lod"), 18, grid[0]);
}

void Drawer::draw(const fjell::Terrain& terrain, const fjell::CutMesh& cut, const fjell::View& view,
                  std::span<const fjell::TileMap> colour, std::span<const fjell::TileMap> normal) const {
    glUseProgram(program_);
    glBindVertexArray(format_);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);                      // reversed: 1 at the near plane, 0 far away,
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE); // and floats are finest where depths crowd
    const GLint units[] = {0, 1};
    glUniform1iv(at("maps"), 2, units);
    set_view(terrain, view);
    set_morph(cut.frame, view);
    for (const fjell::TileRange& range : cut.mesh.tiles) {
        set_tile(terrain, range.tile, colour, normal);
        glDrawElements(GL_TRIANGLES, GLsizei(range.index_count), GL_UNSIGNED_INT,
                       reinterpret_cast<const void*>(std::size_t{range.first_index} * sizeof(std::uint32_t)));
    }
}

void Maps::create(fjell::MapKind kind, const fjell::MapLayers& sizes) {
    const bool colour = kind == fjell::MapKind::colour;
    format_ = colour ? GL_COMPRESSED_SRGB_S3TC_DXT1_EXT : GL_COMPRESSED_RG_RGTC2;
    block_bytes_ = colour ? fjell::colour_block_bytes : fjell::normal_block_bytes;
    sizes_ = sizes;
    for (std::uint32_t log2 = 0; log2 <= fjell::max_texture_log2; ++log2) {
        if (sizes.layers[log2] == 0) continue;
        GLuint& array = array_[log2];
        glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &array);
        glTextureStorage3D(array, GLsizei(fjell::mip_count(log2)), format_, 1 << log2, 1 << log2,
                           GLsizei(sizes.layers[log2]));
        glTextureParameteri(array, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
        glTextureParameteri(array, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glTextureParameteri(array, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
}

void Maps::carry_out(const fjell::MapCommand& command) {
    const GLuint to = array_[command.side_log2];
    if (command.from_log2 != 0) { // the mips that both arrays have, from the smaller one's finest on
        const std::uint32_t common = std::min(command.from_log2, command.side_log2);
        for (std::uint32_t mip = 0; mip < fjell::mip_count(common); ++mip)
            glCopyImageSubData(array_[command.from_log2], GL_TEXTURE_2D_ARRAY, GLint(command.from_log2 - common + mip),
                               0, 0, GLint(command.from_layer), to, GL_TEXTURE_2D_ARRAY,
                               GLint(command.side_log2 - common + mip), 0, 0, GLint(command.layer), 1 << (common - mip),
                               1 << (common - mip), 1);
    }
    const std::byte* blocks = command.blocks.data(); // then new ones, the largest first
    for (std::uint32_t mip = 0; mip < command.upload_mips; ++mip) {
        const std::uint32_t side = 1u << (command.side_log2 - mip);
        const std::size_t bytes = fjell::blocks_of(side) * block_bytes_;
        glCompressedTextureSubImage3D(to, GLint(mip), 0, 0, GLint(command.layer), GLsizei(side), GLsizei(side), 1,
                                      format_, GLsizei(bytes), blocks);
        blocks += bytes;
    }
}

void Maps::put(const fjell::MapPatch& patch) {
    glCompressedTextureSubImage3D(array_[patch.side_log2], patch.mip, GLint(patch.x), GLint(patch.y),
                                  GLint(patch.layer), GLsizei(patch.columns), GLsizei(patch.rows), 1, format_,
                                  GLsizei(patch.blocks.size()), patch.blocks.data());
}

} // namespace game
