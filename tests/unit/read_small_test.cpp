// Files that are common and need a little help: raw numbers, what gzip has packed, pictures with a palette, units that
// say nothing, rotations that rounding leaves.
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <cpl_vsi.h>

#include "baker/bake/bake.h"
#include "baker/check/second_reading.h"
#include "baker/read/height_file.h"
#include "fjell/io/pack_file.h"
#include "read_support.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Little-endian numbers, row by row from the north-west.
template <typename T>
void write_raw(const std::string& path, int columns, int rows) {
    std::ofstream file(path, std::ios::binary);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const T number = static_cast<T>(slope(x, y));
            file.write(reinterpret_cast<const char*>(&number), sizeof number);
        }
}

ReadOptions sized(int columns, int rows) {
    ReadOptions o = spaced(10);
    o.size = {columns, rows};
    return o;
}

std::string bytes_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

} // namespace

TEST_CASE("raw numbers of 16 bits and floats are heights, of the size that is given or else square") {
    static_assert(std::endian::native == std::endian::little);
    const TempDir dir;
    for (const char* const name : {"a.raw", "a.r16", "A.R16", "with & and <.raw"}) {
        write_raw<std::uint16_t>(dir / name, 41, 41);
        check_slope(read_dem(dir / name, spaced(10)), 41, 41);
        CHECK(HeightFile(dir / name, spaced(10)).facts().driver == "raw, taken as a square"); // the summary has it
        write_raw<std::uint16_t>(dir / name, 41, 31);
        CHECK(HeightFile(dir / name, sized(41, 31)).facts().driver == "raw");
        check_slope(read_dem(dir / name, sized(41, 31)), 41, 31);
        CHECK(refused(dir / name, spaced(10)).says("2542 bytes of raw numbers are no square"));
        CHECK(refused(dir / name, spaced(10)).says("--size COLUMNSxROWS"));
        CHECK(refused(dir / name, sized(41, 30)).says("has 2542 bytes"));
        CHECK(refused(dir / name, sized(41, 30)).says("give another --size"));
    }
    for (const char* const name : {"f.raw", "f.r32"}) {
        write_raw<float>(dir / name, 41, 41);
        check_slope(read_dem(dir / name, spaced(10)), 41, 41);
        write_raw<float>(dir / name, 20, 31);
        check_slope(read_dem(dir / name, sized(20, 31)), 20, 31);
    }
    CHECK(refused(dir / "f.r32", sized(40, 31)).says("40 x 31 numbers of 32 bits")); // of 16 bits they are
    std::ofstream(dir / "none.exr") << "v/1";
    CHECK(refused(dir / "none.exr").says("does not read OpenEXR"));
    CHECK(refused(dir / "none.exr").says(".r32"));
}

TEST_CASE("a file that gzip has packed is read as it was before") {
    const TempDir dir;
    const std::string plain = write(raster(41, 31, slope), dir / "a.tif");
    const std::string bytes = bytes_of(plain);
    VSILFILE* const to = VSIFOpenL(("/vsigzip/" + (dir / "a.tif.gz")).c_str(), "wb");
    REQUIRE(to);
    REQUIRE(VSIFWriteL(bytes.data(), 1, bytes.size(), to) == bytes.size());
    REQUIRE(VSIFCloseL(to) == 0);
    check_slope(read_dem(dir / "a.tif.gz", {}), 41, 31);
    const std::string packed = bytes_of(dir / "a.tif.gz");
    std::ofstream(dir / "cut.tif.gz", std::ios::binary) << packed.substr(0, packed.size() / 2);
    CHECK(refused(dir / "cut.tif.gz").says("cut.tif.gz"));
}

