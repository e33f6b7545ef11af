#include "gl/ring.h"

#include <algorithm>
#include <utility>

#include <epoxy/gl.h>

namespace fjell::gl {

std::string Ring::create(std::size_t region_bytes) {
    int uniform = 0, storage = 0;
    glGetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &uniform);
    glGetIntegerv(GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT, &storage);
    alignment_ = static_cast<std::size_t>(std::max({64, uniform, storage})); // all powers of two
    region_bytes_ = aligned(region_bytes);
    unsigned name = 0;
    glCreateBuffers(1, &name);
    buffer_ = Buffer(name);
    constexpr GLbitfield how = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    const auto bytes = static_cast<GLsizeiptr>(regions * region_bytes_);
    glNamedBufferStorage(name, bytes, nullptr, how);
    mapped_ = static_cast<std::byte*>(glMapNamedBufferRange(name, 0, bytes, how));
    if (mapped_ != nullptr) return {};
    return "the driver cannot map " + std::to_string(regions * region_bytes_) +
           " bytes for uploads: lower RendererOptions::ring_bytes or ::ranges";
}

Ring::~Ring() {
    for (void* fence : fences_)
        if (fence != nullptr) glDeleteSync(static_cast<GLsync>(fence));
}

RingSlice Ring::take(std::size_t bytes) {
    const std::size_t offset = region_ * region_bytes_ + used_;
    used_ = std::min(used_ + aligned(bytes), region_bytes_);
    return {mapped_ + offset, offset};
}

void Ring::next() {
    if (used_ == 0) return;
    fences_[region_] = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    region_ = (region_ + 1) % regions;
    used_ = 0;
    const auto fence = static_cast<GLsync>(std::exchange(fences_[region_], nullptr));
    if (fence == nullptr) return;
    GLenum state = glClientWaitSync(fence, 0, 0);
    if (state == GL_TIMEOUT_EXPIRED) ++waits_;
    while (state == GL_TIMEOUT_EXPIRED) state = glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, 1'000'000'000);
    glDeleteSync(fence);
}

} // namespace fjell::gl
