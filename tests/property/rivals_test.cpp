// Rivals are only worth comparing with when they do what their papers say: whole meshes, or their cracks counted; the
// error that they claim, measured from outside at every sample; and whatever works from our errors comes to our mesh.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "fjell/measure.h"
#include "rivals/binary_tree.h"
#include "rivals/blocks_and_vertices.h"
#include "rivals/cdlod.h"
#include "rivals/error_spheres.h"
#include "rivals/look.h"
#include "rivals/roam.h"
#include "support/cut_scene.h"
#include "support/ground_truth.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// A square of one tile, and what rivals read of it.
struct Square {
    io::LoadedPack pack;
    rivals::Ground ground;
    Square(Random& random, int log2, Shape shape)
        : pack(bake_and_load(random_dem(random, (1 << log2) + 1, (1 << log2) + 1, shape), small_bake(log2))),
          ground(rivals::ground_of(pack.terrain)) {}
    [[nodiscard]] const Terrain& terrain() const { return pack.terrain; }
};
Square random_square(Random& random, int least_log2, int most_log2) {
    const auto shape = static_cast<Shape>(pick(random, 0, static_cast<int>(Shape::count) - 1));
    return {random, pick(random, least_log2, most_log2), pick(random, 0, 1) ? Shape::fractal : shape};
}

// As triangles_of() has them: the smallest sample first, sorted.
std::vector<Triangle> triangles_of(const rivals::Rival& rival) {
    std::vector<rivals::Face> faces;
    rival.faces(faces);
    std::vector<Triangle> all;
    for (const rivals::Face& f : faces) {
        Triangle t;
        for (std::size_t k = 0; k < 3; ++k)
            t[k] = {static_cast<std::int32_t>(f[k].column), static_cast<std::int32_t>(f[k].row)};
        const auto less = [](Coord a, Coord b) { return std::pair(a.y, a.x) < std::pair(b.y, b.x); };
        std::rotate(t.begin(), std::min_element(t.begin(), t.end(), less), t.end());
        all.push_back(t);
    }
    std::sort(all.begin(), all.end(), [](const Triangle& a, const Triangle& b) {
        const auto key = [](const Triangle& t) { return std::array{t[0].y, t[0].x, t[1].y, t[1].x, t[2].y, t[2].x}; };
        return key(a) < key(b);
    });
    return all;
}

// Until it says that it is at rest.
void settle(rivals::Rival& rival, const View& view, double error_px, std::uint32_t operations) {
    for (int i = 0; i < patience_frames; ++i)
        if (!rival.refine(view, error_px, operations).interrupted) return;
    FAIL("a rival does not come to rest");
}
void settle(rivals::BinaryTree& tree, const View& view, double error_px) {
    do (void)tree.refine(view, error_px, rivals::unlimited_operations);
    while (tree.changes() > 0);
}

struct Looked {
    rivals::Look look;
    rivals::Seams seams;
    std::vector<rivals::Face> faces;
};
Looked look(const Square& square, const rivals::Rival& rival, const View& view) {
    Looked l;
    rival.faces(l.faces);
    l.look = rivals::look_at(square.ground, l.faces, view);
    l.seams = rivals::seams_of(square.ground, l.faces, view);
    return l;
}

} // namespace

TEST_CASE("ROAM, nested error spheres and a binary tree come to rest at the recursion's triangles") {
    Random random(601);
    std::size_t moved_views = 0;
    for (int round = 0; round < rounds(8, 120); ++round) {
        const Square square = random_square(random, 2, 7);
        rivals::Roam roam(square.ground);
        rivals::ErrorSpheres spheres(square.ground);
        rivals::BinaryTree tree(square.ground, false);
        View view = random_view(random, square.terrain());
        double error_px = random_threshold(random);
        for (int frame = 0; frame < 6; ++frame) {
            const std::uint32_t operations = pick(random, 0, 2) == 0 ? 7 : rivals::unlimited_operations;
            settle(roam, view, error_px, operations);
            settle(spheres, view, error_px, operations);
            settle(tree, view, error_px);
            const auto expected = recursive_triangles(square.terrain(), view, error_px);
            CAPTURE(round, frame, error_px, square.ground.side, operations);
            REQUIRE((triangles_of(roam) == expected));
            REQUIRE((triangles_of(spheres) == expected));
            REQUIRE((triangles_of(tree) == expected));
            view = moved(random, view, random_step_m(random, square.terrain()));
            ++moved_views;
            if (pick(random, 0, 5) == 0) error_px = random_threshold(random);
        }
    }
    CHECK(moved_views >= 40);
}

