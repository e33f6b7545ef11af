// fjell-bake roads and rivers: lines of files that GDAL makes, laid on a pack as a layer of its journal, flown, baked,
// switched off, put in place of each other, refused.
#include <nlohmann/json.hpp>

#include "system/bake_cli.h"

using namespace fjell::test;

namespace {

using nlohmann::json;

json lines_of(const std::vector<json>& lines, const json& properties = json::object()) {
    json features = json::array();
    for (const json& line : lines)
        features.push_back({{"type", "Feature"},
                            {"properties", properties},
                            {"geometry", {{"type", "LineString"}, {"coordinates", line}}}});
    return {{"type", "FeatureCollection"}, {"features", features}};
}

// Hills in UTM zone 33, 2 m from sample to sample, and roads over them in degrees.
struct RoadPlace {
    RoadPlace() {
        json recipe = json::parse(slurp(FJELL_SOURCE_DIR "/content/terrain/hills.json"));
        recipe["columns"] = recipe["rows"] = 257;
        spit(folder / "hills.json", recipe.dump());
        (void)output_of(folder, bake + "synth hills.json -o plain.tif");
        (void)output_of(folder, "gdal_translate -q -a_srs EPSG:32633 -a_ullr 500000 5000000 500514 4999486 plain.tif "
                                "dem.tif");
        (void)output_of(folder, bake + "dem.tif -o hills.fjell --tile 128 --quiet");
        (void)output_of(folder, bake + "plain.tif -o plain.fjell --tile 64 --quiet");
        spit(folder / "metres.json", lines_of({{{500050, 4999950}, {500250, 4999700}, {500420, 4999600}},
                                               {{500250, 4999700}, {500200, 4999500}}})
                                         .dump());
        (void)output_of(folder, "ogr2ogr -f GeoJSON -lco COORDINATE_PRECISION=12 -s_srs EPSG:32633 -t_srs EPSG:4326 "
                                "degrees.geojson metres.json && "
                                "ogr2ogr -f GPKG -a_srs EPSG:32633 roads.gpkg metres.json -nln roads && "
                                "ogr2ogr -f 'ESRI Shapefile' -s_srs EPSG:32633 -t_srs EPSG:3857 roads.shp metres.json");
    }
    [[nodiscard]] json made(const std::string& arguments) const {
        return json::parse(output_of(folder, bake + arguments + " --json -"));
    }
    // A hash of all heights.
    [[nodiscard]] std::size_t heights(const std::string& edits = "", const std::string& pack = "hills.fjell") const {
        (void)output_of(folder, bake + "heights " + pack + " " + edits + " -o heights.tif");
        const std::string bytes = slurp(folder / "heights.tif");
        std::filesystem::remove(folder / "heights.tif");
        return std::hash<std::string>{}(bytes);
    }
    TemporaryFolder folder;
};
const RoadPlace& road_place() {
    static const RoadPlace place;
    return place;
}
const std::string with_journal = "--edits hills.fjell.journal";

} // namespace

TEST_CASE("roads of a GeoPackage, a GeoJSON in degrees and a Shapefile in a third CRS are the same roads") {
    const RoadPlace& place = road_place();
    const std::size_t before = place.heights();
    std::size_t first = 0;
    for (const std::string file : {"roads.gpkg", "degrees.geojson", "roads.shp"}) {
        std::filesystem::remove(place.folder / "hills.fjell.journal");
        const json said = place.made("roads hills.fjell " + file + " --max-grade 0.05");
        CAPTURE(file, said.dump());
        CHECK((said["lines"] == 2 && said["layer"] == "roads" && said["stamps"] > 4));
        CHECK(std::abs(said["length_m"].get<double>() - (320.156 + 197.231 + 206.155)) < 0.5);
        CHECK(said["steepest_grade"].get<double>() <= 0.05 + 1e-9);
        CHECK(said["steepest_grade_before"].get<double>() > 0.05);
        if (first == 0) first = place.heights(with_journal);
        // A line that was straight in another CRS has stations of its own, so the profile meets other bumps.
        (void)output_of(place.folder, bake + "heights hills.fjell " + with_journal + " -o now.tif");
        if (file == "roads.gpkg") std::filesystem::copy_file(place.folder / "now.tif", place.folder / "first.tif");
        (void)output_of(place.folder,
                        "gdal_translate -q -of XYZ now.tif now.xyz && gdal_translate -q -of XYZ first.tif "
                        "first.xyz && paste -d' ' now.xyz first.xyz | awk '{d=$3-$6; if(d<0)d=-d; "
                        "if(d>m)m=d} END {print m; exit !(m<0.25)}'");
    }
    CHECK(first != before);
    // Switched off the ground is the pack's; on again it is the roads'.
    (void)output_of(place.folder, bake + "journal hills.fjell --off roads --quiet");
    CHECK(place.heights(with_journal) == before);
    (void)output_of(place.folder, bake + "journal hills.fjell --on roads --quiet");
    CHECK(place.heights(with_journal) != before);
    for (const char* const name : {"first.tif", "now.tif", "first.xyz", "now.xyz", "hills.fjell.journal"})
        std::filesystem::remove(place.folder / name);
}

