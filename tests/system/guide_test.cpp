// The guide's game (content/hosts/game) beside the library: its shader and its renderer do what ours do. So does the
// renderer of the host in C (content/hosts/c_loop).
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <epoxy/gl.h>

#include "hosts/game/draw.h"
#include "hosts/game/walk.h"
extern "C" {
#include "hosts/c_loop/draw.h"
}
#include "picture_scene.h"
#include "support/program.h"

using namespace pictures;

namespace {

const std::string shaders = FJELL_SOURCE_DIR "/content/hosts/game";

CutBudget capacities(const CutMesh& mesh) {
    return {.vertices = static_cast<std::uint32_t>(mesh.mesh.vertices.size()),
            .triangles = static_cast<std::uint32_t>(mesh.mesh.indices.size() / 3)};
}

// The positions that the guide's vertex shader gives all vertex slots, counted from the terrain's corner.
std::vector<float> shader_positions(const Terrain& terrain, const CutMesh& cut, const gl::Target& target) {
    const std::string text = fjell::test::slurp(shaders + "/terrain.vert");
    const char* const source = text.c_str();
    const GLuint program = glCreateProgram(), shader = glCreateShader(GL_VERTEX_SHADER);
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    glAttachShader(program, shader);
    const char* const captured = "from_eye_m";
    glTransformFeedbackVaryings(program, 1, &captured, GL_INTERLEAVED_ATTRIBS);
    glLinkProgram(program);
    GLint linked = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    REQUIRE(linked);
    glUseProgram(program);
    const auto at = [&](const char* name) { return glGetUniformLocation(program, name); };
    glUniform2f(at("spacing_m"), terrain.spacing_x_m(), terrain.spacing_z_m());
    float eye[max_cut_views][3], q[max_cut_views][2];
    for (std::uint32_t i = 0; i < cut.frame.views; ++i) {
        const MorphView& v = cut.frame.view[i];
        eye[i][0] = v.eye_x, eye[i][1] = v.eye_y, eye[i][2] = v.eye_z;
        q[i][0] = v.start_per_error, q[i][1] = v.full_per_error;
    }
    const auto views = static_cast<GLint>(cut.frame.views);
    glUniform1i(at("morph_views"), views);
    glUniform3fv(at("morph_eye_m"), views, eye[0]);
    glUniform2fv(at("morph_q"), views, q[0]);
    glUniform3f(at("morph_time_s"), cut.frame.now_s, cut.frame.morph_s, morph_clock_s);

    GLuint buffer[3], format = 0;
    glCreateBuffers(3, buffer);
    const auto bytes = [](const auto& items) { return static_cast<GLsizeiptr>(items.size_bytes()); };
    std::vector<float> positions(3 * cut.mesh.vertices.size());
    glNamedBufferStorage(buffer[0], bytes(cut.mesh.vertices), cut.mesh.vertices.data(), 0);
    glNamedBufferStorage(buffer[1], bytes(cut.morph), cut.morph.data(), 0);
    glNamedBufferStorage(buffer[2], bytes(std::span(positions)), nullptr, GL_MAP_READ_BIT);
    glCreateVertexArrays(1, &format);
    glBindVertexArray(format);
    glVertexArrayVertexBuffer(format, 0, buffer[0], 0, sizeof(MeshVertex));
    glVertexArrayVertexBuffer(format, 1, buffer[1], 0, sizeof(MorphVertex));
    glVertexArrayAttribIFormat(format, 0, 2, GL_INT, 0);
    glVertexArrayAttribFormat(format, 1, 1, GL_FLOAT, GL_FALSE, 8);
    glVertexArrayAttribFormat(format, 2, 4, GL_FLOAT, GL_FALSE, 0);
    for (const GLuint i : {0u, 1u, 2u}) {
        glVertexArrayAttribBinding(format, i, i == 2);
        glEnableVertexArrayAttrib(format, i);
    }
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, buffer[2]);
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer()); // nothing is drawn, but a context without one is refused
    glEnable(GL_RASTERIZER_DISCARD);
    glBeginTransformFeedback(GL_POINTS);
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(cut.mesh.vertices.size()));
    glEndTransformFeedback();
    glDisable(GL_RASTERIZER_DISCARD);
    glGetNamedBufferSubData(buffer[2], 0, bytes(std::span(positions)), positions.data());
    glDeleteBuffers(3, buffer);
    glDeleteVertexArrays(1, &format);
    glDeleteProgram(program);
    glDeleteShader(shader);
    return positions;
}

