// Snapshots of a session's frames.
//
// Thread: the session's. Failure: io::Failure, 1 for a pack that cannot be read or a camera that sees nothing, 3 when
// memory is short.
#pragma once

#include "fjell/gltf/snapshot.h"
#include "flight/session.h"

namespace fjell::flight {

// The mesh of the last update as it stands.
[[nodiscard]] gltf::Snapshot take_frame(const Session& session);

// The mesh that its view would settle on, with the same budgets and the pages that are loaded: by the incremental
// method a cut of its own, built from scratch; a frame of the recursive method has settled.
[[nodiscard]] gltf::Snapshot take_converged(const Session& session);

// gltf::write_snapshot() with the session's pack: from memory when it was loaded whole, else from its file.
gltf::SnapshotResult write_snapshot(const Session& session, const gltf::Snapshot& snapshot, const std::string& path,
                                    const gltf::SnapshotOptions& options = {});

} // namespace fjell::flight
