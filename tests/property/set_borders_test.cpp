// Where packs of a set meet: every map and every vertex is compared there as it is within one pack.
#include <catch2/catch.hpp>

#include <filesystem>

#include <fmt/format.h>

#include "baker/check/verify.h"
#include "baker/check/verify_maps.h"
#include "baker/pack/join.h"
#include "fjell/io/failure.h"
#include "support/set_scene.h"
#include "support/splat_rules.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr std::int32_t samples = 4 * 32 + 1; // tiles of 32 cells, four a side

baker::Dem square_field() {
    Random random(2201);
    baker::Dem dem = random_dem(random, samples, samples, Shape::fractal);
    dem.spacing_m[0] = dem.spacing_m[1] = 30;
    return dem;
}
// With all kinds of maps.
baker::BakeOptions options(const RulesFile& rules) {
    baker::BakeOptions o = small_bake(5);
    o.max_texture_log2 = 5;
    o.quantum_m = 0.1;
    o.horizon_spacing = 2;
    o.layers_path = rules.path();
    return o;
}

// A set of 2 x 2 packs of which each of two may be another bake's.
struct Mixed {
    explicit Mixed(const baker::Dem& dem, const baker::BakeOptions& of_all) { set_of(dem, of_all, "set"); }
    void set_of(const baker::Dem& dem, const baker::BakeOptions& how, const std::string& name) const {
        (void)baker::bake(dem, how, folder / (name + ".fjell"));
        (void)baker::split_pack(folder / (name + ".fjell"), folder / name, {2, 2});
    }
    // The pack to the north-east is that of another bake. set.json no longer says which it must be.
    void replace(const baker::Dem& dem, const baker::BakeOptions& how) const {
        set_of(dem, how, "other");
        spit(folder / "set/1-0.fjell", slurp(folder / "other/1-0.fjell"));
        io::SetFile index = io::parse_set_file(slurp(set + "/set.json"), "set");
        for (io::SetFilePack& pack : index.packs) pack.has_hash = false;
        spit(set + "/set.json", io::set_file_text(index));
    }
    TemporaryFolder folder;
    const std::string set = folder / "set";
};

} // namespace

TEST_CASE("where packs of a set meet as many texels and vertices are compared as within one pack, and agree") {
    const RulesFile rules;
    const Mixed mixed(square_field(), options(rules));
    const io::PackFile set(mixed.set), whole(mixed.folder / "set.fjell");
    REQUIRE(set.packs() == 4);
    const baker::MapsReport maps = baker::check_maps(set), of_whole = baker::check_maps(whole);
    CHECK(maps.first == "");
    CHECK(maps.ok());
    CHECK(maps.border_texels == of_whole.border_texels);
    CHECK(maps.border_texels > 0);
    const baker::VerifyReport report = baker::verify(set, nullptr);
    CHECK(report.first == "");
    CHECK(report.ok());
    CHECK(report.samples_compared == baker::verify(whole, nullptr).samples_compared);
}

