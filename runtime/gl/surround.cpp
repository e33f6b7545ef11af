#include "gl/surround.h"

#include <algorithm>
#include <cmath>

#include <epoxy/gl.h>

#include "fjell/gl/palette.h"
#include "fjell/query.h"

namespace fjell::gl {

namespace {

constexpr std::int32_t points_a_side = 96; // at most
// Rings: how far out, in diagonals of the terrain. The first two are the rim: its top and its foot.
constexpr std::array<double, 16> out_diagonals{0,    0,    0.004, 0.012, 0.025, 0.045, 0.075, 0.115,
                                               0.17, 0.25, 0.37,  0.55,  0.85,  1.4,   2.6,   6};
constexpr double level_diagonals = 0.6, accurate_diagonals = 2e-4;
constexpr std::size_t rings = out_diagonals.size();

float mix(float a, float b, float t) {
    return a + (b - a) * t;
}
double smooth_step(double t) {
    const double c = std::clamp(t, 0.0, 1.0);
    return c * c * (3 - 2 * c);
}

// The colour that a map has of a place, straight between texels. Texel centres of the first and the last column lie on
// the tile's border.
std::array<float, 3> colour_of(const RimColours& texels, double u, double v) {
    const std::uint32_t side = 1u << texels.side_log2;
    const auto split = [&](double at, std::uint32_t& first) {
        const double texel = std::clamp(at, 0.0, 1.0) * (side - 1);
        first = std::min(static_cast<std::uint32_t>(texel), side - 2);
        return static_cast<float>(texel - first);
    };
    std::uint32_t i = 0, j = 0;
    const float along = split(u, i), down = split(v, j);
    std::array<float, 3> colour{};
    for (std::uint32_t c = 0; c < 3; ++c) {
        const auto at = [&](std::uint32_t x, std::uint32_t y) {
            return static_cast<float>(to_linear(texels.rgb[(std::size_t{y} * side + x) * 3 + c]));
        };
        colour[c] = mix(mix(at(i, j), at(i + 1, j), along), mix(at(i, j + 1), at(i + 1, j + 1), along), down);
    }
    return colour;
}

// A quarter, a half, a quarter, round the closed line.
template <typename Field>
void smooth_ring(std::vector<SurroundVertex>& ring, Field field) {
    const std::size_t n = ring.size();
    const float first = field(ring[0]);
    float before = field(ring[n - 1]);
    for (std::size_t i = 0; i < n; ++i) {
        const float here = field(ring[i]), after = i + 1 < n ? field(ring[i + 1]) : first;
        field(ring[i]) = 0.25f * before + 0.5f * here + 0.25f * after;
        before = here;
    }
}

} // namespace

void Surround::find_points(const Terrain& terrain, const Maps& maps) {
    const PackHeader& header = terrain.header();
    const auto last_column = static_cast<std::int32_t>(terrain.columns()) - 1,
               last_row = static_cast<std::int32_t>(terrain.rows()) - 1;
    const std::int32_t side = 1 << header.tile_log2;
    std::int32_t stride = 1;
    while (stride < side && std::max(last_column, last_row) > stride * points_a_side) stride *= 2;
    const double dx = header.spacing_m[0], dz = header.spacing_m[1];
    const auto accurate_m = static_cast<float>(accurate_diagonals * std::hypot(last_column * dx, last_row * dz));
    complete_ = true;
    const auto ground_at = [&](double column, double row) {
        const GroundHeight ground = ground_height(terrain, std::clamp(column, 0.0, 1.0 * last_column) * dx,
                                                  std::clamp(row, 0.0, 1.0 * last_row) * dz, accurate_m);
        complete_ = complete_ && (ground.finest || ground.error_m <= accurate_m);
        return ground;
    };
    points_.clear();
    const auto add = [&](std::int32_t column, std::int32_t row) {
        Point p;
        p.column = p.out_column = column;
        p.row = p.out_row = row;
        const double in_column = 0.5 * last_column - column, in_row = 0.5 * last_row - row;
        const int steps = std::max(1, static_cast<int>(std::max(std::abs(in_column), std::abs(in_row)) / stride));
        GroundHeight ground = ground_at(column, row);
        const bool moved = ground.hole;
        for (int step = 1; ground.hole && step < steps; ++step) {
            p.column = column + in_column * step / steps;
            p.row = row + in_row * step / steps;
            ground = ground_at(p.column, p.row);
        }
        // The mesh between two points may be lower; where the rim was left, the ground's end is somewhere around.
        double low_m = ground.height_m;
        const double reach = moved ? stride : 0.5 * stride;
        for (const auto& [x, y] : {std::pair{-reach, 0.0}, {reach, 0.0}, {0.0, -reach}, {0.0, reach}}) {
            const GroundHeight beside = ground_at(p.column + x, p.row + y);
            if (!beside.hole) low_m = std::min(low_m, beside.height_m);
        }
        p.low_m = static_cast<float>(low_m);
        p.top_m = moved ? p.low_m : static_cast<float>(ground.height_m);
        const SampleIndex place{
            std::min(static_cast<std::int32_t>(p.column) / side, static_cast<std::int32_t>(header.tiles_x) - 1),
            std::min(static_cast<std::int32_t>(p.row) / side, static_cast<std::int32_t>(header.tiles_y) - 1)};
        const std::uint32_t tile = terrain.tile_at(place);
        p.colour = {0.2f, 0.19f, 0.15f};
        if (tile < maps.rim.size() && maps.rim[tile].side_log2 != 0)
            p.colour =
                colour_of(maps.rim[tile], (p.column - place.column * side) / side, (p.row - place.row * side) / side);
        points_.push_back(p);
    };
    // Clockwise from the north-west. The last step of a side may be shorter.
    const auto before = [stride](std::int32_t at) { return (at - 1) / stride * stride; };
    for (std::int32_t x = 0; x < last_column; x += stride) add(x, 0);
    for (std::int32_t y = 0; y < last_row; y += stride) add(last_column, y);
    for (std::int32_t x = last_column; x > 0; x = before(x)) add(x, last_row);
    for (std::int32_t y = last_row; y > 0; y = before(y)) add(0, y);
}

void Surround::fill_rings(const Terrain& terrain) {
    const std::size_t n = points_.size();
    const double dx = terrain.header().spacing_m[0], dz = terrain.header().spacing_m[1];
    const double half_x = 0.5 * (terrain.columns() - 1), half_z = 0.5 * (terrain.rows() - 1);
    const double diagonal_m = 2 * std::hypot(half_x * dx, half_z * dz);
    std::vector<float> heights;
    std::array<float, 3> mean{};
    for (const Point& p : points_) {
        heights.push_back(p.low_m);
        for (std::size_t c = 0; c < 3; ++c) mean[c] += p.colour[c] / static_cast<float>(n);
    }
    const auto quarter = heights.begin() + static_cast<std::ptrdiff_t>(n / 4);
    std::nth_element(heights.begin(), quarter, heights.end());
    const float level_m = *quarter;

    rings_.clear();
    std::vector<SurroundVertex> ring(n), placed(n);
    for (std::size_t k = 0; k < rings; ++k) {
        const double out_m = out_diagonals[k] * diagonal_m;
        for (std::size_t i = 0; k < 2 && i < n; ++i) {
            ring[i].height_m = k == 0 ? points_[i].top_m : points_[i].low_m;
            ring[i].colour = points_[i].colour;
        }
        for (int pass = k < 2 ? 0 : 1 << std::min<std::size_t>(k - 2, 5); pass > 0; --pass) {
            smooth_ring(ring, [](SurroundVertex& v) -> float& { return v.height_m; });
            for (std::size_t c = 0; c < 3; ++c)
                smooth_ring(ring, [c](SurroundVertex& v) -> float& { return v.colour[c]; });
        }
        const auto levelled = static_cast<float>(smooth_step(out_diagonals[k] / level_diagonals));
        const double from_end = smooth_step(out_diagonals[k] / 0.1);
        for (std::size_t i = 0; i < n; ++i) {
            const Point& p = points_[i];
            SurroundVertex& v = placed[i] = ring[i];
            // Away from the middle, so that rings get round and corners leave no crease.
            const double east_m = (p.out_column - half_x) * dx, south_m = (p.out_row - half_z) * dz,
                         grown = 1 + out_m / std::max(std::hypot(east_m, south_m), 1e-9);
            const double column = half_x + east_m * grown / dx, row = half_z + south_m * grown / dz;
            const bool at_rim = p.column == p.out_column && p.row == p.out_row;
            const double share = k < 2 ? 0 : at_rim ? 1 : from_end;
            v.column = static_cast<std::int32_t>(std::lround(p.column + (column - p.column) * share));
            v.row = static_cast<std::int32_t>(std::lround(p.row + (row - p.row) * share));
            v.height_m = mix(v.height_m, level_m, levelled);
            for (std::size_t c = 0; c < 3; ++c) v.colour[c] = mix(v.colour[c], mean[c], levelled);
            v.ground =
                k + 1 == rings ? 0.0f : static_cast<float>(std::exp(-out_diagonals[k] / surround_fade_diagonals));
        }
        rings_.insert(rings_.end(), placed.begin(), placed.end());
    }
    // Normals: along the line and outwards.
    for (std::size_t k = 0; k < rings; ++k)
        for (std::size_t i = 0; i < n; ++i) {
            const auto at = [&](std::size_t ring_at, std::size_t point) {
                const SurroundVertex& v = rings_[ring_at * n + point % n];
                return Vec3{v.column * dx, static_cast<double>(v.height_m), v.row * dz};
            };
            const std::size_t inner = k <= 2 ? 1 : k - 1, outer = std::min(std::max<std::size_t>(k + 1, 2), rings - 1);
            const Vec3 along = at(std::max<std::size_t>(k, 2), i + 1) - at(std::max<std::size_t>(k, 2), i + n - 1),
                       out = at(outer, i) - at(inner, i);
            Vec3 normal = cross(out, along);
            if (normal.y < 0) normal = normal * -1.0;
            const double length = std::sqrt(dot(normal, normal));
            if (length > 0)
                rings_[k * n + i].slope = {static_cast<float>(normal.x / length),
                                           static_cast<float>(normal.z / length)};
        }
}

void Surround::upload() {
    const auto n = static_cast<std::uint32_t>(points_.size());
    std::vector<std::uint32_t> indices; // outermost first: nothing writes depth
    for (std::uint32_t k = rings - 1; k-- > 0;)
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t a = k * n + i, b = k * n + (i + 1) % n, c = a + n, d = b + n;
            indices.insert(indices.end(), {a, b, c, b, d, c});
        }
    index_count_ = static_cast<std::uint32_t>(indices.size());
    const auto make = [](Buffer& buffer, std::size_t bytes, const void* from) {
        unsigned name = 0;
        glCreateBuffers(1, &name);
        glNamedBufferStorage(name, static_cast<GLsizeiptr>(bytes), from, 0);
        buffer = Buffer(name);
    };
    make(vertices_, rings_.size() * sizeof(SurroundVertex), rings_.data());
    make(indices_, indices.size() * sizeof(std::uint32_t), indices.data());
    array_ = VertexArray();
}

