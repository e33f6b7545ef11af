#include "patches.h"

#include <cmath>

namespace physics {

namespace {

constexpr std::uint64_t keep_steps = 60; // a body that comes back within a second finds its patch

} // namespace

Patches::~Patches() {
    for (const auto& [key, patch] : patches_) world_.removeCollisionObject(&patch->object);
}

std::unique_ptr<GroundShape> Patches::read(Key key) {
    auto shape = std::make_unique<GroundShape>();
    const float us = shape->make(terrain_, {key.first * patch_cells, key.second * patch_cells});
    if (shape->finest()) counts_.us.push_back(us); // where pages are missing every sample is a height query
    return shape;
}

void Patches::put(Key key, Patch& patch) {
    const fjell::Vec3 at{key.first * patch_cells * terrain_.header().spacing_m[0], patch.shape->base_m(),
                         key.second * patch_cells * terrain_.header().spacing_m[1]};
    patch.object.setCollisionShape(patch.shape.get());
    patch.object.setWorldTransform(btTransform(btQuaternion::getIdentity(), origin_.to_bullet(at)));
    patch.object.setFriction(0.6f);
    world_.addCollisionObject(&patch.object, btBroadphaseProxy::StaticFilter,
                              btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter);
}

bool Patches::want(fjell::Vec3 low_m, fjell::Vec3 high_m) {
    const auto patch_at = [](double at_m, double spacing_m) {
        return static_cast<int>(std::floor(at_m / (patch_cells * spacing_m)));
    };
    const double dx = terrain_.header().spacing_m[0], dz = terrain_.header().spacing_m[1];
    bool good = true;
    for (int y = patch_at(low_m.z, dz); y <= patch_at(high_m.z, dz); ++y)
        for (int x = patch_at(low_m.x, dx); x <= patch_at(high_m.x, dx); ++x) {
            std::unique_ptr<Patch>& patch = patches_[{x, y}];
            if (!patch) {
                patch = std::make_unique<Patch>();
                patch->shape = read({x, y});
                put({x, y}, *patch);
                ++counts_.made;
            }
            patch->wanted = step_;
            good = good && patch->shape->error_m() <= good_m_;
        }
    return good;
}

void Patches::follow(bool pages_came) {
    ++step_;
    for (auto at = patches_.begin(); at != patches_.end();) {
        Patch& patch = *at->second;
        if (patch.wanted + keep_steps < step_) {
            world_.removeCollisionObject(&patch.object);
            at = patches_.erase(at);
            ++counts_.dropped;
            continue;
        }
        // A patch that is of the full resolution is done with: it keeps its heights when its pages go.
        if (pages_came && !patch.shape->finest()) {
            std::unique_ptr<GroundShape> finer = read(at->first);
            if (finer->finest() || finer->error_m() < patch.shape->error_m()) {
                world_.removeCollisionObject(&patch.object); // and its contacts, with triangles that are no more
                patch.shape = std::move(finer);
                put(at->first, patch);
                ++counts_.remade;
            }
        }
        ++at;
    }
}

int Patches::changed(std::span<const fjell::GroundRect> rects) {
    int count = 0;
    for (const auto& [key, patch] : patches_) {
        const int x = key.first * patch_cells, y = key.second * patch_cells;
        bool touched = false;
        for (const fjell::GroundRect& r : rects)
            touched = touched || (r.first.column <= x + patch_cells && r.last.column >= x &&
                                  r.first.row <= y + patch_cells && r.last.row >= y);
        if (!touched) continue;
        world_.removeCollisionObject(&patch->object); // and its contacts
        patch->shape = read(key);
        put(key, *patch);
        ++count;
    }
    return count;
}

const GroundShape* Patches::ground_of(const btCollisionObject* object) {
    const btCollisionShape* const shape = object->getCollisionShape();
    return shape->getShapeType() == FAST_CONCAVE_MESH_PROXYTYPE ? static_cast<const GroundShape*>(shape) : nullptr;
}

} // namespace physics
