// The game of the tier below io::LiveTerrain (content/hosts/first has that): with memory and a loader of its own it
// walks over a pack that is streamed from the disk, in split screen with a drone, without a window.
//   game PACK PICTURE.png [FRAMES [PAGES]] [--dig FRAME]    --dig: in that frame a key is pressed that digs a crater
//   game PACK --times VIEWS    prints what a frame costs (content/hosts/times)
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <fjell/fjell.h>
#include <fjell/gl/context.h>
#include <fjell/gl/target.h>

#include "../times/times.h"
#include "draw.h"
#include "loader.h"
#include "walk.h"

namespace {

using namespace game;

int fail(const char* what, const std::string& why) {
    std::fprintf(stderr, "game: %s: %s\n", what, why.c_str());
    return 1;
}
int fail(const char* what, fjell::Status s) {
    return fail(what, std::string(s.field) + ": " + fjell::message(s.code));
}

constexpr fjell::CutBudget capacities{.vertices = 200'000, .triangles = 400'000, .views = 2};
constexpr fjell::StreamBudget streaming{.map_bytes = 64 << 20};
constexpr fjell::EditBudget digging{.blocks = 512};

// In this order they are made; in the other order they end.
struct World {
    fjell::TerrainBudget pages{.page_slots = 600}; // a pack may have millions
    PackOnDisk file;
    Memory memory;
    fjell::Terrain terrain;
    fjell::Edits edits;
    fjell::LiveCut cut;
    fjell::Stream stream;
    fjell::GroundMaps maps;
    std::unique_ptr<Loader> loader;

