// The examples in the comments of public headers: their lines are quoted from here (docs_test compares), and run.
#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

#include "fjell/fjell.h"
#include "fjell/gltf/snapshot.h"
#include "fjell/io.h"
#include "fjell/profile.h"
#include "support/terrain_fixture.h"

TEST_CASE("the examples of the public headers compile, run and do what they say") {
    fjell::test::Random random(2);
    const fjell::test::TemporaryFolder folder;
    auto dem = fjell::test::random_dem(random, 129, 129, fjell::test::Shape::fractal);
    const std::string path = folder / "alps.fjell", out = folder / "frame.glb";
    (void)fjell::baker::bake(std::move(dem), fjell::test::small_bake(6), path);

    fjell::Profile profile = fjell::read_profile(FJELL_SOURCE_DIR "/profiles/laptop.toml");
    fjell::set_profile_key(profile, "refine.max_error_px", "2");
    fjell::io::LiveTerrain ground(path, fjell::live_options(profile));
    const double wide_m = ground.terrain().extent_x_m(), high_m = ground.pack().header.max_m;
    const fjell::Vec3 eye_m{wide_m / 4, high_m + wide_m / 8, ground.terrain().extent_z_m() / 4};
    const fjell::View view = fjell::make_view(eye_m, {1, -1, 1}, {0, 1, 0}, 0.8, 1280, 720, 1, 1e5);
    double now_s = 0;
    for (int frame = 0; frame < 1'000'000 && !ground.frame().settled; ++frame) // the reader may have to wait for a core
        ground.update({&view, 1}, now_s += 1.0 / 60);
    const fjell::io::LiveFrame& frame = ground.update({&view, 1}, now_s);
    for (const char* field : frame.short_of) std::printf("raise %s\n", field);
    CHECK(frame.settled);

    const fjell::GroundHeight below = fjell::ground_height(ground.terrain(), eye_m.x, eye_m.z);
    const double clearance_m = below.inside && !below.hole ? eye_m.y - below.height_m : 1e9;
    CHECK(clearance_m >= wide_m / 8);
    CHECK(clearance_m < 1e9);
    const fjell::GroundHit hit = fjell::cast_ray(ground.terrain(), eye_m, view.forward, 10'000);
    if (hit.hit) std::printf("ground %.1f m away, to %.2f m\n", hit.distance_m, hit.error_m);
    CHECK(hit.hit);
    fjell::io::LiveOptions options = fjell::live_options(profile);
    options.edits = fjell::EditBudget{}; // the ground may change
    fjell::io::LiveTerrain changing(path, options);
    const fjell::Edits edits = changing.edits();
    fjell::Stamp crater;
    crater.shape = fjell::StampShape::crater;
    crater.x_m = hit.position_m.x, crater.z_m = hit.position_m.z;
    crater.radius_m = 12, crater.falloff_m = 6, crater.amount_m = 5;
    fjell::StampId id = 0;
    const fjell::Status pushed = fjell::push_stamp(edits, crater, id);
    if (!pushed.ok()) std::printf("%s: %s\n", pushed.field, fjell::message(pushed.code));
    CHECK(pushed.ok());
    CHECK(fjell::stamp_state(edits, id).state == fjell::StampState::waiting);
    changing.update({&view, 1}, now_s);
    fjell::io::Journal journal(fjell::io::journal_path(path), changing.pack().header);
    const std::uint32_t layer = journal.layers().empty() ? journal.add_layer("digging") : journal.layers()[0].id;
    journal.add_stamp(layer, fjell::io::KeptStamp(crater));
    journal.commit();
    CHECK(fjell::io::Journal(journal.path()).stamps().size() == 1);
    std::uint64_t cursor = 0; // a consumer's own
    bool lost = false;
    fjell::GroundRect changed[16];
    const std::uint32_t rects = fjell::take_ground_changes(edits, cursor, changed, lost);
    for (std::uint32_t i = 0; i < rects; ++i)
        std::printf("columns %d to %d\n", changed[i].first.column, changed[i].last.column);
    CHECK(fjell::stamp_state(edits, id).state != fjell::StampState::refused);
    std::vector<float> heights_m(33 * 33);
    const fjell::GroundPatch patch = fjell::ground_patch(ground.terrain(), {32, 64}, 0, 33, heights_m);
    CHECK(std::isfinite(patch.error_m));

    const fjell::gltf::Snapshot snapshot = fjell::gltf::take_snapshot(ground, view); // between two updates
    fjell::gltf::write_snapshot(ground, snapshot, out);                              // on any thread
    CHECK(std::filesystem::file_size(out) > 1000);

    const fjell::io::PackFile file(path);
    fjell::Terrain terrain;
    const std::size_t bytes = fjell::terrain_bytes(file.pack().header);
    const fjell::io::AlignedMemory memory = fjell::io::allocate(bytes);
    REQUIRE(fjell::create_terrain(file.pack(), file.corners(), {}, {memory.get(), bytes}, terrain).ok());
    fjell::LiveCut cut;
    const fjell::CutBudget budget{.vertices = 400'000, .triangles = 800'000};
    const fjell::io::AlignedMemory cut_memory = fjell::io::allocate(fjell::cut_bytes(terrain, budget));
    fjell::Status s = fjell::create_cut(terrain, budget, {cut_memory.get(), fjell::cut_bytes(terrain, budget)}, cut);
    fjell::CutReport report;
    if (s.ok()) s = fjell::update_cut(cut, {&view, 1}, {.max_error_px = 1, .max_time_us = 2'000}, report);
    if (!s.ok()) std::printf("%s: %s\n", s.field, fjell::message(s.code));
    REQUIRE(s.ok());
    std::uint32_t uploaded = 0;
    const auto upload = [&](std::uint32_t first, std::uint32_t count) { uploaded += first * 0 + count; };
    const fjell::CutChanges changes = fjell::cut_take_changes(cut);
    fjell::for_each_run(changes.vertex_bits, changes.vertex_words, upload);
    CHECK(uploaded > 0);
    REQUIRE(fjell::destroy_cut(cut).ok());
}
