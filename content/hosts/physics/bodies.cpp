#include "bodies.h"

#include <algorithm>
#include <cmath>

namespace physics {

namespace {

constexpr int count = 200;
constexpr double drop_m = 1.5;
constexpr btScalar radius_m = 0.9f; // of the largest
constexpr btScalar mass_kg = 20;

} // namespace

Bodies::Bodies(btDiscreteDynamicsWorld& world, const fjell::Terrain& terrain, const Origin& origin)
    : world_(world), terrain_(terrain), origin_(origin) {
    btCollisionShape* const shapes[] = {&sphere_, &box_, &wheel_, &sphere_};
    for (int i = 0; i < count; ++i) {
        btCollisionShape* const shape = shapes[i % 4];
        btVector3 inertia;
        shape->calculateLocalInertia(mass_kg, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass_kg, nullptr, shape, inertia);
        info.m_friction = 0.4f;
        info.m_linearDamping = 0.25f; // the air: nothing moves by more than its size in a step
        const double x = terrain.extent_x_m() / 12 + 4.3 * (i % 10), z = terrain.extent_z_m() / 2 + 7.7 * (i / 10 - 10);
        Body body;
        body.rigid = std::make_unique<btRigidBody>(info);
        body.rigid->setWorldTransform(
            btTransform(btQuaternion(btVector3(0, 1, 0), btScalar(i)), origin.to_bullet({x, origin.scene_m.y, z})));
        bodies_.push_back(std::move(body));
    }
    for (Body& body : bodies_) from_west_.push_back(&body);
}

Bodies::~Bodies() {
    for (const Body& body : bodies_)
        if (body.in_world) world_.removeRigidBody(body.rigid.get());
}

// Above the ground, now that it is known.
void Bodies::place(Body& body) {
    fjell::Vec3 at = origin_.to_scene(body.centre());
    const fjell::GroundHeight ground = fjell::ground_height(terrain_, at.x, at.z);
    at.y = ground.height_m + double(ground.error_m) + drop_m;
    btTransform where = body.rigid->getWorldTransform();
    where.setOrigin(origin_.to_bullet(at));
    body.rigid->setWorldTransform(where);
    body.rigid->setInterpolationWorldTransform(where);
    body.placed = true;
}

void Bodies::hold_or_release(Patches& patches) {
    for (Body& body : bodies_) {
        if (body.through) continue;
        // As far as it can come before the ground would have to be read: a quarter of a second.
        const fjell::Vec3 at = origin_.to_scene(body.centre());
        const double around_m = double(radius_m) + 0.25 * double(body.rigid->getLinearVelocity().length());
        const fjell::Vec3 reach{around_m, 0, around_m};
        const bool ground = patches.want(at - reach, at + reach);
        if (ground && !body.in_world) {
            if (!body.placed) place(body);
            world_.addRigidBody(body.rigid.get()); // with the speed that it had
        }
        if (!ground && body.in_world) world_.removeRigidBody(body.rigid.get());
        body.in_world = ground;
        held_steps_ += !ground;
    }
}

void Bodies::look(Check& check, double step_s) {
    for (Body& body : bodies_) {
        if (!body.in_world) continue;
        body.rolled_m += double(body.rigid->getLinearVelocity().length()) * step_s;
        const Check::Place place = check.place(body.centre());
        if (place == Check::Place::above) continue;
        if (place == Check::Place::under) check.fell(body.centre());
        body.through = true;
        body.in_world = false;
        world_.removeRigidBody(body.rigid.get());
    }
}

void Bodies::wake() {
    for (const Body& body : bodies_) body.rigid->activate();
}

void Bodies::views(std::span<fjell::View> out, double accuracy_m) {
    std::sort(from_west_.begin(), from_west_.end(), [](const Body* a, const Body* b) {
        return a->centre().x() != b->centre().x() ? a->centre().x() < b->centre().x() : a < b;
    });
    const std::size_t each = (from_west_.size() + out.size() - 1) / out.size();
    for (std::size_t i = 0; i < out.size(); ++i) {
        const std::span<Body* const> group(&from_west_[i * each], std::min(each, from_west_.size() - i * each));
        btVector3 middle(0, 0, 0);
        for (const Body* body : group) middle += body->centre() / btScalar(group.size());
        double reach_m = 0;
        for (const Body* body : group) reach_m = std::max(reach_m, double(body->centre().distance(middle)));
        fjell::Vec3 place = origin_.to_scene(middle);
        place.y = fjell::ground_height(terrain_, place.x, place.z).height_m;       // distances are in space
        const double patch_m = 1.5 * patch_cells * double(terrain_.spacing_x_m()); // a patch's diagonal, about
        out[i] = ground::focus(place, reach_m + patch_m, accuracy_m);
    }
}

} // namespace physics
