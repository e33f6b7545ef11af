// What another program sees: GDAL's hillshade of a height field and of the pack read back agree.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "support/program.h"
#include "support/real_data.h"
#include "support/temporary_folder.h"

using namespace fjell::test;
using nlohmann::json;

namespace {

const std::string baker_program = FJELL_BIN_DIR "/fjell-bake ";

void must(const TemporaryFolder& folder, const std::string& command) {
    const Run r = run_in(folder.path, command);
    CAPTURE(command, r.out, r.err);
    REQUIRE(r.code == 0);
}

template <typename T>
std::vector<T> raster(const TemporaryFolder& folder, const std::string& tif, const std::string& type) {
    must(folder, "gdal_translate -q -of ENVI -ot " + type + " " + tif + " raw.img");
    const std::string bytes = slurp(folder / "raw.img");
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    return values;
}

struct Case {
    std::string file;
    std::string read;      // fjell-bake's options
    std::string translate; // gdal_translate's, for a GeoTIFF of the same metres on the same height scale
    double spacing_m;
    bool exact;                    // whole metres: the same bits
    double nothing = std::nan(""); // that the translation has where there are holes
    std::string place = {};        // for both, where neither is in metres
    bool large = false;            // left to full rounds
};

// A height field and its pack as Float32 metres in a.tif and b.tif.
void make_both(const TemporaryFolder& folder, const Case& c, const std::string& dem) {
    must(folder, baker_program + dem + " " + c.read + " --quiet -o out.fjell");
    must(folder, baker_program + "heights out.fjell -o back.tif");
    must(folder, "gdal_translate -q " + c.place + " back.tif b.tif");
    must(folder, "gdal_translate -q -ot Float32 " + c.place + " " + c.translate + " " + dem + " a.tif");
}

// The largest difference of heights; holes must be in the same places.
double apart(const TemporaryFolder& folder, double nothing) {
    const std::vector<float> a = raster<float>(folder, "a.tif", "Float32"),
                             b = raster<float>(folder, "b.tif", "Float32");
    REQUIRE(a.size() == b.size());
    REQUIRE(!a.empty());
    double most = 0;
    std::size_t holes_apart = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const bool hole = std::isnan(a[i]) || static_cast<double>(a[i]) == nothing;
        holes_apart += hole != std::isnan(b[i]);
        if (!hole && !std::isnan(b[i])) most = std::max(most, std::abs(static_cast<double>(a[i]) - b[i]));
    }
    CHECK(holes_apart == 0);
    return most;
}

} // namespace

TEST_CASE("GDAL's hillshade of a height field and of its pack read back agree") {
    if (std::system("command -v gdaldem >/dev/null 2>&1") != 0) {
        WARN("skipped: there is no gdaldem; install gdal-bin");
        return;
    }
    const std::vector<Case> cases{
        {"formats/grand_canyon_crop_513_u8.bmp", "--spacing 60 --zscale 14 --zoffset 127",
         "-scale 0 255 127 3697 -a_ullr 0 30780 30780 0", 60, true},
        {"dem/grand_canyon_60m_4097x2049_u8.png",
         "--spacing 60 --zscale 14 --zoffset 127",
         "-scale 0 255 127 3697 -a_ullr 0 122940 245820 0",
         60,
         true,
         std::nan(""),
         {},
         true},
        {"dem/spain_sierra_nevada_srtm3_3601x2401_i16.tif", "--crs none --spacing 90", "", 90, true, std::nan(""),
         "-a_srs EPSG:32630 -a_ullr 0 216090 324090 0", true},
        {"dem/SainteHelens_usgs.dem", "", "", 30, true, -32767},
        {"dem/norway_jotunheimen_117m_512_f32.tif", "", "", 60000.0 / 512, false},
        {"dem/puget_sound_160m_1025_u16.png",
         "--spacing 160 --zscale 0.1",
         "-scale 0 65535 0 6553.5 -a_ullr 0 164000 164000 0",
         160,
         false,
         std::nan(""),
         {},
         true},
    };
    for (const Case& c : cases) {
        const std::string dem = c.large ? large_real(c.file) : real(c.file);
        if (dem.empty()) continue;
        const TemporaryFolder folder;
        make_both(folder, c, dem);
        const double apart_m = apart(folder, c.nothing);
        const json info = json::parse(run_in(folder.path, baker_program + "info out.fjell --json").out);
        // Half a step, and two roundings of floats of this size.
        const double largest =
            std::max(std::abs(info["height_m"][0].get<double>()), std::abs(info["height_m"][1].get<double>()));
        CAPTURE(c.file, apart_m);
        CHECK(apart_m <= (c.exact ? 0 : 0.5 * info["quantum_m"].get<double>() + largest * 0x1p-22));
        for (const std::string name : {"a", "b"})
            must(folder, "gdaldem hillshade -q " + name + ".tif " + name + "_shade.tif");
        const auto a = raster<unsigned char>(folder, "a_shade.tif", "Byte"),
                   b = raster<unsigned char>(folder, "b_shade.tif", "Byte");
        REQUIRE(a.size() == b.size());
        int most = 0;
        std::size_t different = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            most = std::max(most, std::abs(a[i] - b[i]));
            different += a[i] != b[i];
        }
        // A shade is 1 + 254 times the cosine between a unit normal and a unit vector, which changes by no more than
        // the gradient does; Horn's gradient changes by at most apart_m / spacing along each axis. Codes are rounded:
        // the share that falls to another side is at most how far they were moved.
        const double moved = 254 * std::sqrt(2.0) * apart_m / c.spacing_m;
        const double share = static_cast<double>(different) / static_cast<double>(a.size());
        CAPTURE(most, share, moved);
        CHECK(most <= std::ceil(moved));
        CHECK(share <= moved);
        CHECK(*std::max_element(a.begin(), a.end()) > 200); // there is something to see
    }
}
