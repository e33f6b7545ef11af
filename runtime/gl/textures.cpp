#include "gl/textures.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <epoxy/gl.h>

namespace fjell::gl {
namespace {

struct MapKind {
    ChunkKind chunk;
    const char* name;
    GLenum format;
    const char* extension; // that has the format; none: the core
};
constexpr MapKind colour_kind{ChunkKind::colour, "colour map", GL_COMPRESSED_SRGB_S3TC_DXT1_EXT,
                              "GL_EXT_texture_compression_s3tc"};
constexpr MapKind normal_kind{ChunkKind::normal, "normal map", GL_COMPRESSED_RG_RGTC2, nullptr};

std::string check_limits(const MapKind& kind, std::uint32_t tiles, std::uint32_t side) {
    if (kind.extension && !epoxy_has_gl_extension(kind.extension))
        return std::string("this GPU's driver lacks ") + kind.extension + " for the " + kind.name + "; update it";
    int layers = 0, largest = 0;
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers);
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    if (tiles > static_cast<std::uint32_t>(layers))
        return "the terrain has " + std::to_string(tiles) + " tiles and this GPU's texture arrays " +
               std::to_string(layers) + " layers; bake with a larger --tile";
    if (side > static_cast<std::uint32_t>(largest))
        return std::string("the ") + kind.name + " has " + std::to_string(side) +
               " texels a side and this GPU at most " + std::to_string(largest) +
               "; bake with a larger --tile count or smaller textures";
    return {};
}

void set_sampling(unsigned name, std::uint32_t mips, float anisotropy) {
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTextureParameteri(name, GL_TEXTURE_MAX_LEVEL, static_cast<GLint>(mips) - 1);
    if (anisotropy <= 1 || (!epoxy_has_gl_extension("GL_ARB_texture_filter_anisotropic") &&
                            !epoxy_has_gl_extension("GL_EXT_texture_filter_anisotropic")))
        return;
    float most = 1;
    glGetFloatv(GL_MAX_TEXTURE_MAX_ANISOTROPY, &most);
    glTextureParameterf(name, GL_TEXTURE_MAX_ANISOTROPY, std::min(anisotropy, most));
}

std::string load_map(const Pack& pack, const MapKind& kind, std::uint32_t log2_side, float anisotropy, Texture& texture,
                     std::uint64_t& bytes) {
    const std::uint32_t side = 1u << log2_side, mips = mip_count(log2_side), tiles = pack.tile_count();
    if (std::string error = check_limits(kind, tiles, side); !error.empty()) return error;
    while (glGetError() != GL_NO_ERROR) {
    } // so that what follows speaks of this allocation
    unsigned name = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
    texture = Texture(name);
    glTextureStorage3D(name, static_cast<GLsizei>(mips), kind.format, static_cast<GLsizei>(side),
                       static_cast<GLsizei>(side), static_cast<GLsizei>(tiles));
    if (glGetError() != GL_NO_ERROR)
        return std::string("the GPU has no room for the ") + kind.name + "; bake with smaller textures";
    set_sampling(name, mips, anisotropy);
    std::vector<std::byte> blocks;
    for (std::uint32_t mip = 0; mip < mips; ++mip) {
        blocks.resize(chunk_raw_bytes(pack.header, {kind.chunk, 0, mip}));
        const auto mip_side = static_cast<GLsizei>(side >> mip);
        for (std::uint32_t tile = 0; tile < tiles; ++tile) {
            const Status status = read_chunk(pack, {kind.chunk, tile, mip}, blocks);
            if (!status.ok())
                return std::string("the ") + kind.name + " of tile " + std::to_string(tile) + ", mip " +
                       std::to_string(mip) + " (" + status.field + "): " + message(status.code);
            glCompressedTextureSubImage3D(name, static_cast<GLint>(mip), 0, 0, static_cast<GLint>(tile), mip_side,
                                          mip_side, 1, kind.format, static_cast<GLsizei>(blocks.size()), blocks.data());
        }
        bytes += std::uint64_t{tiles} * blocks.size();
    }
    return {};
}

} // namespace

std::string load_textures(const Pack& pack, float anisotropy, TerrainTextures& textures) {
    std::string error;
    if (pack.header.colour_log2 != 0)
        error = load_map(pack, colour_kind, pack.header.colour_log2, anisotropy, textures.colour, textures.bytes);
    if (error.empty() && pack.header.normal_log2 != 0)
        error = load_map(pack, normal_kind, pack.header.normal_log2, anisotropy, textures.normal, textures.bytes);
    return error;
}

SampleToTexel sample_to_texel(std::uint32_t texture_log2, std::uint32_t tile_log2) {
    const double texels = 1u << texture_log2, cells = 1u << tile_log2;
    return {static_cast<float>((texels - 1) / texels / cells), static_cast<float>(0.5 / texels)};
}

} // namespace fjell::gl
