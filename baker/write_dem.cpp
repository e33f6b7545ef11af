#include "baker/read.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <ogr_spatialref.h>

#include "baker/gdal_file.h"
#include "baker/placement.h"
#include "host/file.h"

namespace fjell::baker {

namespace {

// A file in memory, so that the disk only ever sees a complete one.
class MemoryFile {
public:
    MemoryFile() : name_(fmt::format("/vsimem/fjell-{}.tif", static_cast<const void*>(this))) {}
    ~MemoryFile() { VSIUnlink(name_.c_str()); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;

    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] std::span<const std::byte> bytes() const {
        vsi_l_offset size = 0;
        const GByte* const data = VSIGetMemFileBuffer(name_.c_str(), &size, FALSE);
        return {reinterpret_cast<const std::byte*>(data), data ? static_cast<std::size_t>(size) : 0};
    }

private:
    std::string name_;
};

// 16 bits with scale and offset, when every height comes back from them bit for bit.
struct Lattice16 {
    double step_m, base_m;
    [[nodiscard]] double steps(float height) const { return std::round((height - base_m) / step_m); }
};
std::optional<Lattice16> lattice_of(const Dem& dem) {
    if (!(dem.native_quantum_m > 0)) return {};
    const auto [least, most] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    const double q = dem.native_quantum_m;
    // The base is itself a whole number of steps where it can be: 123.4f is not 123.4.
    const double whole = std::round(*least / q) * q;
    const Lattice16 lattice{q, static_cast<float>(whole) == *least ? whole : *least};
    if (lattice.steps(*most) > 65535) return {};
    const bool exact = std::all_of(dem.heights_m.begin(), dem.heights_m.end(), [&](float h) {
        return static_cast<float>(lattice.steps(h) * lattice.step_m + lattice.base_m) == h;
    });
    return exact ? std::optional(lattice) : std::nullopt;
}

void set_place(GDALDataset& file, const Dem& dem) {
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
    std::array<double, 6> t{dem.origin_m[0] - step[0] / 2, step[0], 0, dem.origin_m[1] + step[1] / 2, 0, -step[1]};
    file.SetGeoTransform(t.data());
    file.SetSpatialRef(&crs);
}

bool write_rows(GDALDataset& file, const Dem& dem, const std::optional<Lattice16>& lattice, DemForm form) {
    GDALRasterBand& band = *file.GetRasterBand(1);
    const bool open_holes = form == DemForm::plain && !dem.voids.empty();
    if (open_holes) band.SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
    if (lattice) {
        band.SetScale(lattice->step_m);
        band.SetOffset(lattice->base_m);
    }
    band.SetUnitType("m");
    const auto columns = static_cast<std::size_t>(dem.columns);
    std::vector<float> row(columns);
    for (int y = 0; y < dem.rows; ++y) {
        const float* const from = dem.heights_m.data() + static_cast<std::size_t>(y) * columns;
        std::transform(from, from + columns, row.begin(),
                       [&](float h) { return lattice ? static_cast<float>(lattice->steps(h)) : h; });
        for (int x = 0; open_holes && x < dem.columns; ++x)
            if (dem.is_void(x, y)) row[static_cast<std::size_t>(x)] = std::numeric_limits<float>::quiet_NaN();
        if (band.RasterIO(GF_Write, 0, y, dem.columns, 1, row.data(), dem.columns, 1, GDT_Float32, 0, 0, nullptr) !=
            CE_None)
            return false;
    }
    return true;
}

} // namespace

void write_dem(const Dem& dem, const std::string& path, DemForm form) {
    host::AtomicFile out(path); // first: a missing folder should not cost the work
    GdalMessages messages;
    register_drivers();
    GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    if (!driver) throw Failure(3, fmt::format("{}: this GDAL has no GeoTIFF driver; install libgdal with it", path));
    const std::optional<Lattice16> lattice = form == DemForm::plain ? std::nullopt : lattice_of(dem);
    CPLStringList options;
    options.SetNameValue("COMPRESS", "DEFLATE");
    options.SetNameValue("PREDICTOR", lattice ? "2" : "3");
    options.SetNameValue("BIGTIFF", "IF_SAFER");
    const MemoryFile memory;
    GdalFile file(driver->Create(memory.name().c_str(), dem.columns, dem.rows, 1, lattice ? GDT_UInt16 : GDT_Float32,
                                 options.List()));
    bool written = file != nullptr;
    if (written) {
        set_place(*file, dem);
        written = write_rows(*file, dem, lattice, form);
    }
    file.reset(); // closing writes the rest
    if (!written || messages.failed() || memory.bytes().empty())
        throw Failure(3, fmt::format("{}: cannot be written; is there enough memory?{}", path, messages.said()));
    out.write(memory.bytes());
    out.commit();
}

void write_dem(const HeightSource& source, const std::string& path, DemForm form) {
    write_dem(read_dem(source, path), path, form);
}

} // namespace fjell::baker
