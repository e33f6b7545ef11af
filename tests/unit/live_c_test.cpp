// The terrain in one object for hosts in C: it shows what the one in C++ shows, and what is wrong is one line.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "fjell/io/journal.h"
#include "fjell/io/live_terrain.h"
#include "fjell/live_c.h"
#include "fjell/profile.h"
#include "fjell/query.h"
#include "io/file.h"
#include "support/patience.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr const char* c_profile = "[refine]\nmax_error_px = 2.5\n[budget]\nvertices = 60000\ntriangles = "
                                  "120000\n[stream]\nmap_mb = 4\ntail_log2 = 4\n";

FjellLiveOptions options_of(const char* path) {
    FjellLiveOptions o{};
    o.struct_size = sizeof o;
    o.path = path;
    o.profile_text = c_profile;
    return o;
}
FjellView view_of(double x, double y, double z) {
    FjellView view{};
    view.struct_size = sizeof view;
    REQUIRE(fjell_make_view({x, y, z}, {1, -0.4, 1}, {0, 1, 0}, 1, 640, 360, 1, 1e5, &view).code == FJELL_OK);
    return view;
}
// What opening is refused with.
std::string why_not(const FjellLiveOptions& options) {
    char why[300];
    FjellLive* const live = fjell_live_open(&options, why, sizeof why);
    CHECK(live == nullptr);
    fjell_live_close(live);
    CHECK(std::string(why).find('\n') == std::string::npos);
    return why;
}

struct CPlace {
    CPlace() {
        Random random(412);
        baker::BakeOptions bake = small_bake(6);
        bake.max_texture_log2 = 6;
        (void)baker::bake(random_dem(random, 200, 150, Shape::fractal), bake, pack);
    }
    TemporaryFolder folder;
    std::string pack = folder / "t.fjell";
};

} // namespace

