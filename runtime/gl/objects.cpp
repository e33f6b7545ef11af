#include "gl/objects.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <epoxy/gl.h>

#include "gl/fail.h"

namespace fjell::gl {

void delete_buffer(unsigned name) {
    glDeleteBuffers(1, &name);
}
void delete_texture(unsigned name) {
    glDeleteTextures(1, &name);
}
void delete_vertex_array(unsigned name) {
    glDeleteVertexArrays(1, &name);
}
void delete_framebuffer(unsigned name) {
    glDeleteFramebuffers(1, &name);
}
void delete_renderbuffer(unsigned name) {
    glDeleteRenderbuffers(1, &name);
}
void delete_program(unsigned name) {
    glDeleteProgram(name);
}

namespace {

thread_local std::uint64_t made = 0;

// Attaches one compiled stage; false with the log on failure.
bool attach(unsigned program, GLenum stage, const std::string& defines, const std::string& text, std::string& log) {
    const std::string whole = "#version 450 core\n" + defines + text;
    const char* pointer = whole.c_str();
    const unsigned shader = glCreateShader(stage);
    glShaderSource(shader, 1, &pointer, nullptr);
    glCompileShader(shader);
    int compiled = 0, length = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (!compiled) {
        glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
        std::vector<char> buffer(static_cast<std::size_t>(length) + 1);
        glGetShaderInfoLog(shader, length, nullptr, buffer.data());
        log = buffer.data();
    } else {
        glAttachShader(program, shader);
    }
    glDeleteShader(shader); // lives on while attached
    return compiled != 0;
}

// `good`: all stages were attached.
Program link(Program program, bool good, const char* name, std::string log) {
    if (good) {
        int linked = 0, length = 0;
        ++made;
        glLinkProgram(program.get());
        glGetProgramiv(program.get(), GL_LINK_STATUS, &linked);
        if (linked) return program;
        glGetProgramiv(program.get(), GL_INFO_LOG_LENGTH, &length);
        std::vector<char> buffer(static_cast<std::size_t>(length) + 1);
        glGetProgramInfoLog(program.get(), length, nullptr, buffer.data());
        log = buffer.data();
    }
    fail(std::string("the driver rejects shader '") + name + "': " + log);
}

} // namespace

std::uint64_t programs_made() {
    return made;
}

Program make_program(const ProgramSource& source) {
    Program program(glCreateProgram());
    std::string log;
    bool good = attach(program.get(), GL_VERTEX_SHADER, source.defines, source.vertex, log) &&
                attach(program.get(), GL_FRAGMENT_SHADER, source.defines, source.fragment, log);
    if (good && !source.geometry.empty())
        good = attach(program.get(), GL_GEOMETRY_SHADER, source.defines, source.geometry, log);
    return link(std::move(program), good, source.name, std::move(log));
}

Program make_compute_program(const char* name, const std::string& source) {
    Program program(glCreateProgram());
    std::string log;
    const bool good = attach(program.get(), GL_COMPUTE_SHADER, {}, source, log);
    return link(std::move(program), good, name, std::move(log));
}

void Ring::create(std::size_t region_bytes, const char* lower) {
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
    if (mapped_ != nullptr) return;
    fail("the driver cannot map " + std::to_string(regions * region_bytes_) + " bytes for uploads: lower " + lower);
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
