// Pictures that panels show as textures: the overview, and the heights that are to be baked.
//
// Ownership: the textures and the job that paints the overview. Thread: the frame's, with the graphics context current
// for all but done() and news(). Memory: 4 bytes a texel on the GPU; upload() allocates nothing while the texture
// stays.
#pragma once

#include "editor/jobs/heights.h"
#include "editor/jobs/overview.h"
#include "editor/state.h"
#include "gl/objects.h"

namespace fjell::editor {

class Overview {
public:
    // Another terrain, from nothing, or the same in other colours.
    void begin(OverviewSource source);
    void end(); // no terrain
    // upload() would bring something.
    [[nodiscard]] bool news() const { return job_.news(); }
    // Brings the texture up to date, and makes it when there is none.
    void upload(OverviewImage& image);
    void drop_graphics(OverviewImage& image);
    // All that there will be is painted and shown.
    [[nodiscard]] bool done() const { return job_.done(); }

private:
    void store(OverviewSize size, const std::uint32_t* texels);

    gl::Texture texture_; // none: of another terrain, or the context was lost
    OverviewJob job_;
};

class PreviewTexture {
public:
    // Of the draft's facts; tells the draft its name, 0 where there is no picture.
    void set(BakeDraft& draft);
    void drop_graphics(BakeDraft& draft);

private:
    gl::Texture texture_;
};

} // namespace fjell::editor
