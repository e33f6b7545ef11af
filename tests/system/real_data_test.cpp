// Real height fields, of every format that lies beside the project: baked whole, verified, flown (issue 3).
#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "support/program.h"
#include "support/real_data.h"
#include "support/temporary_folder.h"

using namespace fjell::test;
using nlohmann::json;

namespace {

const std::string bake_real = FJELL_BIN_DIR "/fjell-bake ", fly = FJELL_BIN_DIR "/fjell-fly ";

json bake_and_verify(const TemporaryFolder& folder, const std::string& dem, const std::string& read,
                     const std::string& more = "") {
    const Run baked = run_in(folder.path, bake_real + dem + read + more + " -o out.fjell --json bake.json");
    CAPTURE(dem, baked.err);
    REQUIRE(baked.code == 0);
    const Run verified = run_in(folder.path, bake_real + "verify out.fjell --against " + dem + read);
    CAPTURE(verified.out, verified.err);
    REQUIRE(verified.code == 0);
    REQUIRE(verified.out.find(": 0 off by more than half a quantum") != std::string::npos);
    return json::parse(slurp(folder / "bake.json"));
}

void fly_over(const TemporaryFolder& folder) {
    const Run flown = run_in(folder.path, fly + "out.fjell --headless --frames 60 --error-px 1 --verify 20 "
                                                "--json flight.json");
    CAPTURE(flown.err);
    REQUIRE(flown.code == 0);
    const json flight = json::parse(slurp(folder / "flight.json"));
    CHECK(flight["converged_frames"] == 60);
    CHECK(flight["verified_error_px_max"] <= 1.0);
    CHECK(flight["triangles_mean"] > 100);
}

} // namespace

TEST_CASE("every real height field is baked whole, verified and flown within its threshold") {
    struct Case {
        std::string file, read;
        int columns, rows;
        bool holes;
        bool dear = false; // for full rounds: another one here is like it, or the same is baked below with an image
    };
    const std::vector<Case> cases{
        {"dem/SainteHelens_usgs.dem", "", 327, 468, true},
        {"dem/norway_jotunheimen_117m_512_f32.tif", "", 512, 512, false},
        {"dem/puget_sound_160m_1025_u16.png", " --spacing 160 --zscale 0.1", 1025, 1025, false, true},
        {"dem/craterlake_elev_i16_30m.tif", " --spacing 30 --nodata hole", 429, 279, true, true},
        {"formats/N37W003.hgt", " --spacing 90", 1201, 1201, false, true},
        {"formats/grand_canyon_copdem_512_f32.tif", " --spacing 200", 512, 512, false, true},
        // In degrees, reprojected: holes at the corners.
        {"formats/N37W003.hgt", "", 1080, 1352, true},
        {"formats/grand_canyon_copdem_512_f32.tif", "", 470, 577, true},
        {"formats/luxembourg_terra_elev_i16_nodata.tif", "", 82, 116, true},
        {"dem/craterlake_elev_i16_30m.tif", " --nodata hole", 372, 330, true, true},
        {"dem/grand_canyon_60m_4097x2049_u8.png", " --spacing 60 --zscale 14.4 --zoffset 127", 4097, 2049, false},
        {"formats/terrarium_256.png", " --spacing 100 --encoding terrarium", 256, 256, false},
        {"formats/grand_canyon_crop_513_u8.bmp", " --spacing 60 --zscale 14.4 --zoffset 127", 513, 513, false},
        {"formats/luxembourg_elev_i16_nodata.asc", " --spacing 900", 95, 90, true},
        {"formats/luxembourg_terra_elev_i16_nodata.tif", " --spacing 900", 95, 90, true},
    };
    for (const Case& c : cases) {
        if (c.dear && !full_rounds()) continue;
        const std::string dem = c.columns > 4000 ? large_real(c.file) : real(c.file);
        if (dem.empty()) continue;
        const TemporaryFolder folder;
        const json summary = bake_and_verify(folder, dem, c.read);
        CAPTURE(c.file);
        CHECK(summary["columns"] == c.columns);
        CHECK(summary["rows"] == c.rows);
        CHECK((summary["holes"] > 0) == c.holes);
        fly_over(folder);
    }
}

