// A terrain in one object: what it shows is what its parts show, what is forgotten is said, and what fails is one line.
#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <regex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "fjell/io/failure.h"
#include "fjell/io/journal.h"
#include "fjell/io/live_terrain.h"
#include "fjell/io/load.h"
#include "fjell/pages.h"
#include "fjell/profile.h"
#include "fjell/profile/keys.h"
#include "fjell/query.h"
#include "io/file.h"
#include "session/session.h"
#include "support/mesh_check.h"
#include "support/patience.h"
#include "support/program.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::session;
using namespace fjell::test;

namespace {

// Frames of a sixtieth of a second until nothing is left to do.
const io::LiveFrame& settle(io::LiveTerrain& terrain, const View& view, double& now_s) {
    for (const Patience patience; patience.left();) {
        const io::LiveFrame& f = terrain.update({&view, 1}, now_s += 1.0 / 60);
        (void)terrain.take_map_commands();
        (void)terrain.tile_maps(MapKind::colour);
        if (f.settled) return f;
    }
    return terrain.frame();
}

// A pack with maps in a file, and a profile over which it flies.
struct LivePlace {
    explicit LivePlace(bool room_for_holes = false) {
        Random random(411);
        baker::BakeOptions bake = small_bake(6);
        bake.room_for_holes = room_for_holes;
        bake.max_texture_log2 = 6;
        (void)baker::bake(random_dem(random, 200, 150, Shape::fractal), bake, pack);
        profile = parse_profile(R"([refine]
max_error_px = 2.5
morph = "error"
[budget]
vertices = 60000
triangles = 120000
[stream]
page_slots = 400
map_mb = 4
tail_log2 = 4
[view]
width_px = 640
height_px = 360
)",
                                "test.toml");
    }
    [[nodiscard]] FlightOptions options() const {
        FlightOptions o;
        o.pack = pack;
        o.streaming = Streaming::off;
        o.profile = profile;
        return o;
    }
    TemporaryFolder folder;
    std::string pack = folder / "t.fjell";
    Profile profile;
};

std::string opening_refusal(const std::string& pack, const io::LiveOptions& options) {
    try {
        const io::LiveTerrain terrain(pack, options);
    } catch (const io::Failure& failure) {
        CHECK(failure.exit_code == 1);
        CHECK(std::string(failure.what()).find('\n') == std::string::npos);
        return failure.what();
    }
    return "opened";
}

bool has_part(const std::string& text, const std::string& part) {
    if (text.find(part) != std::string::npos) return true;
    WARN(text);
    return false;
}

} // namespace

TEST_CASE("a terrain in one object, from a file or from memory, shows what fjell-fly shows with the same profile") {
    const LivePlace place;
    const FlightOptions options = place.options();
    Session session;
    open_session(options, session);
    const std::vector<std::byte> bytes = io::read_file(place.pack);
    io::LiveTerrain from_file(place.pack, live_options(place.profile));
    io::LiveTerrain from_memory(bytes, "memory", live_options(place.profile));
    double now_s = 0;
    std::size_t most = 0;
    for (const Pose& pose : resample(path_of(options), session.ground(), 6)) {
        const View view = view_of(pose, session.terrain(), place.profile);
        FrameEntry entry;
        for (int frame = 0; frame < 60; ++frame) entry = update_frame(session, view, place.profile, now_s += 1.0 / 60);
        const std::vector<Triangle> expected = triangles_of(session.mesh());
        most = std::max(most, expected.size());
        for (io::LiveTerrain* terrain : {&from_file, &from_memory}) {
            const io::LiveFrame& frame = settle(*terrain, view, now_s);
            CHECK(frame.converged);
            CHECK(frame.cut.error_bound_px == entry.error_bound_px);
            CHECK(frame.cut.triangles_drawn == entry.triangles);
            CHECK(triangles_of(frame.mesh.mesh) == expected);
            CHECK(frame.short_of.empty());
            CHECK(frame.forgotten == 0);
        }
    }
    CHECK(most > 500);
    CHECK(from_file.file() != nullptr);
    CHECK(from_memory.file() == nullptr);
    CHECK(from_file.reader().pages > 0);
    CHECK(from_file.first_failure().empty());
    // Queries are any thread's, and are asked of the same ground.
    float there = 0;
    std::jthread([&] { there = static_cast<float>(ground_height(from_file.terrain(), 1000, 1000).height_m); }).join();
    CHECK(there == static_cast<float>(ground_height(from_memory.terrain(), 1000, 1000).height_m));
}

