// A live cut in pictures: what it draws, what of it is uploaded, and how its vertices morph.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "picture_scene.h"
#include "support/dem.h"
#include "support/rounds.h"

using namespace pictures;

TEST_CASE("the live cut gives the picture of the recursive method, bit for bit", "[picture]") {
    const bool morphs = GENERATE(true, false); // CutBudget::morph
    Scene scene(mountains(513), 6);
    scene.make_cut(morphs);
    bool from_nothing = true;
    for (const View& view : {scene.camera(0.5, 0.9, 150, 0, -5), scene.camera(0.3, 0.6, 3000, 40, -45)})
        for (const gl::DrawOptions& drawing :
             {gl::DrawOptions{}, gl::DrawOptions{.mode = gl::Mode::levels}, gl::DrawOptions{.wireframe = true}}) {
            const Picture anew = scene.draw(scene.refined(view, 2, Topology::triangles, false), view, drawing);
            const CutReport report = scene.follow(view, 2, std::exchange(from_nothing, false));
            const CutMesh mesh = cut_mesh(scene.cut);
            REQUIRE(report.tiles_drawn > 1);
            REQUIRE(mesh.mesh.tiles.size() > report.tiles_drawn); // tiles of several ranges
            REQUIRE(mesh.morph.empty() == !morphs);
            const Picture live = scene.draw(mesh, view, drawing);
            CHECK(scene.renderer->stats().tiles == report.tiles_drawn);
            CHECK(scene.renderer->stats().triangles == report.triangles_drawn);
            CHECK(
                (live.colour.rgb == anew.colour.rgb)); // parentheses: on failure Catch would print millions of numbers
            CHECK((live.depth == anew.depth));
        }
}

TEST_CASE("what is coarser off-screen does not show, turned or moved: the picture is the same, bit for bit",
          "[picture]") {
    Scene scene(mountains(513), 6);
    scene.make_cut();
    (void)scene.follow(scene.camera(0.5, 0.9, 150, 0, -5), 2, true);
    std::uint32_t fewer = 0;
    for (int step = 0; step < test::rounds(4, 24); ++step) {
        const View view = scene.camera(0.5 + 0.004 * step, 0.8, 150, 15.0 * step, -5);
        CutSettings settings{.max_error_px = 2, .offscreen_factor = 8};
        CutReport coarser;
        REQUIRE(update_cut(scene.cut, {&view, 1}, settings, coarser).ok());
        REQUIRE(coarser.converged);
        const Picture live = scene.draw(cut_mesh(scene.cut), view);
        settings.offscreen_factor = 1;
        CutReport all_around;
        REQUIRE(update_cut(scene.cut, {&view, 1}, settings, all_around).ok());
        const Picture whole = scene.draw(cut_mesh(scene.cut), view);
        CHECK((live.colour.rgb == whole.colour.rgb));
        CHECK((live.depth == whole.depth));
        fewer += coarser.vertices < all_around.vertices / 10 * 9;
    }
    CHECK(fewer > 2);
}

TEST_CASE("of a live cut only the slots that were written are uploaded, and they suffice", "[picture]") {
    Scene scene(mountains(513), 6);
    scene.make_cut();
    const auto eye = [&](int step) { return scene.camera(0.5, 0.9 - 0.004 * step, 200, 3.0 * step, -10); };
    const auto slot_bytes = [](std::uint64_t vertices, std::uint64_t triangles) {
        return vertices * (sizeof(MeshVertex) + sizeof(MorphVertex)) + triangles * 12;
    };
    const auto record_bytes = [](std::uint64_t vertices, std::uint64_t triangles) { // with the slot in front
        return vertices * (4 + sizeof(MeshVertex) + sizeof(MorphVertex)) + triangles * 16;
    };
    scene.follow(eye(0), 2, true);
    (void)scene.draw(cut_mesh(scene.cut), eye(0));
    const std::uint64_t whole =
        slot_bytes(cut_mesh(scene.cut).mesh.vertices.size(), cut_mesh(scene.cut).mesh.indices.size() / 3);
    CHECK(scene.renderer->stats().bytes_uploaded == whole);
    std::vector<Picture> followed;
    for (int step = 1; step <= 6; ++step) {
        std::uint64_t expected = 0;
        if (step == 4) { // an update that is not drawn, only uploaded
            const CutReport between = scene.follow(eye(7), 2);
            scene.renderer->upload(cut_mesh(scene.cut), cut_take_changes(scene.cut));
            expected = record_bytes(between.vertices_changed, between.triangles_changed);
        }
        if (step == 5) // updates after which nothing is uploaded: a renderer three frames behind
            for (const int other : {9, 2, 8}) {
                const CutReport skipped = scene.follow(eye(other), 2);
                expected += record_bytes(skipped.vertices_changed, skipped.triangles_changed);
            }
        const CutReport report = scene.follow(eye(step), 2);
        expected += record_bytes(report.vertices_changed, report.triangles_changed);
        CHECK(report.activations > 0);
        CHECK(report.deactivations > 0);
        followed.push_back(scene.draw(cut_mesh(scene.cut), eye(step)));
        if (step != 5) CHECK(scene.renderer->stats().bytes_uploaded == expected);
        CHECK(scene.renderer->stats().bytes_uploaded <= expected); // a slot written twice is uploaded once
        CHECK(scene.renderer->stats().bytes_uploaded < whole / 10);
        scene.renderer->invalidate();
        const Picture fresh = scene.draw(cut_mesh(scene.cut), eye(step));
        CHECK(scene.renderer->stats().bytes_uploaded == whole);
        CHECK((followed.back().colour.rgb == fresh.colour.rgb));
        CHECK((followed.back().depth == fresh.depth));
    }
    CHECK((followed[0].depth != followed[5].depth));
    CHECK(context().log().errors == 0);
}

