//
#include "editor/scene/textures.h"

#include <cstdint>
#include <span>
#include <utility>

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

void Overview::begin(OverviewSource source) {
    texture_ = {};
    job_.begin(std::move(source));
}

void Overview::end() {
    texture_ = {};
    job_.end();
}

void Overview::upload(OverviewImage& image) {
    if (job_.news() || (job_.there() && texture_.get() == 0)) {
        struct To {
            Overview& overview;
            OverviewImage& image;
        } to{*this, image};
        (void)job_.take(
            [](void* into, OverviewSize size, double share, std::span<const std::uint32_t> texels) {
                auto& [overview, shown] = *static_cast<To*>(into);
                overview.store(size, texels.data());
                shown.share = share;
            },
            &to);
    }
    if (!job_.there()) image.share = 0;
    image.texture = texture_.get();
}

void Overview::store(OverviewSize size, const std::uint32_t* texels) {
    if (texture_.get() == 0) texture_ = make_panel_texture(GL_RGBA8, size.columns, size.rows);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(texture_.get(), 0, 0, 0, static_cast<GLsizei>(size.columns), static_cast<GLsizei>(size.rows),
                        GL_RGBA, GL_UNSIGNED_BYTE, texels);
}

void Overview::drop_graphics(OverviewImage& image) {
    texture_ = {};
    image.texture = 0;
}

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
