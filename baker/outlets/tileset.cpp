#include "baker/outlets/tileset.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace fjell::baker {

namespace {

using nlohmann::ordered_json;

struct GltfPlaces {
    std::vector<std::array<float, 3>> places, normals;
    std::vector<std::uint32_t> indices;
    double low_m = HUGE_VAL, high_m = -HUGE_VAL;

    void add(const GlobePlace& middle, LonLat at, double height_m) {
        const GlobePlace p = on_globe(at, height_m);
        places.push_back({static_cast<float>(p[0] - middle[0]), static_cast<float>(p[2] - middle[2]),
                          static_cast<float>(middle[1] - p[1])});
        low_m = std::min(low_m, height_m), high_m = std::max(high_m, height_m);
    }
    // How far a flat triangle lies below its corners' heights, at most: a circle around it is no wider than its longest
    // side.
    [[nodiscard]] double sag_m() const {
        double longest = 0;
        for (std::size_t i = 0; i < indices.size(); i += 3)
            for (std::size_t k = 0; k < 3; ++k) {
                const auto &a = places[indices[i + k]], &b = places[indices[i + (k + 1) % 3]];
                longest = std::max(longest, std::hypot(static_cast<double>(a[0]) - static_cast<double>(b[0]),
                                                       static_cast<double>(a[1]) - static_cast<double>(b[1]),
                                                       static_cast<double>(a[2]) - static_cast<double>(b[2])));
            }
        constexpr double most_curved = 0.99; // the globe's smallest radius of curvature, in equators
        return longest * longest / (8 * most_curved * globe_radius_m);
    }
};

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
            if (k > 0) {
                const std::uint32_t last = along[k - 1].second;
                for (const std::uint32_t i : {last, before, foot, last, foot, top}) to.indices.push_back(i);
            }
            before = foot;
        }
    }
}

template <typename T>
void append(std::vector<std::byte>& to, const T* from, std::size_t count) {
    const auto bytes = std::as_bytes(std::span(from, count));
    to.insert(to.end(), bytes.begin(), bytes.end());
}