void Surround::follow(const Terrain& terrain, const Maps& maps) {
    // While pages come, not for each of them.
    const std::uint32_t loaded = terrain.pages_loaded();
    const bool heights = !complete_ && 2 * loaded >= 3 * std::max(seen_pages_, 1u);
    const bool colours = 2 * maps.rim_changes >= 3 * std::max(seen_colours_, std::uint64_t{1}) ||
                         (maps.rim_changes == maps.rim.size() && seen_colours_ != maps.rim_changes);
    if (!points_.empty() && !heights && !colours) return;
    seen_pages_ = loaded;
    seen_colours_ = maps.rim_changes;
    find_points(terrain, maps);
    fill_rings(terrain);
    upload();
}

void Surround::draw() {
    if (index_count_ == 0) return;
    if (array_.get() == 0) {
        unsigned name = 0;
        glCreateVertexArrays(1, &name);
        array_ = VertexArray(name);
        glVertexArrayVertexBuffer(name, 0, vertices_.get(), 0, sizeof(SurroundVertex));
        glVertexArrayElementBuffer(name, indices_.get());
        glVertexArrayAttribIFormat(name, 0, 2, GL_INT, offsetof(SurroundVertex, column));
        glVertexArrayAttribFormat(name, 1, 2, GL_FLOAT, GL_FALSE, offsetof(SurroundVertex, height_m));
        glVertexArrayAttribFormat(name, 2, 3, GL_FLOAT, GL_FALSE, offsetof(SurroundVertex, colour));
        glVertexArrayAttribFormat(name, 3, 2, GL_FLOAT, GL_FALSE, offsetof(SurroundVertex, slope));
        for (unsigned attribute = 0; attribute < 4; ++attribute) {
            glEnableVertexArrayAttrib(name, attribute);
            glVertexArrayAttribBinding(name, attribute, 0);
        }
    }
    glBindVertexArray(array_.get());
    glEnable(GL_DEPTH_CLAMP); // it ends in the air, not at the far plane
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(index_count_), GL_UNSIGNED_INT, nullptr);
    glDisable(GL_DEPTH_CLAMP);
}

