// The editor's state as JSON, for tests and scripts: what a screenshot shows, in numbers, and where the controls are.
#pragma once

#include <string>

#include "editor/state.h"

namespace fjell::editor {

// Keys: frame, scene, profile (by dotted key), document, camera, route, interface, input, job, messages, measures,
// marks (with places in pixels; empty unless they were recorded).
[[nodiscard]] std::string dump(const State& state);

} // namespace fjell::editor
