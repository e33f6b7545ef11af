// Ways to bring a live cut's written slots to the GPU: a call a run of slots, as before; the same runs copied from a
// mapped ring; records in the ring that a compute shader spreads, as the renderer does.
//
// Names: upload/way/cells a frame/finished or behind. finished: the GPU is idle when the upload begins, so what is
// timed is the upload. behind: it may still draw the last frame, so waiting counts too. Microseconds of the CPU a
// frame; calls: of GL, a frame.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include <epoxy/gl.h>

#include "baker/bake/bake.h"
#include "fjell/gl/context.h"
#include "fjell/gl/target.h"
#include "fjell/io/load.h"
#include "gl/scatter.h"
#include "support/dem.h"

namespace {

using namespace fjell;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t vertex_slots = 1u << 18, triangle_slots = 1u << 19;
enum class Way { runs, copies, scatter };

[[noreturn]] void stop(const std::string& why) {
    std::fprintf(stderr, "bench_upload: %s\n", why.c_str());
    std::exit(3);
}

io::LoadedPack load() {
    const std::string path = std::string(FJELL_BENCH_DIR) + "/upload-" + std::to_string(pack_layout_hash) + ".fjell";
    std::filesystem::create_directories(FJELL_BENCH_DIR);
    if (!std::filesystem::exists(path)) {
        baker::BakeOptions options;
        options.tile_log2 = 8;
        options.max_texture_log2 = 4;
        (void)baker::bake(baker::synthesise_text(R"({"columns": 2049, "rows": 2049, "spacing_m": 60, "seed": 7,
                                                      "base_m": 0, "relief_m": 3000, "feature_m": 20000})"),
                          options, path);
    }
    return io::load_pack(path, io::LoadTerrain::yes);
}

struct Device {
    std::unique_ptr<gl::Headless> context;
    std::unique_ptr<gl::Target> target;
    gl::MeshBuffers mesh;
    gl::Ring ring;
    gl::Scatter scatter;
    gl::Program program;
    gl::VertexArray array;

    Device() {
        context = gl::Headless::create();
        target = gl::Target::create({320, 240, 1});
        const auto make = [](std::size_t bytes) {
            unsigned name = 0;
            glCreateBuffers(1, &name);
            glNamedBufferStorage(name, static_cast<GLsizeiptr>(bytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
            return gl::Buffer(name);
        };
        mesh = {make(vertex_slots * sizeof(MeshVertex)), make(vertex_slots * sizeof(MorphVertex)),
                make(triangle_slots * 12)};
        ring.create(4u << 20, "the region");
        scatter.create();
        program = gl::make_program({"points of a map", "",
                                    "layout(location = 0) in ivec2 at; layout(location = 1) in float height;\n"
                                    "void main() { gl_Position = vec4(vec2(at) / 1024.0 - 1.0, height * 1e-4, 1); }",
                                    "", "out vec4 colour; void main() { colour = vec4(gl_FragCoord.z); }"});
        unsigned name = 0;
        glCreateVertexArrays(1, &name);
        array = gl::VertexArray(name);
        glVertexArrayVertexBuffer(name, 0, mesh.vertices.get(), 0, sizeof(MeshVertex));
        glVertexArrayElementBuffer(name, mesh.indices.get());
        glVertexArrayAttribIFormat(name, 0, 2, GL_INT, 0);
        glVertexArrayAttribFormat(name, 1, 1, GL_FLOAT, GL_FALSE, offsetof(MeshVertex, height_m));
        for (unsigned i = 0; i < 2; ++i) {
            glEnableVertexArrayAttrib(name, i);
            glVertexArrayAttribBinding(name, i, 0);
        }
    }

    void whole(const CutMesh& cut) const {
        const auto write = [](const gl::Buffer& to, auto span) {
            glNamedBufferSubData(to.get(), 0, static_cast<GLsizeiptr>(span.size_bytes()), span.data());
        };
        write(mesh.vertices, cut.mesh.vertices);
        write(mesh.morph, cut.morph);
        write(mesh.indices, cut.mesh.indices);
    }
    // A call for every run, of the driver's own copy or of one from the ring.
    std::size_t by_runs(const CutMesh& cut, const CutChanges& changes, bool from_ring) {
        std::size_t calls = 0;
        const auto put = [&](const gl::Buffer& to, const auto* all, std::size_t first, std::size_t count) {
            const std::size_t size = sizeof(*all), bytes = count * size;
            ++calls;
            if (!from_ring) {
                glNamedBufferSubData(to.get(), static_cast<GLintptr>(first * size), static_cast<GLsizeiptr>(bytes),
                                     all + first);
                return;
            }
            ring.reserve(ring.aligned(bytes));
            const gl::RingSlice slice = ring.take(bytes);
            std::memcpy(slice.data, all + first, bytes);
            glCopyNamedBufferSubData(ring.buffer(), to.get(), static_cast<GLintptr>(slice.offset),
                                     static_cast<GLintptr>(first * size), static_cast<GLsizeiptr>(bytes));
        };
        for_each_run(changes.vertex_bits, changes.vertex_words, [&](std::size_t first, std::size_t count) {
            put(mesh.vertices, cut.mesh.vertices.data(), first, count);
            put(mesh.morph, cut.morph.data(), first, count);
        });
        for_each_run(changes.triangle_bits, changes.triangle_words, [&](std::size_t first, std::size_t count) {
            put(mesh.indices, cut.mesh.indices.data(), 3 * first, 3 * count);
        });
        return calls;
    }
    std::size_t upload(const CutMesh& cut, const CutChanges& changes, Way way) {
        ring.next();
        if (way != Way::scatter) return by_runs(cut, changes, way == Way::copies);
        (void)gl::scatter(scatter, ring, cut, changes, mesh);
        return 14;
    }
    void draw(const MeshView& view) const {
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target->framebuffer());
        glViewport(0, 0, 320, 240);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        glUseProgram(program.get());
        glBindVertexArray(array.get());
        for (const TileRange& range : view.tiles)
            glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(range.index_count), GL_UNSIGNED_INT,
                           reinterpret_cast<const void*>(std::size_t{4} * range.first_index));
        glFlush();
    }
};

