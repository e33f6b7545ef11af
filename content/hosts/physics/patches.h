// Ground where bodies are: patches that follow them.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include <fjell/fjell.h>

#include "ground_shape.h"

namespace physics {

// Fjell's scene is in doubles from sample (0, 0); Bullet's is in floats from a sample near its bodies.
struct Origin {
    fjell::Vec3 scene_m;
    [[nodiscard]] btVector3 to_bullet(fjell::Vec3 p) const {
        return {btScalar(p.x - scene_m.x), btScalar(p.y - scene_m.y), btScalar(p.z - scene_m.z)};
    }
    [[nodiscard]] fjell::Vec3 to_scene(const btVector3& p) const {
        return {scene_m.x + double(p.x()), scene_m.y + double(p.y()), scene_m.z + double(p.z())};
    }
};

struct PatchCounts {
    std::uint64_t made = 0, remade = 0, dropped = 0;
    std::vector<float> us; // what each took
};

class Patches {
public:
    // good_m: ground that is no further off carries bodies.
    Patches(btCollisionWorld& world, const fjell::Terrain& terrain, const Origin& origin, float good_m)
        : world_(world), terrain_(terrain), origin_(origin), good_m_(good_m) {}
    ~Patches();
    Patches(const Patches&) = delete;
    Patches& operator=(const Patches&) = delete;

    // There is, or will be, a body between these places. True: all ground there is good enough to carry it.
    bool want(fjell::Vec3 low_m, fjell::Vec3 high_m);
    // The ground has changed there: patches with a sample in one of these are read again. Returns how many.
    int changed(std::span<const fjell::GroundRect> rects);
    // After a step: drops what nobody has wanted for a while, and if pages have come makes anew what they make finer.
    void follow(bool pages_came);

    // The ground of a contact, or nullptr.
    [[nodiscard]] static const GroundShape* ground_of(const btCollisionObject* object);
    [[nodiscard]] const PatchCounts& counts() const { return counts_; }
    [[nodiscard]] std::size_t size() const { return patches_.size(); }

private:
    struct Patch {
        std::unique_ptr<GroundShape> shape;
        btCollisionObject object;
        std::uint64_t wanted = 0; // the step in which it last was
    };
    using Key = std::pair<int, int>;
    [[nodiscard]] std::unique_ptr<GroundShape> read(Key key);
    void put(Key key, Patch& patch);

    btCollisionWorld& world_;
    const fjell::Terrain& terrain_;
    const Origin& origin_;
    const float good_m_;
    std::uint64_t step_ = 0;
    std::map<Key, std::unique_ptr<Patch>> patches_;
    PatchCounts counts_;
};

} // namespace physics
