#include "fjell/gltf/snapshot.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <new>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "fjell/io/live_terrain.h"
#include "fjell/io/pack_file.h"
#include "fjell/texture.h"
#include "gltf/content.h"
#include "gltf/geometry.h"
#include "gltf/scene.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::gltf {

namespace {

using Json = Glb::Json;

// The pack that textures and the CRS come from, in memory or in its file.
struct Chunks {
    const Pack& pack;
    const PackHeader& header;
    std::function<void(ChunkId id, std::vector<std::byte>& raw)> read; // decompressed; throws Failure
};

Chunks chunks_of(const Pack& pack) {
    return {pack, pack.header, [&pack](ChunkId id, std::vector<std::byte>& raw) {
                raw.resize(chunk_raw_bytes(pack.header, id));
                if (const Status s = read_chunk(pack, id, raw); !s.ok())
                    throw io::Failure(1, fmt::format("the pack's {}: {}", io::chunk_name(id), message(s.code)));
            }};
}

Chunks chunks_of(const io::PackFile& file) {
    return {file.pack(), file.pack().header,
            [&file](ChunkId id, std::vector<std::byte>& raw) { file.read_chunk(id, raw); }};
}

// The largest mip of a map that fits, and what it is worth: 0 texels when the pack has none.
struct MapMip {
    std::uint32_t level = 0, side_px = 0;
};

// tile_m: a tile's longer side. A mip's outer texel centres lie on the tile's border.
MapMip choose_mip(std::uint32_t map_log2, const SnapshotOptions& options, double tile_m) {
    const std::uint32_t mips = mip_count(map_log2);
    if (mips == 0) return {};
    const auto side = [&](std::uint32_t level) { return 1u << (map_log2 - level); };
    std::uint32_t level = 0;
    while (level + 1 < mips &&
           (side(level) > options.max_texture_px || tile_m / (side(level + 1) - 1) <= options.texel_m))
        ++level;
    return {level, side(level)};
}

// A map as a texture of another size, resampled bilinearly so that texel centres of both sizes begin and end on the
// border. code(c, x, y): what the map has for the texture's component c.
template <typename Code>
[[nodiscard]] std::vector<std::uint8_t> resampled(std::uint32_t side, std::uint32_t texture_px, const Code& code) {
    std::vector<std::uint8_t> rgb;
    rgb.reserve(std::size_t{texture_px} * texture_px * 3);
    const double step = static_cast<double>(side - 1) / (texture_px - 1);
    for (std::uint32_t j = 0; j < texture_px; ++j)
        for (std::uint32_t i = 0; i < texture_px; ++i) {
            const double x = i * step, y = j * step;
            const auto x0 = std::min(static_cast<std::uint32_t>(x), side - 2);
            const auto y0 = std::min(static_cast<std::uint32_t>(y), side - 2);
            const double u = x - x0, v = y - y0;
            for (std::uint32_t c = 0; c < 3; ++c)
                rgb.push_back(static_cast<std::uint8_t>(
                    std::lround((code(c, x0, y0) * (1 - u) + code(c, x0 + 1, y0) * u) * (1 - v) +
                                (code(c, x0, y0 + 1) * (1 - u) + code(c, x0 + 1, y0 + 1) * u) * v)));
        }
    return rgb;
}

Json crs_of(const Chunks& pack) {
    if (pack.header.crs_bytes == 0) return nullptr;
    std::vector<std::byte> wkt;
    pack.read({ChunkKind::crs, 0, 0}, wkt);
    return std::string(reinterpret_cast<const char*>(wkt.data()), wkt.size());
}

// The fields of extras.fjell, with exactly these names: checkers know nothing else about the file.
Json extras(const Chunks& pack, const SnapshotInfo& info, const SnapshotCounts& counts) {
    const PackHeader& h = pack.header;
    const View& view = info.view;
    Json all = {{"error_px", info.error_px},
                {"error_px_effective", info.error_bound_px},
                {"corner_safe", info.corner_safe},
                {"quantum_m", static_cast<double>(h.quantum_m)},
                {"viewport", {view.width_px, view.height_px}},
                {"fov_y_deg", 2 * std::atan(std::max(view.top, -view.bottom)) * 180 / std::numbers::pi},
                {"eye", {view.eye_m.x, view.eye_m.y, view.eye_m.z}},
                {"crs", crs_of(pack)},
                {"size", {h.columns, h.rows}},
                {"converged", info.converged},
                {"morphed", info.morphed},
                {"lagging", info.lagging},
                {"culled", info.culled},
                {"vertices", counts.vertices},
                {"triangles", counts.triangles},
                {"pack_hash", fmt::format("{:016x}", h.directory_hash)}};
    all.update(Json(io::place_json(h)));
    return all;
}

// The textures of one tile after the other, in buffers that are kept.
class Textures {
public:
    Textures(const Chunks& pack, const Paint& stamped, const SnapshotOptions& options)
        : pack_(pack), stamped_(stamped), paint_(options.paint), colours_as_(options.colours),
          colour_(mip_of(pack.header.colour_log2, options)), normal_(mip_of(pack.header.normal_log2, options)),
          horizon_(mip_of(pack.header.horizon_log2, options)) {
        // The texture coordinates are one set, so the textures are of one size.
        side_px_ = colour_.side_px ? colour_.side_px : normal_.side_px ? normal_.side_px : horizon_.side_px;
        if (!paint_) return;
        side_px_ = std::max(side_px_, 4u);
        while (options.texel_m > 0 && tile_m() / (side_px_ - 1) > options.texel_m &&
               2 * side_px_ <= options.max_texture_px)
            side_px_ *= 2;
    }