    World() = default;
    ~World();
    World(const World&) = delete;
    World& operator=(const World&) = delete;
    fjell::Status create();
};

fjell::Status World::create() {
    const fjell::Pack& pack = file.pack();
    const std::span<std::byte> ground = memory.allocate(fjell::terrain_bytes(pack.header, pages));
    if (fjell::Status s = fjell::create_terrain(pack, file.corners(), pages, ground, terrain); !s.ok()) return s;
    const std::span<std::byte> changed = memory.allocate(fjell::edits_bytes(pack.header, digging));
    if (fjell::Status s = fjell::create_edits(terrain, digging, changed, edits); !s.ok()) return s;
    const std::span<std::byte> mesh = memory.allocate(fjell::cut_bytes(terrain, capacities));
    if (fjell::Status s = fjell::create_cut(terrain, capacities, mesh, cut); !s.ok()) return s;
    const std::span<std::byte> requests = memory.allocate(fjell::stream_bytes(pack, terrain, streaming));
    if (fjell::Status s = fjell::create_stream(pack, terrain, cut, streaming, requests, stream); !s.ok()) return s;
    const std::span<std::byte> normals = memory.allocate(fjell::ground_maps_bytes(pack.header));
    if (fjell::Status s = fjell::create_ground_maps(terrain, {}, normals, maps); !s.ok()) return s;
    loader = std::make_unique<Loader>(stream, file);
    return {};
}

World::~World() {
    loader.reset(); // 1. the thread that uses the stream
    (void)fjell::destroy_ground_maps(maps);
    (void)fjell::destroy_stream(stream); // 2. what uses the cut and the terrain
    (void)fjell::destroy_cut(cut);
    (void)fjell::destroy_edits(edits);
    (void)fjell::destroy_terrain(terrain);
} // 3. the memory they lay in; 4. the file, whose directory the pack points into

struct Frame {
    fjell::View view[2];
    std::size_t view_count = 2;
    fjell::CutSettings settings{.max_error_px = 1, .max_work = 20'000, .morph = fjell::Morph::error};
    fjell::EditReport edited;
    fjell::StreamReport streamed;
    fjell::GroundMapsReport normals;
    fjell::CutReport report;

    [[nodiscard]] std::span<const fjell::View> views() const { return {view, view_count}; }
};

// On the frame's thread: never waits for the loader.
fjell::Status update(World& world, Frame& frame, double now_s) {
    frame.settings.now_s = now_s;
    fjell::Status s = fjell::update_edits(world.edits, frame.views(), {.max_time_us = 500}, frame.edited);
    if (s.ok()) s = fjell::update_stream(world.stream, frame.views(), frame.settings, {.now_s = now_s}, frame.streamed);
    world.loader->wake();
    for (const fjell::StreamFailure& failure : fjell::stream_failures(world.stream)) // coarser there from now on
        std::fprintf(stderr, "game: tile %u: %s\n", failure.id.tile, fjell::message(failure.code));
    if (s.ok()) s = fjell::note_map_commands(world.maps, fjell::stream_map_commands(world.stream));
    if (s.ok()) {
        const auto normals = fjell::stream_tile_maps(world.stream, fjell::MapKind::normal);
        s = fjell::update_ground_maps(world.maps, normals, frame.normals);
    }
    if (s.ok()) s = fjell::update_cut(world.cut, frame.views(), frame.settings, frame.report);
    return s;
}

// After every update: neither of them accumulates.
void upload_maps(const World& world, Drawer& drawer) {
    drawer.upload(fjell::stream_map_commands(world.stream));
    drawer.upload(fjell::ground_map_patches(world.maps)); // over what the commands have uploaded
}

void draw(World& world, Drawer& drawer, const Frame& frame, const fjell::gl::Target& target) {
    drawer.upload(fjell::cut_mesh(world.cut), fjell::cut_take_changes(world.cut));
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
    glEnable(GL_FRAMEBUFFER_SRGB);
    glClearColor(0.35f, 0.5f, 0.7f, 1);
    glClearDepth(0); // far away
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    const auto show = [&](const fjell::View& view, GLint left, GLint bottom) {
        glViewport(left, bottom, GLsizei(view.width_px), GLsizei(view.height_px));
        drawer.draw(world.terrain, fjell::cut_mesh(world.cut), view,
                    fjell::stream_tile_maps(world.stream, fjell::MapKind::colour),
                    fjell::stream_tile_maps(world.stream, fjell::MapKind::normal));
    };
    if (frame.view_count == 1) return show(frame.view[0], 0, 0);
    show(frame.view[0], 0, 360);            // split screen: one mesh, two cameras
    show(strip(frame.view[1], 0, 2), 0, 0); // and the drone's on two monitors
    show(strip(frame.view[1], 1, 2), 320, 0);
}

void say_what_was_short(const Frame& frame) {
    for (std::uint32_t bit = 1; bit <= fjell::cut_budget_time; bit <<= 1)
        if (frame.report.exhausted & bit)
            std::fprintf(stderr, "game: raise %s\n", fjell::budget_field(fjell::CutBudgetBit(bit)));
    for (std::uint32_t bit = 1; bit <= fjell::stream_requests; bit <<= 1)
        if (frame.streamed.exhausted & bit)
            std::fprintf(stderr, "game: raise %s\n", fjell::budget_field(fjell::StreamBudgetBit(bit)));
}

// Behind a loading screen: until the coarsest of all is there, then the whole mesh at once.
fjell::Status load(World& world, Drawer& drawer, Frame& frame) {
    while (!frame.streamed.complete) {
        if (fjell::Status s = update(world, frame, 0); !s.ok()) return s;
        upload_maps(world, drawer);
        if (frame.streamed.failed != 0) return {fjell::StatusCode::unreadable, "pack"};
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return fjell::rebuild_cut(world.cut, frame.views(), frame.settings, frame.report);
}

void look_around(const World& world, Frame& frame, double x_m, double z_m) {
    frame.view[0] = walker(world.terrain, x_m, z_m, {1, -0.1, 0.4});
    frame.view[1] = drone(frame.view[0]);
}

// What became of the key.
struct Dig {
    int key_frame = -1; // when it goes down; -1: never
    std::optional<fjell::Stamp> crater{};
    fjell::StampId id = 0;
    double ahead_m = 0, height_m = 0; // of the ground that is hit, before
    std::uint32_t samples = 0;        // that it changes
};

// The key goes down. What does not fit, or lies on ground that is not loaded, stays as it is, or waits: stamp_state().
fjell::Status press(World& world, const fjell::View& view, Dig& dig) {
    dig.crater = crater_ahead(world.terrain, view, 1e5);
    if (!dig.crater) return {}; // the sky
    dig.ahead_m = sight_m(world.terrain, view, 1e5);
    dig.height_m = double(fjell::ground_height(world.terrain, dig.crater->x_m, dig.crater->z_m).height_m);
    return fjell::push_stamp(world.edits, *dig.crater, dig.id);
}

int say_what_was_dug(const World& world, const Dig& dig) {
    if (!dig.crater) return fail("dig", std::string("there is only sky ahead"));
    const fjell::StampResult result = fjell::stamp_state(world.edits, dig.id);
    if (!result.status.ok()) return fail("dig", result.status);
    if (result.state != fjell::StampState::applied) return fail("dig", std::string("its pages have not come"));
    const fjell::GroundHeight now = fjell::ground_height(world.terrain, dig.crater->x_m, dig.crater->z_m);
    std::printf("dug %.1f m ahead: %u samples, %.1f m deep of %.1f m\n", dig.ahead_m, dig.samples,
                dig.height_m - double(now.height_m), double(dig.crater->amount_m));
    return 0;
}

int play(World& world, Drawer& drawer, const fjell::gl::Target& target, int frames, Dig dig) {
    Frame frame;
    const double z_m = world.terrain.extent_z_m() / 2, start_x_m = world.terrain.extent_x_m() / 3;
    look_around(world, frame, start_x_m, z_m);
    if (fjell::Status s = load(world, drawer, frame); !s.ok()) return fail("loading", s);
    bool complete = false;
    for (int i = 0; i < frames + 2000; ++i) { // after the walk as many frames as the picture takes to be complete
        look_around(world, frame, start_x_m + 1.4 * std::min(i, frames) / 60.0, z_m);
        if (i == dig.key_frame) // your engine's window says when
            if (fjell::Status s = press(world, frame.view[0], dig); !s.ok()) return fail("dig", s);
        if (fjell::Status s = update(world, frame, i / 60.0); !s.ok()) return fail("frame", s);
        upload_maps(world, drawer);
        dig.samples += frame.edited.samples;
        complete = frame.edited.waiting == 0 && frame.edited.loose == 0 && frame.report.converged &&
                   frame.streamed.converged && frame.streamed.maps_converged && frame.normals.waiting == 0;
        const bool never = frame.streamed.failed != 0 || (frame.streamed.exhausted & fjell::stream_page_slots) != 0;
        const bool last = i >= frames && (complete || never);
        if (i % 60 == 0 || last) draw(world, drawer, frame, target);
        if (i == frames) say_what_was_short(frame);
        if (last) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(1)); // where a game waits for the display
    }
    float error_m = 0;
    const std::vector<float> heights_m =
        collider(world.terrain, sample_at(world.terrain, frame.view[0].eye_m), error_m);
    std::printf("converged %d: %u vertices, %u pages, %u failed\n", frame.report.converged, frame.report.vertices,
                world.terrain.pages_loaded(), frame.streamed.failed);
    std::printf("sees %.1f m far from %.1f m; %zu heights, %.3g m off at most\n",
                sight_m(world.terrain, frame.view[0], 1e5), frame.view[0].eye_m.y, heights_m.size(), error_m);
    if (dig.key_frame >= 0)
        if (const int code = say_what_was_dug(world, dig); code != 0) return code;
    return complete ? 0 : 1;
}

// One view, over a benchmark's path.
int measure(World& world, Drawer& drawer, const fjell::gl::Target& target, Measured& times) {
    Frame frame;
    frame.view_count = 1;
    frame.settings = {.max_error_px = TIMES_ERROR_PX, .morph = fjell::Morph::error};
    for (unsigned i = 0; i < times.flown(); ++i) {
        frame.view[0] = times.look(i);
        fjell::Status s = i == 0 ? load(world, drawer, frame) : fjell::Status{};
        times.start(i);
        if (s.ok()) s = update(world, frame, i / 60.0);
        if (!s.ok()) return fail("frame", s);
        times.done(times_update);
        upload_maps(world, drawer);
        drawer.upload(fjell::cut_mesh(world.cut), fjell::cut_take_changes(world.cut));
        times.done(times_upload);
        draw(world, drawer, frame, target);
        times.done(times_draw);
        glFinish();
        times.done(times_finish);
        std::this_thread::sleep_for(std::chrono::milliseconds(1)); // where a game waits for the display
    }
    const char* const parts[] = {"update", "upload", "draw", "finish"};
    times_print(&times, frame.report.vertices, parts);
    return 0;
}

int run(int argc, char** argv) {
    Dig dig;
    if (argc > 4 && argv[argc - 2] == std::string_view("--dig")) dig.key_frame = std::atoi(argv[argc - 1]), argc -= 2;
    if (argc < 3) return fail("usage", "game PACK PICTURE.png [FRAMES [PAGES]] [--dig FRAME]");
    Measured times;
    const bool measured = argc == 4 && argv[2] == std::string_view("--times");
    if (const char* wrong = measured ? times_read(&times, argv[3]) : nullptr) return fail(argv[3], wrong);
    const auto context = fjell::gl::Headless::create(); // your engine has its window
    const auto target = fjell::gl::Target::create({640, 720});
    World world;
    if (measured) world.pages.page_slots = TIMES_PAGES;
    if (argc > 4) world.pages.page_slots = std::uint32_t(std::atoi(argv[4]));
    if (const std::string error = world.file.open(argv[1]); !error.empty()) return fail("pack", error);
    if (fjell::Status s = world.create(); !s.ok()) return fail("world", s);
    Drawer drawer;
    const std::string error =
        drawer.create(GAME_SHADERS, capacities, fjell::stream_map_layers(world.stream, fjell::MapKind::colour),
                      fjell::stream_map_layers(world.stream, fjell::MapKind::normal));
    if (!error.empty()) return fail("shaders", error);
    if (measured) return measure(world, drawer, *target, times);
    const int code = play(world, drawer, *target, argc > 3 ? std::atoi(argv[3]) : 600, dig);
    fjell::gl::Image picture;
    target->read_colour(picture);
    fjell::gl::write_png(picture, argv[2]);
    return code;
}

} // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const fjell::io::Failure& failure) { // what fjell::gl throws
        return fail("graphics", failure.what());
    }
}
