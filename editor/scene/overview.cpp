#include "editor/scene/overview.h"

#include <span>
#include <utility>

#include "editor/scene/panel_texture.h"

namespace fjell::editor {

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

} // namespace fjell::editor
