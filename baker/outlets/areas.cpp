#include "baker/outlets/areas.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <type_traits>

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_api.h>
#include <ogr_spatialref.h>

#include "baker/outlets/globe.h"
#include "baker/read/gdal_file.h"

namespace fjell::baker {

namespace {

struct DestroyFeature {
    void operator()(OGRFeatureH f) const { OGR_F_Destroy(f); }
};
using Feature = std::unique_ptr<std::remove_pointer_t<OGRFeatureH>, DestroyFeature>;
struct DestroyChange {
    void operator()(OGRCoordinateTransformation* t) const { OGRCoordinateTransformation::DestroyCT(t); }
};
using CrsChange = std::unique_ptr<OGRCoordinateTransformation, DestroyChange>;

// From a layer's CRS to the field's; none: they are the same, or one of them says none.
CrsChange change_of(OGRLayerH layer, const HeightSource& field, const std::string& path) {
    const OGRSpatialReference* const said = OGRSpatialReference::FromHandle(OGR_L_GetSpatialRef(layer));
    if (said == nullptr || field.crs_wkt.empty()) return {};
    OGRSpatialReference from(*said), to;
    to.importFromWkt(field.crs_wkt.c_str());
    from.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    to.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    CrsChange change(OGRCreateCoordinateTransformation(&from, &to));
    if (!change) throw Failure(1, fmt::format("{}: its CRS does not lead to that of the heights", path));
    return change;
}

// rings(ring): each ring of the polygons in a geometry, whatever collects them.
template <typename Rings>
void for_rings(OGRGeometryH geometry, std::uint32_t& areas, const Rings& rings) {
    const OGRwkbGeometryType type = wkbFlatten(OGR_G_GetGeometryType(geometry));
    if (type == wkbPolygon) ++areas;
    for (int i = 0; i < OGR_G_GetGeometryCount(geometry); ++i) {
        const OGRGeometryH part = OGR_G_GetGeometryRef(geometry, i);
        if (type == wkbPolygon)
            rings(part, areas);
        else
            for_rings(part, areas, rings);
    }
}

} // namespace

Areas::Areas(const std::string& path, const HeightSource& field) : columns_(field.columns) {
    GdalMessages messages;
    register_drivers();
    const GdalFile file(GDALDataset::FromHandle(
        GDALOpenEx(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr)));
    if (!file) throw Failure(1, fmt::format("{}: is no file of polygons that GDAL reads{}", path, messages.said()));
    const std::array<double, 2> step = step_of(field);
    const GDALDatasetH handle = GDALDataset::ToHandle(file.get());
    for (int l = 0; l < GDALDatasetGetLayerCount(handle); ++l) {
        const OGRLayerH layer = GDALDatasetGetLayer(handle, l);
        const CrsChange change = change_of(layer, field, path);
        const auto add_ring = [&](OGRGeometryH ring, std::uint32_t area) {
            // A side that is straight in one CRS is not in another.
            OGREnvelope box{};
            OGR_G_GetEnvelope(ring, &box);
            constexpr double parts = 1000;
            const double longest = std::max(box.MaxX - box.MinX, box.MaxY - box.MinY) / parts;
            if (change && longest > 0) OGR_G_Segmentize(ring, longest);
            std::optional<std::array<double, 2>> before;
            for (int i = 0; i < OGR_G_GetPointCount(ring); ++i) {
                double x = OGR_G_GetX(ring, i), y = OGR_G_GetY(ring, i);
                if ((change && !change->Transform(1, &x, &y)) || !std::isfinite(x) || !std::isfinite(y))
                    throw Failure(1, fmt::format("{}: has places that the CRS of the heights does not know", path));
                const std::array at{(x - field.crs_origin[0]) / step[0], (field.crs_origin[1] - y) / step[1]};
                if (before && (*before)[1] != at[1]) {
                    const auto& [a, b] = (*before)[1] < at[1] ? std::pair{*before, at} : std::pair{at, *before};
                    edges_.push_back({a[0], a[1], b[0], b[1], area - 1});
                }
                before = at;
            }
        };
        for (Feature f; f.reset(OGR_L_GetNextFeature(layer)), f;)
            if (const OGRGeometryH geometry = OGR_F_GetGeometryRef(f.get())) for_rings(geometry, areas_, add_ring);
    }
    if (edges_.empty()) throw Failure(1, fmt::format("{}: has no polygon", path));
    std::ranges::sort(edges_, {}, &Edge::y0);
    for (std::int32_t row = 0; row < field.rows; ++row)
        if (!inside(row).empty()) return;
    throw Failure(1,
                  fmt::format("{}: no sample lies in its polygons; they are elsewhere, or smaller than cells", path));
}

// Area by area, as a ring inside of another is a hole of it alone.
Areas::Runs Areas::inside(std::int32_t row) const {
    std::vector<std::pair<std::uint32_t, double>> crossings;
    for (const Edge& e : edges_) {
        if (e.y0 > row) break;
        if (e.y1 > row) crossings.emplace_back(e.area, e.x0 + (row - e.y0) / (e.y1 - e.y0) * (e.x1 - e.x0));
    }
    std::ranges::sort(crossings);
    Runs runs;
    const auto column = [&](double x) {
        return static_cast<std::int32_t>(std::clamp(std::ceil(x), 0.0, static_cast<double>(columns_)));
    };
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2)
        if (const std::pair run{column(crossings[i].second), column(crossings[i + 1].second)}; run.first < run.second)
            runs.push_back(run);
    std::ranges::sort(runs);
    Runs merged;
    for (const auto& run : runs)
        if (!merged.empty() && run.first <= merged.back().second)
            merged.back().second = std::max(merged.back().second, run.second);
        else
            merged.push_back(run);
    return merged;
}

} // namespace fjell::baker
