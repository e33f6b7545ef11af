// Two pictures of one size as one: per pixel how far their colours are apart.
//
// Ownership: copies of both, made when first used and as large as the target. Thread: the context's. Failure: one line
// in the returned string.
#pragma once

#include <cstdint>
#include <string>

#include "fjell/gl/target.h"
#include "gl/objects.h"

namespace fjell::editor {

// From black, alike, over blue and yellow to white: eight times the difference of the channel that differs most, as
// shares of sRGB's 255.
inline constexpr float difference_gain = 8;

class PictureDifference {
public:
    // Into `first`, which loses its picture. Both have one sample a pixel and the same size.
    [[nodiscard]] std::string draw(const gl::Target& first, const gl::Target& second);
    void drop_graphics();

private:
    [[nodiscard]] std::string make(std::uint32_t width, std::uint32_t height);

    gl::Program program_;
    gl::VertexArray nothing_;
    gl::Texture copies_[2];
    gl::Framebuffer frames_[2];
    std::uint32_t width_ = 0, height_ = 0;
};

} // namespace fjell::editor
