// Where a picture is drawn: an offscreen framebuffer of sRGB colour and 32-bit float depth, of any size.
//
// Also used behind a window, whose own depth buffer is no float: draw into a Target, then present() it.
// Ownership: GL objects of the context that was current at creation; destroy while it is current. Thread: the
// context's. Depth is reversed: 1 at the near plane, falling to 0 at the far plane, and exactly 0 where nothing was
// drawn.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fjell/export.h"
#include "fjell/gl/image.h"
#include "fjell/view.h"

FJELL_API_BEGIN
namespace fjell::gl {

// How large a picture.
struct TargetOptions {
    std::uint32_t width = 1280, height = 720; // pixels, 1..the driver's limit (16384 as a rule)
    std::uint32_t samples = 1;                // a pixel; 4 smooths edges at about the cost of a second picture
};

// Samples a pixel that the current context's driver gives at most.
[[nodiscard]] std::uint32_t max_target_samples();

// A picture to draw into.
class Target {
public:
    // Throws io::Failure, 3, where the GPU has no room.
    [[nodiscard]] static std::unique_ptr<Target> create(const TargetOptions& options);
    ~Target();
    Target(const Target&) = delete;
    Target& operator=(const Target&) = delete;

    [[nodiscard]] std::uint32_t width() const;
    [[nodiscard]] std::uint32_t height() const;
    [[nodiscard]] unsigned framebuffer() const; // GL name to draw into

    // Waits for the picture. Top row first.
    void read_colour(Image& image) const;
    // The stored reversed depth, top row first, width * height; of the first sample when there are several.
    void read_depth(std::vector<float>& depth) const;
    // Copies the picture to the window's framebuffer, stretched to width x height.
    void present(std::uint32_t width, std::uint32_t height) const;

private:
    Target();
    struct Objects;
    std::unique_ptr<Objects> objects_;
};

// Stored depths to metres along the view's forward direction, in place; infinity where nothing was drawn.
void depth_to_metres(std::span<float> depth, const View& view);

} // namespace fjell::gl
FJELL_API_END