TEST_CASE("a terrain opened from C, from a file or from memory, shows what one opened from C++ does") {
    const CPlace place;
    const std::vector<std::byte> bytes = io::read_file(place.pack);
    const Profile profile = parse_profile(c_profile, "test");
    io::LiveTerrain same(place.pack, live_options(profile));
    double now_s = 0;
    for (const bool in_memory : {false, true}) {
        FjellLiveOptions options = options_of(place.pack.c_str());
        if (in_memory) options.path = nullptr, options.pack = bytes.data(), options.pack_bytes = bytes.size();
        char why[300];
        FjellLive* const live = fjell_live_open(&options, why, sizeof why);
        INFO(why);
        REQUIRE(live != nullptr);
        for (int place_number = 0; place_number < 3; ++place_number) {
            const double x = 20.0 + 50 * place_number;
            const FjellView view = view_of(x, 720, 30);
            const View cpp = make_view({x, 720, 30}, {1, -0.4, 1}, {0, 1, 0}, 1, 640, 360, 1, 1e5);
            FjellLiveFrame frame{};
            frame.struct_size = sizeof frame;
            std::size_t commands = 0, tiles = 0, changed = 0;
            const Patience patience;
            for (int n = 0; n == 0 || (!frame.settled && patience.left()); ++n) {
                REQUIRE(fjell_live_update(live, &view, 1, now_s += 1.0 / 60, &frame).code == FJELL_OK);
                std::size_t count = 0;
                (void)fjell_live_take_map_commands(live, &count);
                commands += count;
                (void)fjell_live_tile_maps(live, FJELL_MAP_COLOUR, &tiles);
                const FjellCutChanges changes = fjell_live_take_changes(live);
                FjellRun run{};
                while (fjell_next_run(changes.vertex_bits, changes.vertex_words, changes.vertex_word_count, &run))
                    changed += run.count;
            }
            for (int n = 0; n == 0 || (!same.frame().settled && patience.left()); ++n) {
                (void)same.update({&cpp, 1}, now_s += 1.0 / 60);
                (void)same.take_map_commands();
            }
            CAPTURE(in_memory, place_number);
            CHECK(frame.converged);
            CHECK(frame.error_bound_px <= 2.5);
            CHECK(frame.short_of_count == 0);
            CHECK(frame.forgotten == 0);
            CHECK(changed != 0);
            CHECK(tiles == same.terrain().tile_count());
            CHECK((commands != 0 || place_number != 0));
            FjellCutReport report{};
            report.struct_size = sizeof report;
            CHECK(fjell_live_reports(live, &report, nullptr).code == FJELL_OK);
            CHECK(report.triangles == same.frame().cut.triangles);
            CHECK(frame.mesh.mesh.vertex_count == same.frame().mesh.mesh.vertices.size());
            const FjellTerrain terrain = fjell_live_terrain(live);
            CHECK(fjell_ground_height(terrain, x, 30, 0).height_m == ground_height(same.terrain(), x, 30).height_m);
        }
        CHECK(fjell_live_memory_bytes(live) > 100'000);
        fjell_live_first_failure(live, why, sizeof why);
        CHECK(std::string(why).empty());
        fjell_live_close(live);
    }
}

TEST_CASE("keys override a profile at opening, and those that are not fixed then, later") {
    const CPlace place;
    const FjellProfileKey keys[] = {{"refine.max_error_px", "9"}, {"budget.vertices", "20000"}};
    FjellLiveOptions options = options_of(place.pack.c_str());
    options.keys = keys, options.key_count = 2;
    char why[300];
    FjellLive* const live = fjell_live_open(&options, why, sizeof why);
    REQUIRE(live != nullptr);
    const FjellView view = view_of(300, 900, 300);
    FjellLiveFrame frame{};
    frame.struct_size = sizeof frame;
    REQUIRE(fjell_live_update(live, &view, 1, 0, &frame).code == FJELL_OK);
    CHECK(frame.mesh.mesh.vertex_count == 20'000);
    const auto asked_px = [&] {
        FjellCutReport report{};
        report.struct_size = sizeof report;
        CHECK(fjell_live_update(live, &view, 1, 0.1, nullptr).code == FJELL_OK);
        CHECK(fjell_live_reports(live, &report, nullptr).code == FJELL_OK);
        return report.error_px_requested;
    };
    CHECK(asked_px() == 9);
    CHECK(fjell_live_set(live, {"refine.max_error_px", "3.5"}, why, sizeof why));
    CHECK(asked_px() == 3.5);
    const auto refused = [&](FjellProfileKey key) {
        CHECK_FALSE(fjell_live_set(live, key, why, sizeof why));
        return std::string(why);
    };
    CHECK_THAT(refused({"refine.max_error_px", "-1"}), Catch::StartsWith("refine.max_error_px: must be a number"));
    CHECK_THAT(refused({"refine.max_eror_px", "1"}), Catch::Contains("unknown key"));
    CHECK_THAT(refused({"budget.vertices", "1000"}), Catch::Contains("is fixed at opening"));
    CHECK_THAT(refused({nullptr, "1"}), Catch::Contains("NULL"));
    CHECK(asked_px() == 3.5);
    fjell_live_close(live);
}

TEST_CASE("a host in C moves the ground of its terrain in one object, if it has asked to when it opened it") {
    const CPlace place;
    FjellLiveOptions options = options_of(place.pack.c_str());
    char why[300];
    FjellLive* const still = fjell_live_open(&options, why, sizeof why);
    REQUIRE(still != nullptr);
    CHECK(fjell_live_edits(still).object == nullptr);
    fjell_live_close(still);
    CHECK(fjell_live_edits(nullptr).object == nullptr);
    FjellEditBudget budget = fjell_edit_budget_default();
    options.edits = &budget;
    budget.blocks = 0;
    CHECK_THAT(why_not(options), Catch::Contains("EditBudget::blocks"));
    budget.blocks = 200;
    FjellLive* const live = fjell_live_open(&options, why, sizeof why);
    REQUIRE(live != nullptr);
    const FjellView view = view_of(300, 900, 300);
    FjellStamp mound = fjell_stamp_default();
    mound.x_m = 300, mound.z_m = 300, mound.radius_m = 60, mound.falloff_m = 60, mound.amount_m = 25;
    std::uint64_t id = 0;
    REQUIRE(fjell_push_stamp(fjell_live_edits(live), &mound, &id).code == FJELL_OK);
    FjellLiveFrame frame{};
    frame.struct_size = sizeof frame;
    CHECK(fjell_stamp_state(fjell_live_edits(live), id).state == FJELL_STAMP_STATE_WAITING);
    CHECK(fjell_live_update(live, &view, 1, 0, &frame).code == FJELL_OK); // live_terrain_test.cpp sees it applied
    CHECK(fjell_stamp_state(fjell_live_edits(live), id).status.code == FJELL_OK);
    std::uint64_t cursor = 0;
    FjellGroundRect rect;
    bool lost = true;
    CHECK(fjell_take_ground_changes(fjell_live_edits(live), &cursor, &rect, 1, &lost) <= 1);
    CHECK(!lost);
    fjell_live_close(live);
}

TEST_CASE("stamps that a host in C keeps are the ground of the next run, and any that it cannot keep are none") {
    const CPlace place;
    const std::string path = place.folder / "t.fjell.journal";
    FjellLiveOptions options = options_of(place.pack.c_str());
    options.journal = path.c_str();
    CHECK_THAT(why_not(options), Catch::Contains("FjellLiveOptions::journal: needs edits"));
    const FjellEditBudget budget = fjell_edit_budget_default();
    options.edits = &budget;
    char why[300];
    FjellStamp mounds[2] = {fjell_stamp_default(), fjell_stamp_default()};
    for (FjellStamp& mound : mounds) {
        mound.x_m = 80, mound.z_m = 60, mound.radius_m = 9, mound.falloff_m = 9, mound.amount_m = 4;
    }
    mounds[1].x_m = 30;
    const auto heights = [&](FjellLive* live) {
        const FjellTerrain terrain = fjell_live_terrain(live);
        return std::pair{fjell_ground_height(terrain, 80, 60, 0).height_m,
                         fjell_ground_height(terrain, 30, 60, 0).height_m};
    };
    const auto flown = [&] { // what it stands on when all is applied
        FjellLive* const live = fjell_live_open(&options, why, sizeof why);
        INFO(why);
        REQUIRE(live != nullptr);
        const FjellView view = view_of(80, 900, 60);
        FjellLiveFrame frame{};
        frame.struct_size = sizeof frame;
        const Patience patience;
        double now_s = 0;
        do {
            REQUIRE(fjell_live_update(live, &view, 1, now_s += 0.1, &frame).code == FJELL_OK);
        } while (!frame.settled && patience.left());
        const auto all = heights(live);
        fjell_live_close(live);
        return all;
    };
    const auto before = flown();
    CHECK_FALSE(std::filesystem::exists(path)); // nothing was kept

    FjellLive* const live = fjell_live_open(&options, why, sizeof why);
    REQUIRE(live != nullptr);
    const auto keeps = [&](const char* layer, const FjellStamp* stamps, std::size_t count) {
        return fjell_live_keep_stamps(live, layer, stamps, count, why, sizeof why);
    };
    CHECK(keeps("mounds", mounds, 2));
    CHECK(std::string(why).empty());
    const auto bytes = std::filesystem::file_size(path);
    mounds[1].amount_m = std::nanf("");
    CHECK_FALSE(keeps("mounds", mounds, 2)); // one of them is none, so neither is kept
    CHECK_THAT(why, Catch::Contains("amount_m"));
    CHECK_FALSE(keeps(nullptr, mounds, 1));
    CHECK_FALSE(keeps("mounds", nullptr, 1));
    mounds[0].struct_size = 3;
    CHECK_FALSE(keeps("mounds", mounds, 1));
    CHECK_THAT(why, Catch::Contains("FjellStamp::struct_size"));
    CHECK(std::filesystem::file_size(path) == bytes);
    CHECK_FALSE(fjell_live_keep_stamps(nullptr, "mounds", mounds, 0, why, sizeof why));
    FjellLive* const second = fjell_live_open(&options, why, sizeof why);
    REQUIRE(second != nullptr);
    mounds[0].struct_size = sizeof mounds[0];
    CHECK_FALSE(fjell_live_keep_stamps(second, "mounds", mounds, 1, why, sizeof why)); // the first one has it open
    CHECK_THAT(why, Catch::Contains(path));
    fjell_live_close(second);
    fjell_live_close(live);

    const auto after = flown();
    CHECK(after.first == Approx(before.first + 4).margin(0.1));
    CHECK(after.second == Approx(before.second + 4).margin(0.1));
    const io::Journal journal(path);
    CHECK(journal.layers().size() == 1);
    CHECK(journal.layers()[0].name == "mounds");
    CHECK(journal.layers()[0].stamps.size() == 2);
    options.journal = nullptr;
    CHECK(flown() == before);
    FjellLive* const without = fjell_live_open(&options, why, sizeof why);
    CHECK_FALSE(fjell_live_keep_stamps(without, "mounds", mounds, 1, why, sizeof why));
    CHECK_THAT(why, Catch::Contains("needs FjellLiveOptions::journal"));
    fjell_live_close(without);
}

TEST_CASE("what a host in C gets wrong is a status or one line, and nothing is left behind") {
    const CPlace place;
    FjellLiveOptions options = options_of((place.folder / "none.fjell").c_str());
    const std::string none = place.folder / "none.fjell";
    options.path = none.c_str();
    CHECK_THAT(why_not(options), Catch::Contains("none.fjell"));
    options.path = nullptr;
    CHECK_THAT(why_not(options), Catch::Contains("give a path, or a pack in memory"));
    options.pack = c_profile, options.pack_bytes = std::strlen(c_profile);
    CHECK_THAT(why_not(options), Catch::Contains("not a Fjell pack"));
    options = options_of(place.pack.c_str());
    options.profile_text = "[refine]\nmax_eror_px = 1\n";
    CHECK(why_not(options).starts_with("profile_text:2: refine.max_eror_px"));
    options.profile = none.c_str();
    CHECK_THAT(why_not(options), Catch::Contains("none.fjell"));
    options = options_of(place.pack.c_str());
    for (const char* const count : {"0", "3", "1099511627776"}) { // a capacity of 0, of too few, and of 2^40
        const FjellProfileKey key{"budget.vertices", count};
        options.keys = &key, options.key_count = 1;
        CHECK_FALSE(why_not(options).empty());
    }
    options.struct_size = sizeof options + 8;
    CHECK_THAT(why_not(options), Catch::Contains("struct_size"));
    char shorter[8] = "1234567";
    CHECK(fjell_live_open(nullptr, shorter, sizeof shorter) == nullptr);
    CHECK(std::string(shorter) == "FjellLi");
    CHECK(fjell_live_open(nullptr, nullptr, 0) == nullptr);

    options = options_of(place.pack.c_str());
    FjellLive* const live = fjell_live_open(&options, nullptr, 0);
    REQUIRE(live != nullptr);
    FjellView views[2] = {view_of(0, 900, 0), view_of(9, 900, 9)};
    CHECK(fjell_live_update(nullptr, views, 1, 0, nullptr).code == FJELL_INVALID_HANDLE);
    CHECK(fjell_live_update(live, views, 0, 0, nullptr).code == FJELL_OUT_OF_RANGE);
    CHECK(fjell_live_update(live, nullptr, 1, 0, nullptr).code == FJELL_OUT_OF_RANGE);
    CHECK(fjell_live_update(live, views, 2, 0, nullptr).code == FJELL_OUT_OF_RANGE);
    CHECK(std::string(fjell_live_update(live, views, 1, std::nan(""), nullptr).field) == "now_s");
    FjellLiveFrame frame{};
    frame.struct_size = sizeof frame + 1;
    CHECK(std::string(fjell_live_update(live, views, 1, 0, &frame).field) == "struct_size");
    views[0].near_m = -1;
    CHECK(fjell_live_update(live, views, 1, 0, nullptr).code == FJELL_OUT_OF_RANGE);
    views[0] = views[1];
    CHECK(fjell_live_update(live, views, 1, 0, nullptr).code == FJELL_OK);
    std::size_t count = 7;
    CHECK(fjell_live_tile_maps(live, 9, &count) == nullptr);
    CHECK(count == 0);
    CHECK(fjell_live_take_changes(nullptr).vertex_bits == nullptr);
    CHECK_FALSE(fjell_terrain_valid(fjell_live_terrain(nullptr)));
    fjell_live_close(live);
    fjell_live_close(nullptr);
}
