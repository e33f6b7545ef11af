// Stamps as JSON: what is read is what was written, and what cannot be a stamp is refused with its line, its number and
// the field.
#include <catch2/catch.hpp>

#include <cmath>
#include <random>
#include <set>
#include <string>
#include <utility>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/stamp_blocks.h"
#include "io/stamps.h"
#include "shared/stamp.h"

using namespace fjell;
using namespace fjell::session;

namespace {

std::string stamp_refusal(const std::string& stamp) {
    try {
        (void)io::parse_stamps("{\"stamps\": [\n" + stamp + "\n]}", "s.json");
    } catch (const io::Failure& failure) {
        return failure.exit_code == 1 ? failure.what() : "another exit code";
    }
    return "";
}

} // namespace

TEST_CASE("the example of stamps is read as it is written, and comes back the same when it is written and read") {
    const std::string path = FJELL_SOURCE_DIR "/content/edits/craters.json";
    const std::vector<io::TimedStamp> stamps = io::parse_stamps(io::read_text(path), path);
    REQUIRE(stamps.size() > 3);
    int craters = 0, paths = 0;
    for (std::size_t i = 0; i < stamps.size(); ++i) {
        const Stamp s = stamps[i].what.stamp();
        CHECK((i == 0 || stamps[i - 1].frame <= stamps[i].frame));
        craters += s.shape == StampShape::crater && s.radius_m > 0 && s.amount_m > 0;
        paths += s.shape == StampShape::path && s.point_count > 1 && s.points == stamps[i].what.points.data();
    }
    CHECK((craters > 1 && paths == 1));
    const std::string text = io::write_stamps(stamps);
    CHECK(io::write_stamps(io::parse_stamps(text, "written")) == text);
}

TEST_CASE("stamps keep every field of their shape, and are sorted by frame") {
    const std::string text = R"({"comment": "all", "stamps": [
      {"frame": 7, "shape": "noise", "at": [1.5, -2], "radius_m": 3.25, "falloff_m": 4, "amount_m": -5,
       "wavelength_m": 6, "seed": 4294967295, "morph_s": 0.5},
      {"shape": "level", "at": [1, 2], "radius_m": 3, "height_m": -7, "slope_x": 0.25, "slope_z": -0.5},
      // the rectangle alone
      {"frame": 2, "shape": "heights", "first": [-1, 4], "columns": 3, "rows": 2, "heights_m": [1, 2, null, 4, 5, 6],
       "mask": [0, 255, 1, 2, 3, 4]},
      {"frame": 2, "shape": "restore", "first": [0, 0], "columns": 9, "rows": 9},
      {"frame": 8, "shape": "paint", "at": [1, 2], "radius_m": 3, "rgb": [255, 0, 7], "material": 15, "strength": 0.5},
      {"frame": 9, "shape": "unpaint", "points": [[1, 2], [3, 4.5]], "radius_m": 3},
      {"frame": 10, "shape": "lock", "points": [[1, 2], [3, 4.5]], "radius_m": 3, "amount_m": 0.25},
      {"frame": 11, "shape": "unlock", "at": [1, 2], "radius_m": 0}]})";
    const std::vector<io::TimedStamp> stamps = io::parse_stamps(text, "s.json");
    REQUIRE(stamps.size() == 8);
    const Stamp paint = stamps[4].what.stamp(), unpaint = stamps[5].what.stamp();
    CHECK((paint.rgb[0] == 255 && paint.rgb[1] == 0 && paint.rgb[2] == 7 && paint.material == 15 &&
           paint.strength == 0.5f));
    CHECK((unpaint.shape == StampShape::unpaint && unpaint.point_count == 2 && unpaint.points[1].z_m == 4.5));
    CHECK((unpaint.strength == 1 && unpaint.material == no_material));
    const Stamp lock = stamps[6].what.stamp(), unlock = stamps[7].what.stamp();
    CHECK((lock.shape == StampShape::lock && lock.amount_m == 0.25f && lock.point_count == 2 && lock.radius_m == 3));
    CHECK((unlock.shape == StampShape::unlock && unlock.x_m == 1 && unlock.z_m == 2 && unlock.amount_m == 0));
    const Stamp level = stamps[0].what.stamp(), heights = stamps[1].what.stamp(), restore = stamps[2].what.stamp(),
                noise = stamps[3].what.stamp();
    CHECK((stamps[0].frame == 0 && stamps[1].frame == 2 && stamps[2].frame == 2 && stamps[3].frame == 7));
    CHECK((level.height_m == -7 && level.slope_x == 0.25f && level.slope_z == -0.5f && level.falloff_m == 0));
    CHECK((heights.first.column == -1 && heights.first.row == 4 && heights.columns == 3 && heights.rows == 2));
    CHECK((heights.heights_m[1] == 2 && std::isnan(heights.heights_m[2]) && heights.mask[1] == 255));
    CHECK((restore.shape == StampShape::restore && restore.columns == 9 && restore.heights_m == nullptr &&
           restore.mask == nullptr));
    CHECK((noise.x_m == 1.5 && noise.z_m == -2 && noise.radius_m == 3.25f && noise.falloff_m == 4 &&
           noise.amount_m == -5 && noise.wavelength_m == 6 && noise.seed == 4294967295u && noise.morph_s == 0.5f));
    CHECK((level.morph_s == 0 && heights.morph_s == 0));
    const std::string written = io::write_stamps(stamps);
    CHECK(io::write_stamps(io::parse_stamps(written, "written")) == written);
}

