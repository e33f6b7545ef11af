#include "bench/gpu_patches.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include <epoxy/gl.h>
#include <glm/gtc/type_ptr.hpp>
#include <nlohmann/json.hpp>

#include "bench/gpu_times.h"
#include "fjell/cut.h"
#include "fjell/gl/image.h"
#include "fjell/gl/target.h"
#include "fjell/glm.h"
#include "fjell/io/failure.h"
#include "fjell/io/load.h"
#include "fjell/measure.h"
#include "gl/objects.h"
#include "rivals/cdlod.h"
#include "rivals/look.h"
#include "support/times.h"

namespace fjell::bench {

namespace {

using nlohmann::json;
using rivals::Cdlod;
using test::rank;

constexpr double off_screen = 8; // what nobody sees costs the cut no slots here

constexpr const char* place_source = R"(
uniform mat4 clip_from_eye; // positions count from the eye
uniform ivec2 eye_cell;
uniform vec2 spacing_m, eye_in_cell_m;
uniform float eye_height_m;
out vec3 from_eye_m;
vec3 place(vec2 cell, float height_m) { // cell: of the eye's
    vec2 across = cell * spacing_m - eye_in_cell_m;
    return vec3(across.x, height_m - eye_height_m, across.y);
}
void put(vec3 at) {
    from_eye_m = at;
    gl_Position = clip_from_eye * vec4(at, 1);
}
)";
constexpr const char* mesh_source = R"(
layout(location = 0) in ivec2 cell;
layout(location = 1) in float height_m;
void main() { put(place(vec2(cell - eye_cell), height_m)); }
)";
constexpr const char* patch_source = R"(
layout(location = 0) in ivec2 corner;
layout(location = 1) in ivec3 patch_at; // column, row, cells a square
layout(location = 2) in vec2 morph_m;   // from, to
layout(binding = 0) uniform sampler2D heights_m;
void main() {
    ivec2 cell = patch_at.xy + corner * patch_at.z;
    vec3 at = place(vec2(cell - eye_cell), texelFetch(heights_m, cell, 0).r);
    float morphed = clamp((length(at) - morph_m.x) / (morph_m.y - morph_m.x), 0.0, 1.0);
    vec2 slid = vec2(cell) - morphed * float(patch_at.z) * vec2(corner & 1);
    float height_m = textureLod(heights_m, (slid + 0.5) / vec2(textureSize(heights_m, 0)), 0.0).r;
    put(place(slid - vec2(eye_cell), height_m));
}
)";
constexpr const char* light_source = R"(
in vec3 from_eye_m;
out vec4 colour;
void main() {
    vec3 up = normalize(cross(dFdx(from_eye_m), dFdy(from_eye_m)));
    float lit = max(dot(up, normalize(vec3(-0.6, 0.6, -0.5))), 0.0);
    float air = exp(-length(from_eye_m) / 90000.0);
    colour = vec4(mix(vec3(0.5, 0.6, 0.75), vec3(0.4, 0.37, 0.3) * (0.15 + lit), air), 1);
}
)";

gl::Buffer make_buffer(std::size_t bytes, const void* data) {
    unsigned name = 0;
    glCreateBuffers(1, &name);
    glNamedBufferStorage(name, static_cast<GLsizeiptr>(std::max<std::size_t>(bytes, 1)), data, 0);
    return gl::Buffer(name);
}
gl::VertexArray make_array() {
    unsigned name = 0;
    glCreateVertexArrays(1, &name);
    return gl::VertexArray(name);
}
void attribute(const gl::VertexArray& array, unsigned at, unsigned slot) {
    glEnableVertexArrayAttrib(array.get(), at);
    glVertexArrayAttribBinding(array.get(), at, slot);
}
void check(const Status& status) {
    if (!status.ok()) throw io::Failure(1, std::string(status.field) + ": " + message(status.code));
}

