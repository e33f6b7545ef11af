#include "editor/comparison.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <epoxy/gl.h>

#include "fjell/io/failure.h"
#include "fjell/profile/keys.h"
#include "session/pictures.h"

namespace fjell::editor {

namespace {

constexpr std::uint32_t most_halving_steps = 24;

bool needs_reopening(const Profile& from, const Profile& to) {
    for (const ProfileKey& key : profile_keys())
        if (key.rebuild != Rebuild::nothing && key.get(from) != key.get(to)) return true;
    return false;
}

} // namespace

Comparison::~Comparison() = default;

Profile Comparison::wanted(const State& state) const {
    const Profile* const other = state.document.compared();
    Profile profile =
        state.compared.with == CompareWith::profile && other != nullptr ? *other : state.document.profile();
    if (state.compared.with == CompareWith::threshold || state.compared.with == CompareWith::half)
        profile.refine.max_error_px = state.compared.error_px;
    return profile;
}

session::FlightOptions Comparison::options(const Engine& engine) const {
    return options_of(engine.session().file, profile_, engine.layers());
}

void Comparison::close(State& state) {
    drop_graphics();
    session_.reset();
    opening_ = {}; // waits for its thread
    halving_ = halved_ = 0;
    state.compared.there = false;
}

void Comparison::adopt(const Engine& engine) {
    auto session = opening_.get();
    renderer_ = session::make_renderer(options(engine), *session);
    session_ = std::move(session);
    new_ = true;
}

void Comparison::follow(State& state, const Engine& engine) {
    const bool lost = state.compared.with == CompareWith::profile && state.document.compared() == nullptr;
    if (state.compared.with == CompareWith::nothing || lost || !engine.is_open()) {
        if (lost) state.compared.with = CompareWith::nothing;
        if (session_ || opening_.valid()) close(state);
        return;
    }
    if (opening_.valid() && opening_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
        try {
            adopt(engine);
        } catch (...) { // what it needs cannot be had: the first profile's picture goes on
            state.compared.with = CompareWith::nothing;
            throw;
        }
    }
    if (opening_.valid() || state.document.dragging()) return;
    const Profile now = wanted(state);
    if (session_ && terrains_ == engine.terrains() && !needs_reopening(profile_, now)) {
        if (!renderer_) { // the context was lost
            renderer_ = session::make_renderer(options(engine), *session_);
            new_ = true;
        }
        profile_ = now;
        return;
    }
    close(state);
    profile_ = now;
    terrains_ = engine.terrains();
    opening_ = std::async(std::launch::async, [o = options(engine)] {
        auto session = std::make_unique<session::Session>();
        session::open_session(o, *session);
        return session;
    });
}

bool Comparison::update(State& state, const View& refining) {
    if (!session_ || !renderer_) return false;
    entry_ = session::update_frame(*session_, refining, profile_, state.now_s);
    session::upload_mesh(*renderer_, *session_, entry_);
    state.compared.there = true;
    ComparedPicture& shown = state.compared;
    shown.triangles = entry_.triangles_drawn;
    shown.update_us = entry_.update_us + entry_.stream_us;
    shown.asked_px = profile_.refine.max_error_px;
    shown.kept_px = entry_.error_bound_px;
    shown.exhausted = entry_.exhausted;
    if (shown.with == CompareWith::half) halve(state);
    if (const double share = difference_.take_share(); share >= 0) shown.differing = share;
    return std::exchange(new_, false) || entry_.rebuilt || entry_.activations != 0 || entry_.deactivations != 0 ||
           entry_.morphing != 0 || entry_.upload_bytes != 0;
}

bool Comparison::rests() const {
    return entry_.waiting == entry_.blocked && entry_.morphing == 0 &&
           (!entry_.streamed || entry_.stream.in_flight == 0);
}

bool Comparison::settled() const {
    if (opening_.valid()) return false;
    if (!session_) return true;
    return !new_ && rests() && !difference_.counting() && (halving_ == 0 || halved_ >= most_halving_steps);
}

// Triangles go by about the threshold to the power -1.3; a step is one mesh that has come to rest.
void Comparison::halve(State& state) {
    const session::FrameEntry& first = state.measures.last();
    if (first.waiting != first.blocked || first.morphing != 0 || first.triangles_drawn == 0) return;
    if (std::exchange(halving_, first.triangles_drawn) != first.triangles_drawn) halved_ = 0;
    if (!rests() || halved_ >= most_halving_steps) return;
    const double ratio = 2.0 * entry_.triangles_drawn / first.triangles_drawn;
    if (std::abs(ratio - 1) < 0.01) halved_ = most_halving_steps;
    if (halved_ >= most_halving_steps) return;
    ++halved_;
    state.compared.error_px = std::clamp(state.compared.error_px * std::pow(ratio, 0.75), ranges::least_threshold_px,
                                         ranges::most_threshold_px);
}

void Comparison::draw(const State& state, const gl::Target& target) {
    if (!session_ || !renderer_) return;
    const std::uint32_t w = target.width(), h = target.height();
    if (!target_ || target_->width() != w || target_->height() != h) target_ = gl::Target::create({w, h, 1});
    gl::DrawOptions options = session::draw_options(state.interface.mode, profile_, 0);
    options.wireframe = options.wireframe || state.shows(Overlay::wireframe);
    options.tile_borders = state.shows(Overlay::tile_borders);
    options.page_borders = state.shows(Overlay::page_borders);
    options.contour_m = state.shows(Overlay::contours) ? contour_interval_m(state) : 0;
    options.slope = state.shows(Overlay::slope);
    renderer_->draw_uploaded(session_->mesh(), state.eye.view, options, *target_);
    difference_.compare(target, *target_, state.compared.view == CompareView::difference);
    if (state.compared.view == CompareView::difference) return;
    glDisable(GL_FRAMEBUFFER_SRGB);
    const auto from = static_cast<GLint>(state.compared.divider * w), to = static_cast<GLint>(w),
               top = static_cast<GLint>(h);
    if (from >= to) return;
    glBlitNamedFramebuffer(target_->framebuffer(), target.framebuffer(), from, 0, to, top, from, 0, to, top,
                           GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT, GL_NEAREST); // lines are drawn over both sides
}

void Comparison::drop_graphics() {
    difference_.drop_graphics();
    target_.reset();
    renderer_.reset();
}

namespace {

constexpr const char* vertex_text = R"(
void main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0, 0.0, 1.0); }
)";

