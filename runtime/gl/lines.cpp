#include "fjell/gl/lines.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <initializer_list>

#include <epoxy/gl.h>

#include "gl/fail.h"
#include "gl/objects.h"

namespace fjell::gl {
namespace {

using Switches = std::initializer_list<GLenum>;

constexpr unsigned block_binding = 0, record_slot = 0;
constexpr int circle_pieces = 96; // a chord leaves its circle by 1/1,870 of the radius: 0.2 pixels of 400
constexpr float most_width_px = 64;

// One draw's constants; mirrors the std140 block `Scene` below.
struct SceneBlock {
    float axis[3][4];  // a metre along x, y, z, projected
    float viewport[4]; // half its width and height, half a line's width [pixels]
    float depth[4];    // z = x - y * w; near [m]
};
static_assert(sizeof(SceneBlock) == 80, "SceneBlock is uploaded: change the block `Scene` with it");

// Projected: x and y of clip space, and w, the distance along forward; z follows from w.
struct LineRecord {
    float from[3], to[3];
    Rgba8 rgba;
};
struct BallRecord {
    float centre[3], radius_m, reserved[2];
    Rgba8 rgba;
};
static_assert(sizeof(LineRecord) == 28 && sizeof(BallRecord) == 28,
              "records are uploaded: change make_array() and lines.h with them");

// A quad of two triangles around a line on the screen, half a pixel wider on either side for the soft edge. Across and
// along are counted in pixels and so not in perspective.
const char* common_text() {
    return R"(
layout(std140, binding = 0) uniform Scene {
    vec4 axis[3];
    vec4 viewport;
    vec4 depth;
};
layout(location = 0) uniform float hidden; // 0: this pass draws what is in front
)";
}

const char* vertex_text() {
    return R"(
#ifdef BALLS
layout(location = 0) in vec4 a_ball; // projected centre, radius
#else
layout(location = 0) in vec3 a_from;
layout(location = 1) in vec3 a_to;
#endif
layout(location = 2) in vec4 a_colour;
noperspective out float v_across;
noperspective out float v_along; // in dashes and gaps
flat out vec4 v_colour;

vec3 linear_rgb(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045))); }

vec4 placed(vec3 at, vec2 moved_px) {
    return vec4(at.xy + moved_px / viewport.xy * at.z, depth.x - depth.y * at.z, at.z);
}

// The direction on the screen of a curve that goes through xyw `at` along `tangent`; where the chord says something
// else, because it turns or is cut, the chord's.
vec2 direction(vec3 at, vec3 tangent, vec2 chord) {
    vec2 along = (tangent.xy * at.z - at.xy * tangent.z) * viewport.xy;
    float size = length(along);
    return size > 0.0 && dot(along, chord) > 0.9 * size ? along / size : chord;
}

// xyw of both ends, neither behind the near plane, and which way to go there: ends that meet are cut alike. piece: of a
// circle, or -1. Its pieces have whole dashes or, where they are short, are one each.
void place(vec3 from, vec3 to, vec3 tangent_from, vec3 tangent_to, int corner, int piece) {
    vec2 a = from.xy / from.z * viewport.xy, b = to.xy / to.z * viewport.xy;
    float length_px = distance(a, b);
    vec2 chord = length_px > 1e-6 ? (b - a) / length_px : vec2(1.0, 0.0);
    bool second = corner == 1 || corner == 2 || corner == 4;
    float side = corner == 2 || corner == 4 || corner == 5 ? 1.0 : -1.0;
    vec2 along = direction(second ? to : from, second ? tangent_to : tangent_from, chord);
    float dashes = length_px / 12.0;
    if (piece >= 0) dashes = round(dashes);
    v_along = piece >= 0 && dashes == 0.0 ? float(piece & 1) * 0.5 + 0.25 : second ? dashes : 0.0;
    v_across = side * (viewport.z + 0.5);
    gl_Position = placed(second ? to : from, v_across * vec2(-along.y, along.x));
}

