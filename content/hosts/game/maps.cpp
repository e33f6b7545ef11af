#include "maps.h"

#include <algorithm>

namespace game {

void Maps::create(fjell::MapKind kind, const fjell::MapLayers& sizes) {
    const bool colour = kind == fjell::MapKind::colour;
    format_ = colour ? GL_COMPRESSED_SRGB_S3TC_DXT1_EXT : GL_COMPRESSED_RG_RGTC2;
    block_bytes_ = colour ? fjell::colour_block_bytes : fjell::normal_block_bytes;
    sizes_ = sizes;
    for (std::uint32_t log2 = 0; log2 <= fjell::max_texture_log2; ++log2) {
        if (sizes.layers[log2] == 0) continue;
        GLuint& array = array_[log2];
        glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &array);
        glTextureStorage3D(array, GLsizei(fjell::mip_count(log2)), format_, 1 << log2, 1 << log2,
                           GLsizei(sizes.layers[log2]));
        glTextureParameteri(array, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
        glTextureParameteri(array, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glTextureParameteri(array, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
}

void Maps::carry_out(const fjell::MapCommand& command) {
    const GLuint to = array_[command.side_log2];
    if (command.from_log2 != 0) { // the mips that both arrays have, from the smaller one's finest on
        const std::uint32_t common = std::min(command.from_log2, command.side_log2);
        for (std::uint32_t mip = 0; mip < fjell::mip_count(common); ++mip)
            glCopyImageSubData(array_[command.from_log2], GL_TEXTURE_2D_ARRAY, GLint(command.from_log2 - common + mip),
                               0, 0, GLint(command.from_layer), to, GL_TEXTURE_2D_ARRAY,
                               GLint(command.side_log2 - common + mip), 0, 0, GLint(command.layer), 1 << (common - mip),
                               1 << (common - mip), 1);
    }
    const std::byte* blocks = command.blocks.data(); // then new ones, the largest first
    for (std::uint32_t mip = 0; mip < command.upload_mips; ++mip) {
        const std::uint32_t side = 1u << (command.side_log2 - mip);
        const std::size_t bytes = fjell::blocks_of(side) * block_bytes_;
        glCompressedTextureSubImage3D(to, GLint(mip), 0, 0, GLint(command.layer), GLsizei(side), GLsizei(side), 1,
                                      format_, GLsizei(bytes), blocks);
        blocks += bytes;
    }
}

} // namespace game