TEST_CASE("packs whose borders differ are a set, and verify finds the seam, in the mesh and in each kind of map") {
    const RulesFile rules;
    const baker::Dem dem = square_field();
    const auto seam = [&](const baker::Dem& other, const baker::BakeOptions& how) {
        const Mixed mixed(dem, options(rules));
        mixed.replace(other, how);
        const io::PackFile set(mixed.set);
        return std::pair{baker::verify(set, nullptr), baker::check_maps(set)};
    };
    const auto raised = [&](std::int32_t x, std::int32_t y, float by_m) {
        baker::Dem other = dem;
        other.heights_m[other.index(x, y)] += by_m;
        return other;
    };
    const baker::MapsReport sound = seam(dem, options(rules)).second;
    {
        // A sample on the border of two packs, but no tile's corner, which the set itself would refuse.
        const auto [report, maps] = seam(raised(64, 17, 1), options(rules));
        CHECK(report.border_mismatches > 0);
    }
    {
        const auto [report, maps] = seam(raised(65, 17, 300), options(rules)); // beside it: slopes differ there
        CHECK(maps.normal_border_most > 2 * sound.normal_border_most);
        CHECK(maps.border_violations > 0);
    }
    {
        const auto [report, maps] = seam(raised(70, 17, 200), options(rules)); // stands over the horizon
        CHECK(maps.horizon_border_most > 2 * sound.horizon_border_most);
        CHECK(maps.border_violations > 0);
    }
    {
        baker::BakeOptions how = options(rules);
        how.ramp_path = rules.beside("ramp.json");
        spit(how.ramp_path, R"({"stops": [{"height_m": 0, "rgb": [255, 0, 0]}, {"height_m": 1, "rgb": [250, 0, 0]}]})");
        const auto [report, maps] = seam(dem, how);
        CHECK(report.ok());
        CHECK(maps.border_violations > 0);
        CHECK(maps.first.find("colour map") == 0);
    }
    {
        std::string text = splat_rules;
        text.replace(text.find("0.7"), 3, "0.1");
        const RulesFile other(text);
        const auto [report, maps] = seam(dem, options(other));
        CHECK(report.ok());
        CHECK(maps.border_violations > 0);
        CHECK(maps.first.find("splat map") == 0);
    }
}

namespace {

constexpr int apart_log2 = 7; // tiles of 128 cells: a page of coarse steps, one of step 2, four of step 1
constexpr std::int32_t apart_side = 1 << apart_log2;

// Heights of whole metres from 0 to 200, so that all parts are on one height scale: each has both ends of it.
baker::Dem ground(Random& random, std::int32_t tiles_x, std::int32_t tiles_y) {
    baker::Dem dem = random_dem(random, tiles_x * apart_side + 1, tiles_y * apart_side + 1, Shape::noise);
    const auto [least, most] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    const float low = *least, scale = 200 / (*most - *least);
    for (float& height : dem.heights_m) height = std::round((height - low) * scale);
    for (std::int32_t y = 40; y < dem.rows; y += apart_side)
        for (std::int32_t x = 50; x < dem.columns; x += apart_side)
            dem.heights_m[dem.index(x, y)] = 0, dem.heights_m[dem.index(x + 1, y)] = 200;
    dem.spacing_m[0] = dem.spacing_m[1] = 30;
    dem.crs_origin[0] = 500'000, dem.crs_origin[1] = 6'700'000;
    dem.crs_wkt = R"(LOCAL_CS["ground",UNIT["metre",1]])";
    dem.native_quantum_m = 1;
    return dem;
}
// A rectangle of its tiles, with the samples on the border to the next ones.
baker::Dem tiles_of_ground(const baker::Dem& whole, std::int32_t x, std::int32_t y, std::int32_t tiles_x,
                           std::int32_t tiles_y) {
    baker::Dem part = whole;
    part.columns = tiles_x * apart_side + 1;
    part.rows = tiles_y * apart_side + 1;
    part.heights_m.clear();
    for (std::int32_t row = 0; row < part.rows; ++row) {
        const auto from =
            whole.heights_m.begin() + static_cast<std::ptrdiff_t>(whole.index(x * apart_side, y * apart_side + row));
        part.heights_m.insert(part.heights_m.end(), from, from + part.columns);
    }
    part.crs_origin[0] += x * apart_side * part.spacing_m[0];
    part.crs_origin[1] -= y * apart_side * part.spacing_m[1];
    return part;
}

// What joining a folder is refused with; empty when it is not.
std::string join_refusal(const std::string& folder) {
    try {
        (void)baker::join_packs(folder);
    } catch (const io::Failure& f) {
        CHECK(f.exit_code == 1);
        CHECK(std::string(f.what()).find('\n') == std::string::npos);
        return f.what();
    }
    return {};
}

// Two packs side by side, which a test bakes into its folder.
struct Pair {
    explicit Pair(const baker::Dem& whole) {
        std::filesystem::create_directory(set);
        bake("west", tiles_of_ground(whole, 0, 0, 1, 1));
        bake("east", tiles_of_ground(whole, 1, 0, 1, 1));
    }
    void bake(const std::string& name, const baker::Dem& dem) const {
        (void)baker::bake(dem, small_bake(apart_log2), set + "/" + name + ".fjell");
    }
    [[nodiscard]] bool has_index() const { return std::filesystem::exists(set + "/set.json"); }
    TemporaryFolder folder;
    const std::string set = folder / "set";
};

} // namespace

