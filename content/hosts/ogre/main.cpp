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

#include <fjell/io.h>

#include "../times/times.h"
#include "check.h"
#include "ground.h"
#include "scene.h"

namespace {

int fail(const std::string& what, const std::string& why) {
    std::fprintf(stderr, "ogre: %s: %s\n", what.c_str(), why.c_str());
    return 1;
}
constexpr double fov_y_rad = 0.872664626; // 50 degrees

fjell::io::LiveOptions options_of(std::uint32_t pages) {
    return {.page_slots = pages,
            .cut = {.vertices = 300'000, .triangles = 600'000},
            .stream = {.map_bytes = 16 << 20},
            .settings = {.cut = {.max_error_px = 1.5, .morph = fjell::Morph::error}}};
}

struct Costs {
    double update_us = 0, upload_us = 0;
    std::size_t uploaded = 0;
};

double us_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

void decide(fjell::io::LiveTerrain& terrain, const fjell::View& view, double now_s) {
    terrain.update({&view, 1}, now_s);
    for (const fjell::StreamFailure& failure : fjell::stream_failures(terrain.stream())) // coarser there from now on
        std::fprintf(stderr, "ogre: tile %u: %s\n", failure.id.tile, fjell::message(failure.code));
}

void hand_over(fjell::io::LiveTerrain& terrain, const host::Scene& scene, host::Ground& ground,
               const fjell::View& view) {
    const fjell::CutMesh& cut = terrain.frame().mesh;
    ground.upload(cut, terrain.take_changes());
    ground.place(cut, scene.origin_m(), view.eye_m);
}

void update(fjell::io::LiveTerrain& terrain, const host::Scene& scene, host::Ground& ground, Costs& costs,
            double now_s) {
    const fjell::View view = scene.view();
    auto start = std::chrono::steady_clock::now();
    decide(terrain, view, now_s);
    costs.update_us += us_since(start);
    start = std::chrono::steady_clock::now();
    hand_over(terrain, scene, ground, view);
    costs.upload_us += us_since(start);
    costs.uploaded += ground.uploaded_bytes();
}

// A place to look from: low over the ground, and where to.
void steer(const fjell::Terrain& terrain, host::Scene& scene, double metres) {
    const double x_m = terrain.extent_x_m() / 3 + metres, z_m = terrain.extent_z_m() / 2;
    const fjell::GroundHeight below = fjell::ground_height(terrain, x_m, z_m);
    const fjell::Vec3 eye_m{x_m, below.height_m + below.error_m + 25, z_m};
    // The scene's origin follows in steps; what is in the scene moves with it, what is on the GPU of the ground stays.
    if (fjell::length(eye_m - scene.origin_m()) > 500) scene.move_origin({std::floor(x_m), 0, std::floor(z_m)});
    scene.look(eye_m, fjell::normalised({1, -0.12, 0.35}));
}

int fly(fjell::io::LiveTerrain& terrain, host::Scene& scene, const char* picture, int frames) {
    host::Ground ground(terrain.terrain(), terrain.options().cut, scene.ground_material());
    scene.add(ground);
    Costs costs;
    const fjell::io::LiveFrame& frame = terrain.frame(); // of the last update
    bool complete = false;
    int flown = 0;
    for (int i = 0; i < frames + 5000 && !(i >= frames && complete); ++i) {
        const double metres = 2.0 * std::min(i, frames);
        steer(terrain.terrain(), scene, metres);
        update(terrain, scene, ground, costs, i / 60.0);
        const bool never = frame.stream.failed != 0 || (frame.stream.exhausted & fjell::stream_page_slots) != 0;
        complete = (frame.cut.converged && frame.stream.converged) || never;
        ++flown;
        if (i % 30 == 0) scene.draw();
        if (i >= frames) std::this_thread::sleep_for(std::chrono::milliseconds(1)); // where a game waits
    }
    if (!complete) return fail("flight", "the ground did not come");
    for (const char* const field : frame.short_of) std::fprintf(stderr, "ogre: raise %s\n", field);
    std::printf("%.0f us to update, %.0f us to copy %zu bytes a frame\n", costs.update_us / flown,
                costs.upload_us / flown, costs.uploaded / std::size_t(flown));
    const fjell::View view = scene.view();
    scene.draw();
    const auto bare = scene.picture();
    const std::size_t triangles = scene.triangles_drawn();
    const host::Checked checked = host::check_picture(terrain.terrain(), view, bare, host::Scene::sky, 6);
    scene.add_boulders(terrain.terrain(), view.eye_m + view.forward * 90, 45);
    scene.draw();
    const auto full = scene.picture();
    std::size_t changed = 0, darker = 0;
    for (std::size_t i = 0; i < full.size(); i += 3) {
        const int before = bare[i] + bare[i + 1] + bare[i + 2], now = full[i] + full[i + 1] + full[i + 2];
        changed += before != now;
        darker += now * 10 < before * 8;
    }
    std::printf("%u vertices; OGRE draws %zu triangles, the cut has %u in view. the origin moved %d times\n",
                frame.cut.vertices, triangles, frame.cut.triangles_drawn, scene.moves());
    std::printf("%d rays to the ground and %d to the sky, %d of them not as drawn\n", checked.ground, checked.sky,
                checked.wrong);
    std::printf("boulders and their shadows: %zu pixels, %zu of them much darker\n", changed, darker);
    if (const std::string error = host::write_ppm(picture, full, view); !error.empty()) return fail("picture", error);
    if (checked.wrong != 0) return fail("picture", "the ground is not where rays meet it");
    if (triangles != frame.cut.triangles_drawn) return fail("picture", "not the triangles of the cut");
    return frame.stream.failed == 0 ? 0 : fail("pack", "parts of it cannot be read; the ground is coarser there");
}

// Over a benchmark's path, with the sun's shadow as in a flight.
int measure(fjell::io::LiveTerrain& terrain, host::Scene& scene, Measured& times) {
    host::Ground ground(terrain.terrain(), terrain.options().cut, scene.ground_material());
    scene.add(ground);
    terrain.settings.cut.max_error_px = TIMES_ERROR_PX;
    for (unsigned i = 0; i < times.flown(); ++i) {
        const fjell::View wanted = times.look(i);
        if (fjell::length(wanted.eye_m - scene.origin_m()) > 500)
            scene.move_origin({std::floor(wanted.eye_m.x), 0, std::floor(wanted.eye_m.z)});
        scene.look(wanted.eye_m, wanted.forward);
        const fjell::View view = scene.view();
        times.start(i);
        decide(terrain, view, i / 60.0);
        times.done(times_update);
        if (terrain.frame().stream.failed != 0) return fail("pack", terrain.first_failure());
        hand_over(terrain, scene, ground, view);
        times.done(times_upload);
        scene.draw();
        times.done(times_draw);
        std::this_thread::sleep_for(std::chrono::milliseconds(1)); // where a game waits for the display
    }
    const char* const parts[] = {"update", "upload", "draw", nullptr}; // OGRE draws and swaps in one call
    times_print(&times, terrain.frame().cut.vertices, parts);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 3) return fail("usage", "ogre PACK PICTURE.ppm [FRAMES [PAGES]]");
    Measured times;
    const bool measured = argc == 4 && argv[2] == std::string_view("--times");
    if (const char* wrong = measured ? times_read(&times, argv[3]) : nullptr) return fail(argv[3], wrong);
    const auto pages = argc > 4 ? static_cast<std::uint32_t>(std::max(1, std::atoi(argv[4]))) : 2000u;
    std::unique_ptr<fjell::io::LiveTerrain> terrain;
    try {
        terrain = std::make_unique<fjell::io::LiveTerrain>(argv[1], options_of(pages));
    } catch (const fjell::io::Failure& failure) {
        return fail("pack", failure.what());
    }
    std::unique_ptr<host::Scene> scene;
    try {
        scene = measured ? std::make_unique<host::Scene>(times.width_px, times.height_px, times.fov_y_rad)
                         : std::make_unique<host::Scene>(960, 540, fov_y_rad);
    } catch (const Ogre::Exception& e) {
        (void)fail("OGRE", e.getDescription());
        std::_Exit(1); // without a window what OGRE leaves for the end of the program cannot run
    }
    if (measured) return measure(*terrain, *scene, times);
    return fly(*terrain, *scene, argv[2], argc > 3 ? std::max(1, std::atoi(argv[3])) : 240);
}
