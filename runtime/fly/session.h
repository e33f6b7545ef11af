// A loaded terrain with the method that refines it - incremental or recursive - and one frame of a flight over it.
//
// Ownership: a Session owns the file's bytes, the records and the method's block. Thread: one. Failure: host::Failure,
// 1 for a pack, a view or a budget that does not do, 3 when memory is short.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "fjell/cut.h"
#include "fjell/measure.h"
#include "fjell/recursive.h"
#include "fly/log.h"
#include "fly/options.h"
#include "fly/path.h"
#include "fly/record.h"
#include "host/load.h"

namespace fjell::fly {

struct Session {
    host::LoadedPack loaded;
    host::AlignedBlock block;
    std::size_t block_bytes = 0;
    Method method = Method::incremental;
    RecursiveMethod recursive; // one of the two
    LiveCut cut;
    CutBudget cut_budget;               // the profile's, with chunks to suit the terrain
    std::optional<Recording> recording; // of --record, frame by frame; or what --replay repeats
    bool begun = false;                 // a frame was updated, or the first one shall be like any other
    double load_seconds = 0;

    [[nodiscard]] const Terrain& terrain() const { return loaded.terrain; }
    [[nodiscard]] bool incremental() const { return method == Method::incremental; }
    // Of the last update.
    [[nodiscard]] MeshView mesh() const { return incremental() ? cut_mesh(cut).mesh : recursive_mesh(recursive); }
};
// The Session is filled in place, because the method points into its terrain.
void open_session(const Options& options, Session& session);

// The path the options ask for: a file, a seed's, or an orbit.
[[nodiscard]] CameraPath path_of(const Options& options);

// The far plane lies behind the terrain's farthest corner; the near one a twentieth of a cell ahead: depth is reversed
// and float, so their ratio costs nothing.
[[nodiscard]] View view_of(const Pose& pose, const Terrain& terrain, const Profile& profile);

// Times one update. The incremental method builds its first frame from nothing in one go, whatever the profile allows a
// frame; with --items or --budget-us it starts from the coarsest mesh instead, like an engine that must not miss one.
// now_s: for morphing.
[[nodiscard]] FrameEntry update_frame(Session& session, const View& view, const Profile& profile, double now_s);

// One frame of the session's recording, and whether the mesh is the recorded one. Throws Failure (1) when it is not.
[[nodiscard]] FrameEntry replay_frame(Session& session, std::size_t frame);

// What --verify found so far. Samples are the pack's: errors bound those as well as the original heights.
struct Verification {
    bool exceeded = false;
    std::size_t frame = 0; // of the frame that came nearest to its limit, or exceeded it most
    double max_px = 0, limit_px = 0;
};
// Measures the mesh of the last update at every sample (inside the frustum, unless all was drawn) against the effective
// threshold, which is the asked one in a converged frame. A frame that lags is measured and promises nothing.
// O(samples).
void verify_frame(const Session& session, const View& view, const Profile& profile, std::size_t frame,
                  FrameEntry& entry, Verification& verification);

} // namespace fjell::fly
