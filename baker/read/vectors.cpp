#include "baker/read/vectors.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_api.h>
#include <ogr_spatialref.h>

#include "baker/read/gdal_file.h"

namespace fjell::baker {

namespace {

// Of GDAL's C functions, whose handles all have one type.
template <void (*destroy)(void*)>
struct Destroy {
    void operator()(void* handle) const { destroy(handle); }
};
using Feature = std::unique_ptr<void, Destroy<OGR_F_Destroy>>;
using Geometry = std::unique_ptr<void, Destroy<OGR_G_DestroyGeometry>>;
struct DestroyChange {
    void operator()(OGRCoordinateTransformation* t) const { OGRCoordinateTransformation::DestroyCT(t); }
};
using CrsChange = std::unique_ptr<OGRCoordinateTransformation, DestroyChange>;

class Reading {
public:
    Reading(const std::string& path, const VectorGrid& grid) : path_(path), grid_(grid) {}

    void layer(OGRLayerH layer) {
        change_ = change_of(layer);
        for (Feature f; f.reset(OGR_L_GetNextFeature(layer)), f;)
            if (const OGRGeometryH geometry = OGR_F_GetGeometryRef(f.get())) {
                numbers_ = numbers_of(f.get());
                if (OGR_G_HasCurveGeometry(geometry, FALSE) == TRUE) {
                    const Geometry lines(OGR_G_GetLinearGeometry(geometry, 0, nullptr));
                    if (lines) take(lines.get());
                } else {
                    take(geometry);
                }
            }
    }

    std::vector<VectorShape> shapes;

private:
    // From a layer's CRS to the grid's; none: they are the same, or one of them says none.
    [[nodiscard]] CrsChange change_of(OGRLayerH layer) const {
        const OGRSpatialReference* const said = OGRSpatialReference::FromHandle(OGR_L_GetSpatialRef(layer));
        if (said == nullptr || grid_.crs_wkt.empty()) return {};
        OGRSpatialReference from(*said), to;
        to.importFromWkt(grid_.crs_wkt.c_str());
        from.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        to.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        CrsChange change(OGRCreateCoordinateTransformation(&from, &to));
        if (!change) throw Failure(1, fmt::format("{}: its CRS does not lead to that of the heights", path_));
        return change;
    }

    [[nodiscard]] static std::vector<std::pair<std::string, double>> numbers_of(OGRFeatureH feature) {
        std::vector<std::pair<std::string, double>> numbers;
        for (int i = 0; i < OGR_F_GetFieldCount(feature); ++i) {
            if (OGR_F_IsFieldSetAndNotNull(feature, i) == FALSE) continue;
            const OGRFieldDefnH field = OGR_F_GetFieldDefnRef(feature, i);
            const char* const text = OGR_F_GetFieldAsString(feature, i);
            double value = 0;
            const auto [end, error] = std::from_chars(text, text + std::strlen(text), value);
            if (error != std::errc{}) continue;
            const std::string_view unit(end);
            if (unit.empty() || unit == " m" || unit == "m") numbers.emplace_back(OGR_Fld_GetNameRef(field), value);
        }
        return numbers;
    }

    void take(OGRGeometryH geometry) {
        switch (wkbFlatten(OGR_G_GetGeometryType(geometry))) {
        case wkbPoint:
        case wkbLineString: {
            const bool point = wkbFlatten(OGR_G_GetGeometryType(geometry)) == wkbPoint;
            VectorShape shape{point ? VectorKind::point : VectorKind::line, {places(geometry, !point)}, numbers_};
            if (!shape.parts[0].empty()) shapes.push_back(std::move(shape));
            break;
        }
        case wkbPolygon:
        case wkbTriangle: {
            VectorShape shape{VectorKind::polygon, {}, numbers_};
            for (int i = 0; i < OGR_G_GetGeometryCount(geometry); ++i)
                shape.parts.push_back(places(OGR_G_GetGeometryRef(geometry, i)));
            if (!shape.parts.empty() && !shape.parts[0].empty()) shapes.push_back(std::move(shape));
            break;
        }
        default:
            for (int i = 0; i < OGR_G_GetGeometryCount(geometry); ++i) take(OGR_G_GetGeometryRef(geometry, i));
        }
    }

