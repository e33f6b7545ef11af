#include "editor/probe.h"

#include <algorithm>
#include <cmath>

#include "editor/measures.h"
#include "fjell/pages.h"
#include "fjell/query.h"
#include "session/session.h"

namespace fjell::editor {

namespace {

std::int32_t nearest_sample(double metres, double spacing_m, std::int32_t count) {
    return std::clamp(static_cast<std::int32_t>(std::lround(metres / spacing_m)), 0, count - 1);
}

// What is under the pointer; its mesh is looked for.
std::optional<ProbedGround> ground_under(const session::Session& session, const View& view, double x, double y) {
    const Terrain& terrain = session.terrain();
    const PackHeader& header = terrain.header();
    const GroundHit hit = cast_ray(terrain, view.eye_m, direction_at(view, x, y), view.far_m);
    if (!hit.hit) return {};
    ProbedGround g;
    g.position_m = hit.position_m;
    g.distance_m = length(hit.position_m - view.eye_m);
    g.slope_rad = std::acos(std::clamp(hit.normal.y, -1.0, 1.0));
    g.error_m = static_cast<double>(hit.error_m);
    g.finest = hit.finest;
    const std::int32_t columns = static_cast<std::int32_t>(header.columns),
                       rows = static_cast<std::int32_t>(header.rows), side = 1 << header.tile_log2, inside = side - 1;
    const double spacing_x = header.spacing_m[0], spacing_z = header.spacing_m[1];
    g.sample = {nearest_sample(hit.position_m.x, spacing_x, columns),
                nearest_sample(hit.position_m.z, spacing_z, rows)};
    // The cell, whose middle no other tile or page has.
    const auto cell = [&](double metres, double spacing, std::int32_t count) {
        return std::clamp(static_cast<std::int32_t>(metres / spacing), 0, count - 2);
    };
    const std::int32_t cx = cell(hit.position_m.x, spacing_x, columns), cy = cell(hit.position_m.z, spacing_z, rows);
    g.tile_x = static_cast<std::uint32_t>(cx / side);
    g.tile_y = static_cast<std::uint32_t>(cy / side);
    g.page =
        page_of(header, static_cast<std::uint32_t>((cx & inside) | 1), static_cast<std::uint32_t>((cy & inside) | 1));
    return g;
}

// A triangle of the mesh, and heights as they are drawn.
struct DrawnMesh {
    MeshView mesh;
    CutMesh cut; // its morphing, if it has any
    const Terrain& terrain;

