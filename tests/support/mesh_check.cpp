#include "support/mesh_check.h"
#include "shared/terrain_data.h"

#include <algorithm>
#include <bit>
#include <sstream>

namespace fjell::test {

namespace {

std::int64_t doubled_area_up(const Triangle& t) {
    // x east, y (rows) south: counter-clockwise from above turns the other way round in (x, y).
    const SampleIndex a = t[1] - t[0], b = t[2] - t[0];
    return std::int64_t{a.row} * b.column - std::int64_t{a.column} * b.row;
}

Triangle rotated(Triangle t) {
    const auto less = [](SampleIndex a, SampleIndex b) { return a.row != b.row ? a.row < b.row : a.column < b.column; };
    std::rotate(t.begin(), std::min_element(t.begin(), t.end(), less), t.end());
    return t;
}

SampleIndex tile_corner(const Terrain& terrain, std::uint32_t tile) {
    const SampleIndex place = terrain.tile_place(tile);
    return {place.column * data_of(terrain).tree.side(), place.row * data_of(terrain).tree.side()};
}

// Calls visit(triangle) for every triangle of a range; strips flip every other one, as OpenGL does.
template <typename Visit>
void for_each_triangle(const MeshView& mesh, const TileRange& range, const Visit& visit) {
    const auto at = [&](std::uint32_t i) {
        const MeshVertex& v = mesh.vertices[mesh.indices[range.first_index + i]];
        return SampleIndex{v.column, v.row};
    };
    const bool strip = mesh.topology == Topology::strip;
    for (std::uint32_t i = 0; i + 3 <= range.index_count; i += strip ? 1 : 3) {
        Triangle t{at(i), at(i + 1), at(i + 2)};
        if (strip && (i & 1)) std::swap(t[1], t[2]);
        visit(t);
    }
}

std::string say(const char* what, const Triangle& t) {
    std::ostringstream text;
    text << what;
    for (const SampleIndex c : t) text << " (" << c.column << ", " << c.row << ")";
    return text.str();
}

std::uint64_t key(SampleIndex a, SampleIndex b, std::int32_t columns) {
    const auto index = [&](SampleIndex c) {
        return static_cast<std::uint64_t>(c.row) * static_cast<std::uint64_t>(columns) +
               static_cast<std::uint64_t>(c.column);
    };
    return index(a) << 32 | index(b);
}

// Is the edge on the rim of the terrain, or of the drawn part of it?
bool may_be_open(const Terrain& terrain, const std::vector<bool>& drawn, SampleIndex a, SampleIndex b) {
    const std::int32_t side = data_of(terrain).tree.side();
    if (a.column == b.column && (a.column == 0 || a.column == data_of(terrain).tree.columns() - 1)) return true;
    if (a.row == b.row && (a.row == 0 || a.row == data_of(terrain).tree.rows() - 1)) return true;
    const auto is_drawn = [&](std::int32_t tx, std::int32_t ty) {
        const std::uint32_t tile = terrain.tile_at({tx, ty});
        return tile != no_tile && drawn[tile];
    };
    if (a.column == b.column && a.column % side == 0) {
        const std::int32_t ty = std::min(a.row, b.row) / side;
        return is_drawn(a.column / side - 1, ty) != is_drawn(a.column / side, ty);
    }
    if (a.row == b.row && a.row % side == 0) {
        const std::int32_t tx = std::min(a.column, b.column) / side;
        return is_drawn(tx, a.row / side - 1) != is_drawn(tx, a.row / side);
    }
    return false;
}

// Directed edges. A flat table, because the tests look through every mesh of every frame.
class EdgeSet {
public:
    explicit EdgeSet(std::size_t most) : slots_(std::bit_ceil(2 * most + 2), none) {}
    // False: it was there.
    bool insert(std::uint64_t edge) {
        std::uint64_t& slot = slots_[find(edge)];
        if (slot == edge) return false;
        slot = edge;
        return true;
    }
    [[nodiscard]] bool contains(std::uint64_t edge) const { return slots_[find(edge)] == edge; }

private:
    static constexpr std::uint64_t none = ~std::uint64_t{0};
    std::vector<std::uint64_t> slots_;

