// Pictures that panels show as textures: sRGB bytes as they are, for so the interface is drawn.
#pragma once

#include <cstdint>

#include <epoxy/gl.h>

#include "gl/objects.h"

namespace fjell::editor {

// Empty, without mips. format: GL_RGBA8 or GL_RGB8. The frame's thread, with the graphics context current.
[[nodiscard]] inline gl::Texture make_panel_texture(GLenum format, std::uint32_t width, std::uint32_t height) {
    unsigned name = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &name);
    gl::Texture texture(name);
    glTextureStorage2D(name, 1, format, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return texture;
}

} // namespace fjell::editor
