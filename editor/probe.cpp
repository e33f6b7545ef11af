#include "editor/probe.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "baker/georeference/coordinates.h"
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

void update_probe(Probe& probe, const session::Session& session, const View& drawn, const View& refining, bool changed,
                  const baker::Coordinates* coordinates) {
    std::optional<ProbedGround> ground;
    if (probe.on && probe.pointer) ground = ground_under(session, drawn, (*probe.pointer)[0], (*probe.pointer)[1]);
    if (!ground) {
        probe.ground.reset();
        probe.looking = false;
        return;
    }
    const bool same = probe.ground && length(ground->position_m - probe.ground->position_m) == 0;
    if (same)
        ground->degrees = probe.ground->degrees;
    else if (coordinates != nullptr)
        ground->degrees = coordinates->degrees(ground->position_m.x, ground->position_m.z);
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

namespace {

double ground_at(const session::Session& session, double x_m, double z_m) {
    return ground_height(session.terrain(), x_m, z_m).height_m;
}

// Of the ground from one place to another, in steps of half a sample.
double ground_length_m(const session::Session& session, const Vec3& from, const Vec3& to) {
    const PackHeader& header = session.terrain().header();
    const double flat_m = std::hypot(to.x - from.x, to.z - from.z),
                 half_m = 0.5 * std::min(header.spacing_m[0], header.spacing_m[1]);
    constexpr double most_probed_steps = 20'000;
    const auto steps = static_cast<std::size_t>(std::clamp(std::ceil(flat_m / half_m), 1.0, most_probed_steps));
    const double step_m = flat_m / static_cast<double>(steps);
    double sum_m = 0, before_m = ground_at(session, from.x, from.z);
    for (std::size_t i = 1; i <= steps; ++i) {
        const double t = static_cast<double>(i) / static_cast<double>(steps);
        const double now_m = ground_at(session, from.x + t * (to.x - from.x), from.z + t * (to.z - from.z));
        sum_m += std::hypot(step_m, now_m - before_m);
        before_m = now_m;
    }
    return sum_m;
}

// Whether the polygon holds the place: how often its edges cross the way from there to the east.
bool encloses(std::span<const Vec3> corners, double x_m, double z_m) {
    bool inside = false;
    for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
        const Vec3 &a = corners[i], &b = corners[j];
        if ((a.z > z_m) != (b.z > z_m) && x_m < a.x + (b.x - a.x) * (z_m - a.z) / (b.z - a.z)) inside = !inside;
    }
    return inside;
}

// How much larger the ground inside the polygon is than its map: the mean over a grid of cells.
double ground_per_map(const session::Session& session, std::span<const Vec3> corners) {
    const PackHeader& header = session.terrain().header();
    const auto [west, east] = std::ranges::minmax(corners, {}, &Vec3::x);
    const auto [north, south] = std::ranges::minmax(corners, {}, &Vec3::z);
    constexpr double most_probed_cells = 160;
    const auto cells = [&](double extent_m, double spacing_m) {
        return static_cast<int>(std::clamp(std::ceil(2 * extent_m / spacing_m), 8.0, most_probed_cells));
    };
    const int columns = cells(east.x - west.x, header.spacing_m[0]),
              rows = cells(south.z - north.z, header.spacing_m[1]);
    const double wide_m = (east.x - west.x) / columns, deep_m = (south.z - north.z) / rows;
    double sum = 0;
    int inside = 0;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const double x_m = west.x + (column + 0.5) * wide_m, z_m = north.z + (row + 0.5) * deep_m;
            if (!encloses(corners, x_m, z_m)) continue;
            const double h = ground_at(session, x_m - wide_m / 2, z_m - deep_m / 2),
                         to_east = (ground_at(session, x_m + wide_m / 2, z_m - deep_m / 2) - h) / wide_m,
                         to_south = (ground_at(session, x_m - wide_m / 2, z_m + deep_m / 2) - h) / deep_m;
            sum += std::sqrt(1 + to_east * to_east + to_south * to_south);
            ++inside;
        }
    return inside == 0 ? 1 : sum / inside;
}

void sample_heights(HeightProfile& p, std::span<const Vec3> marks, const session::Session& session) {
    std::size_t leg = 1;
    double before_m = 0, leg_m = std::hypot(marks[1].x - marks[0].x, marks[1].z - marks[0].z);
    for (std::size_t i = 0; i < p.samples; ++i) {
        const double at_m = p.length_m * static_cast<double>(i) / (p.samples - 1);
        while (leg + 1 < marks.size() && at_m > before_m + leg_m) {
            before_m += leg_m;
            ++leg;
            leg_m = std::hypot(marks[leg].x - marks[leg - 1].x, marks[leg].z - marks[leg - 1].z);
        }
        const double t = leg_m > 0 ? std::min((at_m - before_m) / leg_m, 1.0) : 0;
        const Vec3 &from = marks[leg - 1], &to = marks[leg];
        p.place_m[i] = {from.x + t * (to.x - from.x), from.z + t * (to.z - from.z)};
        p.height_m[i] = static_cast<float>(ground_at(session, p.place_m[i][0], p.place_m[i][1]));
    }
    const auto [lowest, highest] = std::minmax_element(p.height_m.begin(), p.height_m.end());
    p.lowest_m = *lowest;
    p.highest_m = *highest;
}

} // namespace

void measure_profile(Probe& probe, const session::Session& session) {
    const std::span<Vec3> marks(probe.mark_m.data(), probe.marks);
    for (Vec3& mark : marks) mark.y = ground_at(session, mark.x, mark.z);
    if (marks.size() < 2) return;
    HeightProfile& p = probe.profile;
    p.length_m = p.ground_length_m = p.area_m2 = p.ground_area_m2 = 0;
    for (std::size_t i = 1; i < marks.size(); ++i) {
        p.length_m += std::hypot(marks[i].x - marks[i - 1].x, marks[i].z - marks[i - 1].z);
        p.ground_length_m += ground_length_m(session, marks[i - 1], marks[i]);
    }
    sample_heights(p, marks, session);
    if (marks.size() < 3) return;
    double twice_m2 = 0;
    for (std::size_t i = 0, j = marks.size() - 1; i < marks.size(); j = i++)
        twice_m2 += marks[j].x * marks[i].z - marks[i].x * marks[j].z;
    p.area_m2 = std::abs(twice_m2) / 2;
    p.ground_area_m2 = p.area_m2 * ground_per_map(session, marks);
}

void set_mark(Probe& probe, const session::Session& session, double x_m, double z_m) {
    if (probe.marks == most_marks) return;
    const session::Ground ground = session::ground_of(session.terrain());
    probe.mark_m[probe.marks++] = {std::clamp(x_m, 0.0, ground.extent_x_m), 0, std::clamp(z_m, 0.0, ground.extent_z_m)};
    measure_profile(probe, session);
}

void remove_mark(Probe& probe, const session::Session& session) {
    if (probe.marks == 0) return;
    --probe.marks;
    measure_profile(probe, session);
}

} // namespace fjell::editor
