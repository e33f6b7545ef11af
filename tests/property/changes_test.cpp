// What cut_take_changes() gives: everything that was written since it was last called.
#include <catch2/catch.hpp>

#include <cstring>

#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// A renderer's buffers, and the cut that it follows, every so many frames.
struct Renderer {
    int every;
    Cut cut;
    std::vector<MeshVertex> vertices;
    std::vector<MorphVertex> morph;
    std::vector<std::uint32_t> indices;

    Renderer(int frames, const Terrain& terrain, const CutBudget& budget)
        : every(frames), cut(terrain, budget), vertices(budget.vertices), morph(budget.vertices),
          indices(cut_mesh(cut.cut).mesh.indices.size()) {}

    void upload() {
        const CutMesh live = cut_mesh(cut.cut);
        const CutChanges changes = cut_take_changes(cut.cut);
        for_each_run(changes.vertex_bits, changes.vertex_words, [&](std::uint32_t first, std::uint32_t count) {
            std::copy_n(live.mesh.vertices.begin() + first, count, vertices.begin() + first);
            std::copy_n(live.morph.begin() + first, count, morph.begin() + first);
        });
        for_each_run(changes.triangle_bits, changes.triangle_words, [&](std::uint32_t first, std::uint32_t count) {
            std::copy_n(live.mesh.indices.begin() + 3 * first, 3 * count, indices.begin() + 3 * first);
        });
    }
};

template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

} // namespace

TEST_CASE("renderers one and three frames behind have the buffers of one in step") {
    Random random(481);
    std::uint64_t compared = 0;
    for (int round = 0; round < rounds(15, 80); ++round) {
        const auto pack = random_terrain(random, 90, 6);
        const Terrain& terrain = pack.terrain;
        CutBudget budget = ample_cut(terrain);
        if (round % 3 == 0) { // some capacity does not suffice
            budget.vertices = std::max(budget.vertices / 8, terrain.tile_count() * 4 + 20);
            budget.triangles = std::max(budget.triangles / 4, budget.segment_triangles * (terrain.tile_count() + 6));
        }
        Renderer in_step(1, terrain, budget), one(2, terrain, budget), three(4, terrain, budget);
        View view = random_view(random, terrain);
        for (int frame = 1; frame <= 40; ++frame) {
            if (pick(random, 0, 5) == 0) view = random_view(random, terrain);
            view = moved(random, view, random_step_m(random, terrain));
            CutSettings settings;
            settings.max_error_px = random_threshold(random);
            settings.morph = frame > 10 ? Morph::error : Morph::none;
            settings.now_s = frame * 0.1;
            settings.max_work = pick(random, 0, 1) ? unlimited_work : 200;
            const bool rebuilds = pick(random, 0, 7) == 0;
            for (Renderer* renderer : {&in_step, &one, &three}) {
                rebuilds ? renderer->cut.rebuild({&view, 1}, settings) : renderer->cut.update({&view, 1}, settings);
                if (frame % renderer->every == 0) renderer->upload();
            }
            for (const Renderer* late : {&one, &three}) {
                if (frame % late->every != 0) continue;
                CAPTURE(round, frame, late->every);
                REQUIRE(same_bytes(late->indices, in_step.indices));
                REQUIRE(same_bytes(late->vertices, in_step.vertices));
                REQUIRE(same_bytes(late->morph, in_step.morph));
                ++compared;
            }
            const CutMesh live = cut_mesh(in_step.cut.cut); // and those are the cut's
            for (const TileRange& range : in_step.cut.mesh().tiles)
                for (std::uint32_t i = range.first_index; i < range.first_index + range.index_count; ++i) {
                    const std::uint32_t slot = live.mesh.indices[i];
                    REQUIRE(in_step.indices[i] == slot);
                    REQUIRE(std::memcmp(&in_step.vertices[slot], &live.mesh.vertices[slot], sizeof(MeshVertex)) == 0);
                    REQUIRE(std::memcmp(&in_step.morph[slot], &live.morph[slot], sizeof(MorphVertex)) == 0);
                }
        }
    }
    REQUIRE(compared > 400);
}

TEST_CASE("what was taken is not given twice") {
    Random random(482);
    const auto pack = rich_terrain(random, 65, 6);
    Cut cut(pack.terrain, ample_cut(pack.terrain));
    const View view = view_from_above(pack.terrain, 1);
    const auto taken = [&] {
        std::uint32_t slots = 0;
        const CutChanges changes = cut_take_changes(cut.cut);
        for_each_run(changes.vertex_bits, changes.vertex_words, [&](std::uint32_t, std::uint32_t n) { slots += n; });
        for_each_run(changes.triangle_bits, changes.triangle_words,
                     [&](std::uint32_t, std::uint32_t n) { slots += n; });
        return slots;
    };
    CHECK(taken() > 0); // the coarsest mesh, before the first update
    CHECK(taken() == 0);
    const CutReport report = cut.update({&view, 1}, {});
    CHECK(report.activations > 0);
    CHECK(taken() == report.vertices_changed + report.triangles_changed);
    CHECK(taken() == 0);
    CHECK(cut.update({&view, 1}, {}).vertices_changed == 0);
    CHECK(taken() == 0);
}

TEST_CASE("a rebuild that cuts a jump short tells what the jump has written") {
    Random random(483);
    int cut_short = 0;
    for (int round = 0; round < rounds(30, 120); ++round) {
        const auto pack = random_terrain(random, 140, 6);
        Cut cut(pack.terrain, ample_cut(pack.terrain, 2));
        CutSettings settings;
        settings.max_error_px = random_threshold(random);
        settings.morph = Morph::error;
        View view = random_view(random, pack.terrain);
        cut.rebuild({&view, 1}, settings);
        (void)cut_take_changes(cut.cut);
        const CutMesh live = cut_mesh(cut.cut); // slots that are free, too
        std::vector<MeshVertex> vertices(live.mesh.vertices.begin(), live.mesh.vertices.end());
        std::vector<MorphVertex> morph(live.morph.begin(), live.morph.end());
        for (int frame = 0; frame < 6; ++frame) {
            view = random_view(random, pack.terrain);
            settings.visits = static_cast<std::uint32_t>(pick(random, 1, 120));
            const bool rebuilds = frame % 2 == 1;
            cut_short += rebuilds && cut.state().bulk.phase == BulkPhase::triangles;
            rebuilds ? cut.rebuild({&view, 1}, settings) : cut.update({&view, 1}, settings);
            const CutChanges changes = cut_take_changes(cut.cut);
            for_each_run(changes.vertex_bits, changes.vertex_words, [&](std::uint32_t first, std::uint32_t count) {
                std::copy_n(live.mesh.vertices.begin() + first, count, vertices.begin() + first);
                std::copy_n(live.morph.begin() + first, count, morph.begin() + first);
            });
            CAPTURE(round, frame);
            REQUIRE(std::memcmp(vertices.data(), live.mesh.vertices.data(), vertices.size() * sizeof(MeshVertex)) == 0);
            REQUIRE(std::memcmp(morph.data(), live.morph.data(), morph.size() * sizeof(MorphVertex)) == 0);
        }
    }
    CHECK(cut_short > rounds(3, 12));
}
