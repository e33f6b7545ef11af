#include "fly/window.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

#include <fmt/format.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "fjell/io/failure.h"
#include "fjell/measure.h"
#include "gl/window.h"
#include "session/camera.h"
#include "session/pictures.h"

namespace fjell::session {

namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* help =
    "W S A D   forward, back, left, right      Q E   down, up\n"
    "arrows, or drag with the left button      look around\n"
    "wheel     speed                            [ ]   threshold\n"
    "P         along the path, on and off       M     next picture: shaded, wireframe, levels,\n"
    "                                                 tiles, mips, residency, distance\n"
    "F1        keys in the title, and this list  Esc   quit\n";
constexpr const char* keys_in_title =
    "Fjell - W A S D Q E: fly - drag: look - wheel: speed - [ ]: threshold - M: picture - "
    "P: path - Esc: quit - F1: figures";
constexpr double radians_a_pixel = 0.003;
constexpr double title_seconds = 0.25;

// What happened since the last frame; filled by GLFW's callbacks.
struct Input {
    int mode_steps = 0, threshold_steps = 0;
    double wheel = 0, drag_x = 0, drag_y = 0, mouse_x = 0, mouse_y = 0;
    bool toggle_path = false, dragging = false, keys_shown = false;
};

Input& input_of(GLFWwindow* window) {
    return *static_cast<Input*>(glfwGetWindowUserPointer(window));
}

void on_key(GLFWwindow* window, int key, int, int action, int) {
    Input& input = input_of(window);
    if (action == GLFW_RELEASE) return;
    if (key == GLFW_KEY_LEFT_BRACKET) --input.threshold_steps;
    if (key == GLFW_KEY_RIGHT_BRACKET) ++input.threshold_steps;
    if (action != GLFW_PRESS) return; // what follows does not repeat
    if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(window, GLFW_TRUE);
    if (key == GLFW_KEY_M) ++input.mode_steps;
    if (key == GLFW_KEY_P) input.toggle_path = !input.toggle_path;
    if (key == GLFW_KEY_F1) {
        input.keys_shown = !input.keys_shown;
        if (input.keys_shown) fmt::print(stderr, "{}", help); // standard output may be taken by --json -
    }
}

void on_button(GLFWwindow* window, int button, int action, int) {
    if (button != GLFW_MOUSE_BUTTON_LEFT) return;
    Input& input = input_of(window);
    input.dragging = action == GLFW_PRESS;
    glfwGetCursorPos(window, &input.mouse_x, &input.mouse_y);
}

void on_move(GLFWwindow* window, double x, double y) {
    Input& input = input_of(window);
    if (input.dragging) {
        input.drag_x += x - input.mouse_x;
        input.drag_y += y - input.mouse_y;
    }
    input.mouse_x = x;
    input.mouse_y = y;
}

Steering steering_of(GLFWwindow* window) {
    const auto axis = [&](int plus, int minus) {
        return (glfwGetKey(window, plus) == GLFW_PRESS ? 1.0 : 0.0) -
               (glfwGetKey(window, minus) == GLFW_PRESS ? 1.0 : 0.0);
    };
    return {axis(GLFW_KEY_W, GLFW_KEY_S), axis(GLFW_KEY_D, GLFW_KEY_A), axis(GLFW_KEY_E, GLFW_KEY_Q),
            axis(GLFW_KEY_RIGHT, GLFW_KEY_LEFT), axis(GLFW_KEY_UP, GLFW_KEY_DOWN)};
}

// The path, and where on it we are: one pose a drawn frame when their number was given, else by the clock.
struct Playback {
    std::span<const Pose> poses;
    double hz = 60, at = 0;
    bool by_clock = true, on = false;

    const Pose& step(double seconds, std::size_t frame) {
        if (!by_clock) return poses[frame % poses.size()];
        at = std::fmod(at + seconds * hz, static_cast<double>(poses.size()));
        return poses[std::min(static_cast<std::size_t>(at), poses.size() - 1)];
    }
};

class Flight {
public:
    Flight(const FlightOptions& options, Session& session, std::span<const Pose> poses)
        : options_(options), session_(session), profile_(options.profile), mode_(options.mode),
          ground_(session.live_ground()),
          camera_(free_camera(poses.front(), ground_.longer_m() / 60)), playback_{poses, options.hz, 0,
                                                                                  options.frames == 0,
                                                                                  options.frames > 0 ||
                                                                                      !options.path.empty() ||
                                                                                      options.seeded} {
        window_ = gl::Window::create({profile_.width_px, profile_.height_px, "Fjell"});
        renderer_ = make_renderer(options, session);
        GLFWwindow* window = window_->handle();
        glfwSetWindowUserPointer(window, &input_);
        glfwSetKeyCallback(window, on_key);
        glfwSetMouseButtonCallback(window, on_button);
        glfwSetCursorPosCallback(window, on_move);
        glfwSetScrollCallback(window, [](GLFWwindow* w, double, double y) { input_of(w).wheel += y; });
    }