class Canvas {
public:
    Canvas(const PatchPlan& plan, const View& view, const Terrain& terrain)
        : plan_(plan), view_(view), spacing_m_{terrain.header().spacing_m[0], terrain.header().spacing_m[1]},
          target_(gl::Target::create({plan.width, plan.height, 1})) {}
    [[nodiscard]] gl::Program program(const char* name, const char* vertex) const {
        return gl::make_program({name, "", std::string(place_source) + vertex, "", light_source});
    }
    // Into `row`: what one draw of that costs, and its picture.
    template <typename Draw>
    void measure(const gl::Program& program, const Draw& draw, const std::string& picture, json& row) const {
        const GpuTimer timer;
        std::vector<double> gpu_us, frame_ms;
        for (std::size_t i = 0; i <= plan_.repeats; ++i) {
            set_up(program);
            glFinish();
            (void)take_calls();
            const auto start = test::Clock::now();
            timer.begin();
            draw();
            timer.end();
            glFinish();
            if (i == 0) continue; // the driver compiles
            frame_ms.push_back(test::us_since(start) * 1e-3);
            gpu_us.push_back(timer.us());
        }
        row["draws"] = take_calls().draws;
        row["frame_ms"] = rank(frame_ms, 0.5);
        row["draw_us"] = plan_.timers ? json(rank(gpu_us, 0.5)) : json();
        gl::Image image;
        target_->read_colour(image);
        gl::write_png(image, plan_.out + "/" + picture);
        row["picture"] = picture;
    }

private:
    void set_up(const gl::Program& program) const {
        glBindFramebuffer(GL_FRAMEBUFFER, target_->framebuffer());
        glViewport(0, 0, static_cast<GLsizei>(plan_.width), static_cast<GLsizei>(plan_.height));
        for (const GLenum on : {GL_DEPTH_TEST, GL_CULL_FACE, GL_FRAMEBUFFER_SRGB}) glEnable(on);
        glDepthMask(GL_TRUE);
        glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
        glDepthFunc(GL_GEQUAL);
        const float sky[4] = {0.5f, 0.6f, 0.75f, 1}, farthest = 0;
        glClearNamedFramebufferfv(target_->framebuffer(), GL_COLOR, 0, sky);
        glClearNamedFramebufferfv(target_->framebuffer(), GL_DEPTH, 0, &farthest);
        const unsigned name = program.get();
        glUseProgram(name);
        const auto at = [&](const char* uniform) { return glGetUniformLocation(name, uniform); };
        const glm::mat4 clip{reversed_projection(view_) * glm::dmat4{glm::dmat3(view_matrix(view_))}};
        glUniformMatrix4fv(at("clip_from_eye"), 1, GL_FALSE, glm::value_ptr(clip));
        const double x = view_.eye_m.x, z = view_.eye_m.z;
        const double column = std::floor(x / spacing_m_[0]), row = std::floor(z / spacing_m_[1]);
        glUniform2i(at("eye_cell"), static_cast<int>(column), static_cast<int>(row));
        glUniform2f(at("spacing_m"), static_cast<float>(spacing_m_[0]), static_cast<float>(spacing_m_[1]));
        glUniform2f(at("eye_in_cell_m"), static_cast<float>(x - column * spacing_m_[0]),
                    static_cast<float>(z - row * spacing_m_[1]));
        glUniform1f(at("eye_height_m"), static_cast<float>(view_.eye_m.y));
    }
    const PatchPlan& plan_;
    const View& view_;
    double spacing_m_[2];
    std::unique_ptr<gl::Target> target_;
};

// The threshold at which about so many triangles are drawn: fewer the larger it is.
template <typename Count>
double threshold_for(double triangles, const Count& count) {
    double low = 0.005, high = 500;
    for (int i = 0; i < 14; ++i) {
        const double middle = std::sqrt(low * high);
        (count(middle) > triangles ? low : high) = middle;
    }
    return high;
}

// The live cut: rebuilt for each threshold, drawn as the host's own buffers.
class Cut {
public:
    Cut(const Terrain& terrain, const PatchPlan& plan, const View& view, const Canvas& canvas)
        : terrain_(terrain), view_(view), canvas_(canvas), program_(canvas.program("a mesh", mesh_source)) {
        std::uint32_t most = 1u << 16;
        for (const std::uint32_t triangles : plan.triangles) most = std::max(most, triangles);
        const CutBudget budget{most + most / 4, 3 * most, 512, 1};
        const std::size_t bytes = cut_bytes(terrain, budget);
        memory_ = io::allocate(bytes);
        check(create_cut(terrain, budget, {memory_.get(), bytes}, cut_));
    }
    std::uint32_t triangles(double error_px) {
        CutSettings settings;
        settings.max_error_px = error_px_ = error_px;
        settings.offscreen_factor = off_screen;
        const auto start = test::Clock::now();
        check(rebuild_cut(cut_, {&view_, 1}, settings, report_));
        build_us_ = test::us_since(start);
        (void)cut_take_changes(cut_);
        return report_.triangles_drawn;
    }
    [[nodiscard]] double true_error_px() const {
        const Frustum frustum = make_frustum(view_);
        return measure_error(terrain_, cut_mesh(cut_).mesh, view_, &frustum).max_px;
    }
    // As it stands.
    [[nodiscard]] json draw(const std::string& asked, const std::string& picture) const {
        const MeshView mesh = cut_mesh(cut_).mesh;
        std::vector<std::uint32_t> commands;
        std::size_t indices = 0;
        for (const TileRange& range : mesh.tiles) {
            commands.insert(commands.end(), {range.index_count, 1, range.first_index, 0, 0});
            indices += range.index_count;
        }
        const gl::Buffer vertices = make_buffer(mesh.vertices.size_bytes(), mesh.vertices.data()),
                         index = make_buffer(mesh.indices.size_bytes(), mesh.indices.data()),
                         indirect = make_buffer(4 * commands.size(), commands.data());
        const gl::VertexArray array = make_array();
        glVertexArrayVertexBuffer(array.get(), 0, vertices.get(), 0, sizeof(MeshVertex));
        glVertexArrayElementBuffer(array.get(), index.get());
        glVertexArrayAttribIFormat(array.get(), 0, 2, GL_INT, offsetof(MeshVertex, column));
        glVertexArrayAttribFormat(array.get(), 1, 1, GL_FLOAT, GL_FALSE, offsetof(MeshVertex, height_m));
        attribute(array, 0, 0);
        attribute(array, 1, 0);
        json row{{"method", "cut"},
                 {"asked", asked},
                 {"error_px", error_px_},
                 {"true_error_px", true_error_px()},
                 {"triangles", report_.triangles_drawn},
                 {"mesh_bytes", sizeof(MeshVertex) * report_.vertices + 4 * indices},
                 {"height_bytes", 0},
                 {"select_us", build_us_}};
        canvas_.measure(
            program_,
            [&] {
                glBindVertexArray(array.get());
                glBindBuffer(GL_DRAW_INDIRECT_BUFFER, indirect.get());
                glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr,
                                            static_cast<GLsizei>(mesh.tiles.size()), 0);
            },
            picture, row);
        return row;
    }

