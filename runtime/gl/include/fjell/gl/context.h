// An OpenGL 4.5 core context: headless through EGL, or in a window through GLFW.
//
// Ownership: the object owns its context; everything made in it (Target, Renderer) must be destroyed first, while the
// context is current. Thread: a context is current on one thread at a time; creation makes it current on the caller's.
// Failure: create() returns null and fills `error` with one line that says what to do; nothing aborts.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

struct GLFWwindow;

namespace fjell::gl {

// What KHR_debug reported. Only errors and messages of high severity are kept, the first 64 as text.
struct DebugLog {
    std::uint64_t errors = 0;
    std::vector<std::string> messages;
};

struct HeadlessOptions {
    bool debug = false; // a debug context: every GL error lands in the log, at some cost in speed
    int device = -1;    // -1: Mesa's surfaceless platform, then every EGL device; n >= 0: the n-th EGL device only
};

class Headless {
public:
    [[nodiscard]] static std::unique_ptr<Headless> create(const HeadlessOptions& options, std::string& error);
    ~Headless();
    Headless(const Headless&) = delete;
    Headless& operator=(const Headless&) = delete;

    [[nodiscard]] bool make_current();
    // Renderer and version strings of the driver, for reports.
    [[nodiscard]] std::string description() const;
    [[nodiscard]] const DebugLog& log() const { return *log_; }

private:
    Headless() = default;
    void* display_ = nullptr; // EGLDisplay
    void* context_ = nullptr; // EGLContext
    std::unique_ptr<DebugLog> log_ = std::make_unique<DebugLog>();
};

struct WindowOptions {
    std::uint32_t width = 1280, height = 720; // in screen coordinates; the framebuffer may have more pixels
    std::string title = "Fjell";
    bool debug = false;
    bool vsync = true;
    bool robust = false; // tells of a driver that has reset (glGetGraphicsResetStatus), where it can
};

// One window at a time: GLFW is started with the first and stopped with the last.
class Window {
public:
    [[nodiscard]] static std::unique_ptr<Window> create(const WindowOptions& options, std::string& error);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    [[nodiscard]] GLFWwindow* handle() const { return window_; } // for keys, mouse and user interface back ends
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
    std::unique_ptr<DebugLog> log_ = std::make_unique<DebugLog>();
};

// Sends the current context's messages to `log`, which must outlive the context.
void attach_debug_log(DebugLog& log);
// "renderer, version" of the current context.
[[nodiscard]] std::string describe_current();

} // namespace fjell::gl
