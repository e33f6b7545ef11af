// What the host promises, held against the full-resolution surface, all of it in memory.
#pragma once

#include <cstdint>
#include <string>

#include <btBulletDynamicsCommon.h>

#include <fjell/fjell.h>

#include "patches.h"

namespace physics {

class Check {
public:
    Check(const fjell::Terrain& whole, const Origin& origin) : whole_(whole), origin_(origin) {}

    // Every point at which a body touches the ground, of the last step.
    void contacts(btCollisionWorld& world);
    enum class Place { above, in_hole, under };
    // Of a body's centre.
    [[nodiscard]] Place place(const btVector3& centre) const;
    void fell(const btVector3& centre);

    [[nodiscard]] const std::string& broken() const { return broken_; } // the first promise that was; empty: none
    [[nodiscard]] std::uint64_t contact_count() const { return contacts_; }
    [[nodiscard]] double worst_share() const { return worst_share_; } // of what is allowed

private:
    void contact(const GroundShape& ground, fjell::Vec3 at_m);

    const fjell::Terrain& whole_;
    const Origin& origin_;
    std::string broken_;
    std::uint64_t contacts_ = 0;
    double worst_share_ = 0;
};

} // namespace physics
