#include "baker/outlets/tileset.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace fjell::baker {

namespace {

using nlohmann::ordered_json;

struct GltfPlaces {
    std::vector<std::array<double, 3>> places, normals; // as glTF turns them
    std::vector<std::array<double, 2>> uv;              // from the north-west
    std::vector<std::array<std::uint32_t, 3>> triangles;
    double low_m = HUGE_VAL, high_m = -HUGE_VAL;

    void add(const GlobePlace& middle, LonLat at, double height_m) {
        const GlobePlace p = on_globe(at, height_m);
        places.push_back({p[0] - middle[0], p[2] - middle[2], middle[1] - p[1]});
        low_m = std::min(low_m, height_m), high_m = std::max(high_m, height_m);
    }
    // How far a flat triangle lies below its corners' heights, at most: a circle around it is no wider than its longest
    // side.
    [[nodiscard]] double sag_m() const {
        double longest = 0;
        for (const auto& t : triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const auto &a = places[t[k]], &b = places[t[(k + 1) % 3]];
                longest = std::max(longest, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
            }
        constexpr double most_curved = 0.99; // the globe's smallest radius of curvature, in equators
        return longest * longest / (8 * most_curved * globe_radius_m);
    }
};

// What moving vertices by moved_m can add to a vertical distance from the ground's triangles: 1 / cosine of the slope
// times as much, on the steepest of them.
double added_error_m(const GltfPlaces& g, std::size_t ground_triangles, const TileMesh& mesh, double moved_m) {
    double least = 1;
    for (const auto& t : std::span(g.triangles).first(ground_triangles)) {
        const auto &a = g.places[t[0]], &b = g.places[t[1]], &c = g.places[t[2]];
        double n[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
            n[axis] = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
        }
        const GlobePlace up = up_at(mesh.place(mesh.vertices[t[0]]));
        const double length = std::hypot(n[0], n[1], n[2]);
        constexpr double upright = 1e-3, no_area_m2 = 1e-6; // at a pole
        if (length > no_area_m2)
            least = std::min(least, std::max(upright, (n[0] * up[0] + n[1] * up[2] - n[2] * up[1]) / length));
    }
    return moved_m / least;
}

// Under the vertices of each side; the same normals, so that light does not change.
void hang_walls(const TileMesh& mesh, const GlobePlace& middle, double skirt_m, GltfPlaces& to) {
    for (const auto side : {TileSide::west, TileSide::south, TileSide::east, TileSide::north}) {
        const bool upright = side == TileSide::west || side == TileSide::east;
        const std::int32_t across = side == TileSide::west || side == TileSide::south ? 0 : tile_grid;
        std::vector<std::pair<std::int32_t, std::uint32_t>> along;
        for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
            const SampleIndex at = mesh.vertices[i].at;
            if ((upright ? at.column : at.row) == across) along.emplace_back(upright ? at.row : at.column, i);
        }
        std::sort(along.begin(), along.end()); // from the south, from the west
        // Seen from outside counter-clockwise: eastwards in the south, northwards in the east, and back.
        if (side == TileSide::north || side == TileSide::west) std::reverse(along.begin(), along.end());
        std::uint32_t before = 0;
        for (std::size_t k = 0; k < along.size(); ++k) {
            const std::uint32_t top = along[k].second, foot = static_cast<std::uint32_t>(to.places.size());
            to.add(middle, mesh.place(mesh.vertices[top]), mesh.vertices[top].height_m - skirt_m);
            if (!to.normals.empty()) to.normals.push_back(to.normals[top]);
            to.uv.push_back(to.uv[top]);
            if (k > 0) {
                const std::uint32_t last = along[k - 1].second;
                to.triangles.push_back({last, before, foot}), to.triangles.push_back({last, foot, top});
            }
            before = foot;
        }
    }
}

// Steps are a power of two, and places whole multiples of it from the globe's middle: a vertex that two tiles share is
// the same in both.
gltf::GlbLattice tile_lattice(const GltfPlaces& g, const GlobePlace& middle, double size_m) {
    constexpr double room = 65000;
    gltf::GlbLattice lattice;
    const std::array<double, 3> turned{middle[0], middle[2], -middle[1]};
    std::array<double, 3> low{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto by = [axis](const auto& p, const auto& q) { return p[axis] < q[axis]; };
        const auto [least, most] = std::minmax_element(g.places.begin(), g.places.end(), by);
        low[axis] = (*least)[axis];
        size_m = std::max(size_m, (*most)[axis] - low[axis]);
    }
    const double step_m = std::exp2(std::ceil(std::log2(size_m / room)));
    lattice.scale = {step_m, step_m, step_m};
    for (std::size_t axis = 0; axis < 3; ++axis)
        lattice.offset[axis] = std::floor((turned[axis] + low[axis]) / step_m) * step_m - turned[axis];
    return lattice;
}

class Tree3d {
public:
    Tree3d(Tiling tiling, const TilesetLevels& levels) : tiling_(tiling), levels_(levels) {}

    [[nodiscard]] ordered_json node(std::size_t level, const TilesetTile& t, const GlobePlace& parent) const {
        const DegreeBox box = box_of(tiling_, t.id);
        const GlobePlace middle = tile_middle(box);
        ordered_json n{{"boundingVolume", {{"region", region_json(box, t.low_m, t.high_m)}}},
                       {"geometricError", t.error_m},
                       {"refine", "REPLACE"}};
        n["transform"] = {
            1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, middle[0] - parent[0], middle[1] - parent[1], middle[2] - parent[2], 1};
        n["content"] = {{"uri", fmt::format("{}/{}/{}.glb", t.id.level, t.id.x, t.id.y)}};
        ordered_json children = ordered_json::array();
        for (int child = 0; level + 1 < levels_.size() && child < 4; ++child) {
            const std::vector<TilesetTile>& below = levels_[level + 1];
            const std::size_t at = find_tile(below, child_of(t.id, child));
            if (at < below.size()) children.push_back(node(level + 1, below[at], middle));
        }
        if (!children.empty()) n["children"] = std::move(children);
        return n;
    }

private:
    Tiling tiling_;
    const TilesetLevels& levels_;
};

} // namespace