TEST_CASE("packs of one bake agree where they meet, and joined they are the set that a split made") {
    Random random(501);
    for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear}) {
        baker::Dem dem = ground(random, 3, 2);
        dem.columns -= 30; // the last tiles end with the terrain
        dem.heights_m.resize(std::size_t(dem.columns) * std::size_t(dem.rows));
        add_random_holes(random, dem, apart_log2);
        for (std::int32_t y = 40; !dem.voids.empty() && y < dem.rows; y += apart_side) // no pack is all hole
            for (std::int32_t x = 50; x < dem.columns; x += apart_side) dem.voids[dem.index(x, y)] = 0;
        baker::BakeOptions how = small_bake(apart_log2);
        how.order = order;
        const TemporaryFolder folder;
        const std::string set = folder / "set";
        (void)baker::bake(dem, how, folder / "pack.fjell");
        (void)baker::split_pack(folder / "pack.fjell", set, {3, 2});
        const std::string index = slurp(set + "/set.json");
        std::filesystem::remove(set + "/set.json");
        CAPTURE(static_cast<int>(order));
        const baker::JoinSummary joined = baker::join_packs(set);
        CHECK(slurp(set + "/set.json") == index);
        CHECK(joined.set.packs == 6);
        CHECK(joined.borders.borders == 7);
        CHECK(joined.borders.vertices == 7 * (apart_side + 1));
        CHECK(joined.borders.bytes_read > 0);
        // Rows by rows a western side is in every page of its tile.
        if (order != PageOrder::linear) CHECK(joined.borders.bytes_read < 2 * joined.set.file_bytes);
        const io::PackFile file(set);
        CHECK(baker::verify(file, nullptr).ok());
    }
}

TEST_CASE("packs whose heights differ where they meet are not joined, and the line says which, where and by how much") {
    Random random(503);
    const baker::Dem whole = ground(random, 2, 1);
    const Pair pair(whole);
    baker::Dem east = tiles_of_ground(whole, 1, 0, 1, 1);
    east.heights_m[east.index(0, 77)] = 100;
    baker::Dem west = tiles_of_ground(whole, 0, 0, 1, 1);
    west.heights_m[west.index(apart_side, 77)] = 105;
    west.heights_m[west.index(apart_side, 30)] = 90;
    east.heights_m[east.index(0, 30)] = 91;
    pair.bake("east", east);
    pair.bake("west", west);
    const std::string said = join_refusal(pair.set);
    CAPTURE(said);
    CHECK(said.find("set/west.fjell and east.fjell: 2 of 129 heights on their border differ, most at sample (128, 77), "
                    "at (503840, 6697690): 105 m and 100 m; bake what both were baked from as one: fjell-bake plan") !=
          std::string::npos);
    CHECK(!pair.has_index());
    // An index by hand is opened, but where tiles' corners differ too.
    spit(pair.set + "/set.json",
         io::set_file_text({2 * apart_side + 1,
                            apart_side + 1,
                            apart_side,
                            {30, 30},
                            {{"west.fjell", 0, 0, 1, 1, 0, false}, {"east.fjell", 1, 0, 1, 1, 0, false}}}));
    CHECK(baker::verify(io::PackFile(pair.set), nullptr).border_mismatches > 0);
    for (float& height : east.heights_m) height = std::min(height + 5, 200.0f);
    east.heights_m[east.index(50, 40)] = 0;
    pair.bake("east", east);
    std::string opened;
    try {
        const io::PackFile file(pair.set);
    } catch (const io::Failure& f) {
        opened = f.what();
    }
    CHECK(opened.find("east.fjell: corners where tiles meet: not those of the packs beside it; ") != std::string::npos);
    CHECK(join_refusal(pair.set).find(" of 129 heights on their border differ, most at sample (128, ") !=
          std::string::npos);
}

