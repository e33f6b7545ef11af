// The bookmarks' thumbnails as textures.
//
// Ownership: the textures. Thread: the frame's, with the graphics context current. Memory: 4 bytes a texel.
#pragma once

#include <vector>

#include "editor/bookmarks.h"
#include "gl/objects.h"

namespace fjell::editor {

class Thumbnails {
public:
    // When bookmarks have changed: makes all of them again. Nothing otherwise.
    void upload(Bookmarks& bookmarks);
    void drop_graphics(Bookmarks& bookmarks);

private:
    std::vector<gl::Texture> textures_;
};

} // namespace fjell::editor
