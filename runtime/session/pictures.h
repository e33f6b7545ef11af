// Frames of a headless flight as PNG files. The only part of a headless flight that touches OpenGL.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "fjell/gl/renderer.h"
#include "fjell/gl/target.h"
#include "session/options.h"
#include "session/session.h"

namespace fjell::session {

// What write() below may call a picture: frame_NNNNN.png.
[[nodiscard]] bool is_picture_name(std::string_view name);

// The profile's light, in this mode. time_s: of the flight, for what moves by itself.
[[nodiscard]] gl::DrawOptions draw_options(PictureMode mode, const Profile& profile, double time_s);
// A target of this size with the profile's samples, or as many as this GPU has.
[[nodiscard]] std::unique_ptr<gl::Target> make_target(std::uint32_t width, std::uint32_t height,
                                                      const Profile& profile);

// A renderer with room for the session's mesh, whichever method makes it.
[[nodiscard]] std::unique_ptr<gl::Renderer> make_renderer(const FlightOptions& options, const Session& session);
// Uploads what the last update wrote: once after every update, drawn or not.
void upload_mesh(gl::Renderer& renderer, const Session& session, const FrameEntry& entry);

class Pictures {
public:
    // Throws Failure 3 when there is no OpenGL 4.5.
    Pictures(const FlightOptions& options, const Session& session);
    ~Pictures();
    Pictures(const Pictures&) = delete;
    Pictures& operator=(const Pictures&) = delete;

    // Uploads what the last update wrote; call it after every update. Throws Failure 3.
    void follow(const Session& session, const FrameEntry& entry);
    // Draws the mesh of the last update and writes FOLDER/frame_NNNNN.png. Throws Failure 3.
    void write(const Session& session, const View& view, std::size_t frame, double time_s);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace fjell::session