TEST_CASE("a layer is refused where it is there, replaced in its place, and laid on the layers below") {
    const RoadPlace& place = road_place();
    const auto layers = [&] { return place.made("journal hills.fjell")["layers"]; };
    (void)place.made("roads hills.fjell roads.gpkg --layer tracks --width-m 3 --paint 806040");
    refused(place.folder, bake + "roads hills.fjell roads.gpkg --layer tracks", 1, "--replace");
    const std::size_t narrow = place.heights(with_journal);
    (void)place.made("rivers hills.fjell degrees.geojson --depth-m 3");
    const std::size_t both = place.heights(with_journal);
    CHECK(both != narrow);
    (void)place.made("roads hills.fjell roads.gpkg --layer tracks --replace --width-m 60");
    json now = layers();
    CHECK((now.size() == 2 && now[0]["name"] == "tracks" && now[1]["name"] == "rivers"));
    CHECK(place.heights(with_journal) != both);
    // Below the river as it was: the same stamps again.
    (void)place.made("roads hills.fjell roads.gpkg --layer tracks --replace --width-m 3 --paint 806040");
    CHECK(place.heights(with_journal) == both);
    // A river on the ground as it is without roads is another one.
    (void)output_of(place.folder, bake + "journal hills.fjell --remove rivers --off tracks --quiet");
    (void)place.made("rivers hills.fjell degrees.geojson --depth-m 3");
    (void)output_of(place.folder, bake + "journal hills.fjell --on tracks --move tracks=0 --quiet");
    CHECK(place.heights(with_journal) != both);
    std::filesystem::remove(place.folder / "hills.fjell.journal");
}

TEST_CASE("a journal with a long network is flown and baked as it is, whatever blocks it takes") {
    const TemporaryFolder folder;
    json recipe = json::parse(slurp(FJELL_SOURCE_DIR "/content/terrain/hills.json"));
    recipe["columns"] = 1400, recipe["rows"] = 1100;
    spit(folder / "hills.json", recipe.dump());
    (void)output_of(folder, bake + "synth hills.json -o dem.tif && " + bake + "dem.tif -o hills.fjell --quiet");
    json lines = json::array();
    for (int y = 20; y < 1100; y += 24) lines.push_back({{5, -y}, {1390, -y}});
    spit(folder / "net.json", lines_of(lines).dump());
    const json said = json::parse(output_of(folder, bake + "roads hills.fjell net.json --paint 606060 --json -"));
    CHECK(said["length_m"] > 60e3);
    CHECK(said["stamps"] > 1024 + 45); // in as many blocks, more than a flight has by itself
    const std::string fly = no_pixels + FJELL_BIN_DIR "/fjell-fly hills.fjell --headless --frames 2 --size 320x200 " +
                            with_journal + " --json flight.json ";
    const Run few = run_in(folder.path, fly + "--edit-blocks 1024");
    CHECK((few.code == 1 && few.err.find("EditBudget::blocks") != std::string::npos));
    (void)output_of(folder, fly);
    const json flown = json::parse(slurp(folder / "flight.json"))["edits"];
    CHECK((flown["refused"] == 0 && flown["waiting"] == 0 && flown["blocks"] > 1024));
    (void)output_of(folder, bake + "hills.fjell " + with_journal + " -o dug.fjell --quiet && " + bake +
                                "heights hills.fjell " + with_journal + " -o dug.tif && " + bake +
                                "verify dug.fjell --against dug.tif --quiet");
}

