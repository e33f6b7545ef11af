// Snapshots of a session's frames.
//
// Thread: the session's; write_snapshot on any. Failure: io::Failure, 1 for a pack that cannot be read or a camera that
// sees nothing, 3 when memory is short.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "fjell/gl/layers.h"
#include "fjell/gltf/snapshot.h"
#include "session/layers_file.h"
#include "session/session.h"

namespace fjell::session {

// The mesh of the last update as it stands.
[[nodiscard]] gltf::Snapshot take_frame(const Session& session);

// The mesh that its view would settle on, with the same budgets and the pages that are loaded: by the incremental
// method a cut of its own, built from scratch; a frame of the recursive method has settled.
[[nodiscard]] gltf::Snapshot take_converged(const Session& session);

// What the pack's splat maps call their materials; empty: it has none. Failure (1).
[[nodiscard]] std::vector<std::string> names_of_layers(const io::PackFile& file);

// What lies over the ground's colours where it is drawn; layers null, or not on: nothing.
struct GroundPaint {
    std::shared_ptr<const GroundLayers> layers;
    gl::LayerSettings settings;
};

// gltf::write_snapshot() with the ground's colours as it is drawn near the eye. file: the snapshot's pack.
gltf::SnapshotCounts write_snapshot(const io::PackFile& file, const gltf::Snapshot& snapshot, const std::string& path,
                                    gltf::SnapshotOptions options, const GroundPaint& paint);

} // namespace fjell::session
