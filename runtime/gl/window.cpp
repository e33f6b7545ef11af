#include "gl/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "gl/fail.h"

namespace fjell::gl {
namespace {

int open_windows = 0; // GLFW is process-wide and main-thread only, so a plain counter suffices

std::string glfw_reason() {
    const char* text = nullptr;
    if (glfwGetError(&text) == GLFW_NO_ERROR || text == nullptr) return "no reason given";
    return text;
}

} // namespace

std::unique_ptr<Window> Window::create(const WindowOptions& options) {
    if (open_windows == 0 && !glfwInit())
        fail("no window: " + glfw_reason() + "; start it under a display, or use --headless");
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, options.debug ? GLFW_TRUE : GLFW_FALSE);
    if (options.robust) glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
    glfwWindowHint(GLFW_DEPTH_BITS, 0); // pictures are drawn into a Target and copied; its depth is 32-bit float
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    const auto create = [&] {
        return glfwCreateWindow(static_cast<int>(options.width), static_cast<int>(options.height),
                                options.title.c_str(), nullptr, nullptr);
    };
    GLFWwindow* window = create();
    if (window == nullptr && options.robust) { // not every driver has robust contexts
        glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_NO_ROBUSTNESS);
        window = create();
    }
    if (window == nullptr) {
        const std::string why = "no window with OpenGL 4.5 core: " + glfw_reason();
        if (open_windows == 0) glfwTerminate();
        fail(why + "; update the driver, or use --headless");
    }
    ++open_windows;
    std::unique_ptr<Window> result(new Window);
    result->window_ = window;
    if (options.second) { // with the hints of the first, as contexts that share must be alike
        glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
        result->second_.window_ = glfwCreateWindow(1, 1, "", nullptr, window);
    }
    glfwMakeContextCurrent(window);
    glfwSwapInterval(options.vsync ? 1 : 0);
    attach_debug_log(*result->log_);
    return result;
}

Window::~Window() {
    if (window_ == nullptr) return;
    if (second_.window_ != nullptr) glfwDestroyWindow(second_.window_);
    glfwDestroyWindow(window_);
    if (--open_windows == 0) glfwTerminate();
}

bool SecondContext::make_current() {
    glfwMakeContextCurrent(window_);
    return glfwGetCurrentContext() == window_;
}

void SecondContext::release() {
    glfwMakeContextCurrent(nullptr);
}

bool Window::should_close() const {
    return glfwWindowShouldClose(window_) == GLFW_TRUE;
}

void Window::framebuffer_size(std::uint32_t& width, std::uint32_t& height) const {
    int w = 0, h = 0;
    glfwGetFramebufferSize(window_, &w, &h);
    width = static_cast<std::uint32_t>(w);
    height = static_cast<std::uint32_t>(h);
}

void Window::poll() {
    glfwPollEvents();
}
void Window::swap() {
    glfwSwapBuffers(window_);
}
std::string Window::description() const {
    return describe_current();
}

} // namespace fjell::gl
