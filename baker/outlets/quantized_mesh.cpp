#include "baker/outlets/quantized_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <zlib.h>

namespace fjell::baker {

namespace {

class ByteStream {
public:
    template <typename T>
    void put(T value) {
        const auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
        bytes.insert(bytes.end(), raw.begin(), raw.end());
    }
    void align(std::size_t to) {
        while (bytes.size() % to != 0) bytes.push_back(std::byte{0});
    }
    std::vector<std::byte> bytes;
};

struct TileSphere {
    GlobePlace middle{};
    double radius = 0;
};
// About the middle of the box of all places.
TileSphere sphere_around(const std::vector<GlobePlace>& places) {
    GlobePlace low = places.front(), high = low;
    for (const GlobePlace& p : places)
        for (std::size_t axis = 0; axis < 3; ++axis)
            low[axis] = std::min(low[axis], p[axis]), high[axis] = std::max(high[axis], p[axis]);
    TileSphere s;
    for (std::size_t axis = 0; axis < 3; ++axis) s.middle[axis] = (low[axis] + high[axis]) / 2;
    for (const GlobePlace& p : places)
        s.radius = std::max(s.radius, std::hypot(p[0] - s.middle[0], p[1] - s.middle[1], p[2] - s.middle[2]));
    constexpr double rounding = 1e-9;
    s.radius *= 1 + rounding;
    return s;
}

// The place over a tile's middle that lies behind the horizon only when all of the tile does, in units of the
// ellipsoid's radii: https://cesium.com/blog/2013/05/09/computing-the-horizon-occlusion-point/ derives it.
GlobePlace horizon_place(const GlobePlace& towards, const std::vector<GlobePlace>& places, bool whole_globe) {
    const auto scaled = [](const GlobePlace& p) {
        return GlobePlace{p[0] / globe_radius_m, p[1] / globe_radius_m, p[2] / globe_polar_radius_m};
    };
    const auto length = [](const GlobePlace& p) { return std::hypot(p[0], p[1], p[2]); };
    GlobePlace d = scaled(towards);
    const double d_length = length(d);
    for (double& axis : d) axis /= d_length;
    constexpr double farthest = 1000; // for half of a globe
    // No place stands for all of a globe: what is no place is hidden by nothing.
    constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
    if (whole_globe) return {nowhere, nowhere, nowhere};
    double most = 1;
    for (const GlobePlace& place : places) {
        const GlobePlace p = scaled(place);
        const double r = std::max(1.0, length(p));
        const double cos_a = std::clamp((p[0] * d[0] + p[1] * d[1] + p[2] * d[2]) / length(p), -1.0, 1.0);
        const double sin_a = std::sqrt(1 - cos_a * cos_a), cos_b = 1 / r, sin_b = std::sqrt(1 - cos_b * cos_b);
        const double share = cos_a * cos_b - sin_a * sin_b;
        most = share > 1 / farthest ? std::max(most, 1 / share) : farthest;
    }
    return {d[0] * most, d[1] * most, d[2] * most};
}

// Two bytes of a unit vector, on an octahedron that is folded flat.
std::array<std::uint8_t, 2> oct_encoded(const GlobePlace& n) {
    const double sum = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
    double x = n[0] / sum, y = n[1] / sum;
    if (n[2] < 0) {
        const double folded = (1 - std::abs(y)) * (x < 0 ? -1 : 1);
        y = (1 - std::abs(x)) * (y < 0 ? -1 : 1);
        x = folded;
    }
    const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround((v * 0.5 + 0.5) * 255)); };
    return {byte(x), byte(y)};
}

void put_differences(ByteStream& out, const std::vector<std::int32_t>& values) {
    std::int32_t before = 0;
    for (const std::int32_t value : values) {
        const std::int32_t difference = value - before;
        out.put(static_cast<std::uint16_t>((difference << 1) ^ (difference >> 31)));
        before = value;
    }
}

void put_index(ByteStream& out, std::uint32_t index, bool wide) {
    if (wide)
        out.put(index);
    else
        out.put(static_cast<std::uint16_t>(index));
}

// Each index as its distance from the highest one so far.
void put_triangles(ByteStream& out, const TileMesh& mesh, bool wide) {
    out.put(static_cast<std::uint32_t>(mesh.triangles.size()));
    std::uint32_t next = 0;
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t index : triangle) {
            put_index(out, next - index, wide);
            next = std::max(next, index + 1);
        }
}

void put_sides(ByteStream& out, const TileMesh& mesh, bool wide) {
    for (const auto side : {TileSide::west, TileSide::south, TileSide::east, TileSide::north}) {
        const bool upright = side == TileSide::west || side == TileSide::east;
        const std::int32_t across = side == TileSide::west || side == TileSide::south ? 0 : tile_grid;
        std::vector<std::pair<std::int32_t, std::uint32_t>> found;
        for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
            const SampleIndex at = mesh.vertices[i].at;
            if ((upright ? at.column : at.row) == across) found.emplace_back(upright ? at.row : at.column, i);
        }
        std::sort(found.begin(), found.end());
        out.put(static_cast<std::uint32_t>(found.size()));
        for (const auto& [along, index] : found) put_index(out, index, wide);
    }
}

