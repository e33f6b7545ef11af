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
        glfwSetKeyCallback(handle, [](GLFWwindow* w, int key, int, int action, int mods) {
            auto* const self = static_cast<WindowSurface*>(glfwGetWindowUserPointer(w));
            if (action != GLFW_REPEAT) ++self->input.keys;
            self->remember_press(key, action, mods);
        });
        glfwSetCharCallback(handle, [](GLFWwindow* w, unsigned) { ++counts_of(w).characters; });
        glfwSetMouseButtonCallback(handle, [](GLFWwindow* w, int button, int action, int) {
            auto* const self = static_cast<WindowSurface*>(glfwGetWindowUserPointer(w));
            if (button == GLFW_MOUSE_BUTTON_LEFT)
                self->remember_button(action == GLFW_PRESS);
            else
                ++self->input.buttons;
        });
        glfwSetCursorPosCallback(handle, [](GLFWwindow* w, double x, double y) {
            static_cast<WindowSurface*>(glfwGetWindowUserPointer(w))->pointer_ = {static_cast<float>(x),
                                                                                  static_cast<float>(y)};
        });
        glfwSetScrollCallback(handle, [](GLFWwindow* w, double, double) { ++counts_of(w).scrolls; });
        ImGui_ImplGlfw_InitForOpenGL(handle, true); // its callbacks call ours
        ImGui_ImplOpenGL3_Init("#version 450 core");
    }
    ~WindowSurface() override {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
    }

    void begin_frame() override {
        ImGuiIO& io = ImGui::GetIO();
        for (std::size_t i = 0; i < held_; ++i)
            if (glfwGetKey(window_->handle(), held_keys_[i]) != GLFW_PRESS) io.KeysDown[held_keys_[i]] = false;
        window_->poll();
        for (std::size_t i = 0; i < pressed_; ++i) io.KeysDown[keys_[i]] = true;
        if (pressed_ != 0) {
            io.KeyCtrl = (mods_ & GLFW_MOD_CONTROL) != 0;
            io.KeyShift = (mods_ & GLFW_MOD_SHIFT) != 0;
            io.KeyAlt = (mods_ & GLFW_MOD_ALT) != 0;
        }
        held_keys_ = keys_;
        held_ = std::exchange(pressed_, 0);
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        deliver_button(io);
        input.pointer_px[0] = static_cast<double>(io.MousePos.x);
        input.pointer_px[1] = static_cast<double>(io.MousePos.y);
        input.focused = glfwGetWindowAttrib(window_->handle(), GLFW_FOCUSED) != 0;
    }
    bool wait(double most_s) override { // presses are remembered for begin_frame()
        if (waiting_ != 0) return true;
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
    static InputCounts& counts_of(GLFWwindow* w) {
        return static_cast<WindowSurface*>(glfwGetWindowUserPointer(w))->input;
    }
    // ImGui 1.86 looks at keys once a frame: what goes down and up again between two frames would be lost. It is held
    // down for the frame that follows, with the modifiers it was pressed with.
    void remember_press(int key, int action, int mods) {
        if (action != GLFW_PRESS || key < 0 || key >= GLFW_KEY_LEFT_SHIFT || pressed_ == keys_.size()) return;
        keys_[pressed_++] = key;
        mods_ = mods;
    }

    // Of what happens between two frames ImGui 1.86 sees the last: two clicks would be one, where the pointer is by
    // then, and whether they are a double click would be told by the times of frames, which software may draw seldom.
    // So the button's events wait, each with its place, for a frame of their own.
    struct ButtonEvent {
        bool down = false, twice = false; // twice: the second press of a double click
        ImVec2 at;
    };
    void remember_button(bool down) {
        ButtonEvent event{down, false, pointer_};
        if (down) {
            const double now_s = glfwGetTime();
            event.twice = std::abs(pointer_.x - clicked_at_.x) < double_click_px &&
                          std::abs(pointer_.y - clicked_at_.y) < double_click_px && now_s - clicked_s_ < double_click_s;
            clicked_s_ = event.twice ? -double_click_s : now_s; // a third click begins again
            clicked_at_ = pointer_;
        }
        if (waiting_ < events_.size()) events_[waiting_++] = event;
    }
    void deliver_button(ImGuiIO& io) {
        io.MouseDoubleClickTime = 0; // seconds between two frames
        if (waiting_ != 0) {
            const ButtonEvent event = events_[0];
            std::rotate(events_.begin(), events_.begin() + 1, events_.end());
            --waiting_;
            ++input.buttons;
            down_ = event.down;
            io.MousePos = event.at;
            if (event.twice) io.MouseDoubleClickTime = 1e6F;
        } else if (glfwGetMouseButton(window_->handle(), GLFW_MOUSE_BUTTON_LEFT) != GLFW_PRESS) {
            down_ = false; // whatever became of the event
        }
        io.MouseDown[ImGuiMouseButton_Left] = down_;
    }

    static constexpr double double_click_s = 0.35;
    static constexpr float double_click_px = 6;
    std::array<ButtonEvent, 16> events_{}; // of the left button, that no frame has seen yet
    std::size_t waiting_ = 0;
    bool down_ = false; // the left button, in the last frame
    ImVec2 pointer_{}, clicked_at_{};
    double clicked_s_ = -double_click_s;

    std::unique_ptr<gl::Window> window_;
    std::array<int, 16> keys_{}, held_keys_{};
    std::size_t pressed_ = 0, held_ = 0; // since the last frame, and in it
    int mods_ = 0;
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