void main() {
    v_colour = vec4(linear_rgb(a_colour.rgb), a_colour.a);
#ifdef BALLS
    int piece = gl_VertexID / 6, circle = piece / PIECES;
    vec3 u = axis[circle == 0 ? 2 : 0].xyz, v = axis[circle == 1 ? 2 : 1].xyz; // planes zy, xz, xy
    vec2 angle = radians(360.0 / float(PIECES)) * vec2(piece % PIECES, (piece + 1) % PIECES);
    vec3 from = a_ball.xyz + a_ball.w * (cos(angle.x) * u + sin(angle.x) * v);
    vec3 to = a_ball.xyz + a_ball.w * (cos(angle.y) * u + sin(angle.y) * v);
    if (max(from.z, to.z) <= depth.z) {
        v_across = v_along = 0.0;
        gl_Position = vec4(0.0, 0.0, 2.0, 1.0); // outside: no pixel
        return;
    }
    if (from.z < depth.z) from = mix(from, to, (depth.z - from.z) / (to.z - from.z));
    if (to.z < depth.z) to = mix(to, from, (depth.z - to.z) / (from.z - to.z));
    from.z = max(from.z, depth.z);
    to.z = max(to.z, depth.z);
    vec3 tangent_from = cos(angle.x) * v - sin(angle.x) * u, tangent_to = cos(angle.y) * v - sin(angle.y) * u;
    place(from, to, tangent_from, tangent_to, gl_VertexID % 6, piece);
#else
    place(a_from, a_to, vec3(0.0), vec3(0.0), gl_VertexID % 6, -1);
#endif
}
)";
}

const char* fragment_text() {
    return R"(
noperspective in float v_across;
noperspective in float v_along;
flat in vec4 v_colour;
layout(location = 0) out vec4 out_colour;
void main() {
    float opacity = v_colour.a * clamp(viewport.z + 0.5 - abs(v_across), 0.0, 1.0) * min(2.0 * viewport.z, 1.0);
    if (hidden > 0.0) opacity *= fract(v_along) < 0.5 ? hidden : 0.0;
    out_colour = vec4(v_colour.rgb, opacity);
}
)";
}

// Projects from doubles.
class Projector {
public:
    explicit Projector(const View& view) : view_(view) {
        x_ = (cross(view.forward, view.up) * 2 - view.forward * (view.right + view.left)) *
             (1 / (view.right - view.left));
        y_ = (view.up * 2 - view.forward * (view.top + view.bottom)) * (1 / (view.top - view.bottom));
    }
    // A direction: x and y of clip space, and w in z.
    [[nodiscard]] Vec3 direction(Vec3 d) const { return {dot(x_, d), dot(y_, d), dot(view_.forward, d)}; }
    [[nodiscard]] Vec3 point(Vec3 p) const { return direction(p - view_.eye_m); }
    // The part of a line between near and far, and not far beside the picture, whose numbers floats hold well.
    [[nodiscard]] bool cut(Vec3& from, Vec3& to) const {
        constexpr double beside = 1.25; // wide lines beside the picture still reach into it
        const double a[6] = {from.z - view_.near_m,    view_.far_m - from.z,     beside * from.z - from.x,
                             beside * from.z + from.x, beside * from.z - from.y, beside * from.z + from.y};
        const double b[6] = {to.z - view_.near_m,  view_.far_m - to.z,   beside * to.z - to.x,
                             beside * to.z + to.x, beside * to.z - to.y, beside * to.z + to.y};
        double begin = 0, end = 1;
        for (int i = 0; i < 6; ++i) {
            if (!std::isfinite(a[i] - b[i]) || (a[i] < 0 && b[i] < 0)) return false;
            if (a[i] < 0) begin = std::max(begin, a[i] / (a[i] - b[i]));
            if (b[i] < 0) end = std::min(end, a[i] / (a[i] - b[i]));
        }
        if (begin >= end) return false;
        const Vec3 way = to - from, whole = from;
        if (end < 1) to = whole + way * end;
        if (begin > 0) from = whole + way * begin;
        from.z = std::max(from.z, view_.near_m); // rounded
        to.z = std::max(to.z, view_.near_m);
        return true;
    }

private:
    const View& view_;
    Vec3 x_, y_;
};

void set3(float* to, Vec3 v) {
    to[0] = static_cast<float>(v.x), to[1] = static_cast<float>(v.y), to[2] = static_cast<float>(v.z);
}