TEST_CASE("of several borders that differ one is told, and how many more do") {
    Random random(510);
    const baker::Dem whole = ground(random, 3, 1);
    const Pair pair(whole);
    pair.bake("far", tiles_of_ground(whole, 2, 0, 1, 1));
    const std::string said = join_refusal(pair.set + "/");
    CAPTURE(said);
    CHECK(said.find("/set/west.fjell and east.fjell: ") != std::string::npos);
    CHECK(said.ends_with(" (one more border differs)"));
}

TEST_CASE("packs that meet in a single corner are no set where its heights differ") {
    Random random(509);
    const baker::Dem whole = ground(random, 2, 2);
    const Pair pair(whole);
    std::filesystem::remove(pair.set + "/east.fjell");
    baker::Dem south = tiles_of_ground(whole, 1, 1, 1, 1);
    pair.bake("south", south);
    CHECK(join_refusal(pair.set) == "");
    CHECK(pair.has_index());
    float& corner = south.heights_m[south.index(0, 0)];
    corner = corner < 100 ? corner + 1 : corner - 1;
    pair.bake("south", south);
    CHECK(join_refusal(pair.set).find("south.fjell: corners where tiles meet: not those of the packs beside it") !=
          std::string::npos);
}

TEST_CASE("packs of which one alone has a hole where they meet are not joined") {
    Random random(508);
    baker::Dem whole = ground(random, 2, 1);
    for (std::int32_t y = 0; y < whole.rows; ++y) // flat around the hole, so that heights under it are those beside it
        for (std::int32_t x = apart_side - 30; x < apart_side + 30; ++x) whole.heights_m[whole.index(x, y)] = 7;
    const Pair pair(whole);
    baker::Dem east = tiles_of_ground(whole, 1, 0, 1, 1);
    east.voids.assign(east.heights_m.size(), 0);
    east.voids[east.index(0, 60)] = 1;
    pair.bake("east", east);
    const std::string said = join_refusal(pair.set);
    CAPTURE(said);
    CHECK(said.find("1 of 129 holes on their border differ, most at sample (128, 60), at (503840, 6698200): a hole in "
                    "one of the two; bake what") != std::string::npos);
}

TEST_CASE("packs baked apart whose heights agree are not joined where an error holds for one of them only") {
    Random random(504);
    const Pair pair(ground(random, 2, 1));
    const std::string said = join_refusal(pair.set);
    CAPTURE(said);
    CHECK(said.find("west.fjell and east.fjell: ") != std::string::npos);
    CHECK(said.find(" of 129 errors on their border differ, most at sample (128, ") != std::string::npos);
    CHECK(said.find(", where heights agree; bake what") != std::string::npos);
    CHECK(!pair.has_index());
}

TEST_CASE("islands baked apart that meet in a flat sea are one set, one above the other and side by side") {
    Random random(505);
    baker::Dem whole = ground(random, 4, 4);
    // Land in the outer tiles, and not at their edges: radii are shared by squares, which reach a few samples further.
    for (std::int32_t y = 0; y < whole.rows; ++y)
        for (std::int32_t x = 0; x < whole.columns; ++x) {
            const auto land = [](std::int32_t v) {
                const std::int32_t tile = v / apart_side;
                return (tile == 0 || tile == 3) && v % apart_side > 40 && v % apart_side < apart_side - 40;
            };
            if (!land(x) || !land(y)) whole.heights_m[whole.index(x, y)] = 0;
        }
    const TemporaryFolder folder;
    for (const std::int32_t y : {0, 2})
        for (const std::int32_t x : {0, 2})
            (void)baker::bake(tiles_of_ground(whole, x, y, 2, 2), small_bake(apart_log2),
                              folder / fmt::format("{}{}.fjell", x, y));
    const baker::JoinSummary joined = baker::join_packs(folder.path);
    CHECK(joined.borders.borders == 4);
    CHECK(joined.borders.vertices == 4 * (2 * apart_side + 1));
    const io::PackFile file(folder.path);
    const baker::VerifyReport report = baker::verify(file, nullptr);
    CHECK(report.first == "");
    CHECK(report.ok());
}

