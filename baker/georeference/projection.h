// From degrees, or any CRS, to a square grid in metres.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include <gdal_alg.h>
#include <ogr_spatialref.h>

#include "baker/read/gdal_file.h"
#include "baker/read/options.h"

namespace fjell::baker {

// A projected CRS for a field of these extents in degrees, of the same datum: UTM for at most 12 degrees of longitude
// between 84 degrees south and north, polar stereographic about a pole, else Lambert's azimuthal equal-area projection
// about the middle. Null when more than 90 degrees are spanned, which no projection shows without great distortion,
// unless all of it lies within 30 degrees of a pole: then the usual polar stereographic projection.
[[nodiscard]] std::unique_ptr<OGRSpatialReference> crs_for(const OGRSpatialReference& geographic, double west,
                                                           double south, double east, double north);

// Where to reproject to.
struct ReprojectionTarget {
    std::unique_ptr<OGRSpatialReference> crs;  // null: samples stay where they are
    std::optional<std::array<double, 4>> bbox; // in its units; none: all of the field
};

// Throws Failure: 1 degrees that need a decision; 2 a crs that is none or not projected. A box that meets a field of
// degrees in degrees counts in these. Of a field for which there is no automatic CRS it must, and the CRS is one for
// that box.
[[nodiscard]] ReprojectionTarget choose_target(const Placement& from, const ReadOptions& options,
                                               const std::string& path);

// GDAL's exact transformation between a raster of one CRS and one of another. One thread.
class Transformer {
public:
    // from: its crs_wkt, or longitude and latitude on WGS 84 when it has degrees and none.
    Transformer(GDALDataset& from, const std::string& crs_wkt, const std::string& path);
    ~Transformer();
    Transformer(const Transformer&) = delete;
    Transformer& operator=(const Transformer&) = delete;

    // For GDAL: what transforms, and what it takes first. Columns of a source that goes round once and a little more
    // are wrapped into it, which GDAL gives up: rounded steps, and columns at both ends, make that little. So are those
    // of a map on a cylinder that goes on beyond its edge, across the antimeridian.
    [[nodiscard]] GDALTransformerFunc function() const;
    [[nodiscard]] void* argument() const;
    void set_target(const Placement& to);
    // Columns and rows, pixel edges at whole numbers. False: no such place.
    bool to_source(double& x, double& y) const;
    bool to_target(double& x, double& y) const;

private:
    bool transform(int backwards, double& x, double& y) const;
    void* argument_ = nullptr;
    static int wrap(void* self, int backwards, int count, double* x, double* y, double* z, int* good);
    double columns_ = 0, turn_ = 0; // of the source; columns of a full circle, 0: none are wrapped
};

// The grid of the reprojected field: square, its spacing --spacing or that of the source in the middle to three
// digits, edges on multiples of it, so that neighbours fit; around the bbox if there is one, else around the source.
// Throws Failure 1: outside, or too large.
[[nodiscard]] Placement target_grid(GDALDataset& from, const ReprojectionTarget& target, const ReadOptions& options,
                                    const std::string& path);

// What its angles count: "degrees", "grads", ...
[[nodiscard]] std::string angle_name(const OGRSpatialReference& crs);

// The CRS of what has degrees, without its vertical part.
[[nodiscard]] OGRSpatialReference source_crs(const Placement& from);

} // namespace fjell::baker
