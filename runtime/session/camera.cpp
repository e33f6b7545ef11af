#include "session/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fjell::session {

namespace {

constexpr double steepest = 1.5; // rad; straight up and down have no heading
constexpr double turn_rad_s = 0.9;

Vec3 direction_of(const FreeCamera& c) {
    return {std::sin(c.heading) * std::cos(c.pitch), std::sin(c.pitch), -std::cos(c.heading) * std::cos(c.pitch)};
}

} // namespace

Pose FreeCamera::pose() const {
    const Vec3 direction = direction_of(*this);
    return {position_m, direction, normalised(Vec3{0, 1, 0} - direction * direction.y)};
}

FreeCamera free_camera(const Pose& pose, double speed_m_s) {
    FreeCamera c;
    c.position_m = pose.position_m;
    c.heading = std::atan2(pose.direction.x, -pose.direction.z);
    c.pitch = std::clamp(std::asin(std::clamp(pose.direction.y, -1.0, 1.0)), -steepest, steepest);
    c.speed_m_s = speed_m_s;
    return c;
}

void look(FreeCamera& c, double right_rad, double up_rad) {
    c.heading = std::remainder(c.heading + right_rad, 2 * std::numbers::pi);
    c.pitch = std::clamp(c.pitch + up_rad, -steepest, steepest);
}

void steer(FreeCamera& c, const Steering& s, double seconds, const Ground& ground, double least_above_m) {
    look(c, s.turn_right * turn_rad_s * seconds, s.turn_up * turn_rad_s * seconds);
    const Vec3 forward = direction_of(c), right{std::cos(c.heading), 0, std::sin(c.heading)};
    const Vec3 way = forward * s.forward + right * s.right + Vec3{0, 1, 0} * s.up;
    c.position_m = c.position_m + way * (c.speed_m_s * seconds);
    const double reach = 10 * ground.longer_m();
    c.position_m.x = std::clamp(c.position_m.x, -reach, ground.extent_x_m + reach);
    c.position_m.z = std::clamp(c.position_m.z, -reach, ground.extent_z_m + reach);
    const double floor_m = ground.height_m(c.position_m.x, c.position_m.z) + least_above_m;
    c.position_m.y = std::clamp(c.position_m.y, floor_m, floor_m + reach);
}

} // namespace fjell::session