    [[nodiscard]] std::vector<VectorShape::Place> places(OGRGeometryH line, bool may_be_unknown = false) const {
        // A side that is straight in one CRS is not in another.
        OGREnvelope box{};
        OGR_G_GetEnvelope(line, &box);
        constexpr double parts = 1000;
        const double longest = std::max(box.MaxX - box.MinX, box.MaxY - box.MinY) / parts;
        if (change_ && longest > 0) OGR_G_Segmentize(line, longest);
        const auto count = static_cast<std::size_t>(OGR_G_GetPointCount(line));
        std::vector<double> x(count), y(count);
        std::vector<int> known(count, TRUE);
        OGR_G_GetPoints(line, x.data(), sizeof(double), y.data(), sizeof(double), nullptr, 0);
        if (change_ && count != 0)
            change_->Transform(static_cast<int>(count), x.data(), y.data(), nullptr, nullptr, known.data());
        std::vector<VectorShape::Place> all(count);
        for (std::size_t i = 0; i < count; ++i) {
            all[i] = {(x[i] - grid_.origin[0]) / grid_.step[0], (grid_.origin[1] - y[i]) / grid_.step[1]};
            if (known[i] != FALSE && std::isfinite(x[i]) && std::isfinite(y[i])) continue;
            if (!may_be_unknown)
                throw Failure(1, fmt::format("{}: has places that the CRS of the heights does not know", path_));
            all[i] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
        }
        return all;
    }

    const std::string& path_;
    const VectorGrid& grid_;
    CrsChange change_;
    std::vector<std::pair<std::string, double>> numbers_; // of the feature that is read
};

} // namespace

VectorGrid::VectorGrid(const HeightSource& field)
    : crs_wkt(field.crs_wkt), origin{field.crs_origin[0], field.crs_origin[1]}, step(step_of(field)) {
    for (std::size_t axis = 0; axis < 2; ++axis)
        if (!(step[axis] > 0)) step[axis] = field.spacing_m[axis];
}

std::optional<double> VectorShape::number(const std::string& name) const {
    const auto found = std::ranges::find(numbers, name, &std::pair<std::string, double>::first);
    return found != numbers.end() ? std::optional(found->second) : std::nullopt;
}

std::vector<VectorShape> read_vectors(const std::string& path, const VectorGrid& grid, const char* what,
                                      const std::string& layer) {
    GdalMessages messages;
    register_drivers();
    const GdalFile file(GDALDataset::FromHandle(
        GDALOpenEx(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr)));
    if (!file) throw Failure(1, fmt::format("{}: is no file of {} that GDAL reads{}", path, what, messages.said()));
    Reading reading(path, grid);
    const GDALDatasetH handle = GDALDataset::ToHandle(file.get());
    std::string names;
    bool found = layer.empty();
    for (int l = 0; l < GDALDatasetGetLayerCount(handle); ++l) {
        const OGRLayerH one = GDALDatasetGetLayer(handle, l);
        const std::string name = OGR_L_GetName(one);
        names += (names.empty() ? "" : ", ") + name;
        if (!layer.empty() && name != layer) continue;
        found = true;
        reading.layer(one);
    }
    if (!found) throw Failure(1, fmt::format("{}: has no layer \"{}\"; its layers are {}", path, layer, names));
    return std::move(reading.shapes);
}

void for_stretches_inside(std::span<const std::span<const VectorShape::Place>> pieces, const Window& w,
                          const std::function<void(std::int32_t row, std::int32_t first, std::int32_t last)>& stretch) {
    using Place = VectorShape::Place;
    std::vector<std::vector<double>> crossings(static_cast<std::size_t>(w.rows));
    for (const std::span<const Place> piece : pieces)
        for (std::size_t i = 1; i < piece.size(); ++i) {
            const auto [a, b] =
                std::minmax(piece[i - 1], piece[i], [](const Place& p, const Place& q) { return p[1] < q[1]; });
            const double from = std::max(std::ceil(a[1]), static_cast<double>(w.y)),
                         to = std::min(std::ceil(b[1]), static_cast<double>(w.y + w.rows));
            for (double y = from; y < to; ++y)
                crossings[static_cast<std::size_t>(y - w.y)].push_back(a[0] +
                                                                       (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]));
        }
    for (std::int32_t row = 0; row < w.rows; ++row) {
        std::vector<double>& at = crossings[static_cast<std::size_t>(row)];
        std::ranges::sort(at);
        for (std::size_t i = 0; i + 1 < at.size(); i += 2) {
            const double from = std::max(std::ceil(at[i]), static_cast<double>(w.x)),
                         to = std::min(std::floor(at[i + 1]), static_cast<double>(w.x + w.columns - 1));
            if (from <= to) stretch(w.y + row, static_cast<std::int32_t>(from), static_cast<std::int32_t>(to));
        }
    }
}

} // namespace fjell::baker