void fly(benchmark::State& state, Way way, double cells, bool finished) {
    static io::LoadedPack loaded = load();
    static Device device;
    const Terrain& terrain = loaded.terrain;
    CutBudget budget;
    budget.vertices = vertex_slots;
    budget.triangles = triangle_slots;
    const std::size_t bytes = cut_bytes(terrain, budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    LiveCut cut;
    if (!create_cut(terrain, budget, {memory.get(), bytes}, cut).ok()) stop("the cut's budget does not do");
    CutSettings settings;
    settings.max_error_px = 4;
    CutReport report;
    std::vector<double> us;
    double changed = 0, calls = 0;
    for (auto _ : state) {
        us.clear();
        constexpr int frames = 60;
        for (int frame = 0; frame <= frames; ++frame) {
            const double x = 50'000 + frame * cells * 60 * 0.8, z = 70'000 - frame * cells * 60 * 0.6;
            const View view = make_view({x, 2500, z}, {0.8, -0.15, -0.6}, {0, 1, 0}, 0.785, 1280, 960, 10, 3e5);
            if (!(frame == 0 ? rebuild_cut : update_cut)(cut, {&view, 1}, settings, report).ok()) stop("no update");
            const CutMesh mesh = cut_mesh(cut);
            const CutChanges changes = cut_take_changes(cut);
            if (finished) glFinish();
            const auto start = Clock::now();
            if (frame == 0)
                device.whole(mesh);
            else
                calls += static_cast<double>(device.upload(mesh, changes, way));
            const double took = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
            if (frame != 0) us.push_back(took);
            if (frame != 0) changed += report.vertices_changed + report.triangles_changed;
            device.draw(mesh.mesh);
        }
        glFinish();
        double sum = 0;
        for (const double t : us) sum += t;
        state.SetIterationTime(sum / frames * 1e-6);
    }
    std::sort(us.begin(), us.end());
    state.counters["us_p50"] = us[us.size() / 2];
    state.counters["us_p99"] = us[us.size() * 99 / 100];
    const double frames = static_cast<double>(us.size()) * static_cast<double>(state.iterations());
    state.counters["slots"] = changed / frames;
    state.counters["calls"] = calls / frames;
}

} // namespace

int main(int argc, char** argv) {
    const char* const names[] = {"runs", "copies", "scatter"};
    for (const double cells : {0.25, 1.0, 3.3})
        for (const bool finished : {true, false})
            for (const Way way : {Way::runs, Way::copies, Way::scatter})
                benchmark::RegisterBenchmark((std::string("upload/") + names[static_cast<int>(way)] + "/" +
                                              std::to_string(cells).substr(0, 4) + (finished ? "/finished" : "/behind"))
                                                 .c_str(),
                                             [=](benchmark::State& state) { fly(state, way, cells, finished); })
                    ->Iterations(1)
                    ->UseManualTime()
                    ->Unit(benchmark::kMicrosecond);
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
}
