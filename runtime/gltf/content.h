// What a Snapshot holds.
#pragma once

#include <utility>
#include <vector>

#include "fjell/gltf/snapshot.h"
#include "gltf/geometry.h"

namespace fjell::gltf {

struct Snapshot::Content {
    SnapshotInfo info;
    PackHeader header; // of the pack that the terrain was loaded from
    std::vector<TileGeometry> tiles;
};

struct SnapshotAccess {
    static const Snapshot::Content* content(const Snapshot& snapshot) { return snapshot.content_.get(); }
    static void set(Snapshot& snapshot, Snapshot::Content content) {
        snapshot.content_ = std::make_shared<const Snapshot::Content>(std::move(content));
    }
};

} // namespace fjell::gltf