    [[nodiscard]] std::uint32_t colour_px() const { return colour_.side_px || paint_ ? side_px_ : 0; }
    [[nodiscard]] std::uint32_t normal_px() const { return normal_.side_px ? side_px_ : 0; }
    [[nodiscard]] std::uint32_t occlusion_px() const { return horizon_.side_px ? side_px_ : 0; }

    // Of a tile; without textures one of one texel.
    [[nodiscard]] TexelGrid texels() const {
        const double cells = std::ldexp(1.0, static_cast<int>(pack_.header.tile_log2));
        return {std::max(side_px_, 1u), std::max(side_px_, 1u), cells, cells};
    }

    // JPEG loses what normals and shares of the sky are for, so only colours are written so.
    [[nodiscard]] GlbTextures add(const TileGeometry& geometry, const std::string& name, SceneBuilder& scene) {
        GlbTextures added;
        const auto add_texture = [&](const char* kind, const std::vector<std::uint8_t>& rgb,
                                     SnapshotImage image = SnapshotImage::png) {
            return scene.add_texture(name + kind, side_px_, std::as_bytes(std::span(rgb)), image);
        };
        std::vector<std::uint8_t> normals;
        NormalAt normal_at;
        if (normal_.side_px) {
            normals = read<2>(ChunkKind::normal, normal_, geometry.tile, decode_normal, geometry.moved);
            normal_at = map_normals(normals, normal_.side_px, side_px_);
        }
        if (colour_px()) added.colour = add_texture(" colour", colours(geometry, normal_at), colours_as_);
        if (normal_px())
            added.normal =
                add_texture(" normal", normal_texture({geometry.vertices, geometry.indices}, texels(), normal_at));
        if (occlusion_px()) {
            const std::vector<std::uint8_t> planes =
                read<horizon_planes>(ChunkKind::horizon, horizon_, geometry.tile, decode_horizon);
            const auto sky = [&](std::uint32_t, std::uint32_t x, std::uint32_t y) {
                return static_cast<double>(
                    planes[(std::size_t{y} * horizon_.side_px + x) * horizon_planes + horizon_directions]);
            };
            added.occlusion = add_texture(" occlusion", resampled(horizon_.side_px, side_px_, sky));
        }
        return added;
    }

private:
    [[nodiscard]] MapMip mip_of(std::uint32_t map_log2, const SnapshotOptions& options) const {
        return choose_mip(map_log2, options, tile_m());
    }
    [[nodiscard]] double tile_m() const { // the longer side
        const PackHeader& h = pack_.header;
        return std::ldexp(std::max(h.spacing_m[0], h.spacing_m[1]), static_cast<int>(h.tile_log2));
    }

    template <std::size_t Channels, typename Decode>
    [[nodiscard]] std::vector<std::uint8_t> read(ChunkKind kind, const MapMip& mip, std::uint32_t tile,
                                                 const Decode& decode, std::span<const MovedNormals> moved = {}) {
        pack_.read({kind, tile, mip.level}, blocks_);
        for (const MovedNormals& m : moved)
            if (m.mip == mip.level) put_over(m, mip.side_px, blocks_);
        bool painted = false;
        if (kind == ChunkKind::colour) // without paint it stays as it is
            (void)paint_map(stamped_, MapKind::colour, tile, pack_.header.colour_log2 - mip.level, blocks_, painted);
        std::vector<std::uint8_t> texels(std::size_t{mip.side_px} * mip.side_px * Channels);
        (void)decode(blocks_, mip.side_px, texels);
        return texels;
    }