const char* surround_vertex_shader() {
    return R"(
layout(location = 0) in ivec2 a_sample;
layout(location = 1) in vec2 a_height; // and how much of the ground is seen
layout(location = 2) in vec3 a_colour;
layout(location = 3) in vec2 a_slope;
out vec3 v_position;
out vec3 v_colour;
out vec2 v_slope;
out float v_ground;
void main() {
    vec2 cells = vec2(a_sample - tile.zw);
    v_position = vec3(cells.x * grid.x - eye.x, (a_height.x - eye.z) - eye.w, cells.y * grid.y - eye.y);
    v_ground = a_height.y;
    if (water.y > 0.0) { // it falls into the sea, which goes on instead
        v_position.y = mix(min(water.x - 20.0, v_position.y), v_position.y, smoothstep(0.75, 0.98, v_ground));
        v_ground = 1.0;
    }
    v_colour = a_colour;
    v_slope = a_slope;
    gl_Position = view_projection * vec4(v_position, 1.0);
}
)";
}

const char* surround_fragment_shader() {
    return R"(
in vec3 v_position;
in vec3 v_colour;
in vec2 v_slope;
in float v_ground;
layout(location = 0) out vec4 out_colour;
void main() {
    if (water.y > 0.0 && v_position.y < water.x + 0.5 + 2.0 * water.z) discard; // the sea was drawn
    float metres = length(v_position);
    vec3 direction = v_position / metres, normal = vec3(v_slope.x, sqrt(max(1.0 - dot(v_slope, v_slope), 0.0)), v_slope.y);
    vec3 colour = v_colour * (sun_at(v_position.y) * (0.31831 * max(dot(normal, sun.xyz), 0.0)) + sky_light(normal));
    colour = mix(haze_source(direction), colour, through_air(metres, v_position.y));
    out_colour = vec4(picture(mix(far_air(direction), colour, v_ground)), 1.0);
}
)";
}

} // namespace fjell::gl