TEST_CASE("a Terrarium picture that was stored with a palette is the picture that it was") {
    const TempDir dir;
    // 16 heights: 100 + 20 * (i mod 16), and their colours.
    const auto place = [](int x, int y) { return (x + 3 * y) % 16; };
    Raster r = raster(40, 30, [&](int x, int y) { return place(x, y); });
    r.type = GDT_Byte;
    r.geotransform.clear();
    r.more = [](GDALDataset& file) {
        GDALColorTable table;
        for (int i = 0; i < 16; ++i) {
            const int packed = (100 + 20 * i + 32768) * 256;
            const GDALColorEntry entry{static_cast<short>(packed >> 16), static_cast<short>(packed >> 8 & 255),
                                       static_cast<short>(packed & 255), 255};
            table.SetColorEntry(i, &entry);
        }
        file.GetRasterBand(1)->SetColorTable(&table);
    };
    ReadOptions options = spaced(10);
    options.encoding = Encoding::terrarium;
    const Dem dem = read_dem(write(r, dir / "t.png", "PNG"), options);
    int wrong = 0;
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) wrong += dem.at(x, y) != static_cast<float>(100 + 20 * place(x, y));
    CHECK(wrong == 0);
}

TEST_CASE("a unit that says nothing counts as none, and a rotation that moves nothing as none") {
    const TempDir dir;
    for (const char* const word : {"unspecified", "Unknown", "none"}) {
        Raster r = raster(41, 31, slope);
        r.more = [=](GDALDataset& file) { file.GetRasterBand(1)->SetUnitType(word); };
        check_slope(read_dem(write(r, dir / "u.tif"), {}), 41, 31);
    }
    Raster furlongs = raster(41, 31, slope);
    furlongs.more = [](GDALDataset& file) { file.GetRasterBand(1)->SetUnitType("furlongs"); };
    CHECK(refused(write(furlongs, dir / "f.tif")).says("furlongs"));
    CHECK(refused(write(furlongs, dir / "f.tif")).says("--zscale"));
    Raster turned = raster(41, 31, slope);
    turned.geotransform[2] = turned.geotransform[4] = 1e-7;
    check_slope(read_dem(write(turned, dir / "r.tif"), {}), 41, 31);
    turned.geotransform[2] = 0.01; // a thirtieth of a pixel at the last row
    CHECK(refused(write(turned, dir / "r2.tif")).says("rotated or sheared"));
}

TEST_CASE("of several bands the one that is named as elevation is read, or the one that is asked for, or none") {
    const TempDir dir;
    const auto two = [&](const char* first, const char* second) {
        Raster r = raster(41, 31, slope);
        r.bands = 2;
        r.more = [=](GDALDataset& file) {
            std::vector<float> steep(41 * 31, 7);
            REQUIRE(file.GetRasterBand(1)->RasterIO(GF_Write, 0, 0, 41, 31, steep.data(), 41, 31, GDT_Float32, 0, 0,
                                                    nullptr) == CE_None);
            file.GetRasterBand(1)->SetDescription(first);
            file.GetRasterBand(2)->SetDescription(second);
        };
        return write(r, dir / "two.tif");
    };
    ReadOptions second;
    second.band = "2";
    for (const char* const name : {"elevation", "Elevation (m)", "DEM", "surface height"}) {
        const std::string path = two("slope", name);
        check_slope(read_dem(path, {}), 41, 31);
        check_slope(read_dem(path, second), 41, 31);
        ReadOptions by_name;
        by_name.band = name;
        check_slope(read_dem(path, by_name), 41, 31);
    }
    for (const auto& [a, b] : {std::pair{"slope", "aspect"}, {"", ""}, {"elevation", "elevation of the sea"}}) {
        const std::string path = two(a, b);
        CHECK(refused(path).says("--band N or --band NAME"));
        CHECK(refused(path).says("has 2 bands, 1"));
        check_slope(read_dem(path, second), 41, 31);
    }
    ReadOptions third;
    third.band = "3";
    CHECK(refused(two("slope", "elevation"), third).says("has no band 3; it has 1 \"slope\", 2 \"elevation\""));
}

