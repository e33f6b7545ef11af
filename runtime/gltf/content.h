// What a Snapshot holds, and a result that says no.
#pragma once

#include <string>
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

// A result that says no.
inline SnapshotResult refused(int exit_code, std::string message) {
    SnapshotResult result;
    result.exit_code = exit_code;
    result.message = std::move(message);
    return result;
}

} // namespace fjell::gltf
