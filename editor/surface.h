// Where the editor shows itself: a window, or a headless picture of any size for scripts and tests.
//
// Both hold a current OpenGL context and Dear ImGui's back ends for it. Ownership: the surface's; GL objects of others
// must be gone before it. Thread: the frame's. Failure: create functions return null with one line in error.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fjell/gl/image.h"
#include "fjell/gl/target.h"

namespace fjell::editor {

// All zero without a window. Counted in the frame whose panels see the event.
struct InputCounts {
    std::uint64_t keys = 0;       // pressed and released; no repeats
    std::uint64_t characters = 0; // typed
    std::uint64_t buttons = 0;    // of the mouse, pressed and released
    std::uint64_t scrolls = 0;    // of the wheel
    double pointer_px[2] = {};    // as this frame's panels see it; far outside while there is none
    bool focused = false;         // keys go to this window
};

} // namespace fjell::editor

namespace fjell::gl {
class SecondContext; // gl/window.h
}

namespace fjell::editor {

class Surface {
public:
    virtual ~Surface() = default;
    Surface() = default;
    Surface(const Surface&) = delete;
    Surface& operator=(const Surface&) = delete;

    virtual void begin_frame() = 0; // input, and ImGui's display size and time
    // Until something happens to the window, at most that long; false: nothing did.
    virtual bool wait(double most_s) = 0;
    // 0 x 0 while minimised.
    virtual void size(std::uint32_t& width, std::uint32_t& height) const = 0;
    [[nodiscard]] virtual unsigned framebuffer() const = 0;
    void draw_interface(); // ImGui's draw data, into the bound framebuffer
    void fonts_changed();  // the atlas was recreated
    virtual void present() = 0;
    // For a thread that prepares what frames will draw; null: there is none, and frames prepare it.
    [[nodiscard]] virtual gl::SecondContext* second_context() { return nullptr; }
    [[nodiscard]] virtual bool should_close() const = 0;
    virtual void stay_open() = 0; // after should_close(): the user is asked first
    virtual void set_title(const char* title) = 0;
    virtual void resize(std::uint32_t width, std::uint32_t height) = 0;
    [[nodiscard]] virtual bool lost() const = 0; // the driver has reset: nothing on the GPU is left
    [[nodiscard]] virtual std::string description() const = 0;
    [[nodiscard]] virtual double content_scale() const = 0; // what the desktop asks for
    void read(gl::Image& image) const;                      // what is drawn so far

    std::vector<std::string> dropped; // files, since they were last taken
    InputCounts input;                // so far
};

struct SurfaceOptions {
    bool headless = false;
    std::uint32_t width = 1280, height = 720;
    bool vsync = true;
};
[[nodiscard]] std::unique_ptr<Surface> make_surface(const SurfaceOptions& options);

// Copies a target's picture to that place of a framebuffer, y from the top, stretched where it is smaller.
struct Place {
    std::uint32_t x = 0, y = 0, width = 0, height = 0;
};
void blit(const gl::Target& target, unsigned framebuffer, std::uint32_t framebuffer_height, const Place& to);
// Has the driver compile what both kinds of that take, before there is a frame that it could hold up.
void rehearse_blit(const Surface& surface);

// --- How long the GPU takes for a frame, by timestamps that it notes itself; known some frames later.
//
// Software renderers return nonsense: whoever draws by one leaves it off. Ownership: its queries. Thread: the
// context's. Memory: none after the first frame. Nothing here waits for the GPU.

class GpuTimer {
public:
    void begin(); // of a frame; nothing where all queries are still under way
    void end();
    // Of the newest frame whose result has come since the last call, microseconds; below 0: none has.
    [[nodiscard]] double take_us();
    void drop_graphics(); // before the context goes

private:
    static constexpr std::size_t frames = 4; // the GPU is up to three behind
    struct Pair {
        unsigned names[2] = {};
        bool waits = false;
    };
    std::array<Pair, frames> pairs_{};
    std::size_t next_ = 0, oldest_ = 0;
    bool begun_ = false;
};

} // namespace fjell::editor
