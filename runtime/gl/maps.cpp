#include "gl/maps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include <epoxy/gl.h>

#include "fjell/texture.h"
#include "gl/fail.h"

namespace fjell::gl {
namespace {

struct Format {
    ChunkKind chunk;
    const char* name;
    const char* option; // RendererOptions'
    GLenum format;
    std::size_t block_bytes; // of 4 x 4 texels, all planes
    const char* extension;   // that has the format; none: the core
    std::uint32_t across;    // planes of a picture, each way
    bool numbers = false;    // texels as they are, of whole numbers: never filtered
};
constexpr Format formats[map_kinds] = {
    {ChunkKind::colour, "colour map", "RendererOptions::colour", GL_COMPRESSED_SRGB_S3TC_DXT1_EXT, colour_block_bytes,
     "GL_EXT_texture_compression_s3tc", 1},
    {ChunkKind::normal, "normal map", "RendererOptions::normal", GL_COMPRESSED_RG_RGTC2, normal_block_bytes, nullptr,
     1},
    {ChunkKind::horizon, "horizon map", "RendererOptions::horizon", GL_COMPRESSED_RED_RGTC1, horizon_block_bytes,
     nullptr, horizon_planes_across},
    {ChunkKind::splat, "splat map", "RendererOptions::splat", GL_RGBA16UI, splat_block_bytes, nullptr, 1, true}};

std::size_t mip_bytes(const Format& format, std::uint32_t side) {
    return blocks_of(side) * format.block_bytes;
}

void check_slots(const Format& format, const MapLayers& slots, std::uint32_t pack_log2, std::uint32_t tiles,
                 bool streamed) {
    if (format.extension && !epoxy_has_gl_extension(format.extension))
        fail(std::string("this GPU's driver lacks ") + format.extension + " for the " + format.name + "; update it");
    if (slots.top_log2 != pack_log2 || slots.tail_log2 > slots.top_log2 || slots.tail_log2 < 2 ||
        slots.layers[slots.tail_log2] < tiles)
        fail(std::string(format.option) + " is not of this pack: take it from stream_map_layers()");
    int most_layers = 0, largest = 0;
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    std::uint32_t sizes = 0;
    for (std::uint32_t log2 = slots.tail_log2; log2 <= slots.top_log2; ++log2) {
        const std::uint32_t layers = slots.layers[log2];
        if (layers == 0) continue;
        ++sizes;
        if (layers > static_cast<std::uint32_t>(most_layers))
            fail("the " + std::string(format.name) + " needs " + std::to_string(layers) + " layers of " +
                 std::to_string(1u << log2) + " texels and this GPU's texture arrays have " +
                 std::to_string(most_layers) +
                 (streamed ? "; lower StreamBudget::map_bytes" : "; bake with a larger --tile"));
        if (format.across << log2 > static_cast<std::uint32_t>(largest))
            fail("the " + std::string(format.name) + " has " + std::to_string(format.across << log2) +
                 " texels a side and this GPU at most " + std::to_string(largest) +
                 "; bake with a larger --tile count or smaller textures");
    }
    if (sizes <= max_map_sizes) return;
    fail(std::string(format.option) + " has " + std::to_string(sizes) + " sizes and a shader " +
         std::to_string(max_map_sizes) + " samplers a kind: raise StreamBudget::tail_log2");
}

// Of planes side by side the shader reads whole mips: a filter between two would reach over a plane's border.
void set_sampling(unsigned name, const Format& format, std::uint32_t mips, float anisotropy) {
    const bool planes = format.across > 1;
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER,
                        format.numbers ? GL_NEAREST_MIPMAP_NEAREST
                        : planes       ? GL_LINEAR_MIPMAP_NEAREST
                                       : GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, format.numbers ? GL_NEAREST : GL_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTextureParameteri(name, GL_TEXTURE_MAX_LEVEL, static_cast<GLint>(mips) - 1);
    if (anisotropy > 1 && !planes && !format.numbers) glTextureParameterf(name, GL_TEXTURE_MAX_ANISOTROPY, anisotropy);
}

float granted_anisotropy(float wish) {
    if (wish <= 1 || (!epoxy_has_gl_extension("GL_ARB_texture_filter_anisotropic") &&
                      !epoxy_has_gl_extension("GL_EXT_texture_filter_anisotropic")))
        return 1;
    float most = 1;
    glGetFloatv(GL_MAX_TEXTURE_MAX_ANISOTROPY, &most);
    return std::min(wish, most);
}

void make_arrays(const Format& format, const MapLayers& slots, std::uint32_t tiles, bool streamed, float anisotropy,
                 MapArrays& arrays, std::uint64_t& bytes) {
    arrays.slots = slots;
    arrays.tiles.assign(tiles, {});
    while (glGetError() != GL_NO_ERROR) {
    } // so that what follows speaks of these allocations
    for (std::uint32_t log2 = slots.tail_log2; log2 <= slots.top_log2; ++log2) {
        const std::uint32_t layers = slots.layers[log2], mips = mip_count(log2);
        if (layers == 0) continue;
        unsigned name = 0;
        glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
        arrays.array_of[log2] = static_cast<std::int32_t>(arrays.sizes);
        arrays.array[arrays.sizes++] = Texture(name);
        const auto side = static_cast<GLsizei>(format.across << log2);
        glTextureStorage3D(name, static_cast<GLsizei>(mips), format.format, side, side, static_cast<GLsizei>(layers));
        set_sampling(name, format, mips, anisotropy);
        for (std::uint32_t mip = 0; mip < mips; ++mip) bytes += layers * mip_bytes(format, 1u << (log2 - mip));
    }
    if (glGetError() == GL_NO_ERROR) return;
    fail(std::string("the GPU has no room for the ") + format.name +
         (streamed ? ": lower StreamBudget::map_bytes" : "; bake with smaller textures"));
}

void store_mip(const Format& format, unsigned texture, std::uint32_t mip, std::uint32_t layer, std::uint32_t first_row,
               std::uint32_t rows, std::uint32_t side, std::size_t bytes, const void* blocks) {
    if (format.numbers) {
        glTextureSubImage3D(texture, static_cast<GLint>(mip), 0, static_cast<GLint>(first_row),
                            static_cast<GLint>(layer), static_cast<GLsizei>(side), static_cast<GLsizei>(rows), 1,
                            GL_RGBA_INTEGER, GL_UNSIGNED_SHORT, blocks);
        return;
    }
    glCompressedTextureSubImage3D(texture, static_cast<GLint>(mip), 0, static_cast<GLint>(first_row),
                                  static_cast<GLint>(layer), static_cast<GLsizei>(side), static_cast<GLsizei>(rows), 1,
                                  format.format, static_cast<GLsizei>(bytes), blocks);
}

// Keeps the largest of these mips, largest first, that has 32 texels a side or fewer, or 8 where tiles are many.
void keep_rim(std::span<const std::byte> blocks, std::uint32_t side_log2, std::uint32_t mips, std::uint32_t tile,
              Maps& maps) {
    if (tile >= maps.rim.size()) return;
    RimColours& rim = maps.rim[tile];
    const std::uint32_t most_log2 = maps.rim.size() > 256 ? 3 : 5;
    for (std::uint32_t log2 = side_log2; mips > 0; --log2, --mips) {
        const std::size_t bytes = mip_bytes(formats[0], 1u << log2);
        if (log2 > most_log2 || log2 <= rim.side_log2) {
            blocks = blocks.subspan(bytes);
            continue;
        }
        rim.rgb.resize((std::size_t{3} << log2) << log2);
        if (decode_colour(blocks.first(bytes), 1u << log2, rim.rgb).ok()) {
            rim.side_log2 = static_cast<std::uint8_t>(log2);
            ++maps.rim_changes;
        }
        return;
    }
}

void load_all(const Pack& pack, const Format& format, MapArrays& arrays, Maps& maps) {
    const std::uint32_t log2 = arrays.slots.top_log2;
    std::vector<std::byte> blocks;
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    for (std::uint32_t mip = 0; mip < mip_count(log2); ++mip) {
        const std::uint32_t side = 1u << (log2 - mip);
        blocks.resize(mip_bytes(format, side));
        for (std::uint32_t tile = 0; tile < pack.tile_count(); ++tile) {
            const Status status = read_chunk(pack, {format.chunk, tile, mip}, blocks);
            if (!status.ok())
                fail(std::string("the ") + format.name + " of tile " + std::to_string(tile) + ", mip " +
                     std::to_string(mip) + " (" + status.field + "): " + message(status.code));
            store_mip(format, arrays.texture(log2), mip, tile, 0, format.across * side, format.across * side,
                      blocks.size(), blocks.data());
            if (&arrays == &maps.kind[0]) keep_rim(blocks, log2 - mip, 1, tile, maps);
        }
    }
    for (std::uint32_t tile = 0; tile < pack.tile_count(); ++tile)
        arrays.tiles[tile] = {tile, static_cast<std::uint8_t>(log2), 0};
}

// --- commands
// ---------------------------------------------------------------------------------------------------------

bool has_layer(const MapArrays& arrays, std::uint32_t log2, std::uint32_t layer) {
    return log2 <= max_texture_log2 && arrays.present() && arrays.array_of[log2] >= 0 &&
           layer < arrays.slots.layers[log2];
}

bool is_good(const MapCommand& command, const Maps& maps) {
    const auto kind = static_cast<std::uint32_t>(command.map);
    if (kind >= map_kinds) return false;
    const MapArrays& arrays = maps.kind[kind];
    if (!has_layer(arrays, command.side_log2, command.layer)) return false;
    if (command.from_log2 != 0 && !has_layer(arrays, command.from_log2, command.from_layer)) return false;
    if (command.upload_mips > mip_count(command.side_log2)) return false;
    std::size_t bytes = 0;
    for (std::uint32_t mip = 0; mip < command.upload_mips; ++mip)
        bytes += mip_bytes(formats[kind], 1u << (command.side_log2 - mip));
    return bytes == command.blocks.size();
}

// The mips that both arrays have, from the smaller one's own mip 0 down to 4 x 4.
void copy_mips(const MapCommand& command, const Format& format, const MapArrays& arrays) {
    const std::uint32_t from = command.from_log2, to = command.side_log2, common = std::min(from, to);
    for (std::uint32_t mip = 0; mip < mip_count(common); ++mip) {
        const auto side = static_cast<GLsizei>(format.across << (common - mip));
        glCopyImageSubData(arrays.texture(from), GL_TEXTURE_2D_ARRAY, static_cast<GLint>(from - common + mip), 0, 0,
                           static_cast<GLint>(command.from_layer), arrays.texture(to), GL_TEXTURE_2D_ARRAY,
                           static_cast<GLint>(to - common + mip), 0, 0, static_cast<GLint>(command.layer), side, side,
                           1);
    }
}

// In strips of whole rows of blocks, as many as the ring's region has room for.
void store_blocks(const MapCommand& command, const Format& format, const MapArrays& arrays, Ring& ring) {
    const std::byte* from = command.blocks.data();
    for (std::uint32_t mip = 0; mip < command.upload_mips; ++mip) {
        const std::uint32_t side = format.across << (command.side_log2 - mip); // of all planes
        const std::size_t row_bytes = side / 4 * format.block_bytes / (std::size_t{format.across} * format.across);
        for (std::uint32_t row = 0; row < side / 4;) {
            ring.reserve(ring.aligned(row_bytes));
            const auto rows =
                static_cast<std::uint32_t>(std::min<std::size_t>(side / 4 - row, ring.room() / row_bytes));
            const RingSlice slice = ring.take(rows * row_bytes);
            std::memcpy(slice.data, from, rows * row_bytes);
            store_mip(format, arrays.texture(command.side_log2), mip, command.layer, 4 * row, 4 * rows, side,
                      rows * row_bytes, reinterpret_cast<const void*>(slice.offset));
            from += rows * row_bytes;
            row += rows;
        }
    }
}

} // namespace

void make_maps(const Pack& pack, const MapLayers (&slots)[map_kinds], const MapOptions& options, Maps& maps) {
    maps.anisotropy = granted_anisotropy(options.anisotropy);
    const PackHeader& h = pack.header;
    // Whose other maps are streamed has no bytes to load these from.
    const bool whole = slots[0].top_log2 == 0 && slots[1].top_log2 == 0 && !pack.bytes.empty();
    const auto wanted = [&](std::uint32_t kind, bool wish) { return slots[kind].top_log2 != 0 || (wish && whole); };
    const std::uint32_t pack_log2[map_kinds] = {h.colour_log2, h.normal_log2,
                                                wanted(2, options.horizons) ? h.horizon_log2 : 0,
                                                wanted(3, options.splat) ? h.splat_log2 : 0};
    for (std::uint32_t kind = 0; kind < map_kinds; ++kind) {
        MapArrays& arrays = maps.kind[kind];
        std::fill(std::begin(arrays.array_of), std::end(arrays.array_of), -1);
        const bool streamed = slots[kind].top_log2 != 0;
        maps.all_there = maps.all_there && !streamed;
        if (!streamed && pack_log2[kind] == 0) continue;
        MapLayers own = slots[kind];
        if (!streamed) {
            own.tail_log2 = own.top_log2 = pack_log2[kind];
            own.layers[own.top_log2] = pack.tile_count();
        }
        if (own.top_log2 > max_texture_log2) fail(std::string(formats[kind].option) + ": top_log2 is out of range");
        check_slots(formats[kind], own, pack_log2[kind], pack.tile_count(), streamed);
        if (kind == 0) maps.rim.resize(pack.tile_count());
        make_arrays(formats[kind], own, pack.tile_count(), streamed, maps.anisotropy, arrays, maps.bytes);
        arrays.whole = !streamed;
        if (!streamed) load_all(pack, formats[kind], arrays, maps);
    }
}

void run_commands(std::span<const MapCommand> commands, Maps& maps, Ring& ring, std::uint64_t& bytes) {
    for (const MapCommand& command : commands)
        if (!is_good(command, maps))
            fail("a map command for tile " + std::to_string(command.tile) +
                 " names a size, a layer or blocks that RendererOptions has no room for");
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, ring.buffer());
    for (const MapCommand& command : commands) {
        const auto kind = static_cast<std::uint32_t>(command.map);
        if (command.from_log2 != 0) copy_mips(command, formats[kind], maps.kind[kind]);
        store_blocks(command, formats[kind], maps.kind[kind], ring);
        if (kind == 0) keep_rim(command.blocks, command.side_log2, command.upload_mips, command.tile, maps);
        bytes += command.blocks.size();
    }
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

void run_patches(std::span<const MapPatch> patches, const Maps& maps, std::uint64_t& bytes) {
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    for (const MapPatch& patch : patches) {
        const auto kind = static_cast<std::uint32_t>(patch.map);
        if (!has_layer(maps.kind[kind], patch.side_log2, patch.layer)) continue; // of a map that is not drawn
        const unsigned texture = maps.kind[kind].texture(patch.side_log2);
        const auto x = static_cast<GLint>(patch.x), y = static_cast<GLint>(patch.y),
                   layer = static_cast<GLint>(patch.layer);
        const auto columns = static_cast<GLsizei>(patch.columns), rows = static_cast<GLsizei>(patch.rows);
        if (formats[kind].numbers)
            glTextureSubImage3D(texture, patch.mip, x, y, layer, columns, rows, 1, GL_RGBA_INTEGER, GL_UNSIGNED_SHORT,
                                patch.blocks.data());
        else
            glCompressedTextureSubImage3D(texture, patch.mip, x, y, layer, columns, rows, 1, formats[kind].format,
                                          static_cast<GLsizei>(patch.blocks.size()), patch.blocks.data());
        bytes += patch.blocks.size();
    }
}

namespace {

// All mips of a tile, largest first.
std::vector<std::byte> read_mips(const Format& format, const MapArrays& arrays, std::uint32_t tile) {
    const std::uint32_t log2 = arrays.slots.top_log2;
    const unsigned texture = arrays.texture(log2);
    const auto layer = static_cast<GLint>(tile);
    std::vector<std::byte> mips;
    for (std::uint32_t mip = 0; mip < mip_count(log2); ++mip) {
        const std::size_t bytes = mip_bytes(format, 1u << (log2 - mip)), at = mips.size();
        const auto level = static_cast<GLint>(mip), side = static_cast<GLsizei>(1u << (log2 - mip));
        mips.resize(at + bytes);
        if (format.numbers)
            glGetTextureSubImage(texture, level, 0, 0, layer, side, side, 1, GL_RGBA_INTEGER, GL_UNSIGNED_SHORT,
                                 static_cast<GLsizei>(bytes), mips.data() + at);
        else
            glGetCompressedTextureSubImage(texture, level, 0, 0, layer, side, side, 1, static_cast<GLsizei>(bytes),
                                           mips.data() + at);
    }
    return mips;
}

// Tiles whose texels may take paint of these samples: the widest reach half a tile.
bool is_near(const PackHeader& h, std::uint32_t tile, std::span<const GroundRect> changed) {
    const std::int32_t side = std::int32_t{1} << h.tile_log2, reach = side / 2 + 32;
    const auto x = static_cast<std::int32_t>(tile % h.tiles_x) * side,
               y = static_cast<std::int32_t>(tile / h.tiles_x) * side;
    return std::any_of(changed.begin(), changed.end(), [&](const GroundRect& r) {
        return r.first.column - reach <= x + side && r.last.column + reach >= x && r.first.row - reach <= y + side &&
               r.last.row + reach >= y;
    });
}

} // namespace

void paint_tiles(const Terrain& terrain, std::span<const GroundRect> changed, Maps& maps, std::uint64_t& bytes) {
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    for (const MapKind kind : {MapKind::colour, MapKind::splat}) {
        const Format& format = formats[static_cast<std::uint32_t>(kind)];
        MapArrays& arrays = maps.kind[static_cast<std::uint32_t>(kind)];
        if (!arrays.present() || !arrays.whole) continue;
        const std::uint32_t log2 = arrays.slots.top_log2;
        for (std::uint32_t tile = 0; tile < arrays.tiles.size(); ++tile) {
            if (!is_near(terrain.header(), tile, changed)) continue;
            const bool was_painted = arrays.unpainted.contains(tile);
            std::vector<std::byte>& pack = arrays.unpainted[tile];
            if (!was_painted) pack = read_mips(format, arrays, tile);
            std::vector<std::byte> mips = pack;
            std::size_t at = 0;
            bool any = false;
            for (std::uint32_t mip = 0; mip < mip_count(log2); ++mip) {
                const std::uint32_t side = 1u << (log2 - mip);
                const std::span<std::byte> blocks(mips.data() + at, mip_bytes(format, side));
                at += blocks.size();
                bool painted = false;
                (void)paint_map(terrain, kind, tile, log2 - mip, blocks, painted);
                any = any || painted;
                if (!painted && !was_painted) continue;
                store_mip(format, arrays.texture(log2), mip, tile, 0, side, side, blocks.size(), blocks.data());
                bytes += blocks.size();
            }
            if (!any) arrays.unpainted.erase(tile);
        }
    }
}

void show_maps(std::span<const TileMap> from, MapKind kind, Maps& maps) {
    MapArrays& arrays = maps.kind[static_cast<std::uint32_t>(kind)];
    if (from.empty()) return;
    if (from.size() != arrays.tiles.size()) fail("show_maps() needs one TileMap a tile");
    for (const TileMap& map : from)
        if ((map.side_log2 != 0 && !has_layer(arrays, map.side_log2, map.layer)) || !std::isfinite(map.min_lod))
            fail("a TileMap names a size or a layer that RendererOptions has no room for");
    std::copy(from.begin(), from.end(), arrays.tiles.begin());
    maps.all_there = false;
}

SampleToTexel sample_to_texel(std::uint32_t texture_log2, std::uint32_t tile_log2) {
    const double texels = 1u << texture_log2, cells = 1u << tile_log2;
    return {static_cast<float>((texels - 1) / texels / cells), static_cast<float>(0.5 / texels)};
}

} // namespace fjell::gl
