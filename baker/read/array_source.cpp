#include "baker/read/array_source.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <ogr_spatialref.h>

#include "baker/georeference/projection.h"
#include "baker/read/decode.h"
#include "baker/read/void_check.h"
#include "baker/read/windows.h"
#include "fjell/pack.h"
#include "shared/hash.h"

namespace fjell::baker {

namespace {

constexpr const char* type_names[] = {"int8",   "uint8", "int16",  "uint16",  "int32",
                                      "uint32", "int64", "uint64", "float32", "float64"};

// What numbers become heights by.
struct ArrayReading {
    HeightArray array;
    ReadOptions options;
    Decoding decoding;
};

class ArrayReader final : public HeightReader {
public:
    explicit ArrayReader(const ArrayReading& reading) : reading_(reading) {}

    void read(const Window& window, float* to, ReadStatistics& statistics) override {
        row_.resize(static_cast<std::size_t>(window.columns));
        for (std::int32_t y = window.y; y < window.y + window.rows; ++y, to += window.columns) {
            reading_.array.read(y, window.x, window.columns, row_.data());
            decode_row(row_.data(), nullptr, to, row_.size(), reading_.decoding, {window.x, y}, statistics);
        }
    }

private:
    const ArrayReading& reading_;
    std::vector<double> row_;
};

class ArraySource final : public HeightSource {
public:
    ArraySource(const HeightArray& array, const ArrayPlace& place, const ReadOptions& options)
        : reading_{array, options, {}} {
        if (array.columns < 2 || array.rows < 2)
            throw Failure(1, fmt::format("heights: has {} x {} samples; a height field needs at least 2 x 2",
                                         array.columns, array.rows));
        if (std::max(array.columns, array.rows) > max_columns)
            throw Failure(1, fmt::format("heights: has {} x {} samples; a pack takes {} a side at most", array.columns,
                                         array.rows, max_columns));
        columns = static_cast<std::int32_t>(array.columns), rows = static_cast<std::int32_t>(array.rows);
        std::copy_n(place.spacing_m, 2, spacing_m);
        facts.type = type_names[static_cast<int>(array.type)];
        facts.driver = "array";
        facts.voids = array.mask ? "mask" : "";
        facts.height_unit_m = options.zscale.value_or(1);
        Decoding& d = reading_.decoding;
        d.scaling = {1, 0, options.zscale.value_or(1), options.zoffset_m};
        d.whole = array.whole();
        d.all_ground = options.voids.no_others;
        for (const double number : options.voids.numbers) d.voids.push_back({number, 0});
        if (!place.crs.empty()) set_crs(place);
    }
    [[nodiscard]] std::unique_ptr<HeightReader> reader() const override {
        return std::make_unique<ArrayReader>(reading_);
    }
    [[nodiscard]] std::vector<Window> windows(std::size_t most) const override {
        return cut_along({0, 0, columns, rows}, {columns, 1, 0, 0}, most);
    }
    [[nodiscard]] SourceProperties properties(const ReadStatistics& statistics) const override {
        const ReadOptions& o = reading_.options;
        const Scaling& scaling = reading_.decoding.scaling;
        const std::uint64_t samples = static_cast<std::uint64_t>(columns) * static_cast<std::uint64_t>(rows);
        const VoidCheck check{"heights", o.nodata, o.voids.no_others, samples, false, scaling};
        refuse_voids(statistics, check);
        SourceProperties s;
        if (!check.no_others) tell_voids(find_voids(statistics.ends, true), check, s);
        s.holes = statistics.voids.count + statistics.implausible.count > 0 && o.nodata != NoData::fill;
        s.anchor_m = scaling.asked_m(0);
        if (statistics.per_unit <= 100) s.native_quantum_m = std::abs(scaling.zscale) / statistics.per_unit;
        return s;
    }
    // Of its numbers: an array has no name, and whoever calls again may have changed it.
    [[nodiscard]] std::string identity() const override {
        std::uint64_t hash = 0;
        std::vector<double> row(static_cast<std::size_t>(columns) + 1);
        for (std::int32_t y = 0; y < rows; ++y) {
            reading_.array.read(y, 0, columns, row.data());
            std::memcpy(&row.back(), &hash, sizeof hash);
            hash = hash_of(row.data(), row.size() * sizeof row[0]);
        }
        const ReadOptions& o = reading_.options;
        return fmt::format("array {} {} x {} {:016x} spacing {} {} crs {} origin {} {} zscale {} zoffset {} nodata {} "
                           "void {}{}",
                           facts.type, columns, rows, hash, spacing_m[0], spacing_m[1], crs_wkt, crs_origin[0],
                           crs_origin[1], o.zscale.value_or(1), o.zoffset_m, static_cast<int>(o.nodata),
                           fmt::join(o.voids.numbers, " "), o.voids.no_others ? " none" : "");
    }

private:
    void set_crs(const ArrayPlace& place) {
        const GdalMessages messages;
        OGRSpatialReference crs;
        if (crs.SetFromUserInput(place.crs.c_str()) != OGRERR_NONE || messages.failed())
            throw Failure(2, fmt::format("crs: {}: no CRS that GDAL knows{}; give one such as EPSG:25832", place.crs,
                                         messages.said()));
        if (!crs.IsProjected())
            throw Failure(2, fmt::format("crs: {}: is not projected; an array is not reprojected, so reproject it "
                                         "first, or write it to a file and bake that",
                                         place.crs));
        crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        crs_wkt = wkt_of(crs);
        std::copy_n(place.crs_origin, 2, crs_origin);
        crs_step_of(spacing_m, crs_wkt, crs_step);
    }

    ArrayReading reading_;
};

} // namespace

std::unique_ptr<HeightSource> array_source(const HeightArray& array, const ArrayPlace& place,
                                           const ReadOptions& options) {
    return std::make_unique<ArraySource>(array, place, options);
}

} // namespace fjell::baker
