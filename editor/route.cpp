#include "editor/route.h"

#include <algorithm>
#include <cmath>

namespace fjell::editor {

void Route::open(const std::string& path, const fly::Ground& ground) {
    const fly::CameraPath read = fly::read_path(path);
    std::vector<fly::Pose> poses = fly::resample(read, ground);
    *this = {};
    path_ = path;
    poses_ = std::move(poses);
}

void Route::save(const std::string&) {}

void Route::clear() {
    *this = {};
}

void Route::play(bool on) {
    playing_ = on && !poses_.empty();
}

void Route::seek(double share) {
    share_ = std::clamp(share, 0.0, 1.0);
}

std::optional<fly::Pose> Route::advance(double seconds) {
    if (!playing_ || poses_.empty()) return {};
    share_ = std::fmod(share_ + seconds / this->seconds(), 1.0);
    return poses_[std::min(static_cast<std::size_t>(share_ * static_cast<double>(poses_.size())), poses_.size() - 1)];
}

void Route::record(bool, const fly::Pose&, const fly::Ground&) {}
void Route::follow(const fly::Pose&) {}
void Route::add(const fly::Pose&, const fly::Ground&) {}
void Route::replace(std::size_t, const fly::Pose&, const fly::Ground&) {}
void Route::remove(std::size_t, const fly::Ground&) {}
fly::Pose Route::select(std::size_t) {
    return {};
}

} // namespace fjell::editor
