#include "baker/synth/write_dem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include <cpl_string.h>
#include <fmt/format.h>
#include <ogr_spatialref.h>

#include "baker/georeference/open_source.h"
#include "baker/heights/fill.h"
#include "baker/read/gdal_file.h"
#include "baker/store/parallel.h"
#include "baker/store/store.h"
#include "io/file.h"

namespace fjell::baker {

namespace {

constexpr std::int32_t tile = 256; // samples a side

// Heights from wherever they lie: rows y and on, as many as `to` holds; NaN where there is none, if `holes`.
struct HeightRows {
    std::int32_t columns, rows;
    const double (&spacing_m)[2], (&crs_origin)[2], (&crs_step)[2];
    const std::string& crs_wkt;
    double native_quantum_m;
    float least_m, most_m;
    DemForm form;
    bool holes;
    std::function<void(std::int32_t y, std::span<float> to)> read;
};

// visit(y, rows): a row of tiles after the other, until it says no.
template <typename Visit>
bool each_band(const HeightRows& heights, std::vector<float>& rows, const Visit& visit) {
    for (std::int32_t y = 0; y < heights.rows; y += tile) {
        io::check_interrupt();
        const std::int32_t n = std::min(tile, heights.rows - y);
        rows.resize(static_cast<std::size_t>(heights.columns) * static_cast<std::size_t>(n));
        heights.read(y, rows);
        if (!visit(y, n)) return false;
    }
    return true;
}

// 16 bits with scale and offset, when every height comes back from them bit for bit.
struct HeightScale16 {
    double step_m, base_m;
    [[nodiscard]] double steps(float height) const { return std::round((height - base_m) / step_m); }
};
std::optional<HeightScale16> height_scale_of(const HeightRows& heights) {
    if (!(heights.native_quantum_m > 0) || heights.form == DemForm::plain) return {};
    const double q = heights.native_quantum_m;
    // The base is itself a whole number of steps where it can be: 123.4f is not 123.4.
    const double whole = std::round(heights.least_m / q) * q;
    const HeightScale16 height_scale{q, static_cast<float>(whole) == heights.least_m ? whole : heights.least_m};
    if (height_scale.steps(heights.most_m) > 65535) return {};
    std::vector<float> band;
    const bool exact = each_band(heights, band, [&](std::int32_t, std::int32_t) {
        return std::all_of(band.begin(), band.end(), [&](float h) {
            return static_cast<float>(height_scale.steps(h) * height_scale.step_m + height_scale.base_m) == h;
        });
    });
    return exact ? std::optional(height_scale) : std::nullopt;
}

void set_place(GDALDataset& file, const HeightRows& dem) {
    double step[2] = {dem.crs_step[0], dem.crs_step[1]};
    if (!(step[0] > 0 && step[1] > 0)) crs_step_of(dem.spacing_m, dem.crs_wkt, step);
    OGRSpatialReference crs;
    // Without a CRS of its own, or with one that its spacing means nothing in, it gets a local one in metres, or a
    // small terrain at the origin looks like degrees.
    if (!(step[0] > 0 && step[1] > 0) || dem.crs_wkt.empty() || crs.importFromWkt(dem.crs_wkt.c_str()) != OGRERR_NONE) {
        std::copy_n(dem.spacing_m, 2, step);
        crs.Clear();
        crs.SetLocalCS("local metres");
        crs.SetLinearUnits("metre", 1);
    }
    // Pixels are samples: the origin is the north-west pixel's corner, half a pixel out.
    std::array<double, 6> t{dem.crs_origin[0] - step[0] / 2, step[0], 0, dem.crs_origin[1] + step[1] / 2, 0, -step[1]};
    file.SetGeoTransform(t.data());
    file.SetSpatialRef(&crs);
}

// Writes the bands, or reads them back and compares.
bool move_rows(GDALDataset& file, const HeightRows& heights, const std::optional<HeightScale16>& height_scale,
               GDALRWFlag way) {
    GDALRasterBand& band = *file.GetRasterBand(1);
    std::vector<float> rows, found;
    return each_band(heights, rows, [&](std::int32_t y, std::int32_t n) {
        if (height_scale)
            for (float& h : rows) h = static_cast<float>(height_scale->steps(h));
        found.resize(way == GF_Read ? rows.size() : 0);
        if (band.RasterIO(way, 0, y, heights.columns, n, way == GF_Read ? found.data() : rows.data(), heights.columns,
                          n, GDT_Float32, 0, 0, nullptr) != CE_None)
            return false;
        // Tiles are complete: GDAL need not keep any.
        return band.FlushCache() == CE_None &&
               (way == GF_Write || std::equal(rows.begin(), rows.end(), found.begin(), [](float a, float b) {
                    return a == b || (std::isnan(a) && std::isnan(b));
                }));
    });
}

GdalFile create(GDALDriver& driver, const std::string& name, const HeightRows& heights,
                const std::optional<HeightScale16>& height_scale) {
    CPLStringList options;
    options.SetNameValue("TILED", "YES");
    options.SetNameValue("BLOCKXSIZE", std::to_string(tile).c_str());
    options.SetNameValue("BLOCKYSIZE", std::to_string(tile).c_str());
    options.SetNameValue("COMPRESS", "DEFLATE");
    options.SetNameValue("PREDICTOR", height_scale ? "2" : "3");
    options.SetNameValue("BIGTIFF", "IF_SAFER");
    GdalFile file(driver.Create(name.c_str(), heights.columns, heights.rows, 1, height_scale ? GDT_UInt16 : GDT_Float32,
                                options.List()));
    if (!file) return file;
    set_place(*file, heights);
    GDALRasterBand& band = *file->GetRasterBand(1);
    if (height_scale) {
        band.SetScale(height_scale->step_m);
        band.SetOffset(height_scale->base_m);
    }
    if (heights.holes) band.SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
    band.SetUnitType("m");
    return file;
}

void write_heights(const HeightRows& heights, const std::string& path, const std::string& temporary) {
    io::AtomicFile out(path, temporary);
    GdalMessages messages;
    register_drivers();
    GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    if (!driver) throw Failure(3, fmt::format("{}: this GDAL has no GeoTIFF driver; install libgdal with it", path));
    const std::optional<HeightScale16> height_scale = height_scale_of(heights);
    GdalFile file = create(*driver, temporary, heights, height_scale); // the same file: it is cut to nothing and filled
    bool written = file && move_rows(*file, heights, height_scale, GF_Write);
    file.reset(); // closing writes the rest, and does not say when it cannot
    if (written && !messages.failed()) {
        file.reset(GDALDataset::Open(temporary.c_str(), GDAL_OF_RASTER));
        written = file && move_rows(*file, heights, height_scale, GF_Read);
        file.reset();
    }
    if (!written || messages.failed())
        throw Failure(
            3, fmt::format("{}: cannot be written; free some space or choose another disk{}", path, messages.said()));
    out.commit();
}

void refuse_device(const std::string& path) {
    if (std::filesystem::is_character_file(path))
        throw Failure(1, fmt::format("{}: is a device; give the height field a file name", path));
}

} // namespace

void write_dem(const HeightSource& source, const std::string& path, DemForm form, int threads,
               const Progress& progress) {
    refuse_device(path);
    WorkFolder folder(path);
    folder.empty();
    folder.keep(false);
    (void)io::AtomicFile(path, folder.file("dem.tif")); // a file that cannot be written should not cost an hour
    Store<float> heights(folder.file("heights"), source.columns, source.rows);
    const std::vector<Window> windows = source.windows(std::size_t{1} << 20);
    const int workers = source.readers(resolve_threads(threads));
    ReadStatistics statistics;
    std::mutex lock;
    std::uint64_t done = 0;
    parallel_for(static_cast<std::int64_t>(windows.size()), workers, [&](std::int64_t i) {
        const Window& w = windows[static_cast<std::size_t>(i)];
        std::vector<float> read(w.area());
        ReadStatistics part;
        source.reader()->read(w, read.data(), part);
        heights.write(w, read.data(), w.columns);
        const std::lock_guard hold(lock);
        statistics.add(part);
        if (progress) progress("read", ++done, windows.size());
    });
    const SourceProperties properties = source.properties(statistics);
    const bool voids = statistics.voids.count + statistics.implausible.count > 0,
               holes = voids && form == DemForm::plain;
    if (voids && !holes) {
        Store<float> filled(folder.file("filled"), source.columns, source.rows);
        const auto make = [&](const std::string& name, std::int64_t columns, std::int64_t rows) {
            return Store<float>(folder.file(name), columns, rows);
        };
        fill_voids({heights, {properties.native_quantum_m, properties.anchor_m}, workers, make}, filled);
        heights.remove();
        heights = std::move(filled);
    }
    float least = statistics.least_m, most = statistics.most_m;
    write_heights({source.columns, source.rows, source.spacing_m, source.crs_origin, source.crs_step, source.crs_wkt,
                   properties.native_quantum_m, least, most, form, holes,
                   [&](std::int32_t y, std::span<float> to) {
                       const Window w{0, y, source.columns, static_cast<std::int32_t>(to.size()) / source.columns};
                       heights.read(w, to.data(), w.columns);
                       if (progress)
                           progress("write", static_cast<std::uint64_t>(y), static_cast<std::uint64_t>(source.rows));
                   }},
                  path, folder.file("dem.tif"));
}

} // namespace fjell::baker
