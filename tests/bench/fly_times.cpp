// What hosts are measured against (hosts.sh): the flight of fjell-fly, frame by frame as in its window, with the loop
// that all hosts have (content/hosts/times).
//   fly_times PACK --write PATH FRAMES    prints the VIEWS of a camera path
//   fly_times PACK --times VIEWS          flies them; the pack is loaded whole
//   fly_times PACK --stream VIEWS         and this one is streamed
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <thread>

#include <epoxy/gl.h>

#include "content/hosts/times/times.h"
#include "fjell/gl/context.h"
#include "fjell/io/failure.h"
#include "session/pictures.h"
#include "session/session.h"

namespace {

using namespace fjell;
using namespace fjell::session;

constexpr std::uint32_t width_px = 640, height_px = 360;

void write_views(FlightOptions& options, std::size_t frames) {
    Session session;
    open_session(options, session);
    std::printf("%u %u %.17g\n", width_px, height_px, options.profile.fov_deg * std::numbers::pi / 180);
    for (const Pose& pose : resample(path_of(options), session.ground(), frames))
        std::printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", pose.position_m.x, pose.position_m.y,
                    pose.position_m.z, pose.direction.x, pose.direction.y, pose.direction.z, pose.up.x, pose.up.y,
                    pose.up.z);
}

void fly(const FlightOptions& options, Measured& times) {
    Session session;
    open_session(options, session);
    const auto context = gl::Headless::create();
    const auto target = make_target(times.width_px, times.height_px, options.profile);
    const auto renderer = make_renderer(options, session);
    FrameEntry entry;
    for (unsigned i = 0; i < times.flown(); ++i) {
        const View view = times.look(i);
        times.start(i);
        entry = update_frame(session, view, options.profile, i / 60.0);
        times.done(times_update);
        upload_mesh(*renderer, session, entry);
        times.done(times_upload);
        renderer->draw_uploaded(session.mesh(), view, draw_options(PictureMode::shaded, options.profile, i / 60.0),
                                *target);
        times.done(times_draw);
        glFinish();
        times.done(times_finish);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const char* const parts[] = {"update", "upload", "draw", "finish"};
    times_print(&times, entry.vertices, parts);
}

int run(int argc, char** argv) {
    if (argc < 4) throw io::Failure(2, "usage: fly_times PACK --write PATH FRAMES | --times VIEWS | --stream VIEWS");
    const std::string what = argv[2];
    FlightOptions options;
    options.pack = argv[1];
    options.streaming = what == "--stream" ? Streaming::on : Streaming::off;
    Profile& profile = options.profile;
    profile.width_px = width_px;
    profile.height_px = height_px;
    profile.fov_deg = 50;
    profile.refine.max_error_px = TIMES_ERROR_PX;
    profile.cut.morph = Morph::error;
    profile.page_slots = TIMES_PAGES;
    profile.samples = 1;
    if (what == "--write") {
        options.path = argv[3];
        write_views(options, argc > 4 ? std::size_t(std::atoi(argv[4])) : 240);
        return 0;
    }
    Measured times;
    if (const char* wrong = times_read(&times, argv[3])) throw io::Failure(2, std::string(argv[3]) + ": " + wrong);
    fly(options, times);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return io::run_tool("fly_times", [&] { return run(argc, argv); });
}
