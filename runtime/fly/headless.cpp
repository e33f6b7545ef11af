#include "fly/headless.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "fjell/gltf/snapshot.h"
#include "fjell/io/failure.h"
#include "fjell/measure.h"
#include "session/pictures.h"
#include "session/snapshots.h"

namespace fjell::session {

namespace {

using io::Failure;
using Clock = std::chrono::steady_clock;

void write_export(const std::string& path, const FlightOptions& options, const Session& session) {
    const gltf::Snapshot snapshot = options.export_converged ? take_converged(session) : take_frame(session);
    session::write_snapshot(*session.file, snapshot, path,
                            {.texel_m = options.export_texel_m,
                             .colours = options.export_jpeg ? gltf::SnapshotImage::jpeg : gltf::SnapshotImage::png,
                             .quantised = options.export_quantised,
                             .meshopt = options.export_meshopt},
                            {options.layers, options.profile.layers});
}

// Once a second, so that nobody takes a slow disk for a hang.
class Waiting {
public:
    explicit Waiting(std::size_t frame) : frame_(frame) {}
    void show(const FrameEntry& entry) {
        const auto now = Clock::now();
        if (now - shown_ < std::chrono::seconds(1)) return;
        shown_ = now;
        const StreamReport& r = entry.stream;
        fmt::print(stderr, "fjell-fly: frame {} waits: {} pages wanted, {} reads in flight, {:.1f} MB read\n", frame_,
                   r.pages_wanted, r.in_flight, static_cast<double>(r.bytes_read) / 1e6);
    }

private:
    std::size_t frame_;
    Clock::time_point shown_ = Clock::now();
};

// Why, and what to do about it.
std::string remedy(const FlightOptions& options, const StreamReport& r, bool maps) {
    if ((r.exhausted & stream_page_slots) != 0)
        return fmt::format("page_slots ({}) do not suffice; raise them in [stream] of a --profile, or --error-px",
                           r.page_slots.capacity);
    if (maps && (r.exhausted & stream_map_bytes) != 0)
        return "map_mb does not suffice; raise it in [stream] of a --profile";
    if (options.realtime) return "--realtime waits for nothing; leave it out";
    return "no more came from the disk";
}

// What this frame's output lacks. maps: it draws the stream's maps; a snapshot reads its own from the file.
void note_shortfall(const FlightOptions& options, const FrameEntry& entry, const std::string& output, bool maps,
                    Shortfall& shortfall) {
    const StreamReport& r = entry.stream;
    if (!entry.streamed || (r.converged && (r.maps_converged || !maps))) return;
    const bool full = (r.exhausted & (stream_page_slots | stream_map_bytes)) != 0;
    const std::string lacks =
        r.converged ? fmt::format("maps up to {:.3g} levels coarser than the view wants", r.missing_mips)
        : r.missing_px < unbounded_px ? fmt::format("pages that the view wants, which may hide {:.3g} px", r.missing_px)
                                      : "pages that the view wants, which may hide anything";
    if (shortfall.outputs++ == 0)
        shortfall.first = fmt::format("{} lacks {}: {}", output, lacks, remedy(options, r, maps));
    if (!options.realtime) shortfall.exit_code = std::max(shortfall.exit_code, full ? 1 : 3);
}

class HeadlessFlight {
public:
    HeadlessFlight(const FlightOptions& options, Session& session, Shortfall& shortfall)
        : options_(options), session_(session), shortfall_(shortfall), still_(options.profile) {
        if (!options.render_folder.empty()) pictures_.emplace(options, session);
        still_.stream.fade_s = still_.stream.lookahead_s = 0; // while a frame waits, time stands still
    }

    FrameEntry fly(std::size_t frame, const View& view, bool replay) {
        const double now_s = static_cast<double>(frame) / options_.hz;
        if (!replay) begin_frame(session_, frame);
        const auto follow = [&](const FrameEntry& entry) {
            if (pictures_) pictures_->follow(session_, entry);
        };
        if (options_.wait || (waits(frame) && !replay)) {
            Waiting waiting(frame);
            return update_until_there(session_, view, still_, now_s, [&](const FrameEntry& entry) {
                follow(entry);
                waiting.show(entry);
            });
        }
        const FrameEntry entry = replay ? this->replay(frame) : update_frame(session_, view, options_.profile, now_s);
        follow(entry);
        return entry;
    }

    void write(std::size_t frame, const View& view, const FrameEntry& entry) {
        if (drawn(frame)) {
            pictures_->write(session_, view, frame, static_cast<double>(frame) / options_.hz);
            note_shortfall(options_, entry, fmt::format("{}: the picture of frame {}", options_.render_folder, frame),
                           true, shortfall_);
        }
        for (const Export& e : options_.exports) {
            if (e.frame != frame) continue;
            write_export(e.path, options_, session_);
            note_shortfall(options_, entry, fmt::format("{}: frame {}", e.path, frame), false, shortfall_);
        }
    }

private:
    [[nodiscard]] bool drawn(std::size_t frame) const { return pictures_ && frame % options_.render_every == 0; }
    FrameEntry replay(std::size_t frame) {
        try {
            return replay_frame(session_, frame);
        } catch (const Failure& failure) {
            throw Failure(failure.exit_code, fmt::format("{}: {}", options_.replay, failure.what()));
        }
    }
    [[nodiscard]] bool waits(std::size_t frame) const {
        return session_.streamed && !options_.realtime &&
               (drawn(frame) ||
                std::ranges::any_of(options_.exports, [&](const Export& e) { return e.frame == frame; }));
    }

    const FlightOptions& options_;
    Session& session_;
    Shortfall& shortfall_;
    Profile still_;
    std::optional<Pictures> pictures_;
};

} // namespace

void fly_headless(const FlightOptions& options, Session& session, std::span<const Pose> poses, FlightLog& log,
                  Verification& verification, Shortfall& shortfall) {
    HeadlessFlight flight(options, session, shortfall);
    const Profile& profile = options.profile;
    const bool replay = !options.replay.empty();
    const auto start = Clock::now();
    for (std::size_t frame = 0; frame < (replay ? session.recording->frames.size() : poses.size()); ++frame) {
        io::check_interrupt();
        const View view =
            replay ? session.recording->frames[frame].views[0] : view_of(poses[frame], session.terrain(), profile);
        if (options.realtime)
            std::this_thread::sleep_until(start +
                                          std::chrono::duration_cast<Clock::duration>(
                                              std::chrono::duration<double>(static_cast<double>(frame) / options.hz)));
        FrameEntry entry = flight.fly(frame, view, replay);
        if (options.verify_every && frame % options.verify_every == 0)
            verify_frame(session, view, profile, frame, entry, verification);
        flight.write(frame, view, entry);
        log.frames.push_back(entry);
    }
}

} // namespace fjell::session
