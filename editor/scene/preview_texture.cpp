#include "editor/scene/preview_texture.h"

#include <epoxy/gl.h>

namespace fjell::editor {

void PreviewTexture::set(BakeDraft& draft) {
    drop_graphics(draft);
    const HeightFacts& f = draft.facts;
    if (f.texels.empty()) return;
    const auto w = static_cast<GLsizei>(f.width_px), h = static_cast<GLsizei>(f.height_px);
    unsigned name = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &name);
    texture_ = gl::Texture(name);
    glTextureStorage2D(name, 1, GL_RGBA8, w, h); // sRGB bytes as they are: so the interface is drawn
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(name, 0, 0, 0, w, h, GL_RGBA, GL_UNSIGNED_BYTE, f.texels.data());
    draft.texture = name;
}

void PreviewTexture::drop_graphics(BakeDraft& draft) {
    texture_ = {};
    draft.texture = 0;
}

} // namespace fjell::editor
