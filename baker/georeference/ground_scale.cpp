// GDAL does not hand out PROJ's factors, so that they are measured: steps of 50 m to both sides of a place, as metres
// on the ellipsoid.
#include "baker/georeference/ground_scale.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <string>

#include <cpl_string.h>

namespace fjell::baker {

std::vector<CrsPlace> CrsBox::nine_places() const {
    std::vector<CrsPlace> places;
    for (const double y : {south, (south + north) / 2, north})
        for (const double x : {west, (west + east) / 2, east}) places.push_back({x, y});
    return places;
}

double GroundScale::off() const {
    return std::max(std::abs(least - 1), std::abs(most - 1));
}

std::optional<GroundScale> ground_scale(const OGRSpatialReference& crs, const std::vector<CrsPlace>& places) {
    const OGRSpatialReference degrees = degrees_of(crs);
    const std::unique_ptr<OGRCoordinateTransformation> to_degrees(OGRCreateCoordinateTransformation(&crs, &degrees));
    if (!to_degrees) return {};
    constexpr double radian = std::numbers::pi / 180, reach_m = 50;
    const double unit_m = crs.GetLinearUnits(), a = crs.GetSemiMajor(), b = crs.GetSemiMinor();
    const double eccentricity2 = 1 - b * b / (a * a);
    std::optional<GroundScale> scale;
    for (const CrsPlace& place : places) {
        const double reach = reach_m / unit_m;
        double x[5] = {place[0], place[0] - reach, place[0] + reach, place[0], place[0]};
        double y[5] = {place[1], place[1], place[1], place[1] - reach, place[1] + reach};
        int good[5] = {};
        if (!to_degrees->Transform(5, x, y, nullptr, nullptr, good) || std::count(good, good + 5, 0)) continue;
        const double sine = std::sin(y[0] * radian), bent = 1 - eccentricity2 * sine * sine;
        const double around = a / std::sqrt(bent) * std::cos(y[0] * radian) * radian; // metres in a degree
        const double along = a * (1 - eccentricity2) / std::pow(bent, 1.5) * radian;
        const auto ground = [&](int from, int to) { // of one metre of the plane: eastwards, northwards
            const double turn = std::remainder(x[to] - x[from], 360);
            return CrsPlace{turn * around / (2 * reach_m), (y[to] - y[from]) * along / (2 * reach_m)};
        };
        // Singular values: the longest and the shortest that a metre of the plane becomes in any direction.
        const CrsPlace u = ground(1, 2), v = ground(3, 4);
        const double sum = u[0] * u[0] + u[1] * u[1] + v[0] * v[0] + v[1] * v[1];
        const double area = std::abs(u[0] * v[1] - u[1] * v[0]);
        const double longest = std::sqrt((sum + std::sqrt(std::max(0.0, sum * sum - 4 * area * area))) / 2);
        const double least = 1 / longest, most = longest / area;
        if (!std::isfinite(least) || !std::isfinite(most)) continue;
        scale =
            scale ? GroundScale{std::min(scale->least, least), std::max(scale->most, most)} : GroundScale{least, most};
    }
    return scale;
}

OGRSpatialReference degrees_of(const OGRSpatialReference& crs) {
    OGRSpatialReference degrees;
    degrees.CopyGeogCSFrom(&crs);
    degrees.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    if (std::abs(crs.GetAngularUnits() / (std::numbers::pi / 180) - 1) < 1e-9) return degrees;
    const auto name = [&](const char* node) { return std::string(degrees.GetAttrValue(node)); };
    const char* meridian = nullptr;
    const double east_of_greenwich = crs.GetPrimeMeridian(&meridian);
    degrees.SetGeogCS(name("GEOGCS").c_str(), name("DATUM").c_str(), name("SPHEROID").c_str(), crs.GetSemiMajor(),
                      crs.GetInvFlattening(), meridian, east_of_greenwich);
    return degrees;
}

namespace {

// Of x and of y.
std::array<OGRAxisOrientation, 2> directions_of(const OGRSpatialReference& crs) {
    const std::vector<int>& order = crs.GetDataAxisToSRSAxisMapping();
    std::array<OGRAxisOrientation, 2> points{OAO_East, OAO_North};
    for (std::size_t axis = 0; axis < 2 && axis < order.size(); ++axis)
        (void)crs.GetAxis("PROJCS", std::abs(order[axis]) - 1, &points[axis]);
    return points;
}

} // namespace

std::string axes_text(const OGRSpatialReference& crs) {
    std::string text;
    for (const OGRAxisOrientation points : directions_of(crs))
        text += (text.empty() ? "" : ", ") + CPLString(OSRAxisEnumToName(points)).tolower();
    return text;
}

bool points_east_and_north(const OGRSpatialReference& crs) {
    const auto [x, y] = directions_of(crs);
    if (x == y) return true; // about a pole
    return x != OAO_West && x != OAO_South && x != OAO_North && y != OAO_South && y != OAO_West && y != OAO_East;
}

} // namespace fjell::baker