SceneBlock make_block(const View& view, const Projector& project, const Target& target, float width_px) {
    SceneBlock block{};
    const Vec3 unit[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 3; ++i) set3(block.axis[i], project.direction(unit[i]));
    block.viewport[0] = static_cast<float>(target.width()) / 2;
    block.viewport[1] = static_cast<float>(target.height()) / 2;
    block.viewport[2] = width_px / 2;
    const double range = view.far_m - view.near_m; // as the terrain's: see frame.cpp
    block.depth[0] = static_cast<float>(view.near_m * view.far_m / range);
    block.depth[1] = static_cast<float>(view.near_m / range);
    block.depth[2] = static_cast<float>(view.near_m);
    return block;
}

// Floats from the record's first, one attribute or two; the colour at its end.
VertexArray make_array(bool balls) {
    unsigned name = 0;
    glCreateVertexArrays(1, &name);
    VertexArray array(name);
    glVertexArrayBindingDivisor(name, record_slot, 1);
    const auto floats = [&](unsigned attribute, int count, std::size_t offset) {
        glVertexArrayAttribFormat(name, attribute, count, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
    };
    if (balls)
        floats(0, 4, offsetof(BallRecord, centre));
    else
        floats(0, 3, offsetof(LineRecord, from)), floats(1, 3, offsetof(LineRecord, to));
    glVertexArrayAttribFormat(name, 2, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(LineRecord, rgba));
    for (const unsigned attribute : {0u, 1u, 2u}) {
        if (balls && attribute == 1) continue;
        glEnableVertexArrayAttrib(name, attribute);
        glVertexArrayAttribBinding(name, attribute, record_slot);
    }
    return array;
}

} // namespace

struct Lines::State {
    LinesOptions options;
    Ring ring;
    Program line_program, ball_program;
    VertexArray line_array, ball_array;

    [[nodiscard]] std::size_t bytes(std::size_t lines, std::size_t balls) const {
        return ring.aligned(sizeof(SceneBlock)) + ring.aligned(lines * sizeof(LineRecord)) +
               ring.aligned(balls * sizeof(BallRecord));
    }
    void pass(bool in_front, float hidden, std::uint32_t lines, std::uint32_t balls) const;
};

Lines::Lines() : state_(std::make_unique<State>()) {}
Lines::~Lines() = default;

std::unique_ptr<Lines> Lines::create(const LinesOptions& options) {
    std::unique_ptr<Lines> result(new Lines);
    State& s = *result->state_;
    s.options = options;
    const auto program = [&](const char* name, const std::string& defines) {
        return make_program({name, defines + common_text(), vertex_text(), "", fragment_text()});
    };
    s.line_program = program("lines", "");
    s.ball_program = program("balls", "#define BALLS\n#define PIECES " + std::to_string(circle_pieces) + "\n");
    s.ring.create(s.bytes(options.lines, options.balls), "LinesOptions::lines or ::balls");
    s.line_array = make_array(false);
    s.ball_array = make_array(true);
    return result;
}

// Reversed depth: what is in front is greater.
void Lines::State::pass(bool in_front, float hidden, std::uint32_t lines, std::uint32_t balls) const {
    glDepthFunc(in_front ? GL_GEQUAL : GL_LESS);
    const auto draw = [&](const Program& program, const VertexArray& array, int vertices, std::uint32_t count) {
        if (count == 0) return;
        glProgramUniform1f(program.get(), 0, in_front ? 0.0f : hidden);
        glUseProgram(program.get());
        glBindVertexArray(array.get());
        glDrawArraysInstanced(GL_TRIANGLES, 0, vertices, static_cast<GLsizei>(count));
    };
    draw(line_program, line_array, 6, lines);
    draw(ball_program, ball_array, 6 * 3 * circle_pieces, balls);
}

namespace {

void set_up(const Target& target) {
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer());
    glViewport(0, 0, static_cast<GLsizei>(target.width()), static_cast<GLsizei>(target.height()));
    for (const GLenum off : Switches{GL_CULL_FACE, GL_SCISSOR_TEST, GL_STENCIL_TEST, GL_RASTERIZER_DISCARD})
        glDisable(off);
    for (const GLenum on : Switches{GL_DEPTH_TEST, GL_BLEND, GL_FRAMEBUFFER_SRGB, GL_MULTISAMPLE}) glEnable(on);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_FALSE);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
}

