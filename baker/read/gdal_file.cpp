#include "baker/read/gdal_file.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include <cpl_conv.h>
#include <cpl_minixml.h>
#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal_alg.h>
#include <ogr_spatialref.h>
#include <unistd.h>

#include "baker/read/netcdf_length.h"
#include "baker/read/options.h"
#include "baker/read/source.h"
#include "io/file.h"

namespace fjell::baker {

namespace {

std::atomic<std::int64_t> cache_limit{-1}; // still to be told to GDAL, if not negative

std::string one_line(const char* text) {
    std::string line(text ? text : "");
    std::replace_if(
        line.begin(), line.end(), [](unsigned char c) { return c < ' '; }, ' ');
    constexpr std::size_t longest = 240;
    if (line.size() > longest) line.replace(line.begin() + longest, line.end(), "...");
    return line;
}

// GDAL knows HGT files by name and size alone, and is often built without OpenEXR.
const char* hint(const std::string& path) {
    const auto ends = [&](const char* low, const char* high) { return path.ends_with(low) || path.ends_with(high); };
    if (ends(".hgt", ".HGT") || ends(".hgt.gz", ".HGT.gz"))
        return "; HGT files must be named like N37W003.hgt and have 1201 or 3601 samples a side";
    if (ends(".exr", ".EXR"))
        return "; GDAL here does not read OpenEXR: save the heights as a 32-bit GeoTIFF or as .r32";
    return "";
}

// Checks what neither GDAL nor the netCDF library does: see netcdf_length.h. name: a file, of the raster called path.
void check_length(const std::string& name, const std::string& path) {
    const std::optional<std::uint64_t> promised = netcdf_length(name);
    std::error_code unknown;
    const std::uint64_t length = std::filesystem::file_size(name, unknown);
    if (!promised || unknown || length >= *promised) return;
    if (*promised == netcdf_damaged)
        throw Failure(1, fmt::format("{}: its netCDF header is damaged or cut short; fetch the file again", path));
    throw Failure(1, fmt::format("{}: cut short, {} of {} bytes; fetch the file again", path, length, *promised));
}

// The same for names that are not files, once GDAL has said which file they mean.
void check_files(GDALDataset& file, const std::string& path) {
    char** const names = file.GetFileList();
    const std::string first = names && *names ? *names : "";
    CSLDestroy(names);
    if (!first.empty() && first != path) check_length(first, path);
}

} // namespace

bool is_gdal_name(const std::string& path) {
    if (path.starts_with("/vsi")) return true;
    const std::size_t colon = path.find(':');
    return colon != std::string::npos && colon > 1 &&
           std::all_of(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(colon),
                       [](unsigned char c) { return std::isalnum(c) || c == '_'; });
}

void register_drivers() {
    static std::once_flag once;
    std::call_once(once, [] {
        load_gdal();
        // Files of a VRT are opened for it alone, so that every thread has its own.
        if (!CPLGetConfigOption("VRT_SHARED_SOURCE", nullptr)) CPLSetConfigOption("VRT_SHARED_SOURCE", "0");
        // And leaves nothing beside what gzip has packed.
        if (!CPLGetConfigOption("CPL_VSIL_GZIP_WRITE_PROPERTIES", nullptr))
            CPLSetConfigOption("CPL_VSIL_GZIP_WRITE_PROPERTIES", "NO");
        GDALAllRegister();
    });
    if (const std::int64_t bytes = cache_limit.exchange(-1); bytes >= 0) GDALSetCacheMax64(bytes);
}

void limit_gdal_cache(std::size_t bytes) {
    cache_limit = static_cast<std::int64_t>(bytes);
}

void GdalMessages::take(CPLErr level, CPLErrorNum, const char* text) {
    auto* self = static_cast<GdalMessages*>(CPLGetErrorHandlerUserData());
    if (level >= CE_Failure && self->error_.empty()) self->error_ = one_line(text);
    if (level == CE_Warning && self->warning_.empty()) self->warning_ = one_line(text);
}

std::string GdalMessages::said() const {
    const std::string& text = failed() ? error_ : warning_;
    return text.empty() ? "" : fmt::format(" (GDAL: {})", text);
}

bool is_raw(const std::string& path) {
    std::string ending = std::filesystem::path(path).extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return !is_gdal_name(path) && (ending == ".raw" || ending == ".r16" || ending == ".r32");
}

namespace {

// What GDAL takes for a name: of raw numbers a description, of what gzip has packed the way into it.
std::string name_for_gdal(const std::string& path, const std::optional<std::array<int, 2>>& size) {
    if (path.ends_with(".gz") && !is_gdal_name(path)) return "/vsigzip/" + path;
    if (!is_raw(path)) return path;
    std::error_code none;
    const std::uint64_t bytes = std::filesystem::file_size(path, none);
    const auto side = [&](std::uint64_t sample_bytes) { // of a square of such samples; 0: it is none
        const auto n = static_cast<std::uint64_t>(std::lround(std::sqrt(static_cast<double>(bytes / sample_bytes))));
        return n * n * sample_bytes == bytes ? static_cast<int>(std::min<std::uint64_t>(n, 1u << 30)) : 0;
    };
    const std::string ending = std::filesystem::path(path).extension().string();
    const bool may_be_16 = ending.back() != '2', may_be_32 = ending.back() != '6';
    std::array<int, 2> grid = size.value_or(std::array{0, 0});
    std::uint64_t sample_bytes = 0;
    for (const std::uint64_t b : {std::uint64_t{2}, std::uint64_t{4}}) {
        if (sample_bytes != 0 || (b == 2 ? !may_be_16 : !may_be_32)) continue;
        if (!size) grid = {side(b), side(b)};
        const auto samples = static_cast<std::uint64_t>(grid[0]) * static_cast<std::uint64_t>(grid[1]);
        if (samples != 0 && samples * b == bytes) sample_bytes = b;
    }
    if (sample_bytes == 0 && size)
        throw Failure(1, fmt::format("{}: has {} bytes, which {} x {} numbers of {} are not; give another --size", path,
                                     bytes, grid[0], grid[1],
                                     may_be_16 && may_be_32 ? "16 or 32 bits"
                                     : may_be_16            ? "16 bits"
                                                            : "32 bits"));
    if (sample_bytes == 0)
        throw Failure(1,
                      fmt::format("{}: {} bytes of raw numbers are no square; give --size COLUMNSxROWS", path, bytes));
    char* const escaped = CPLEscapeString(path.c_str(), -1, CPLES_XML);
    const std::string vrt = fmt::format(
        R"(<VRTDataset rasterXSize="{}" rasterYSize="{}"><VRTRasterBand dataType="{}" band="1" subClass="VRTRawRasterBand"><SourceFilename relativeToVRT="0">{}</SourceFilename><ByteOrder>LSB</ByteOrder></VRTRasterBand></VRTDataset>)",
        grid[0], grid[1], sample_bytes == 2 ? "UInt16" : "Float32", escaped);
    CPLFree(escaped);
    return vrt;
}

} // namespace

bool named_as_elevation(const char* name) {
    const CPLString text(name ? name : "");
    for (const char* const word :
         {"elev", "height", "altitude", "topo", "bathy", "terrain", "relief", "dem", "dtm", "dsm", "orog"})
        if (text.ifind(word) != std::string::npos) return true;
    return false;
}

namespace {

// Of a file that holds arrays with names, those that GDAL takes; first what is called elevation.
std::string named_rasters(GDALDataset& file) {
    constexpr std::size_t most = 6;
    std::vector<std::string> names;
    const char* const* all = file.GetMetadata("SUBDATASETS");
    for (int i = 1;; ++i) {
        const char* const name = CSLFetchNameValue(all, fmt::format("SUBDATASET_{}_NAME", i).c_str());
        if (!name) break;
        names.push_back(one_line(name));
    }
    std::stable_partition(names.begin(), names.end(), [](const std::string& name) {
        return named_as_elevation(name.substr(name.find_last_of(":/") + 1).c_str());
    });
    const std::size_t more = names.size() > most ? names.size() - most : 0;
    names.resize(names.size() - more);
    return names.empty() ? "" : fmt::format("'{}'{}", fmt::join(names, "', '"), more ? ", ..." : "");
}

// A folder that is one raster: Zarr.
bool is_zarr(const std::string& path) {
    std::error_code none;
    for (const char* const name : {".zgroup", ".zarray", ".zmetadata", "zarr.json"})
        if (std::filesystem::exists(std::filesystem::path(path) / name, none)) return true;
    return false;
}

} // namespace

GdalFile open_raster(const std::string& path, const char* what, GdalMessages& messages,
                     const std::optional<std::array<int, 2>>& size) {
    register_drivers();
    std::error_code ignored;
    const auto status = std::filesystem::status(path, ignored);
    const bool zarr = is_zarr(path);
    if (std::filesystem::is_directory(status) && !zarr)
        throw Failure(1, fmt::format("{}: is a folder; give the file in it that holds {}", path, what));
    if (!std::filesystem::exists(status)) {
        if (!is_gdal_name(path)) throw Failure(1, fmt::format("{}: no such file; check the path", path));
    } else if (!zarr && !std::filesystem::is_regular_file(status)) {
        throw Failure(1, fmt::format("{}: not a regular file; give a file that holds {}", path, what));
    } else if (!zarr) {
        close(io::open_regular_file(path)); // GDAL would take what may not be read for a format it does not know
        check_length(path, path);
    }
    hush_hdf5();
    (void)raster_sources(path); // GDAL would wait for what a pipe never brings
    GdalFile file(GDALDataset::Open(name_for_gdal(path, size).c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
    if (!file)
        throw Failure(1, fmt::format("{}: cannot be read as {}; give a GeoTIFF, PNG, BMP, ASCII grid, HGT, USGS DEM or "
                                     "netCDF that is whole{}{}",
                                     path, what, hint(path), messages.said()));
    check_files(*file, path);
    if (file->GetRasterCount() == 0) {
        if (const std::string names = named_rasters(*file); !names.empty())
            throw Failure(1, fmt::format("{}: holds several rasters; give one of them instead: {}", path, names));
        throw Failure(1, fmt::format("{}: holds no raster; give a file that holds {}", path, what));
    }
    messages.forget(); // what GDAL grumbled about while it guessed the format is no fault of the data
    return file;
}

std::string named_bands(GDALDataset& file) {
    constexpr int most = 20;
    std::string text;
    for (int b = 1; b <= std::min(file.GetRasterCount(), most); ++b) {
        const char* const name = file.GetRasterBand(b)->GetDescription();
        text += fmt::format("{}{}{}", b == 1 ? "" : ", ", b, name && *name ? fmt::format(" \"{}\"", name) : "");
    }
    return text + (file.GetRasterCount() > most ? ", ..." : "");
}

int find_band(GDALDataset& file, const std::string& wanted, const std::string& path) {
    const int count = file.GetRasterCount();
    int number = 0;
    const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
    if (error == std::errc() && end == wanted.data() + wanted.size() && number >= 1 && number <= count) return number;
    for (int b = 1; b <= count; ++b)
        if (wanted == file.GetRasterBand(b)->GetDescription()) return b;
    throw Failure(1, fmt::format("{}: has no band {}; it has {}", path, wanted, named_bands(file)));
}

namespace {

template <typename T>
void read_row_as(GDALRasterBand& band, int row, T* to, GDALDataType type, const std::string& path,
                 const GdalMessages& messages) {
    const int columns = band.GetXSize();
    const CPLErr result = band.RasterIO(GF_Read, 0, row, columns, 1, to, columns, 1, type, 0, 0, nullptr);
    if (result != CE_None || messages.failed() || messages.warned())
        throw Failure(1, fmt::format("{}: damaged or cut short at row {} of {}; fetch the file again{}", path, row,
                                     band.GetYSize(), messages.said()));
}

} // namespace

void read_row(GDALRasterBand& band, int row, double* to, const std::string& path, const GdalMessages& messages) {
    read_row_as(band, row, to, GDT_Float64, path, messages);
}
void read_row(GDALRasterBand& band, int row, std::uint8_t* to, const std::string& path, const GdalMessages& messages) {
    read_row_as(band, row, to, GDT_Byte, path, messages);
}

namespace {

namespace fs = std::filesystem;

fs::file_status status_of(const std::string& path) {
    std::error_code ignored; // what cannot be looked at cannot be opened, and is said then
    return fs::status(path, ignored);
}

// A file, or those within a name such as /vsizip/a.zip/b.tif or NETCDF:"a.nc":height.
std::vector<std::string> files_named(const std::string& name) {
    if (fs::exists(status_of(name))) return {name};
    std::string rest = name;
    while (rest.starts_with("/vsi") && rest.find('/', 1) != std::string::npos) rest.erase(0, rest.find('/', 1) + 1);
    if (rest != name) {
        std::erase_if(rest, [](char c) { return c == '{' || c == '}'; });
        for (fs::path at = rest; !at.empty() && at != at.root_path(); at = at.parent_path())
            if (fs::exists(status_of(at.string()))) return {at.string()};
        return {};
    }
    std::vector<std::string> files;
    for (std::size_t from = 0; from < name.size();) {
        const std::size_t end = std::min(name.find_first_of(":\"", from), name.size());
        const std::string part = name.substr(from, end - from);
        if (!part.empty() && fs::exists(status_of(part))) files.push_back(part);
        from = end + 1;
    }
    return files;
}

struct CplFree {
    void operator()(CPLXMLNode* node) const { CPLDestroyXMLNode(node); }
};

bool is_vrt(const std::string& path) {
    char head[1024]; // as much as GDAL looks at
    std::ifstream file(path, std::ios::binary);
    file.read(head, sizeof head);
    return std::string_view(head, static_cast<std::size_t>(file.gcount())).find("<VRTDataset") !=
           std::string_view::npos;
}

class Sources {
public:
    void add(const std::string& name) {
        for (const std::string& file : files_named(name)) add_file(file);
    }
    std::vector<std::string> files;

private:
    void add_file(const std::string& path) {
        if (!seen_.insert(path).second) return;
        const fs::file_status status = status_of(path);
        if (!fs::is_regular_file(status) && !fs::is_directory(status))
            throw Failure(1, fmt::format("{}: not a regular file{}; give a file in its place", path,
                                         files.empty() ? "" : ", which " + files.front() + " needs"));
        files.push_back(path);
        if (!fs::is_regular_file(status) || !is_vrt(path)) return;
        const GdalMessages quiet; // what is wrong with it is said when it is opened
        const std::unique_ptr<CPLXMLNode, CplFree> xml(CPLParseXMLFile(path.c_str()));
        for (const CPLXMLNode* node = xml.get(); node; node = node->psNext) visit(*node, path);
    }

    void visit(const CPLXMLNode& node, const std::string& vrt) {
        if (node.eType != CXT_Element) return;
        if (EQUAL(node.pszValue, "SourceFilename") || EQUAL(node.pszValue, "SourceDataset")) {
            const char* const name = CPLGetXMLValue(&node, nullptr, "");
            const bool relative = CPLTestBool(CPLGetXMLValue(&node, "relativeToVRT", "0"));
            add(relative ? CPLProjectRelativeFilename(fs::path(vrt).parent_path().c_str(), name) : name);
            return;
        }
        for (const CPLXMLNode* child = node.psChild; child; child = child->psNext) visit(*child, vrt);
    }

    std::set<std::string> seen_;
};

} // namespace

std::vector<std::string> raster_sources(const std::string& path) {
    Sources sources;
    sources.add(path);
    return std::move(sources.files);
}

std::vector<std::string> raster_files(const std::string& path, const char* what) {
    std::vector<std::string> files = raster_sources(path);
    if (is_raw(path)) return files; // it may take a size that is not known here
    GdalMessages messages;
    const GdalFile file = open_raster(path, what, messages);
    const CPLStringList listed(file->GetFileList());
    // A VRT's list has its sources, but not what lies beside those, and opening thousands only to ask would take long.
    for (std::size_t i = 1, sources = files.size(); i < sources; ++i)
        for (const char* end : {".aux.xml", ".ovr", ".msk", ".prj", ".hdr", ".tfw", ".wld", ".aux", ".clr"}) {
            const std::string after = files[i] + end, instead = fs::path(files[i]).replace_extension(end).string();
            if (fs::exists(status_of(after))) files.push_back(after);
            if (fs::exists(status_of(instead))) files.push_back(instead);
        }
    for (int i = 0; i < listed.Count(); ++i) files.emplace_back(listed[i]);
    return files;
}

namespace {

// A rotation that moves no sample by a hundredth of a pixel is what rounding leaves.
bool is_straight(const double* t, int columns, int rows) {
    return std::abs(t[2]) * rows <= 0.01 * std::abs(t[1]) && std::abs(t[4]) * columns <= 0.01 * std::abs(t[5]);
}

// netCDF: an axis in degrees_east, or one that is called a longitude without a unit, as GMT writes both.
bool names_degrees(GDALDataset& file) {
    constexpr std::array<const char*, 4> words{"units=degree", "standard_name=longitude", "long_name=longitude",
                                               "[degrees_east]"};
    const char* const* metadata = file.GetMetadata();
    for (const char* const* entry = metadata; entry && *entry; ++entry)
        if (std::any_of(words.begin(), words.end(),
                        [line = CPLString(*entry)](const char* word) { return line.ifind(word) != std::string::npos; }))
            return true;
    return false;
}

// No CRS, but every place is a latitude and longitude, and no pixel is larger than 5 degrees: an ASCII grid of a globe.
bool looks_like_degrees(const double* t, int columns, int rows) {
    const double west = std::min(t[0], t[0] + columns * t[1]), east = std::max(t[0], t[0] + columns * t[1]);
    const double south = std::min(t[3], t[3] + rows * t[5]), north = std::max(t[3], t[3] + rows * t[5]);
    return west >= -181 && east <= 361 && south >= -91 && north <= 91 && std::abs(t[1]) <= 5 && std::abs(t[5]) <= 5;
}

} // namespace

std::string wkt_of(const OGRSpatialReference& crs) {
    char* text = nullptr;
    const bool exported = crs.exportToWkt(&text) == OGRERR_NONE && text;
    std::string wkt = exported ? text : "";
    CPLFree(text);
    return wkt;
}

Turn turn_of(const OGRSpatialReference& crs) {
    if (crs.IsGeographic()) return {8 * std::atan(1.0) / crs.GetAngularUnits(), 0};
    constexpr std::array<const char*, 5> cylinders{"Mercator_1SP", "Mercator_2SP", "Equirectangular",
                                                   "Cylindrical_Equal_Area", "Miller_Cylindrical"};
    const char* const method = crs.IsProjected() ? crs.GetAttrValue("PROJECTION") : nullptr;
    if (!method || std::none_of(cylinders.begin(), cylinders.end(), [&](const char* c) { return EQUAL(c, method); }))
        return {};
    const std::unique_ptr<OGRSpatialReference> degrees(crs.CloneGeogCS());
    degrees->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    OGRSpatialReference plane(crs);
    plane.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRCoordinateTransformation> there(OGRCreateCoordinateTransformation(degrees.get(), &plane));
    const double middle = crs.GetNormProjParm(SRS_PP_CENTRAL_MERIDIAN, 0);
    double x[2] = {middle, middle + 90}, y[2] = {0, 0};
    if (!there || !there->Transform(2, x, y)) return {};
    return {4 * (x[1] - x[0]), x[0]};
}

void crs_step_of(const double (&spacing_m)[2], const std::string& crs_wkt, double (&step)[2]) {
    step[0] = step[1] = 0;
    if (crs_wkt.empty()) return;
    load_gdal();
    OGRSpatialReference crs;
    if (crs.importFromWkt(crs_wkt.c_str()) != OGRERR_NONE) return;
    if (!crs.IsProjected() && !crs.IsLocal()) return;
    const double unit_m = crs.GetLinearUnits();
    for (const int axis : {0, 1})
        if (unit_m > 0) step[axis] = spacing_m[axis] / unit_m;
}

std::array<double, 2> step_of(const HeightSource& source) {
    double step[2] = {source.crs_step[0], source.crs_step[1]};
    if (!(step[0] > 0 && step[1] > 0)) crs_step_of(source.spacing_m, source.crs_wkt, step);
    return {step[0], step[1]};
}

bool points_are_bent(GDALDataset& file, double& off_px) {
    const int count = file.GetGCPCount();
    const GDAL_GCP* const points = file.GetGCPs();
    off_px = std::numeric_limits<double>::infinity();
    void* const polynomial = GDALCreateGCPTransformer(count, points, 0, FALSE);
    if (!polynomial) return true;
    off_px = 0;
    for (int i = 0; i < count; ++i) {
        double x = points[i].dfGCPX, y = points[i].dfGCPY, z = 0;
        int ok = FALSE;
        GDALGCPTransform(polynomial, TRUE, 1, &x, &y, &z, &ok);
        off_px = std::max(off_px, ok ? std::hypot(x - points[i].dfGCPPixel, y - points[i].dfGCPLine)
                                     : std::numeric_limits<double>::infinity());
    }
    GDALDestroyGCPTransformer(polynomial);
    return !(off_px <= 1);
}

namespace {

// Makes a grid along east and north. What it leaves free at the corners would be heights of 0 without the no-data.
std::string warp_to_grid(const char* how, const std::string& path) {
    return fmt::format("gdalwarp {}-r bilinear -ot Float32 -dstnodata nan {} OUT.tif", how, path);
}

} // namespace

Placement place(GDALDataset& file, const std::string& path) {
    Placement p;
    p.columns = file.GetRasterXSize();
    p.rows = file.GetRasterYSize();
    std::array<double, 6> t{};
    if (file.GetGeoTransform(t.data()) != CE_None) {
        double off_px = 0;
        if (file.GetGCPCount() >= 3)
            p.command = warp_to_grid(points_are_bent(file, off_px) ? "-tps " : "", path);
        else if (file.GetMetadata("GEOLOCATION"))
            p.command = warp_to_grid("-geoloc ", path);
        return p;
    }
    if (!std::all_of(t.begin(), t.end(), [](double v) { return std::isfinite(v); }) || t[1] == 0 || t[5] == 0 ||
        !is_straight(t.data(), p.columns, p.rows))
        throw Failure(1, fmt::format("{}: its grid is rotated or sheared; straighten it first: {}", path,
                                     warp_to_grid("", path)));
    const OGRSpatialReference* const crs = file.GetSpatialRef();
    p.axes = Axes::metres;
    if (crs ? crs->IsGeographic() != 0 : names_degrees(file))
        p.axes = Axes::degrees;
    else if (!crs && looks_like_degrees(t.data(), p.columns, p.rows))
        p.axes = Axes::perhaps_degrees;
    if (crs && p.axes == Axes::metres) p.unit_m = crs->GetLinearUnits();
    p.flip_x = t[1] < 0;
    p.flip_y = t[5] > 0;
    p.step[0] = std::abs(t[1]);
    p.step[1] = std::abs(t[5]);
    p.origin[0] = t[0] + t[1] * (p.flip_x ? p.columns - 0.5 : 0.5);
    // Longitudes count from anywhere, but projections know no more than a turn to each side.
    if (p.axes == Axes::degrees && (p.origin[0] >= 360 || p.east(p.columns - 1) <= -360))
        p.origin[0] -= 360 * std::floor((p.origin[0] + 180) / 360);
    p.origin[1] = t[3] + t[5] * (p.flip_y ? p.rows - 0.5 : 0.5);
    // A local frame says nothing about where on Earth it is; other programs could do nothing with it.
    if (crs && !crs->IsLocal()) p.crs_wkt = wkt_of(*crs);
    return p;
}

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
    if (found != units.end()) return found->metres;
    // PROJ's own: fath, yd, link, ind-ft, ...
    const bool plain = unit.size() <= 6 && unit.find_first_not_of("abcdefghijklmnopqrstuvwxyz-") == std::string::npos;
    OGRSpatialReference plane;
    const GdalMessages quiet;
    return plain && plane.importFromProj4(("+proj=merc +units=" + unit).c_str()) == OGRERR_NONE ? plane.GetLinearUnits()
                                                                                                : 0;
}

namespace {

// Metres in one unit of the CRS' vertical axis; 0: it has none.
double vertical_unit(const OGRSpatialReference* crs, std::string& name) {
    if (!crs || (!crs->IsCompound() && !crs->IsVertical())) return 0;
    const char* text = nullptr;
    const double metres = crs->GetTargetLinearUnits("VERT_CS", &text);
    name = text ? text : "";
    return metres > 0 ? metres : 0;
}

// As the file calls the band's unit; empty: it does not, or in IDRISI's words that it is not known.
std::string named_unit(GDALRasterBand& band) {
    const CPLString named(band.GetUnitType() ? band.GetUnitType() : "");
    for (const char* const none : {"unspecified", "unknown", "none"})
        if (EQUAL(named.c_str(), none)) return {};
    return named;
}

bool same_unit(double a_m, double b_m) {
    return std::abs(a_m / b_m - 1) < 1e-5; // feet of two kinds differ by 2e-6
}

// How the unit of a CRS' axes is asked about: "--vertical-unit us-ft", or by its length.
std::string across_option(double across_m) {
    for (const char* const name : {"ft", "us-ft", "link", "ch", "yd", "ind-yd", "km"})
        if (std::abs(across_m / unit_in_metres(name) - 1) < 1e-7) return fmt::format("--vertical-unit {}", name);
    return fmt::format("--zscale {:.7g}", across_m);
}

double unit_of(GDALRasterBand& band, const OGRSpatialReference* crs, const ReadOptions& options,
               const std::string& path) {
    const std::string named = named_unit(band);
    const double unit = unit_in_metres(named.c_str());
    std::string axis;
    const double vertical = vertical_unit(crs, axis);
    const bool band_says = !named.empty() && unit > 0;
    if (!options.vertical_unit.empty()) {
        const double asked = unit_in_metres(options.vertical_unit.c_str());
        if ((!band_says && vertical == 0) || (band_says && same_unit(asked, unit)) ||
            (vertical > 0 && same_unit(asked, vertical)))
            return asked;
        throw Failure(1, fmt::format("{}: says that its heights are in \"{}\"; leave out --vertical-unit {}, or give "
                                     "--zscale {:.7g} instead if the file is wrong",
                                     path, band_says ? named : axis, options.vertical_unit,
                                     asked / (band_says ? unit : vertical)));
    }
    if (unit == 0 && !options.zscale)
        throw Failure(1, fmt::format("{}: heights are in \"{}\", which is not known here; give --zscale S (metres a "
                                     "unit), or --vertical-unit NAME",
                                     path, named));
    // Whoever counts feet across may count feet upwards, and a third of the height is no small mistake.
    const double across_m = crs && crs->IsProjected() ? crs->GetLinearUnits() : 1;
    if (named.empty() && vertical == 0 && !options.zscale && std::abs(across_m - 1) > 0.01)
        throw Failure(1, fmt::format("{}: its CRS counts in units of {:.7g} m and its heights name no unit; give {} if "
                                     "they are in the same, --vertical-unit m if they are in metres",
                                     path, across_m, across_option(across_m)));
    if (unit == 0) return 1; // --zscale says what a unit is
    if (vertical == 0 || same_unit(vertical, unit)) return unit;
    if (named.empty()) return vertical;
    throw Failure(1,
                  fmt::format("{}: its band says that heights are in \"{}\", its CRS in \"{}\"; give --vertical-unit "
                              "with the one that is right",
                              path, named, axis));
}

} // namespace

std::string unit_name(GDALRasterBand& band, const OGRSpatialReference* crs) {
    std::string name = named_unit(band);
    if (name.empty()) (void)vertical_unit(crs, name);
    return name;
}

namespace {

// Depths: what netCDF calls positive downwards, or by a standard name of the sea floor's depth.
// Or a vertical axis that points down. (Real files carry one over elevations, so that it is asked about.)
bool counts_downwards(GDALRasterBand& band, const OGRSpatialReference* crs) {
    OGRAxisOrientation points = OAO_Up;
    if (crs && (crs->IsCompound() || crs->IsVertical()) && crs->GetAxis("VERT_CS", 0, &points) && points == OAO_Down)
        return true;
    const auto has = [&](const char* key, const char* word) {
        const char* const value = band.GetMetadataItem(key);
        return value && CPLString(value).ifind(word) != std::string::npos;
    };
    return has("positive", "down") || has("standard_name", "sea_floor_depth");
}

} // namespace

Scaling scaling_of(GDALRasterBand& band, const OGRSpatialReference* crs, const ReadOptions& options,
                   const std::string& path) {
    const double unit = unit_of(band, crs, options, path);
    int known = 0;
    const double scale = band.GetScale(&known), offset = band.GetOffset(&known);
    if (!options.zscale && counts_downwards(band, crs))
        throw Failure(1,
                      fmt::format("{}: says that its numbers are depths; give --zscale -1 to make heights of them, or "
                                  "--zscale 1 if they are heights already",
                                  path));
    const Scaling s{scale * unit, offset * unit, options.zscale.value_or(1), options.zoffset_m};
    if (!std::isfinite(s.file_scale) || s.file_scale == 0 || !std::isfinite(s.file_offset_m))
        throw Failure(1,
                      fmt::format("{}: its band has scale {} and offset {}; set them right with gdal_edit.py -scale 1 "
                                  "-offset 0",
                                  path, scale, offset));
    return s;
}

} // namespace fjell::baker