TEST_CASE("a terrain in one object takes stamps from any thread, shows them, and says what has changed") {
    const LivePlace place;
    io::LiveOptions options = live_options(place.profile);
    CHECK(io::LiveTerrain(place.pack, options).edits() == Edits{});
    options.edits = EditBudget{.blocks = 12};
    io::LiveTerrain terrain(place.pack, options);
    CHECK(terrain.memory_bytes() > io::LiveTerrain(place.pack, live_options(place.profile)).memory_bytes());
    const Terrain& t = terrain.terrain();
    const double x_m = t.extent_x_m() / 2, z_m = t.extent_z_m() / 2, spacing_m = t.spacing_x_m();
    const double top_m = terrain.pack().header.max_m;
    const View view = make_view({x_m, top_m + 20 * spacing_m, z_m}, {0, -1, 0.1}, {0, 1, 0}, 1, 640, 480, 1, 1e6);
    double now_s = 0;
    terrain.settings.cut.max_error_px = 0.1; // whatever is below the camera is loaded in full
    (void)settle(terrain, view, now_s);
    const double before_m = ground_height(t, x_m, z_m).height_m;

    Stamp crater;
    crater.shape = StampShape::crater;
    crater.x_m = x_m, crater.z_m = z_m;
    crater.radius_m = static_cast<float>(6 * spacing_m), crater.falloff_m = static_cast<float>(3 * spacing_m);
    crater.amount_m = 40;
    StampId id = 0;
    std::jthread([&] { REQUIRE(push_stamp(terrain.edits(), crater, id).ok()); }).join();
    CHECK(stamp_state(terrain.edits(), id).state == StampState::waiting);
    terrain.settings.edits.max_work = 2; // and many updates
    bool seen = false, short_of_work = false, unsettled = false;
    for (const Patience patience; patience.left();) {
        const io::LiveFrame& f = terrain.update({&view, 1}, now_s += 1.0 / 60);
        seen |= f.edits.applied == 1;
        unsettled |= !f.settled;
        for (const std::string_view field : f.short_of) short_of_work |= field == "EditSettings::max_work";
        if (f.settled) break;
    }
    CHECK((seen && short_of_work && unsettled));
    CHECK(terrain.frame().edits.loose == 0);
    CHECK(stamp_state(terrain.edits(), id).state == StampState::applied);
    CHECK(ground_height(t, x_m, z_m).height_m == Approx(before_m - 40).margin(5));
    // The mesh in the middle of the crater is the ground there.
    bool drawn = false;
    for (const MeshVertex& v : terrain.frame().mesh.mesh.vertices)
        drawn |= v.height_m != 0 && std::abs(t.x_m(v.column) - x_m) < spacing_m &&
                 std::abs(t.z_m(v.row) - z_m) < spacing_m &&
                 v.height_m == terrain_vertex(t, {v.column, v.row}).height_m;
    CHECK(drawn);

    std::uint64_t cursor = 0;
    bool lost = true, inside = false;
    GroundRect rects[32];
    const std::uint32_t changes = take_ground_changes(terrain.edits(), cursor, rects, lost);
    REQUIRE((changes > 0 && !lost));
    for (std::uint32_t i = 0; i < changes; ++i)
        inside |= t.x_m(rects[i].first.column) < x_m && t.x_m(rects[i].last.column) > x_m;
    CHECK(inside);

    crater.radius_m = static_cast<float>(60 * spacing_m); // more blocks than there are
    REQUIRE(push_stamp(terrain.edits(), crater, id).ok());
    terrain.settings.edits = {};
    bool short_of_blocks = false;
    for (const Patience patience; stamp_state(terrain.edits(), id).state == StampState::waiting && patience.left();)
        for (const std::string_view field : terrain.update({&view, 1}, now_s += 1.0 / 60).short_of)
            short_of_blocks |= field == "EditBudget::blocks";
    CHECK((short_of_blocks && stamp_state(terrain.edits(), id).state == StampState::refused));
    options.edits = EditBudget{.blocks = 0};
    CHECK(has_part(opening_refusal(place.pack, options), "EditBudget::blocks"));
}

