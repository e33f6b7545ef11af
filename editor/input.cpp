#include "editor/input.h"

#include <bitset>
#include <cmath>

namespace fjell::editor {

namespace {

// GLFW's numbers, so that tests need no window.
constexpr int control_mod = 2, alt_mod = 4, super_mod = 8;
constexpr int first_printable = 32, last_printable = 96, enter_key = 257, tab_key = 258, keypad_enter = 335,
              first_function = 290, last_function = 314, first_modifier = 340, last_modifier = 347;
constexpr double double_click_s = 0.35;
constexpr float double_click_px = 6;
constexpr int settling_frames = 3; // the command is applied, the dialog is drawn, its field is active

bool is_modifier(int key) {
    return key >= first_modifier && key <= last_modifier;
}

// A letter, which a field takes as a character and anything else as a key.
bool is_letter(const InputEvent& e) {
    return e.code >= first_printable && e.code <= last_printable && (e.mods & (control_mod | alt_mod | super_mod)) == 0;
}

bool moves_focus(const InputEvent& e) {
    if (e.kind == InputEvent::Kind::button) return e.down;
    if (e.kind != InputEvent::Kind::key || !e.down || is_modifier(e.code)) return false;
    return (e.mods & (control_mod | alt_mod | super_mod)) != 0 || e.code == tab_key || e.code == enter_key ||
           e.code == keypad_enter || (e.code >= first_function && e.code <= last_function);
}

} // namespace

// What one frame has been given so far.
struct InputQueue::Frame {
    std::bitset<512> keys; // that went down or up
    bool button = false, character = false, command = false, letter = false;
};

void InputQueue::push(InputEvent event, double time_s) {
    if (event.kind == InputEvent::Kind::key && (event.code < 0 || event.code >= 512)) return;
    if (event.kind == InputEvent::Kind::button && event.code == 0 && event.down) {
        event.twice = std::abs(event.at.x - clicked_at_.x) < double_click_px &&
                      std::abs(event.at.y - clicked_at_.y) < double_click_px && time_s - clicked_s_ < double_click_s;
        clicked_s_ = event.twice ? -1e9 : time_s; // a third click begins again
        clicked_at_ = event.at;
    }
    if (!waits()) {
        events_.clear();
        next_ = 0;
    }
    events_.push_back(event);
}

bool InputQueue::may_follow(const InputEvent& e, const ImGuiIO& io, const Frame& frame) const {
    switch (e.kind) {
    case InputEvent::Kind::button: return !frame.button && !frame.character && !frame.command;
    case InputEvent::Kind::wheel: return !frame.button;
    case InputEvent::Kind::character: return settling_ == 0 && !frame.button && !frame.command;
    case InputEvent::Kind::key: break;
    }
    if (is_modifier(e.code)) return !frame.button && !frame.command && !frame.letter;
    if (is_letter(e) && e.down && settling_ > 0) return false;
    if (is_letter(e) && io.WantTextInput) return true; // it comes as a character
    if (frame.keys[static_cast<std::size_t>(e.code)] || frame.button) return false;
    return is_letter(e) || !e.down || (!frame.command && !frame.character);
}

void InputQueue::deliver(ImGuiIO& io, InputCounts& counts, const bool (&held)[3]) {
    if (settling_ > 0) --settling_;
    io.MouseDoubleClickTime = 0; // seconds between two frames
    Frame frame;
    for (; waits() && may_follow(events_[next_], io, frame); ++next_) {
        const InputEvent& e = events_[next_];
        switch (e.kind) {
        case InputEvent::Kind::button:
            ++counts.buttons;
            frame.button = true;
            if (e.code >= 0 && e.code < 3) down_[e.code] = e.down;
            io.MousePos = e.at;
            if (e.twice) io.MouseDoubleClickTime = 1e6F;
            break;
        case InputEvent::Kind::wheel:
            ++counts.scrolls;
            io.MouseWheel += e.notches;
            io.MousePos = e.at;
            break;
        case InputEvent::Kind::character:
            ++counts.characters;
            frame.character = frame.character || io.WantTextInput;
            io.AddInputCharacter(static_cast<unsigned>(e.code));
            break;
        case InputEvent::Kind::key:
            ++counts.keys;
            if (is_letter(e) && e.down && io.WantTextInput) break;
            io.KeysDown[e.code] = e.down;
            if (is_modifier(e.code)) break;
            frame.keys.set(static_cast<std::size_t>(e.code));
            (is_letter(e) ? frame.letter : frame.command) |= e.down;
            break;
        }
        if (moves_focus(e)) settling_ = settling_frames;
    }
    for (int b = 0; b < 3; ++b) {
        if (!waits() && !frame.button && !held[b]) down_[b] = false; // whatever became of the event
        io.MouseDown[b] = down_[b];
    }
    const auto either = [&](int left) { return io.KeysDown[left] || io.KeysDown[left + 4]; };
    io.KeyShift = either(first_modifier);
    io.KeyCtrl = either(first_modifier + 1);
    io.KeyAlt = either(first_modifier + 2);
    io.KeySuper = either(first_modifier + 3);
}

} // namespace fjell::editor
