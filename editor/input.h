// What happens between two frames, handed on in order and in as many frames as it takes.
//
// ImGui 1.86 looks at keys and buttons once a frame: of two presses in between it would see one, a click where the
// pointer is by then, and letters that follow a click before the field that it was on has the keyboard. Here each event
// keeps its place and its order, and one that would hide the one before waits for the next frame. So a window that is
// drawn twice a second loses nothing.
//
// Thread: the frame's. Memory: of the events that wait.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <imgui.h>

#include "editor/surface.h"

namespace fjell::editor {

struct InputEvent {
    enum class Kind : std::uint8_t { key, character, button, wheel };
    Kind kind = Kind::key;
    int code = 0;       // GLFW's key or button, or the character
    bool down = false;  // of a key or a button
    bool twice = false; // of a button: the second press of a double click
    int mods = 0;       // GLFW's, of a key
    float notches = 0;  // of the wheel
    ImVec2 at;          // the pointer
};

class InputQueue {
public:
    InputQueue() { events_.reserve(64); }
    // Of a press time_s counts, for double clicks.
    void push(InputEvent event, double time_s = 0);
    [[nodiscard]] bool waits() const { return next_ < events_.size(); } // for a frame
    // Before ImGui's frame, after the back end's: as many as one frame can see. held: of the buttons, now.
    void deliver(ImGuiIO& io, InputCounts& counts, const bool (&held)[3]);

private:
    struct Frame;
    [[nodiscard]] bool may_follow(const InputEvent& event, const ImGuiIO& io, const Frame& frame) const;

    std::vector<InputEvent> events_;
    std::size_t next_ = 0;
    bool down_[3] = {};
    int settling_ = 0; // frames until a field that was clicked, or a dialog that was asked for, has the keyboard
    double clicked_s_ = -1e9;
    ImVec2 clicked_at_;
};

} // namespace fjell::editor