std::vector<std::byte> glb_of(const GltfPlaces& g, double error_m) {
    constexpr int array_buffer = 34962, element_buffer = 34963, float_type = 5126, short_type = 5123, uint_type = 5125;
    const bool wide = g.places.size() > 65535;
    std::vector<std::byte> binary;
    append(binary, g.places.data(), g.places.size());
    append(binary, g.normals.data(), g.normals.size());
    const std::size_t places_bytes = g.places.size() * sizeof(g.places[0]),
                      normals_bytes = g.normals.size() * sizeof(g.places[0]), indices_at = binary.size();
    if (wide)
        append(binary, g.indices.data(), g.indices.size());
    else
        for (const std::uint32_t i : g.indices) {
            const auto index = static_cast<std::uint16_t>(i);
            append(binary, &index, 1);
        }
    const std::size_t indices_bytes = binary.size() - indices_at;
    binary.resize((binary.size() + 3) / 4 * 4);
    auto low = g.places.front(), high = low;
    for (const auto& p : g.places)
        for (std::size_t axis = 0; axis < 3; ++axis)
            low[axis] = std::min(low[axis], p[axis]), high[axis] = std::max(high[axis], p[axis]);
    const auto view = [](std::size_t at, std::size_t bytes, int target) {
        return ordered_json{{"buffer", 0}, {"byteOffset", at}, {"byteLength", bytes}, {"target", target}};
    };
    ordered_json attributes{{"POSITION", 1}};
    ordered_json accessors{{{"bufferView", 0},
                            {"componentType", wide ? uint_type : short_type},
                            {"count", g.indices.size()},
                            {"type", "SCALAR"}},
                           {{"bufferView", 1},
                            {"componentType", float_type},
                            {"count", g.places.size()},
                            {"type", "VEC3"},
                            {"min", low},
                            {"max", high}}};
    ordered_json views{view(indices_at, indices_bytes, element_buffer), view(0, places_bytes, array_buffer)};
    if (!g.normals.empty()) {
        attributes["NORMAL"] = 2;
        accessors.push_back(
            {{"bufferView", 2}, {"componentType", float_type}, {"count", g.normals.size()}, {"type", "VEC3"}});
        views.push_back(view(places_bytes, normals_bytes, array_buffer));
    }
    const ordered_json gltf{
        {"asset", {{"version", "2.0"}, {"generator", "fjell-bake"}, {"extras", {{"fjell", {{"error_m", error_m}}}}}}},
        {"scene", 0},
        {"scenes", {{{"nodes", {0}}}}},
        {"nodes", {{{"mesh", 0}}}},
        {"meshes", {{{"primitives", {{{"attributes", attributes}, {"indices", 0}, {"material", 0}, {"mode", 4}}}}}}},
        {"materials",
         {{{"pbrMetallicRoughness",
            {{"baseColorFactor", {0.5, 0.5, 0.5, 1.0}}, {"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}}}}},
        {"accessors", accessors},
        {"bufferViews", views},
        {"buffers", {{{"byteLength", binary.size()}}}}};
    std::string text = gltf.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<std::byte> bytes;
    const auto put32 = [&](std::size_t value) {
        const auto word = static_cast<std::uint32_t>(value);
        append(bytes, &word, 1);
    };
    put32(0x46546c67), put32(2), put32(12 + 8 + text.size() + 8 + binary.size());
    put32(text.size()), put32(0x4e4f534a);
    append(bytes, text.data(), text.size());
    put32(binary.size()), put32(0x004e4942);
    append(bytes, binary.data(), binary.size());
    return bytes;
}

class Tree3d {
public:
    Tree3d(Tiling tiling, const std::vector<std::vector<TilesetTile>>& levels) : tiling_(tiling), levels_(levels) {
        for (const auto& level : levels_) {
            places_.emplace_back();
            for (std::size_t i = 0; i < level.size(); ++i) places_.back()[{level[i].id.x, level[i].id.y}] = i;
        }
    }
    struct Node {
        ordered_json json;
        double error_m, low_m, high_m;
        DegreeBox box;
    };
    [[nodiscard]] Node node(std::size_t level, std::size_t which, const GlobePlace& parent) const {
        const TilesetTile& t = levels_[level][which];
        const DegreeBox box = box_of(tiling_, t.id);
        const GlobePlace middle = tile_middle(box);
        Node n{{}, t.error_m, t.low_m, t.high_m, box};
        ordered_json children = ordered_json::array();
        if (level + 1 < levels_.size())
            for (int child = 0; child < 4; ++child) {
                const auto found = places_[level + 1].find({2 * t.id.x + (child & 1), 2 * t.id.y + (child >> 1)});
                if (found == places_[level + 1].end()) continue;
                Node c = node(level + 1, found->second, middle);
                n.error_m = std::max(n.error_m, c.error_m);
                n.low_m = std::min(n.low_m, c.low_m), n.high_m = std::max(n.high_m, c.high_m);
                children.push_back(std::move(c.json));
            }
        n.json["boundingVolume"] = {{"region", region(box, n.low_m, n.high_m)}};
        n.json["geometricError"] = n.error_m;
        n.json["refine"] = "REPLACE";
        n.json["transform"] = {
            1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, middle[0] - parent[0], middle[1] - parent[1], middle[2] - parent[2], 1};
        n.json["content"] = {{"uri", fmt::format("{}/{}/{}.glb", t.id.level, t.id.x, t.id.y)}};
        if (!children.empty()) n.json["children"] = std::move(children);
        return n;
    }
    [[nodiscard]] static ordered_json region(const DegreeBox& b, double low_m, double high_m) {
        constexpr double radians = std::numbers::pi / 180;
        return {b.west * radians, b.south * radians, b.east * radians, b.north * radians, low_m, high_m};
    }

private:
    Tiling tiling_;
    const std::vector<std::vector<TilesetTile>>& levels_;
    std::vector<std::map<std::pair<std::int32_t, std::int32_t>, std::size_t>> places_;
};

} // namespace

GlobePlace tile_middle(const DegreeBox& box) {
    return on_globe(box.middle(), 0);
}

GltfTile encode_gltf_tile(const TileMesh& mesh, double skirt_m, std::span<const GlobePlace> normals) {
    const GlobePlace middle = tile_middle(mesh.box);
    GltfPlaces g;
    for (const TileMesh::Vertex& v : mesh.vertices) g.add(middle, mesh.place(v), v.height_m);
    for (const GlobePlace& n : normals)
        g.normals.push_back({static_cast<float>(n[0]), static_cast<float>(n[2]), static_cast<float>(-n[1])});
    for (const auto& t : mesh.triangles) g.indices.insert(g.indices.end(), t.begin(), t.end());
    hang_walls(mesh, middle, skirt_m, g);
    return {glb_of(g, mesh.error_m), g.low_m - g.sag_m(), g.high_m};
}

std::string tileset_json(Tiling tiling, const std::vector<std::vector<TilesetTile>>& levels,
                         const std::string& extras) {
    const Tree3d tree(tiling, levels);
    ordered_json children = ordered_json::array();
    double low_m = HUGE_VAL, high_m = -HUGE_VAL;
    DegreeBox box{180, 90, -180, -90};
    for (std::size_t i = 0; i < levels.front().size(); ++i) {
        Tree3d::Node n = tree.node(0, i, {});
        low_m = std::min(low_m, n.low_m), high_m = std::max(high_m, n.high_m);
        box = {std::min(box.west, n.box.west), std::min(box.south, n.box.south), std::max(box.east, n.box.east),
               std::max(box.north, n.box.north)};
        children.push_back(std::move(n.json));
    }
    // Without any tile all of the ground is missing: whoever sees it refines.
    const double nothing_m = globe_radius_m;
    const ordered_json tileset{{"asset", {{"version", "1.1"}, {"extras", {{"fjell", ordered_json::parse(extras)}}}}},
                               {"geometricError", nothing_m},
                               {"root",
                                {{"boundingVolume", {{"region", Tree3d::region(box, low_m, high_m)}}},
                                 {"geometricError", nothing_m},
                                 {"refine", "REPLACE"},
                                 {"children", std::move(children)}}}};
    return tileset.dump() + "\n";
}

} // namespace fjell::baker
