#include "fjell/terrain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace fjell {

namespace {

// A geometry chunk is six planes of bytes: low and high bytes of heights, errors and radii, in vertex order. Bytes of
// one kind beside each other compress far better than records do.
void interleave(const std::byte* planes, std::uint32_t count, VertexRecord* records) {
    const auto word = [&](std::uint32_t plane, std::uint32_t i) {
        const auto low = std::to_integer<std::uint32_t>(planes[std::size_t{2 * plane} * count + i]);
        const auto high = std::to_integer<std::uint32_t>(planes[std::size_t{2 * plane + 1} * count + i]);
        return static_cast<std::uint16_t>(low | high << 8);
    };
    for (std::uint32_t i = 0; i < count; ++i) records[i] = {word(0, i), word(1, i), word(2, i), 0};
}

std::size_t record_bytes(const PackHeader& header) {
    const PlanarOrder order{static_cast<int>(header.tile_log2)};
    return std::size_t{header.tiles_x} * header.tiles_y * order.vertex_count() * sizeof(VertexRecord);
}

constexpr std::size_t alignment = 64;
constexpr std::size_t aligned(std::size_t bytes) {
    return (bytes + alignment - 1) / alignment * alignment;
}

} // namespace

// The tail of the block is where one chunk is decoded before it is interleaved.
std::size_t terrain_bytes(const PackHeader& header) {
    return aligned(record_bytes(header)) + chunk_raw_bytes(header, ChunkKind::geometry, 0);
}

Status load_terrain(const Pack& pack, std::span<std::byte> block, Terrain& terrain) {
    if (block.size() < terrain_bytes(pack.header)) return {Code::block_too_small, "block"};
    if (reinterpret_cast<std::uintptr_t>(block.data()) % alignment != 0) return {Code::out_of_range, "block alignment"};
    Terrain loaded;
    loaded.header = pack.header;
    loaded.tree = pack.tree();
    loaded.order = {static_cast<int>(pack.header.tile_log2)};
    loaded.lattice = {pack.header.base_m, pack.header.quantum_m};
    loaded.spacing_x_m = static_cast<float>(pack.header.spacing_m[0]);
    loaded.spacing_z_m = static_cast<float>(pack.header.spacing_m[1]);
    loaded.vertices_per_tile = loaded.order.vertex_count();
    auto* records = reinterpret_cast<VertexRecord*>(block.data());
    const std::span<std::byte> planes =
        block.subspan(aligned(record_bytes(pack.header)), chunk_raw_bytes(pack.header, ChunkKind::geometry, 0));
    for (std::uint32_t tile = 0; tile < pack.tile_count(); ++tile) {
        if (Status s = read_chunk(pack, ChunkKind::geometry, tile, 0, planes); !s.ok())
            return {s.code, "geometry chunk"};
        interleave(planes.data(), loaded.vertices_per_tile, records + std::size_t{tile} * loaded.vertices_per_tile);
    }
    loaded.records = records;
    terrain = loaded;
    return {};
}

const VertexRecord& Terrain::record(Coord vertex) const {
    const std::int32_t side = tree.side();
    const std::int32_t tx = std::min(vertex.x / side, tree.tiles_x - 1),
                       ty = std::min(vertex.y / side, tree.tiles_y - 1);
    const auto tile = static_cast<std::uint32_t>(ty * tree.tiles_x + tx);
    return tile_records(tile)[order.index(static_cast<std::uint32_t>(vertex.x - tx * side),
                                          static_cast<std::uint32_t>(vertex.y - ty * side))];
}

double Terrain::ground_m(double x, double z) const {
    const double column = std::clamp(x / header.spacing_m[0], 0.0, static_cast<double>(tree.columns() - 1));
    const double row = std::clamp(z / header.spacing_m[1], 0.0, static_cast<double>(tree.rows() - 1));
    const auto x0 = std::min(static_cast<std::int32_t>(column), tree.columns() - 2);
    const auto y0 = std::min(static_cast<std::int32_t>(row), tree.rows() - 2);
    const double u = column - x0, v = row - y0;
    const auto lerp = [](double a, double b, double t) { return a + (b - a) * t; };
    const double north = lerp(height_m({x0, y0}), height_m({x0 + 1, y0}), u);
    const double south = lerp(height_m({x0, y0 + 1}), height_m({x0 + 1, y0 + 1}), u);
    return lerp(north, south, v);
}

} // namespace fjell