TEST_CASE("every real image bakes onto its height field, in its own detail, is verified and flown") {
    struct Case {
        std::string file, read, image;
        int tile, texels; // a tile's colour map
        int columns, rows;
        bool holes;
        bool dear = false; // for full rounds
    };
    const std::vector<Case> cases{
        // An image of a part: its place is columns and rows of the whole.
        {"dem/grand_canyon_60m_4097x2049_u8.png", " --spacing 60 --zscale 14.4 --zoffset 127 --bbox 2246,1628,3446,428",
         "textures/grand_canyon_color_crop_1024.png", 512, 512, 1201, 1201, false},
        {"dem/norway_jotunheimen_117m_512_f32.tif", "", "textures/norway_jotunheimen_texture_4096.jpg", 256, 1024, 512,
         512, false, true},
        {"dem/puget_sound_160m_1025_u16.png", " --spacing 160 --zscale 0.1", "textures/puget_sound_texture_1024.png",
         512, 512, 1025, 1025, false, true},
        // By its coordinates: reprojected with its terrain, and with the samples where they are.
        {"dem/craterlake_elev_i16_30m.tif", " --nodata hole", "textures/craterlake_imagery_30m.tif", 512, 512, 372, 330,
         true},
        {"dem/craterlake_elev_i16_30m.tif", " --nodata hole --spacing 30", "textures/craterlake_imagery_30m.tif", 512,
         512, 429, 279, true, true},
    };
    for (const Case& c : cases) {
        if (c.dear && !full_rounds()) continue;
        const std::string dem = real(c.file), image = real(c.image);
        if (dem.empty() || image.empty()) continue;
        const TemporaryFolder folder;
        CAPTURE(c.file, c.read);
        const json summary =
            bake_and_verify(folder, dem, c.read, " --tile " + std::to_string(c.tile) + " --texture " + image);
        CHECK(summary["columns"] == c.columns);
        CHECK(summary["rows"] == c.rows);
        CHECK((summary["holes"] > 0) == c.holes);
        const json info = json::parse(run_in(folder.path, bake_real + "info out.fjell --json").out);
        CHECK(info["colour_texels"] == c.texels);
        fly_over(folder);
    }
}

TEST_CASE("Spain and a tile inside of it, in degrees, make one field in metres that a region is cut from") {
    const std::string spain = large_real("dem/spain_sierra_nevada_srtm3_3601x2401_i16.tif"),
                      tile = real("formats/N37W003.hgt");
    if (spain.empty() || tile.empty()) return;
    const TemporaryFolder folder;
    const json whole = bake_and_verify(folder, spain, "");
    CHECK(whole["columns"] == 3268);
    CHECK(whole["rows"] == 2704);
    const json info = json::parse(run_in(folder.path, bake_real + "info out.fjell --json").out);
    CHECK(info["epsg"] == 32630);
    CHECK(info["crs_name"] == "WGS 84 / UTM zone 30N");
    CHECK(info["spacing_m"][0] == info["spacing_m"][1]);
    const json part = bake_and_verify(folder, spain + " " + tile, " --bbox 480000,4100000,520000,4150000");
    CHECK(part["columns"] == 484);
    CHECK(part["holes"] == 0);
}

TEST_CASE(
    "all of the Spain mosaic takes at most two bytes a sample, and 1.6 times what GeoTIFF needs for heights alone") {
    const std::string dem = large_real("dem/spain_sierra_nevada_srtm3_3601x2401_i16.tif");
    if (dem.empty()) return;
    const TemporaryFolder folder;
    const json summary = bake_and_verify(folder, dem, " --spacing 90");
    const double bytes = summary["geometry_bytes"].get<double>() + summary["directory_bytes"].get<double>();
    CHECK(bytes <= 2.0 * 3601 * 2401);
    for (const std::string options : {"", " -co TILED=YES", " -co TILED=YES -co ZLEVEL=9"}) {
        REQUIRE(run_in(folder.path,
                       "gdal_translate -q -co COMPRESS=DEFLATE -co PREDICTOR=2" + options + " " + dem + " heights.tif")
                    .code == 0);
        CAPTURE(options);
        CHECK(bytes <= 1.6 * static_cast<double>(std::filesystem::file_size(folder / "heights.tif")));
    }
}
