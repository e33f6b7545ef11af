// The camera's path as the editor has it: loaded, recorded or laid point by point, edited, played.
//
// Points are metres (ControlPoint: position, direction, up). A path of another kind - orbit, straight, shares of the
// terrain, recorded frames - is played and saved as it is, beside points taken from its flight, and becomes those when
// it is first edited. Points that have times keep them through edits: a new one lies between its neighbours' or as much
// after the last as that is after the one before it, one that goes takes its own along, and one that changes its place
// in the order gets that place's. What an edit, a recording or another file replaces is kept once: restore() swaps the
// two. Thread: the frame's. Memory: a pose is 72 bytes, 60 a second; advance(), follow() and pose() allocate nothing.
// Failure: reading, writing and resampling throw io::Failure and leave the route as it was.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "flight/path.h"

namespace fjell::editor {

inline constexpr std::size_t most_points = 10'000; // of a recording or by hand
inline constexpr double poses_a_second = 60;

class Route {
public:
    [[nodiscard]] bool empty() const { return now_.poses.empty(); }
    [[nodiscard]] const std::string& path() const { return now_.path; } // of the file; empty: never saved
    [[nodiscard]] bool unsaved() const { return now_.unsaved || recorded_points_.size() > 1; }
    [[nodiscard]] const std::vector<flight::ControlPoint>& points() const { return now_.points; }
    [[nodiscard]] const std::vector<double>& times_s() const { return now_.times_s; } // of the points; empty: none
    [[nodiscard]] std::optional<std::size_t> selected() const { return now_.selected; }
    [[nodiscard]] const std::vector<flight::Pose>& poses() const { return now_.poses; } // resampled, 60 a second
    [[nodiscard]] double share() const { return share_; }                               // where it is being played
    [[nodiscard]] bool playing() const { return playing_; }
    [[nodiscard]] bool recording() const { return recording_; }
    [[nodiscard]] std::size_t recorded() const { return recorded_points_.size(); } // points, while recording
    [[nodiscard]] const std::vector<flight::ControlPoint>& recorded_points() const { return recorded_points_; }
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
    [[nodiscard]] bool can_restore() const { return !before_.points.empty(); }

    void open(const std::string& path, const flight::Ground& ground);
    void save(const std::string& path); // empty: where it came from
    void clear();
    void restore(); // what was there before the last edit; again: what was there now

    void play(bool on);
    void seek(double share);
    void loop(bool on) { loops_ = on; }
    // 0 or 1 to flight::max_path_seconds. Times of points are stretched; 0 drops them.
    void set_seconds(double seconds, const flight::Ground& ground);
    // Moves on and says where the camera is; none: not playing. At the end it stops, or begins again.
    std::optional<flight::Pose> advance(double seconds);
    // Where share() is; the path must not be empty. Between two poses, in between.
    [[nodiscard]] flight::Pose pose() const;

    // On: the path that there was stays until off, when what was noted takes its place. Throws Failure (2), and there
    // is no new path, when it has fewer than two points.
    void record(bool on, const flight::Pose& pose, const flight::Ground& ground);
    // While recording: notes a point when the camera has moved or turned enough. False: there is no more room.
    bool follow(const flight::Pose& pose, double seconds);

    void add(const flight::Pose& pose,
             const flight::Ground& ground); // after the selected point, or last; it is selected then
    void replace(std::size_t point, const flight::Pose& pose, const flight::Ground& ground);
    void remove(std::size_t point, const flight::Ground& ground);
    void move(std::size_t point, std::size_t to, const flight::Ground& ground); // so that it becomes the to-th
    [[nodiscard]] flight::Pose select(std::size_t point);

    // route_shapes.cpp. Over that place, as high above the ground as it was. dragging: the same point's next place
    // follows, and all of them are one step for restore().
    void place(std::size_t point, double x_m, double z_m, bool dragging, const flight::Ground& ground);
    // All points look at that place on the ground.
    void aim(double x_m, double z_m, const flight::Ground& ground);
    // Another path: level, once around centre_m, from from_m on and looking inwards; that high above all ground on it.
    void circle(const Vec3& centre_m, const Vec3& from_m, double seconds, double least_above_m,
                const flight::Ground& ground);

private:
    struct Content {
        std::string path;
        std::vector<flight::ControlPoint> points;
        std::vector<double> times_s, shares; // of the points
        std::vector<flight::Pose> poses;
        std::optional<flight::CameraPath> as_read;
        std::optional<std::size_t> selected;
        double seconds = 0;
        bool unsaved = false;
    };
    // Makes the poses and takes it over; what was there can be restored.
    void edit(Content next, const flight::Ground& ground);
    void take_over(Content next);
    void require(std::size_t point) const;
    void record_point(const flight::Pose& pose);

    Content now_, before_;
    std::optional<std::size_t> dragged_; // the point that place() is dragging
    double share_ = 0;
    bool playing_ = false, loops_ = true;
    bool recording_ = false; // what follows: of it
    std::vector<flight::ControlPoint> recorded_points_;
    double step_m_ = 0, recorded_s_ = 0;
};

} // namespace fjell::editor
