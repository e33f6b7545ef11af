#include <algorithm>
#include <cmath>
#include <limits>

#include "read_support.h"

using namespace fjell::baker;
using namespace fjell::test;

TEST_CASE("real files of every format read as GDAL reads them") {
    const auto raw = [](const std::string& path, int x, int y) {
        const GdalMessages quiet;
        const GdalFile file(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER));
        double value = 0;
        REQUIRE(file->GetRasterBand(1)->RasterIO(GF_Read, x, y, 1, 1, &value, 1, 1, GDT_Float64, 0, 0, nullptr) ==
                CE_None);
        return value;
    };
    for (const char* name :
         {"formats/N37W003.hgt", "formats/grand_canyon_copdem_512_f32.tif",
          "formats/luxembourg_terra_elev_i16_nodata.tif", "formats/luxembourg_elev_i16_nodata.asc",
          "formats/grand_canyon_crop_513_u8.bmp", "dem/grand_canyon_60m_4097x2049_u8.png",
          "dem/spain_sierra_nevada_srtm3_3601x2401_i16.tif", "dem/norway_jotunheimen_117m_512_f32.tif",
          "dem/SainteHelens_usgs.dem", "dem/craterlake_elev_i16_30m.tif"}) {
        const std::string path = data_file(name);
        if (path.empty()) continue;
        INFO(path);
        ReadOptions options = filling();
        if (path.find("norway") == std::string::npos && path.find("Helens") == std::string::npos)
            options.spacing_m = 60; // what is projected would be resampled
        const Dem dem = read_dem(path, options);
        for (int k = 0; k < 50; ++k) {
            const int x = k * 7919 % dem.columns, y = k * 104729 % dem.rows;
            const double value = raw(path, x, y);
            if (value > -1000)
                CHECK(dem.at(x, y) == static_cast<float>(value));
            else
                CHECK(dem.at(x, y) > -1000); // filled
        }
    }
}

TEST_CASE("real files have holes exactly where GDAL reads their void value") {
    struct Holed {
        const char* name;
        NoData nodata;
        double nothing;
        double least, most; // share of holes
    };
    for (const Holed& holed :
         {Holed{"formats/luxembourg_terra_elev_i16_nodata.tif", NoData::automatic, -32768, 0.4, 0.5},
          {"formats/luxembourg_elev_i16_nodata.asc", NoData::automatic, -32768, 0.4, 0.5},
          {"dem/SainteHelens_usgs.dem", NoData::automatic, -32767, 0, 0.1},
          {"dem/craterlake_elev_i16_30m.tif", NoData::hole, -32767, 0.3, 0.4}}) {
        const std::string path = data_file(holed.name);
        if (path.empty()) continue;
        INFO(path);
        ReadOptions options = with(holed.nodata);
        if (path.find("Helens") == std::string::npos) options.spacing_m = 60; // what is projected would be resampled
        const Dem dem = read_dem(path, options);
        const GdalMessages quiet;
        const GdalFile file(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER));
        std::vector<double> raw(dem.heights_m.size());
        REQUIRE(file->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, dem.columns, dem.rows, raw.data(), dem.columns,
                                                 dem.rows, GDT_Float64, 0, 0, nullptr) == CE_None);
        int misplaced = 0, wrong = 0;
        for (int y = 0; y < dem.rows; ++y)
            for (int x = 0; x < dem.columns; ++x) {
                const double value = raw[dem.index(x, y)];
                misplaced += dem.is_void(x, y) != (value == holed.nothing);
                wrong += value != holed.nothing ? dem.at(x, y) != static_cast<float>(value) : dem.at(x, y) < 0;
            }
        CHECK(misplaced == 0);
        CHECK(wrong == 0);
        const double share = static_cast<double>(void_count(dem)) / static_cast<double>(raw.size());
        CHECK(share > holed.least);
        CHECK(share < holed.most);
    }
}

TEST_CASE("real files with traps in them are refused with the option that settles them") {
    struct Trap {
        const char* name;
        bool spacing;
        std::vector<std::string> words;
    };
    for (const Trap& trap : {Trap{"formats/luxembourg_elev_i16_nodata.asc", false, {"degrees"}},
                             {"formats/terrarium_256.png", true, {"--encoding"}},
                             {"formats/grand_canyon_crop_513_u8.bmp", false, {"--spacing"}},
                             {"dem/craterlake_elev_i16_30m.tif", true, {"-32767 m", "--nodata hole", "--nodata fill"}},
                             {"dem/puget_sound_160m_1025_u16.png", true, {"--zscale"}}}) {
        const std::string path = data_file(trap.name);
        if (path.empty()) continue;
        check_refusal(refused(path, trap.spacing ? spaced(60) : ReadOptions{}), 1, path, trap.words);
    }
}