private:
    const Terrain& terrain_;
    const View& view_;
    const Canvas& canvas_;
    gl::Program program_;
    io::AlignedMemory memory_;
    LiveCut cut_;
    CutReport report_;
    double error_px_ = 0, build_us_ = 0;
};

// CDLOD: a grid, an instance of it a patch, and the heights in a texture.
class Patches {
public:
    Patches(const Terrain& terrain, const View& view, const Canvas& canvas)
        : ground_(rivals::ground_of(terrain)), cdlod_(ground_), view_(view), canvas_(canvas),
          program_(canvas.program("patches", patch_source)) {
        unsigned name = 0;
        glCreateTextures(GL_TEXTURE_2D, 1, &name);
        heights_ = gl::Texture(name);
        glTextureStorage2D(name, 1, GL_R32F, ground_.side + 1, ground_.side + 1);
        glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
        glTextureSubImage2D(name, 0, 0, 0, ground_.side + 1, ground_.side + 1, GL_RED, GL_FLOAT,
                            ground_.height_m.data());
        for (const GLenum side : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
            glTextureParameteri(name, side, GL_CLAMP_TO_EDGE);
        glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    }
    std::uint32_t triangles(double error_px) {
        error_px_ = error_px;
        const auto start = test::Clock::now();
        triangles_ = cdlod_.refine(view_, error_px, rivals::unlimited_operations).triangles;
        select_us_ = test::us_since(start);
        return triangles_;
    }
    double true_error_px() {
        cdlod_.faces(faces_);
        return rivals::look_at(ground_, faces_, view_).error_px;
    }
    [[nodiscard]] json draw(const std::string& asked, const std::string& picture) {
        (void)triangles(error_px_);
        const double true_px = true_error_px();
        std::vector<Cdlod::Drawn> all;
        cdlod_.drawn(all);
        std::map<std::int32_t, std::vector<Cdlod::Drawn>> by_squares; // whole patches, and quarters of them
        for (Cdlod::Drawn& patch : all) {
            if (std::isinf(patch.morph_to_m)) patch.morph_from_m = 1e30f, patch.morph_to_m = 2e30f; // shaders divide
            by_squares[patch.squares].push_back(patch);
        }
        std::vector<Grid> grids;
        std::size_t bytes = 0;
        for (const auto& [squares, patches] : by_squares) {
            grids.push_back(make_grid(squares, patches));
            bytes += grids.back().bytes;
        }
        json row{{"method", "cdlod"},
                 {"asked", asked},
                 {"error_px", error_px_},
                 {"true_error_px", true_px},
                 {"triangles", triangles_},
                 {"mesh_bytes", bytes},
                 {"height_bytes", 4 * ground_.height_m.size()},
                 {"select_us", select_us_}};
        canvas_.measure(
            program_,
            [&] {
                glBindTextureUnit(0, heights_.get());
                for (const Grid& grid : grids) {
                    glBindVertexArray(grid.array.get());
                    glDrawElementsInstanced(GL_TRIANGLES, grid.indices, GL_UNSIGNED_SHORT, nullptr, grid.instances);
                }
            },
            picture, row);
        return row;
    }

private:
    struct Grid {
        gl::Buffer corners, index, instance;
        gl::VertexArray array;
        GLsizei indices = 0, instances = 0;
        std::size_t bytes = 0;
    };
    static Grid make_grid(std::int32_t squares, const std::vector<Cdlod::Drawn>& patches) {
        std::vector<std::uint8_t> corners;
        std::vector<std::uint16_t> index;
        for (std::int32_t y = 0; y <= squares; ++y)
            for (std::int32_t x = 0; x <= squares; ++x)
                corners.insert(corners.end(), {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), 0, 0});
        const auto at = [&](std::int32_t x, std::int32_t y) {
            return static_cast<std::uint16_t>(y * (squares + 1) + x);
        };
        for (std::int32_t y = 0; y < squares; ++y)
            for (std::int32_t x = 0; x < squares; ++x)
                index.insert(index.end(),
                             {at(x, y), at(x, y + 1), at(x + 1, y + 1), at(x, y), at(x + 1, y + 1), at(x + 1, y)});
        Grid grid;
        grid.corners = make_buffer(corners.size(), corners.data());
        grid.index = make_buffer(2 * index.size(), index.data());
        grid.instance = make_buffer(sizeof(Cdlod::Drawn) * patches.size(), patches.data());
        grid.array = make_array();
        const unsigned array = grid.array.get();
        glVertexArrayVertexBuffer(array, 0, grid.corners.get(), 0, 4);
        glVertexArrayVertexBuffer(array, 1, grid.instance.get(), 0, sizeof(Cdlod::Drawn));
        glVertexArrayBindingDivisor(array, 1, 1);
        glVertexArrayElementBuffer(array, grid.index.get());
        glVertexArrayAttribIFormat(array, 0, 2, GL_UNSIGNED_BYTE, 0);
        glVertexArrayAttribIFormat(array, 1, 3, GL_INT, offsetof(Cdlod::Drawn, column));
        glVertexArrayAttribFormat(array, 2, 2, GL_FLOAT, GL_FALSE, offsetof(Cdlod::Drawn, morph_from_m));
        attribute(grid.array, 0, 0);
        attribute(grid.array, 1, 1);
        attribute(grid.array, 2, 1);
        grid.indices = static_cast<GLsizei>(index.size());
        grid.instances = static_cast<GLsizei>(patches.size());
        grid.bytes = corners.size() + 2 * index.size() + sizeof(Cdlod::Drawn) * patches.size();
        return grid;
    }
    rivals::Ground ground_;
    Cdlod cdlod_;
    const View& view_;
    const Canvas& canvas_;
    gl::Program program_;
    gl::Texture heights_;
    std::vector<rivals::Face> faces_;
    std::uint32_t triangles_ = 0;
    double error_px_ = 0, select_us_ = 0;
};

