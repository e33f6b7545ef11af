#include "editor/scene/preview_texture.h"

#include "editor/scene/panel_texture.h"

namespace fjell::editor {

void PreviewTexture::set(BakeDraft& draft) {
    drop_graphics(draft);
    const HeightFacts& f = draft.facts;
    if (f.texels.empty()) return;
    texture_ = make_panel_texture(GL_RGBA8, f.width_px, f.height_px);
    draft.texture = texture_.get();
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(draft.texture, 0, 0, 0, static_cast<GLsizei>(f.width_px), static_cast<GLsizei>(f.height_px),
                        GL_RGBA, GL_UNSIGNED_BYTE, f.texels.data());
}

void PreviewTexture::drop_graphics(BakeDraft& draft) {
    texture_ = {};
    draft.texture = 0;
}

} // namespace fjell::editor