TEST_CASE("Vertical Mapper's grids are heights beside colours, and of arrays with names the line says which to give") {
    const TempDir dir;
    register_drivers();
    auto* const manager = GetGDALDriverManager();
    Raster r = raster(41, 31, slope); // 100 to 430, in 65,535 steps
    r.crs = "EPSG:32632";
    if (manager->GetDriverByName("NWT_GRD")) {
        const Dem dem = read_dem(write(r, dir / "v.grd", "NWT_GRD"), {});
        REQUIRE(dem.columns == 41);
        int wrong = 0;
        for (int y = 0; y < 31; ++y)
            for (int x = 0; x < 41; ++x) wrong += std::abs(dem.at(x, y) - slope(x, y)) > 330.0 / 65'533;
        CHECK(wrong == 0);
    } else {
        WARN("skipped: GDAL here has no driver NWT_GRD");
    }
    for (const char* const kind : {"netCDF", "Zarr"}) {
        GDALDriver* const driver = manager->GetDriverByName(kind);
        if (!driver || !driver->GetMetadataItem(GDAL_DCAP_CREATE_MULTIDIMENSIONAL)) {
            WARN("skipped: GDAL here makes no arrays of " << kind);
            continue;
        }
        CAPTURE(kind);
        const std::string path = dir / (*kind == 'n' ? "arrays.nc" : "arrays.zarr");
        {
            const std::unique_ptr<GDALDataset> file(driver->CreateMultiDimensional(path.c_str(), nullptr, nullptr));
            const auto group = file->GetRootGroup();
            const auto rows = group->CreateDimension("y", GDAL_DIM_TYPE_HORIZONTAL_Y, "NORTH", 31);
            const auto columns = group->CreateDimension("x", GDAL_DIM_TYPE_HORIZONTAL_X, "EAST", 41);
            const GDALExtendedDataType real = GDALExtendedDataType::Create(GDT_Float64);
            OGRSpatialReference crs;
            crs.SetFromUserInput("EPSG:32632");
            const auto fill = [&](const char* name, const std::vector<std::shared_ptr<GDALDimension>>& along,
                                  const std::vector<double>& values) {
                const GUInt64 from[2] = {0, 0};
                std::vector<size_t> counts;
                for (const auto& dimension : along) counts.push_back(static_cast<size_t>(dimension->GetSize()));
                const auto array = group->CreateMDArray(name, along, real);
                REQUIRE(array);
                if (along.size() == 2) REQUIRE(array->SetSpatialRef(&crs));
                REQUIRE(array->Write(from, counts.data(), nullptr, nullptr, real, values.data()));
                if (along.size() == 1 && *kind == 'Z') REQUIRE(along[0]->SetIndexingVariable(array));
            };
            std::vector<double> x, y;
            for (int i = 0; i < 41; ++i) x.push_back(1000 + 10 * i);
            for (int i = 0; i < 31; ++i) y.push_back(2000 - 10 * i);
            fill("y", {rows}, y);
            fill("x", {columns}, x);
            fill("slope", {rows, columns}, std::vector<double>(41 * 31, 7));
            fill("surface_elevation", {rows, columns}, r.values);
        }
        const Refusal line = refused(path);
        CHECK(line.says("holds several rasters; give one of them instead: '"));
        const std::size_t from = line.line.find('\'') + 1;
        const std::string name = line.line.substr(from, line.line.find('\'', from) - from);
        CHECK(name.ends_with("surface_elevation"));
        check_slope(read_dem(name, {}), 41, 31);
    }
}

TEST_CASE("--band holds in every file of a mosaic") {
    const TempDir dir;
    const auto half = [&](const char* name, int from) { // 20 columns, the heights in the third band
        Raster r = raster(20, 31, [=](int x, int y) { return slope(from + x, y); });
        r.bands = 3;
        r.geotransform[0] += 10 * from;
        r.more = [](GDALDataset& file) {
            for (const int b : {1, 2}) REQUIRE(file.GetRasterBand(b)->Fill(b) == CE_None);
            file.GetRasterBand(3)->SetDescription("ground");
        };
        return write(r, dir / name);
    };
    const std::vector<std::string> both{half("a.tif", 0), half("b.tif", 20)};
    for (const char* const band : {"3", "ground"}) {
        ReadOptions options;
        options.band = band;
        check_slope(read_dem(both, options), 40, 31);
    }
    CHECK(refusal([&] { (void)read_dem(both, {}); }).says("--band N or --band NAME"));
    ReadOptions fourth;
    fourth.band = "4";
    CHECK(refusal([&] { (void)read_dem(both, fourth); }).says("a.tif: has no band 4"));
}