TEST_CASE("an upload that outgrows the ring's regions is whole all the same", "[picture]") {
    Scene scene(mountains(513), 6);
    scene.make_cut();
    const View view = scene.camera(0.5, 0.9, 200, 0, -10);
    scene.follow(view, 30, true);
    const MeshView mesh = cut_mesh(scene.cut).mesh;
    gl::RendererOptions slots{.vertices = static_cast<std::uint32_t>(mesh.vertices.size()),
                              .indices = static_cast<std::uint32_t>(mesh.indices.size()),
                              .ranges = 4096,
                              .morph = true,
                              .ring_bytes = 1}; // the least, 64 KB, beside 4,096 ranges
    scene.renderer = gl::Renderer::create(scene.loaded.terrain, scene.loaded.pack, slots);
    (void)scene.draw(cut_mesh(scene.cut), view);
    scene.follow(view, 0.5);
    const Picture piece_by_piece = scene.draw(cut_mesh(scene.cut), view);
    CHECK(scene.renderer->stats().bytes_uploaded > 4 * (65'536 + 4096 * 132 + 2048)); // more than all three regions
    scene.renderer->invalidate();
    const Picture fresh = scene.draw(cut_mesh(scene.cut), view);
    CHECK((piece_by_piece.colour.rgb == fresh.colour.rgb));
    CHECK((piece_by_piece.depth == fresh.depth));
}

TEST_CASE("the shader places morphing vertices where morphed_height_m() says", "[picture]") {
    Scene scene(mountains(513), 6);
    scene.make_cut();
    const View from = scene.camera(0.5, 0.9, 200, 0, -10), view = scene.camera(0.5, 0.88, 210, 5, -10);
    // The same mesh for a picture of half the size.
    const CutMesh live = scene.half_way(from, view, 3);
    OwnMesh placed = copy_of(live.mesh);
    std::size_t half_way = 0;
    for (std::size_t i = 0; i < placed.vertices.size(); ++i) {
        const float full = placed.vertices[i].height_m, flat = live.morph[i].morph_from_m;
        placed.vertices[i].height_m =
            morphed_height_m(scene.loaded.terrain, placed.vertices[i], live.morph[i], live.frame);
        half_way +=
            std::abs(placed.vertices[i].height_m - full) > 0.1f && std::abs(placed.vertices[i].height_m - flat) > 0.1f;
    }
    CHECK(half_way > 100);
    const Picture shader = scene.draw(live, view), processor = scene.draw(placed.view(), view);
    const Picture full = scene.draw(copy_of(live.mesh).view(), view);
    const auto apart = [&](const Picture& a, const Picture& b) {
        std::size_t n = 0;
        for (std::size_t i = 0; i < a.depth.size(); ++i)
            n += std::abs(a.depth[i] - b.depth[i]) > 1e-4f * std::max(a.depth[i], b.depth[i]);
        return n;
    };
    CHECK(apart(shader, processor) < shader.depth.size() / 10'000); // silhouettes, where a rounding shows
    CHECK(apart(shader, full) > shader.depth.size() / 100);         // or the measure is blind
}
