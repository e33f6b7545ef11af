// Spheres, boxes and wheels that are dropped side by side.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include <fjell/fjell.h>

#include "../ground/streamed_ground.h"
#include "check.h"
#include "patches.h"

namespace physics {

struct Body {
    std::unique_ptr<btRigidBody> rigid;
    bool placed = false;   // it has had ground to be dropped on
    bool in_world = false; // it moves; otherwise it is held, because its ground is not loaded
    bool through = false;  // it has fallen through a hole
    double rolled_m = 0;
    [[nodiscard]] const btVector3& centre() const { return rigid->getWorldTransform().getOrigin(); }
};

class Bodies {
public:
    Bodies(btDiscreteDynamicsWorld& world, const fjell::Terrain& terrain, const Origin& origin);
    ~Bodies();
    Bodies(const Bodies&) = delete;
    Bodies& operator=(const Bodies&) = delete;

    // Before a step: asks for the ground of each, and holds those whose ground is not good enough yet.
    void hold_or_release(Patches& patches);
    // After it: what has rolled how far, and what has fallen.
    void look(Check& check, double step_s);
    void wake();
    // A stream looks through a few views only: each sees the ground around an equal share of the bodies, from west to
    // east.
    void views(std::span<fjell::View> out, double accuracy_m);

    [[nodiscard]] std::span<const Body> all() const { return bodies_; }
    [[nodiscard]] std::uint64_t held_steps() const { return held_steps_; }

private:
    void place(Body& body);

    btDiscreteDynamicsWorld& world_;
    const fjell::Terrain& terrain_;
    const Origin& origin_;
    btSphereShape sphere_{0.5f};
    btBoxShape box_{btVector3(0.6f, 0.4f, 0.5f)};
    btCylinderShapeX wheel_{btVector3(0.2f, 0.5f, 0.5f)};
    std::vector<Body> bodies_;
    std::vector<Body*> from_west_;
    std::uint64_t held_steps_ = 0;
};

} // namespace physics