TEST_CASE("attributes count more than options, one layer of a file can be taken, and no CRS means metres") {
    const RoadPlace& place = road_place();
    const auto width = [&](const json& properties, const std::string& options = "") {
        spit(place.folder / "one.geojson", lines_of({{{20, -100}, {240, -110}}}, properties).dump());
        const json said = place.made("roads plain.fjell one.geojson --shoulder-m 0 " + options);
        std::filesystem::remove(place.folder / "plain.fjell.journal");
        return said["samples"].get<double>() / said["length_m"].get<double>();
    };
    const std::string steep = "--cut-slope 100 --fill-slope 100 --max-grade 10 --smooth-m 0 ";
    CHECK(std::abs(width({{"width", "20 m"}}, steep) - 20) < 1.5);
    CHECK(std::abs(width({{"width", "20 m"}, {"width_m", 10}}, steep) - 10) < 1.5);
    CHECK(std::abs(width({}, steep + "--width-m 15") - 15) < 1.5);
    refused(place.folder, bake + "roads plain.fjell one.geojson --max-grade nan", 2, "must be a number");
    spit(place.folder / "one.geojson", lines_of({{{20, -100}, {240, -110}}}, {{"width_m", 0}}).dump());
    refused(place.folder, bake + "roads plain.fjell one.geojson", 1, "a line says width_m 0, which may be 0.1 to 1000");
    (void)output_of(place.folder, "cp roads.gpkg two.gpkg && ogr2ogr -f GPKG -update -a_srs EPSG:32633 two.gpkg "
                                  "one.geojson -nln others");
    CHECK(place.made("roads hills.fjell two.gpkg --from roads")["lines"] == 2);
    std::filesystem::remove(place.folder / "hills.fjell.journal");
    refused(place.folder, bake + "roads hills.fjell two.gpkg --from rails", 1, "its layers are roads, others");
}

TEST_CASE("what cannot be laid is refused in one line, and nothing is written") {
    const RoadPlace& place = road_place();
    const auto refuse = [&](const std::string& file, const std::string& says, const std::string& options = "",
                            int code = 1) {
        spit(place.folder / "bad.geojson", file);
        refused(place.folder, bake + "roads plain.fjell bad.geojson " + options, code, says);
        refused(place.folder, bake + "rivers plain.fjell bad.geojson " + options, code, says);
    };
    const std::string good = lines_of({{{20, -100}, {240, -110}}}).dump();
    refuse("", "is no file of lines");
    refuse("{", "is no file of lines");
    refuse(lines_of({}).dump(), "has no lines");
    refuse(R"({"type": "Point", "coordinates": [5, -5]})", "has no lines");
    refuse(lines_of({{{-500, 5}, {900, 7}}, {{1000, -1000}, {2000, -1000}}}).dump(),
           "none of its 2 lines lies on the terrain");
    refuse(lines_of({{{50, -50}, {50, -50}}}).dump(), "none of its 1 lines");
    refuse(good, "--width-m", "--width-m 0", 2);
    refuse(good, "--width-m", "--width-m nan", 2);
    refuse(good, "six hexadecimal digits", "--paint red", 2);
    refuse(good, "has no splat maps", "--material asphalt");
    refuse(good, "would overwrite", "--json plain.fjell", 2);
    refused(place.folder, bake + "roads nothing.fjell bad.geojson", 1, "nothing.fjell");
    refused(place.folder, bake + "roads plain.fjell nothing.geojson", 1, "nothing.geojson");
    // Another pack's journal.
    (void)place.made("roads hills.fjell roads.gpkg");
    const std::string journal = slurp(place.folder / "hills.fjell.journal");
    refused(place.folder, bake + "roads plain.fjell bad.geojson --journal hills.fjell.journal", 1, "fjell-bake rebase");
    CHECK(slurp(place.folder / "hills.fjell.journal") == journal);
    std::filesystem::remove(place.folder / "hills.fjell.journal");
    // Rings, and a line that crosses itself, are lines as others.
    spit(place.folder / "bad.geojson",
         lines_of({{{50, -50}, {200, -60}, {120, -200}, {50, -50}}, {{20, -20}, {220, -220}, {220, -20}, {20, -220}}})
             .dump());
    for (const std::string kind : {"roads", "rivers"})
        CHECK(place.made(kind + " plain.fjell bad.geojson")["lines"] == 2);
    std::filesystem::remove(place.folder / "plain.fjell.journal");
}