TEST_CASE("interrupted after any operation, ROAM, error spheres and our own cut leave a whole mesh") {
    Random random(602);
    int interrupted = 0;
    for (int round = 0; round < rounds(4, 40); ++round) {
        const Square square = random_square(random, 4, 6);
        for (const char* name : {"roam", "roam-wedgies", "spheres", "incremental"}) {
            const auto rival = rivals::make_rival(name, square.ground, square.terrain());
            View view = random_view(random, square.terrain());
            const double error_px = random_threshold(random);
            for (int frame = 0; frame < 8; ++frame) {
                interrupted +=
                    rival->refine(view, error_px, static_cast<std::uint32_t>(pick(random, 0, 40))).interrupted;
                const Looked l = look(square, *rival, view);
                CAPTURE(name, round, frame);
                REQUIRE((l.seams.open_edges == 0 && l.look.facing_down == 0));
                REQUIRE((l.look.uncovered == 0));
                view = moved(random, view, random_step_m(random, square.terrain()));
            }
        }
    }
    CHECK(interrupted > rounds(30, 300));
}

TEST_CASE("every rival's mesh is whole, and its true error is what the method claims where the claim holds") {
    Random random(603);
    std::map<std::string, double> worst; // true error over threshold
    int cameras = 0;
    for (int round = 0; round < rounds(5, 60); ++round) {
        const Square square = random_square(random, 5, 7);
        std::map<std::string, std::unique_ptr<rivals::Rival>> all;
        for (const std::string& name : rivals::rival_names())
            all.emplace(name, rivals::make_rival(name, square.ground, square.terrain()));
        for (int i = 0; i < 3; ++i, ++cameras) {
            const View view = random_view(random, square.terrain());
            const double error_px = random_threshold(random);
            for (const auto& [name, rival] : all) {
                for (int frame = 0; frame < 30; ++frame) (void)rival->refine(view, error_px, rivals::unlimited_operations);
                const Looked l = look(square, *rival, view);
                CAPTURE(name, round, i, error_px, l.look.error_px, l.seams.open_edges);
                REQUIRE((l.seams.open_edges == 0 && l.look.facing_down == 0));
                REQUIRE((l.look.uncovered == 0));
                worst[name] = std::max(worst[name], l.look.error_px / error_px);
                if (name != "blocks" && name != "cdlod") REQUIRE((l.look.error_px <= error_px * (1 + 1e-6)));
            }
        }
    }
    CHECK(cameras >= rounds(15, 100));
    for (const auto& [name, ratio] : worst) WARN(name << " " << ratio);
}

TEST_CASE("looking at a mesh agrees with the library's measure and with the ground found without a hierarchy") {
    Random random(604);
    for (int round = 0; round < rounds(6, 60); ++round) {
        const Square square = random_square(random, 3, 6);
        const View view = random_view(random, square.terrain());
        const double error_px = random_threshold(random);
        Recursive method(square.terrain(), ample_budget(square.terrain()));
        RefineSettings settings;
        settings.error_px = error_px;
        (void)method.update(view, settings);
        std::vector<rivals::Face> faces;
        for (const Triangle& t : fjell::test::triangles_of(method.mesh())) {
            rivals::Face f;
            for (std::size_t k = 0; k < 3; ++k)
                f[k] = {static_cast<float>(t[k].x), static_cast<float>(t[k].y),
                        square.ground.height_m[square.ground.index(t[k])]};
            faces.push_back(f);
        }
        std::vector<float> surface;
        const rivals::Look look = rivals::look_at(square.ground, faces, view, &surface);
        const Frustum frustum = make_frustum(view);
        const double measured_px = measure_error(square.terrain(), method.mesh(), view, &frustum).max_px;
        // Each allows for heights being floats, in its own way; both by some 2^-22 of the largest.
        const double largest_m = std::max(std::abs(double(square.ground.min_m)), std::abs(double(square.ground.max_m)));
        const double nearest_m = length(Vec3{look.where.x * double(square.ground.spacing_x_m), 0,
                                             look.where.y * double(square.ground.spacing_z_m)} -
                                        Vec3{view.eye_m.x, 0, view.eye_m.z});
        const double allowed_px = 0x1p-20 * largest_m * lambda_px(view) / std::max(nearest_m, 1e-3);
        CAPTURE(round, error_px, look.error_px, measured_px, allowed_px);
        CHECK(std::abs(look.error_px - measured_px) <= allowed_px + 1e-3 * measured_px);
        for (int i = 0; i < 50; ++i) {
            const Coord c{pick(random, 0, square.ground.side), pick(random, 0, square.ground.side)};
            const double truth_m = at(true_plane(square.terrain(), c.x, c.y), c.x, c.y);
            CHECK(std::abs(truth_m - double(square.ground.height_m[square.ground.index(c)])) <= 0x1p-20 * largest_m);
        }
    }
}
