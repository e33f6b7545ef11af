#include "baker/outlets/globe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "baker/read/gdal_file.h"

namespace fjell::baker {

namespace {

constexpr double radian = std::numbers::pi / 180;
constexpr double squashed =
    (globe_polar_radius_m / globe_radius_m) * (globe_polar_radius_m / globe_radius_m); // 1 - e^2

OGRSpatialReference wgs84() {
    OGRSpatialReference crs;
    crs.importFromEPSG(4326);
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return crs;
}

OGRSpatialReference crs_of(const HeightSource& source) {
    OGRSpatialReference crs;
    crs.importFromWkt(source.crs_wkt.c_str());
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    crs.StripVertical();
    return crs;
}

double distance_m(const GlobePlace& a, const GlobePlace& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

} // namespace

GlobePlace up_at(LonLat at) {
    const double c = std::cos(at.latitude * radian);
    return {c * std::cos(at.longitude * radian), c * std::sin(at.longitude * radian), std::sin(at.latitude * radian)};
}

GlobePlace on_globe(LonLat at, double height_m) {
    const GlobePlace up = up_at(at);
    const double n = globe_radius_m / std::sqrt(1 - (1 - squashed) * up[2] * up[2]);
    return {(n + height_m) * up[0], (n + height_m) * up[1], (n * squashed + height_m) * up[2]};
}

LonLat lon_lat_of(const GlobePlace& place) {
    const double across = std::hypot(place[0], place[1]);
    return {std::atan2(place[1], place[0]) / radian, std::atan2(place[2], across * squashed) / radian};
}

double near_longitude(double longitude, double middle) {
    return longitude - 360 * std::round((longitude - middle) / 360);
}

std::int32_t tiles_across(Tiling tiling, std::int32_t level) {
    return (tiling == Tiling::geographic ? 2 : 1) << level;
}
std::int32_t tiles_down(std::int32_t level) {
    return 1 << level;
}

DegreeBox box_of(Tiling tiling, TileId tile) {
    const double across = tiles_across(tiling, tile.level), down = tiles_down(tile.level);
    const auto longitude = [&](std::int32_t x) { return 360 * (x / across) - 180; };
    const auto latitude = [&](std::int32_t y) {
        if (tiling == Tiling::geographic) return 180 * (y / down) - 90;
        return std::atan(std::sinh(std::numbers::pi * (2 * (y / down) - 1))) / radian;
    };
    return {longitude(tile.x), latitude(tile.y), longitude(tile.x + 1), latitude(tile.y + 1)};
}

double assumed_error_m(Tiling tiling, std::int32_t level) {
    constexpr double texels = 65, share = 0.25;
    return globe_radius_m * 2 * std::numbers::pi * share / (texels * tiles_across(tiling, level));
}

SamplePlaces::SamplePlaces(const HeightSource& source, const std::string& name) {
    const auto [step_x, step_y] = step_of(source);
    if (source.crs_wkt.empty() || !(step_x > 0 && step_y > 0))
        throw Failure(1, fmt::format("{}: has no CRS, so its place on the globe is not known; bake it from a height "
                                     "field that has one: gdal_translate -a_srs CRS IN OUT.tif",
                                     name));
    constexpr double nodes_apart_m = 20e3, most_samples = 1024;
    const double spacing_m = std::max(source.spacing_m[0], source.spacing_m[1]);
    double nodes_apart = std::clamp(nodes_apart_m / spacing_m, 1.0, most_samples);
    while (!fill(source, nodes_apart)) {
        if (nodes_apart <= 1)
            throw Failure(1, fmt::format("{}: its CRS leads to no place on Earth for some of its samples; reproject it "
                                         "with --crs when it is baked",
                                         name));
        nodes_apart = std::max(1.0, nodes_apart / 4);
    }
}

bool SamplePlaces::fill(const HeightSource& source, double nodes_apart) {
    const auto nodes = [&](std::int32_t samples) {
        return std::max(4, static_cast<std::int32_t>(std::ceil((samples - 1) / nodes_apart)) + 1);
    };
    nodes_x_ = nodes(source.columns), nodes_y_ = nodes(source.rows);
    step_x_ = static_cast<double>(source.columns - 1) / (nodes_x_ - 1);
    step_y_ = static_cast<double>(source.rows - 1) / (nodes_y_ - 1);
    const GdalMessages messages;
    const OGRSpatialReference own = crs_of(source), globe = wgs84();
    const std::unique_ptr<OGRCoordinateTransformation> way(OGRCreateCoordinateTransformation(&own, &globe));
    if (!way) return false;
    const auto crs_step = step_of(source); // whole: clang 14 captures no part of it
    const auto exact = [&](double column, double row, GlobePlace& place) {
        double x = source.crs_origin[0] + column * std::get<0>(crs_step),
               y = source.crs_origin[1] - row * std::get<1>(crs_step);
        if (!way->Transform(1, &x, &y) || !std::isfinite(x) || !std::isfinite(y)) return false;
        place = on_globe({x, y}, 0);
        return true;
    };
    nodes_.resize(static_cast<std::size_t>(nodes_x_) * static_cast<std::size_t>(nodes_y_));
    for (std::int32_t j = 0; j < nodes_y_; ++j)
        for (std::int32_t i = 0; i < nodes_x_; ++i)
            if (!exact(i * step_x_, j * step_y_,
                       nodes_[static_cast<std::size_t>(j) * static_cast<std::size_t>(nodes_x_) +
                              static_cast<std::size_t>(i)]))
                return false;
    const double most = 1e-5 * std::min(source.spacing_m[0], source.spacing_m[1]) + 1e-6;
    constexpr int probes = 40; // a side, in the middle of what is interpolated
    for (int j = 0; j < probes; ++j)
        for (int i = 0; i < probes; ++i) {
            const double column = std::min(std::floor((i + 0.5) / probes * (nodes_x_ - 1)) + 0.5, nodes_x_ - 1.5),
                         row = std::min(std::floor((j + 0.5) / probes * (nodes_y_ - 1)) + 0.5, nodes_y_ - 1.5);
            GlobePlace place{};
            if (!exact(column * step_x_, row * step_y_, place)) return false;
            if (distance_m(place, at(column * step_x_, row * step_y_)) > most && nodes_apart > 1) return false;
        }
    return true;
}

GlobePlace SamplePlaces::at(double column, double row) const {
    struct Along {
        std::int32_t first;
        std::array<double, 4> weight;
    };
    const auto along = [](double where, std::int32_t nodes) {
        const std::int32_t first = std::clamp(static_cast<std::int32_t>(where) - 1, 0, nodes - 4);
        const double t = where - first, a = t, b = t - 1, c = t - 2, d = t - 3;
        return Along{first, {-b * c * d / 6, a * c * d / 2, -a * b * d / 2, a * b * c / 6}};
    };
    const Along x = along(column / step_x_, nodes_x_), y = along(row / step_y_, nodes_y_);
    GlobePlace sum{};
    for (std::int32_t j = 0; j < 4; ++j) {
        const GlobePlace* const node =
            &nodes_[static_cast<std::size_t>(y.first + j) * static_cast<std::size_t>(nodes_x_) +
                    static_cast<std::size_t>(x.first)];
        for (std::size_t axis = 0; axis < 3; ++axis)
            sum[axis] +=
                y.weight[static_cast<std::size_t>(j)] * (x.weight[0] * node[0][axis] + x.weight[1] * node[1][axis] +
                                                         x.weight[2] * node[2][axis] + x.weight[3] * node[3][axis]);
    }
    return sum;
}

SampleFinder::SampleFinder(const HeightSource& source) : columns_(source.columns), rows_(source.rows) {
    const GdalMessages messages;
    const OGRSpatialReference own = crs_of(source), globe = wgs84();
    to_field_.reset(OGRCreateCoordinateTransformation(&globe, &own));
    to_globe_.reset(OGRCreateCoordinateTransformation(&own, &globe));
    std::copy_n(source.crs_origin, 2, origin_);
    std::copy_n(step_of(source).data(), 2, step_);
}

bool SampleFinder::find(LonLat at, double& column, double& row) const {
    if (!to_field_ || !to_globe_) return false;
    const GdalMessages messages; // of places that a projection does not know there are many
    double x = at.longitude >= 180 ? at.longitude - 360 : at.longitude, y = at.latitude;
    if (!to_field_->Transform(1, &x, &y) || !std::isfinite(x) || !std::isfinite(y)) return false;
    column = (x - origin_[0]) / step_[0], row = (origin_[1] - y) / step_[1];
    if (column >= 0 && row >= 0 && column <= columns_ - 1 && row <= rows_ - 1) return true;
    // Far from where it is meant for a projection may lead to a wrong place, and not say so.
    constexpr double most_m = 1000;
    return to_globe_->Transform(1, &x, &y) && std::isfinite(x) && std::isfinite(y) &&
           distance_m(on_globe({x, y}, 0), on_globe(at, 0)) < most_m;
}

} // namespace fjell::baker
