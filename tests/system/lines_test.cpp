// Lines and balls in a drawn scene: where they must be, hidden where the terrain is nearer, and steady far away.
#include <cmath>
#include <random>
#include <vector>

#include "fjell/gl/lines.h"
#include "picture_scene.h"
#include "support/dem.h"
#include "support/rounds.h"

using namespace pictures;

namespace {

constexpr gl::Rgba8 red{255, 0, 0, 255};

struct Drawer {
    Scene& scene;
    std::unique_ptr<gl::Lines> lines;

    explicit Drawer(Scene& of, const gl::LinesOptions& options = {}) : scene(of) { lines = gl::Lines::create(options); }
    // Over a picture of the mesh.
    gl::Image draw(const MeshView& mesh, const View& view, std::span<const gl::Line> some,
                   std::span<const gl::Ball> balls, const gl::LineStyle& style) {
        scene.renderer->draw(mesh, view, {.light = scene.light}, *scene.target);
        lines->draw(some, balls, view, *scene.target, style);
        gl::Image image;
        scene.target->read_colour(image);
        REQUIRE(context().log().errors == 0);
        return image;
    }
};

double between(std::mt19937& random, double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
}

// A point on the screen; outside, or before the near plane: not visible.
struct Seen {
    bool visible = false;
    double x = 0, y = 0, distance_m = 0;
    double least_m = 0, most_m = 0; // of what else of the line is within 2 pixels
};
Seen project(const View& view, Vec3 p) {
    const Vec3 d = p - view.eye_m;
    Seen seen;
    seen.distance_m = seen.least_m = seen.most_m = dot(d, view.forward);
    if (seen.distance_m < view.near_m * 1.001) return seen;
    seen.x = width_px / 2.0 + focal_length_px(view) * dot(d, cross(view.forward, view.up)) / seen.distance_m;
    seen.y = height_px / 2.0 - focal_length_px(view) * dot(d, view.up) / seen.distance_m;
    seen.visible = seen.x > 2 && seen.y > 2 && seen.x < width_px - 2 && seen.y < height_px - 2;
    return seen;
}

struct Checked {
    std::size_t in_front = 0, behind = 0, wrong = 0;
};

bool differ(const gl::Image& a, const gl::Image& b, std::uint32_t x, std::uint32_t y) {
    return !std::equal(a.pixel(x, y), a.pixel(x, y) + 3, b.pixel(x, y));
}

// A point of a line 1.5 pixels wide: its pixel is red where the point is nearer than the terrain in all pixels around
// it, and as it was where it is farther and no other line is near. 2^-10: what chords and floats may lose many times.
void check(const Picture& plain, const gl::Image& drawn, const Seen& at, bool others, Checked& result) {
    if (!at.visible) return;
    const auto x = static_cast<std::uint32_t>(at.x), y = static_cast<std::uint32_t>(at.y);
    double least = INFINITY, most = 0;
    for (std::uint32_t j = y - 2; j <= y + 2; ++j)
        for (std::uint32_t i = x - 2; i <= x + 2; ++i) {
            const double d = plain.distance_m[std::size_t{j} * width_px + i];
            least = std::min(least, d);
            most = std::max(most, d);
        }
    const std::uint8_t* const is = drawn.pixel(x, y);
    if (at.most_m < least * (1 - 0x1p-10)) {
        ++result.in_front;
        // The pixel's middle is at most half a diagonal, 0.71 pixels, off: a line that reaches 0.75 covers half of it.
        result.wrong += !(is[0] > 180 && is[0] > is[1] + 60 && is[0] > is[2] + 60);
    } else if (at.least_m > most * (1 + 0x1p-10) && !others) {
        ++result.behind;
        result.wrong += differ(plain.colour, drawn, x, y);
    }
}

} // namespace

