// Heights as a virtual GDAL raster, so that GDAL can transform their coordinates and interpolate between them.
#pragma once

#include <functional>
#include <memory>

#include <ogr_spatialref.h>

#include "baker/read/placement.h"
#include "baker/read/source.h"

namespace fjell::baker {

// One band of floats, NaN where there is no height. Samples come from `read`, straight into GDAL's buffer and past its
// cache; what it throws is kept for rethrow().
class PlacedDataset final : public GDALDataset {
public:
    using Read = std::function<void(const Window&, float*)>;
    PlacedDataset(const Placement& at, const OGRSpatialReference& crs, Read read);

    CPLErr GetGeoTransform(double* transform) override;
    const OGRSpatialReference* GetSpatialRef() const override { return &crs_; }
    bool fetch(const Window& window, float* to);
    // Throws what reading threw, if it did.
    void rethrow();

private:
    Placement at_;
    OGRSpatialReference crs_;
    Read read_;
    std::exception_ptr thrown_;
};

} // namespace fjell::baker