    [[nodiscard]] const MeshVertex& vertex(std::size_t index) const { return mesh.vertices[mesh.indices[index]]; }
    [[nodiscard]] double height_m(std::size_t index) const {
        const std::uint32_t slot = mesh.indices[index];
        if (cut.morph.empty()) return static_cast<double>(mesh.vertices[slot].height_m);
        return static_cast<double>(morphed_height_m(terrain, mesh.vertices[slot], cut.morph[slot], cut.frame));
    }
};

// The height of the triangle of three indices from `first` on at a place in samples; none where it is not over it.
std::optional<double> height_over(const DrawnMesh& drawn, std::size_t first, double column, double row) {
    const MeshVertex &a = drawn.vertex(first), &b = drawn.vertex(first + 1), &c = drawn.vertex(first + 2);
    const double bx = b.column - a.column, by = b.row - a.row, cx = c.column - a.column, cy = c.row - a.row;
    const double px = column - a.column, py = row - a.row, area = bx * cy - by * cx;
    if (area == 0) return {};
    const double v = (px * cy - py * cx) / area, w = (bx * py - by * px) / area;
    constexpr double rounding = -1e-9; // a place on an edge is over either side
    if (v < rounding || w < rounding || v + w > 1 - rounding) return {};
    return drawn.height_m(first) * (1 - v - w) + drawn.height_m(first + 1) * v + drawn.height_m(first + 2) * w;
}

// Goes on with the search where it stands, some triangles further.
void look_for_mesh(Probe& probe, const session::Session& session, const View& refining) {
    const DrawnMesh drawn{session.mesh(), session.method->mesh(), session.terrain()};
    ProbedGround& g = *probe.ground;
    const PackHeader& header = session.terrain().header();
    const std::uint32_t tile =
        session.terrain().tile_at({static_cast<std::int32_t>(g.tile_x), static_cast<std::int32_t>(g.tile_y)});
    const double column = g.position_m.x / header.spacing_m[0], row = g.position_m.z / header.spacing_m[1];
    const std::size_t step = drawn.mesh.topology == Topology::strip ? 1 : 3;
    std::size_t left = triangles_a_call;
    const auto next_range = [&] {
        ++probe.range;
        probe.triangle = 0;
        --probe.ranges_left;
        left -= std::min<std::size_t>(left, 1); // those of other tiles are not free either
    };
    while (probe.ranges_left > 0 && left > 0) {
        if (probe.range >= drawn.mesh.tiles.size()) probe.range = probe.triangle = 0;
        const TileRange& range = drawn.mesh.tiles[probe.range];
        if (range.tile != tile) {
            next_range();
            continue;
        }
        for (; probe.triangle + 3 <= range.index_count && left > 0; probe.triangle += step, --left) {
            const std::size_t first = range.first_index + probe.triangle;
            const std::optional<double> height_m = height_over(drawn, first, column, row);
            if (!height_m) continue;
            ProbedMesh m;
            m.level =
                triangle_level(drawn.vertex(first), drawn.vertex(first + 1), drawn.vertex(first + 2), header.tile_log2);
            m.height_m = *height_m;
            const double away_m = length(g.position_m - refining.eye_m);
            m.error_px = focal_length_px(refining) * std::abs(*height_m - g.position_m.y) / std::max(away_m, 1e-9);
            g.mesh = m;
            probe.looking = false; // the next search begins here, where most likely it ends too
            return;
        }
        if (probe.triangle + 3 > range.index_count) next_range();
    }
    if (probe.ranges_left == 0) probe.looking = false; // nothing is drawn here
}

} // namespace

Vec3 direction_at(const View& view, double x, double y) {
    const Vec3 right = cross(view.forward, view.up);
    return view.forward + right * (view.left + x * (view.right - view.left)) +
           view.up * (view.top - y * (view.top - view.bottom));
}

std::optional<std::array<double, 2>> place_in(const View& view, const Vec3& position_m) {
    const Vec3 way = position_m - view.eye_m;
    const double ahead_m = dot(way, view.forward);
    if (ahead_m <= view.near_m) return {};
    const double right = dot(way, cross(view.forward, view.up)) / ahead_m, up = dot(way, view.up) / ahead_m;
    return std::array{(right - view.left) / (view.right - view.left), (view.top - up) / (view.top - view.bottom)};
}

void update_probe(Probe& probe, const session::Session& session, const View& drawn, const View& refining,
                  bool changed) {
    std::optional<ProbedGround> ground;
    if (probe.on && probe.pointer) ground = ground_under(session, drawn, (*probe.pointer)[0], (*probe.pointer)[1]);
    if (!ground) {
        probe.ground.reset();
        probe.looking = false;
        return;
    }
    const bool same = probe.ground && length(ground->position_m - probe.ground->position_m) == 0;
    if (same && !changed) {
        ground->mesh = probe.ground->mesh;
    } else {
        probe.looking = true;
        // All ranges, and the first one's beginning once more.
        probe.ranges_left = session.mesh().tiles.size() + 1;
    }
    probe.ground = ground;
    if (probe.looking) look_for_mesh(probe, session, refining);
}

void measure_profile(Probe& probe, const session::Session& session) {
    if (probe.marks < 2) return;
    HeightProfile& p = probe.profile;
    const Vec3 &from = probe.mark_m[0], &to = probe.mark_m[1];
    p.length_m = std::hypot(to.x - from.x, to.z - from.z);
    for (std::size_t i = 0; i < p.samples; ++i) {
        const double t = static_cast<double>(i) / (p.samples - 1);
        p.height_m[i] = static_cast<float>(
            ground_height(session.terrain(), from.x + t * (to.x - from.x), from.z + t * (to.z - from.z)).height_m);
    }
    const auto [lowest, highest] = std::minmax_element(p.height_m.begin(), p.height_m.end());
    p.lowest_m = *lowest;
    p.highest_m = *highest;
    probe.mark_m[0].y = static_cast<double>(p.height_m.front());
    probe.mark_m[1].y = static_cast<double>(p.height_m.back());
}

void set_mark(Probe& probe, const session::Session& session, double x_m, double z_m) {
    const session::Ground ground = session::ground_of(session.terrain());
    const double x = std::clamp(x_m, 0.0, ground.extent_x_m), z = std::clamp(z_m, 0.0, ground.extent_z_m);
    if (probe.marks == probe.mark_m.size()) probe.marks = 0;
    probe.mark_m[probe.marks++] = {x, ground_height(session.terrain(), x, z).height_m, z};
    measure_profile(probe, session);
}

} // namespace fjell::editor