TEST_CASE("a line is drawn where it is nearer than the terrain and nowhere else, from behind the eye too",
          "[picture]") {
    Scene scene(mountains(513), 7);
    Drawer drawer(scene);
    std::mt19937 random(5);
    Checked result;
    std::size_t from_behind = 0;
    for (int round = 0; round < 40; ++round) {
        const View view = scene.camera(between(random, 0.2, 0.8), between(random, 0.2, 0.8), between(random, 50, 1500),
                                       between(random, 0, 360), between(random, -30, 5));
        const MeshView mesh = scene.refined(view, 4);
        const Picture plain = scene.draw(mesh, view);
        const auto some_point = [&] {
            const double far_m = std::exp(between(random, 2, 10));
            return view.eye_m +
                   Vec3{between(random, -1, 1), between(random, -0.7, 0.2), between(random, -1, 1)} * far_m;
        };
        const gl::Line line{some_point(), some_point(), red};
        const gl::Image drawn = drawer.draw(mesh, view, {&line, 1}, {}, {.hidden = 0});
        // Both ends in pixels, cut to what lies before the near plane.
        Vec3 ends[2] = {line.from, line.to};
        double ahead[2];
        for (int k = 0; k < 2; ++k) ahead[k] = dot(ends[k] - view.eye_m, view.forward) - 1.01 * view.near_m;
        const bool any = ahead[0] > 0 || ahead[1] > 0;
        for (int k = 0; k < 2 && any; ++k)
            if (ahead[k] < 0) ends[k] = ends[k] + (ends[1 - k] - ends[k]) * (ahead[k] / (ahead[k] - ahead[1 - k]));
        const Seen a = project(view, ends[0]), b = project(view, ends[1]);
        const double length_px = std::hypot(b.x - a.x, b.y - a.y);
        bool behind = false, seen = false;
        std::vector<Seen> points;
        for (int i = 0; i <= 4000; ++i) { // crowded at both ends
            const double t = i / 4000.0;
            points.push_back(project(view, line.from + (line.to - line.from) * (t * t * (3 - 2 * t))));
        }
        for (std::size_t i = 0; i < points.size(); ++i) {
            Seen at = points[i];
            behind = behind || at.distance_m < 0;
            seen = seen || at.visible;
            const auto beside = [&](const Seen& end) { return std::hypot(at.x - end.x, at.y - end.y) < 2; };
            if (!at.visible || beside(a) || beside(b)) continue; // its ends are blunt
            const auto add = [&](std::size_t k) {                // seen end on, a line crosses depths within a pixel
                if (std::hypot(points[k].x - at.x, points[k].y - at.y) > 2) return false;
                at.least_m = std::min(at.least_m, points[k].distance_m);
                at.most_m = std::max(at.most_m, points[k].distance_m);
                return true;
            };
            for (std::size_t k = i; k > 0 && add(k - 1); --k) {
            }
            for (std::size_t k = i + 1; k < points.size() && add(k); ++k) {
            }
            check(plain, drawn, at, false, result);
        }
        from_behind += behind && seen;
        // Nothing but the line: no pixel differs that is farther than 2 from it.
        std::size_t stray = 0;
        for (std::uint32_t y = 0; y < height_px; ++y)
            for (std::uint32_t x = 0; x < width_px; ++x) {
                if (!differ(plain.colour, drawn, x, y)) continue;
                const double across =
                    std::abs((b.x - a.x) * (y + 0.5 - a.y) - (b.y - a.y) * (x + 0.5 - a.x)) / length_px;
                stray += !any || across > 2;
            }
        CAPTURE(round);
        CHECK(stray == 0);
    }
    CAPTURE(result.in_front, result.behind);
    CHECK(result.wrong == 0);
    CHECK(result.in_front > 5000);
    CHECK(result.behind > 500);
    CHECK(from_behind >= 5);
}

TEST_CASE("what a mountain hides of a line is dimmed and dashed when asked for", "[picture]") {
    Scene scene(mountains(513), 7);
    Drawer drawer(scene);
    const View view = scene.camera(0.5, 0.9, 150, 0, -10);
    const MeshView mesh = scene.refined(view, 4);
    const Picture plain = scene.draw(mesh, view);
    const Vec3 right = cross(view.forward, view.up);
    const Vec3 deep = view.eye_m + view.forward * 9000 + view.up * -2800; // underground
    const gl::Line line{deep + right * -3000, deep + right * 3000, red};
    const auto redder = [&](float hidden) {
        const gl::Image drawn = drawer.draw(mesh, view, {&line, 1}, {}, {.hidden = hidden});
        std::pair<std::size_t, double> sum{0, 0};
        for (std::uint32_t y = 0; y < height_px; ++y)
            for (std::uint32_t x = 0; x < width_px; ++x) {
                if (!differ(plain.colour, drawn, x, y)) continue;
                ++sum.first;
                sum.second += drawn.pixel(x, y)[0] - plain.colour.pixel(x, y)[0];
            }
        return sum;
    };
    const auto none = redder(0), some = redder(0.3f), all = redder(1);
    const double length_px = 6000 / 9000.0 * focal_length_px(view);
    CHECK(none.first == 0);
    CHECK(static_cast<double>(some.first) > length_px / 2); // half of it, two pixels high or more
    CHECK(static_cast<double>(some.first) < length_px * 2);
    CHECK(some.second > 0);
    CHECK(some.second < all.second * 0.8);
}

