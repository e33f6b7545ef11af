#include "editor/scene/thumbnails.h"

#include <epoxy/gl.h>

namespace fjell::editor {

void Thumbnails::upload(Bookmarks& bookmarks) {
    if (!bookmarks.changed) return;
    bookmarks.changed = false;
    textures_.clear();
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (Bookmark& b : bookmarks.all) {
        b.texture = 0;
        if (b.thumbnail.width == 0) continue;
        glCreateTextures(GL_TEXTURE_2D, 1, &b.texture);
        textures_.emplace_back(b.texture);
        const auto w = static_cast<GLsizei>(b.thumbnail.width), h = static_cast<GLsizei>(b.thumbnail.height);
        glTextureStorage2D(b.texture, 1, GL_RGB8, w, h); // sRGB bytes as they are: so the interface is drawn
        glTextureSubImage2D(b.texture, 0, 0, 0, w, h, GL_RGB, GL_UNSIGNED_BYTE, b.thumbnail.rgb.data());
        glTextureParameteri(b.texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glTextureParameteri(b.texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
}

void Thumbnails::drop_graphics(Bookmarks& bookmarks) {
    textures_.clear();
    for (Bookmark& b : bookmarks.all) b.texture = 0;
    bookmarks.changed = true;
}

} // namespace fjell::editor