std::vector<std::uint32_t> used_slots(const MeshView& mesh) {
    std::vector<std::uint32_t> slots;
    for (const TileRange& range : mesh.tiles)
        slots.insert(slots.end(), mesh.indices.begin() + range.first_index,
                     mesh.indices.begin() + range.first_index + range.index_count);
    return slots;
}

// Into the scene's target, as the game clears it.
std::vector<float> drawn(const game::Drawer& drawer, Scene& scene, const CutMesh& cut, std::span<const View> views) {
    glBindFramebuffer(GL_FRAMEBUFFER, scene.target->framebuffer());
    glClearDepth(0);
    glDepthMask(GL_TRUE);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    GLint left = 0;
    for (const View& view : views) {
        glViewport(left, 0, static_cast<GLsizei>(view.width_px), static_cast<GLsizei>(view.height_px));
        drawer.draw(scene.loaded.terrain, cut, view, {}, {});
        left += static_cast<GLint>(view.width_px);
    }
    std::vector<float> depth;
    scene.target->read_depth(depth);
    const std::vector<std::string>& messages = context().log().messages;
    INFO((messages.empty() ? std::string() : messages.front()));
    CHECK(context().log().errors == 0);
    return depth;
}

std::size_t apart(const std::vector<float>& a, const std::vector<float>& b) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < a.size(); ++i) n += std::abs(a[i] - b[i]) > 1e-4f * std::max(a[i], b[i]);
    return n;
}

} // namespace

TEST_CASE("the guide's shader gives every vertex the height of morphed_height_m()", "[picture]") {
    Scene scene(mountains(513), 6);
    scene.make_cut();
    const Terrain& terrain = scene.loaded.terrain;
    CutMesh cut = scene.half_way(scene.camera(0.5, 0.9, 200, 0, -10), scene.camera(0.5, 0.88, 210, 5, -10), 3);
    // The same once more with the cut's clock about to start again: some were activated before, and it is after.
    std::vector<MorphVertex> later(cut.morph.begin(), cut.morph.end());
    const auto shifted = [](float then_s) { return std::fmod(then_s + 1023.625f, morph_clock_s); };
    for (MorphVertex& m : later)
        if (m.activated_s != activated_long_ago_s) m.activated_s = shifted(m.activated_s);
    CutMesh wrapped = cut;
    wrapped.morph = later;
    wrapped.frame.now_s = shifted(cut.frame.now_s);
    // Some twelve roundings of numbers up to the diagonal on the way to a share of the band, whose width is error_m
    // times start_per_error - full_per_error; the height moves by at most error_m over it. Then a few of the height
    // itself.
    const MorphView& v = cut.frame.view[0];
    const double diagonal_m = std::hypot(terrain.extent_x_m(), terrain.extent_z_m());
    const double bound_m = 0x1p-24 * (12 * 2 * diagonal_m / double{v.start_per_error - v.full_per_error} + 6 * 3000);
    for (const CutMesh& mesh : {cut, wrapped}) {
        const std::vector<float> positions = shader_positions(terrain, mesh, *scene.target);
        double largest_m = 0;
        std::size_t between = 0, before = 0;
        for (const std::uint32_t slot : used_slots(mesh.mesh)) {
            const MeshVertex& vertex = mesh.mesh.vertices[slot];
            const float expected = morphed_height_m(terrain, vertex, mesh.morph[slot], mesh.frame);
            largest_m = std::max(largest_m, std::abs(double{positions[3 * slot + 1]} - double{expected}));
            between += std::abs(expected - vertex.height_m) > 0.1f &&
                       std::abs(expected - mesh.morph[slot].morph_from_m) > 0.1f;
            before += mesh.morph[slot].activated_s > mesh.frame.now_s;
        }
        INFO("largest " << largest_m << " m, bound " << bound_m << " m");
        CHECK(largest_m <= bound_m);
        CHECK(between > 100); // or nothing was compared
        CHECK((before > 100) == (mesh.morph.data() == later.data()));
    }
}

