// fjell-fly: flies a camera over a pack, in a window or headless. Exit codes: 0 done, 1 the input is at fault, 2 usage,
// 3 the machine (disk, memory, GPU) is.
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "fjell/gltf/snapshot.h"
#include "fjell/io/failure.h"
#include "flight/pictures.h"
#include "flight/session.h"
#include "fly/options.h"
#include "fly/outputs.h"
#include "fly/window.h"

namespace {

using namespace fjell;
using namespace fjell::flight;
using io::Failure;

// What a frame that lags would show in the end: the snapshot refines anew, to the frame's effective threshold. Of a
// streamed pack it has what is there.
void export_frame(const Export& e, const Session& session, const View& view, const RefineSettings& settings,
                  double effective_px) {
    const double error_px = effective_px / (settings.corner_safe ? corner_factor(view) : 1);
    const gltf::SnapshotResult result =
        gltf::export_snapshot(session.readable_pack(), session.terrain(), view, error_px, e.path);
    if (!result.ok()) throw Failure(result.exit_code, result.message);
}

// The threshold that capacities allow, whatever missing pages hide besides.
double allowed_px(const FrameEntry& entry) {
    return entry.error_px_effective > entry.missing_px ? entry.error_px_effective : entry.error_px_requested;
}

// What could not be read is an error of the input, or of the disk, once the flight is over.
void check_reads(const std::string& path, const StreamedPack& streamed) {
    const std::uint64_t corrupt = streamed.corrupt(), unreadable = streamed.unreadable();
    if (corrupt + unreadable == 0) return;
    throw Failure(corrupt != 0 ? 1 : 3,
                  fmt::format("{}: {} damaged and {} unreadable chunks; it was coarser there; {}", path, corrupt,
                              unreadable, corrupt != 0 ? "check it with fjell-bake verify" : "check the disk"));
}

void fly_headless(const FlightOptions& options, Session& session, std::span<const Pose> poses, FlightLog& log,
                  Verification& verification) {
    std::optional<Pictures> pictures;
    if (!options.render_folder.empty()) pictures.emplace(options, session);
    const Profile& profile = options.profile;
    const bool replay = !options.replay.empty();
    const auto start = std::chrono::steady_clock::now();
    const auto follow = [&](const FrameEntry& entry) {
        if (pictures) pictures->follow(session, entry);
    };
    for (std::size_t frame = 0; frame < (replay ? session.recording->frames.size() : poses.size()); ++frame) {
        io::check_interrupt();
        const View view =
            replay ? session.recording->frames[frame].views[0] : view_of(poses[frame], session.terrain(), profile);
        const double now_s = static_cast<double>(frame) / options.hz;
        if (options.realtime)
            std::this_thread::sleep_until(
                start + std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(now_s)));
        FrameEntry entry;
        if (options.wait) {
            entry = update_until_there(session, view, profile, now_s, follow);
        } else {
            entry = replay ? replay_frame(session, frame) : update_frame(session, view, profile, now_s);
            follow(entry);
        }
        if (options.verify_every && frame % options.verify_every == 0)
            verify_frame(session, view, profile, frame, entry, verification);
        if (pictures && frame % options.render_every == 0) pictures->write(session, view, frame);
        for (const Export& e : options.exports)
            if (e.frame == frame) export_frame(e, session, view, profile.refine, allowed_px(entry));
        log.frames.push_back(entry);
    }
}

int run(int argc, char** argv) {
    FlightOptions options;
    if (!parse_options(argc, argv, options)) return 0;
    io::catch_interrupts();
    const CameraPath path = path_of(options);
    Outputs outputs(options);
    Session session;
    open_session(options, session);
    if (session.streamed)
        session.streamed->on_failure([](const std::string& line) { fmt::print(stderr, "fjell-fly: {}\n", line); });
    if (!options.replay.empty()) options.profile.refine.error_px = session.recording->frames[0].settings.error_px;
    const std::size_t frames = options.frames ? options.frames : default_frames;
    std::vector<Pose> poses;
    if (options.replay.empty()) poses = resample(path, session.ground(), frames);
    FlightLog log;
    log.frames.reserve(frames);
    Verification verification;
    if (options.headless)
        fly_headless(options, session, poses, log, verification);
    else
        fly_in_window(options, session, poses, log, verification);
    outputs.finish(options, session, path, log, verification);
    if (session.streamed) check_reads(options.pack, *session.streamed);
    if (verification.exceeded)
        throw Failure(
            1, fmt::format(
                   "{}: frame {}: {:.4f} px measured where {:.4f} are allowed; check the pack with fjell-bake verify",
                   options.pack, verification.frame, verification.max_px, verification.limit_px));
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return io::run_tool("fjell-fly", [&] { return run(argc, argv); });
}