TEST_CASE("bytes with a sign and 16 bits beside a table of colours are the numbers that they are") {
    const TempDir dir;
    register_drivers();
    const char* const kind[] = {"PIXELTYPE=SIGNEDBYTE", nullptr};
    const std::string path = dir / "s.tif";
    const GdalFile file(
        GetGDALDriverManager()->GetDriverByName("GTiff")->Create(path.c_str(), 16, 16, 1, GDT_Byte, kind));
    std::vector<std::uint8_t> bytes(256);
    for (std::size_t i = 0; i < 256; ++i) bytes[i] = static_cast<std::uint8_t>(i);
    std::array<double, 6> t{};
    std::copy_n(metres(10, 10).begin(), 6, t.begin());
    file->SetGeoTransform(t.data());
    REQUIRE(file->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, 16, 16, bytes.data(), 16, 16, GDT_Byte, 0, 0, nullptr) ==
            CE_None);
    file->FlushCache();
    const Dem dem = read_dem(path, {});
    int wrong = 0;
    for (int i = 0; i < 256; ++i) wrong += dem.at(i % 16, i / 16) != static_cast<float>(i < 128 ? i : i - 256);
    CHECK(wrong == 0);

    Raster table = raster(41, 31, slope);
    table.type = GDT_UInt16;
    table.more = [](GDALDataset& written) {
        GDALColorTable colours;
        for (int i = 0; i < 500; ++i) {
            const GDALColorEntry entry{static_cast<short>(i % 256), 10, 10, 255};
            colours.SetColorEntry(i, &entry);
        }
        written.GetRasterBand(1)->SetColorTable(&colours);
    };
    check_slope(read_dem(write(table, dir / "t.tif"), {}), 41, 31);
}

TEST_CASE("a second reading by GDAL alone finds another range and other samples, and only those") {
    const TempDir dir;
    const auto write_bytes = [&](const std::string& path, const char* kind, int step) {
        Raster r = raster(17, 15, [=](int x, int y) { return (200 + step * (x + 17 * y)) % 256; });
        r.type = GDT_Byte;
        if (*kind) r.creation = {kind};
        return write(r, path);
    };
    const std::string signed_path = write_bytes(dir / "s.tif", "PIXELTYPE=SIGNEDBYTE", 1);
    const std::string plain_path = write_bytes(dir / "p.tif", "", 1), other_path = write_bytes(dir / "o.tif", "", 3);
    const auto source = open_source({signed_path}, {});
    BakeOptions options;
    options.threads = 1;
    (void)bake(*source, options, dir / "s.fjell");
    const io::PackFile pack(dir / "s.fjell");
    const SecondReading good = read_again({signed_path}, {}, source->facts, pack);
    CHECK(good.wrong == "");
    CHECK(good.account == "GTiff signed Byte, -128 to 127 m, 5 samples");
    // The same bytes without their sign, as they were baked before.
    CHECK(read_again({plain_path}, {}, source->facts, pack).wrong != "");
    ReadOptions fills; // whose range proves nothing
    fills.nodata = NoData::fill;
    CHECK(read_again({plain_path}, fills, source->facts, pack).wrong.find("at column ") == 0);
    const auto plain = open_source({plain_path}, {});
    (void)bake(*plain, options, dir / "p.fjell");
    const io::PackFile plain_pack(dir / "p.fjell");
    CHECK(read_again({plain_path}, {}, plain->facts, plain_pack).wrong == "");
    CHECK(read_again({other_path}, {}, plain->facts, plain_pack).wrong.find("at column ") == 0);
    ReadOptions taller;
    taller.zscale = 0.5;
    CHECK(read_again({plain_path, plain_path}, taller, plain->facts, plain_pack)
              .wrong.find("its numbers are 0 to 127.5 m") == 0);
}