// Colours are compared as they are stored and seen, in sRGB: equal steps of light would hide the dark.
constexpr const char* fragment_text = R"(
layout(binding = 0) uniform sampler2D first;
layout(binding = 1) uniform sampler2D second;
layout(location = 0) uniform float gain;
layout(location = 1) uniform float least;
layout(location = 0) out vec4 colour;
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 apart = abs(texelFetch(first, at, 0).rgb - texelFetch(second, at, 0).rgb);
    float most = max(apart.r, max(apart.g, apart.b));
    if (most < least) discard;
    float much = clamp(gain * most, 0.0, 1.0) * 3.0;
    const vec3 steps[4] = vec3[](vec3(0.0), vec3(0.15, 0.3, 0.8), vec3(0.96, 0.84, 0.2), vec3(1.0));
    int i = min(int(much), 2);
    colour = vec4(mix(steps[i], steps[i + 1], much - float(i)), 1.0);
}
)";

} // namespace

void PictureDifference::make(std::uint32_t width, std::uint32_t height) {
    if (program_.get() == 0) {
        program_ = gl::make_program({"difference", "", vertex_text, "", fragment_text});
        unsigned name = 0;
        glCreateVertexArrays(1, &name);
        nothing_ = gl::VertexArray(name);
    }
    if (width == width_ && height == height_) return;
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
}

void PictureDifference::compare(const gl::Target& first, const gl::Target& second, bool show) {
    make(first.width(), first.height());
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
    if (query_ == 0) glCreateQueries(GL_SAMPLES_PASSED, 1, &query_);
    if (!counting_) { // otherwise the one before is still under way
        glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
        glProgramUniform1f(program_.get(), 1, (visible_difference - 0.5F) / 255);
        glBeginQuery(GL_SAMPLES_PASSED, query_);
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glEndQuery(GL_SAMPLES_PASSED);
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        counting_ = true;
    }
    glProgramUniform1f(program_.get(), 1, 0);
    if (show) glDrawArrays(GL_TRIANGLES, 0, 3);
}

double PictureDifference::take_share() {
    if (!counting_) return -1;
    GLuint there = 0;
    glGetQueryObjectuiv(query_, GL_QUERY_RESULT_AVAILABLE, &there);
    if (there == 0) return -1;
    GLuint64 pixels = 0;
    glGetQueryObjectui64v(query_, GL_QUERY_RESULT, &pixels);
    counting_ = false;
    return static_cast<double>(pixels) / (static_cast<double>(width_) * height_);
}

void PictureDifference::drop_graphics() {
    if (query_ != 0) glDeleteQueries(1, &query_);
    program_ = {};
    nothing_ = {};
    for (int i = 0; i < 2; ++i) copies_[i] = {}, frames_[i] = {};
    width_ = height_ = query_ = 0;
    counting_ = false;
}

} // namespace fjell::editor
