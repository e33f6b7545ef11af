// What a Snapshot holds.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "fjell/gltf/snapshot.h"
#include "fjell/ground_maps.h"
#include "fjell/io/load.h"
#include "gltf/geometry.h"

namespace fjell::gltf {

struct Snapshot::Content {
    SnapshotInfo info;
    PackHeader header; // of the pack that the terrain was loaded from
    std::vector<TileGeometry> tiles;
    io::AlignedMemory paint_memory;
    Paint paint; // as it was; empty: there was none
};

struct SnapshotAccess {
    static const Snapshot::Content* content(const Snapshot& snapshot) { return snapshot.content_.get(); }
    static Snapshot of(Snapshot::Content content) {
        Snapshot snapshot;
        snapshot.content_ = std::make_shared<const Snapshot::Content>(std::move(content));
        return snapshot;
    }
};

} // namespace fjell::gltf
