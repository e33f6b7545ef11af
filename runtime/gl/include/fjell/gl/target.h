// A target for pictures: an offscreen framebuffer of sRGB colour and 32-bit float depth, of any size.
//
// It is used behind a window too, whose own depth buffer is not float: draw into a Target, then present() it.
// Ownership: GL objects of the context that was current at creation; destroy them while it is current. Thread: the
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

// The size of a target.
struct TargetOptions {
    // Pixels, 1 to the driver's limit, which is 16,384 as a rule.
    std::uint32_t width = 1280, height = 720;
    // Samples a pixel. 4 smooth edges at about the cost of a second picture.
    std::uint32_t samples = 1;
};

// The most samples a pixel that the driver of the current context allows.
[[nodiscard]] std::uint32_t max_target_samples();

// A picture to draw into.
class Target {
public:
    // Throws io::Failure, 3, if the GPU has no room.
    [[nodiscard]] static std::unique_ptr<Target> create(const TargetOptions& options);
    ~Target();
    Target(const Target&) = delete;
    Target& operator=(const Target&) = delete;

    [[nodiscard]] std::uint32_t width() const;
    [[nodiscard]] std::uint32_t height() const;
    [[nodiscard]] unsigned framebuffer() const; // GL name of the framebuffer to draw into

    // Reads the picture, top row first. Waits until it is drawn.
    void read_colour(Image& image) const;
    // Reads the stored reversed depth, width * height values, top row first. With several samples a pixel it is that of
    // the first.
    void read_depth(std::vector<float>& depth) const;
    // Copies the picture to the window's framebuffer, stretched to width x height.
    void present(std::uint32_t width, std::uint32_t height) const;

private:
    Target();
    struct Objects;
    std::unique_ptr<Objects> objects_;
};

// Converts stored depths to metres along the view's forward direction, in place. Infinity where nothing was drawn.
void depth_to_metres(std::span<float> depth, const View& view);

} // namespace fjell::gl
FJELL_API_END