TEST_CASE("blocks of stamps are all that a sample changes in, and not many more") {
    std::mt19937 random(5);
    const auto number = [&](double least, double most) {
        return std::uniform_real_distribution<double>(least, most)(random);
    };
    PackHeader pack{};
    pack.columns = 500, pack.rows = 400;
    pack.spacing_m[0] = 2, pack.spacing_m[1] = 3;
    const edit::StampGrid grid(500, 400, pack.spacing_m);
    std::size_t all = 0, counted = 0;
    for (int round = 0; round < 75; ++round) {
        io::KeptStamp kept;
        Stamp& s = kept.plain;
        const int kind = round % 5;
        s.shape = kind == 0   ? StampShape::path
                  : kind == 1 ? StampShape::paint
                  : kind == 4 ? StampShape::lock
                              : StampShape::raise;
        s.radius_m = static_cast<float>(number(0, 60)), s.falloff_m = static_cast<float>(number(0, 30));
        s.x_m = number(-100, 1100), s.z_m = number(-100, 1300), s.amount_m = 1;
        if (kind < 2 || (kind == 4 && round % 2 == 0))
            for (int i = 0; i < 4; ++i) kept.points.push_back({number(-200, 1200), number(-200, 1400), 5});
        if (kind == 3) {
            s.first = {static_cast<std::int32_t>(number(-20, 480)), static_cast<std::int32_t>(number(-20, 380))};
            s.columns = 60, s.rows = 40, s.radius_m = 0;
            s.shape = StampShape::heights;
            kept.heights_m.assign(2400, 7);
        }
        io::StampBlocks blocks(pack);
        blocks.add(kept);
        const bool locks = s.shape == StampShape::lock;
        std::set<std::pair<int, int>> changed;
        for (std::int32_t y = 0; y < 400; ++y)
            for (std::int32_t x = 0; x < 500; ++x)
                if (edit::samples_of(grid, kept.stamp()).contains(SampleIndex{x, y}) &&
                    (locks ? edit::locks_sample(grid, kept.stamp(), {x, y})
                           : edit::stamp_weight(grid, kept.stamp(), {x, y}) > 0))
                    changed.insert({x / 32, y / 32});
        const std::uint32_t count = locks                          ? blocks.locks()
                                    : s.shape == StampShape::paint ? blocks.paint()
                                                                   : blocks.heights();
        CAPTURE(round);
        CHECK(blocks.paint() + blocks.heights() + blocks.locks() == count);
        CHECK(count >= changed.size());
        all += changed.size(), counted += count;
    }
    CHECK((all > 500 && counted < all * 3 / 2));

    // A stamp that would take all memory is left out, and those beside it are not.
    pack.columns = pack.rows = 1u << 20;
    io::KeptStamp small, whole;
    small.plain.radius_m = 50, whole.plain.radius_m = 1e9f;
    io::StampBlocks blocks(pack);
    blocks.add(small);
    const std::uint32_t of_small = blocks.heights();
    CHECK(of_small > 0);
    blocks.add(whole);
    CHECK(blocks.heights() == of_small);
}

