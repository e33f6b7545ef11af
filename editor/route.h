// The camera's path as the editor has it: loaded, recorded or laid point by point, edited, played.
//
// Points are metres (ControlPoint: position, direction, up). A path of another kind - orbit, straight, shares of the
// terrain, recorded frames - is played and saved as it is, beside points taken from its flight, and becomes those when
// it is first edited.
//
// Every edit, recording, opening or clearing is a step of undo(); so is a drag, however many changes it makes, unless
// it ends where it began. Thread: the frame's. Memory: a pose is 72 bytes, 60 a second; the last 100 steps are kept, or
// as many as 64 MB hold; advance(), follow() and pose() allocate nothing. Failure: reading, writing and resampling
// throw io::Failure and leave the route as it was.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "session/path.h"

namespace fjell::editor {

inline constexpr std::size_t most_points = 10'000; // of a recording or by hand
inline constexpr double poses_a_second = 60;

// What a flight along a path is called: "the path valley.json", "the camera path" where it was never saved, "an orbit"
// where there is none. On the stack, so that panels allocate nothing.
struct FlightName {
    char text[96];
};

class Route {
public:
    [[nodiscard]] bool empty() const { return now_.poses.empty(); }
    [[nodiscard]] FlightName flight_name() const;
    [[nodiscard]] const std::string& path() const { return now_.path; } // of the file; empty: never saved
    [[nodiscard]] bool unsaved() const { return now_.unsaved || recorded_points_.size() > 1; }
    // Would be lost with what is recorded now in its place.
    [[nodiscard]] bool unsaved_before_recording() const { return now_.unsaved && !now_.points.empty(); }
    [[nodiscard]] const std::vector<session::ControlPoint>& points() const { return now_.points; }
    [[nodiscard]] std::optional<std::size_t> selected() const { return now_.selected; }
    [[nodiscard]] const std::vector<session::Pose>& poses() const { return now_.poses; } // resampled, 60 a second
    [[nodiscard]] double share() const { return share_; }                                // where it is being played
    [[nodiscard]] bool playing() const { return playing_; }
    [[nodiscard]] bool recording() const { return recording_; }
    [[nodiscard]] std::size_t recorded() const { return recorded_points_.size(); } // points, while recording
    [[nodiscard]] const std::vector<session::ControlPoint>& recorded_points() const { return recorded_points_; }
    [[nodiscard]] bool loops() const { return loops_; }
    [[nodiscard]] double seconds() const { return static_cast<double>(now_.poses.size()) / poses_a_second; }
    // That it shall take; 0: as long as its way at a sixtieth of the terrain's longer extent a second.
    [[nodiscard]] double requested_seconds() const { return now_.seconds; }
    // Where a point lies in the path's time, 0..1.
    [[nodiscard]] double share_of(std::size_t point) const {
        return point < now_.shares.size() ? now_.shares[point] : 0;
    }
    // Not points yet: an orbit, say, as it was read.
    [[nodiscard]] bool as_read() const { return now_.as_read.has_value(); }

    void open(const std::string& path, const session::Ground& ground);
    void save(const std::string& path); // empty: where it came from
    void clear();
    // Throw Failure (2) when there is nothing to take back, or to repeat.
    void undo();
    void redo();
    void restore(); // undoes; again: redoes
    [[nodiscard]] std::size_t undo_steps() const { return undo_.size(); }
    [[nodiscard]] std::size_t redo_steps() const { return redo_.size(); }
    [[nodiscard]] bool can_restore() const { return !undo_.empty() || !redo_.empty(); }
    // Of the next step back, or forward (next_edit_stamp(), editor/document.h); 0: there is none.
    [[nodiscard]] std::uint64_t undo_stamp() const { return undo_.empty() ? 0 : undo_.back().stamp; }
    [[nodiscard]] std::uint64_t redo_stamp() const { return redo_.empty() ? 0 : redo_.back().stamp; }

    void play(bool on);
    void seek(double share);
    void loop(bool on) { loops_ = on; }
    void set_seconds(double seconds, const session::Ground& ground); // 0 or 1 to session::max_path_seconds
    // Moves on and says where the camera is; none: not playing. At the end it stops, or begins again.
    std::optional<session::Pose> advance(double seconds);
    // Where share() is; the path must not be empty. Between two poses, in between.
    [[nodiscard]] session::Pose pose() const { return pose_at(share_); }
    [[nodiscard]] session::Pose pose_at(double share) const;

    // On: the path that there was stays until off, when what was noted takes its place. Throws Failure (2), and there
    // is no new path, when it has fewer than two points.
    void record(bool on, const session::Pose& pose, const session::Ground& ground);
    // While recording: notes a point when the camera has moved or turned enough. False: there is no more room.
    bool follow(const session::Pose& pose, double seconds);

    // After the selected point, or last; it is selected then.
    void add(const session::Pose& pose, const session::Ground& ground);
    // Where the path is at that share of its time; it is selected then.
    void insert(double share, const session::Ground& ground);
    void replace(std::size_t point, const session::Pose& pose, const session::Ground& ground);
    void remove(std::size_t point, const session::Ground& ground);
    void move(std::size_t point, std::size_t to, const session::Ground& ground); // so that it becomes the to-th
    // Over that place: at that height, if it is above the ground, or else as high above it as it was. dragging: more of
    // the same follows, and all of it is one step.
    void place(std::size_t point, double x_m, double z_m, bool dragging, const session::Ground& ground,
               std::optional<double> y_m = {});
    session::Pose select(std::size_t point);

private:
    struct Content {
        std::string path;
        std::vector<session::ControlPoint> points;
        std::vector<double> shares; // of the points
        std::vector<session::Pose> poses;
        std::optional<session::CameraPath> as_read;
        std::optional<std::size_t> selected;
        double seconds = 0;
        bool unsaved = false;
    };
    struct Step {
        Content content;
        std::uint64_t stamp = 0;
    };
    [[nodiscard]] static session::CameraPath path_of(const Content& content, double seconds);
    static void complete(Content& next, const session::Ground& ground); // makes the poses, and all that follows
    void edit(Content next, const session::Ground& ground);             // makes the poses and takes it over
    void take_over(Content next);
    void exchange(std::vector<Step>& from, std::vector<Step>& to, const char* none);
    void require(std::size_t point) const;

    Content now_;
    std::vector<Step> undo_, redo_;
    std::optional<std::size_t> held_, ignored_; // a point; ignored_: held still, but what was done to it was undone
    double share_ = 0;
    bool playing_ = false, loops_ = true;
    bool recording_ = false; // what follows: of it
    std::vector<session::ControlPoint> recorded_points_;
    double step_m_ = 0, recorded_s_ = 0;
};

} // namespace fjell::editor
