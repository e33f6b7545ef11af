// The real editor in a real window on an X server of its own: xdotool moves the pointer and presses keys, the editor's
// JSON dump (SIGUSR1, FJELL_EDITOR_DUMP) says what came of it and where its controls are, and the server's own memory
// is what a user would see.
//
// Nothing here depends on how fast the machine is. Every input returns when the editor has counted its event (the
// dump's "input") and two more frames have begun: then its command has been applied, the panels show it, and so does
// the screen. Every wait ends the test after three minutes, saying what it waited for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/types.h>

#include "fjell/gl/image.h"
#include "support/temporary_folder.h"

namespace fjell::test {

// Why there can be no window here, or empty: Xvfb and xdotool are Debian packages that ./dev installs.
[[nodiscard]] std::string why_no_windows();

class VirtualDisplay {
public:
    VirtualDisplay(std::uint32_t width, std::uint32_t height);
    ~VirtualDisplay();
    VirtualDisplay(const VirtualDisplay&) = delete;
    VirtualDisplay& operator=(const VirtualDisplay&) = delete;

    [[nodiscard]] const std::string& name() const { return name_; } // ":1"
    [[nodiscard]] gl::Image picture() const;                        // of the whole screen

private:
    TemporaryFolder folder_; // the server keeps its screen here
    pid_t pid_ = -1;
    std::string name_;
};

struct Place {
    double x = 0, y = 0, width = 0, height = 0;
};

// Where the terrain is drawn.
[[nodiscard]] Place view_of(const nlohmann::json& state);
// Share of the pixels of a place that differ by more than a little.
[[nodiscard]] double changed(const gl::Image& a, const gl::Image& b, const Place& p);

// Whether a test looks at pictures. Where it does not, software need not fill their pixels (no_pixels).
enum class Pixels { drawn, unseen };

class EditorWindow {
public:
    using Condition = std::function<bool(const nlohmann::json& state)>;
    // home: holds all that the editor keeps (XDG folders) and its dump; a test may look into it, or spoil it.
    EditorWindow(const VirtualDisplay& display, const std::filesystem::path& home,
                 const std::vector<std::string>& arguments, Pixels pixels = Pixels::drawn);
    ~EditorWindow(); // kills what is still running

    void find(); // the window, again after it was replaced; it then has the focus

    [[nodiscard]] nlohmann::json state(); // of a frame later than that of any state before
    // The first state in which it holds.
    nlohmann::json until(const std::string& what, const Condition& holds);
    [[nodiscard]] Place place(const std::string& mark); // where a control is, once it has come to rest there

    void move(double x, double y); // the pointer, in pixels of the window
    void click(const std::string& mark);
    void click_at(double x, double y);
    void click_twice(const std::string& mark); // as fast as there are events, whatever frames there are
    // Presses at one share of its width, moves in steps to another, releases.
    void drag(const std::string& mark, double from, double to);
    void drag_at(double x, double y, double to_x, double to_y);
    void key(const std::string& name); // as xdotool has them: "ctrl+z", "Return"
    // Holds a key down until that is so.
    nlohmann::json hold(const std::string& name, const std::string& what, const Condition& holds);
    void type(const std::string& text); // letters, digits and . / - _
    // Presses the key until the keyboard's focus is at that control, as many times as a window may have controls.
    void go_to(const std::string& mark, const std::string& by = "Tab");
    void wheel(int notches); // up is positive
    // Words for xdotool, while the editor draws no frame: so all of it lies between two of its frames. Returns when so
    // many events of that kind have been counted.
    void between_frames(const std::vector<std::string>& what, const char* counter, std::uint64_t events);
    void resize(std::uint32_t width, std::uint32_t height);

    [[nodiscard]] bool runs();
    void signal(int number);
    [[nodiscard]] int exit_code();            // waits for the end; 128 + n after a signal
    [[nodiscard]] std::string errors() const; // its stderr so far

private:
    void start_tool();
    void end_tool();
    // Returns what that has printed: nothing where there was nothing to be found.
    std::string xdotool(const std::string& what);
    // None: the editor has ended.
    std::optional<nlohmann::json> dump();
    std::optional<nlohmann::json> until_or_end(const std::string& what, const Condition& holds);
    // Sends it, waits until the editor has counted so many more events of that kind, and two frames more. An editor
    // that ends has seen it.
    void send(const std::string& what, const char* counter, std::uint64_t events);
    void send_unsettled(const std::string& what, const char* counter, std::uint64_t events); // without those two frames
    void settle();                                                                           // two frames more

    const VirtualDisplay& display_;
    std::filesystem::path home_;
    pid_t pid_ = -1, tool_ = -1; // the editor; xdotool
    int status_ = -1, tool_in_ = -1, tool_out_ = -1;
    std::string window_;
    std::uint64_t frame_ = 0; // of the last dump
    nlohmann::json input_;    // of the last dump
};

} // namespace fjell::test
