#include "editor/scene/difference.h"

#include <epoxy/gl.h>

namespace fjell::editor {

namespace {

constexpr const char* vertex_text = R"(
void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0, 0.0, 1.0); }
)";

// Colours are compared as they are stored and seen, in sRGB: equal steps of light would hide the dark.
constexpr const char* fragment_text = R"(
layout(binding = 0) uniform sampler2D first;
layout(binding = 1) uniform sampler2D second;
layout(location = 0) uniform float gain;
layout(location = 0) out vec4 colour;
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 apart = abs(texelFetch(first, at, 0).rgb - texelFetch(second, at, 0).rgb);
    float much = clamp(gain * max(apart.r, max(apart.g, apart.b)), 0.0, 1.0) * 3.0;
    const vec3 steps[4] = vec3[](vec3(0.0), vec3(0.15, 0.3, 0.8), vec3(0.96, 0.84, 0.2), vec3(1.0));
    int i = min(int(much), 2);
    colour = vec4(mix(steps[i], steps[i + 1], much - float(i)), 1.0);
}
)";

} // namespace

std::string PictureDifference::make(std::uint32_t width, std::uint32_t height) {
    std::string error;
    if (program_.get() == 0) {
        program_ = gl::make_program({"difference", "", vertex_text, "", fragment_text}, error);
        if (!error.empty()) return error;
        unsigned name = 0;
        glCreateVertexArrays(1, &name);
        nothing_ = gl::VertexArray(name);
    }
    if (width == width_ && height == height_) return error;
    for (int i = 0; i < 2; ++i) {
        unsigned name = 0;
        glCreateTextures(GL_TEXTURE_2D, 1, &name);
        copies_[i] = gl::Texture(name);
        // Bytes as they are: no conversion on the way in or out.
        glTextureStorage2D(name, 1, GL_RGBA8, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
        unsigned frame = 0;
        glCreateFramebuffers(1, &frame);
        glNamedFramebufferTexture(frame, GL_COLOR_ATTACHMENT0, name, 0);
        frames_[i] = gl::Framebuffer(frame);
    }
    width_ = width;
    height_ = height;
    return error;
}

std::string PictureDifference::draw(const gl::Target& first, const gl::Target& second) {
    if (std::string error = make(first.width(), first.height()); !error.empty()) return error;
    const auto w = static_cast<GLint>(width_), h = static_cast<GLint>(height_);
    glDisable(GL_FRAMEBUFFER_SRGB);
    const unsigned from[] = {first.framebuffer(), second.framebuffer()};
    for (int i = 0; i < 2; ++i)
        glBlitNamedFramebuffer(from[i], frames_[i].get(), 0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, first.framebuffer());
    glViewport(0, 0, w, h);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glUseProgram(program_.get());
    glProgramUniform1f(program_.get(), 0, difference_gain);
    glBindVertexArray(nothing_.get());
    for (GLuint i = 0; i < 2; ++i) glBindTextureUnit(i, copies_[i].get());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    return {};
}

void PictureDifference::drop_graphics() {
    *this = {};
}

} // namespace fjell::editor
