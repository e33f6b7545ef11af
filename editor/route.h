// The camera's path as the editor has it: loaded, recorded or laid point by point, edited, played.
//
// Points are metres (ControlPoint: position, direction, up). A path of another kind - orbit, straight, recorded frames -
// is played as it is and turned into points when it is first edited. Thread: the frame's. Failure: reading, writing and
// resampling throw host::Failure and leave the route as it was.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "fly/path.h"

namespace fjell::editor {

class Route {
public:
    [[nodiscard]] bool empty() const { return poses_.empty(); }
    [[nodiscard]] const std::string& path() const { return path_; } // of the file; empty: never saved
    [[nodiscard]] bool unsaved() const { return unsaved_; }
    [[nodiscard]] const std::vector<fly::ControlPoint>& points() const { return points_; }
    [[nodiscard]] std::optional<std::size_t> selected() const { return selected_; }
    [[nodiscard]] const std::vector<fly::Pose>& poses() const { return poses_; } // resampled, 60 a second
    [[nodiscard]] double share() const { return share_; }                       // where it is being played
    [[nodiscard]] bool playing() const { return playing_; }
    [[nodiscard]] bool recording() const { return recording_; }
    [[nodiscard]] double seconds() const { return static_cast<double>(poses_.size()) / 60; }

    void open(const std::string& path, const fly::Ground& ground);
    void save(const std::string& path);
    void clear();

    void play(bool on);
    void seek(double share);
    // Moves on and says where the camera is; none: not playing.
    std::optional<fly::Pose> advance(double seconds);

    void record(bool on, const fly::Pose& pose, const fly::Ground& ground);
    // While recording: notes a point when the camera has moved or turned enough.
    void follow(const fly::Pose& pose);

    void add(const fly::Pose& pose, const fly::Ground& ground); // after the selected point
    void replace(std::size_t point, const fly::Pose& pose, const fly::Ground& ground);
    void remove(std::size_t point, const fly::Ground& ground);
    [[nodiscard]] fly::Pose select(std::size_t point);

private:
    std::string path_;
    std::vector<fly::ControlPoint> points_;
    std::vector<fly::Pose> poses_;
    std::optional<std::size_t> selected_;
    double share_ = 0;
    bool playing_ = false, recording_ = false, unsaved_ = false;
};

} // namespace fjell::editor