TEST_CASE("a terrain that is opened with a journal has the ground that was left, however many stamps that took") {
    const LivePlace place(true);
    io::LiveOptions options = live_options(place.profile);
    options.edits = EditBudget{.blocks = 1, .stamps = 2}; // fewer than the journal has, and than it changes
    const std::string path = io::journal_path(place.pack);
    std::filesystem::remove(path);
    double x_m = 0, z_m = 0;
    View view;
    const auto height = [&] {
        io::LiveTerrain terrain(place.pack, options);
        const Terrain& t = terrain.terrain();
        x_m = t.extent_x_m() / 2, z_m = t.extent_z_m() / 2;
        view = make_view({x_m, terrain.pack().header.max_m + 20 * t.spacing_x_m(), z_m}, {0, -1, 0.1}, {0, 1, 0}, 1,
                         640, 480, 1, 1e6);
        terrain.settings.cut.max_error_px = 0.1;
        double now_s = 0;
        (void)settle(terrain, view, now_s);
        CHECK(terrain.frame().edits.waiting == 0);
        return ground_height(t, x_m, z_m).height_m;
    };
    const double before_m = height();
    {
        io::Journal journal(path, io::PackFile(place.pack).pack().header);
        Stamp raise;
        raise.x_m = x_m, raise.z_m = z_m, raise.radius_m = 100, raise.falloff_m = 2000, raise.amount_m = 2;
        const std::uint32_t layer = journal.add_layer("hill");
        for (int i = 0; i < 7; ++i) (void)journal.add_stamp(layer, io::KeptStamp(raise));
    }
    options.journal = path;
    CHECK(height() == Approx(before_m + 14).margin(0.5));
    options.edits.reset();
    CHECK(has_part(opening_refusal(place.pack, options), "LiveOptions::edits"));
    {
        io::Journal journal(path, io::PackFile(place.pack).pack().header);
        Stamp shaft;
        shaft.shape = StampShape::hole, shaft.x_m = x_m, shaft.z_m = z_m, shaft.radius_m = 100;
        (void)journal.add_stamp(journal.layers()[0].id, io::KeptStamp(shaft));
    }
    options.edits = EditBudget{};
    CHECK(has_part(opening_refusal(place.pack, options), "cuts holes: set EditBudget::holes"));
    REQUIRE(has_room_for_holes(io::PackFile(place.pack).pack().header));
    options.edits->holes = true;
    {
        io::LiveTerrain terrain(place.pack, options);
        double now_s = 0;
        (void)settle(terrain, view, now_s);
        CHECK(ground_height(terrain.terrain(), x_m, z_m).hole);
    }
    options.edits = EditBudget{}, options.journal = place.pack;
    CHECK(has_part(opening_refusal(place.pack, options), "is no journal"));
}