TEST_CASE("a ball is three great circles where they are expected", "[picture]") {
    Scene scene(mountains(513), 7);
    Drawer drawer(scene);
    std::mt19937 random(6);
    Checked result;
    for (int round = 0; round < test::rounds(12, 20); ++round) {
        const View view = scene.camera(between(random, 0.3, 0.7), between(random, 0.3, 0.7), between(random, 300, 1500),
                                       between(random, 0, 360), between(random, -30, -5));
        const MeshView mesh = scene.refined(view, 4);
        const Picture plain = scene.draw(mesh, view);
        // Every third around the eye: its circles pass behind.
        const double radius_m = between(random, 100, 1500);
        const Vec3 centre = round % 3 == 0 ? view.eye_m + view.forward * (radius_m / 2)
                                           : view.eye_m + view.forward * between(random, 1.5, 6) * radius_m;
        const gl::Ball ball{centre, radius_m, red};
        const gl::Image drawn = drawer.draw(mesh, view, {}, {&ball, 1}, {.hidden = 0});
        const Vec3 unit[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        for (std::size_t plane = 0; plane < 3; ++plane)
            for (int i = 0; i < 96; ++i) { // the ends of its pieces: between them a chord may leave it by pixels
                const auto on_circle = [&](int end) {
                    const double angle = 2 * pi * end / 96;
                    const Vec3 p = unit[plane] * std::cos(angle) + unit[(plane + 1) % 3] * std::sin(angle);
                    return project(view, centre + p * radius_m);
                };
                // Where a circle seen flat turns back, its pieces' blunt ends leave the corner out.
                const Seen before = on_circle(i - 1), at = on_circle(i), after = on_circle(i + 1);
                const double ax = at.x - before.x, ay = at.y - before.y, bx = after.x - at.x, by = after.y - at.y;
                if (before.visible && after.visible &&
                    ax * bx + ay * by > 0.9 * std::hypot(ax, ay) * std::hypot(bx, by))
                    check(plain, drawn, at, true, result);
            }
        // Outside its outline nothing is drawn: a ray that passes the centre by more than the radius and 2 pixels.
        std::size_t stray = 0;
        const Vec3 right = cross(view.forward, view.up);
        for (std::uint32_t y = 0; y < height_px; ++y)
            for (std::uint32_t x = 0; x < width_px; ++x) {
                if (!differ(plain.colour, drawn, x, y)) continue;
                const Vec3 ray = normalised(view.forward * focal_length_px(view) + right * (x + 0.5 - width_px / 2.0) +
                                            view.up * (height_px / 2.0 - y - 0.5));
                const Vec3 to = centre - view.eye_m;
                stray +=
                    length(to) > radius_m && length(cross(to, ray)) > radius_m + 2 * length(to) / focal_length_px(view);
            }
        CAPTURE(round);
        CHECK(stray == 0);
    }
    CAPTURE(result.in_front);
    CHECK(result.wrong == 0);
    CHECK(result.in_front > 1000);
}

TEST_CASE("10,000 km from the origin lines and balls are bit for bit those near it", "[picture]") {
    constexpr double spacing_m = 10'000, period_m = 1024 * spacing_m; // a whole number of tiles
    baker::Dem dem;
    dem.columns = 1057;
    dem.rows = 33;
    dem.spacing_m[0] = dem.spacing_m[1] = spacing_m;
    dem.heights_m.assign(std::size_t{1057} * 33, 0.0f);
    Scene scene(std::move(dem), 4);
    Drawer drawer(scene);
    const auto look = [&](double origin_m, double moved_m) {
        const Vec3 eye{origin_m + 83'125 + moved_m, 60, 155'000};
        const View view = make_view(eye, {0.8, -0.6, 0}, {0.6, 0.8, 0}, pi / 4, width_px, height_px, 1, 1e7);
        const Vec3 at{origin_m + 83'125, 20, 155'000};
        const gl::Line lines[2] = {{at + Vec3{20, 0, -30}, at + Vec3{60, 3, 30}, red},
                                   {at + Vec3{-2e6, 10, -40}, at + Vec3{1e6, 5, 20}, red}};
        const gl::Ball ball{at + Vec3{50, 0, 4}, 20, red};
        return drawer.draw(scene.refined(view, 1), view, lines, {&ball, 1}, {});
    };
    gl::Image before = look(0, 0);
    for (int i = 0; i <= 8; ++i) {
        const gl::Image near_by = look(0, i / 64.0), far = look(period_m, i / 64.0);
        CHECK((near_by.rgb == far.rgb));               // parentheses: on failure Catch would print millions of numbers
        if (i > 0) CHECK((near_by.rgb != before.rgb)); // a sixty-fourth of a metre is seen
        before = near_by;
    }
}

TEST_CASE("the edges of a view lie on its frustum's planes", "[picture]") {
    std::mt19937 random(8);
    for (int round = 0; round < 50; ++round) {
        const Vec3 forward{between(random, -1, 1), between(random, -1, 1), between(random, -1, 1)};
        const auto side = [&] { return static_cast<std::uint32_t>(between(random, 1, 2000)); };
        const View view = make_view({between(random, -1e6, 1e6), 500, between(random, -1e6, 1e6)}, forward,
                                    {0.1, 1, 0.3}, between(random, 0.2, 2), side(), side(), 2, 5000);
        gl::Line edges[12];
        gl::frustum_lines(view, view.far_m, red, edges);
        const Frustum frustum = make_frustum(view);
        std::size_t on_plane[6] = {};
        double worst = 0;
        for (const gl::Line& edge : edges)
            for (const Vec3 end : {edge.from, edge.to})
                for (int k = 0; k < 6; ++k) {
                    const double off = dot(frustum.normal[k], end - view.eye_m) - frustum.offset[k];
                    // Ends 5,000 m ahead, at most 10,000 aside by aspect and angle, counted from 10^6 m: 2^-33 m each.
                    const double reach = 1e-8 * (1 + length(end - view.eye_m));
                    on_plane[k] += std::abs(off) <= reach;
                    worst = std::min(worst, off + reach);
                }
        CHECK(worst >= 0); // no end is outside
        // Of 24 ends 12 are on the near plane, as many on each other one.
        for (const std::size_t count : on_plane) CHECK(count == 12);
    }
}

TEST_CASE("more lines or balls than there is room for are refused with the number to raise", "[picture]") {
    Scene scene(mountains(129), 5);
    Drawer drawer(scene, {.lines = 12, .balls = 1});
    View view = scene.camera(0.5, 0.9, 150, 0, -10);
    const MeshView mesh = scene.refined(view, 4);
    std::vector<gl::Line> lines(13);
    const gl::Ball balls[2] = {};
    (void)scene.draw(mesh, view);
    CHECK_THROWS_WITH(drawer.lines->draw(lines, {}, view, *scene.target), Catch::Contains("LinesOptions::lines"));
    CHECK_THROWS_WITH(drawer.lines->draw({}, balls, view, *scene.target), Catch::Contains("LinesOptions::balls"));
    CHECK_THROWS_WITH(drawer.lines->draw({}, {}, view, *scene.target, {.width_px = 0}), Catch::Contains("width_px"));
    lines.resize(12);
    gl::frustum_lines(scene.camera(0.5, 0.5, 100, 0, -10), 1000, red, std::span<gl::Line, 12>(lines.data(), 12));
    lines[3].from.x = NAN;       // is left out
    for (int i = 0; i < 20; ++i) // round the ring
        drawer.lines->draw(lines, {balls, 1}, view, *scene.target);
    view.top = view.bottom;
    CHECK_THROWS_AS(drawer.lines->draw(lines, {}, view, *scene.target), io::Failure);
    CHECK(context().log().errors == 0);
    // The next picture is none the worse for it.
    view = scene.camera(0.5, 0.9, 150, 0, -10);
    const Picture plain = scene.draw(mesh, view);
    drawer.lines->draw(lines, {}, view, *scene.target);
    const Picture again = scene.draw(mesh, view);
    CHECK((plain.colour.rgb == again.colour.rgb));
    CHECK((plain.depth == again.depth));
}