    [[nodiscard]] std::vector<std::uint8_t> colours(const TileGeometry& geometry, const NormalAt& normal_at) {
        std::vector<std::uint8_t> rgb;
        if (colour_.side_px) rgb = read<3>(ChunkKind::colour, colour_, geometry.tile, decode_colour);
        if (colour_.side_px && colour_.side_px != side_px_) {
            const auto code = [&](std::uint32_t c, std::uint32_t x, std::uint32_t y) {
                return static_cast<double>(rgb[(std::size_t{y} * colour_.side_px + x) * 3 + c]);
            };
            rgb = resampled(colour_.side_px, side_px_, code);
        }
        if (!paint_) return rgb;
        rgb.resize(std::size_t{side_px_} * side_px_ * 3, 128);
        const PackHeader& h = pack_.header;
        const std::uint32_t place = pack_.pack.tile_place(geometry.tile);
        const double cells = std::ldexp(1.0, static_cast<int>(h.tile_log2));
        const TexelGround ground = ground_of_texels({geometry.vertices, geometry.indices}, texels(), normal_at);
        paint_({geometry.tile, side_px_, place % h.tiles_x * cells * h.spacing_m[0],
                place / h.tiles_x * cells * h.spacing_m[1], cells * h.spacing_m[0] / (side_px_ - 1),
                cells * h.spacing_m[1] / (side_px_ - 1), ground.height_m, ground.slope_deg, rgb});
        return rgb;
    }

