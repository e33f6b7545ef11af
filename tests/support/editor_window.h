// The real editor in a real window on an X server of its own, driven as by hand: xdotool moves the pointer and presses
// keys, the editor's JSON dump (SIGUSR1, FJELL_EDITOR_DUMP) says what came of it and where its controls are, and the
// server's own memory is what a user would see.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/types.h>

#include "gl/image.h"
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

class EditorWindow {
public:
    // home: holds all that the editor keeps (XDG folders) and its dump; a test may look into it, or spoil it.
    EditorWindow(const VirtualDisplay& display, const std::filesystem::path& home,
                 const std::vector<std::string>& arguments);
    ~EditorWindow(); // kills what is still running

    void find(); // the window anew, after it was replaced

    [[nodiscard]] nlohmann::json state();
    // Asks again and again until it holds; fails the test after 30 s, naming what was waited for.
    nlohmann::json until(const std::string& what, const std::function<bool(const nlohmann::json&)>& holds);
    [[nodiscard]] Place place(const std::string& mark); // waits until there is one

    void move(double x, double y);
    void click(const std::string& mark);
    void click_at(double x, double y);
    // Presses at one share of its width, moves in steps to another, lets go.
    void drag(const std::string& mark, double from, double to);
    void drag_at(double x, double y, double to_x, double to_y);
    void key(const std::string& name); // as xdotool has them: "ctrl+z", "Return"
    void hold(const std::string& name, double seconds);
    void type(const std::string& text);
    void wheel(int notches); // up is positive
    void resize(std::uint32_t width, std::uint32_t height);

    [[nodiscard]] bool runs();
    void signal(int number);
    [[nodiscard]] int exit_code();            // waits for the end; 128 + n after a signal
    [[nodiscard]] std::string errors() const; // its stderr so far

private:
    void xdotool(const std::string& what);

    const VirtualDisplay& display_;
    std::filesystem::path home_;
    pid_t pid_ = -1;
    int status_ = -1;
    std::string window_;
};

} // namespace fjell::test
