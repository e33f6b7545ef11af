// A raster file through GDAL, with GDAL's messages caught instead of printed. Shared by heights and images.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <gdal_priv.h>

#include "fjell/io/failure.h"

namespace fjell::baker {

using io::Failure;

// Before anything else of GDAL, once for the whole process; safe to repeat. Whoever has GdalMessages has called it.
// Throws Failure 3: GDAL is not installed.
void load_gdal();
void register_drivers(); // and loads it

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
// as NETCDF:"file.nc":variable pass through to GDAL. what: "a height field" or "an image", for the messages.
[[nodiscard]] GdalFile open_raster(const std::string& path, const char* what, GdalMessages& messages);

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

} // namespace fjell::baker
