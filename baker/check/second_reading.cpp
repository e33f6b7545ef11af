// Through GDAL's C functions: its own minimum and maximum, its own way from places to pixels.
#include "baker/check/second_reading.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include "baker/read/gdal_file.h"
#include "baker/read/pack_source.h"

namespace fjell::baker {

namespace {

struct CloseSecond {
    void operator()(void* file) const { GDALClose(file); }
};

struct RangeOfNumbers {
    double least = std::numeric_limits<double>::infinity(), most = -std::numeric_limits<double>::infinity();
};

bool has_sign(GDALRasterBandH band) {
    const char* const kind = GDALGetMetadataItem(band, "PIXELTYPE", "IMAGE_STRUCTURE");
    return GDALGetRasterDataType(band) == GDT_Byte && kind && std::string(kind) == "SIGNEDBYTE";
}

// Metres of a number, by the band's own scale; a unit that has a name, or is the CRS', is the baker's to know.
struct Metres {
    double scale = 1, offset_m = 0;
    [[nodiscard]] double of(double number) const { return number * scale + offset_m; }
};
Metres metres_of(GDALRasterBandH band, const ReadOptions& options, const SourceFacts& facts) {
    const double zscale = options.zscale.value_or(1), scale = GDALGetRasterScale(band, nullptr);
    const double unit_m = facts.height_unit.empty() ? 1 : facts.height_unit_m / (scale * zscale);
    return {scale * unit_m * zscale, GDALGetRasterOffset(band, nullptr) * unit_m * zscale + options.zoffset_m};
}

// Pixels of pack samples as the geotransform runs; false: they are not in rows and columns of the CRS' east and north.
bool runs_plainly(GDALDatasetH file, bool& mirror_x, bool& mirror_y) {
    double t[6];
    mirror_x = mirror_y = false;
    if (GDALGetGeoTransform(file, t) != CE_None) return GDALGetSpatialRef(file) == nullptr;
    mirror_x = t[1] < 0;
    mirror_y = t[5] > 0;
    OGRSpatialReferenceH const crs = GDALGetSpatialRef(file);
    if (!crs || !OSRIsProjected(crs)) return true;
    OGRAxisOrientation axes[2] = {OAO_East, OAO_North};
    for (const int axis : {0, 1}) (void)OSRGetAxis(crs, "PROJCS", axis, &axes[axis]);
    std::sort(axes, axes + 2);
    return axes[0] == OAO_North && axes[1] == OAO_East;
}

// What five samples are in the file and in the pack; empty: they agree.
std::string compare_samples(GDALDatasetH file, GDALRasterBandH band, const Metres& metres, const io::PackFile& pack,
                            double allowed_m, int& compared) {
    bool mirror_x = false, mirror_y = false;
    if (!runs_plainly(file, mirror_x, mirror_y)) return {};
    const PackSource ground(pack.path());
    const auto reader = ground.reader();
    ReadStatistics unused;
    constexpr double places[5][2] = {{0.07, 0.11}, {0.93, 0.06}, {0.52, 0.47}, {0.12, 0.91}, {0.89, 0.94}};
    for (const auto& [u, v] : places) {
        const auto x = static_cast<int>(u * ground.columns), y = static_cast<int>(v * ground.rows);
        float height = 0;
        reader->read({x, y, 1, 1}, &height, unused);
        double number = 0;
        if (GDALRasterIO(band, GF_Read, mirror_x ? ground.columns - 1 - x : x, mirror_y ? ground.rows - 1 - y : y, 1, 1,
                         &number, 1, 1, GDT_Float64, 0, 0) != CE_None)
            return {};
        if (has_sign(band) && number > 127) number -= 256;
        if (std::isnan(height) || !std::isfinite(number)) continue;
        ++compared;
        if (!(std::abs(metres.of(number) - static_cast<double>(height)) <= allowed_m))
            return fmt::format("at column {}, row {} its number is {}, which is {:.6g} m, and the pack has {:.6g} m", x,
                               y, number, metres.of(number), height);
    }
    return {};
}

} // namespace

SecondReading read_again(const std::vector<std::string>& paths, const ReadOptions& options, const SourceFacts& facts,
                         const io::PackFile& pack) {
    SecondReading said;
    if (options.encoding != Encoding::none) return said; // its heights are in no band
    const PackHeader& h = pack.pack().header;
    const GdalMessages quiet;
    register_drivers();
    RangeOfNumbers range;
    std::string type;
    int compared = 0;
    const double allowed_m =
        0.5 * static_cast<double>(h.quantum_m) + 1e-6 +
        0x1p-22 * std::max(std::abs(static_cast<double>(h.min_m)), std::abs(static_cast<double>(h.max_m)));
    const bool whole = paths.size() == 1 && facts.reprojected_from.empty() && !options.bbox;
    const int number = std::max(1, std::atoi(facts.band.c_str()));
    for (const std::string& path : paths) {
        const std::string name = path.ends_with(".gz") && !is_gdal_name(path) ? fmt::format("/vsigzip/{}", path) : path;
        const std::unique_ptr<void, CloseSecond> file(GDALOpen(name.c_str(), GA_ReadOnly));
        GDALRasterBandH const band =
            file && number <= GDALGetRasterCount(file.get()) ? GDALGetRasterBand(file.get(), number) : nullptr;
        double ends[2] = {0, 0};
        if (!band || GDALComputeRasterMinMax(band, FALSE, ends) != CE_None) return said; // raw, or all of it void
        const Metres metres = metres_of(band, options, facts);
        for (const double end : ends) {
            range.least = std::min(range.least, metres.of(end));
            range.most = std::max(range.most, metres.of(end));
        }
        type = fmt::format("{} {}{}", GDALGetDriverShortName(GDALGetDatasetDriver(file.get())),
                           has_sign(band) ? "signed " : "", GDALGetDataTypeName(GDALGetRasterDataType(band)));
        if (whole && (GDALGetRasterXSize(file.get()) != static_cast<int>(h.columns) ||
                      GDALGetRasterYSize(file.get()) != static_cast<int>(h.rows)))
            return said;
        if (whole && said.wrong.empty())
            said.wrong = compare_samples(file.get(), band, metres, pack, allowed_m, compared);
    }
    said.account = fmt::format("{}, {:.6g} to {:.6g} m, {} samples", type, range.least, range.most, compared);
    const bool fills = options.nodata == NoData::fill; // beyond the range, smoothly
    if (said.wrong.empty() && !fills &&
        (static_cast<double>(h.min_m) < range.least - allowed_m ||
         static_cast<double>(h.max_m) > range.most + allowed_m))
        said.wrong = fmt::format("its numbers are {:.6g} to {:.6g} m, and the pack's heights {:.6g} to {:.6g} m",
                                 range.least, range.most, h.min_m, h.max_m);
    return said;
}

} // namespace fjell::baker
