// The terrain's picture in a frame: whole, at half resolution while the camera moves and software draws, or in bands
// after that; and whether it has to be drawn anew at all.
//
// Ownership: its targets. Thread: the frame's, with the graphics context current. Failure: io::Failure.
#pragma once

#include <cstdint>
#include <memory>

#include "editor/comparison.h"
#include "editor/engine.h"
#include "editor/measures.h"
#include "editor/state.h"
#include "fjell/gl/target.h"

namespace fjell::editor {

// A stretch of the editor's own code in a frame, told to whoever watches.
class OwnCode {
public:
    explicit OwnCode(void (*watch)(bool begins)) : watch_(watch) { watch_(true); }
    ~OwnCode() { watch_(false); }
    OwnCode(const OwnCode&) = delete;
    OwnCode& operator=(const OwnCode&) = delete;

private:
    void (*watch_)(bool begins);
};

// What a picture is drawn by, of this frame.
struct PictureFrame {
    const session::FrameEntry& entry;
    bool asked = false;  // for: who asks for a picture gets it whole
    bool opened = false; // by a thread; the first pack, of the command line, is shown at once
    bool compared_changed = false;
    void (*watch)(bool begins);
};

class TerrainPicture {
public:
    // Whether this frame's view and mesh have to be drawn.
    void judge(const State& state, const Engine& engine, const PictureFrame& frame);
    [[nodiscard]] bool old() const { return old_; }
    void redraw(); // all of it, bands that are drawn already too
    // Tells the state what was drawn, and times what it took.
    void draw(State& state, Engine& engine, Comparison& comparison, const PictureFrame& frame, FrameTimes& times);
    [[nodiscard]] const gl::Target* shown() const { return shown_; } // what was drawn last; null: nothing
    // After the frame: what a picture of half resolution took, with its copy, where software catches up.
    void end_frame(const FrameTimes& times);
    void drop_graphics();

private:
    gl::Target& fit(const Interface& interface, bool half);
    [[nodiscard]] PictureRows next_band(std::uint32_t height) const;
    PictureRows next_first_band(const View& view, const session::FrameEntry& entry, std::uint32_t height);

    std::unique_ptr<gl::Target> whole_, half_; // the terrain's picture, and that of a moving camera
    const gl::Target* shown_ = nullptr;
    bool old_ = true;
    bool mesh_changed_ = false;     // in this frame
    bool ground_waiting_ = false;   // in the frame before
    bool moving_ = false;           // the camera, since the last picture
    std::uint32_t first_row_ = 0;   // of a terrain's first picture, rows below it are drawn already
    std::uint32_t first_bands_ = 1; // that it is drawn in
    View first_view_;               // of it
    bool drew_half_ = false;        // in this frame
    double half_us_ = 0;            // what the last picture of half resolution took
    std::uint32_t band_row_ = 0;    // of the whole picture, rows below this one are drawn already
    View drawn_view_;               // of the last picture
    std::uint64_t drawn_terrain_ = 0;
};

} // namespace fjell::editor
