#include "baker/georeference/placed_dataset.h"

#include <exception>
#include <limits>
#include <utility>

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

} // namespace fjell::baker
