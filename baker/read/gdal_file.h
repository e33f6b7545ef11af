// A raster file through GDAL, with GDAL's messages caught instead of printed. Shared by heights and images.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gdal_priv.h>

#include "baker/read/options.h"
#include "fjell/io/failure.h"

namespace fjell::baker {

class HeightSource;
using io::Failure;

// Before anything else of GDAL, once for the whole process; safe to repeat. Whoever has GdalMessages has called it.
// Throws Failure 3: GDAL is not installed.
void load_gdal();
void register_drivers(); // and loads it
void hush_hdf5();        // which GDAL uses, and which prints what fails by itself, for this thread; after load_gdal()

// While it lives, this thread's GDAL messages come here: the first error and the first warning are kept, one line each.
class GdalMessages {
public:
    GdalMessages() { load_gdal(), CPLPushErrorHandlerEx(&GdalMessages::take, this); }
    ~GdalMessages() { CPLPopErrorHandler(); }
    GdalMessages(const GdalMessages&) = delete;
    GdalMessages& operator=(const GdalMessages&) = delete;

    [[nodiscard]] bool failed() const { return !error_.empty(); }
    [[nodiscard]] bool warned() const { return !warning_.empty(); }
    // "" or " (GDAL: what it said)".
    [[nodiscard]] std::string said() const;
    void forget() { error_.clear(), warning_.clear(); }

private:
    static void CPL_STDCALL take(CPLErr level, CPLErrorNum number, const char* text);
    std::string error_, warning_;
};

struct GdalClose {
    void operator()(GDALDataset* dataset) const { GDALClose(GDALDataset::ToHandle(dataset)); }
};
using GdalFile = std::unique_ptr<GDALDataset, GdalClose>;

// A name for one of GDAL's drivers or file systems, not a file's: NETCDF:"a.nc":height, /vsizip/..., and so on.
[[nodiscard]] bool is_gdal_name(const std::string& path);

// Opens a raster for reading. Throws Failure 1: no such file, a folder, not a raster GDAL knows, no bands. Names such
// as NETCDF:"file.nc":variable pass through to GDAL; a file that gzip has packed is read as it was before. what: "a
// height field" or "an image", for the messages. Raw numbers (.raw, .r16: 16 bits, .r32: floats; little-endian, rows
// from the north-west) have no header: size gives their columns and rows, and else they must be square.
[[nodiscard]] GdalFile open_raster(const std::string& path, const char* what, GdalMessages& messages,
                                   const std::optional<std::array<int, 2>>& size = {});
// By what people and programs call heights.
[[nodiscard]] bool named_as_elevation(const char* name);
// The bands of a raster, with their names: 1 "slope", 2 "elevation".
[[nodiscard]] std::string named_bands(GDALDataset& file);
// The number of the band of that number, from 1, or else of that name. Throws Failure 1: there is none.
[[nodiscard]] int find_band(GDALDataset& file, const std::string& wanted, const std::string& path);
// By its name.
[[nodiscard]] bool is_raw(const std::string& path);

// One row of a band as doubles or bytes. Throws Failure 1 when the file is truncated or damaged; warnings count,
// because some drivers only warn about missing data and hand out zeros.
void read_row(GDALRasterBand& band, int row, double* to, const std::string& path, const GdalMessages& messages);
void read_row(GDALRasterBand& band, int row, std::uint8_t* to, const std::string& path, const GdalMessages& messages);

// Which files a raster consists of: so that no output replaces one of them, and none that would block is opened.

// path: a file, or one of GDAL's names for what is in one. The files themselves, and of a VRT those that it names, as
// do VRTs among these. Throws Failure (1) for a pipe, a device or a socket among them, whose opening might never end.
// Opens nothing but VRTs.
[[nodiscard]] std::vector<std::string> raster_sources(const std::string& path);

// These, and what GDAL reads beside them (.aux.xml, .prj, .hdr, .tfw, .ovr, ...), as far as it is there. what: as for
// open_raster(), whose Failures it throws.
[[nodiscard]] std::vector<std::string> raster_files(const std::string& path, const char* what);

// The georeference of a raster's samples.

// metres: any linear unit. perhaps_degrees: nothing says so, but every place is a latitude and longitude.
enum class Axes : std::uint8_t { none, metres, degrees, perhaps_degrees };

// A grid with row 0 in the north and column 0 in the west, in the units of its CRS.
struct Placement {
    std::int32_t columns = 0, rows = 0;
    Axes axes = Axes::none;
    double step[2] = {1, 1};             // from sample to sample, > 0
    double origin[2] = {0, 0};           // of sample (0, 0): easting or longitude, northing or latitude
    double unit_m = 1;                   // metres in one unit of metre axes
    bool flip_x = false, flip_y = false; // how the file has them
    std::string crs_wkt;                 // empty: none that means anything elsewhere
    std::string command; // that makes a grid of what only control points or arrays place; empty: they do not

    [[nodiscard]] double east(double column) const { return origin[0] + step[0] * column; }
    [[nodiscard]] double north(double row) const { return origin[1] - step[1] * row; }
};

// Whether the polynomial that GDAL lays through control points is off one of them by more than a pixel; off_px: by how
// much, of the worst.
[[nodiscard]] bool points_are_bent(GDALDataset& file, double& off_px);

// Throws Failure 1 for a grid that is rotated or sheared, or absurd.
[[nodiscard]] Placement place(GDALDataset& file, const std::string& path);

// What a spacing is in units of the CRS, where that counts metres, feet and so on; 0 in degrees and without a CRS.
void crs_step_of(const double (&spacing_m)[2], const std::string& crs_wkt, double (&step)[2]);
// Units of the CRS from sample to sample; 0: not known.
[[nodiscard]] std::array<double, 2> step_of(const HeightSource& source);

// What once around the Earth is along x, in units of the CRS: 360 of degrees, the width of a map on a cylinder; 0:
// x is no longitude. middle: of the map, around which the CRS has its own places.
struct Turn {
    double length = 0, middle = 0;
};
[[nodiscard]] Turn turn_of(const OGRSpatialReference& crs);

[[nodiscard]] std::string wkt_of(const OGRSpatialReference& crs);

// Numbers of a band to metres.

// Nothing on Earth, Mars or Venus lies outside; undeclared voids (-32767, -99999, 1e38) do.
inline constexpr double lowest_m = -12000, highest_m = 30000;

// raw -> metres as in the file -> metres as asked.
struct Scaling {
    double file_scale = 1, file_offset_m = 0, zscale = 1, zoffset_m = 0;

    [[nodiscard]] double file_m(double raw) const { return raw * file_scale + file_offset_m; }
    [[nodiscard]] double asked_m(double metres) const { return metres * zscale + zoffset_m; }
    friend bool operator==(const Scaling&, const Scaling&) = default;
};

// Metres in one unit of this name, as GDAL or PROJ has it; no name means metres, 0 that it is not known.
[[nodiscard]] double unit_in_metres(const char* name);

// What the band, or the vertical axis of the CRS where the band is silent, calls its unit; empty: neither says.
[[nodiscard]] std::string unit_name(GDALRasterBand& band, const OGRSpatialReference* crs);

// From the band's scale, offset and unit, the unit of the CRS' vertical axis where the band has none, and the options.
// Throws Failure 1: a unit not known here, two units that differ, none where metres are no matter of course, an absurd
// scale.
[[nodiscard]] Scaling scaling_of(GDALRasterBand& band, const OGRSpatialReference* crs, const ReadOptions& options,
                                 const std::string& path);

} // namespace fjell::baker
