// A window with an OpenGL 4.5 core context, through GLFW: for our programs. A host has a window of its own.
//
// Ownership: the object owns its context; everything made in it (Target, Renderer) must be destroyed first, while the
// context is current. Thread: the main one, as GLFW has it. Failure: create() throws io::Failure, 3, whose one line
// says what to do; nothing aborts.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "fjell/gl/context.h"

struct GLFWwindow;

namespace fjell::gl {

struct WindowOptions {
    std::uint32_t width = 1280, height = 720; // in screen coordinates; the framebuffer may have more pixels
    std::string title = "Fjell";
    bool debug = false;
    bool vsync = true;
    bool robust = false; // tells of a driver that has reset (glGetGraphicsResetStatus), where it can
    bool second = false; // with a second context, Window::second(), where the driver gives one
};

// A context beside a window's, without a window: what is made in one is there in the other. Ownership: the window's,
// which must outlive what is made in it. Thread: any, one at a time.
class SecondContext {
public:
    // On the caller's thread; false: refused.
    [[nodiscard]] bool make_current();
    void release(); // on the thread that has it

private:
    friend class Window;
    GLFWwindow* window_ = nullptr; // never shown
};

// One window at a time: GLFW is started with the first and stopped with the last.
class Window {
public:
    [[nodiscard]] static std::unique_ptr<Window> create(const WindowOptions& options);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    [[nodiscard]] GLFWwindow* handle() const { return window_; } // for keys, mouse and user interface back ends
    [[nodiscard]] SecondContext* second() { return second_.window_ != nullptr ? &second_ : nullptr; } // null: none
    [[nodiscard]] bool should_close() const;
    // Pixels; 0 x 0 while minimised.
    void framebuffer_size(std::uint32_t& width, std::uint32_t& height) const;
    void poll();
    void swap();
    [[nodiscard]] std::string description() const;
    [[nodiscard]] const DebugLog& log() const { return *log_; }

private:
    Window() = default;
    GLFWwindow* window_ = nullptr;
    SecondContext second_;
    std::unique_ptr<DebugLog> log_ = std::make_unique<DebugLog>();
};

} // namespace fjell::gl
