// The editor's state as JSON, for tests and scripts: what a screenshot shows, in numbers, and where the controls are.
#pragma once

#include <string>
#include <vector>

#include "editor/state.h"

namespace fjell::editor {

// Keys: frame, scene, profile (by dotted key), document, camera, route, interface, input, job, messages, measures,
// marks (with places in pixels; empty unless they were recorded).
[[nodiscard]] std::string dump(const State& state);

} // namespace fjell::editor

// --- Texts that cannot be read whole, found in what ImGui has drawn: what tests of the window look for.
//
// Thread: the frame's, between the end of one of ImGui's frames and the begin of the next. Memory: allocates; for dumps
// alone. Complexity: O(letters + pairs of texts of a window).

namespace fjell::editor::ui {

// "window: text" of each that an edge cuts although nothing scrolls there, and "window: text | other" of two that lie
// over each other. What is typed into a field may be longer than the field.
[[nodiscard]] std::vector<std::string> illegible_texts();

} // namespace fjell::editor::ui
