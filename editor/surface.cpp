#include "editor/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include <epoxy/gl.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "editor/input.h"
#include "gl/window.h"

namespace fjell::editor {

namespace {

class WindowSurface : public Surface {
public:
    explicit WindowSurface(std::unique_ptr<gl::Window> window) : window_(std::move(window)) {
        GLFWwindow* const handle = window_->handle();
        glfwSetWindowUserPointer(handle, this);
        glfwSetDropCallback(handle, [](GLFWwindow* w, int count, const char** paths) {
            auto* const self = static_cast<WindowSurface*>(glfwGetWindowUserPointer(w));
            self->dropped.assign(paths, paths + count);
        });
        ImGui_ImplGlfw_InitForOpenGL(handle, true);
        // In place of ImGui's own: ours keep the order of what happens, and each event's place.
        glfwSetKeyCallback(handle, [](GLFWwindow* w, int key, int, int action, int mods) {
            if (action == GLFW_REPEAT) return; // ImGui repeats by itself
            queue_of(w).push({InputEvent::Kind::key, key, action == GLFW_PRESS, false, mods, 0, pointer_in(w)});
        });
        glfwSetCharCallback(handle, [](GLFWwindow* w, unsigned character) {
            queue_of(w).push(
                {InputEvent::Kind::character, static_cast<int>(character), false, false, 0, 0, pointer_in(w)});
        });
        glfwSetMouseButtonCallback(handle, [](GLFWwindow* w, int button, int action, int) {
            queue_of(w).push({InputEvent::Kind::button, button, action == GLFW_PRESS, false, 0, 0, pointer_in(w)},
                             glfwGetTime());
        });
        glfwSetScrollCallback(handle, [](GLFWwindow* w, double, double notches) {
            queue_of(w).push({InputEvent::Kind::wheel, 0, false, false, 0, static_cast<float>(notches), pointer_in(w)});
        });
        glfwSetCursorPosCallback(handle, [](GLFWwindow* w, double x, double y) {
            static_cast<WindowSurface*>(glfwGetWindowUserPointer(w))->pointer_ = {static_cast<float>(x),
                                                                                  static_cast<float>(y)};
        });
        ImGui_ImplOpenGL3_Init("#version 450 core");
    }
    ~WindowSurface() override {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
    }

    void begin_frame() override {
        window_->poll();
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        ImGuiIO& io = ImGui::GetIO();
        bool held[3] = {};
        for (int b = 0; b < 3; ++b) held[b] = glfwGetMouseButton(window_->handle(), b) == GLFW_PRESS;
        queue_.deliver(io, input, held);
        input.pointer_px[0] = static_cast<double>(io.MousePos.x);
        input.pointer_px[1] = static_cast<double>(io.MousePos.y);
        input.focused = glfwGetWindowAttrib(window_->handle(), GLFW_FOCUSED) != 0;
    }
    bool wait(double most_s) override {
        if (queue_.waits()) return true;
        const double start = glfwGetTime();
        glfwWaitEventsTimeout(most_s);
        return glfwGetTime() - start < 0.95 * most_s;
    }
    void size(std::uint32_t& width, std::uint32_t& height) const override { window_->framebuffer_size(width, height); }
    unsigned framebuffer() const override { return 0; }
    void present() override { window_->swap(); }
    gl::SecondContext* second_context() override { return window_->second(); }
    bool should_close() const override { return window_->should_close(); }
    void stay_open() override { glfwSetWindowShouldClose(window_->handle(), GLFW_FALSE); }
    void set_title(const char* title) override { glfwSetWindowTitle(window_->handle(), title); }
    void resize(std::uint32_t width, std::uint32_t height) override {
        glfwSetWindowSize(window_->handle(), static_cast<int>(width), static_cast<int>(height));
    }
    bool lost() const override { return glGetGraphicsResetStatus() != GL_NO_ERROR; }
    std::string description() const override { return window_->description(); }
    double content_scale() const override {
        float x = 1, y = 1;
        glfwGetWindowContentScale(window_->handle(), &x, &y);
        return x > y ? static_cast<double>(x) : static_cast<double>(y);
    }

private:
    static InputQueue& queue_of(GLFWwindow* w) {
        return static_cast<WindowSurface*>(glfwGetWindowUserPointer(w))->queue_;
    }
    static ImVec2 pointer_in(GLFWwindow* w) {
        return static_cast<WindowSurface*>(glfwGetWindowUserPointer(w))->pointer_;
    }

    InputQueue queue_;
    ImVec2 pointer_{};
    std::unique_ptr<gl::Window> window_;
};

class HeadlessSurface : public Surface {
public:
    HeadlessSurface(std::unique_ptr<gl::Headless> context, std::unique_ptr<gl::Target> target)
        : context_(std::move(context)), target_(std::move(target)) {
        ImGui_ImplOpenGL3_Init("#version 450 core");
    }
    ~HeadlessSurface() override { ImGui_ImplOpenGL3_Shutdown(); }