TEST_CASE("a page along a border that is damaged is named, and a page that no other pack touches is not read") {
    Random random(506);
    const TemporaryFolder folder;
    const std::string set = folder / "set";
    (void)baker::bake(ground(random, 2, 1), small_bake(apart_log2), folder / "pack.fjell");
    (void)baker::split_pack(folder / "pack.fjell", set, {2, 1});
    const std::string east = set + "/1-0.fjell", good = slurp(east);
    const auto damaged = [&](std::uint32_t page) {
        std::string bytes = good;
        const io::PackFile file(folder / "set/1-0.fjell");
        const ChunkEntry entry = file.pack().entry(chunk_index(file.pack().header, {ChunkKind::geometry, 0, page}));
        bytes[entry.offset + 20] = static_cast<char>(bytes[entry.offset + 20] ^ 1);
        spit(east, bytes);
        const std::string said = join_refusal(set);
        spit(east, good);
        return said;
    };
    // Of step 1 there are two pages in the west, 2 and 4, and two in the east.
    for (const std::uint32_t page : {0u, 1u, 2u, 4u})
        CHECK(damaged(page).find(fmt::format("set/1-0.fjell: page {} of tile 0: the pack is damaged here", page)) !=
              std::string::npos);
    for (const std::uint32_t page : {3u, 5u}) CHECK(damaged(page) == "");
    spit(east, good.substr(0, good.size() / 2));
    CHECK(join_refusal(set).find("set/1-0.fjell: ") != std::string::npos);
}

TEST_CASE("packs that overlap, lie off each other's tiles or are of other scales are not joined, and named") {
    Random random(507);
    const baker::Dem whole = ground(random, 2, 1);
    const Pair pair(whole);
    const auto refused_with_east = [&](const baker::Dem& dem, const std::string& what) {
        pair.bake("east", dem);
        const std::string said = join_refusal(pair.set);
        CAPTURE(said, what);
        CHECK(said.find(what) != std::string::npos);
        CHECK(!pair.has_index());
    };
    baker::Dem east = tiles_of_ground(whole, 1, 0, 1, 1);
    east.crs_origin[0] -= 30;
    refused_with_east(east, "west.fjell and east.fjell: lie 0.992188 tiles apart from west to east; packs of a set");
    refused_with_east(tiles_of_ground(whole, 0, 0, 1, 1),
                      "east.fjell and west.fjell: both have tile (0, 0) of the set");
    east = tiles_of_ground(whole, 1, 0, 1, 1);
    east.crs_origin[0] += 1e12;
    refused_with_east(east, "east.fjell: lies ");
    east = tiles_of_ground(whole, 1, 0, 1, 1);
    for (float& height : east.heights_m) height += 3;
    refused_with_east(east, "height scale: not that of");
    std::filesystem::remove(pair.set + "/west.fjell");
    std::filesystem::remove(pair.set + "/east.fjell");
    CHECK(join_refusal(pair.set).find("set: has no packs (*.fjell)") != std::string::npos);
    CHECK(join_refusal(pair.set + "/none").find("cannot be listed") != std::string::npos);
    spit(pair.set + "/two\nlines.fjell", "");
    CHECK(join_refusal(pair.set).find("set: has a pack whose name is no line of text; rename it") != std::string::npos);
}
