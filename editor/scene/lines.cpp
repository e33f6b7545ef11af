#include "editor/scene/lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "fjell/gl/palette.h"
#include "fjell/pages.h"
#include "fjell/query.h"
#include "shared/order.h"

namespace fjell::editor {

namespace {

constexpr gl::Rgba8 path_rgba{255, 120, 200, 210}, selected_rgba{255, 255, 255, 255}, recorded_rgba{240, 105, 95, 230};
constexpr double point_px = 10, selected_px = 14, apart_px = 16;

Vec3 place_of(const session::ControlPoint& p) {
    return {p[0], p[1], p[2]};
}

// Through n places, by no more than most_route_pieces straight lines.
template <typename Place>
void add_way(std::size_t n, const Place& place, gl::Rgba8 rgba, std::vector<gl::Line>& to) {
    if (n < 2) return;
    const std::size_t pieces = std::min(n - 1, most_route_pieces);
    Vec3 from = place(0);
    for (std::size_t i = 1; i <= pieces; ++i) {
        const Vec3 next = place(i * (n - 1) / pieces);
        to.push_back({from, next, rgba});
        from = next;
    }
}

// In pixels from the picture's middle; none: behind the eye.
std::optional<std::array<double, 2>> seen_px(const Vec3& place, const View& view) {
    const Vec3 way = place - view.eye_m;
    const double ahead_m = dot(way, view.forward);
    if (ahead_m <= view.near_m) return {};
    const double scale = focal_length_px(view) / ahead_m;
    return std::array{dot(way, cross(view.forward, view.up)) * scale, dot(way, view.up) * scale};
}

void add_square(const Vec3& centre, const View& view, double side_px, gl::Rgba8 rgba, std::vector<gl::Line>& to) {
    const double ahead_m = dot(centre - view.eye_m, view.forward);
    if (ahead_m <= view.near_m) return;
    const double half_m = side_px / (2 * focal_length_px(view)) * ahead_m;
    const Vec3 up = view.up * half_m, right = cross(view.forward, view.up) * half_m;
    const Vec3 corners[] = {centre - right - up, centre + right - up, centre + right + up, centre - right + up};
    for (std::size_t i = 0; i < 4; ++i) to.push_back({corners[i], corners[(i + 1) % 4], rgba});
}

} // namespace

void add_route_lines(const Route& route, const View& view, std::vector<gl::Line>& to) {
    const auto& poses = route.poses();
    add_way(
        poses.size(), [&](std::size_t i) { return poses[i].position_m; }, path_rgba, to);
    const auto& recorded = route.recorded_points();
    add_way(
        recorded.size(), [&](std::size_t i) { return place_of(recorded[i]); }, recorded_rgba, to);
    const auto& points = route.points();
    const std::size_t step = points.size() / most_route_marks + 1;
    // Squares that would lie over each other are one: those of a path of many points, from afar, would be a bar.
    std::optional<std::array<double, 2>> before;
    for (std::size_t i = 0; i < points.size(); i += step) {
        const auto now = seen_px(place_of(points[i]), view);
        if (!now || route.selected() == i) continue;
        if (before && std::hypot((*now)[0] - (*before)[0], (*now)[1] - (*before)[1]) < apart_px) continue;
        before = now;
        add_square(place_of(points[i]), view, point_px, path_rgba, to);
    }
    if (route.selected()) add_square(place_of(points[*route.selected()]), view, selected_px, selected_rgba, to);
}

namespace {

constexpr gl::Rgba8 frustum_rgba{255, 255, 255, 230}, culled_rgba{255, 70, 60, 200}, tile_rgba{255, 220, 120, 130};
constexpr std::size_t shown_tiles = 12; // with their spheres: more are a ball of wool

// In doubles: x_m() is a float, which jumps by centimetres where the terrain is a thousand kilometres wide.
Vec3 place_of(const Terrain& terrain, SampleIndex c, float height_m) {
    return {c.column * terrain.header().spacing_m[0], static_cast<double>(height_m),
            c.row * terrain.header().spacing_m[1]};
}

// A tile's corners are always loaded.
Vec3 corner(const Terrain& terrain, std::int32_t x, std::int32_t y) {
    const SampleIndex c = tree_of(terrain.header()).sample({x, y});
    return place_of(terrain, c, terrain_vertex(terrain, {x, y}).height_m);
}

SampleIndex tile_origin(const Terrain& terrain, std::uint32_t tile) {
    const SampleIndex place = terrain.tile_place(tile);
    return {place.column * tree_of(terrain.header()).side(), place.row * tree_of(terrain.header()).side()};
}

gl::Rgba8 level_rgba(const Terrain& terrain, SampleIndex v) {
    const gl::Rgb8 rgb =
        gl::level_rgb(tree_of(terrain.header()).level(v), static_cast<int>(terrain.header().tile_log2));
    return {rgb[0], rgb[1], rgb[2], 220};
}

} // namespace

SceneLines::SceneLines() {
    lines_.reserve(most_lines);
    balls_.reserve(most_balls);
}

void SceneLines::build(const State& state, const session::Session& session) {
    lines_.clear();
    balls_.clear();
    if (state.eye.refining) {
        const Scene& s = state.scene;
        const double length_m = std::min(state.eye.refining->far_m, std::hypot(s.width_m(), s.depth_m()));
        lines_.resize(12);
        gl::frustum_lines(*state.eye.refining, length_m, frustum_rgba, std::span<gl::Line, 12>(lines_));
    }
    // Flying along it, the line would be in the eye.
    if (state.shows(Overlay::path) && !state.route.playing()) add_route_lines(state.route, state.eye.view, lines_);
    if (state.shows(Overlay::culled)) add_culled(session);
    if (state.shows(Overlay::spheres)) {
        add_tile_spheres(session, state.eye.view);
        add_chain(session, state.eye.view);
    }
}

// Crossed out: the four borders between corners, and both diagonals.
void SceneLines::add_culled(const session::Session& session) {
    const Terrain& terrain = session.terrain();
    drawn_.assign(terrain.tile_count(), false);
    for (const TileRange& range : session.mesh().tiles)
        if (range.index_count != 0) drawn_[range.tile] = true;
    const std::int32_t side = tree_of(terrain.header()).side();
    for (std::uint32_t tile = 0; tile < terrain.tile_count() && lines_.size() + 6 <= most_lines; ++tile) {
        if (drawn_[tile]) continue;
        const SampleIndex o = tile_origin(terrain, tile);
        const Vec3 nw = corner(terrain, o.column, o.row), ne = corner(terrain, o.column + side, o.row);
        const Vec3 sw = corner(terrain, o.column, o.row + side), se = corner(terrain, o.column + side, o.row + side);
        for (const auto& [a, b] : {std::pair{nw, ne}, {ne, se}, {se, sw}, {sw, nw}, {nw, se}, {ne, sw}})
            lines_.push_back({a, b, culled_rgba});
    }
}

// The sphere of a tile's centre bounds all vertices inside the tile.
void SceneLines::add_tile_spheres(const session::Session& session, const View& view) {
    const Terrain& terrain = session.terrain();
    const std::int32_t half = tree_of(terrain.header()).side() / 2;
    near_.clear();
    std::uint32_t last = terrain.tile_count();
    for (const TileRange& range : session.mesh().tiles) { // a tile's ranges follow each other
        if (range.index_count == 0 || range.tile == last) continue;
        last = range.tile;
        const SampleIndex o = tile_origin(terrain, last);
        const SampleIndex c = tree_of(terrain.header()).sample({o.column + half, o.row + half});
        near_.push_back({length(place_of(terrain, c, terrain.header().min_m) - view.eye_m), last});
    }
    const std::size_t count = std::min(near_.size(), shown_tiles);
    std::partial_sort(near_.begin(), near_.begin() + static_cast<std::ptrdiff_t>(count), near_.end(),
                      [](const Near& a, const Near& b) { return a.distance_m < b.distance_m; });
    for (std::size_t i = 0; i < count; ++i) {
        const SampleIndex o = tile_origin(terrain, near_[i].tile), c{o.column + half, o.row + half};
        const TerrainVertex v = terrain_vertex(terrain, c);
        if (!v.loaded) continue;
        balls_.push_back({place_of(terrain, tree_of(terrain.header()).sample(c), v.height_m),
                          static_cast<double>(v.radius_m), tile_rgba});
    }
}

// The spheres over one another under the picture's middle: a vertex, its parent, and so on up to its tile's centre.
void SceneLines::add_chain(const session::Session& session, const View& view) {
    const Terrain& terrain = session.terrain();
    const GroundHit hit = cast_ray(terrain, view.eye_m, view.forward, view.far_m);
    if (!hit.hit) return;
    const auto sample = [](double metres, double spacing_m, std::int32_t count) {
        return std::clamp(static_cast<std::int32_t>(std::lround(metres / spacing_m)), 0, count - 1);
    };
    const Tree tree = tree_of(terrain.header());
    SampleIndex v{sample(hit.position_m.x, terrain.header().spacing_m[0], tree.columns()),
                  sample(hit.position_m.z, terrain.header().spacing_m[1], tree.rows())};
    while (!tree.is_corner(v) && balls_.size() < most_balls) {
        const TerrainVertex vertex = terrain_vertex(terrain, v);
        if (vertex.loaded && vertex.radius_m > 0)
            balls_.push_back(
                {place_of(terrain, v, vertex.height_m), static_cast<double>(vertex.radius_m), level_rgba(terrain, v)});
        const Diamond d = diamond(tree, v);
        const SampleIndex up = tree.contains(d.apexes[0]) ? d.apexes[0] : d.apexes[1];
        if (tree.is_corner(up)) break;
        v = up;
    }
}

} // namespace fjell::editor
