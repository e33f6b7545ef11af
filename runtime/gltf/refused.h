// A result that says no.
#pragma once

#include <string>
#include <utility>

#include "fjell/gltf/snapshot.h"

namespace fjell::gltf {

inline SnapshotResult refused(int exit_code, std::string message) {
    SnapshotResult result;
    result.exit_code = exit_code;
    result.message = std::move(message);
    return result;
}

} // namespace fjell::gltf
