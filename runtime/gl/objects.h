// Owners of GL names, and programs from source.
//
// Internal to runtime/gl. Thread and lifetime: the context that made an object must be current when it is destroyed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

namespace fjell::gl {

void delete_buffer(unsigned name);
void delete_texture(unsigned name);
void delete_vertex_array(unsigned name);
void delete_framebuffer(unsigned name);
void delete_renderbuffer(unsigned name);
void delete_program(unsigned name);

// Move-only; 0 is none.
template <void (*Delete)(unsigned)>
class Object {
public:
    Object() = default;
    explicit Object(unsigned name) : name_(name) {}
    Object(Object&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    Object& operator=(Object&& other) noexcept {
        std::swap(name_, other.name_);
        return *this;
    }
    ~Object() {
        if (name_ != 0) Delete(name_);
    }
    [[nodiscard]] unsigned get() const { return name_; }

private:
    unsigned name_ = 0;
};

using Buffer = Object<delete_buffer>;
using Texture = Object<delete_texture>;
using VertexArray = Object<delete_vertex_array>;
using Framebuffer = Object<delete_framebuffer>;
using Renderbuffer = Object<delete_renderbuffer>;
using Program = Object<delete_program>;

// Sources without a #version line; `geometry` may be empty. `defines` is put in front of each.
struct ProgramSource {
    const char* name;
    std::string defines, vertex, geometry, fragment;
};
// Throws with the compiler's or linker's log.
[[nodiscard]] Program make_program(const ProgramSource& source);
// How many this thread has made so far.
[[nodiscard]] std::uint64_t programs_made();
[[nodiscard]] Program make_compute_program(const char* name, const std::string& source);

// Where the CPU writes what the GPU reads: one buffer, mapped once and for good, in three regions.
//
// The CPU fills one region while the GPU reads the others. A region is left with a fence behind the last command that
// reads it, and entered again when that fence has passed: asked without waiting, and waited for only when the GPU is
// three regions behind. Internal to runtime/gl. Thread: the context's. Failure: create() throws.
struct RingSlice {
    std::byte* data = nullptr; // write in order, never read: the memory may be write-combined
    std::size_t offset = 0;    // in the buffer, aligned for any binding
};

class Ring {
public:
    static constexpr unsigned regions = 3;

    Ring() = default;
    ~Ring();
    Ring(const Ring&) = delete;
    Ring& operator=(const Ring&) = delete;

    // lower: what the host has to lower where there is no room.
    void create(std::size_t region_bytes, const char* lower);
    // What n bytes take up.
    [[nodiscard]] std::size_t aligned(std::size_t bytes) const {
        return (bytes + alignment_ - 1) / alignment_ * alignment_;
    }
    // Bytes that can still be taken from this region in one go.
    [[nodiscard]] std::size_t room() const { return region_bytes_ - used_; }
    [[nodiscard]] std::size_t region_bytes() const { return region_bytes_; }
    // bytes <= room().
    [[nodiscard]] RingSlice take(std::size_t bytes);
    // Leaves the region: all commands that read from it must have been given.
    void next();
    // Moves on unless that much is left. bytes <= region_bytes(), the sum of aligned() sizes.
    void reserve(std::size_t bytes) {
        if (bytes > room()) next();
    }
    [[nodiscard]] unsigned buffer() const { return buffer_.get(); }
    // How often the CPU had to wait for the GPU, so far.
    [[nodiscard]] std::uint64_t waits() const { return waits_; }

private:
    Buffer buffer_;
    std::byte* mapped_ = nullptr;
    std::size_t region_bytes_ = 0, alignment_ = 256, used_ = 0;
    unsigned region_ = 0;
    void* fences_[regions] = {}; // GLsync
    std::uint64_t waits_ = 0;
};

} // namespace fjell::gl