    const Chunks& pack_;
    const Paint& stamped_; // by StampShape::paint
    const std::function<void(const TileTexels&)>& paint_;
    SnapshotImage colours_as_;
    MapMip colour_, normal_, horizon_;
    std::uint32_t side_px_ = 0;
    std::vector<std::byte> blocks_;
};

// Columns and rows are whole numbers by themselves. Heights are in steps of the quantum, times a power of two, as fine
// as the relief of all tiles and directions allow: so a height that is not morphed stays as it is, but for a float's
// digits.
GlbLattice lattice_of(const PackHeader& h, const Snapshot::Content& content) {
    float low = content.tiles.front().low_m[1], high = content.tiles.front().high_m[1];
    for (const TileGeometry& tile : content.tiles)
        low = std::min(low, tile.low_m[1]), high = std::max(high, tile.high_m[1]);
    const double low_m = static_cast<double>(low), relief_m = static_cast<double>(high) - low_m;
    const double cells = std::ldexp(1.0, static_cast<int>(h.tile_log2));
    const auto cell_m = [&](int axis) { // as tile_corner_m() counts
        return static_cast<double>(static_cast<float>(cells * h.spacing_m[axis])) / cells;
    };
    constexpr double finest = 1.0 / 16; // of a quantum
    const double quantum_m = static_cast<double>(h.quantum_m);
    const double least_m = std::max(
        {quantum_m * finest, std::max(cell_m(0), cell_m(1)) / GlbLattice::most_different, relief_m / GlbLattice::most});
    double step_m = quantum_m;
    while (relief_m > step_m * GlbLattice::most) step_m *= 2;
    while (step_m / 2 >= least_m) step_m /= 2;
    return {{0, low_m, 0}, {cell_m(0), step_m, cell_m(1)}};
}

// How far a height is from that of the lattice, at most.
double rounding_m(const GlbLattice& lattice, const Snapshot::Content& content) {
    double most_m = 0;
    for (const TileGeometry& tile : content.tiles)
        for (const SnapshotVertex& v : tile.vertices) {
            const double height_m = static_cast<double>(v.position_m[1]);
            const double stored_m = lattice.offset[1] + lattice.scale[1] * lattice.nearest(height_m, 1);
            most_m = std::max(most_m, std::abs(stored_m - height_m));
        }
    return most_m;
}

void add_tiles(const Chunks& pack, const Snapshot::Content& content, const SnapshotOptions& options,
               SceneBuilder& scene, SnapshotCounts& counts) {
    Textures textures(pack, content.paint, options);
    counts.texture_px = textures.colour_px();
    counts.normal_px = textures.normal_px();
    counts.occlusion_px = textures.occlusion_px();
    std::uint64_t done = 0;
    for (const TileGeometry& geometry : content.tiles) {
        if (options.progress && !options.progress(done++, content.tiles.size()))
            throw io::Failure(130, "stopped; nothing is written");
        const std::uint32_t place = pack.pack.tile_place(geometry.tile);
        const std::string name = fmt::format("tile {} {}", place % pack.header.tiles_x, place / pack.header.tiles_x);
        const GlbTextures added = textures.add(geometry, name, scene);
        scene.add_tile(name, geometry, tile_corner_m(pack.pack, geometry.tile), added, textures.texels());
    }
}

SnapshotCounts write_with(const Chunks& pack, const Snapshot& snapshot, const std::string& path,
                          const SnapshotOptions& options) {
    try {
        const Snapshot::Content* const content = SnapshotAccess::content(snapshot);
        if (content == nullptr) throw io::Failure(2, "the snapshot is empty; take one with take_snapshot");
        if (path.empty() && options.write)
            throw io::Failure(2, "the snapshot has no file name; give one that ends in .glb");
        if (options.write && !is_snapshot_name(path))
            throw io::Failure(2, fmt::format("{}: a snapshot is binary glTF; give it a name that ends in .glb", path));
        if (pack.header.header_hash != content->header.header_hash)
            throw io::Failure(2,
                              "the pack is not the one that the snapshot was taken of; open that one, or take it anew");
        std::optional<io::AtomicFile> file; // says what is wrong with the place before seconds of work, not after
        if (options.write) file.emplace(path);
        if (!(options.texel_m >= 0)) throw io::Failure(2, "texel_m must be 0 (the finest) or a number of metres");
        SnapshotCounts counts = snapshot.counts();
        Glb glb("Fjell",
                "the snapshot needs more bytes than a .glb may have (4 GiB, or max_file_bytes); ask for a larger "
                "error_px or smaller textures (max_texture_px)",
                options.max_file_bytes);
        std::optional<GlbLattice> lattice;
        if (options.quantised) lattice = lattice_of(pack.header, *content);
        SceneBuilder scene(glb, lattice, options.meshopt);
        add_tiles(pack, *content, options, scene, counts);
        scene.add_camera(content->info.view);
        Json& said = glb.json["scenes"][0]["extras"]["fjell"] = extras(pack, content->info, counts);
        said["rounding_m"] = lattice ? rounding_m(*lattice, *content) : 0.0;
        counts.file_bytes = glb.close();
        if (!file) return counts;
        glb.write([&](std::span<const std::byte> bytes) { file->write(bytes); });
        file->commit();
        return counts;
    } catch (const io::Failure&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw io::Failure(3, "not enough memory for the snapshot; ask for a larger error_px or smaller textures");
    } catch (const std::exception& error) {
        throw io::Failure(3, fmt::format("{}: cannot write the snapshot: {}", path, io::as_failure(error).what()));
    }
}

} // namespace

bool is_snapshot_name(const std::string& path) {
    const std::filesystem::path name(path);
    std::string ending = name.extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    std::error_code none;
    const std::filesystem::file_status there = std::filesystem::status(name, none);
    return ending == ".glb" || (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there));
}

SnapshotCounts write_snapshot(const Pack& pack, const Snapshot& snapshot, const std::string& path,
                              const SnapshotOptions& options) {
    return write_with(chunks_of(pack), snapshot, path, options);
}

SnapshotCounts write_snapshot(const io::PackFile& file, const Snapshot& snapshot, const std::string& path,
                              const SnapshotOptions& options) {
    return write_with(chunks_of(file), snapshot, path, options);
}

SnapshotCounts write_snapshot(const io::LiveTerrain& terrain, const Snapshot& snapshot, const std::string& path,
                              const SnapshotOptions& options) {
    return terrain.file() ? write_snapshot(*terrain.file(), snapshot, path, options)
                          : write_snapshot(terrain.pack(), snapshot, path, options);
}

SnapshotCounts write_snapshot(const Pack& pack, const Terrain& terrain, const MeshView& mesh, const SnapshotInfo& info,
                              const std::string& path, const SnapshotOptions& options) {
    return write_snapshot(pack, take_snapshot(terrain, mesh, info), path, options);
}

} // namespace fjell::gltf
