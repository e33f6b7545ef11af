// Rasters made for one test, and refusals looked at.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <cpl_string.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <unistd.h>

#include "baker/read/gdal_file.h"
#include "support/dem.h"
#include "support/temporary_folder.h"

namespace fjell::test {

using TempDir = TemporaryFolder;

// Tests call GDAL as they like.
inline const bool gdal_is_there = (baker::load_gdal(), true);

struct Raster {
    int columns = 0, rows = 0;
    std::vector<double> values;
    GDALDataType type = GDT_Float32;
    int bands = 1;
    std::vector<double> geotransform; // empty: no georeference
    std::string crs;                  // as "EPSG:32632"; empty: none
    std::function<void(GDALDataset&)> more;
    std::vector<std::string> creation = {}; // options of the format
};

// Metres, north up, sample (0, 0) at (1000, 2000).
inline std::vector<double> metres(double dx, double dy) {
    return {1000 - dx / 2, dx, 0, 2000 + dy / 2, 0, -dy};
}

inline Raster raster(int columns, int rows, const std::function<double(int, int)>& value) {
    Raster r{columns, rows, {}, GDT_Float32, 1, metres(10, 10), "", {}};
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) r.values.push_back(value(x, y));
    return r;
}

inline std::string write(const Raster& r, const std::string& path, const char* format = "GTiff") {
    baker::register_drivers();
    auto* const manager = GetGDALDriverManager();
    const bool direct = std::string(format) == "GTiff";
    CPLStringList creation;
    for (const std::string& option : r.creation) creation.AddString(option.c_str());
    GDALDataset* const file = manager->GetDriverByName(direct ? "GTiff" : "MEM")
                                  ->Create(direct ? path.c_str() : "", r.columns, r.rows, r.bands, r.type,
                                           direct ? creation.List() : nullptr);
    REQUIRE(file);
    if (!r.geotransform.empty()) {
        std::array<double, 6> t{};
        std::copy_n(r.geotransform.begin(), 6, t.begin());
        file->SetGeoTransform(t.data());
    }
    if (!r.crs.empty()) {
        OGRSpatialReference crs;
        crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        crs.SetFromUserInput(r.crs.c_str());
        file->SetSpatialRef(&crs);
    }
    std::vector<double> values = r.values;
    for (int b = 1; b <= r.bands; ++b)
        REQUIRE(file->GetRasterBand(b)->RasterIO(GF_Write, 0, 0, r.columns, r.rows, values.data(), r.columns, r.rows,
                                                 GDT_Float64, 0, 0, nullptr) == CE_None);
    if (r.more) r.more(*file);
    if (!direct) {
        GDALDataset* const copy =
            manager->GetDriverByName(format)->CreateCopy(path.c_str(), file, FALSE, nullptr, nullptr, nullptr);
        REQUIRE(copy);
        GDALClose(copy);
    }
    GDALClose(file);
    return path;
}

inline void write_text(const std::string& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

// What a call refuses with; code 0 when it does not.
struct Refusal {
    int code = 0;
    std::string line;
    [[nodiscard]] bool says(const std::string& words) const { return line.find(words) != std::string::npos; }
};
inline Refusal refusal(const std::function<void()>& call) {
    try {
        call();
    } catch (const baker::Failure& failure) {
        return {failure.exit_code, failure.what()};
    }
    return {};
}

// One line, about this path, with this code, and the remedy in it.
inline void check_refusal(const Refusal& r, int code, const std::string& path, const std::vector<std::string>& words) {
    INFO("refusal: " << r.code << " " << r.line);
    CHECK(r.code == code);
    CHECK(r.says(path));
    CHECK(r.line.find('\n') == std::string::npos);
    for (const std::string& w : words) {
        INFO("wanted: " << w);
        CHECK(r.says(w));
    }
}

// Real data, where it is; empty, with a line about it, where it is not.
inline std::string data_file(const std::string& name) {
    const std::string given = FJELL_DATA_DIR;
    const std::string path = (given.empty() ? std::string(FJELL_SOURCE_DIR) + "/../shared/data" : given) + "/" + name;
    if (std::filesystem::exists(path)) return path;
    WARN("skipped: " << path << " is not there; set FJELL_DATA to the folder of real DEMs");
    return {};
}

} // namespace fjell::test
