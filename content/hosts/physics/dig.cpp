#include "dig.h"

#include <btBulletDynamicsCommon.h>

#include "check.h"
#include "patches.h"

namespace physics {

namespace {

constexpr double step_s = 1.0 / 60, depth_m = 4, radius_m = 9, falloff_m = 5, still_m_s = 0.02;
constexpr int most_steps = 3000, still_for = 30, requests_per_step = 8;
constexpr btScalar mass_kg = 20;

// Where there is no hole within reach, nor the rim.
fjell::Vec3 whole_place(const fjell::Terrain& whole) {
    const auto is_whole = [&](double x, double z) {
        for (double dz = -24; dz <= 24; dz += 2)
            for (double dx = -24; dx <= 24; dx += 2) {
                const fjell::GroundHeight g = fjell::ground_height(whole, x + dx, z + dz);
                if (!g.inside || g.hole) return false;
            }
        return true;
    };
    for (int i = 0; i < 100; ++i) {
        const double x = whole.extent_x_m() * (0.3 + 0.004 * i), z = whole.extent_z_m() / 2;
        if (is_whole(x, z)) return {x, fjell::ground_height(whole, x, z).height_m, z};
    }
    return {whole.extent_x_m() / 2, 0, whole.extent_z_m() / 2};
}

class Digging {
public:
    Digging(ground::StreamedGround& ground, ground::Yardstick& whole, double accuracy_m, float good_m)
        : ground_(ground), whole_(whole), accuracy_m_(accuracy_m),
          place_(whole_place(whole.terrain())), origin_{place_}, patches_(world_, ground.terrain(), origin_, good_m),
          check_(whole.terrain(), origin_) {
        world_.setGravity(btVector3(0, -9.81f, 0));
        btVector3 inertia;
        box_.calculateLocalInertia(mass_kg, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass_kg, nullptr, &box_, inertia);
        info.m_friction = 1.5f; // it stays where it is on a slope
        info.m_angularDamping = 0.3f;
        body_ = std::make_unique<btRigidBody>(info);
    }
    ~Digging() { leave(); }
    Digging(const Digging&) = delete;
    Digging& operator=(const Digging&) = delete;

    Dug run() {
        if (!rest(dug_.still_steps)) return fail("the body does not come to rest on the ground as it was");
        const double before_m = centre().y;
        fjell::Stamp crater;
        crater.shape = fjell::StampShape::crater;
        crater.x_m = centre().x, crater.z_m = centre().z;
        crater.radius_m = float(radius_m), crater.falloff_m = float(falloff_m), crater.amount_m = float(depth_m);
        fjell::StampId id = 0;
        if (fjell::Status s = fjell::push_stamp(ground_.edits(), crater, id); !s.ok()) return fail(ground::text_of(s));
        while (fjell::stamp_state(ground_.edits(), id).state == fjell::StampState::waiting) { // for pages, perhaps
            if (dug_.changed_steps++ == most_steps) return fail("the crater waits for pages that do not come");
            if (!step(false)) return dug_;
        }
        if (const fjell::Status s = fjell::stamp_state(ground_.edits(), id).status; !s.ok())
            return fail(ground::text_of(s));
        if (std::string error = whole_.stamp(crater); !error.empty()) return fail(error);
        if (dug_.patches == 0) return fail("the ground has changed, and no patch was told");
        body_->activate();
        int fallen_steps = 0;
        if (!rest(fallen_steps)) return fail("the body does not come to rest in the crater");
        dug_.fell_m = before_m - centre().y;
        if (check_.contact_count() == 0) return fail("the body rests on nothing");
        if (dug_.fell_m < 0.8 * depth_m) return fail("the body has not fallen to the floor of the crater");
        dug_.share = check_.worst_share();
        return dug_;
    }

private:
    Dug fail(const std::string& what) {
        if (dug_.broken.empty()) dug_.broken = what;
        return dug_;
    }
    void leave() {
        if (in_world_) world_.removeRigidBody(body_.get());
        in_world_ = false;
    }
    [[nodiscard]] fjell::Vec3 centre() const {
        return in_world_ || placed_ ? origin_.to_scene(body_->getWorldTransform().getOrigin()) : place_;
    }
    // The ground, then the body on it.
    bool step(bool checked) {
        fjell::Vec3 eye = centre();
        eye.y = fjell::ground_height(ground_.terrain(), eye.x, eye.z).height_m;
        const fjell::View view = ground::focus(eye, 60, accuracy_m_);
        if (const fjell::Status s = ground_.update({&view, 1}, steps_++ * step_s); !s.ok())
            return fail(ground::text_of(s)), false;
        ground_.answer(requests_per_step);
        dug_.patches += patches_.changed(ground_.changes());
        patches_.follow(ground_.report().pages_inserted != 0);
        const fjell::Vec3 reach{2, 0, 2}, at = centre();
        const bool carried = patches_.want(at - reach, at + reach);
        if (carried && !placed_) {
            body_->setWorldTransform(
                btTransform(btQuaternion::getIdentity(), origin_.to_bullet(eye + fjell::Vec3{0, 1, 0})));
            placed_ = true;
        }
        if (carried && !in_world_) world_.addRigidBody(body_.get()), in_world_ = true;
        if (!carried) leave();
        world_.stepSimulation(btScalar(step_s), 0);
        if (checked) {
            check_.contacts(world_);
            if (in_world_ && check_.place(body_->getWorldTransform().getOrigin()) != Check::Place::above)
                check_.fell(body_->getWorldTransform().getOrigin());
            if (!check_.broken().empty()) return fail(check_.broken()), false;
        }
        return true;
    }
    bool rest(int& steps) {
        int still = 0;
        while (still < still_for) {
            if (steps++ == most_steps || !step(true)) return false;
            still = in_world_ && double(body_->getLinearVelocity().length()) < still_m_s && check_.contact_count() != 0
                        ? still + 1
                        : 0;
        }
        return true;
    }

    ground::StreamedGround& ground_;
    ground::Yardstick& whole_;
    const double accuracy_m_;
    const fjell::Vec3 place_;
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_{&configuration_};
    btDbvtBroadphase broadphase_;
    btSequentialImpulseConstraintSolver solver_;
    btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
    Origin origin_;
    Patches patches_;
    Check check_;
    btBoxShape box_{btVector3(0.6f, 0.4f, 0.5f)};
    std::unique_ptr<btRigidBody> body_;
    bool placed_ = false, in_world_ = false;
    int steps_ = 0;
    Dug dug_;
};

} // namespace

Dug dig(ground::StreamedGround& ground, ground::Yardstick& whole, double accuracy_m, float good_m) {
    return Digging(ground, whole, accuracy_m, good_m).run();
}

} // namespace physics
