// Heights from any raster GDAL opens (thesis 5.3.1, its DataReader for bmp and ascii). Everything that could change the
// ground silently - units, degrees, voids, orientation - is converted, or refused with the option that settles it.
#include "baker/read.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <ogr_spatialref.h>

#include "baker/fill.h"
#include "baker/gdal_file.h"
#include "fjell/pack.h"

namespace fjell::baker {

namespace {

// Nothing on Earth, Mars or Venus lies outside; undeclared voids (-32767, -99999, 1e38) do.
constexpr double lowest_m = -12000, highest_m = 30000;
constexpr double bytes_per_sample = 28; // what a bake holds at its peak

bool near_zero(double v, double beside) {
    return std::abs(v) <= 1e-9 * std::abs(beside);
}

void check_options(const ReadOptions& o) {
    if (o.spacing_m && !(*o.spacing_m >= min_spacing_m && *o.spacing_m <= max_spacing_m))
        throw Failure(2, fmt::format("--spacing {} is out of range; give metres between samples in {}..{:.0f}",
                                     *o.spacing_m, min_spacing_m, max_spacing_m));
    if (!(std::abs(o.zscale) >= 1e-6 && std::abs(o.zscale) <= 1e6))
        throw Failure(2, fmt::format("--zscale {} is out of range; give a factor of size 1e-6..1e6", o.zscale));
    if (!(std::abs(o.zoffset_m) <= 1e7))
        throw Failure(2, fmt::format("--zoffset {} is out of range; give metres in -1e7..1e7", o.zoffset_m));
}

// Metres in one unit of the band; no unit means metres, 0 that it is not known.
double unit_in_metres(const char* name) {
    std::string unit(name ? name : "");
    std::transform(unit.begin(), unit.end(), unit.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    struct Unit {
        std::string_view name;
        double metres;
    };
    constexpr double survey_foot = 1200.0 / 3937;
    constexpr std::array<Unit, 30> units{{{"", 1},
                                          {"m", 1},
                                          {"metre", 1},
                                          {"metres", 1},
                                          {"meter", 1},
                                          {"meters", 1},
                                          {"ft", 0.3048},
                                          {"foot", 0.3048},
                                          {"feet", 0.3048},
                                          {"international foot", 0.3048},
                                          {"international feet", 0.3048},
                                          {"us survey foot", survey_foot},
                                          {"us survey feet", survey_foot},
                                          {"us_survey_foot", survey_foot},
                                          {"foot_us", survey_foot},
                                          {"ftus", survey_foot},
                                          {"us-ft", survey_foot},
                                          {"usft", survey_foot},
                                          {"sfoot", survey_foot},
                                          {"survey foot", survey_foot},
                                          {"km", 1000},
                                          {"kilometre", 1000},
                                          {"kilometer", 1000},
                                          {"dm", 0.1},
                                          {"decimetre", 0.1},
                                          {"decimeter", 0.1},
                                          {"cm", 0.01},
                                          {"centimetre", 0.01},
                                          {"centimeter", 0.01},
                                          {"mm", 0.001}}};
    const auto found = std::find_if(units.begin(), units.end(), [&](const Unit& u) { return u.name == unit; });
    return found == units.end() ? 0 : found->metres;
}

// Where the samples stand, with row 0 in the north and column 0 in the west.
struct Placement {
    double spacing_m[2] = {0, 0};
    double origin[2] = {0, 0};
    bool flip_x = false, flip_y = false;
    std::string crs_wkt;
};

bool names_degrees(GDALDataset& file) {
    const char* const* metadata = file.GetMetadata();
    for (const char* const* entry = metadata; entry && *entry; ++entry) {
        const std::string_view line(*entry);
        if (line.find("units=degree") != std::string_view::npos) return true; // netCDF: degrees_east, degrees_north
    }
    return false;
}

// No CRS, but every place is a latitude and longitude, and no pixel is larger than 5 degrees: an ASCII grid of a globe.
bool looks_like_degrees(const double* t, int columns, int rows) {
    const double west = std::min(t[0], t[0] + columns * t[1]), east = std::max(t[0], t[0] + columns * t[1]);
    const double south = std::min(t[3], t[3] + rows * t[5]), north = std::max(t[3], t[3] + rows * t[5]);
    return west >= -181 && east <= 361 && south >= -91 && north <= 91 && std::abs(t[1]) <= 5 && std::abs(t[5]) <= 5;
}

Placement place(GDALDataset& file, const std::string& path, const ReadOptions& options) {
    Placement p;
    std::array<double, 6> t{};
    const bool referenced = file.GetGeoTransform(t.data()) == CE_None;
    const OGRSpatialReference* const crs = file.GetSpatialRef();
    if (options.spacing_m) p.spacing_m[0] = p.spacing_m[1] = *options.spacing_m;
    if (!referenced) {
        if (options.spacing_m) return p;
        throw Failure(1, fmt::format("{}: has no georeference; give --spacing M (metres between samples)", path));
    }
    if (!std::all_of(t.begin(), t.end(), [](double v) { return std::isfinite(v); }) || t[1] == 0 || t[5] == 0 ||
        !near_zero(t[2], t[1]) || !near_zero(t[4], t[5]))
        throw Failure(1, fmt::format("{}: its grid is rotated or sheared; straighten it first with gdalwarp", path));
    const int columns = file.GetRasterXSize(), rows = file.GetRasterYSize();
    if (!options.spacing_m) {
        if (crs ? crs->IsGeographic() != 0 : names_degrees(file) || looks_like_degrees(t.data(), columns, rows))
            throw Failure(1, fmt::format("{}: is in degrees; give --spacing M (metres between samples), or project it "
                                         "first with gdalwarp",
                                         path));
        const double unit = crs ? crs->GetLinearUnits() : 1;
        p.spacing_m[0] = std::abs(t[1]) * unit;
        p.spacing_m[1] = std::abs(t[5]) * unit;
    }
    p.flip_x = t[1] < 0;
    p.flip_y = t[5] > 0;
    p.origin[0] = t[0] + t[1] * (p.flip_x ? columns - 0.5 : 0.5);
    p.origin[1] = t[3] + t[5] * (p.flip_y ? rows - 0.5 : 0.5);
    // A local frame says nothing about where on Earth it is; other programs could do nothing with it.
    if (crs && !crs->IsLocal()) {
        char* wkt = nullptr;
        if (crs->exportToWkt(&wkt) == OGRERR_NONE && wkt) p.crs_wkt = wkt;
        CPLFree(wkt);
    }
    return p;
}

void check_placement(const Placement& p, const std::string& path) {
    for (const double spacing : p.spacing_m)
        if (!(spacing >= min_spacing_m && spacing <= max_spacing_m))
            throw Failure(1, fmt::format("{}: its samples are {} m apart; give --spacing M in {}..{:.0f}", path,
                                         spacing, min_spacing_m, max_spacing_m));
}

// An identity table of greys, as 8-bit BMPs carry, is no palette.
bool is_grey_table(const GDALColorTable& table) {
    for (int i = 0; i < table.GetColorEntryCount(); ++i) {
        const GDALColorEntry& c = *table.GetColorEntry(i);
        if (c.c1 != i || c.c2 != i || c.c3 != i) return false;
    }
    return true;
}

void check_band(GDALDataset& file, const std::string& path, const ReadOptions& options) {
    GDALRasterBand& band = *file.GetRasterBand(1);
    const int columns = file.GetRasterXSize(), rows = file.GetRasterYSize();
    if (columns < 2 || rows < 2)
        throw Failure(1,
                      fmt::format("{}: has {} x {} samples; a height field needs at least 2 x 2", path, columns, rows));
    const double needed = bytes_per_sample * columns * rows;
    if (needed > static_cast<double>(options.memory_bytes))
        throw Failure(3,
                      fmt::format("{}: {} x {} samples need about {:.0f} MB; give --memory MB of at least that, or cut "
                                  "the file with gdal_translate -srcwin",
                                  path, columns, rows, std::ceil(needed / 1e6)));
    const GDALDataType type = band.GetRasterDataType();
    if (GDALDataTypeIsComplex(type))
        throw Failure(1, fmt::format("{}: holds complex numbers, not heights; extract one part first", path));
    const bool bytes_rgb = file.GetRasterCount() >= 3 && type == GDT_Byte;
    if (bytes_rgb || band.GetColorInterpretation() == GCI_RedBand)
        throw Failure(
            1, fmt::format("{}: has {} bands of colour; is this an image, or Terrarium or Mapbox heights? Convert "
                           "it to one band of heights first (gdal_calc.py)",
                           path, file.GetRasterCount()));
    const GDALColorTable* const table = band.GetColorTable();
    if (table && !is_grey_table(*table))
        throw Failure(
            1, fmt::format("{}: is a palette image, whose numbers are no heights; convert it to grey first", path));
}

// Samples of one kind, and where the first one is, in the file's own columns and rows.
struct FileTally {
    std::uint64_t count = 0;
    int column = 0, row = 0;

    void add(int x, int y) {
        if (count++ == 0) column = x, row = y;
    }
};

// What has no height, or none that can be believed (read.h).
struct FileCensus {
    FileTally voids, odd;
    double odd_m = 0; // the first, as asked
};

// raw -> metres as in the file -> metres as asked.
struct Scaling {
    double file_scale = 1, file_offset_m = 0, zscale = 1, zoffset_m = 0;

    [[nodiscard]] double file_m(double raw) const { return raw * file_scale + file_offset_m; }
    [[nodiscard]] double asked_m(double metres) const { return metres * zscale + zoffset_m; }
};

Scaling scaling_of(GDALRasterBand& band, const ReadOptions& options, const std::string& path) {
    int known = 0;
    double unit = unit_in_metres(band.GetUnitType());
    if (unit == 0) {
        if (options.zscale == 1)
            throw Failure(
                1, fmt::format("{}: heights are in \"{}\", which is not known here; give --zscale S (metres a unit)",
                               path, band.GetUnitType()));
        unit = 1; // --zscale says what a unit is
    }
    const double scale = band.GetScale(&known), offset = band.GetOffset(&known);
    Scaling s{scale * unit, offset * unit, options.zscale, options.zoffset_m};
    if (!std::isfinite(s.file_scale) || s.file_scale == 0 || !std::isfinite(s.file_offset_m))
        throw Failure(1,
                      fmt::format("{}: its band has scale {} and offset {}; set them right with gdal_edit.py -scale 1 "
                                  "-offset 0",
                                  path, scale, offset));
    return s;
}

// Finds the coarsest of 1, 0.1 and 0.01 that all raw numbers are multiples of, as floats.
class StepFinder {
public:
    explicit StepFinder(GDALDataType type) : per_unit_(1), whole_(GDALDataTypeIsInteger(type) != 0) {}
    void see(double raw) {
        if (whole_) return;
        while (per_unit_ <= 100 &&
               static_cast<float>(std::round(raw * per_unit_) / per_unit_) != static_cast<float>(raw))
            per_unit_ *= 10;
    }
    [[nodiscard]] double step() const { return per_unit_ <= 100 ? 1 / per_unit_ : 0; }

private:
    double per_unit_;
    bool whole_;
};

bool plausible(double metres) {
    return metres >= lowest_m && metres <= highest_m;
}

// A sample's height, or NaN and a mark in the census. A height is odd only when it is so both as the file has it and as
// asked: 16-bit counts become plausible by --zscale, and exaggerated heights were plausible before.
float classify(double raw, const Scaling& scaling, int x, int y, FileCensus& census) {
    const double metres = scaling.file_m(raw), asked = scaling.asked_m(metres);
    if (plausible(metres) || plausible(asked)) return static_cast<float>(asked);
    if (std::isnan(metres)) {
        census.voids.add(x, y);
    } else {
        if (census.odd.count == 0) census.odd_m = asked;
        census.odd.add(x, y);
    }
    return std::numeric_limits<float>::quiet_NaN();
}

// What the file itself says is no height. GDAL's mask speaks for one source alone, the strongest: where that is a mask
// of its own, the tag has to be asked beside it.
class Marks {
public:
    explicit Marks(GDALRasterBand& band) : valid_(static_cast<std::size_t>(band.GetXSize()), 255) {
        const int flags = band.GetMaskFlags();
        if (!(flags & GMF_ALL_VALID)) mask_ = band.GetMaskBand();
        int tagged = 0;
        const double tag = band.GetNoDataValue(&tagged);
        if (tagged && !(flags & GMF_NODATA)) tag_ = static_cast<float>(tag);
    }
    void read(int y, const std::string& path, const GdalMessages& messages) {
        if (mask_) read_row(*mask_, y, valid_.data(), path, messages);
    }
    [[nodiscard]] bool is_void(std::size_t x, double raw) const {
        return valid_[x] == 0 || static_cast<float>(raw) == tag_;
    }

private:
    GDALRasterBand* mask_ = nullptr; // none: all are valid
    std::vector<std::uint8_t> valid_;
    float tag_ = std::numeric_limits<float>::quiet_NaN(); // none
};

// Fills heights_m (no height: NaN) and native_quantum_m.
FileCensus read_heights(GDALRasterBand& band, const Placement& at, const Scaling& scaling, const std::string& path,
                    const GdalMessages& messages, Dem& dem) {
    const auto columns = static_cast<std::size_t>(dem.columns);
    dem.heights_m.resize(columns * static_cast<std::size_t>(dem.rows));
    std::vector<double> raw(columns);
    Marks marks(band);
    FileCensus census;
    StepFinder finder(band.GetRasterDataType());
    for (int y = 0; y < dem.rows; ++y) {
        read_row(band, y, raw.data(), path, messages);
        marks.read(y, path, messages);
        float* const row = dem.heights_m.data() + columns * static_cast<std::size_t>(at.flip_y ? dem.rows - 1 - y : y);
        for (std::size_t x = 0; x < columns; ++x) {
            float& height = row[at.flip_x ? columns - 1 - x : x];
            if (marks.is_void(x, raw[x])) {
                census.voids.add(static_cast<int>(x), y);
                height = std::numeric_limits<float>::quiet_NaN();
                continue;
            }
            height = classify(raw[x], scaling, static_cast<int>(x), y, census);
            if (!std::isnan(height)) finder.see(raw[x]);
        }
    }
    dem.native_quantum_m = finder.step() * std::abs(scaling.file_scale * scaling.zscale);
    return census;
}

// Throws for what the user has to decide about, and for a file without any height.
void refuse_voids(const FileCensus& census, std::uint64_t all, const std::string& path, NoData nodata) {
    constexpr const char* remedy =
        "give --nodata hole to leave them open or --nodata fill to fill them from their neighbours";
    const auto& [voids, odd, odd_m] = census;
    if (voids.count + odd.count == all)
        throw Failure(1,
                      fmt::format("{}: all {} samples are no-data, NaN or outside {}..{} m; give a file with heights",
                                  path, all, lowest_m, highest_m));
    if (odd.count && (nodata == NoData::automatic || nodata == NoData::refuse))
        throw Failure(1, fmt::format("{}: {} of {} heights lie outside {}..{} m, the first {} m at column {}, row {}; "
                                     "if they are voids, {}; if the unit is another, give --zscale S",
                                     path, odd.count, all, lowest_m, highest_m, odd_m, odd.column, odd.row, remedy));
    if (voids.count && nodata == NoData::refuse)
        throw Failure(1, fmt::format("{}: {} of {} samples are no-data or NaN, the first at column {}, row {}; {}",
                                     path, voids.count, all, voids.column, voids.row, remedy));
}

void settle_voids(Dem& dem, const FileCensus& census, const Scaling& scaling, const std::string& path, NoData nodata) {
    if (census.voids.count + census.odd.count == 0) return;
    refuse_voids(census, dem.heights_m.size(), path, nodata);
    if (nodata != NoData::fill) {
        dem.voids.resize(dem.heights_m.size());
        std::transform(dem.heights_m.begin(), dem.heights_m.end(), dem.voids.begin(),
                       [](float height) { return static_cast<std::uint8_t>(std::isnan(height)); });
    }
    fill_voids(dem.heights_m, dem.columns, dem.rows, dem.native_quantum_m, scaling.asked_m(scaling.file_offset_m));
}

// Squares of heights must stay far from float's largest value, like those of extents.
void check_range(const Dem& dem, const std::string& path) {
    const auto [least, most] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    if (*least < -max_extent_m || *most > max_extent_m)
        throw Failure(2, fmt::format("{}: heights become {}..{} m; give a smaller --zscale", path, *least, *most));
}

} // namespace

Dem read_dem(const std::string& path, const ReadOptions& options) {
    check_options(options);
    GdalMessages messages;
    const GdalFile file = open_raster(path, "a height field", messages);
    check_band(*file, path, options);
    const Placement at = place(*file, path, options);
    check_placement(at, path);
    GDALRasterBand& band = *file->GetRasterBand(1);
    const Scaling scaling = scaling_of(band, options, path);
    Dem dem;
    dem.columns = file->GetRasterXSize();
    dem.rows = file->GetRasterYSize();
    std::copy_n(at.spacing_m, 2, dem.spacing_m);
    std::copy_n(at.origin, 2, dem.origin_m);
    dem.crs_wkt = at.crs_wkt;
    messages.forget();
    try {
        const FileCensus census = read_heights(band, at, scaling, path, messages, dem);
        settle_voids(dem, census, scaling, path, options.nodata);
    } catch (const std::bad_alloc&) {
        throw Failure(3,
                      fmt::format("{}: not enough memory for {} x {} samples; cut the file with gdal_translate -srcwin",
                                  path, dem.columns, dem.rows));
    }
    check_range(dem, path);
    return dem;
}

} // namespace fjell::baker
