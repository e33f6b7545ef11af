// A second profile of the terrain that is shown, drawn into the same picture: beyond a divider, or as a difference.
//
// It has a session of its own, opened by a thread from the file that is open, and is refined for the same view in the
// same frame. Ownership: that session, its renderer and its target. Thread: the frame's, with the graphics context
// current. Memory: as much as the terrain itself takes, while it is on. Cost: an update and a picture more a frame,
// which are not the editor's own nor the first profile's. Failure: io::Failure; it is off then.
#pragma once

#include <cstdint>
#include <future>
#include <memory>
#include <string>

#include "editor/engine.h"
#include "editor/state.h"
#include "fjell/gl/renderer.h"
#include "fjell/gl/target.h"
#include "gl/objects.h"
#include "session/session.h"

namespace fjell::editor {

// From black, alike, over blue and yellow to white: eight times the difference of the channel that differs most, as
// shares of sRGB's 255.
inline constexpr float difference_gain = 8;
// From so many of 255 on a pixel is counted as one that differs: less is hardly seen.
inline constexpr int visible_difference = 4;

class PictureDifference {
public:
    ~PictureDifference() { drop_graphics(); }
    // Counts pixels that differ visibly; show: into `first`, which loses its picture. Both have one sample a pixel and
    // the same size.
    void compare(const gl::Target& first, const gl::Target& second, bool show);
    // The share of pixels that was counted last, once the GPU has it; below 0: nothing new.
    [[nodiscard]] double take_share();
    [[nodiscard]] bool counting() const { return counting_; }
    void drop_graphics();

private:
    void make(std::uint32_t width, std::uint32_t height);

    gl::Program program_;
    gl::VertexArray nothing_;
    gl::Texture copies_[2];
    gl::Framebuffer frames_[2];
    std::uint32_t width_ = 0, height_ = 0;
    unsigned query_ = 0; // of samples passed
    bool counting_ = false;
};

class Comparison {
public:
    ~Comparison();
    // Before a frame's update: opens, reopens or closes what the state wants now.
    void follow(State& state, const Engine& engine);
    // True: its mesh is another one than before, or it has just come.
    bool update(State& state, const View& refining);
    // Over the picture of the first profile.
    void draw(const State& state, const gl::Target& target);
    [[nodiscard]] bool opening() const { return opening_.valid(); }
    [[nodiscard]] bool settled() const; // it is off, or has all that its view wants
    void drop_graphics();

private:
    [[nodiscard]] Profile wanted(const State& state) const;
    [[nodiscard]] session::FlightOptions options(const Engine& engine) const;
    void close(State& state);
    void adopt(const Engine& engine);
    [[nodiscard]] bool rests() const; // its mesh
    void halve(State& state);

    Profile profile_;            // that it goes by
    std::uint64_t terrains_ = 0; // Engine::terrains() that it belongs to
    // In the order of destruction, last first: the renderer points into the session.
    std::unique_ptr<session::Session> session_;
    std::unique_ptr<gl::Renderer> renderer_;
    std::unique_ptr<gl::Target> target_;
    PictureDifference difference_;
    std::future<std::unique_ptr<session::Session>> opening_;
    session::FrameEntry entry_;
    bool new_ = false;
    std::uint32_t halving_ = 0, halved_ = 0; // triangles of the first profile, and steps that have looked for half
};

} // namespace fjell::editor
