// GDAL's warper gives other numbers when it is given other chunks or other memory. Here its kernel is given one block
// at a time, always the same ones, with a fixed resampling ratio and fixed bounds of transformation, so that a sample
// depends on nothing but its place. Cubic interpolation keeps crests and valleys that bilinear flattens; beside a void,
// where it lacks one of its 16 samples, GDAL falls back to the bilinear of those that there are.
#include "baker/georeference/warp.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <utility>

#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal_alg.h>

namespace fjell::baker {

namespace {

class PlacedBand final : public GDALRasterBand {
public:
    PlacedBand(PlacedDataset* dataset, const Placement& at) : dataset_(*dataset) {
        poDS = dataset;
        nBand = 1;
        nRasterXSize = at.columns;
        nRasterYSize = at.rows;
        eDataType = GDT_Float32;
        nBlockXSize = at.columns;
        nBlockYSize = 1;
    }
    double GetNoDataValue(int* known) override {
        if (known) *known = TRUE;
        return std::numeric_limits<double>::quiet_NaN();
    }

protected:
    CPLErr IReadBlock(int, int y, void* to) override {
        return dataset_.fetch({0, y, nRasterXSize, 1}, static_cast<float*>(to)) ? CE_None : CE_Failure;
    }
    CPLErr IRasterIO(GDALRWFlag flag, int x, int y, int columns, int rows, void* to, int to_columns, int to_rows,
                     GDALDataType type, GSpacing pixel, GSpacing line, GDALRasterIOExtraArg* extra) override {
        if (flag == GF_Read && type == GDT_Float32 && columns == to_columns && rows == to_rows && pixel == 4 &&
            line == 4 * static_cast<GSpacing>(columns))
            return dataset_.fetch({x, y, columns, rows}, static_cast<float*>(to)) ? CE_None : CE_Failure;
        return GDALRasterBand::IRasterIO(flag, x, y, columns, rows, to, to_columns, to_rows, type, pixel, line, extra);
    }

private:
    PlacedDataset& dataset_;
};

} // namespace

PlacedDataset::PlacedDataset(const Placement& at, const OGRSpatialReference& crs, Read read)
    : at_(at), crs_(crs), read_(std::move(read)) {
    nRasterXSize = at.columns;
    nRasterYSize = at.rows;
    SetBand(1, new PlacedBand(this, at)); // the dataset owns it
}

CPLErr PlacedDataset::GetGeoTransform(double* transform) {
    const double placed[6] = {at_.east(-0.5), at_.step[0], 0, at_.north(-0.5), 0, -at_.step[1]};
    std::copy_n(placed, 6, transform);
    return CE_None;
}

bool PlacedDataset::fetch(const Window& window, float* to) {
    if (thrown_) return false;
    try {
        read_(window, to);
        return true;
    } catch (...) { // GDAL knows no exceptions
        thrown_ = std::current_exception();
        return false;
    }
}

void PlacedDataset::rethrow() {
    if (const std::exception_ptr thrown = std::exchange(thrown_, nullptr)) std::rethrow_exception(thrown);
}

namespace {

constexpr float nothing = std::numeric_limits<float>::quiet_NaN();

double* one_number(double value) {
    auto* const number = static_cast<double*>(CPLMalloc(sizeof(double)));
    *number = value;
    return number;
}
int* first_band() {
    auto* const band = static_cast<int*>(CPLMalloc(sizeof(int)));
    *band = 1;
    return band;
}

// Places of the source are right to this many samples: exact transformation of every sample took ten times as long as
// all else. GDAL interpolates along rows of what it is given, which are always the same blocks.
constexpr double place_error = 0.01;

struct OptionsFree {
    void operator()(GDALWarpOptions* options) const { GDALDestroyWarpOptions(options); }
};

} // namespace

// In the middle of the source, or of the target where that is elsewhere.
double resampling_ratio(const Transformer& transformer, const Placement& from, const Placement& to) {
    double x = 0.5 * to.columns, y = 0.5 * to.rows;
    double middle_x = 0.5 * from.columns, middle_y = 0.5 * from.rows;
    if (double tx = middle_x, ty = middle_y;
        !transformer.to_target(tx, ty) || tx < 0 || ty < 0 || tx > to.columns || ty > to.rows)
        if (transformer.to_source(x, y)) middle_x = x, middle_y = y;
    double area = 1;
    for (const int axis : {0, 1}) {
        double ax = middle_x - 0.5 * (axis == 0), ay = middle_y - 0.5 * (axis == 1);
        double bx = middle_x + 0.5 * (axis == 0), by = middle_y + 0.5 * (axis == 1);
        if (!transformer.to_target(ax, ay) || !transformer.to_target(bx, by)) return 1;
        area *= std::hypot(bx - ax, by - ay);
    }
    const double scale = std::sqrt(area);
    return scale < 0.8 && scale > 0.001 ? scale : 1;
}

Warp::Warp(const MosaicLayout& from, const Placement& to, const ReadOptions& options)
    : from_(from), to_(to), options_(options), mosaic_(from, options),
      source_(from.at, source_crs(from.at), [this](const Window& window, float* heights) { fetch(window, heights); }),
      transformer_(source_, to.crs_wkt, from.files.front().facts.path) {
    transformer_.set_target(to);
    const std::unique_ptr<GDALWarpOptions, OptionsFree> o(GDALCreateWarpOptions());
    o->eResampleAlg = GRA_Cubic;
    o->eWorkingDataType = GDT_Float32;
    o->hSrcDS = GDALDataset::ToHandle(&source_);
    o->nBandCount = 1;
    o->panSrcBands = first_band();
    o->panDstBands = first_band();
    o->padfSrcNoDataReal = one_number(nothing);
    o->padfDstNoDataReal = one_number(nothing);
    approximate_.reset(GDALCreateApproxTransformer(transformer_.function(), transformer_.argument(), place_error));
    o->pfnTransformer = GDALApproxTransform;
    o->pTransformerArg = approximate_.get();
    CPLStringList settings;
    settings.SetNameValue("NUM_THREADS", "1");
    settings.SetNameValue("SAMPLE_GRID", "YES");
    settings.SetNameValue("SOURCE_EXTRA", "4");
    ratio_ = resampling_ratio(transformer_, from.at, to);
    const std::string scale = fmt::format("{}", ratio_);
    settings.SetNameValue("XSCALE", scale.c_str());
    settings.SetNameValue("YSCALE", scale.c_str());
    o->papszWarpOptions = settings.StealList();
    const GdalMessages messages;
    operation_ = std::make_unique<GDALWarpOperation>();
    if (operation_->Initialize(o.get()) != CE_None)
        throw Failure(1, fmt::format("{}: cannot be reprojected{}", from.files.front().facts.path, messages.said()));
}

Warp::~Warp() = default;
void Warp::ApproximateFree::operator()(void* transformer) const {
    GDALDestroyApproxTransformer(transformer);
}

void Warp::fetch(const Window& window, float* to) {
    ReadStatistics statistics;
    mosaic_.read(window, to, statistics);
    fetched_.push_back({window, {to, to + window.area()}});
    ends_.add(statistics.ends);
    const bool ask = options_.nodata == NoData::automatic || options_.nodata == NoData::refuse;
    if (ask && statistics.implausible.count)
        throw Failure(1, fmt::format("{}: has heights outside {}..{} m, such as {} m at column {}, row {}; if they are "
                                     "voids, give --nodata hole to leave them open or --nodata fill to fill them from "
                                     "their neighbours; if the unit is another, give --zscale S",
                                     from_.files.front().facts.path, lowest_m, highest_m, statistics.implausible_m,
                                     statistics.implausible.column, statistics.implausible.row));
    if (options_.nodata == NoData::refuse && statistics.voids.count)
        throw Failure(1, fmt::format("{}: has samples that are no-data or NaN, such as at column {}, row {}; give "
                                     "--nodata hole to leave them open or --nodata fill to fill them from their "
                                     "neighbours",
                                     from_.files.front().facts.path, statistics.voids.column, statistics.voids.row));
}

void Warp::add_range(const Window& samples, float& least, float& most) const {
    for (const auto& [window, heights] : fetched_) {
        const std::int32_t right = std::min(samples.x + samples.columns, window.x + window.columns);
        const std::int32_t bottom = std::min(samples.y + samples.rows, window.y + window.rows);
        for (std::int32_t y = std::max(samples.y, window.y); y < bottom; ++y) {
            const float* const row = heights.data() + static_cast<std::ptrdiff_t>(y - window.y) * window.columns;
            for (std::int32_t x = std::max(samples.x, window.x); x < right; ++x) {
                const float height = row[x - window.x]; // NaN changes neither
                if (height < least) least = height;
                if (height > most) most = height;
            }
        }
    }
}

// Cubic interpolation overshoots: beside a cliff it digs a trench into level ground. No height may lie outside those of
// the samples that its place lies between: four, and more where a sample of the target is wider than one of the source.
void Warp::keep_in_range(const Window& window) {
    constexpr double widest = 4; // beyond it means are taken over so much that all that was fetched bounds them
    const double more = 1 / ratio_ - 1 + place_error;
    const bool means = 1 / ratio_ > widest;
    float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
    if (means)
        for (const auto& fetched : fetched_) add_range(fetched.first, lowest, highest);
    const auto columns = static_cast<std::size_t>(window.columns);
    std::vector<double> x(columns), y(columns), z(columns);
    std::vector<int> there(columns);
    const auto index = [](double place) { return static_cast<std::int32_t>(std::floor(place)); };
    for (std::int32_t row = 0; row < window.rows; ++row) {
        for (std::size_t i = 0; i < columns; ++i) {
            x[i] = window.x + static_cast<double>(i) + 0.5;
            y[i] = window.y + row + 0.5;
            z[i] = 0;
        }
        (void)GDALApproxTransform(approximate_.get(), TRUE, window.columns, x.data(), y.data(), z.data(), there.data());
        float* const heights = block_.data() + static_cast<std::size_t>(row) * columns;
        for (std::size_t i = 0; i < columns; ++i) {
            if (there[i] == 0 || std::isnan(heights[i])) continue;
            float least = lowest, most = highest;
            if (!means) {
                const double u = x[i] - 0.5, v = y[i] - 0.5; // counted in samples
                const std::int32_t left = index(u - more), top = index(v - more);
                add_range({left, top, index(u + more) + 2 - left, index(v + more) + 2 - top}, least, most);
            }
            if (least <= most) heights[i] = std::clamp(heights[i], least, most);
        }
    }
}

void Warp::load(std::int32_t block_x, std::int32_t block_y) {
    const std::int32_t x = block_x * warp_block, y = block_y * warp_block;
    const Window window{x, y, std::min(warp_block, to_.columns - x), std::min(warp_block, to_.rows - y)};
    if (window == held_) return;
    held_ = {};
    fetched_.clear();
    block_.assign(window.area(), nothing);
    // GDAL calls a block that no place of the source falls in an error.
    constexpr int probes = 8;
    bool anywhere = false;
    for (int j = 0; j <= probes; ++j)
        for (int i = 0; i <= probes && !anywhere; ++i) {
            double px = x + static_cast<double>(window.columns) * i / probes;
            double py = y + static_cast<double>(window.rows) * j / probes;
            anywhere = transformer_.to_source(px, py);
        }
    if (anywhere) {
        const GdalMessages messages;
        const CPLErr result =
            operation_->WarpRegionToBuffer(x, y, window.columns, window.rows, block_.data(), GDT_Float32);
        source_.rethrow();
        if (result != CE_None) // what it says otherwise is about places that the projection does not know
            throw Failure(3, fmt::format("{}: could not be reprojected at columns {} to {}, rows {} to {}{}",
                                         from_.files.front().facts.path, x, x + window.columns - 1, y,
                                         y + window.rows - 1, messages.said()));
        keep_in_range(window);
    }
    held_ = window;
}

void Warp::read(const Window& window, float* to) {
    const std::int32_t right = window.x + window.columns, bottom = window.y + window.rows;
    for (std::int32_t by = window.y / warp_block; by * warp_block < bottom; ++by)
        for (std::int32_t bx = window.x / warp_block; bx * warp_block < right; ++bx) {
            load(bx, by);
            const std::int32_t from_x = std::max(window.x, held_.x), to_x = std::min(right, held_.x + held_.columns);
            const std::int32_t from_y = std::max(window.y, held_.y), to_y = std::min(bottom, held_.y + held_.rows);
            for (std::int32_t y = from_y; y < to_y; ++y)
                std::copy_n(block_.data() +
                                static_cast<std::size_t>(y - held_.y) * static_cast<std::size_t>(held_.columns) +
                                static_cast<std::size_t>(from_x - held_.x),
                            to_x - from_x,
                            to + static_cast<std::size_t>(y - window.y) * static_cast<std::size_t>(window.columns) +
                                static_cast<std::size_t>(from_x - window.x));
        }
}

} // namespace fjell::baker
