#include "bench/gpu_times.h"

#include <string>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "fjell/gl/target.h"
#include "gl/objects.h"
#include "support/times.h"

namespace fjell::bench {

GpuTimer::GpuTimer() {
    glCreateQueries(GL_TIME_ELAPSED, 1, &query_);
}
GpuTimer::~GpuTimer() {
    glDeleteQueries(1, &query_);
}
void GpuTimer::begin() const {
    glBeginQuery(GL_TIME_ELAPSED, query_);
}
void GpuTimer::end() const {
    glEndQuery(GL_TIME_ELAPSED);
}
double GpuTimer::us() const {
    std::uint64_t ns = 0;
    glGetQueryObjectui64v(query_, GL_QUERY_RESULT, &ns);
    return static_cast<double>(ns) * 1e-3;
}

bool in_software() {
    const auto* const name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    const std::string renderer = name ? name : "";
    for (const char* const software : {"llvmpipe", "softpipe", "SwiftShader", "swrast"})
        if (renderer.find(software) != std::string::npos) return true;
    return false;
}

bool timers_are_real() {
    int bits = 0;
    glGetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &bits);
    if (bits == 0 || in_software()) return false;
    const auto target = gl::Target::create({1024, 1024, 1});
    const gl::Program program = gl::make_program(
        {"a known load", "",
         "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0.5, 1); }", "",
         "out vec4 colour; void main() { float x = gl_FragCoord.x; for (int i = 0; i < 200; ++i) x = sin(x) + 1.0;\n"
         "colour = vec4(x); }"});
    unsigned none = 0;
    glCreateVertexArrays(1, &none);
    const gl::VertexArray array(none);
    glBindFramebuffer(GL_FRAMEBUFFER, target->framebuffer());
    glViewport(0, 0, 1024, 1024);
    glDisable(GL_DEPTH_TEST);
    glUseProgram(program.get());
    glBindVertexArray(array.get());
    const GpuTimer timer;
    double waited_us = 0;
    const auto load = [&](int times) {
        glFinish();
        const auto start = test::Clock::now();
        timer.begin();
        for (int i = 0; i < times; ++i) glDrawArrays(GL_TRIANGLES, 0, 3);
        timer.end();
        glFinish();
        waited_us = test::us_since(start);
        return timer.us();
    };
    (void)load(8);
    const double once = load(8), fourfold = load(32);
    return once > 0 && fourfold < 1.02 * waited_us && fourfold > 2.5 * once && fourfold < 6 * once;
}

namespace {

Calls made;

// libepoxy's functions are pointers: ours count, and call what the driver has.
PFNGLDRAWARRAYSPROC draw_arrays;
PFNGLDRAWELEMENTSINSTANCEDPROC draw_instanced;
PFNGLMULTIDRAWELEMENTSINDIRECTPROC multi_draw;
PFNGLDISPATCHCOMPUTEPROC dispatch;

void count(std::uint32_t draws, std::uint32_t dispatches = 0) {
    ++made.calls;
    made.draws += draws;
    made.dispatches += dispatches;
}
void count_draw_arrays(GLenum mode, GLint first, GLsizei vertices) {
    count(1);
    draw_arrays(mode, first, vertices);
}
void count_draw_instanced(GLenum mode, GLsizei indices, GLenum type, const void* at, GLsizei instances) {
    count(1);
    draw_instanced(mode, indices, type, at, instances);
}
void count_multi_draw(GLenum mode, GLenum type, const void* at, GLsizei draws, GLsizei stride) {
    count(static_cast<std::uint32_t>(draws));
    multi_draw(mode, type, at, draws, stride);
}
void count_dispatch(GLuint x, GLuint y, GLuint z) {
    count(0, 1);
    dispatch(x, y, z);
}

template <typename Function>
void put(Function& pointer, Function& kept, Function counting, const char* name) {
    kept = reinterpret_cast<Function>(eglGetProcAddress(name));
    if (kept) pointer = counting;
}

} // namespace

void count_calls() {
    put(epoxy_glDrawArrays, draw_arrays, &count_draw_arrays, "glDrawArrays");
    put(epoxy_glDrawElementsInstanced, draw_instanced, &count_draw_instanced, "glDrawElementsInstanced");
    put(epoxy_glMultiDrawElementsIndirect, multi_draw, &count_multi_draw, "glMultiDrawElementsIndirect");
    put(epoxy_glDispatchCompute, dispatch, &count_dispatch, "glDispatchCompute");
    made = {};
}

Calls take_calls() {
    const Calls taken = made;
    made = {};
    return taken;
}

} // namespace fjell::bench
