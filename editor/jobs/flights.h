// Flights that are measured beside the frame, over a terrain of their own: for tuning and benchmarks.
//
// The terrain is loaded, or streamed, as the profile says, from the file that is open: not from what its name leads to
// by now. A streamed flight waits in every frame until all that its
// view wants is there, so that the disk does not count; of the updates that this takes, the dearest is the frame's, as
// it would be where each is a frame of its own. The picture has the size of the profile's [view], whatever the window
// has, so a result holds for every machine that flies the profile.
//
// Ownership: terrain, method and, where it draws, a headless context, all of it its own. Thread: the one that makes it,
// beginning to end. Failure: io::Failure; Cancelled within a frame.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "editor/jobs/jobs.h"
#include "fjell/io/pack_file.h"
#include "fjell/profile.h"
#include "fjell/profile/keys.h"
#include "session/log.h"
#include "session/path.h"

namespace fjell::editor {

struct MeasuredFlightPlan {
    std::shared_ptr<const io::PackFile> pack; // of the terrain that is shown
    Profile profile;
    std::vector<session::Pose> route; // 60 a second; empty: an orbit around the terrain's middle
    std::size_t frames = 0;           // 0: as many as the route has
    bool draws = false;               // with upload, drawing and the GPU's work
    std::string profile_name{};       // for people
    std::string flight_name{};        // for people: what the route is called (Route::flight_name)
    bool measures = false;            // errors too: a streamed terrain is read whole for them
};

// What a frame took, microseconds; upload and drawing only where the plan draws.
struct FlownTimes {
    double update_us = 0, upload_us = 0, draw_us = 0; // update: with the stream's
    [[nodiscard]] double all_us() const { return update_us + upload_us + draw_us; }
};

// The route in so many frames, from its first pose to its last; directions in between are orthonormal.
[[nodiscard]] std::vector<session::Pose> in_frames(const std::vector<session::Pose>& route, std::size_t frames);

class MeasuredFlight {
public:
    MeasuredFlight(MeasuredFlightPlan plan, JobControl& control);
    ~MeasuredFlight();
    MeasuredFlight(const MeasuredFlight&) = delete;
    MeasuredFlight& operator=(const MeasuredFlight&) = delete;

    [[nodiscard]] std::size_t frames() const;
    [[nodiscard]] const std::vector<session::Pose>& poses() const;
    [[nodiscard]] bool incremental() const;
    [[nodiscard]] double error_px() const; // the profile's
    // From the first pose to the last, the first frame built from nothing. each: after every frame, with what it took
    // and its number.
    using Each = std::function<void(const session::FrameEntry& entry, const FlownTimes& times, std::size_t frame)>;
    void fly(double error_px, const Each& each);
    // Within each(): the error on screen of the frame's mesh, measured at every sample (session::verify_frame()).
    void measure(session::FrameEntry& entry, std::size_t frame);
    [[nodiscard]] double samples() const; // of the terrain
    // Of the profile, for the flights that follow: a key that rebuilds nothing.
    void set(const ProfileKey& key, double value);
    [[nodiscard]] double get(const ProfileKey& key) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace fjell::editor
