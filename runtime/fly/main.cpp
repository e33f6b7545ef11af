// fjell-fly: flies a camera over a pack, in a window or headless. Exit codes: 0 done, 1 the input is at fault, 2 usage,
// 3 the machine (disk, memory, GPU) is.
#include <cerrno>
#include <cstdio>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "fly/headless.h"
#include "fly/options.h"
#include "fly/outputs.h"
#include "fly/window.h"
#include "session/session.h"

namespace {

using namespace fjell;
using namespace fjell::session;
using io::Failure;

// What could not be read is an error of the input, or of the disk, once the flight is over.
void check_reads(const io::PackFile& file, const io::PackStream& streamed) {
    const std::uint64_t corrupt = streamed.corrupt(), unreadable = streamed.unreadable();
    if (corrupt + unreadable == 0) return;
    if (file.changed()) file.fail(EIO);
    throw Failure(corrupt != 0 ? 1 : 3,
                  fmt::format("{} ({} damaged and {} unreadable chunks); it was coarser there; {}",
                              streamed.first_failure(), corrupt, unreadable,
                              corrupt != 0 ? "check it with fjell-bake verify" : "check the disk"));
}

int run(int argc, char** argv) {
    FlightOptions options;
    if (!parse_options(argc, argv, options)) return 0;
    io::catch_interrupts();
    const CameraPath path = path_of(options);
    Outputs outputs(options);
    Session session;
    open_session(options, session);
    if (session.streamed && !options.headless) // whoever looks at it is told at once
        session.on_failure = [](const std::string& line) { fmt::print(stderr, "fjell-fly: {}\n", line); };
    if (!options.replay.empty()) adopt_recorded(session, options.profile);
    const std::size_t frames = options.frames ? options.frames : default_frames;
    std::vector<Pose> poses;
    if (options.replay.empty()) poses = resample(path, session.ground(), frames);
    FlightLog log;
    log.frames.reserve(frames);
    Verification verification;
    Shortfall shortfall;
    try {
        if (options.headless)
            fly_headless(options, session, poses, log, verification, shortfall);
        else
            fly_in_window(options, session, poses, log, verification);
    } catch (const Failure& failure) {
        const std::string kept = outputs.keep_measured(options, log);
        throw Failure(failure.exit_code, failure.what() + kept);
    }
    outputs.finish(options, session, path, log, verification);
    if (session.streamed) check_reads(*session.file, *session.streamed);
    if (shortfall.outputs != 0) {
        const std::string what = shortfall.outputs == 1
                                     ? shortfall.first
                                     : fmt::format("{} (and {} more outputs)", shortfall.first, shortfall.outputs - 1);
        if (shortfall.exit_code != 0) throw Failure(shortfall.exit_code, what);
        fmt::print(stderr, "fjell-fly: {}\n", what);
    }
    if (session.edits && session.edits->totals().refused != 0)
        throw Failure(1, fmt::format("{}: {} ({} stamps refused in all)",
                                     options.edits_path.empty() ? options.replay : options.edits_path,
                                     session.edits->totals().first_refusal, session.edits->totals().refused));
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