GlobePlace tile_middle(const DegreeBox& box) {
    return on_globe(box.middle(), 0);
}

GltfTile encode_gltf_tile(const TileMesh& mesh, const GltfTileRules& rules, std::span<const GlobePlace> normals,
                          std::vector<std::byte> texture_jpeg) {
    const GlobePlace middle = tile_middle(mesh.box);
    GltfPlaces g;
    for (const TileMesh::Vertex& v : mesh.vertices) {
        g.add(middle, mesh.place(v), v.height_m);
        g.uv.push_back({static_cast<double>(v.at.column) / tile_grid, 1 - static_cast<double>(v.at.row) / tile_grid});
    }
    for (const GlobePlace& n : normals) g.normals.push_back({n[0], n[2], -n[1]});
    g.triangles = mesh.triangles;
    const double skirt_m = 3 * std::max(rules.least_error_m, mesh.error_m);
    hang_walls(mesh, middle, skirt_m, g);
    gltf::GlbMesh content{"ground", g.places.size(), {g.triangles.front().data(), 3 * g.triangles.size()}};
    if (rules.placed) content.origin = {middle[0], middle[2], -middle[1]};
    content.place = [&](std::size_t i) { return g.places[i]; };
    if (!g.normals.empty()) content.normal = [&](std::size_t i) { return g.normals[i]; };
    GltfTile tile{{}, mesh.error_m, g.low_m - g.sag_m(), g.high_m};
    if (rules.packing.quantised) {
        content.lattice = tile_lattice(g, middle, rules.size_m);
        const double moved_m = std::sqrt(3) / 2 * content.lattice->scale[0];
        tile.error_m += added_error_m(g, mesh.triangles.size(), mesh, moved_m);
        tile.low_m -= moved_m, tile.high_m += moved_m;
    }
    gltf::Glb glb("fjell-bake", "a tile has more than 4 GB");
    glb.json["asset"]["extras"]["fjell"]["error_m"] = tile.error_m;
    if (!texture_jpeg.empty()) {
        content.uv = [&](std::size_t i) { return g.uv[i]; };
        content.textures.colour = static_cast<int>(glb.add_texture("ground", std::move(texture_jpeg), "image/jpeg"));
    }
    gltf::add_glb_mesh(glb, std::move(content), rules.packing.meshopt);
    glb.close();
    tile.bytes = glb.bytes();
    return tile;
}

std::size_t find_tile(const std::vector<TilesetTile>& level, TileId id) {
    const auto before = [](const TilesetTile& t, TileId at) { return t.id.y != at.y ? t.id.y < at.y : t.id.x < at.x; };
    const auto found = std::lower_bound(level.begin(), level.end(), id, before);
    return found != level.end() && found->id == id ? static_cast<std::size_t>(found - level.begin()) : level.size();
}

TilesetLevels with_children(TilesetLevels levels) {
    for (std::size_t level = levels.size() - 1; level-- > 0;)
        for (const TilesetTile& t : levels[level + 1]) {
            TilesetTile& parent = levels[level].at(find_tile(levels[level], parent_of(t.id)));
            parent.error_m = std::max(parent.error_m, t.error_m);
            parent.low_m = std::min(parent.low_m, t.low_m), parent.high_m = std::max(parent.high_m, t.high_m);
        }
    return levels;
}

ordered_json region_json(const DegreeBox& b, double low_m, double high_m) {
    constexpr double radians = std::numbers::pi / 180;
    return {b.west * radians, b.south * radians, b.east * radians, b.north * radians, low_m, high_m};
}

ordered_json tileset_of(Tiling tiling, const std::vector<TilesetTile>& roots, ordered_json children,
                        const std::string& extras) {
    double low_m = HUGE_VAL, high_m = -HUGE_VAL;
    DegreeBox box{180, 90, -180, -90};
    for (const TilesetTile& t : roots) {
        const DegreeBox b = box_of(tiling, t.id);
        low_m = std::min(low_m, t.low_m), high_m = std::max(high_m, t.high_m);
        box = {std::min(box.west, b.west), std::min(box.south, b.south), std::max(box.east, b.east),
               std::max(box.north, b.north)};
    }
    // Without any tile all of the ground is missing: whoever sees it refines.
    const double nothing_m = globe_radius_m;
    return {{"asset", {{"version", "1.1"}, {"extras", {{"fjell", ordered_json::parse(extras)}}}}},
            {"geometricError", nothing_m},
            {"root",
             {{"boundingVolume", {{"region", region_json(box, low_m, high_m)}}},
              {"geometricError", nothing_m},
              {"refine", "REPLACE"},
              {"children", std::move(children)}}}};
}

std::string tileset_json(Tiling tiling, TilesetLevels made, const std::string& extras) {
    const TilesetLevels levels = with_children(std::move(made));
    const Tree3d tree(tiling, levels);
    ordered_json children = ordered_json::array();
    for (const TilesetTile& t : levels.front()) children.push_back(tree.node(0, t, {}));
    return tileset_of(tiling, levels.front(), std::move(children), extras).dump() + "\n";
}

} // namespace fjell::baker
