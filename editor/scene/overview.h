// The overview's texture: what the thread that paints it has done so far (editor/jobs/overview_job.h).
//
// Ownership: the job and the texture. Thread: the frame's, with the graphics context current for all but done() and
// news(). Memory: 4 bytes a texel on the GPU; upload() allocates nothing while the texture stays.
#pragma once

#include "editor/jobs/overview_job.h"
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

} // namespace fjell::editor