TEST_CASE("what changes far away is seen from there: its pages are loaded, though no view wants them") {
    const LivePlace place;
    io::LiveOptions options = live_options(place.profile);
    options.edits = EditBudget{};
    const io::LoadedPack whole = io::load_pack(place.pack, io::LoadTerrain::yes);
    for (const std::uint32_t page_slots : {8192u, 40u}) {
        options.page_slots = page_slots;
        io::LiveTerrain terrain(place.pack, options);
        const Terrain& t = terrain.terrain();
        const double across_m = t.extent_x_m(), x_m = across_m * 0.7, z_m = t.extent_z_m() * 0.6;
        const View view = make_view({across_m / 2, 10 * across_m, t.extent_z_m() / 2}, {0, -1, 0.001}, {0, 1, 0}, 1,
                                    640, 480, 1, 1e7);
        double now_s = 0;
        terrain.settings.cut.max_error_px = 4;
        (void)settle(terrain, view, now_s);
        REQUIRE(ground_height(t, x_m, z_m).error_m > t.header().quantum_m); // the full resolution is not there
        const double wanted_m = ground_height(whole.terrain, x_m, z_m).height_m + 30;
        Stamp stamp;
        stamp.shape = StampShape::raise;
        stamp.x_m = x_m, stamp.z_m = z_m;
        stamp.radius_m = static_cast<float>(5 * t.spacing_x_m());
        stamp.amount_m = 30;
        StampId id = 0;
        REQUIRE(push_stamp(terrain.edits(), stamp, id).ok());
        const io::LiveFrame& frame = settle(terrain, view, now_s);
        CAPTURE(page_slots, frame.edits.held);
        CHECK(frame.settled);
        CHECK(stamp_state(terrain.edits(), id).state == StampState::applied);
        // Its pages may go again. The ground that is left of it is what the report says of it.
        terrain.settings.cut.max_error_px = 1;
        (void)settle(terrain, view, now_s);
        const GroundHeight left = ground_height(t, x_m, z_m);
        CHECK(std::abs(left.height_m - wanted_m) <= static_cast<double>(left.error_m + t.header().quantum_m));
        terrain.settings.cut.max_error_px = 0.01; // now it is wanted in full
        const View near = make_view({x_m, wanted_m + 300, z_m}, {0, -1, 0.001}, {0, 1, 0}, 1, 640, 480, 1, 1e7);
        if (page_slots < 100) continue; // which is not enough for that
        (void)settle(terrain, near, now_s);
        CHECK(ground_height(t, x_m, z_m).height_m ==
              Approx(wanted_m).margin(static_cast<double>(t.header().quantum_m)));
    }
}

TEST_CASE("what does not suffice is a list of fields, and what a host has forgotten is a bit") {
    const LivePlace place;
    io::LiveOptions options = live_options(place.profile);
    options.cut.vertices = 300;
    options.settings.cut.max_error_px = 0.5;
    io::LiveTerrain terrain(place.pack, options);
    const double across_m = terrain.terrain().extent_x_m();
    const View view = make_view({across_m / 2, terrain.pack().header.max_m + across_m / 50, across_m / 2}, {0, -1, 0.1},
                                {0, 1, 0}, 1, 640, 480, 1, 1e6);
    bool short_of_vertices = false;
    const Patience patience;
    for (int frame = 0; (terrain.frame().forgotten != 3 || !short_of_vertices) && patience.left(); ++frame)
        for (const std::string_view field : terrain.update({&view, 1}, frame / 60.0).short_of)
            short_of_vertices |= field == "CutBudget::vertices";
    CHECK(short_of_vertices);
    CHECK(terrain.frame().forgotten == (io::live_map_commands | io::live_tile_maps));
}

TEST_CASE("a pack, a budget or a view that cannot be used is one line that names it") {
    const LivePlace place;
    io::LiveOptions options = live_options(place.profile);
    CHECK(opening_refusal(place.pack, options) == "opened");
    CHECK(has_part(opening_refusal(place.folder / "none.fjell", options), "none.fjell"));
    spit(place.folder / "text.fjell", std::string(5000, 'x'));
    CHECK(has_part(opening_refusal(place.folder / "text.fjell", options), "not a Fjell pack"));
    io::LiveOptions none = options;
    none.cut.vertices = 0;
    CHECK(has_part(opening_refusal(place.pack, none), "CutBudget::vertices"));
    none = options;
    none.page_slots = 0;
    CHECK(has_part(opening_refusal(place.pack, none), "page_slots"));
    none = options;
    none.stream.map_bytes = 0;
    CHECK(has_part(opening_refusal(place.pack, none),
                   "StreamBudget::map_bytes (the smallest mips of all tiles): raise the field, or lower"));
    io::LiveOptions much = options;
    much.stream.map_bytes = std::uint64_t{1} << 40;
    much.page_slots = 0xffff'ffff;
    CHECK(opening_refusal(place.pack, much) == "opened"); // no more than the pack has is made
    Random random(412);
    baker::BakeOptions linear = small_bake(5);
    linear.order = PageOrder::linear;
    (void)baker::bake(random_dem(random, 80, 80, Shape::fractal), linear, place.folder / "linear.fjell");
    CHECK(has_part(opening_refusal(place.folder / "linear.fjell", options), "linear order"));
    Profile recursive = place.profile;
    recursive.method = Method::recursive;
    CHECK_THROWS_WITH(live_options(recursive), Catch::Contains("refine.method"));

    io::LiveTerrain terrain(place.pack, options); // and is closed in its first frame
    View view = make_view({100, 500, 100}, {1, -0.5, 1}, {0, 1, 0}, 1, 640, 480, 1, 1e6);
    (void)terrain.update({&view, 1}, 0);
    view.near_m = -1;
    CHECK_THROWS_WITH(terrain.update({&view, 1}, 0), Catch::Contains("near_m"));
    view.near_m = 1;
    (void)terrain.update({&view, 1}, 0); // and goes on
}

