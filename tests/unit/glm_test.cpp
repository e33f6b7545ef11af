// The optional GLM header against the runtime's own geometry.
#include <catch2/catch.hpp>

#include <random>

#include "fjell/glm.h"

using namespace fjell;

namespace {

using Random64 = std::mt19937_64;

double between(Random64& random, double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
}

Vec3 anywhere(Random64& random, double reach) {
    return {between(random, -reach, reach), between(random, -reach, reach), between(random, -reach, reach)};
}

View random_view(Random64& random) {
    View view = make_view(anywhere(random, 1e5), anywhere(random, 1), anywhere(random, 1), between(random, 0.1, 2.5),
                          1600, 900, between(random, 0.1, 10), between(random, 1e3, 1e6));
    if (random() % 2 == 0) { // off the centre
        const double wide = view.right - view.left, high = view.top - view.bottom;
        view.left = between(random, -1.2, 0.2) * wide, view.right = view.left + wide;
        view.bottom = between(random, -1.2, 0.2) * high, view.top = view.bottom + high;
    }
    return view;
}

} // namespace

TEST_CASE("a point inside the frustum is seen in the picture, one outside is not, and depth falls from 1 to 0") {
    Random64 random(7);
    int inside = 0, outside = 0;
    for (int i = 0; i < 20000; ++i) {
        const View view = random_view(random);
        REQUIRE(validate(view).ok());
        const Frustum frustum = make_frustum(view);
        const double d = between(random, view.near_m, view.far_m);
        const Vec3 point = view.eye_m + normalised(view.forward + anywhere(random, 1.2)) * d;
        double least = 1e300; // by how much it is inside, or how far out
        for (int k = 0; k < 6; ++k)
            least = std::min(least, dot(frustum.normal[k], point - view.eye_m) - frustum.offset[k]);
        if (std::abs(least) < 1e-6 * d + 1e-6) continue; // on a plane, as far as doubles can tell
        const auto pixel = project(view, point);
        const glm::dvec4 clip = reversed_projection(view) * (view_matrix(view) * glm::dvec4(to_glm(point), 1.0));
        const bool seen = pixel && pixel->x > 0 && pixel->x < 1600 && pixel->y > 0 && pixel->y < 900 && clip.z > 0;
        REQUIRE(seen == (least > 0));
        (seen ? inside : outside)++;
        if (seen) REQUIRE(clip.z / clip.w <= 1 + 1e-9);
    }
    CHECK(inside > 1000);
    CHECK(outside > 1000);
}

TEST_CASE("up is up in the picture, and right is right") {
    const View view = make_view({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 1, 800, 600, 1, 1000);
    const auto middle = project(view, {0, 0, -10}), up = project(view, {0, 1, -10}), east = project(view, {1, 0, -10});
    REQUIRE((middle && up && east));
    CHECK(middle->x == Approx(400));
    CHECK(middle->y == Approx(300));
    CHECK(up->y == Approx(300 - focal_length_px(view) / 10));
    CHECK(east->x == Approx(400 + focal_length_px(view) / 10));
    CHECK_FALSE(project(view, {0, 0, 10}));
    CHECK(from_glm(to_glm({1, 2, 3})).y == 2);
}

TEST_CASE("a projection gives the tangents back, as docs/guides/embedding-views.md says") {
    Random64 random(11);
    for (int i = 0; i < 1000; ++i) {
        const View view = random_view(random);
        const glm::dmat4 m = reversed_projection(view); // columns first: m[2][0] is row 0, column 2
        const double wide = view.right - view.left, high = view.top - view.bottom;
        CHECK(std::abs((m[2][0] - 1) / m[0][0] - view.left) < 1e-14 * wide * 4);
        CHECK(std::abs((m[2][0] + 1) / m[0][0] - view.right) < 1e-14 * wide * 4);
        CHECK(std::abs((m[2][1] - 1) / m[1][1] - view.bottom) < 1e-14 * high * 4);
        CHECK(std::abs((m[2][1] + 1) / m[1][1] - view.top) < 1e-14 * high * 4);
    }
}
