// The keyboard in panels, menus and dialogs.
//
// ImGui 1.86 tabs through text fields alone, presses with Space alone, and shows nothing of where Tab has arrived. Here
// it does what users of windows expect: Tab reaches every control, Enter presses it, and it has an outline. Panels are
// panes: F6 goes from one to the next and, after the last, back to the picture; Ctrl+PageDown turns to a pane's next
// panel. Thread: the frame's. Memory: none.
#pragma once

#include "editor/command.h"
#include "editor/state.h"

namespace fjell::editor::keyboard {

// Before ImGui's frame: whether keys move in panels and dialogs, or are the camera's; and what Enter presses.
void begin_frame(const State& state);
// After it has begun: where Tab goes on from, F6, and menus by Alt with their first letter.
void begin_panels(const State& state, Commands& commands);

// What is drawn while it lives is reached by Tab.
class TabStops {
public:
    explicit TabStops(bool on = true);
    ~TabStops();
    TabStops(const TabStops&) = delete;
    TabStops& operator=(const TabStops&) = delete;
};
// What is drawn while it lives is not reached by keys: it follows the pointer, and has a twin that keys reach.
class PointerOnly {
public:
    PointerOnly();
    ~PointerOnly();
    PointerOnly(const PointerOnly&) = delete;
    PointerOnly& operator=(const PointerOnly&) = delete;
};

// The next window is a pane, the one after the pane before in this frame.
class Pane {
public:
    explicit Pane(const State& state);
    void began(); // within the window
    // Which way to turn to another of its panels, -1 or 1; 0: stay. The keys stay with the pane.
    [[nodiscard]] int turns() const;

private:
    int index_;
    bool keys_, focuses_;
};

// The item before has no outline of its own: draws one if keys are at it. True: they are.
bool outline();
// The item before takes arrows itself: left and right, and with Shift all four, move the focus nowhere.
void keep_arrows();
// The focus is shown from now on, as after an arrow key.
void show_focus();
// Keys are at the item before, having just moved there.
[[nodiscard]] bool arrived();

} // namespace fjell::editor::keyboard
