// fjell-fly: flies a camera over a pack, in a window or headless. Exit codes: 0 done, 1 the input is at fault, 2 usage,
// 3 the machine (disk, memory, GPU) is.
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "fly/options.h"
#include "fly/outputs.h"
#include "fly/pictures.h"
#include "fly/session.h"
#include "fly/window.h"
#include "gltf/snapshot.h"
#include "host/failure.h"

namespace {

using namespace fjell;
using namespace fjell::fly;
using host::Failure;

// What a frame that lags would show in the end: the snapshot refines anew, to the frame's effective threshold.
void export_frame(const Export& e, const Session& session, const View& view, const RefineSettings& settings,
                  double effective_px) {
    const double error_px = effective_px / (settings.corner_safe ? corner_factor(view) : 1);
    const gltf::SnapshotResult result =
        gltf::export_snapshot(session.loaded.pack, session.terrain(), view, error_px, e.path);
    if (!result.ok()) throw Failure(result.exit_code, result.message);
}

void fly_headless(const Options& options, Session& session, std::span<const Pose> poses, FlightLog& log,
                  Verification& verification) {
    std::optional<Pictures> pictures;
    if (!options.render_folder.empty()) pictures.emplace(options, session);
    const Profile& profile = options.profile;
    const bool replay = !options.replay.empty();
    for (std::size_t frame = 0; frame < (replay ? session.recording->frames.size() : poses.size()); ++frame) {
        host::check_interrupt();
        const View view =
            replay ? session.recording->frames[frame].views[0] : view_of(poses[frame], session.terrain(), profile);
        FrameEntry entry = replay ? replay_frame(session, frame)
                                  : update_frame(session, view, profile, static_cast<double>(frame) / options.hz);
        if (options.verify_every && frame % options.verify_every == 0)
            verify_frame(session, view, profile, frame, entry, verification);
        if (pictures) pictures->follow(session, entry);
        if (pictures && frame % options.render_every == 0) pictures->write(session, view, frame);
        for (const Export& e : options.exports)
            if (e.frame == frame) export_frame(e, session, view, profile.refine, entry.error_px_effective);
        log.frames.push_back(entry);
    }
}

int run(int argc, char** argv) {
    Options options;
    if (!parse_options(argc, argv, options)) return 0;
    host::catch_interrupts();
    const CameraPath path = path_of(options);
    Outputs outputs(options);
    Session session;
    open_session(options, session);
    if (!options.replay.empty()) options.profile.refine.error_px = session.recording->frames[0].settings.error_px;
    const std::size_t frames = options.frames ? options.frames : default_frames;
    const std::vector<Pose> poses = resample(path, ground_of(session.terrain()), frames);
    FlightLog log;
    log.frames.reserve(frames);
    Verification verification;
    if (options.headless)
        fly_headless(options, session, poses, log, verification);
    else
        fly_in_window(options, session, poses, log, verification);
    outputs.finish(options, session, path, log, verification);
    if (verification.exceeded)
        throw Failure(
            1, fmt::format(
                   "{}: frame {}: {:.4f} px measured where {:.4f} are allowed; check the pack with fjell-bake verify",
                   options.pack, verification.frame, verification.max_px, verification.limit_px));
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return host::run_tool("fjell-fly", [&] { return run(argc, argv); });
}
