// Flies over a pack in an OGRE scene: streamed ground that casts and receives shadows, with boulders on it.
//   ogre PACK PICTURE.ppm [FRAMES [PAGES]]
//   ogre PACK --times VIEWS    prints what a frame costs (content/hosts/times)
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include <OgreException.h>

#include <fjell/fjell.h>

#include "../game/loader.h"
#include "../times/times.h"
#include "check.h"
#include "ground.h"
#include "scene.h"

namespace {

int fail(const std::string& what, const std::string& why) {
    std::fprintf(stderr, "ogre: %s: %s\n", what.c_str(), why.c_str());
    return 1;
}
int fail(const char* what, fjell::Status s) {
    return fail(what, std::string(s.field) + ": " + fjell::message(s.code));
}

constexpr fjell::CutBudget capacities{.vertices = 300'000, .triangles = 600'000};
constexpr fjell::StreamBudget streaming{.map_bytes = 16 << 20};
constexpr double fov_y_rad = 0.872664626; // 50 degrees

struct World {
    fjell::TerrainBudget pages{.page_slots = 2000};
    game::PackOnDisk file;
    game::Memory memory;
    fjell::Terrain terrain;
    fjell::LiveCut cut;
    fjell::Stream stream;
    std::unique_ptr<game::Loader> loader;

