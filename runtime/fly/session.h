// A loaded terrain with a method that refines it, and one frame of a flight over it.
//
// Ownership: a Session owns the file's bytes, the records and the method's block. Thread: one. Failure: host::Failure,
// 1 for a pack, a view or a budget that does not do, 3 when memory is short.
#pragma once

#include <cstddef>
#include <string>

#include "fjell/measure.h"
#include "fjell/recursive.h"
#include "fly/log.h"
#include "fly/options.h"
#include "fly/path.h"
#include "host/load.h"

namespace fjell::fly {

struct Session {
    host::LoadedPack loaded;
    host::AlignedBlock block;
    std::size_t block_bytes = 0;
    RecursiveMethod method;
    double load_seconds = 0;

    [[nodiscard]] const Terrain& terrain() const { return loaded.terrain; }
};
// The Session is filled in place, because the method points into its terrain.
void open_session(const Options& options, Session& session);

// The path the options ask for: a file, a seed's, or an orbit.
[[nodiscard]] CameraPath path_of(const Options& options);

// The far plane lies behind the terrain's farthest corner; the near one a twentieth of a cell ahead: depth is reversed
// and float, so their ratio costs nothing.
[[nodiscard]] View view_of(const Pose& pose, const Terrain& terrain, const Profile& profile);

// Times one update.
[[nodiscard]] FrameEntry update_frame(Session& session, const View& view, const RefineSettings& settings);

// What --verify found so far. Samples are the pack's: errors bound those as well as the original heights.
struct Verification {
    bool exceeded = false;
    std::size_t frame = 0; // of the frame that came nearest to its limit, or exceeded it most
    double max_px = 0, limit_px = 0;
};
// Measures the mesh of the last update at every sample (inside the frustum, when it was culled) against the effective
// threshold, which is the asked one in a converged frame. O(samples).
void verify_frame(const Session& session, const View& view, const RefineSettings& settings, std::size_t frame,
                  FrameEntry& entry, Verification& verification);

} // namespace fjell::fly