void put_back() {
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
    glDepthFunc(GL_LESS);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glBindVertexArray(0);
}

void check(const LinesOptions& most, std::size_t lines, std::size_t balls, const View& view, const LineStyle& style) {
    if (const Status status = validate(view); !status.ok())
        fail(std::string("the view cannot be drawn: ") + status.field + ": " + message(status.code));
    if (lines > most.lines)
        fail("there are " + std::to_string(lines) + " lines: raise LinesOptions::lines from " +
             std::to_string(most.lines));
    if (balls > most.balls)
        fail("there are " + std::to_string(balls) + " balls: raise LinesOptions::balls from " +
             std::to_string(most.balls));
    if (!(style.width_px > 0) || !(style.width_px <= most_width_px) || !(style.hidden >= 0) || !(style.hidden <= 1))
        fail("LineStyle::width_px must be above 0 and at most 64, ::hidden 0 to 1");
}

} // namespace

void Lines::draw(std::span<const Line> lines, std::span<const Ball> balls, const View& view, const Target& target,
                 const LineStyle& style) {
    State& s = *state_;
    check(s.options, lines.size(), balls.size(), view, style);
    s.ring.reserve(s.bytes(lines.size(), balls.size()));
    const Projector project(view);
    const SceneBlock block = make_block(view, project, target, style.width_px);
    const RingSlice numbers = s.ring.take(sizeof block);
    std::memcpy(numbers.data, &block, sizeof block);
    const RingSlice line_slice = s.ring.take(lines.size() * sizeof(LineRecord));
    const RingSlice ball_slice = s.ring.take(balls.size() * sizeof(BallRecord));
    std::uint32_t line_count = 0, ball_count = 0;
    for (const Line& line : lines) {
        Vec3 from = project.point(line.from), to = project.point(line.to);
        if (!project.cut(from, to)) continue;
        LineRecord record{};
        set3(record.from, from);
        set3(record.to, to);
        record.rgba = line.rgba;
        std::memcpy(line_slice.data + line_count++ * sizeof record, &record, sizeof record);
    }
    for (const Ball& ball : balls) {
        BallRecord record{};
        set3(record.centre, project.point(ball.centre));
        record.radius_m = static_cast<float>(ball.radius_m);
        record.rgba = ball.rgba;
        std::memcpy(ball_slice.data + ball_count++ * sizeof record, &record, sizeof record);
    }
    set_up(target);
    glBindBufferRange(GL_UNIFORM_BUFFER, block_binding, s.ring.buffer(), static_cast<GLintptr>(numbers.offset),
                      sizeof block);
    glVertexArrayVertexBuffer(s.line_array.get(), record_slot, s.ring.buffer(),
                              static_cast<GLintptr>(line_slice.offset), sizeof(LineRecord));
    glVertexArrayVertexBuffer(s.ball_array.get(), record_slot, s.ring.buffer(),
                              static_cast<GLintptr>(ball_slice.offset), sizeof(BallRecord));
    if (style.hidden > 0) s.pass(false, style.hidden, line_count, ball_count);
    s.pass(true, 0, line_count, ball_count);
    put_back();
}

void frustum_lines(const View& of, double length_m, Rgba8 rgba, std::span<Line, 12> out) {
    const Vec3 right = cross(of.forward, of.up);
    const double tangents[4][2] = {{of.left, of.bottom}, {of.right, of.bottom}, {of.right, of.top}, {of.left, of.top}};
    Vec3 corner[2][4]; // near, far
    for (std::size_t k = 0; k < 4; ++k) {
        const Vec3 ray = of.forward + right * tangents[k][0] + of.up * tangents[k][1];
        corner[0][k] = of.eye_m + ray * of.near_m;
        corner[1][k] = of.eye_m + ray * std::max(length_m, of.near_m);
    }
    for (std::size_t k = 0; k < 4; ++k) {
        out[k] = {corner[0][k], corner[0][(k + 1) % 4], rgba};
        out[4 + k] = {corner[1][k], corner[1][(k + 1) % 4], rgba};
        out[8 + k] = {corner[0][k], corner[1][k], rgba};
    }
}

} // namespace fjell::gl