TEST_CASE("the guide's renderer draws what ours draws, from uploads of what changed", "[picture]") {
    Scene scene(mountains(513), 6);
    scene.make_cut();
    game::Drawer drawer;
    REQUIRE(drawer.create(shaders, capacities(cut_mesh(scene.cut)), {}, {}) == "");
    const View from = scene.camera(0.5, 0.9, 200, 0, -10), to = scene.camera(0.5, 0.88, 210, 5, -10);
    std::vector<std::vector<float>> pictures;
    for (const bool back : {false, true, false}) {
        const CutMesh cut = back ? scene.half_way(to, from, 3) : scene.half_way(from, to, 3);
        const View& view = back ? from : to;
        const CutChanges changes = cut_take_changes(scene.cut); // once, for both
        drawer.upload(cut, changes);
        scene.renderer->draw(cut, changes, view, {.light = scene.light}, *scene.target);
        std::vector<float> ours;
        scene.target->read_depth(ours);
        pictures.push_back(drawn(drawer, scene, cut, {&view, 1}));
        CHECK(apart(pictures.back(), ours) < ours.size() / 10'000); // silhouettes, where a rounding shows

        const View strips[] = {game::strip(view, 0, 2), game::strip(view, 1, 2)};
        CHECK(apart(drawn(drawer, scene, cut, strips), ours) < ours.size() / 10'000);
    }
    CHECK(apart(pictures[0], pictures[1]) > pictures[0].size() / 100); // or the measure is blind
}

TEST_CASE("the C host's renderer draws what ours draws, from uploads of what changed and from any origin",
          "[picture]") {
    Scene scene(mountains(513), 6);
    scene.make_cut();
    const auto terrain = std::bit_cast<FjellTerrain>(scene.loaded.terrain);
    const auto cut = std::bit_cast<FjellLiveCut>(scene.cut);
    FjellCutBudget budget = fjell_cut_budget_default();
    budget.vertices = capacities(cut_mesh(scene.cut)).vertices;
    budget.triangles = capacities(cut_mesh(scene.cut)).triangles;
    Renderer c_host;
    const char* const error = renderer_create(&c_host, &budget);
    REQUIRE(error == nullptr);
    std::vector<std::vector<float>> pictures;
    std::size_t first_upload = 0;
    for (const double south : {0.9, 0.899, 0.7}) {
        const View view = scene.camera(0.5, south, 200, 5, -10);
        scene.follow(view, 3);
        const FjellCutChanges taken = fjell_cut_take_changes(cut); // once, for both
        const FjellCutMesh mesh = fjell_cut_mesh(cut);
        const std::size_t before = c_host.uploaded_bytes;
        renderer_upload(&c_host, &mesh, &taken);
        if (first_upload == 0) first_upload = c_host.uploaded_bytes;
        if (south == 0.899) CHECK(c_host.uploaded_bytes - before < first_upload / 4);
        const CutChanges changes{{taken.vertex_bits, taken.vertex_bit_words},
                                 {taken.triangle_bits, taken.triangle_bit_words},
                                 {taken.vertex_words, taken.vertex_word_count},
                                 {taken.triangle_words, taken.triangle_word_count}};
        scene.renderer->draw(cut_mesh(scene.cut), changes, view, {}, *scene.target);
        std::vector<float> ours, theirs;
        scene.target->read_depth(ours);
        FjellView seen = fjell_view_default();
        std::memcpy(&seen.eye_m, &view, sizeof view);
        for (const FjellSampleIndex origin : {FjellSampleIndex{250, 460}, FjellSampleIndex{0, 0}}) {
            glBindFramebuffer(GL_FRAMEBUFFER, scene.target->framebuffer());
            glViewport(0, 0, static_cast<GLsizei>(width_px), static_cast<GLsizei>(height_px));
            glDepthMask(GL_TRUE);
            glClearDepth(0);
            glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
            renderer_draw(&c_host, terrain, &mesh, &seen, origin);
            scene.target->read_depth(theirs);
            CHECK(apart(theirs, ours) < ours.size() / 5000); // silhouettes, where a rounding shows
        }
        pictures.push_back(theirs);
    }
    CHECK(apart(pictures[0], pictures[2]) > pictures[0].size() / 100); // or the measure is blind
    renderer_destroy(&c_host);
    CHECK(context().log().errors == 0);
}
