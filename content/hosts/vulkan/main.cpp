// Terrain with Vulkan, without a window: flies over a pack that is streamed from the disk.
//   vulkan PACK PICTURE.ppm [FRAMES [VERTICES [PAGES]]]
//   vulkan PACK --times VIEWS    prints what a frame costs (content/hosts/times)
// Every 30th frame is compared with the cut and with the full-resolution surface, and the last one is written. Exit
// code 1: a promise is broken, or the pack or a budget is at fault; 2: usage; 3: the machine is.
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fjell/io.h>

#include "../times/times.h"
#include "check.h"
#include "drawer.h"
#include "gpu.h"
#include "probe.h"
#include "space.h"

namespace {

using namespace vulkan;
using fjell::io::Failure;

constexpr std::uint32_t width_px = 640, height_px = 360, probe_every = 30, late_every = 5, most_frames = 100'000;
constexpr double frame_s = 1.0 / 60, speed_m_s = 600;

struct Arguments {
    std::string pack, picture;
    std::uint32_t frames = 240, vertices = 65'536, pages = 600;
    std::string views; // of --times
};

Arguments read_arguments(int argc, char** argv) {
    if (argc < 3 || argc > 6) throw Failure(2, "usage: vulkan PACK PICTURE.ppm [FRAMES [VERTICES [PAGES]]]");
    Arguments all{.pack = argv[1], .picture = argv[2]};
    if (all.picture == "--times" && argc == 4) {
        all.views = argv[3];
        all.pages = TIMES_PAGES;
        return all;
    }
    std::uint32_t* const numbers[] = {&all.frames, &all.vertices, &all.pages};
    for (int i = 3; i < argc; ++i) {
        const char* const end = argv[i] + std::strlen(argv[i]);
        const auto [stop, error] = std::from_chars(argv[i], end, *numbers[i - 3]);
        if (error != std::errc() || stop != end || *numbers[i - 3] == 0)
            throw Failure(2, "FRAMES, VERTICES and PAGES are whole numbers from 1 on");
    }
    all.frames = std::min(all.frames, most_frames);
    return all;
}

fjell::io::LiveOptions options_of(const Arguments& arguments) {
    return {.page_slots = arguments.pages,
            .cut = {.vertices = arguments.vertices, .triangles = 2 * arguments.vertices},
            .stream = {.map_bytes = 64 << 20}, // maps are not drawn here
            .settings = {.cut = {.max_error_px = 1, .max_work = 20'000, .morph = fjell::Morph::error},
                         .stream = {.texel_px = 100}}};
}

// What the frames cost, and what they did.
struct Log {
    std::vector<float> update_us, stage_us, record_us, submit_us;
    std::vector<std::uint32_t> uploaded_bytes;
    std::uint32_t rebased = 0, tiles_drawn = 0;

    Log() {
        for (auto* times : {&update_us, &stage_us, &record_us, &submit_us}) times->reserve(2 * most_frames);
        uploaded_bytes.reserve(2 * most_frames);
    }
};

template <typename T>
T median(std::vector<T> all) {
    const auto middle = all.begin() + std::ptrdiff_t(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    return all.empty() ? T{} : *middle;
}

using Clock = std::chrono::steady_clock;
float us_since(Clock::time_point start) {
    return std::chrono::duration<float, std::micro>(Clock::now() - start).count();
}

class Flight {
public:
    Flight(fjell::io::LiveTerrain& ground, Gpu& gpu, const fjell::Terrain& whole)
        : ground_(ground), drawer_(gpu, ground.terrain(), ground.options().cut, {width_px, height_px}),
          probe_(gpu, drawer_), check_(whole) {}
    // Throws Failure when a promise is broken.
    void fly(std::uint32_t frames);
    void print(const Gpu& gpu) const;
    void write_picture(const std::string& path) const;

private:
    void update(double now_s);
    void draw(bool probed);
    void look(double travelled_m);
    void load();
    void compare();

    fjell::io::LiveTerrain& ground_;
    Drawer drawer_;
    Probe probe_;
    Check check_;
    Origin origin_;
    fjell::View view_;
    const fjell::StreamReport& streamed_ = ground_.frame().stream; // of the last update
    const fjell::CutReport& report_ = ground_.frame().cut;
    Log log_;
};

// Eastwards over the middle, above all peaks, half to the right of the way. The eye is the host's, in doubles.
void Flight::look(double travelled_m) {
    const fjell::Terrain& terrain = ground_.terrain();
    const Vector eye_m{double(terrain.extent_x_m()) / 4 + travelled_m, -double(terrain.extent_z_m()) / 2,
                       double(terrain.header().max_m) + 100};
    view_ = fjell::make_view(to_scene(eye_m), to_scene({1, -0.6, -0.3}), to_scene({0, 0, 1}), 1.0, width_px, height_px,
                             0.5, 1e7); // what is farther is not drawn, though depth could hold it
    log_.rebased += origin_.follow(eye_m, terrain);
}

void Flight::update(double now_s) {
    ground_.update({&view_, 1}, now_s);
    for (const fjell::StreamFailure& failure : fjell::stream_failures(ground_.stream())) // coarser there from now on
        std::fprintf(stderr, "vulkan: tile %u: %s\n", failure.id.tile, fjell::message(failure.code));
}

// The coarsest of all, then the whole mesh at once.
void Flight::load() {
    while (!streamed_.complete) {
        update(0);
        if (streamed_.failed != 0) throw Failure(1, "the pack's coarsest pages cannot be read; see above");
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    fjell::CutReport report;
    const fjell::Status s = fjell::rebuild_cut(ground_.cut(), {&view_, 1}, ground_.settings.cut, report);
    if (!s.ok()) throw Failure(1, std::string(s.field) + ": " + fjell::message(s.code));
}

void Flight::draw(bool probed) {
    drawer_.wait();
    counting = true;
    Clock::time_point start = Clock::now();
    const fjell::CutMesh cut = fjell::cut_mesh(ground_.cut());
    const fjell::CutChanges changes = ground_.take_changes(); // however many updates they are of
    const std::uint64_t bytes = drawer_.stage(cut, changes);
    log_.stage_us.push_back(us_since(start));
    check_.upload(changes, drawer_.index_bytes(), bytes);
    start = Clock::now();
    const VkCommandBuffer commands = drawer_.record(cut, view_, origin_);
    log_.record_us.push_back(us_since(start));
    if (probed) probe_.record(commands, drawer_, cut);
    start = Clock::now();
    drawer_.submit();
    log_.submit_us.push_back(us_since(start));
    counting = false;
    log_.uploaded_bytes.push_back(std::uint32_t(bytes));
    log_.tiles_drawn = report_.tiles_drawn;
}

void Flight::compare() {
    drawer_.finish(); // a game never waits like this
    const fjell::CutMesh cut = fjell::cut_mesh(ground_.cut());
    check_.vertices(ground_.terrain(), cut, view_, origin_, drawer_.index_bytes(), probe_);
    check_.picture(cut, report_, view_, probe_);
    if (!check_.broken().empty()) throw Failure(1, check_.broken());
}

void Flight::fly(std::uint32_t frames) {
    look(0);
    load();
    for (std::uint32_t i = 0; i < frames + most_frames; ++i) { // then until the picture is complete
        look(std::min(i, frames) * frame_s * speed_m_s);
        counting = true;
        const Clock::time_point start = Clock::now();
        update(i * frame_s);
        log_.update_us.push_back(us_since(start));
        counting = false;
        const bool never = streamed_.failed != 0 || (streamed_.exhausted & fjell::stream_page_slots) != 0 ||
                           (report_.exhausted & (fjell::cut_budget_vertices | fjell::cut_budget_triangles)) != 0;
        const bool last = i >= frames && ((report_.converged && streamed_.converged) || never);
        const bool probed = i % probe_every == 0 || last;
        // As where the display is slower than the game: the next picture takes the changes of both updates.
        if (i % late_every == late_every - 1 && !probed) continue;
        draw(probed);
        if (probed) compare();
        if (last) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(1)); // where a game waits for the display
    }
    drawer_.finish();
    for (const char* const field : ground_.frame().short_of) std::fprintf(stderr, "vulkan: raise %s\n", field);
}

void Flight::print(const Gpu& gpu) const {
    const fjell::Vec3 eye = view_.eye_m, at = view_.eye_m + view_.forward;
    std::printf("eye %.17g,%.17g,%.17g looks at %.17g,%.17g,%.17g\n", eye.x, eye.y, eye.z, at.x, at.y, at.z);
    std::printf("converged %d: %u vertices, %u triangles, %u of %u tiles drawn in %u ranges; rebased %u times\n",
                report_.converged, report_.vertices, report_.triangles, report_.tiles_drawn,
                ground_.terrain().tile_count(), drawer_.draws(), log_.rebased - 1);
    std::printf("%zu bytes a vertex for %zu, %u an index; %.1f MB on the device\n", sizeof(fjell::CompactVertex),
                sizeof(fjell::MeshVertex) + sizeof(fjell::MorphVertex), drawer_.index_bytes(),
                double(gpu.device_bytes()) / 1e6);
    const Check::Copies copies = Check::copies(fjell::cut_mesh(ground_.cut()));
    std::printf("copies of a vertex if each range had its own: %.2f, each tile: %.2f\n", copies.by_range,
                copies.by_tile);
    std::printf("uploaded %u bytes a frame (median), exactly what had changed\n", median(log_.uploaded_bytes));
    std::printf("%llu vertices compared, %llu of them half-way; rounding moves them by %.4f px and %.2f m at most\n",
                static_cast<unsigned long long>(check_.vertex_count()),
                static_cast<unsigned long long>(check_.between_count()), check_.worst_rounding_px(),
                check_.worst_rounding_m());
    std::printf("%llu pixels compared with the full resolution, off by %.2f px at most, %.0f%% of what is allowed\n",
                static_cast<unsigned long long>(check_.pixel_count()), check_.worst_px(), 100 * check_.worst_share());
    std::printf("update %.0f us, staging %.0f us, recording %.0f us, submitting %.0f us (medians); %llu allocations\n",
                double(median(log_.update_us)), double(median(log_.stage_us)), double(median(log_.record_us)),
                double(median(log_.submit_us)), static_cast<unsigned long long>(allocations));
}

void Flight::write_picture(const std::string& path) const {
    std::vector<unsigned char> bytes;
    for (const std::uint32_t pixel : probe_.colours())
        for (int shift : {0, 8, 16}) bytes.push_back(static_cast<unsigned char>(pixel >> shift));
    std::FILE* const file = std::fopen(path.c_str(), "wb");
    bool good = file != nullptr && std::fprintf(file, "P6\n%u %u\n255\n", width_px, height_px) > 0 &&
                std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
    if (file != nullptr) good = std::fclose(file) == 0 && good;
    if (!good) throw Failure(3, path + ": cannot be written; give a place with room");
}

// Over a benchmark's path, and nothing is compared with anything.
void measure(fjell::io::LiveTerrain& ground, Gpu& gpu, Measured& times) {
    Drawer drawer(gpu, ground.terrain(), ground.options().cut, {times.width_px, times.height_px});
    Origin origin;
    ground.settings.cut.max_error_px = TIMES_ERROR_PX;
    ground.settings.cut.max_work = fjell::unlimited_work;
    for (unsigned i = 0; i < times.flown(); ++i) {
        const fjell::View view = times.look(i);
        (void)origin.follow(from_scene(view.eye_m), ground.terrain());
        times.start(i);
        const fjell::CutMesh cut = ground.update({&view, 1}, i * frame_s).mesh;
        times.done(times_update);
        drawer.wait();
        times.pause();
        (void)drawer.stage(cut, ground.take_changes());
        times.done(times_upload);
        (void)drawer.record(cut, view, origin);
        drawer.submit();
        times.done(times_draw);
        drawer.finish();
        times.done(times_finish);
        std::this_thread::sleep_for(std::chrono::milliseconds(1)); // where a game waits for the display
    }
    const char* const parts[] = {"update", "upload", "draw", "finish"};
    times_print(&times, ground.frame().cut.vertices, parts);
}

int run(int argc, char** argv) {
    const Arguments arguments = read_arguments(argc, argv);
    Measured times;
    if (const char* wrong = arguments.views.empty() ? nullptr : times_read(&times, arguments.views.c_str()))
        throw Failure(2, arguments.views + ": " + wrong);
    fjell::io::LiveTerrain ground(arguments.pack, options_of(arguments));
    if (!arguments.views.empty()) {
        Gpu gpu;
        measure(ground, gpu, times);
        return 0;
    }
    const fjell::io::LoadedPack whole = fjell::io::load_pack(*ground.file(), fjell::io::LoadTerrain::yes);
    if (whole.terrain.has_voids())
        throw Failure(1, arguments.pack + ": this host's checks know no holes; give a pack without");
    Gpu gpu;
    Flight flight(ground, gpu, whole.terrain);
    std::printf("on %s\n", gpu.name().c_str());
    flight.fly(arguments.frames);
    flight.print(gpu);
    flight.write_picture(arguments.picture);
    std::printf("%u messages of Vulkan's validation\n", gpu.messages());
    return gpu.messages() == 0 ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    return fjell::io::run_tool("vulkan", [&] { return run(argc, argv); });
}