TEST_CASE("a stamp that cannot be one is refused with its line, its number and the field") {
    const std::string crater = R"({"shape": "crater", "at": [1, 2], "radius_m": 3, "amount_m": 4})";
    CHECK(stamp_refusal(crater).empty());
    CHECK(stamp_refusal(crater + ",\n{\"shape\": \"tunnel\"}")
              .starts_with("s.json:3: stamp 1: \"shape\" must be one of "
                           "raise, level, crater,"));
    const auto refused = [](const std::string& stamp, const std::string& part) {
        const std::string what = stamp_refusal(stamp);
        INFO(stamp << "\n" << what);
        CHECK(what.starts_with("s.json:2: stamp 0: "));
        CHECK(what.find(part) != std::string::npos);
        CHECK(what.find("content/edits/craters.json") != std::string::npos);
    };
    refused("[]", "must be an object");
    refused(R"({"shape": "crater", "at": [1, 2], "radius_m": 0, "amount_m": 4})", "\"radius_m\" of a crater");
    refused(R"({"shape": "crater", "at": [1, 2], "radius_m": 1e-60, "amount_m": 4})", "\"radius_m\" of a crater");
    refused(R"({"shape": "crater", "at": [1, 2], "radius_m": -3, "amount_m": 4})", "\"radius_m\" must hold numbers in");
    refused(R"({"shape": "crater", "at": [1, 2e9], "radius_m": 3, "amount_m": 4})", "\"at\" must hold numbers in");
    refused(R"({"shape": "crater", "at": [1], "radius_m": 3, "amount_m": 4})", "\"at\" must be a list of 2");
    refused(R"({"shape": "crater", "at": [1, 2], "radius_m": 3})", "\"amount_m\" is missing");
    refused(R"({"shape": "crater", "at": [1, 2], "radius_m": 3, "amount_m": 4, "height_m": 1})",
            "\"height_m\" is no field of a stamp of shape crater");
    refused(R"({"frame": -1, "shape": "smooth", "at": [1, 2], "radius_m": 3})", "\"frame\" must hold whole numbers");
    refused(R"({"frame": 1.5, "shape": "smooth", "at": [1, 2], "radius_m": 3})", "\"frame\" must hold whole numbers");
    refused(R"({"shape": "smooth", "radius_m": 3})", "\"at\" is missing");
    refused(R"({"shape": "noise", "at": [1, 2], "radius_m": 3, "amount_m": 4, "wavelength_m": 0})", "\"wavelength_m\"");
    refused(R"({"shape": "path", "radius_m": 3, "points": [[1, 2, 3]]})", "\"points\" must be a list of 2 to 256");
    refused(R"({"shape": "path", "radius_m": 3, "points": [[1, 2, 3], [1, 2]]})", "points: [x, z, height]");
    refused(R"({"shape": "heights", "first": [0, 0], "columns": 2, "rows": 2, "heights_m": [1, 2, 3]})",
            "\"heights_m\" must be a list of 4");
    refused(R"({"shape": "heights", "first": [0, 0], "columns": 2, "heights_m": [1, 2]})", "\"rows\" is missing");
    const std::string paint = R"({"shape": "paint", "at": [1, 2], "radius_m": 3, "rgb": )";
    CHECK(stamp_refusal(paint + "[1, 2, 3]}").empty());
    refused(R"({"shape": "paint", "at": [1, 2], "radius_m": 3})", "\"rgb\" is missing");
    refused(paint + "[1, 2]}", "\"rgb\" must be a list of 3");
    refused(paint + "[1, 2, 256]}", "\"rgb\" must hold whole numbers in 0..255");
    refused(paint + "[1, 2, 3], \"strength\": 1.1}", "\"strength\" must hold numbers in 0..1");
    refused(paint + "[1, 2, 3], \"material\": 16}", "\"material\" must hold whole numbers in 0..15");
    refused(paint + "[1, 2, 3], \"morph_s\": 1}", "\"morph_s\" is no field");
    refused(R"({"shape": "unpaint", "points": [[1, 2], [3, 4]]})", "\"radius_m\" is missing");
    refused(R"({"shape": "unpaint", "points": [[1, 2, 3], [3, 4, 5]], "radius_m": 1})", "points: [x, z]");
    refused(R"({"shape": "lock", "at": [1, 2], "radius_m": 3})", "\"amount_m\" is missing");
    refused(R"({"shape": "lock", "at": [1, 2], "radius_m": 3, "amount_m": -1})",
            "\"amount_m\" must hold numbers in 0..");
    refused(R"({"shape": "lock", "at": [1, 2], "radius_m": 3, "amount_m": 1, "falloff_m": 1})",
            "\"falloff_m\" is no field");
    refused(R"({"shape": "unlock", "at": [1, 2], "radius_m": 3, "amount_m": 1})", "\"amount_m\" is no field");
    refused(R"({"shape": "restore", "first": [0, 0], "columns": 1, "rows": 1, "mask": [256]})", "\"mask\" must hold");
    for (const char* file :
         {"[]", "{}", R"({"stamps": []})", R"({"stamps": 1})", R"({"stamps": [], "more": 1})", "{"}) {
        try {
            (void)io::parse_stamps(file, "s.json");
            FAIL("taken: " << file);
        } catch (const io::Failure& failure) {
            CHECK(std::string(failure.what()).starts_with("s.json"));
        }
    }
}
