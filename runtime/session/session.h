// A terrain, loaded whole or streamed, with the method that refines it - incremental or recursive - and one frame of a
// flight over it.
//
// Ownership: a Session owns the file's bytes, the records, the method and the stream. Thread: one. Failure:
// io::Failure, 1 for an unusable pack, view or budget, 3 when memory is short.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "fjell/io/load.h"
#include "fjell/measure.h"
#include "fjell/query.h"
#include "io/pack_stream.h"
#include "session/file_ground.h"
#include "session/flight_edits.h"
#include "session/log.h"
#include "session/methods/method.h"
#include "session/options.h"
#include "session/path.h"
#include "session/record.h"

namespace fjell::session {

struct Session {
    // The pack and its terrain. Streamed: without the file's bytes, and pages come and go. Replaying a streamed flight:
    // with them, and pages come and go as recorded.
    io::LoadedPack loaded;
    std::size_t terrain_bytes = 0;
    std::unique_ptr<io::LoadedPack> reference; // loaded whole to measure against, where `loaded` is not
    std::shared_ptr<const io::PackFile> file;  // open as long as the session, and whoever else wants this pack
    std::unique_ptr<FileGround> file_ground;   // of a streamed pack: for camera paths
    std::optional<Area> start;                 // of a sparse terrain
    std::unique_ptr<FlightEdits> edits;        // of moving ground; null: it stays as it is
    std::unique_ptr<RunningMethod> method;
    std::optional<Recording> recording; // of --record, frame by frame; or what --replay repeats
    bool begun = false;                 // a frame was updated, or the first one shall be like any other
    double load_seconds = 0;
    std::chrono::steady_clock::time_point started; // when opening was done
    // Hears of the first chunk that could not be read or was damaged, within update_frame(): "PACK: page 3 of tile 1:
    // why". A damaged pack may have hundreds of them: the others are counted.
    std::function<void(const std::string&)> on_failure;
    std::unique_ptr<io::PackStream> streamed; // last: its thread stops before what it streams into goes

    [[nodiscard]] const Terrain& terrain() const { return loaded.terrain; }
    [[nodiscard]] const Terrain& whole_terrain() const { return reference ? reference->terrain : loaded.terrain; }
    // At full resolution, also where no page is there yet; of a streamed pack by reading the file.
    [[nodiscard]] Ground ground() const {
        Ground ground = file_ground ? ground_of(*file_ground, loaded.terrain) : ground_of(loaded.terrain);
        ground.start = start;
        return ground;
    }
    // For the frame's thread: as fine as it is there.
    [[nodiscard]] Ground live_ground() const {
        Ground ground = ground_of(loaded.terrain);
        ground.start = start;
        if (streamed)
            ground.height_m = [this](double x_m, double z_m) { return ground_height(terrain(), x_m, z_m).height_m; };
        return ground;
    }
    // Of the last update.
    [[nodiscard]] MeshView mesh() const { return method->mesh().mesh; }
};
// The Session is filled in place, because the method points into its terrain.
void open_session(const FlightOptions& options, Session& session);

// Another method, or other budgets, for an open session: options.profile's method, cut_budget and budget, whatever they
// were before. The terrain stays, and so does everything that points into it; a renderer was created for the old
// budgets and must be recreated. begun is false afterwards: the next update builds from scratch. Both methods' memory
// is allocated until the new one is created, so that a Failure leaves the session as it was and able to go on: 1 for
// unusable budgets or an unusable pack, 3 when memory is short. Neither for a streamed session, whose stream feeds the
// method it was begun with, nor for one that records or replays, which one budget holds for: those must be reopened,
// and here they are a Failure (1).
void remake_method(const FlightOptions& options, Session& session);

// The path the options ask for: a file, a seed's, or an orbit.
[[nodiscard]] CameraPath path_of(const FlightOptions& options);

// The far plane lies behind the terrain's farthest corner; the near one a twentieth of a cell ahead, and half a
// metre at most: depth is reversed and float, so their ratio costs nothing.
[[nodiscard]] View view_of(const Pose& pose, const Terrain& terrain, const Profile& profile);

// Stamps that are due in this frame of the flight are pushed from its next update on.
void begin_frame(Session& session, std::size_t frame);

// Times one update; of a streamed pack the stream's first. The incremental method builds its first frame from scratch
// in one go, whatever the profile allows a frame; with --items or --budget-us it starts from the coarsest mesh instead,
// like an engine that must not miss one. now_s: for morphing.
[[nodiscard]] FrameEntry update_frame(Session& session, const View& view, const Profile& profile, double now_s);

// The same again and again until everything that the view wants is there, nothing is in flight any more, or nothing has
// come for some seconds. each: after every update, with what it did.
[[nodiscard]] FrameEntry update_until_there(Session& session, const View& view, const Profile& profile, double now_s,
                                            const std::function<void(const FrameEntry&)>& each);

// What the session's recording was flown with, as far as its first frame says: threshold, method, morphing, items,
// viewport and field of view. The profile's are then true of the replay.
void adopt_recorded(const Session& session, Profile& profile);

// One frame of the session's recording, and whether the mesh is the recorded one. Throws Failure (1) when it is not.
[[nodiscard]] FrameEntry replay_frame(Session& session, std::size_t frame);

// What --verify found so far. Samples are the pack's: errors bound those as well as the original heights.
struct Verification {
    bool exceeded = false;
    std::size_t frame = 0; // of the frame that came nearest to its limit, or exceeded it most
    double max_px = 0, limit_px = 0;
};
// Measures the mesh of the last update at every sample of the whole terrain (inside the frustum, unless all was drawn)
// against the effective threshold, which is the requested one in a converged frame. A frame that lags is measured and
// promises nothing. Of moving ground the samples are the edited ones. O(samples).
void verify_frame(const Session& session, const View& view, const Profile& profile, std::size_t frame,
                  FrameEntry& entry, Verification& verification);

} // namespace fjell::session
