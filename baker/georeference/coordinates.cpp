#include "baker/georeference/coordinates.h"

#include <cmath>

#include <ogr_spatialref.h>

#include "baker/georeference/crs_label.h"
#include "baker/georeference/ground_scale.h"
#include "baker/georeference/projection.h"
#include "baker/read/gdal_file.h"

namespace fjell::baker {

Coordinates::Coordinates(const PackHeader& header, const std::string& crs_wkt) {
    for (const int axis : {0, 1}) {
        origin_[axis] = header.crs_origin[axis];
        spacing_m_[axis] = header.spacing_m[axis];
        step_[axis] = header.crs_step[axis] > 0 ? header.crs_step[axis] : header.spacing_m[axis];
    }
    if (crs_wkt.empty()) return;
    crs_ = crs_text(crs_label(crs_wkt));
    load_gdal();
    const GdalMessages quiet;
    Placement at;
    at.crs_wkt = crs_wkt;
    const OGRSpatialReference own = source_crs(at);
    if (!own.IsProjected() && !own.IsGeographic()) return;
    if (own.IsProjected()) {
        const char* unit = nullptr;
        unit_ = own.GetLinearUnits(&unit) == 1 || unit == nullptr ? "m" : unit;
    }
    const OGRSpatialReference degrees = degrees_of(own);
    to_degrees_.reset(OGRCreateCoordinateTransformation(&own, &degrees));
    if (const char* const name = degrees.GetName(); to_degrees_ && name != nullptr) datum_ = name;
}

Coordinates::~Coordinates() = default;

void Coordinates::Free::operator()(OGRCoordinateTransformation* transformation) const {
    OGRCoordinateTransformation::DestroyCT(transformation);
}

std::array<double, 2> Coordinates::in_crs(double x_m, double z_m) const {
    return {origin_[0] + x_m / spacing_m_[0] * step_[0], origin_[1] - z_m / spacing_m_[1] * step_[1]};
}

std::optional<std::array<double, 2>> Coordinates::degrees(double x_m, double z_m) const {
    if (!to_degrees_) return {};
    auto [x, y] = in_crs(x_m, z_m);
    const GdalMessages quiet;
    int good = 0;
    if (!to_degrees_->Transform(1, &x, &y, nullptr, nullptr, &good) || good == 0) return {};
    return std::array{y, std::remainder(x, 360)};
}

} // namespace fjell::baker