TEST_CASE("heights that lie all beyond belief are refused with what takes them") {
    const TempDir dir;
    const std::string path = write(raster(41, 31, [](int x, int y) { return 1e6 + slope(x, y); }), dir / "far.tif");
    CHECK(refused(path).says("or if such as 1000100 m are heights"));
    CHECK(refused(path).says("--void none"));
    ReadOptions none, offset;
    none.voids.no_others = true;
    offset.zoffset_m = -1e6;
    CHECK(read_dem(path, none).at(0, 0) == 1000100);
    check_slope(read_dem(path, offset), 41, 31);
}

TEST_CASE("a second reading finds that another band was baked") {
    const TempDir dir;
    Raster r = raster(41, 31, slope);
    r.bands = 2;
    r.more = [](GDALDataset& file) {
        REQUIRE(file.GetRasterBand(1)->Fill(200) == CE_None); // within the range of the other
        file.GetRasterBand(2)->SetDescription("elevation");
    };
    const std::string path = write(r, dir / "two.tif");
    const auto source = open_source({path}, {});
    (void)bake(*source, {}, dir / "two.fjell");
    const io::PackFile pack(dir / "two.fjell");
    CHECK(read_again({path}, {}, source->facts, pack).wrong == "");
    SourceFacts other = source->facts;
    other.band = "1";
    CHECK(read_again({path}, {}, other, pack).wrong.find("at column 2, row 3 its number is 200") == 0);
}

TEST_CASE("no common kind of file that GDAL writes is refused, and all hold the same heights") {
    const TempDir dir;
    register_drivers();
    int kinds = 0;
    const auto take = [&](const char* driver, const Raster& r, const std::string& path) {
        CAPTURE(driver, GDALGetDataTypeName(r.type), path);
        ++kinds;
        const GdalMessages quiet;
        try {
            check_slope(read_dem(write(r, path, driver), {}), 15, 11);
        } catch (const Failure& failure) {
            FAIL_CHECK(failure.what());
        }
    };
    const std::vector<GDALDataType> types{GDT_Byte,  GDT_UInt16,  GDT_Int16,  GDT_UInt32,
                                          GDT_Int32, GDT_Float32, GDT_Float64};
    Raster r = raster(15, 11, slope); // 100 to 212
    r.crs = "EPSG:32632";
    for (const GDALDataType type : types) {
        r.type = type;
        for (const char* const option : {"COMPRESS=NONE", "COMPRESS=LZW", "COMPRESS=DEFLATE", "COMPRESS=PACKBITS",
                                         "TILED=YES", "BIGTIFF=YES", "ENDIANNESS=BIG"}) {
            r.creation = {option};
            take("GTiff", r, dir / "a.tif");
        }
        r.creation.clear();
        for (const char* const driver :
             {"COG",   "HFA",  "ENVI", "EHdr", "ERS", "RST",   "PCIDSK", "netCDF", "KRO",     "BT",  "AAIGrid", "GSBG",
              "GS7BG", "GSAG", "NITF", "PNG",  "GIF", "ISIS3", "PDS4",   "SAGA",   "RRASTER", "KEA", "Zarr"}) {
            GDALDriver* const known = GetGDALDriverManager()->GetDriverByName(driver);
            if (!known && type == types.front()) WARN("skipped: GDAL here has no driver " << driver);
            const char* const writes = known ? known->GetMetadataItem(GDAL_DMD_CREATIONDATATYPES) : nullptr;
            if (!writes || (" " + std::string(writes) + " ").find(std::string(" ") + GDALGetDataTypeName(type) + " ") ==
                               std::string::npos)
                continue;
            const char* const ending =
                std::string(driver) == "SAGA" ? "sdat" : known->GetMetadataItem(GDAL_DMD_EXTENSION);
            take(driver, r,
                 dir / (std::string(driver) + GDALGetDataTypeName(type) + "." + (ending && *ending ? ending : "dat")));
        }
    }
    CAPTURE(kinds);
    CHECK(kinds >= 100);
}