    World() = default;
    ~World() {
        loader.reset(); // the thread that uses the stream
        (void)fjell::destroy_stream(stream);
        (void)fjell::destroy_cut(cut);
        (void)fjell::destroy_terrain(terrain);
    }
    World(const World&) = delete;
    World& operator=(const World&) = delete;
    fjell::Status create();
};

fjell::Status World::create() {
    const fjell::Pack& pack = file.pack();
    const std::span<std::byte> ground = memory.allocate(fjell::terrain_bytes(pack.header, pages));
    if (fjell::Status s = fjell::create_terrain(pack, file.corners(), pages, ground, terrain); !s.ok()) return s;
    const std::span<std::byte> mesh = memory.allocate(fjell::cut_bytes(terrain, capacities));
    if (fjell::Status s = fjell::create_cut(terrain, capacities, mesh, cut); !s.ok()) return s;
    const std::span<std::byte> requests = memory.allocate(fjell::stream_bytes(pack, terrain, streaming));
    if (fjell::Status s = fjell::create_stream(pack, terrain, cut, streaming, requests, stream); !s.ok()) return s;
    loader = std::make_unique<game::Loader>(stream, file);
    return {};
}

struct Frame {
    fjell::CutSettings settings{.max_error_px = 1.5, .morph = fjell::Morph::error};
    fjell::StreamReport streamed;
    fjell::CutReport report;
    double update_us = 0, upload_us = 0;
    std::size_t uploaded = 0;
};

double us_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

fjell::Status decide(World& world, const fjell::View& view, Frame& frame, double now_s) {
    frame.settings.now_s = now_s;
    fjell::Status s = fjell::update_stream(world.stream, {&view, 1}, frame.settings, {.now_s = now_s}, frame.streamed);
    world.loader->wake();
    for (const fjell::StreamFailure& failure : fjell::stream_failures(world.stream)) // coarser there from now on
        std::fprintf(stderr, "ogre: tile %u: %s\n", failure.id.tile, fjell::message(failure.code));
    if (s.ok()) s = fjell::update_cut(world.cut, {&view, 1}, frame.settings, frame.report);
    return s;
}

void hand_over(const World& world, const host::Scene& scene, host::Ground& ground, const fjell::View& view) {
    const fjell::CutMesh cut = fjell::cut_mesh(world.cut);
    ground.upload(cut, fjell::cut_take_changes(world.cut));
    ground.place(cut, scene.origin_m(), view.eye_m);
}

fjell::Status update(World& world, const host::Scene& scene, host::Ground& ground, Frame& frame, double now_s) {
    const fjell::View view = scene.view();
    auto start = std::chrono::steady_clock::now();
    const fjell::Status s = decide(world, view, frame, now_s);
    frame.update_us += us_since(start);
    start = std::chrono::steady_clock::now();
    hand_over(world, scene, ground, view);
    frame.upload_us += us_since(start);
    frame.uploaded += ground.uploaded_bytes();
    return s;
}

// A place to look from: low over the ground, and where to.
void steer(const World& world, host::Scene& scene, double metres) {
    const double x_m = world.terrain.extent_x_m() / 3 + metres, z_m = world.terrain.extent_z_m() / 2;
    const fjell::GroundHeight below = fjell::ground_height(world.terrain, x_m, z_m);
    const fjell::Vec3 eye_m{x_m, below.height_m + below.error_m + 25, z_m};
    // The scene's origin follows in steps; what is in the scene moves with it, what is on the GPU of the ground stays.
    if (fjell::length(eye_m - scene.origin_m()) > 500) scene.move_origin({std::floor(x_m), 0, std::floor(z_m)});
    scene.look(eye_m, fjell::normalised({1, -0.12, 0.35}));
}

int fly(World& world, host::Scene& scene, const char* picture, int frames) {
    host::Ground ground(world.terrain, capacities, scene.ground_material());
    scene.add(ground);
    Frame frame;
    bool complete = false;
    int flown = 0;
    for (int i = 0; i < frames + 5000 && !(i >= frames && complete); ++i) {
        const double metres = 2.0 * std::min(i, frames);
        steer(world, scene, metres);
        if (fjell::Status s = update(world, scene, ground, frame, i / 60.0); !s.ok()) return fail("frame", s);
        const bool never = frame.streamed.failed != 0 || (frame.streamed.exhausted & fjell::stream_page_slots) != 0;
        complete = (frame.report.converged && frame.streamed.converged) || never;
        ++flown;
        if (i % 30 == 0) scene.draw();
        if (i >= frames) std::this_thread::sleep_for(std::chrono::milliseconds(1)); // where a game waits
    }
    if (!complete) return fail("flight", "the ground did not come");
    for (std::uint32_t bit = 1; bit <= fjell::stream_requests; bit <<= 1)
        if (frame.streamed.exhausted & bit)
            std::fprintf(stderr, "ogre: raise %s\n", fjell::budget_field(fjell::StreamBudgetBit(bit)));
    std::printf("%.0f us to update, %.0f us to copy %zu bytes a frame\n", frame.update_us / flown,
                frame.upload_us / flown, frame.uploaded / std::size_t(flown));
    const fjell::View view = scene.view();
    scene.draw();
    const auto bare = scene.picture();
    const std::size_t triangles = scene.triangles_drawn();
    const host::Checked checked = host::check_picture(world.terrain, view, bare, host::Scene::sky, 6);
    scene.add_boulders(world.terrain, view.eye_m + view.forward * 90, 45);
    scene.draw();
    const auto full = scene.picture();
    std::size_t changed = 0, darker = 0;
    for (std::size_t i = 0; i < full.size(); i += 3) {
        const int before = bare[i] + bare[i + 1] + bare[i + 2], now = full[i] + full[i + 1] + full[i + 2];
        changed += before != now;
        darker += now * 10 < before * 8;
    }
    std::printf("%u vertices; OGRE draws %zu triangles, the cut has %u in view. the origin moved %d times\n",
                frame.report.vertices, triangles, frame.report.triangles_drawn, scene.moves());
    std::printf("%d rays to the ground and %d to the sky, %d of them not as drawn\n", checked.ground, checked.sky,
                checked.wrong);
    std::printf("boulders and their shadows: %zu pixels, %zu of them much darker\n", changed, darker);
    if (const std::string error = host::write_ppm(picture, full, view); !error.empty()) return fail("picture", error);
    if (checked.wrong != 0) return fail("picture", "the ground is not where rays meet it");
    if (triangles != frame.report.triangles_drawn) return fail("picture", "not the triangles of the cut");
    return frame.streamed.failed == 0 ? 0 : fail("pack", "parts of it cannot be read; the ground is coarser there");
}

// Over a benchmark's path, with the sun's shadow as in a flight.
int measure(World& world, host::Scene& scene, Measured& times) {
    host::Ground ground(world.terrain, capacities, scene.ground_material());
    scene.add(ground);
    Frame frame;
    frame.settings.max_error_px = TIMES_ERROR_PX;
    for (unsigned i = 0; i < times.flown(); ++i) {
        const fjell::View wanted = times.look(i);
        if (fjell::length(wanted.eye_m - scene.origin_m()) > 500)
            scene.move_origin({std::floor(wanted.eye_m.x), 0, std::floor(wanted.eye_m.z)});
        scene.look(wanted.eye_m, wanted.forward);
        const fjell::View view = scene.view();
        times.start(i);
        fjell::Status s = decide(world, view, frame, i / 60.0);
        times.done(times_update);
        if (s.ok() && frame.streamed.failed != 0) s = {fjell::StatusCode::unreadable, "pack"};
        if (!s.ok()) return fail("frame", s);
        hand_over(world, scene, ground, view);
        times.done(times_upload);
        scene.draw();
        times.done(times_draw);
        std::this_thread::sleep_for(std::chrono::milliseconds(1)); // where a game waits for the display
    }
    const char* const parts[] = {"update", "upload", "draw", nullptr}; // OGRE draws and swaps in one call
    times_print(&times, frame.report.vertices, parts);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 3) return fail("usage", "ogre PACK PICTURE.ppm [FRAMES [PAGES]]");
    Measured times;
    const bool measured = argc == 4 && argv[2] == std::string_view("--times");
    if (const char* wrong = measured ? times_read(&times, argv[3]) : nullptr) return fail(argv[3], wrong);
    World world;
    if (argc > 4) world.pages.page_slots = static_cast<std::uint32_t>(std::max(1, std::atoi(argv[4])));
    if (const std::string error = world.file.open(argv[1]); !error.empty()) return fail("pack", error);
    if (fjell::Status s = world.create(); !s.ok()) return fail("world", s);
    std::unique_ptr<host::Scene> scene;
    try {
        scene = measured ? std::make_unique<host::Scene>(times.width_px, times.height_px, times.fov_y_rad)
                         : std::make_unique<host::Scene>(960, 540, fov_y_rad);
    } catch (const Ogre::Exception& e) {
        (void)fail("OGRE", e.getDescription());
        std::_Exit(1); // without a window what OGRE leaves for the end of the program cannot run
    }
    if (measured) return measure(world, *scene, times);
    return fly(world, *scene, argv[2], argc > 3 ? std::max(1, std::atoi(argv[3])) : 240);
}
