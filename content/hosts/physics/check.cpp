#include "check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace physics {

namespace {

// Bullet's floats: some steps of 2^-14 m, that of numbers up to 1 km.
constexpr double rounding_m = 16.0 / (1 << 14);

// off_m: none is said if it is infinite.
std::string at(const char* what, fjell::Vec3 p, double off_m, double allowed_m) {
    char text[200], off[100] = "";
    if (off_m < INFINITY)
        std::snprintf(off, sizeof off, ": %.3f m off the full-resolution ground, %.3f m allowed", off_m, allowed_m);
    std::snprintf(text, sizeof text, "%s at x %.2f, z %.2f%s", what, p.x, p.z, off);
    return text;
}

} // namespace

// The margin is a distance from the triangle; straight up it is as much more as the ground is steeper. A contact at the
// edge of a hole may be beyond it, by the margin.
void Check::contact(const GroundShape& ground, fjell::Vec3 p) {
    ++contacts_;
    const double margin_m = double(ground_margin_m) + rounding_m;
    const double reported_m = ground.finest() ? 0 : double(ground.error_m());
    double least_m = INFINITY, allowed_m = margin_m + reported_m;
    for (int dz = -1; dz <= 1; ++dz)
        for (int dx = -1; dx <= 1; ++dx) {
            if ((dx != 0 || dz != 0) && least_m < INFINITY) continue; // only beside a hole
            const fjell::GroundHeight full = fjell::ground_height(whole_, p.x + dx * margin_m, p.z + dz * margin_m);
            if (full.hole) continue;
            const double up = std::abs(full.normal.y), slope = std::sqrt(1 - std::min(up * up, 1.0)) / up;
            const double steep = std::max(slope, ground.steepest());
            least_m = std::abs(p.y - full.height_m);
            allowed_m = margin_m * (std::hypot(1, steep) + (dx != 0 || dz != 0 ? 2 * steep : 0)) + reported_m;
        }
    worst_share_ = std::max(worst_share_, least_m / allowed_m);
    if (!(least_m < INFINITY) && broken_.empty()) broken_ = at("a contact over a hole", p, INFINITY, 0);
    if (!(least_m <= allowed_m) && broken_.empty()) broken_ = at("a contact", p, least_m, allowed_m);
}

void Check::contacts(btCollisionWorld& world) {
    btDispatcher& pairs = *world.getDispatcher();
    for (int i = 0; i < pairs.getNumManifolds(); ++i) {
        const btPersistentManifold& pair = *pairs.getManifoldByIndexInternal(i);
        const GroundShape* const first = Patches::ground_of(pair.getBody0());
        const GroundShape* const ground = first != nullptr ? first : Patches::ground_of(pair.getBody1());
        if (ground == nullptr) continue; // two bodies
        for (int k = 0; k < pair.getNumContacts(); ++k) {
            const btManifoldPoint& p = pair.getContactPoint(k);
            contact(*ground, origin_.to_scene(first != nullptr ? p.getPositionWorldOnA() : p.getPositionWorldOnB()));
        }
    }
}

Check::Place Check::place(const btVector3& centre) const {
    const fjell::Vec3 p = origin_.to_scene(centre);
    const fjell::GroundHeight full = fjell::ground_height(whole_, p.x, p.z);
    if (p.y >= full.height_m) return Place::above;
    return full.hole ? Place::in_hole : Place::under;
}

void Check::fell(const btVector3& centre) {
    const fjell::Vec3 p = origin_.to_scene(centre);
    if (broken_.empty())
        broken_ =
            at("a body's centre is under the ground", p, fjell::ground_height(whole_, p.x, p.z).height_m - p.y, 0);
}

} // namespace physics