void put_extension(ByteStream& out, std::uint8_t id, std::span<const std::byte> bytes) {
    out.put(id);
    out.put(static_cast<std::uint32_t>(bytes.size()));
    out.bytes.insert(out.bytes.end(), bytes.begin(), bytes.end());
}

// Steps from the lowest vertex up, so many that 15 bits count them all: whole ones, so that neighbours' common vertices
// stay equal.
struct HeightSteps {
    double low_m, step_m;
};
HeightSteps steps_of(double low_m, double high_m, double largest_m) {
    double step_m = largest_m;
    if (high_m - low_m > step_m * quantized_most)
        throw Failure(1, fmt::format("a tile spans {} m of height, too much for its level; give a lower --max-level",
                                     high_m - low_m));
    constexpr double finest_m = 1.0 / 4096;
    constexpr double exact = 1 << 24; // whole numbers that a float holds: the header's heights are floats
    const double farthest_m = std::max(std::abs(low_m), std::abs(high_m));
    while (step_m / 2 >= finest_m && high_m - low_m <= step_m / 2 * quantized_most &&
           farthest_m + step_m * quantized_most < step_m / 2 * exact)
        step_m /= 2;
    return {low_m, step_m};
}

} // namespace

EncodedTile encode_quantized_mesh(const TileMesh& mesh, double height_step_m, const TileExtensions& extensions) {
    std::vector<GlobePlace> places;
    EncodedTile tile{{}, mesh.vertices.front().height_m, mesh.vertices.front().height_m};
    for (const TileMesh::Vertex& v : mesh.vertices) {
        places.push_back(on_globe(mesh.place(v), v.height_m));
        tile.low_m = std::min(tile.low_m, v.height_m), tile.high_m = std::max(tile.high_m, v.height_m);
    }
    const HeightSteps steps = steps_of(tile.low_m, tile.high_m, height_step_m);
    const TileSphere sphere = sphere_around(places);
    ByteStream out;
    for (const double axis : sphere.middle) out.put(axis);
    out.put(static_cast<float>(steps.low_m));
    out.put(static_cast<float>(steps.low_m + steps.step_m * quantized_most));
    for (const double axis : sphere.middle) out.put(axis);
    out.put(sphere.radius);
    for (const double axis : horizon_place(sphere.middle, places, mesh.box.east - mesh.box.west > 180)) out.put(axis);
    const std::size_t count = mesh.vertices.size();
    std::vector<std::int32_t> u(count), v(count), h(count);
    for (std::size_t i = 0; i < count; ++i) {
        u[i] = quantized(mesh.vertices[i].at.column);
        v[i] = quantized(mesh.vertices[i].at.row);
        h[i] = static_cast<std::int32_t>(std::lround((mesh.vertices[i].height_m - steps.low_m) / steps.step_m));
    }
    out.put(static_cast<std::uint32_t>(count));
    put_differences(out, u);
    put_differences(out, v);
    put_differences(out, h);
    const bool wide = count > 65536;
    out.align(wide ? 4 : 2);
    put_triangles(out, mesh, wide);
    put_sides(out, mesh, wide);
    if (!extensions.normals.empty()) {
        std::vector<std::byte> encoded;
        for (const GlobePlace& n : extensions.normals)
            for (const std::uint8_t byte : oct_encoded(n)) encoded.push_back(std::byte{byte});
        put_extension(out, 1, encoded);
    }
    if (!extensions.water.empty()) put_extension(out, 2, extensions.water);
    constexpr double digits = 1e4; // rounded up
    std::string metadata = fmt::format(R"({{"geometricerror":{:.4f})", std::ceil(mesh.error_m * digits) / digits);
    metadata += extensions.available.empty() ? "}" : R"(,"available":)" + extensions.available + "}";
    ByteStream text;
    text.put(static_cast<std::uint32_t>(metadata.size()));
    for (const char c : metadata) text.put(c);
    put_extension(out, 4, text.bytes);
    tile.bytes = std::move(out.bytes);
    return tile;
}

std::vector<std::byte> gzip(std::span<const std::byte> bytes) {
    z_stream stream{};
    constexpr int with_gzip_header = 16;
    if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, MAX_WBITS + with_gzip_header, MAX_MEM_LEVEL,
                     Z_DEFAULT_STRATEGY) != Z_OK)
        throw Failure(3, "zlib: no memory");
    std::vector<std::byte> out(deflateBound(&stream, bytes.size()));
    stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    const int result = deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    if (result != Z_STREAM_END) throw Failure(3, "zlib: a tile could not be compressed");
    return out;
}

} // namespace fjell::baker
