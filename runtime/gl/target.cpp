#include "fjell/gl/target.h"

#include <cmath>
#include <cstring>
#include <limits>

#include <epoxy/gl.h>

#include "gl/fail.h"
#include "gl/objects.h"

namespace fjell::gl {

struct Target::Objects {
    TargetOptions options;
    Renderbuffer colour, depth;
    Framebuffer draw;
    // Single-sampled copies to read from; unused (name 0) when there is one sample a pixel anyway.
    Renderbuffer resolved_colour, resolved_depth;
    Framebuffer resolved;
};

namespace {

void check_size(const TargetOptions& options) {
    int largest = 0;
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
    const std::uint32_t samples = max_target_samples();
    const auto limit = static_cast<std::uint32_t>(largest);
    if (options.width < 1 || options.height < 1 || options.width > limit || options.height > limit)
        fail("a picture of " + std::to_string(options.width) + "x" + std::to_string(options.height) +
             " pixels is not possible here: each side must be 1 to " + std::to_string(limit));
    if (options.samples < 1 || options.samples > samples)
        fail(std::to_string(options.samples) + " samples a pixel are not possible here: 1 to " +
             std::to_string(samples));
}

Renderbuffer make_renderbuffer(const TargetOptions& options, GLenum format, std::uint32_t samples) {
    unsigned name = 0;
    glCreateRenderbuffers(1, &name);
    glNamedRenderbufferStorageMultisample(name, samples > 1 ? static_cast<GLsizei>(samples) : 0, format,
                                          static_cast<GLsizei>(options.width), static_cast<GLsizei>(options.height));
    return Renderbuffer(name);
}

Framebuffer make_framebuffer(const Renderbuffer& colour, const Renderbuffer& depth) {
    unsigned name = 0;
    glCreateFramebuffers(1, &name);
    glNamedFramebufferRenderbuffer(name, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour.get());
    glNamedFramebufferRenderbuffer(name, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth.get());
    return Framebuffer(name);
}

// GL's rows start at the bottom, ours at the top.
void flip_rows(void* pixels, std::size_t row_bytes, std::size_t rows) {
    auto* first = static_cast<std::uint8_t*>(pixels);
    std::vector<std::uint8_t> swap(row_bytes);
    for (std::size_t i = 0; i < rows / 2; ++i) {
        std::uint8_t *a = first + i * row_bytes, *b = first + (rows - 1 - i) * row_bytes;
        std::memcpy(swap.data(), a, row_bytes);
        std::memcpy(a, b, row_bytes);
        std::memcpy(b, swap.data(), row_bytes);
    }
}

} // namespace

std::uint32_t max_target_samples() {
    int samples = 1;
    glGetIntegerv(GL_MAX_SAMPLES, &samples);
    return static_cast<std::uint32_t>(samples);
}

Target::Target() : objects_(std::make_unique<Objects>()) {}
Target::~Target() = default;

std::unique_ptr<Target> Target::create(const TargetOptions& options) {
    check_size(options);
    std::unique_ptr<Target> result(new Target);
    Objects& o = *result->objects_;
    o.options = options;
    o.colour = make_renderbuffer(options, GL_SRGB8_ALPHA8, options.samples);
    o.depth = make_renderbuffer(options, GL_DEPTH_COMPONENT32F, options.samples);
    o.draw = make_framebuffer(o.colour, o.depth);
    bool complete = glCheckNamedFramebufferStatus(o.draw.get(), GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    if (options.samples > 1) {
        o.resolved_colour = make_renderbuffer(options, GL_SRGB8_ALPHA8, 1);
        o.resolved_depth = make_renderbuffer(options, GL_DEPTH_COMPONENT32F, 1);
        o.resolved = make_framebuffer(o.resolved_colour, o.resolved_depth);
        complete =
            complete && glCheckNamedFramebufferStatus(o.resolved.get(), GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    }
    if (complete && glGetError() != GL_OUT_OF_MEMORY) return result;
    fail("the driver cannot give a picture of " + std::to_string(options.width) + "x" + std::to_string(options.height) +
         " pixels; ask for a smaller one");
}

std::uint32_t Target::width() const {
    return objects_->options.width;
}
std::uint32_t Target::height() const {
    return objects_->options.height;
}
unsigned Target::framebuffer() const {
    return objects_->draw.get();
}

namespace {

// Colour is averaged in linear light when sRGB conversion is on; depth takes one of the samples.
void resolve(unsigned from, unsigned to, const TargetOptions& options, GLbitfield what) {
    const auto w = static_cast<GLint>(options.width), h = static_cast<GLint>(options.height);
    glEnable(GL_FRAMEBUFFER_SRGB);
    glBlitNamedFramebuffer(from, to, 0, 0, w, h, 0, 0, w, h, what, GL_NEAREST);
}

// Mesa 22.3 in software reads a framebuffer that its threads are still drawing, where another one was bound meanwhile.
void finish_before_reading() {
    glFinish();
}

} // namespace

void Target::read_colour(Image& image) const {
    const Objects& o = *objects_;
    if (o.options.samples > 1) resolve(o.draw.get(), o.resolved.get(), o.options, GL_COLOR_BUFFER_BIT);
    image.width = o.options.width;
    image.height = o.options.height;
    image.rgb.resize(std::size_t{3} * image.width * image.height);
    finish_before_reading();
    glDisable(GL_FRAMEBUFFER_SRGB); // the stored bytes, as they are
    glBindFramebuffer(GL_READ_FRAMEBUFFER, o.options.samples > 1 ? o.resolved.get() : o.draw.get());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, static_cast<GLsizei>(image.width), static_cast<GLsizei>(image.height), GL_RGB, GL_UNSIGNED_BYTE,
                 image.rgb.data());
    flip_rows(image.rgb.data(), std::size_t{3} * image.width, image.height);
}

void Target::read_depth(std::vector<float>& depth) const {
    const Objects& o = *objects_;
    if (o.options.samples > 1) resolve(o.draw.get(), o.resolved.get(), o.options, GL_DEPTH_BUFFER_BIT);
    depth.resize(std::size_t{o.options.width} * o.options.height);
    finish_before_reading();
    glBindFramebuffer(GL_READ_FRAMEBUFFER, o.options.samples > 1 ? o.resolved.get() : o.draw.get());
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, static_cast<GLsizei>(o.options.width), static_cast<GLsizei>(o.options.height),
                 GL_DEPTH_COMPONENT, GL_FLOAT, depth.data());
    flip_rows(depth.data(), sizeof(float) * o.options.width, o.options.height);
}

void Target::present(std::uint32_t width, std::uint32_t height) const {
    const Objects& o = *objects_;
    unsigned from = o.draw.get();
    if (o.options.samples > 1) { // a multisampled source may not be stretched
        resolve(from, o.resolved.get(), o.options, GL_COLOR_BUFFER_BIT);
        from = o.resolved.get();
    }
    // A raw copy: the window's buffer takes sRGB bytes whether or not it says so.
    glDisable(GL_FRAMEBUFFER_SRGB);
    const bool same = width == o.options.width && height == o.options.height;
    glBlitNamedFramebuffer(from, 0, 0, 0, static_cast<GLint>(o.options.width), static_cast<GLint>(o.options.height), 0,
                           0, static_cast<GLint>(width), static_cast<GLint>(height), GL_COLOR_BUFFER_BIT,
                           same ? GL_NEAREST : GL_LINEAR);
}

void depth_to_metres(std::span<float> depth, const View& view) {
    // stored = near (far - d) / (d (far - near)), hence d = near far / (near + stored (far - near)).
    const double product = view.near_m * view.far_m, range = view.far_m - view.near_m;
    for (float& value : depth)
        value = value <= 0 ? std::numeric_limits<float>::infinity()
                           : static_cast<float>(product / (view.near_m + static_cast<double>(value) * range));
}

} // namespace fjell::gl
