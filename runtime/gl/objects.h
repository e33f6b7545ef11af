// Owners of GL names, and programs from source.
//
// Internal to runtime/gl. Thread and lifetime: the context that made an object must be current when it is destroyed.
#pragma once

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
// Empty error on success; otherwise the compiler's or linker's log in one string.
[[nodiscard]] Program make_program(const ProgramSource& source, std::string& error);
// How many this thread has made so far.
[[nodiscard]] std::uint64_t programs_made();
[[nodiscard]] Program make_compute_program(const char* name, const std::string& source, std::string& error);

} // namespace fjell::gl
