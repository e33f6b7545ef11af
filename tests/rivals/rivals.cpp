#include <stdexcept>

#include "rivals/binary_tree.h"
#include "rivals/blocks_and_vertices.h"
#include "rivals/cdlod.h"
#include "rivals/error_spheres.h"
#include "rivals/multi_triangulation.h"
#include "rivals/ours.h"
#include "rivals/progressive_mesh.h"
#include "rivals/roam.h"
#include "rivals/skirted_tiles.h"

namespace fjell::rivals {

namespace {

struct Entry {
    const char* name;
    std::unique_ptr<Rival> (*make)(const Ground&, const Terrain&);
};

template <typename R, auto... Arguments>
std::unique_ptr<Rival> from_ground(const Ground& ground, const Terrain&) {
    return std::make_unique<R>(ground, Arguments...);
}
template <typename R, auto... Arguments>
std::unique_ptr<Rival> from_terrain(const Ground&, const Terrain& terrain) {
    return std::make_unique<R>(terrain, Arguments...);
}
std::unique_ptr<Rival> roam_of_wedgies(const Ground& ground, const Terrain&) {
    return std::make_unique<Roam>(with_wedgies(ground));
}

constexpr Entry entries[] = {{"incremental", from_terrain<Incremental, false>},
                             {"incremental-morph", from_terrain<Incremental, true>},
                             {"incremental-offscreen", from_terrain<Incremental, false, 8>},
                             {"recursive", from_terrain<Recursive>},
                             {"lean", from_terrain<Lean>},
                             {"roam", from_ground<Roam>},
                             {"roam-wedgies", roam_of_wedgies},
                             {"cdlod", from_ground<Cdlod>},
                             {"cdlod-doubling", from_ground<Cdlod, Cdlod::Ranges::doubling>},
                             {"blocks", from_ground<BlocksAndVertices>},
                             {"spheres", from_ground<ErrorSpheres>},
                             {"binary-tree", from_ground<BinaryTree, true>},
                             {"skirted-tiles", from_ground<SkirtedTiles>},
                             {"multi-triangulation", from_ground<MultiTriangulation, true>},
                             {"progressive-mesh", from_ground<ProgressiveMesh>}};

} // namespace

const std::vector<std::string>& rival_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const Entry& e : entries) all.emplace_back(e.name);
        return all;
    }();
    return names;
}

std::unique_ptr<Rival> make_rival(const std::string& name, const Ground& ground, const Terrain& terrain) {
    for (const Entry& e : entries)
        if (name == e.name) return e.make(ground, terrain);
    throw std::invalid_argument(name + ": no such rival");
}

} // namespace fjell::rivals
