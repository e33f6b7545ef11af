// The camera path as lines in the scene: where it goes, its points, and what is being recorded.
//
// Ownership: none. Thread: any. Memory: adds to `to`, no more than room for it was made. Complexity:
// O(most_route_lines).
#pragma once

#include <vector>

#include "editor/route.h"
#include "fjell/gl/lines.h"
#include "fjell/view.h"

namespace fjell::editor {

// However long the path is: it is shown coarser then, and of its points some.
inline constexpr std::size_t most_route_pieces = 512, most_route_marks = 256;
inline constexpr std::size_t most_route_lines = 2 * most_route_pieces + 4 * most_route_marks;

// Points are squares that face the view, some pixels wide; the selected one is larger. Those that are nearer than the
// near plane, or behind it, are left out: the camera is at one of them often.
void add_route_lines(const Route& route, const View& view, std::vector<gl::Line>& to);

} // namespace fjell::editor
