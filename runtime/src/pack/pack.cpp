// Opening a pack never trusts a number it has not checked: sizes are compared in 64 bits before anything is read, and
// the header's and directory's hashes are checked before their fields are used.
#include "fjell/pack.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include <zstd.h>

#include "fjell/texture.h"
#include "shared/hash.h"
#include "shared/order.h"
#include "shared/record.h"

namespace fjell {

static_assert(std::endian::native == std::endian::little,
              "packs are read in place: a big-endian build needs a byte-swapping reader");

namespace {

Status failed(StatusCode code, const char* field) {
    return {code, field};
}

bool in_range(double value, double least, double most) {
    return value >= least && value <= most;
} // false for NaN

Status check_directory(const Pack& pack) {
    const PackHeader& h = pack.header;
    for (std::uint64_t chunk = 0; chunk < h.directory_count; ++chunk) {
        const ChunkEntry e = pack.entry(chunk);
        const ChunkId id = chunk_id(h, chunk);
        const std::size_t most = chunk_raw_bytes(h, id),
                          least = id.kind == ChunkKind::geometry ? sizeof(PageHead) : most;
        if (e.raw_bytes < least || e.raw_bytes > most) return failed(StatusCode::corrupt, "directory sizes");
        if (e.offset < h.header_bytes || e.offset > h.directory_offset ||
            e.stored_bytes > h.directory_offset - e.offset)
            return failed(StatusCode::corrupt, "directory offsets");
        if (e.bound.low > e.bound.high || e.bound.radius >= radius_codes || e.bound.reserved != 0)
            return failed(StatusCode::corrupt, "directory bounds");
    }
    return {};
}

// The scales that codes of errors and radii count on.
Status check_scales(const PackHeader& h) {
    if (!in_range(h.error_floor_m, 1e-9, 1e9)) return failed(StatusCode::out_of_range, "error_floor_m");
    if (!in_range(h.error_ratio, 1.0001, 1.2)) return failed(StatusCode::out_of_range, "error_ratio");
    if (h.error_nesting_steps < 1 || h.error_nesting_steps > 255)
        return failed(StatusCode::out_of_range, "error_nesting_steps");
    for (std::uint32_t level = 0; level < 2 * max_tile_log2; ++level)
        if (!in_range(h.level_radius_m[level], level < 2 * h.tile_log2 ? 1e-9 : 0, 1e9))
            return failed(StatusCode::out_of_range, "level_radius_m");
    if (h.height_steps > static_cast<std::uint32_t>(max_height_steps))
        return failed(StatusCode::out_of_range, "height_steps");
    return {};
}

} // namespace

Status check_ranges(const PackHeader& h) {
    const auto bad = [](const char* field) { return failed(StatusCode::out_of_range, field); };
    if (h.tile_log2 < min_tile_log2 || h.tile_log2 > max_tile_log2) return bad("tile_log2");
    if (h.columns < 2 || h.columns > max_columns) return bad("columns");
    if (h.rows < 2 || h.rows > max_columns) return bad("rows");
    const Tree covering = Tree::covering(static_cast<std::int32_t>(h.columns), static_cast<std::int32_t>(h.rows),
                                         static_cast<int>(h.tile_log2));
    if (static_cast<std::uint32_t>(covering.tiles_x) != h.tiles_x) return bad("tiles_x");
    if (static_cast<std::uint32_t>(covering.tiles_y) != h.tiles_y) return bad("tiles_y");
    if (h.order != PageOrder::planar && h.order != PageOrder::hierarchical_z && h.order != PageOrder::linear)
        return bad("order");
    if (h.estimate != ErrorEstimate::max && h.estimate != ErrorEstimate::midpoint) return bad("estimate");
    if (!in_range(h.nesting, 0.0009, 1.0001)) return bad("nesting");
    for (const double spacing : h.spacing_m)
        if (!in_range(spacing, min_spacing_m, max_spacing_m)) return bad("spacing_m");
    if (std::max((h.columns - 1) * h.spacing_m[0], (h.rows - 1) * h.spacing_m[1]) > max_extent_m)
        return bad("spacing_m");
    for (const double origin : h.crs_origin)
        if (!std::isfinite(origin)) return bad("crs_origin");
    for (const double step : h.crs_step)
        if (!in_range(step, 0, 1e9)) return bad("crs_step");
    if (!in_range(h.quantum_m, 1e-9, 1e4)) return bad("quantum_m");
    for (const float height : {h.base_m, h.min_m, h.max_m})
        if (!in_range(height, -1e7, 1e7)) return bad("heights");
    if (!in_range(h.max_error_m, 0, 1e9)) return bad("max_error_m");
    if (h.colour_log2 == 1 || h.colour_log2 > max_texture_log2) return bad("colour_log2");
    if (h.normal_log2 == 1 || h.normal_log2 > max_texture_log2) return bad("normal_log2");
    if (h.horizon_log2 == 1 || h.horizon_log2 > max_texture_log2) return bad("horizon_log2");
    if (h.splat_log2 == 1 || h.splat_log2 > max_texture_log2) return bad("splat_log2");
    if (h.layer_bytes > max_layer_bytes || (h.layer_bytes != 0) != (h.splat_log2 != 0)) return bad("layer_bytes");
    if (h.tiles_held != 0 && std::uint64_t{h.tiles_x} * h.tiles_y > max_sparse_tiles) return bad("tile_log2");
    if (h.tiles_held > std::uint64_t{h.tiles_x} * h.tiles_y) return bad("tiles_held");
    if (h.crs_bytes > (1u << 20)) return bad("crs_bytes");
    if (h.notes_bytes > (1u << 20)) return bad("notes_bytes");
    return check_scales(h);
}

ChunkEntry Pack::entry(std::uint64_t chunk) const {
    ChunkEntry e{};
    if (directory != nullptr && chunk < header.directory_count)
        std::memcpy(&e, directory + chunk * sizeof(ChunkEntry), sizeof e);
    return e;
}

std::uint32_t Pack::tile_place(std::uint32_t tile) const {
    if (directory == nullptr || tile >= tile_count()) return no_index;
    if (header.tiles_held == 0) return tile;
    std::uint32_t place = 0;
    std::memcpy(&place, directory + header.directory_count * sizeof(ChunkEntry) + std::size_t{tile} * sizeof place,
                sizeof place);
    return place;
}

namespace {

// In 64 bits: what is not checked yet may have more than there are numbers for.
std::uint64_t tile_total(const PackHeader& h) {
    return h.tiles_held != 0 ? h.tiles_held : std::uint64_t{h.tiles_x} * h.tiles_y;
}

// Chunks before each kind, and how many of it a tile has.
struct DirectoryPlan {
    std::uint64_t first[8], per_tile[8];
};

DirectoryPlan plan_directory(const PackHeader& h) {
    const std::uint64_t tiles = tile_total(h);
    const std::uint64_t pages = PageLayout{static_cast<int>(h.tile_log2), h.order}.pages_per_tile();
    const std::uint64_t colours = mip_count(h.colour_log2), normals = mip_count(h.normal_log2);
    const std::uint64_t after_pages = 1 + tiles * pages, after_colours = after_pages + tiles * colours;
    const std::uint64_t after_normals = after_colours + tiles * normals, crs = h.crs_bytes ? 1 : 0;
    const std::uint64_t horizons = mip_count(h.horizon_log2), names = h.layer_bytes ? 1 : 0;
    const std::uint64_t after_crs = after_normals + crs, after_horizons = after_crs + tiles * horizons;
    return {{0, 1, after_pages, after_colours, after_normals, after_crs, after_horizons, after_horizons + names},
            {1, pages, colours, normals, crs, horizons, names, mip_count(h.splat_log2)}};
}

// What the directory's plan follows from can be that of a pack. check_ranges() looks at the rest too, and takes longer.
bool has_layout(const PackHeader& h) {
    return h.tile_log2 >= min_tile_log2 && h.tile_log2 <= max_tile_log2 && h.tiles_x != 0 && h.tiles_y != 0 &&
           h.tiles_x <= max_columns && h.tiles_y <= max_columns && h.order <= PageOrder::linear &&
           h.colour_log2 <= max_texture_log2 && h.normal_log2 <= max_texture_log2 &&
           h.horizon_log2 <= max_texture_log2 && h.splat_log2 <= max_texture_log2;
}

bool has_chunk(const PackHeader& h, ChunkId id) {
    if (!has_layout(h)) return false;
    const bool in_tile = id.tile < tile_total(h);
    switch (id.kind) {
    case ChunkKind::corners: return id.tile == 0 && id.item == 0;
    case ChunkKind::geometry: return in_tile && id.item < pages_of(h).pages_per_tile();
    case ChunkKind::colour: return in_tile && id.item < mip_count(h.colour_log2);
    case ChunkKind::normal: return in_tile && id.item < mip_count(h.normal_log2);
    case ChunkKind::crs: return id.tile == 0 && id.item == 0 && h.crs_bytes != 0;
    case ChunkKind::horizon: return in_tile && id.item < mip_count(h.horizon_log2);
    case ChunkKind::layers: return id.tile == 0 && id.item == 0 && h.layer_bytes != 0;
    case ChunkKind::splat: return in_tile && id.item < mip_count(h.splat_log2);
    }
    return false;
}

} // namespace

std::uint64_t chunk_index(const PackHeader& h, ChunkId id) {
    if (!has_chunk(h, id)) return no_chunk;
    const DirectoryPlan plan = plan_directory(h);
    const auto kind = static_cast<std::size_t>(id.kind);
    return plan.first[kind] + id.tile * plan.per_tile[kind] + id.item;
}

ChunkId chunk_id(const PackHeader& h, std::uint64_t chunk) {
    if (!has_layout(h) || chunk >= chunk_count(h)) return {ChunkKind::corners, no_index, no_index};
    const DirectoryPlan plan = plan_directory(h);
    std::size_t kind = 7;
    while (kind > 0 && chunk < plan.first[kind]) --kind;
    // A kind that has no chunks begins where the next one does.
    while (kind < 7 && plan.per_tile[kind] == 0) ++kind;
    const std::uint64_t local = chunk - plan.first[kind];
    return {static_cast<ChunkKind>(kind), static_cast<std::uint32_t>(local / plan.per_tile[kind]),
            static_cast<std::uint32_t>(local % plan.per_tile[kind])};
}

std::uint64_t chunk_count(const PackHeader& h) {
    if (!has_layout(h)) return 0;
    const std::uint64_t tiles = tile_total(h);
    return plan_directory(h).first[static_cast<std::size_t>(ChunkKind::splat)] + tiles * mip_count(h.splat_log2);
}

std::size_t chunk_raw_bytes(const PackHeader& h, ChunkId id) {
    if (!has_chunk(h, id)) return 0;
    const auto blocks = [&](std::uint32_t log2_side) { return blocks_of(1u << (log2_side - id.item)); };
    switch (id.kind) {
    case ChunkKind::corners: {
        const std::uint64_t all = (std::uint64_t{h.tiles_x} + 1) * (std::uint64_t{h.tiles_y} + 1),
                            bytes = 4 * (h.tiles_held != 0 ? std::uint64_t{h.tiles_held} * 4 : all);
        return static_cast<std::size_t>(std::min<std::uint64_t>(bytes, std::numeric_limits<std::size_t>::max()));
    }
    case ChunkKind::geometry:
        return max_page_raw_bytes(PageLayout{static_cast<int>(h.tile_log2), h.order}.page_vertices(id.item));
    case ChunkKind::colour: return blocks(h.colour_log2) * colour_block_bytes;
    case ChunkKind::normal: return blocks(h.normal_log2) * normal_block_bytes;
    case ChunkKind::horizon: return blocks(h.horizon_log2) * horizon_block_bytes;
    case ChunkKind::layers: return h.layer_bytes;
    case ChunkKind::splat: return blocks(h.splat_log2) * splat_block_bytes;
    case ChunkKind::crs: break;
    }
    return h.crs_bytes;
}

Status read_header(std::span<const std::byte> header, std::uint64_t file_bytes, PackHeader& out) {
    if (header.size() < sizeof pack_magic || std::memcmp(header.data(), pack_magic, sizeof pack_magic) != 0)
        return failed(StatusCode::not_a_pack, "magic");
    if (header.size() < sizeof(PackHeader)) return failed(StatusCode::truncated, "header");
    PackHeader h;
    std::memcpy(&h, header.data(), sizeof h);
    if (h.version != pack_version) return failed(StatusCode::wrong_version, "version");
    if (h.layout_hash != pack_layout_hash || h.header_bytes != sizeof(PackHeader))
        return failed(StatusCode::wrong_layout, "layout_hash");
    if (h.header_hash != hash_of(header.data(), offsetof(PackHeader, header_hash)))
        return failed(StatusCode::corrupt, "header");
    if (file_bytes < h.file_bytes) return failed(StatusCode::truncated, "file_bytes");
    if (file_bytes > h.file_bytes) return failed(StatusCode::corrupt, "file_bytes");
    if (Status s = check_ranges(h); !s.ok()) return s;
    if (h.features > (pack_has_horizons | pack_has_splat | pack_is_sparse))
        return failed(StatusCode::wrong_version, "features");
    if (h.features != features_of(h)) return failed(StatusCode::corrupt, "features");
    if (h.directory_offset < h.header_bytes || h.directory_offset > h.file_bytes ||
        h.directory_count != chunk_count(h) ||
        h.directory_count > (h.file_bytes - h.directory_offset) / sizeof(ChunkEntry) ||
        directory_bytes(h) != h.file_bytes - h.directory_offset)
        return failed(StatusCode::corrupt, "directory");
    if (h.notes_bytes != 0 && (h.notes_offset < h.header_bytes || h.notes_offset > h.directory_offset ||
                               h.notes_bytes > h.directory_offset - h.notes_offset))
        return failed(StatusCode::corrupt, "notes_offset");
    out = h;
    return {};
}

Status open_index(std::span<const std::byte> header, std::span<const std::byte> directory, std::uint64_t file_bytes,
                  Pack& pack) {
    Pack opened;
    if (Status s = read_header(header, file_bytes, opened.header); !s.ok()) return s;
    const PackHeader& h = opened.header;
    const std::uint64_t bytes = directory_bytes(h);
    if (directory.size() < bytes) return failed(StatusCode::truncated, "directory");
    opened.directory = directory.data();
    if (h.directory_hash != hash_of(opened.directory, static_cast<std::size_t>(bytes)))
        return failed(StatusCode::corrupt, "directory");
    if (Status s = check_directory(opened); !s.ok()) return s;
    for (std::uint64_t tile = 0, least = 0; tile < h.tiles_held; ++tile) {
        const std::uint32_t place = opened.tile_place(static_cast<std::uint32_t>(tile));
        if (place < least || place >= std::uint64_t{h.tiles_x} * h.tiles_y) return failed(StatusCode::corrupt, "tiles");
        least = std::uint64_t{place} + 1;
    }
    pack = opened;
    return {};
}

Status open_pack(std::span<const std::byte> file, Pack& pack) {
    PackHeader h;
    if (Status s = read_header(file, file.size(), h); !s.ok()) return s;
    if (h.notes_bytes != 0 &&
        h.notes_hash != hash_of(file.data() + h.notes_offset, static_cast<std::size_t>(h.notes_bytes)))
        return failed(StatusCode::corrupt, "notes");
    const std::span<const std::byte> directory = file.subspan(static_cast<std::size_t>(h.directory_offset));
    if (Status s = open_index(file, directory, file.size(), pack); !s.ok()) return s;
    pack.bytes = file;
    return {};
}

Status decode_chunk(const ChunkEntry& e, std::span<const std::byte> stored, std::span<std::byte> out) {
    if (out.size() != e.raw_bytes) return failed(StatusCode::memory_too_small, "out");
    if (stored.size() != e.stored_bytes || hash_of(stored.data(), stored.size()) != e.hash)
        return failed(StatusCode::corrupt, "chunk");
    const std::size_t written = ZSTD_decompress(out.data(), out.size(), stored.data(), stored.size());
    if (ZSTD_isError(written) || written != e.raw_bytes) return failed(StatusCode::corrupt, "chunk");
    return {};
}

Status read_chunk(const Pack& pack, ChunkId id, std::span<std::byte> out) {
    const std::uint64_t chunk = chunk_index(pack.header, id);
    if (pack.directory == nullptr || chunk == no_chunk) return failed(StatusCode::out_of_range, "chunk");
    if (pack.bytes.empty()) return failed(StatusCode::not_supported, "chunk of a streamed pack");
    const ChunkEntry e = pack.entry(chunk);
    if (e.offset > pack.bytes.size() || e.stored_bytes > pack.bytes.size() - e.offset)
        return failed(StatusCode::truncated, "pack");
    return decode_chunk(e, pack.bytes.subspan(static_cast<std::size_t>(e.offset), e.stored_bytes), out);
}

} // namespace fjell