    [[nodiscard]] std::size_t find(std::uint64_t edge) const { // its slot, or the one that it would take
        const std::size_t mask = slots_.size() - 1;
        std::size_t i = (edge * 0x9e3779b97f4a7c15u >> 32) & mask;
        while (slots_[i] != edge && slots_[i] != none) i = (i + 1) & mask;
        return i;
    }
};

std::string check_edges(const Terrain& terrain, const std::vector<bool>& drawn,
                        const std::vector<Triangle>& triangles) {
    EdgeSet edges(triangles.size() * 3);
    const std::int32_t columns = data_of(terrain).tree.columns();
    for (const Triangle& t : triangles)
        for (std::size_t i = 0; i < 3; ++i)
            if (!edges.insert(key(t[i], t[(i + 1) % 3], columns)))
                return say("an edge is used twice in one direction by", t);
    for (const Triangle& t : triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const SampleIndex a = t[i], b = t[(i + 1) % 3];
            if (!edges.contains(key(b, a, columns)) && !may_be_open(terrain, drawn, a, b))
                return say("an inner edge has no neighbour: a crack or T-junction beside", t);
        }
    return {};
}

} // namespace

std::vector<Triangle> triangles_of(const MeshView& mesh) {
    std::vector<Triangle> all;
    for (const TileRange& range : mesh.tiles)
        for_each_triangle(mesh, range, [&](const Triangle& t) {
            if (doubled_area_up(t) != 0) all.push_back(rotated(t));
        });
    std::sort(all.begin(), all.end(), [](const Triangle& a, const Triangle& b) {
        for (std::size_t i = 0; i < 3; ++i) {
            if (a[i].row != b[i].row) return a[i].row < b[i].row;
            if (a[i].column != b[i].column) return a[i].column < b[i].column;
        }
        return false;
    });
    return all;
}

std::string check_mesh(const Terrain& terrain, const MeshView& mesh) {
    std::vector<bool> drawn(terrain.tile_count());
    std::vector<std::int64_t> areas(terrain.tile_count());
    std::vector<bool> compared(mesh.vertices.size()); // with its sample: the same vertex is in about six triangles
    std::vector<Triangle> triangles;
    for (const TileRange& range : mesh.tiles) {
        if (range.tile >= terrain.tile_count()) return "a range names no tile";
        drawn[range.tile] = true;
        const SampleIndex corner = tile_corner(terrain, range.tile);
        std::string wrong;
        std::uint32_t count = 0;
        for (std::uint32_t i = 0; i < range.index_count; ++i) {
            const std::uint32_t index = mesh.indices[range.first_index + i];
            const MeshVertex& v = mesh.vertices[index];
            const SampleIndex at{v.column, v.row}, in_tile = at - corner;
            if (in_tile.column < 0 || in_tile.row < 0 || in_tile.column > data_of(terrain).tree.side() ||
                in_tile.row > data_of(terrain).tree.side())
                return "a vertex lies outside its tile";
            if (at.column >= data_of(terrain).tree.columns() || at.row >= data_of(terrain).tree.rows())
                return "a vertex lies outside the terrain";
            if (compared[index]) continue;
            compared[index] = true;
            if (v.height_m != data_of(terrain).height_m(at)) return "a vertex has not its sample's height";
        }
        for_each_triangle(mesh, range, [&](const Triangle& t) {
            const std::int64_t doubled = doubled_area_up(t);
            if (doubled < 0) wrong = say("faces down:", t);
            if (doubled == 0 && mesh.topology == Topology::triangles) wrong = say("degenerate:", t);
            areas[range.tile] += doubled;
            count += doubled != 0;
            if (doubled != 0) triangles.push_back(t);
        });
        if (!wrong.empty()) return wrong;
        if (count != range.triangles) return "a range counts its triangles wrongly";
    }
    for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile) {
        const SampleIndex corner = tile_corner(terrain, tile);
        const SampleIndex end = data_of(terrain).tree.sample(
            corner + SampleIndex{data_of(terrain).tree.side(), data_of(terrain).tree.side()});
        if (drawn[tile] && areas[tile] != 2 * std::int64_t{end.column - corner.column} * (end.row - corner.row))
            return "a tile is not covered exactly";
    }
    return check_edges(terrain, drawn, triangles);
}

} // namespace fjell::test
