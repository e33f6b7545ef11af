// A mesh from above, as SVG that stands by itself: its edges around what a camera sees, and the camera's sides.
#pragma once

#include <span>
#include <string>

#include "rivals/rival.h"

namespace fjell::lab {

// A square of `cells` ahead of the eye, north up.
[[nodiscard]] std::string mesh_svg(const rivals::Ground& ground, std::span<const rivals::Face> faces, const View& view,
                                   int cells, const std::string& title);

} // namespace fjell::lab