TEST_CASE("damage that is met in flight is a count, a line and coarser ground, and the frames go on") {
    const LivePlace place;
    std::vector<std::byte> bytes = io::read_file(place.pack);
    Pack pack;
    REQUIRE(open_pack(bytes, pack).ok());
    const PackHeader& h = pack.header;
    for (std::uint64_t i = 0; i < h.directory_count; ++i)
        if (chunk_id(h, i).kind == ChunkKind::geometry && chunk_id(h, i).item != 0)
            bytes[pack.entry(i).offset] ^= std::byte{0x40};
    io::LiveTerrain terrain(bytes, "memory", live_options(place.profile));
    const double across_m = terrain.terrain().extent_x_m();
    const View view = make_view({across_m / 2, terrain.pack().header.max_m + across_m / 50, across_m / 2}, {0, -1, 0.1},
                                {0, 1, 0}, 1, 640, 480, 1, 1e6);
    double now_s = 0;
    const io::LiveFrame& frame = settle(terrain, view, now_s);
    CHECK(frame.settled);
    CHECK(frame.stream.failed > 0);
    CHECK_FALSE(frame.converged);
    CHECK(has_part(terrain.first_failure(), "memory: page "));
    CHECK(has_part(terrain.first_failure(), "damaged"));
    CHECK(terrain.update({&view, 1}, now_s).mesh.mesh.tiles.size() > 0);
}

TEST_CASE("a host overrides a profile by keys, as the editor names them") {
    Profile profile;
    set_profile_key(profile, "refine.max_error_px", "3.5");
    set_profile_key(profile, "refine.morph", "time");
    set_profile_key(profile, "budget.vertices", "70000");
    CHECK(profile.refine.max_error_px == 3.5);
    CHECK(profile.cut.morph == Morph::time);
    const io::LiveOptions options = live_options(profile);
    CHECK(options.cut.vertices == 70'000);
    CHECK(options.settings.cut.max_error_px == 3.5);
    // What the editor copies as C++ makes the same profile.
    std::istringstream lines(profile_as_cpp(profile));
    Profile made;
    int keys = 0;
    for (std::string line; std::getline(lines, line); ++keys) {
        std::smatch call;
        if (std::regex_match(line, call, std::regex(R"x(fjell::set_profile_key\(profile, "([^"]+)", "([^"]*)"\);)x")))
            set_profile_key(made, call[1].str(), call[2].str());
        else
            CHECK(line == "fjell::Profile profile;");
    }
    CHECK(keys == 4);
    CHECK(differing_keys(made, profile).empty());
    CHECK_THROWS_WITH(set_profile_key(profile, "refine.px", "1"), Catch::Contains("refine.px: unknown key"));
    CHECK_THROWS_WITH(set_profile_key(profile, "refine.max_error_px", "-1"),
                      Catch::Contains("refine.max_error_px: must be a number from 0.01 to 1000"));
    CHECK(profile.refine.max_error_px == 3.5);
}