    void run(FlightLog& log, Verification& verification) {
        auto last = Clock::now();
        while (!window_->should_close() && (options_.frames == 0 || log.frames.size() < options_.frames)) {
            io::check_interrupt();
            window_->poll();
            const auto now = Clock::now();
            const double seconds = std::min(std::chrono::duration<double>(now - last).count(), 0.25);
            last = now;
            take_input();
            if (!fit_target()) { // minimised
                glfwWaitEventsTimeout(0.1);
                continue;
            }
            const Pose pose = move(seconds, log.frames.size());
            log.frames.push_back(show(pose, log.frames.size(), verification));
            title(log.frames.back(), seconds);
        }
    }

private:
    void take_input() {
        const Input input = std::exchange(input_, Input{.mouse_x = input_.mouse_x,
                                                        .mouse_y = input_.mouse_y,
                                                        .dragging = input_.dragging,
                                                        .keys_shown = input_.keys_shown});
        mode_ = static_cast<PictureMode>((static_cast<int>(mode_) + input.mode_steps) % picture_modes);
        profile_.refine.max_error_px = std::clamp(profile_.refine.max_error_px * std::pow(1.25, input.threshold_steps),
                                                  ranges::least_threshold_px, ranges::most_threshold_px);
        camera_.speed_m_s = std::clamp(camera_.speed_m_s * std::pow(1.25, input.wheel), 0.01, 1e6);
        look(camera_, input.drag_x * radians_a_pixel, -input.drag_y * radians_a_pixel);
        if (input.toggle_path) playback_.on = !playback_.on;
    }

    // The camera in the hand follows the path while that plays, so that letting go of it does not jump.
    Pose move(double seconds, std::size_t frame) {
        if (playback_.on) {
            const Pose& pose = playback_.step(seconds, frame);
            camera_ = free_camera(pose, camera_.speed_m_s);
            return pose;
        }
        const double above_m = 0.5 * ground_.cell_m; // ten times the near plane's distance
        steer(camera_, steering_of(window_->handle()), seconds, ground_, above_m);
        return camera_.pose();
    }

    bool fit_target() {
        std::uint32_t width = 0, height = 0;
        window_->framebuffer_size(width, height);
        if (width == 0 || height == 0) return false;
        if (target_ && target_->width() == width && target_->height() == height) return true;
        target_.reset(); // the old one's memory first
        target_ = make_target(width, height, profile_);
        profile_.width_px = width;
        profile_.height_px = height;
        return true;
    }

    FrameEntry show(const Pose& pose, std::size_t frame, Verification& verification) {
        const View view = view_of(pose, session_.terrain(), profile_);
        const double now_s = std::chrono::duration<double>(Clock::now() - start_).count();
        begin_frame(session_, frame);
        FrameEntry entry = update_frame(session_, view, profile_, now_s);
        if (options_.verify_every && frame % options_.verify_every == 0)
            verify_frame(session_, view, profile_, frame, entry, verification);
        upload_mesh(*renderer_, session_, entry);
        renderer_->draw_uploaded(session_.mesh(), view, draw_options(mode_, profile_, now_s), *target_);
        target_->present(target_->width(), target_->height());
        window_->swap();
        return entry;
    }

    // What streaming is at: done, up against a capacity, or reading.
    static std::string streaming(const FrameEntry& entry) {
        if (!entry.streamed) return "";
        const StreamReport& r = entry.stream;
        const std::uint32_t full = entry.exhausted & (exhausted_page_slots | exhausted_map_bytes);
        const std::string state = r.converged && r.maps_converged ? "all there"
                                  : full ? fmt::format("{} full", fmt::join(budget_names(full), " and "))
                                         : "reading";
        return fmt::format(" - {}: {} of {} page slots, {:.1f} MB read{}", state, r.page_slots.used,
                           r.page_slots.capacity, static_cast<double>(r.bytes_read) / 1e6,
                           r.failed ? fmt::format(", {} damaged", r.failed) : "");
    }

    void title(const FrameEntry& entry, double seconds) {
        shown_seconds_ += seconds;
        ++shown_frames_;
        if (shown_seconds_ < title_seconds) return;
        if (input_.keys_shown) {
            glfwSetWindowTitle(window_->handle(), keys_in_title);
            shown_seconds_ = 0;
            shown_frames_ = 0;
            return;
        }
        const bool wanting = (entry.exhausted & (session::exhausted_vertices | session::exhausted_indices |
                                                 session::exhausted_triangles)) != 0;
        const bool missing = entry.missing_px > entry.error_px_requested;
        const std::string text = fmt::format(
            "Fjell - update {:.0f} us - {} vertices - {} triangles drawn - {:.0f} fps - {}{}{}", entry.update_us,
            entry.vertices, entry.triangles_drawn, shown_frames_ / shown_seconds_,
            entry.error_bound_px < unbounded_px ? fmt::format("{:.3g} px", entry.error_bound_px) : "unbounded error",
            entry.converged ? ""
            : wanting       ? " (budget exhausted)"
            : missing       ? " (pages missing)"
                            : " (lags)",
            streaming(entry));
        glfwSetWindowTitle(window_->handle(), text.c_str());
        shown_seconds_ = 0;
        shown_frames_ = 0;
    }

    const FlightOptions& options_;
    Session& session_;
    Profile profile_; // with the window's size and the keys' threshold
    PictureMode mode_;
    Ground ground_;
    FreeCamera camera_;
    Playback playback_;
    Input input_;
    Clock::time_point start_ = Clock::now();
    double shown_seconds_ = 0;
    int shown_frames_ = 0;
    // Destroyed from last to first: GL objects need their context.
    std::unique_ptr<gl::Window> window_;
    std::unique_ptr<gl::Renderer> renderer_;
    std::unique_ptr<gl::Target> target_;
};

} // namespace

void fly_in_window(const FlightOptions& options, Session& session, std::span<const Pose> poses, FlightLog& log,
                   Verification& verification) {
    Flight flight(options, session, poses);
    std::fputs("F1 in the window prints the keys; Esc quits\n", stderr);
    flight.run(log, verification);
}

} // namespace fjell::session
