// Heights interpolated on another grid, in fixed blocks.
#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include <gdalwarper.h>
#include <ogr_spatialref.h>

#include "baker/georeference/projection.h"
#include "baker/read/gdal_file.h"
#include "baker/read/mosaic.h"
#include "baker/read/source.h"

namespace fjell::baker {

// Heights as a virtual GDAL raster, so that GDAL can transform their coordinates and interpolate between them.

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

// Blocks of the target that are interpolated one by one, whatever is asked for.
inline constexpr std::int32_t warp_block = 512;

// Target samples per source sample, at most 1: below, means are taken over wider surroundings so that nothing aliases.
// transformer: from one to the other.
[[nodiscard]] double resampling_ratio(const Transformer& transformer, const Placement& from, const Placement& to);

// One thread at a time. Throws Failure: what reading the files throws; implausible heights, and voids of the files with
// NoData::refuse, as soon as they are met, because interpolation would smear them.
class Warp {
public:
    Warp(const MosaicLayout& from, const Placement& to, const ReadOptions& options); // all must outlive it
    ~Warp();
    Warp(const Warp&) = delete;
    Warp& operator=(const Warp&) = delete;

    // Heights of a window of the target, NaN outside the source and beside its voids.
    void read(const Window& window, float* to);
    // Of the source's samples fetched since it was last asked. Where blocks reach into each other they count twice.
    [[nodiscard]] RangeEnds take_ends() { return std::exchange(ends_, {}); }

private:
    void fetch(const Window& window, float* to);
    void load(std::int32_t block_x, std::int32_t block_y);
    void add_range(const Window& samples, float& least, float& most) const; // of what was fetched
    void keep_in_range(const Window& window);

    const MosaicLayout& from_;
    const Placement& to_;
    const ReadOptions& options_;
    Mosaic mosaic_;
    PlacedDataset source_;
    Transformer transformer_;
    struct ApproximateFree {
        void operator()(void* transformer) const;
    };
    std::unique_ptr<void, ApproximateFree> approximate_;
    std::unique_ptr<GDALWarpOperation> operation_;
    RangeEnds ends_;
    double ratio_ = 1;                                           // target samples per source sample, at most 1
    std::vector<std::pair<Window, std::vector<float>>> fetched_; // for the last block
    std::vector<float> block_;                                   // the last one
    Window held_;
};

} // namespace fjell::baker