    void begin_frame() override {
        ImGui_ImplOpenGL3_NewFrame();
        ImGuiIO& io = ImGui::GetIO();
        io.DisplaySize = {static_cast<float>(target_->width()), static_cast<float>(target_->height())};
        io.DeltaTime = 1.0F / 60;
    }
    bool wait(double) override { return false; }
    void size(std::uint32_t& width, std::uint32_t& height) const override {
        width = target_->width();
        height = target_->height();
    }
    unsigned framebuffer() const override { return target_->framebuffer(); }
    void present() override {}
    bool should_close() const override { return false; }
    void stay_open() override {}
    void set_title(const char*) override {}
    void resize(std::uint32_t width, std::uint32_t height) override {
        target_ = gl::Target::create({width, height, 1});
    }
    bool lost() const override { return false; }
    std::string description() const override { return context_->description(); }
    double content_scale() const override { return 1; }

private:
    std::unique_ptr<gl::Headless> context_;
    std::unique_ptr<gl::Target> target_; // after the context
};

} // namespace

void Surface::draw_interface() {
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Surface::fonts_changed() {
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
}

void Surface::read(gl::Image& image) const {
    size(image.width, image.height);
    const std::size_t row = std::size_t{3} * image.width;
    std::vector<std::uint8_t> pixels(row * image.height);
    glFinish(); // as Target::read_colour
    glDisable(GL_FRAMEBUFFER_SRGB);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer());
    if (framebuffer() == 0) glReadBuffer(GL_BACK);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, static_cast<GLsizei>(image.width), static_cast<GLsizei>(image.height), GL_RGB, GL_UNSIGNED_BYTE,
                 pixels.data());
    image.rgb.resize(pixels.size());
    for (std::size_t y = 0; y < image.height; ++y) // GL's rows start at the bottom
        std::memcpy(image.rgb.data() + y * row, pixels.data() + (image.height - 1 - y) * row, row);
}

std::unique_ptr<Surface> make_surface(const SurfaceOptions& options) {
    if (!options.headless)
        return std::make_unique<WindowSurface>(
            gl::Window::create({options.width, options.height, "Fjell editor", false, options.vsync, true, true}));
    auto context = gl::Headless::create();
    auto target = gl::Target::create({options.width, options.height, 1});
    return std::make_unique<HeadlessSurface>(std::move(context), std::move(target));
}

void blit(const gl::Target& target, unsigned framebuffer, std::uint32_t framebuffer_height, const Place& to) {
    const auto w = static_cast<GLint>(target.width()), h = static_cast<GLint>(target.height());
    const auto left = static_cast<GLint>(to.x), wide = static_cast<GLint>(to.width),
               high = static_cast<GLint>(to.height);
    const GLint bottom = static_cast<GLint>(framebuffer_height) - static_cast<GLint>(to.y) - high;
    glDisable(GL_FRAMEBUFFER_SRGB); // a raw copy: both hold sRGB bytes
    glBlitNamedFramebuffer(target.framebuffer(), framebuffer, 0, 0, w, h, left, bottom, left + wide, bottom + high,
                           GL_COLOR_BUFFER_BIT, w == wide && h == high ? GL_NEAREST : GL_LINEAR);
}

void rehearse_blit(const Surface& surface) {
    const auto target = gl::Target::create({2, 2, 1});
    std::uint32_t width = 0, height = 0;
    surface.size(width, height);
    for (const std::uint32_t side : {2u, 4u}) blit(*target, surface.framebuffer(), height, {0, 0, side, side});
    glFinish();
}

// --- How long the GPU takes.

void GpuTimer::begin() {
    Pair& pair = pairs_[next_];
    begun_ = !pair.waits;
    if (!begun_) return;
    if (pair.names[0] == 0) glCreateQueries(GL_TIMESTAMP, 2, pair.names);
    glQueryCounter(pair.names[0], GL_TIMESTAMP);
}

void GpuTimer::end() {
    if (!begun_) return;
    begun_ = false;
    glQueryCounter(pairs_[next_].names[1], GL_TIMESTAMP);
    pairs_[next_].waits = true;
    next_ = (next_ + 1) % frames;
}

double GpuTimer::take_us() {
    double us = -1;
    for (; pairs_[oldest_].waits; oldest_ = (oldest_ + 1) % frames) {
        Pair& pair = pairs_[oldest_];
        GLint there = 0;
        glGetQueryObjectiv(pair.names[1], GL_QUERY_RESULT_AVAILABLE, &there);
        if (there == 0) break;
        GLuint64 from = 0, to = 0;
        glGetQueryObjectui64v(pair.names[0], GL_QUERY_RESULT, &from);
        glGetQueryObjectui64v(pair.names[1], GL_QUERY_RESULT, &to);
        us = to > from ? static_cast<double>(to - from) * 1e-3 : 0;
        pair.waits = false;
    }
    return us;
}

void GpuTimer::drop_graphics() {
    for (Pair& pair : pairs_)
        if (pair.names[0] != 0) glDeleteQueries(2, pair.names);
    *this = {};
}

} // namespace fjell::editor
