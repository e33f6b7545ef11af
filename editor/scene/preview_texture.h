// The picture of what is to be baked (editor/jobs/height_look.h), for the panels.
//
// Ownership: the texture. Thread: the frame's, with the graphics context current.
#pragma once

#include "editor/jobs/height_look.h"
#include "gl/objects.h"

namespace fjell::editor {

class PreviewTexture {
public:
    // Of the draft's facts; tells the draft its name, 0 where there is no picture.
    void set(BakeDraft& draft);
    void drop_graphics(BakeDraft& draft);

private:
    gl::Texture texture_;
};

} // namespace fjell::editor
