// The loop of docs/guides/embedding.md: the block there is quoted from here (docs_test compares), and runs.
#include <catch2/catch.hpp>

#include "fjell/cut.h"
#include "support/terrain_fixture.h"

namespace {

std::vector<fjell::io::AlignedMemory> memory;
std::span<std::byte> allocate(std::size_t bytes) {
    memory.push_back(fjell::io::allocate(bytes));
    return {memory.back().get(), bytes};
}
std::string failure;
int fail(const char* field, const char* what) {
    failure = std::string(field) + ": " + what;
    return 1;
}
std::uint32_t uploaded = 0, uploaded_triangles = 0, drawn = 0;
int frames = 0;
void upload_vertices(std::uint32_t, std::uint32_t count) {
    uploaded += count;
}
void upload_triangles(std::uint32_t, std::uint32_t count) {
    uploaded_triangles += count;
}
void draw(const fjell::TileRange& range, const fjell::MeshView& mesh) {
    REQUIRE(range.index_count == 3 * range.triangles);
    REQUIRE(range.first_index + range.index_count <= mesh.indices.size());
    drawn += range.triangles;
}

int embed(std::span<const std::byte> file) {
    fjell::CutReport report;
    fjell::View view;
    const auto next_view = [&](fjell::View& v) {
        v = fjell::make_view({100, 2000, 100}, {1, -1, 1}, {0, 1, 0}, 1, 1280, 720, 1, 1e5);
        return ++frames < 3;
    };
    fjell::Pack pack; // `file`: the pack's bytes, read or mapped by you
    if (fjell::Status s = fjell::open_pack(file, pack); !s.ok()) return fail(s.field, fjell::message(s.code));
    fjell::Terrain terrain; // your memory, aligned to 64 bytes; the library allocates nothing itself
    if (!fjell::load_terrain(pack, allocate(fjell::terrain_bytes(pack.header)), terrain).ok())
        return fail("terrain", "damaged");
    const fjell::CutBudget budget{.vertices = 400'000, .triangles = 800'000};
    fjell::LiveCut cut;
    if (!fjell::create_cut(terrain, budget, allocate(fjell::cut_bytes(terrain, budget)), cut).ok())
        return fail("budget", "too small");
    while (next_view(view)) { // every frame: no allocation, no lock, no system call, no exception
        if (!fjell::update_cut(cut, {&view, 1}, {.max_error_px = 1.0, .max_time_us = 2'000}, report).ok())
            return fail("view", "not a camera");
        const fjell::CutMesh live = fjell::cut_mesh(cut);
        const fjell::CutChanges changes = fjell::cut_take_changes(cut);                  // written since the last call:
        fjell::for_each_run(changes.vertex_bits, changes.vertex_words, upload_vertices); // a few kilobytes a frame
        fjell::for_each_run(changes.triangle_bits, changes.triangle_words, upload_triangles);
        for (const fjell::TileRange& range : live.mesh.tiles) draw(range, live.mesh);
    }
    return 0;
}

} // namespace

TEST_CASE("the embedding example of the guide compiles, runs and draws") {
    fjell::test::Random random(1);
    auto dem = fjell::test::random_dem(random, 65, 65, fjell::test::Shape::fractal);
    const auto pack = fjell::test::bake_and_load(std::move(dem), fjell::test::small_bake(5));
    REQUIRE(embed(pack.file) == 0);
    REQUIRE(failure == "");
    REQUIRE(uploaded > 0);
    REQUIRE(uploaded_triangles > 0);
    REQUIRE(drawn > 0);
    std::vector<std::byte> damaged = pack.file;
    damaged[100] ^= std::byte{1};
    REQUIRE(embed(damaged) == 1);
    REQUIRE(failure.find("header: ") == 0);
}