// The largest threshold at which the patches are as true as that.
void as_true_as(Patches& patches, double true_px, double asked_px) {
    double low = asked_px / 64, high = asked_px * 16;
    for (int i = 0; i < 9; ++i) {
        io::check_interrupt();
        const double middle = std::sqrt(low * high);
        (void)patches.triangles(middle);
        (patches.true_error_px() <= true_px ? low : high) = middle;
    }
    (void)patches.triangles(low);
}

} // namespace

json draw_patches(const PatchPlan& plan) {
    const io::LoadedPack tiles = io::load_pack(plan.tiles, io::LoadTerrain::yes);
    const io::LoadedPack one = io::load_pack(plan.one_tile, io::LoadTerrain::yes);
    const Terrain& terrain = tiles.terrain;
    const double extent_m = terrain.x_m(static_cast<std::int32_t>(terrain.columns()) - 1);
    // From one corner over most of the square, so that it has millions of triangles in view.
    const View view = make_view({0.05 * extent_m, terrain.header().max_m + 0.004 * extent_m, 0.05 * extent_m},
                                {1, -0.12, 1}, {0, 1, 0}, 0.9, plan.width, plan.height, 3, 3 * extent_m);
    const Canvas canvas(plan, view, terrain);
    Cut cut(terrain, plan, view, canvas);
    Patches patches(one.terrain, view, canvas);
    json rows = json::array();
    (void)cut.triangles(plan.error_px);
    rows.push_back(cut.draw("error", "cut-error.png"));
    as_true_as(patches, rows.back()["true_error_px"], plan.error_px);
    rows.push_back(patches.draw("error", "cdlod-error.png"));
    for (const std::uint32_t triangles : plan.triangles) {
        const std::string name = std::to_string(triangles) + "-triangles";
        const auto of = [&](auto& method) {
            const double error_px = threshold_for(triangles, [&](double px) { return method.triangles(px); });
            (void)method.triangles(error_px);
        };
        of(cut);
        rows.push_back(cut.draw(std::to_string(triangles), "cut-" + name + ".png"));
        of(patches);
        rows.push_back(patches.draw(std::to_string(triangles), "cdlod-" + name + ".png"));
    }
    return rows;
}

} // namespace fjell::bench
