#include "baker/georeference/projection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal_alg.h>

#include "baker/georeference/ground_scale.h"
#include "fjell/pack.h"

namespace fjell::baker {

namespace {

// Caps from here on to the pole stay square to 7% in a polar plane; half a degree for rims of pixels.
constexpr double least_cap = 59.5;

// Longitude in -180..180.
double wrapped(double longitude) {
    return longitude - 360 * std::floor((longitude + 180) / 360);
}

// Well-known codes where they exist, so that other programs recognise the CRS.
int utm_code(const OGRSpatialReference& geographic, int zone, bool north) {
    OGRSpatialReference wgs84;
    wgs84.importFromEPSG(4326);
    if (geographic.IsSameGeogCS(&wgs84)) return (north ? 32600 : 32700) + zone;
    const int code = geographic.GetEPSGGeogCS();
    if (code == 4258 && north && zone >= 28 && zone <= 38) return 25800 + zone;
    if (code == 4269 && north && zone <= 23) return 26900 + zone;
    return 0;
}

std::unique_ptr<OGRSpatialReference> blank() {
    auto crs = std::make_unique<OGRSpatialReference>();
    crs->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return crs;
}

std::unique_ptr<OGRSpatialReference> named_crs(const std::string& text) {
    auto crs = blank();
    constexpr std::array<const char*, 3> options{"ALLOW_NETWORK_ACCESS=NO", "ALLOW_FILE_ACCESS=NO", nullptr};
    if (crs->SetFromUserInput(text.c_str(), options.data()) != OGRERR_NONE)
        throw Failure(2, fmt::format("--crs {}: no CRS that GDAL knows; give one like EPSG:32633, WKT, auto or none",
                                     text.substr(0, 200)));
    if (!crs->IsProjected())
        throw Failure(2, fmt::format("--crs {}: is not projected, and heights and places must both be in metres; give "
                                     "one like EPSG:32633, or auto",
                                     text.substr(0, 200)));
    crs->StripVertical();
    if (!points_east_and_north(*crs))
        throw Failure(2, fmt::format("--crs {}: its axes do not point east and north; give another, or auto",
                                     text.substr(0, 200)));
    return crs;
}

// All of a body on one plane, as --crs takes it: Earth's by a well-known code, others by their own axes.
std::string whole_body_crs(const OGRSpatialReference& geographic) {
    const double a = geographic.GetSemiMajor(), b = geographic.GetSemiMinor();
    if (std::abs(a - 6.37e6) < 3e4) return "EPSG:6933";
    return fmt::format("\"+proj=eqc {} +units=m\"", std::abs(a - b) < 1e-3
                                                        ? fmt::format("+R={:.10g}", a)
                                                        : fmt::format("+a={:.10g} +b={:.10g}", a, b));
}

struct Degrees {
    double west, south, east, north;
};

// Whole turns that bring a box to a field, in degrees; false: they do not meet.
bool meets(const std::array<double, 4>& box, const Degrees& all, double& turns) {
    turns = 360 * std::ceil((all.west - box[2]) / 360);
    return box[0] + turns < all.east && box[2] + turns > all.west && box[1] < all.north && box[3] > all.south;
}

// A box that meets the field in degrees counts in these: as metres it would be smaller than a village, and elsewhere.
bool is_in_degrees(const ReadOptions& options, const Degrees& all) {
    double turns = 0;
    if (!options.bbox) return false;
    const auto& [west, south, east, north] = *options.bbox;
    return std::abs(west) <= 540 && std::abs(east) <= 540 && std::abs(south) <= 90 && std::abs(north) <= 90 &&
           meets(*options.bbox, all, turns);
}

// The box, in degrees, that was asked for; of a field that no plane holds there must be one. Throws Failure.
Degrees box_in_degrees(const Degrees& all, const ReadOptions& options, const std::string& path,
                       const OGRSpatialReference& geographic) {
    const std::string spans = fmt::format("{}: spans {:.0f} x {:.0f} degrees, which no flat map shows undistorted",
                                          path, all.east - all.west, all.north - all.south);
    if (!options.bbox)
        throw Failure(1, fmt::format("{}; give --bbox WEST,SOUTH,EAST,NORTH in degrees for a part, --crs {} for all of "
                                     "it on one map, or --spacing M (metres between samples) for a square grid",
                                     spans, whole_body_crs(geographic)));
    const auto& [west, south, east, north] = *options.bbox;
    if (std::abs(south) > 90 || std::abs(north) > 90 || std::abs(west) > 540 || std::abs(east) > 540)
        throw Failure(1, fmt::format("{}; give --bbox in degrees, or --crs CRS for one in its units", spans));
    double turns = 0; // longitudes count from anywhere
    if (!meets(*options.bbox, all, turns))
        throw Failure(1, fmt::format("{}: --bbox {},{},{},{} lies outside of it; it spans {:.6g},{:.6g},{:.6g},{:.6g} "
                                     "degrees",
                                     path, west, south, east, north, all.west, all.south, all.east, all.north));
    return {west, south, east, north};
}

void check_box(const ReadOptions& options) {
    if (options.bbox && !((*options.bbox)[1] < (*options.bbox)[3]))
        throw Failure(2, fmt::format("--bbox: SOUTH {} is not less than NORTH {}; give WEST,SOUTH,EAST,NORTH",
                                     (*options.bbox)[1], (*options.bbox)[3]));
}

ReprojectionTarget automatic_target(const Placement& from, const ReadOptions& options, const std::string& path) {
    check_box(options);
    const OGRSpatialReference own = source_crs(from), geographic = degrees_of(own);
    const double unit = own.GetAngularUnits() / (std::numbers::pi / 180); // in degrees
    const Degrees all{from.east(-0.5) * unit, from.north(from.rows - 0.5) * unit, from.east(from.columns - 0.5) * unit,
                      from.north(-0.5) * unit};
    auto crs = crs_for(geographic, all.west, all.south, all.east, all.north);
    if (crs && !is_in_degrees(options, all)) return {std::move(crs), options.bbox};
    const Degrees box = box_in_degrees(all, options, path, geographic);
    if (!crs) crs = crs_for(geographic, box.west, box.south, box.east, box.north);
    if (!crs)
        throw Failure(1, fmt::format("{}: --bbox spans {:.0f} x {:.0f} degrees, which no flat map shows undistorted; "
                                     "give at most 90 x 90, or --crs {} without --bbox for all of it",
                                     path, box.east - box.west, box.north - box.south, whole_body_crs(geographic)));
    const GdalMessages messages;
    const std::unique_ptr<OGRCoordinateTransformation> to_plane(
        OGRCreateCoordinateTransformation(&geographic, crs.get()));
    std::array<double, 4> placed{};
    constexpr int points_an_edge = 65;
    if (!to_plane || !to_plane->TransformBounds(box.west, box.south, box.east, box.north, &placed[0], &placed[1],
                                                &placed[2], &placed[3], points_an_edge))
        throw Failure(1, fmt::format("{}: --bbox {},{},{},{} cannot be projected; choose another{}", path, box.west,
                                     box.south, box.east, box.north, messages.said()));
    return {std::move(crs), placed};
}

// Lengths may be wrong by this much: more shows in slopes, and survey maps stay below it.
constexpr double most_off = 0.005;

struct TruePlane {
    std::unique_ptr<OGRSpatialReference> crs; // null: the CRS is true enough, or there is none that is truer
    OGRSpatialReference degrees;              // of the same datum
    std::unique_ptr<OGRCoordinateTransformation> to_degrees;
};

// A CRS whose metres are the ground's in a box of another one's.
TruePlane truer_plane(const OGRSpatialReference& own, const CrsBox& box) {
    TruePlane plane;
    const bool turned = !points_east_and_north(own);
    const std::optional<GroundScale> scale = ground_scale(own, box.nine_places());
    if (!turned && (!scale || scale->off() <= most_off)) return plane;
    plane.degrees = degrees_of(own);
    plane.to_degrees.reset(OGRCreateCoordinateTransformation(&own, &plane.degrees));
    Degrees d{};
    constexpr int points_an_edge = 21;
    if (!plane.to_degrees || !plane.to_degrees->TransformBounds(box.west, box.south, box.east, box.north, &d.west,
                                                                &d.south, &d.east, &d.north, points_an_edge))
        return plane;
    if (d.east < d.west) d.east += 360;
    auto crs = crs_for(plane.degrees, d.west, d.south, d.east, d.north);
    if (!crs || turned || !scale) {
        plane.crs = std::move(crs);
        return plane;
    }
    const std::unique_ptr<OGRCoordinateTransformation> there(OGRCreateCoordinateTransformation(&own, crs.get()));
    std::vector<CrsPlace> placed;
    for (CrsPlace& at : box.nine_places())
        if (there && there->Transform(1, &at[0], &at[1])) placed.push_back(at);
    const std::optional<GroundScale> truer = ground_scale(*crs, placed);
    if (truer && truer->off() < scale->off() / 2) plane.crs = std::move(crs);
    return plane;
}

bool same_steps(const Placement& from, double spacing_m) {
    return std::abs(from.step[0] * from.unit_m / spacing_m - 1) < 1e-6 &&
           std::abs(from.step[1] * from.unit_m / spacing_m - 1) < 1e-6;
}

// Of a field in a projected CRS: one that is true there, its own for another spacing, or none.
ReprojectionTarget target_of_projected(const Placement& from, const ReadOptions& options, const std::string& path) {
    const OGRSpatialReference own = source_crs(from);
    if (!own.IsProjected()) return {};
    const bool keep = options.crs == "none" || options.crs == "keep", turned = !points_east_and_north(own);
    constexpr const char* remedy = "give a projected CRS to reproject to, such as --crs EPSG:32633";
    if (turned && keep)
        throw Failure(1, fmt::format("{}: the axes of its CRS do not point east and north; leave out --crs {}", path,
                                     options.crs));
    CrsBox box{from.east(-0.5), from.north(from.rows - 0.5), from.east(from.columns - 0.5), from.north(-0.5)};
    if (options.bbox) {
        check_box(options);
        const auto& [west, south, east, north] = *options.bbox;
        box = {std::max(box.west, west), std::max(box.south, south), std::min(box.east, east),
               std::min(box.north, north)};
        if (!(box.west < box.east && box.south < box.north)) return {}; // said when it is cut out
    }
    if (!keep) {
        TruePlane plane = truer_plane(own, box);
        if (plane.crs && !options.bbox) return {std::move(plane.crs), {}};
        if (plane.crs) { // the box is in units of the field's own CRS
            const std::unique_ptr<OGRCoordinateTransformation> there(
                OGRCreateCoordinateTransformation(&own, plane.crs.get()));
            std::array<double, 4> placed{};
            constexpr int points_an_edge = 65;
            if (there && there->TransformBounds(box.west, box.south, box.east, box.north, &placed[0], &placed[1],
                                                &placed[2], &placed[3], points_an_edge))
                return {std::move(plane.crs), placed};
        }
        if (turned)
            throw Failure(1, fmt::format("{}: the axes of its CRS do not point east and north; {}", path, remedy));
    }
    if (!options.spacing_m || same_steps(from, *options.spacing_m)) return {};
    return {std::unique_ptr<OGRSpatialReference>(own.Clone()), options.bbox};
}

[[noreturn]] void refuse_unplaced(const Placement& from, const std::string& path) {
    throw Failure(1, fmt::format("{}: is placed by control points or arrays of coordinates alone; make a grid of it "
                                 "first: {}; or give --spacing M (metres between samples) to take its samples as a "
                                 "square grid without a place",
                                 path, from.command));
}

// To three digits: what a source has in its middle is no round number.
double rounded(double step) {
    const double unit = std::pow(10.0, std::floor(std::log10(step)) - 2);
    return unit < 1 ? std::round(step / unit) / std::round(1 / unit) : std::round(step / unit) * unit;
}

struct Extent {
    double low[2] = {-HUGE_VAL, -HUGE_VAL}, high[2] = {HUGE_VAL, HUGE_VAL};
};

// Metres between neighbouring samples at a place of the source, as a square has them; 0: not known.
double spacing_at(const Transformer& transformer, double x, double y, double unit_m) {
    double area = 1;
    for (const int axis : {0, 1}) {
        double ax = x - 0.5 * (axis == 0), ay = y - 0.5 * (axis == 1);
        double bx = x + 0.5 * (axis == 0), by = y + 0.5 * (axis == 1);
        if (!transformer.to_target(ax, ay) || !transformer.to_target(bx, by)) return 0;
        area *= std::hypot(bx - ax, by - ay) * unit_m;
    }
    return std::sqrt(area);
}

// The same in the middle of the source; where a map is cut there, as that of a globe whose longitudes begin at 0, a
// quarter further on.
double spacing_in_middle(const Transformer& transformer, double x, double y, double columns, double unit_m) {
    const double middle = spacing_at(transformer, x, y, unit_m);
    const double beside = spacing_at(transformer, x + columns / 4, y, unit_m);
    return beside > 0 && middle > 3 * beside ? beside : middle;
}

bool touches(const Transformer& transformer, const Extent& box, const GDALDataset& from) {
    constexpr int steps = 32;
    for (int j = 0; j <= steps; ++j)
        for (int i = 0; i <= steps; ++i) {
            double x = box.low[0] + (box.high[0] - box.low[0]) * i / steps;
            double y = box.low[1] + (box.high[1] - box.low[1]) * j / steps;
            if (transformer.to_source(x, y) && x >= 0 && y >= 0 &&
                x <= const_cast<GDALDataset&>(from).GetRasterXSize() &&
                y <= const_cast<GDALDataset&>(from).GetRasterYSize())
                return true;
        }
    return false;
}

} // namespace

std::string angle_name(const OGRSpatialReference& crs) {
    const char* unit = nullptr;
    (void)crs.GetAngularUnits(&unit);
    return EQUAL(unit, "degree") ? "degrees" : std::string(unit) + "s";
}

OGRSpatialReference source_crs(const Placement& from) {
    OGRSpatialReference crs;
    if (from.crs_wkt.empty())
        crs.importFromEPSG(4326);
    else
        crs.importFromWkt(from.crs_wkt.c_str());
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    crs.StripVertical();
    return crs;
}

std::unique_ptr<OGRSpatialReference> crs_for(const OGRSpatialReference& geographic, double west, double south,
                                             double east, double north) {
    const double middle = wrapped((west + east) / 2), latitude = (south + north) / 2, width = east - west;
    auto crs = blank();
    if (width > 90 && (south > least_cap || north < -least_cap)) { // around a pole
        OGRSpatialReference wgs84;
        wgs84.importFromEPSG(4326);
        if (geographic.IsSameGeogCS(&wgs84) && crs->importFromEPSG(north > 0 ? 3995 : 3031) == OGRERR_NONE) return crs;
        crs->SetProjCS("Polar stereographic");
        crs->CopyGeogCSFrom(&geographic);
        crs->SetPS(north > 0 ? 71 : -71, 0, 1, 0, 0);
        return crs;
    }
    if (north - south > 90 || width > 90) return nullptr;
    if (north > 84 || south < -84) {
        crs->SetProjCS("Polar stereographic");
        crs->CopyGeogCSFrom(&geographic);
        const double side = latitude < 0 ? -1 : 1;
        crs->SetPS(std::abs(latitude) > 89 ? side * 89 : std::round(latitude), std::round(middle), 1, 0, 0);
        return crs;
    }
    // UTM is for ellipsoids, and counts from Greenwich.
    if (width <= 12 && (geographic.GetInvFlattening() == 0 || geographic.GetPrimeMeridian() != 0)) {
        crs->SetProjCS("Transverse Mercator");
        crs->CopyGeogCSFrom(&geographic);
        crs->SetTM(std::round(latitude), std::round(middle), 0.9996, 0, 0);
        return crs;
    }
    if (width <= 12) {
        const int zone = std::min(60, static_cast<int>(std::floor((middle + 180) / 6)) + 1);
        const bool north_half = latitude >= 0;
        const int code = utm_code(geographic, zone, north_half);
        if (code && crs->importFromEPSG(code) == OGRERR_NONE) return crs;
        crs->SetProjCS(fmt::format("UTM zone {}{}", zone, north_half ? 'N' : 'S').c_str());
        crs->CopyGeogCSFrom(&geographic);
        crs->SetUTM(zone, north_half);
        return crs;
    }
    crs->SetProjCS("Lambert azimuthal equal area");
    crs->CopyGeogCSFrom(&geographic);
    crs->SetLAEA(std::round(latitude), std::round(middle), 0, 0);
    return crs;
}

ReprojectionTarget choose_target(const Placement& from, const ReadOptions& options, const std::string& path) {
    const bool automatic = options.crs == "auto", none = options.crs == "none" || options.crs == "keep";
    if (!automatic && !none) {
        auto crs = named_crs(options.crs);
        if (!from.command.empty()) refuse_unplaced(from, path);
        if (from.axes == Axes::none)
            throw Failure(1, fmt::format("{}: has no georeference and cannot be reprojected; give --spacing M (metres "
                                         "between samples) and leave out --crs",
                                         path));
        if (from.axes == Axes::perhaps_degrees || (from.axes == Axes::metres && from.crs_wkt.empty()))
            throw Failure(1, fmt::format("{}: has no CRS of its own to reproject from; give it one first with "
                                         "gdal_translate -a_srs CRS {} OUT.tif",
                                         path, path));
        const OGRSpatialReference own = source_crs(from);
        if (!options.spacing_m && own.IsSame(crs.get())) return {};
        check_box(options);
        return {std::move(crs), options.bbox};
    }
    if (from.axes == Axes::metres && !from.crs_wkt.empty()) return target_of_projected(from, options, path);
    if (options.spacing_m || from.axes == Axes::metres) return {};
    if (!from.command.empty()) refuse_unplaced(from, path);
    if (from.axes == Axes::none)
        throw Failure(1, fmt::format("{}: has no georeference; give --spacing M (metres between samples)", path));
    if (none)
        throw Failure(1,
                      fmt::format("{}: is in {}; give --spacing M (metres between samples), or leave out --crs {} to "
                                  "reproject it",
                                  path, angle_name(source_crs(from)), options.crs));
    if (from.axes == Axes::perhaps_degrees)
        throw Failure(1,
                      fmt::format("{}: has no CRS and looks as if it is in degrees; give --spacing M (metres between "
                                  "samples), or say so with gdal_translate -a_srs EPSG:4326 {} OUT.tif",
                                  path, path));
    return automatic_target(from, options, path);
}

Transformer::Transformer(GDALDataset& from, const std::string& crs_wkt, const std::string& path) {
    const GdalMessages messages;
    CPLStringList options;
    options.SetNameValue("DST_SRS", crs_wkt.c_str());
    argument_ = GDALCreateGenImgProjTransformer2(GDALDataset::ToHandle(&from), nullptr, options.List());
    if (!argument_)
        throw Failure(1, fmt::format("{}: cannot be reprojected; try another --crs{}", path, messages.said()));
    columns_ = from.GetRasterXSize();
    std::array<double, 6> t{};
    const OGRSpatialReference* const own = from.GetSpatialRef();
    if (!own || from.GetGeoTransform(t.data()) != CE_None) return;
    const Turn turn = turn_of(*own);
    const double slack = 0.01 * t[1], west = turn.middle - turn.length / 2, east = turn.middle + turn.length / 2;
    const bool beyond = t[0] < west - slack || t[0] + columns_ * t[1] > east + slack;
    if (turn.length > 0 && (own->IsGeographic() ? columns_ * t[1] > turn.length : beyond)) turn_ = turn.length / t[1];
}

Transformer::~Transformer() {
    GDALDestroyGenImgProjTransformer(argument_);
}

void Transformer::set_target(const Placement& to) {
    const double transform[6] = {to.east(-0.5), to.step[0], 0, to.north(-0.5), 0, -to.step[1]};
    GDALSetGenImgProjTransformerDstGeoTransform(argument_, transform);
}

bool Transformer::transform(int backwards, double& x, double& y) const {
    const GdalMessages quiet;
    double z = 0;
    int good = 0;
    return function()(argument(), backwards, 1, &x, &y, &z, &good) && good && std::isfinite(x) && std::isfinite(y);
}

GDALTransformerFunc Transformer::function() const {
    return turn_ > 0 ? wrap : GDALGenImgProjTransform;
}
void* Transformer::argument() const {
    return turn_ > 0 ? const_cast<Transformer*>(this) : argument_;
}

int Transformer::wrap(void* self, int backwards, int count, double* x, double* y, double* z, int* good) {
    const Transformer& t = *static_cast<const Transformer*>(self);
    const int done = GDALGenImgProjTransform(t.argument_, backwards, count, x, y, z, good);
    if (!backwards) return done;
    for (int i = 0; i < count; ++i) {
        if (!good[i] || (x[i] >= 0 && x[i] <= t.columns_)) continue;
        const double wrapped = x[i] - t.turn_ * std::floor(x[i] / t.turn_);
        if (wrapped <= t.columns_) x[i] = wrapped;
    }
    return done;
}

bool Transformer::to_source(double& x, double& y) const {
    return transform(TRUE, x, y);
}
bool Transformer::to_target(double& x, double& y) const {
    return transform(FALSE, x, y);
}

Placement target_grid(GDALDataset& from, const ReprojectionTarget& target, const ReadOptions& options,
                      const std::string& path) {
    const OGRSpatialReference& crs = *target.crs;
    Placement p;
    p.axes = Axes::metres;
    p.crs_wkt = wkt_of(crs);
    p.unit_m = crs.GetLinearUnits();
    const Transformer transformer(from, p.crs_wkt, path);
    const GdalMessages quiet;
    std::array<double, 6> unused{};
    std::array<double, 4> around{}; // west, south, east, north
    int columns = 0, rows = 0;
    Extent extent;
    const bool known =
        GDALSuggestedWarpOutput2(GDALDataset::ToHandle(&from), transformer.function(), transformer.argument(),
                                 unused.data(), &columns, &rows, around.data(), 0) == CE_None;
    if (known) extent = {{around[0], around[1]}, {around[2], around[3]}};
    double x = 0.5 * from.GetRasterXSize(), y = 0.5 * from.GetRasterYSize();
    if (target.bbox) {
        const auto& [west, south, east, north] = *target.bbox;
        const Extent box{{west, south}, {east, north}};
        if (!touches(transformer, box, from))
            throw Failure(1, fmt::format("{}: --bbox {},{},{},{} lies outside of it{}", path, west, south, east, north,
                                         known ? fmt::format("; it spans {:.0f},{:.0f},{:.0f},{:.0f} in {}", around[0],
                                                             around[1], around[2], around[3], crs.GetName())
                                               : ""));
        x = (west + east) / 2, y = (south + north) / 2;
        if (!transformer.to_source(x, y)) x = 0.5 * from.GetRasterXSize(), y = 0.5 * from.GetRasterYSize();
        for (const int axis : {0, 1}) {
            extent.low[axis] = std::max(extent.low[axis], box.low[axis]);
            extent.high[axis] = std::min(extent.high[axis], box.high[axis]);
        }
    } else if (!known) {
        throw Failure(1,
                      fmt::format("{}: does not fit into that CRS; choose a part with --bbox, or another --crs", path));
    }
    const double spacing_m =
        options.spacing_m ? *options.spacing_m : spacing_in_middle(transformer, x, y, from.GetRasterXSize(), p.unit_m);
    if (!(spacing_m >= min_spacing_m && spacing_m <= max_spacing_m))
        throw Failure(1, fmt::format("{}: has no spacing in its middle in that CRS; give --spacing M", path));
    const double step = options.spacing_m ? spacing_m / p.unit_m : rounded(spacing_m / p.unit_m);
    p.step[0] = p.step[1] = step;
    // Cells from first to last, whole ones around the source, those with their middle in a box.
    double first[2], last[2];
    for (const int axis : {0, 1}) {
        const double low = extent.low[axis] / step, high = extent.high[axis] / step;
        first[axis] = target.bbox ? std::ceil(low - 0.5) : std::floor(low);
        last[axis] = target.bbox ? std::floor(high - 0.5) : std::ceil(high) - 1;
        if (!(last[axis] - first[axis] < std::numeric_limits<std::int32_t>::max() / 2 &&
              (last[axis] - first[axis]) * step * p.unit_m <= max_extent_m))
            throw Failure(
                1, fmt::format("{}: does not fit into that CRS; choose a part with --bbox, or another --crs", path));
    }
    if (!(last[0] - first[0] >= 1 && last[1] - first[1] >= 1))
        throw Failure(1, fmt::format("{}: fewer than 2 x 2 samples, {} m apart, lie inside; give a larger --bbox or a "
                                     "smaller --spacing",
                                     path, step * p.unit_m));
    p.columns = static_cast<std::int32_t>(last[0] - first[0]) + 1;
    p.rows = static_cast<std::int32_t>(last[1] - first[1]) + 1;
    p.origin[0] = (first[0] + 0.5) * step;
    p.origin[1] = (last[1] + 0.5) * step;
    return p;
}

} // namespace fjell::baker
