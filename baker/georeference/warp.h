// Heights interpolated on another grid, in fixed blocks.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <gdalwarper.h>

#include "baker/georeference/placed_dataset.h"
#include "baker/georeference/projection.h"
#include "baker/read/mosaic.h"

namespace fjell::baker {

// Blocks of the target that are interpolated one by one, whatever is asked for.
inline constexpr std::int32_t warp_block = 512;

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
    std::vector<float> block_; // the last one
    Window held_;
};

} // namespace fjell::baker
