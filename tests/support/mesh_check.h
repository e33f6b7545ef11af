// Is a mesh what Fjell promises? Written against the promise, not against the code that makes meshes.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "fjell/mesh.h"
#include "fjell/sample_index.h"
#include "fjell/terrain.h"

namespace fjell::test {

// Three samples of the whole terrain, counter-clockwise from above, smallest first.
using Triangle = std::array<SampleIndex, 3>;

// Every non-degenerate triangle with its winding, strips unrolled; sorted.
[[nodiscard]] std::vector<Triangle> triangles_of(const MeshView& mesh);

// Empty when all of this holds, otherwise the first thing that does not, in words: every vertex stands at its sample's
// height; no triangle is degenerate (in a list) or faces down; drawn tiles are covered exactly; every edge has its
// opposite unless it lies on the terrain's rim or on the border of a tile that is not drawn (so: no crack, no
// T-junction, no overlap).
[[nodiscard]] std::string check_mesh(const Terrain& terrain, const MeshView& mesh);

} // namespace fjell::test
