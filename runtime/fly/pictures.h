// Frames of a headless flight as PNG files. The only part of a headless flight that touches OpenGL.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "fly/options.h"
#include "fly/session.h"
#include "gl/renderer.h"

namespace fjell::fly {

[[nodiscard]] gl::DrawOptions draw_options(PictureMode mode);

class Pictures {
public:
    // Throws Failure 3 when there is no OpenGL 4.5.
    Pictures(const Options& options, const Session& session);
    ~Pictures();
    Pictures(const Pictures&) = delete;
    Pictures& operator=(const Pictures&) = delete;

    // Draws the mesh of the last update and writes FOLDER/frame_NNNNN.png. Throws Failure 3.
    void write(const Session& session, const View& view, std::size_t frame);
    [[nodiscard]] std::size_t written() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace fjell::fly
