#include "fjell/gltf/snapshot.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>
#include <span>
#include <sstream>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "fjell/texture.h"
#include "gltf/refused.h"
#include "gltf/scene.h"
#include "io/file.h"
#include "pack/terrain_data.h"

namespace fjell::gltf {

namespace {

using Json = nlohmann::json;

constexpr std::uint64_t most_file_bytes = 0xffff'ffff;
constexpr std::uint64_t container_bytes = 12 + 8 + 8; // header and the heads of two chunks

void require(const Status& status, const char* what) {
    if (!status.ok())
        throw io::Failure(1, fmt::format("{}: {} ({}); bake the pack again", what, message(status.code), status.field));
}

void check(const Pack& pack, const Terrain& terrain, const MeshView& mesh, const SnapshotInfo& info) {
    if (const Status status = validate(info.view); !status.ok())
        throw io::Failure(2, fmt::format("{}: {}", status.field, message(status.code)));
    if (!(info.error_px > 0 && info.error_px_effective > 0 && std::isfinite(info.error_px_effective)))
        throw io::Failure(2, "SnapshotInfo::error_px and error_px_effective must be above zero and finite");
    if (mesh.topology != Topology::triangles)
        throw io::Failure(2, "the snapshot needs a triangle list; set RefineSettings::topology to Topology::triangles");
    if (pack.header.header_hash != terrain.header().header_hash || !terrain.valid())
        throw io::Failure(2, "the terrain was not loaded from this pack; load it with load_terrain");
}

// The largest mip of the colour map that fits, and what it is worth: 0 texels when the pack has no colour.
struct ColourMip {
    std::uint32_t level = 0, side_px = 0;
};

ColourMip choose_mip(const PackHeader& header, std::uint32_t max_texture_px) {
    const std::uint32_t mips = mip_count(header.colour_log2);
    if (mips == 0) return {};
    std::uint32_t level = 0;
    while (level + 1 < mips && (1u << (header.colour_log2 - level)) > max_texture_px) ++level;
    return {level, 1u << (header.colour_log2 - level)};
}

Json crs_of(const Pack& pack) {
    if (pack.header.crs_bytes == 0) return nullptr;
    std::string wkt(pack.header.crs_bytes, '\0');
    require(read_chunk(pack, {ChunkKind::crs, 0, 0}, std::as_writable_bytes(std::span(wkt))), "the pack's CRS chunk");
    return wkt;
}

// The fields of extras.fjell, with exactly these names: checkers know nothing else about the file.
Json extras(const Pack& pack, const SnapshotInfo& info, const SnapshotResult& counts) {
    const PackHeader& h = pack.header;
    const View& view = info.view;
    return {{"error_px", info.error_px},
            {"error_px_effective", info.error_px_effective},
            {"quantum_m", static_cast<double>(h.quantum_m)},
            {"viewport", {view.width_px, view.height_px}},
            {"fov_y_deg", 2 * std::atan(std::max(view.top, -view.bottom)) * 180 / std::numbers::pi},
            {"eye", {view.eye_m.x, view.eye_m.y, view.eye_m.z}},
            {"spacing_m", {h.spacing_m[0], h.spacing_m[1]}},
            {"origin_m", {h.origin_m[0], h.origin_m[1]}},
            {"crs", crs_of(pack)},
            {"size", {h.columns, h.rows}},
            {"converged", info.converged},
            {"morphed", info.morphed},
            {"vertices", counts.vertices},
            {"triangles", counts.triangles},
            {"pack_hash", fmt::format("{:016x}", h.directory_hash)}};
}

void add_tiles(const Pack& pack, const Terrain& terrain, const MeshView& mesh, const SnapshotOptions& options,
               SceneBuilder& scene, SnapshotResult& result) {
    const ColourMip mip = choose_mip(pack.header, options.max_texture_px);
    result.texture_px = mip.side_px;
    std::vector<std::byte> blocks(mip.side_px ? chunk_raw_bytes(pack.header, {ChunkKind::colour, 0, mip.level}) : 0);
    std::vector<std::uint8_t> rgb(std::size_t{mip.side_px} * mip.side_px * 3);
    TileCollector collector(terrain, mip.side_px);
    std::uint64_t done = 0;
    for (const TileRange& range : mesh.tiles) {
        if (options.progress && !options.progress(done++, mesh.tiles.size()))
            throw io::Failure(130, "stopped; nothing is written");
        const TileGeometry geometry = collector.collect(mesh, range);
        if (geometry.indices.empty()) continue;
        const std::string name =
            fmt::format("tile {} {}", range.tile % pack.header.tiles_x, range.tile / pack.header.tiles_x);
        int texture = -1;
        if (mip.side_px) {
            require(read_chunk(pack, {ChunkKind::colour, range.tile, mip.level}, blocks), "the pack's colour chunk");
            (void)decode_colour(blocks, mip.side_px, rgb);
            texture = scene.add_texture(name, mip.side_px, std::as_bytes(std::span(rgb)));
        }
        scene.add_tile(name, geometry, {collector.tile_x_m(range.tile), 0, collector.tile_z_m(range.tile)}, texture);
        ++result.tiles;
        result.vertices += geometry.vertices.size();
        result.triangles += geometry.indices.size() / 3;
    }
    if (result.tiles == 0)
        throw io::Failure(2, "the mesh has no triangle; refine it with culling off before the snapshot");
}

// tinygltf's JSON, completed with what it cannot say: the buffer (whose bytes it does not hold) and the extras.
std::string json_chunk(const SceneBuilder& scene, Json fjell_extras) {
    tinygltf::TinyGLTF writer;
    std::ostringstream text;
    if (!writer.WriteGltfSceneToStream(&scene.model(), text, false, false))
        throw io::Failure(3, "tinygltf could not serialise the scene; report it with the command line");
    Json document = Json::parse(text.str());
    document["buffers"] = Json::array({{{"byteLength", scene.binary_bytes()}}});
    document["scenes"][0]["extras"]["fjell"] = std::move(fjell_extras);
    // A CRS comes from a file and may hold anything; JSON must be UTF-8.
    std::string chunk = document.dump(-1, ' ', false, Json::error_handler_t::replace);
    chunk.resize((chunk.size() + 3) / 4 * 4, ' ');
    return chunk;
}

// The container (glTF 2.0, section 4.4): a header of 12 bytes, then chunks of length, type and data, all in words of 4.
std::uint64_t write_glb(const SceneBuilder& scene, const std::string& json, std::uint64_t max_file_bytes,
                        const std::string& path, bool write) {
    const std::uint64_t total = container_bytes + json.size() + scene.binary_bytes();
    if (total > max_file_bytes)
        throw io::Failure(
            1, fmt::format("{}: the snapshot needs {} bytes, more than the {} that are allowed; ask for a larger "
                           "error_px or smaller textures (max_texture_px)",
                           path, total, max_file_bytes));
    if (!write) return total;
    io::AtomicFile file(path);
    const auto words = [&](std::initializer_list<std::uint32_t> list) {
        file.write(std::as_bytes(std::span(list.begin(), list.size())));
    };
    words({0x46546c67, 2, static_cast<std::uint32_t>(total)});
    words({static_cast<std::uint32_t>(json.size()), 0x4e4f534a});
    file.write(std::as_bytes(std::span(json)));
    words({static_cast<std::uint32_t>(scene.binary_bytes()), 0x004e4942});
    for (const auto& piece : scene.pieces()) file.write(piece);
    file.commit();
    return total;
}

} // namespace

SnapshotResult write_snapshot(const Pack& pack, const Terrain& terrain, const MeshView& mesh, const SnapshotInfo& info,
                              const std::string& path, const SnapshotOptions& options) {
    try {
        if (path.empty() && options.write)
            throw io::Failure(2, "the snapshot has no file name; give one that ends in .glb");
        check(pack, terrain, mesh, info);
        if (options.write) {
            const io::AtomicFile probe(path); // says what is wrong with the place before seconds of work, not after
        }
        const std::uint64_t max_file_bytes = std::min(options.max_file_bytes, most_file_bytes);
        SnapshotResult result;
        result.converged = info.converged;
        SceneBuilder scene(max_file_bytes);
        add_tiles(pack, terrain, mesh, options, scene, result);
        scene.add_camera(info.view);
        result.file_bytes =
            write_glb(scene, json_chunk(scene, extras(pack, info, result)), max_file_bytes, path, options.write);
        return result;
    } catch (const io::Failure& failure) {
        return refused(failure.exit_code, failure.what());
    } catch (const std::bad_alloc&) {
        return refused(3, "not enough memory for the snapshot; ask for a larger error_px or smaller textures");
    } catch (const std::exception& error) {
        return refused(3, fmt::format("{}: cannot write the snapshot: {}", path, error.what()));
    }
}

} // namespace fjell::gltf
