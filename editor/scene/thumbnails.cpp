#include "editor/scene/thumbnails.h"

#include "editor/scene/panel_texture.h"

namespace fjell::editor {

void Thumbnails::upload(Bookmarks& bookmarks) {
    if (!bookmarks.changed) return;
    bookmarks.changed = false;
    textures_.clear();
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (Bookmark& b : bookmarks.all) {
        b.texture = 0;
        if (b.thumbnail.width == 0) continue;
        textures_.push_back(make_panel_texture(GL_RGB8, b.thumbnail.width, b.thumbnail.height));
        b.texture = textures_.back().get();
        glTextureSubImage2D(b.texture, 0, 0, 0, static_cast<GLsizei>(b.thumbnail.width),
                            static_cast<GLsizei>(b.thumbnail.height), GL_RGB, GL_UNSIGNED_BYTE, b.thumbnail.rgb.data());
    }
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
}

void Thumbnails::drop_graphics(Bookmarks& bookmarks) {
    textures_.clear();
    for (Bookmark& b : bookmarks.all) b.texture = 0;
    bookmarks.changed = true;
}

} // namespace fjell::editor
