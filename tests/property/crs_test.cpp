// A known hill on a known plane, written by GDAL in a CRS of EPSG's inside its area of use, and looked for in the pack.
// What is right follows from PROJ's own projections and geodesics, whose code and library the baker calls only through
// GDAL: where the pack says that a sample lies, the ground there has the sample's height, and metres are the ground's.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <geodesic.h>
#include <ogr_srs_api.h>
#include <proj.h>

#include "baker/bake/recipe.h"
#include "baker/read/pack_source.h"
#include "fjell/io/pack_file.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"
#include "unit/raster.h"

using namespace fjell;
using namespace fjell::test;
using namespace fjell::baker;

namespace {

constexpr double degree = M_PI / 180;

struct PjFree {
    void operator()(PJ* pj) const { proj_destroy(pj); }
};
using Pj = std::unique_ptr<PJ, PjFree>;
// One of ours, which says nothing about places that it does not know: GDAL listens to what the default one says.
PJ_CONTEXT* proj() {
    static PJ_CONTEXT* const context = [] {
        PJ_CONTEXT* const quiet = proj_context_create();
        proj_log_level(quiet, PJ_LOG_NONE);
        return quiet;
    }();
    return context;
}
struct Place {
    double x = 0, y = 0;
};

// A CRS by PROJ alone. Its axes are those of a raster: `order` says which of its own comes first.
class Plane {
public:
    // text: a code or WKT. Check ok() first: PROJ cannot do every CRS that it knows by name.
    Plane(const std::string& text, bool swapped) : swapped_(swapped) {
        const Pj crs(proj_create(proj(), text.c_str()));
        if (!crs) return;
        const Pj degrees(proj_crs_get_geodetic_crs(proj(), crs.get()));
        const Pj ellipsoid(proj_get_ellipsoid(proj(), crs.get())), meridian(proj_get_prime_meridian(proj(), crs.get()));
        const Pj system(proj_crs_get_coordinate_system(proj(), degrees.get()));
        const Pj own(proj_crs_get_coordinate_system(proj(), crs.get()));
        if (!degrees || !ellipsoid || !meridian || !system || !own) return;
        double b = 0, inverse = 0, west = 0, west_unit = 0;
        int computed = 0;
        const char* direction = nullptr;
        proj_ellipsoid_get_parameters(proj(), ellipsoid.get(), &a_, &b, &computed, &inverse);
        geod_init(&ball_, a_, 1 - b / a_);
        proj_prime_meridian_get_parameters(proj(), meridian.get(), &west, &west_unit, nullptr);
        meridian_ = west * west_unit / degree;
        proj_cs_get_axis_info(proj(), system.get(), 0, nullptr, nullptr, &direction, &unit_, nullptr, nullptr, nullptr);
        latitude_first_ = std::string(direction) == "north";
        unit_ /= degree;
        if (proj_get_type(crs.get()) == PJ_TYPE_PROJECTED_CRS)
            proj_cs_get_axis_info(proj(), own.get(), 0, nullptr, nullptr, nullptr, &unit_m, nullptr, nullptr, nullptr);
        to_crs_.reset(proj_create_crs_to_crs_from_pj(proj(), degrees.get(), crs.get(), nullptr, nullptr));
    }
    [[nodiscard]] bool ok() const { return to_crs_ != nullptr; }
    // Degrees from Greenwich, of the CRS' own datum; not finite where PROJ knows no place.
    [[nodiscard]] Place to_crs(Place lon_lat) const {
        const double lon = (lon_lat.x - meridian_) / unit_, lat = lon_lat.y / unit_;
        const PJ_COORD c = proj_trans(to_crs_.get(), PJ_FWD,
                                      latitude_first_ ? proj_coord(lat, lon, 0, 0) : proj_coord(lon, lat, 0, 0));
        return swapped_ ? Place{c.xy.y, c.xy.x} : Place{c.xy.x, c.xy.y};
    }
    [[nodiscard]] Place to_degrees(Place at) const {
        const PJ_COORD c =
            proj_trans(to_crs_.get(), PJ_INV, swapped_ ? proj_coord(at.y, at.x, 0, 0) : proj_coord(at.x, at.y, 0, 0));
        return latitude_first_ ? Place{c.xy.y * unit_ + meridian_, c.xy.x * unit_}
                               : Place{c.xy.x * unit_ + meridian_, c.xy.y * unit_};
    }
    // Metres of ground to the east and to the north.
    [[nodiscard]] Place from(Place middle, Place lon_lat) const {
        double distance = 0, azimuth = 0;
        geod_inverse(&ball_, middle.y, middle.x, lon_lat.y, lon_lat.x, &distance, &azimuth, nullptr);
        return {distance * std::sin(azimuth * degree), distance * std::cos(azimuth * degree)};
    }
    [[nodiscard]] Place beside(Place middle, Place metres) const {
        Place to;
        geod_direct(&ball_, middle.y, middle.x, std::atan2(metres.x, metres.y) / degree, std::hypot(metres.x, metres.y),
                    &to.y, &to.x, nullptr);
        return to;
    }
    double unit_m = 1; // of a projected one

private:
    Pj to_crs_;
    geod_geodesic ball_{};
    double a_ = 0, meridian_ = 0, unit_ = 1;
    bool swapped_, latitude_first_ = true;
};

// How GDAL has the axes of a CRS in a raster.
bool is_swapped(const std::string& text) {
    OGRSpatialReference crs;
    crs.SetFromUserInput(text.c_str());
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return crs.GetDataAxisToSRSAxisMapping()[0] == 2;
}

// The code that GDAL gives a file, and reads in it: another one where EPSG has replaced a CRS.
std::string written_code(std::string code) {
    for (std::string before; before != code;) {
        before = code;
        OGRSpatialReference crs;
        if (crs.SetFromUserInput(code.c_str()) != OGRERR_NONE) return code;
        if (const char* const is = crs.GetAuthorityCode(nullptr)) code = std::string("EPSG:") + is;
    }
    return code;
}

struct Listed {
    std::string code, name;
    double west, south, east, north;
};
// Projected ones, and those in degrees or grads.
std::vector<Listed> all_of_epsg() {
    std::vector<Listed> all;
    int count = 0;
    OSRCRSInfo** const list = OSRGetCRSInfoListFromDatabase("EPSG", nullptr, &count);
    for (int i = 0; i < count; ++i)
        if (const OSRCRSInfo& c = *list[i];
            (c.eType == OSR_CRS_TYPE_PROJECTED || c.eType == OSR_CRS_TYPE_GEOGRAPHIC_2D) && c.bBboxValid)
            all.push_back({std::string("EPSG:") + c.pszCode, c.pszName, c.dfWestLongitudeDeg, c.dfSouthLatitudeDeg,
                           c.dfEastLongitudeDeg + (c.dfEastLongitudeDeg < c.dfWestLongitudeDeg ? 360 : 0),
                           c.dfNorthLatitudeDeg});
    OSRDestroyCRSInfoList(list);
    return all;
}

constexpr int columns = 121, rows = 101;
constexpr double hill_m = 200, hill_cells = 6; // its height, and how wide it is

// What stands on the ground around `middle`, s metres a cell.
struct Ground {
    const Plane& plane; // for its geodesics
    Place middle;
    double s;
    [[nodiscard]] Place top() const { return {20 * s, 15 * s}; }
    [[nodiscard]] double plain_m(Place at) const { return 400 + 0.5 * at.x / s + at.y / s; }
    [[nodiscard]] double height_m(Place lon_lat) const {
        const Place at = plane.from(middle, lon_lat);
        const double away = std::hypot(at.x - top().x, at.y - top().y) / (hill_cells * s);
        return plain_m(at) + hill_m * std::exp(-away * away / 2);
    }
};

// The options that a refusal names, in their order.
void apply_remedy(const std::string& line, Recipe& recipe) {
    std::smatch found;
    const std::regex option("--(crs|zscale|vertical-unit) ([-+.0-9]+|EPSG:[0-9]+|[a-z]+(-[a-z]+)?|\"[^\"]+\")");
    if (!std::regex_search(line, found, option)) return;
    std::string value = found[2];
    if (value.front() == '"') value = value.substr(1, value.size() - 2);
    if (found[1] == "crs") recipe.crs = value;
    if (found[1] == "vertical-unit") recipe.vertical_unit = value;
    if (found[1] == "zscale") recipe.zscale = std::stod(value);
}

struct Outcome {
    bool able = false, refused = false, reprojected = false; // able: PROJ can do the CRS at this place
    std::string wrong;                                       // empty: nothing
};

std::string say(const char* what, double is, double right) {
    return fmt::format("{} {:.6g} instead of {:.6g}", what, is, right);
}

// What is wrong with a pack that should hold this ground; empty: nothing.
std::string compare(const std::string& path, const Ground& ground, double area_m2) {
    const PackSource source(path);
    const Plane plane(source.crs_wkt, is_swapped(source.crs_wkt));
    if (!plane.ok()) return "PROJ does not know the pack's CRS";
    std::vector<float> heights(static_cast<std::size_t>(source.columns) * static_cast<std::size_t>(source.rows));
    ReadStatistics statistics;
    source.reader()->read({0, 0, source.columns, source.rows}, heights.data(), statistics);
    const auto at = [&](int x, int y) { return heights[static_cast<std::size_t>(y * source.columns + x)]; };
    const auto lon_lat = [&](int x, int y) {
        return plane.to_degrees(
            {source.crs_origin[0] + x * source.crs_step[0], source.crs_origin[1] - y * source.crs_step[1]});
    };
    // Metres of the pack from the middle of the ground.
    const Place middle = plane.to_crs(ground.middle);
    const auto pack_m = [&](Place in_crs) {
        return Place{(in_crs.x - middle.x) * source.spacing_m[0] / source.crs_step[0],
                     (in_crs.y - middle.y) * source.spacing_m[1] / source.crs_step[1]};
    };
    double worst = 0, there = 0;
    int top_x = 0, top_y = 0;
    float highest = -1e9f;
    for (int y = 0; y < source.rows; ++y)
        for (int x = 0; x < source.columns; ++x) {
            const float height = at(x, y);
            if (std::isnan(height)) continue;
            ++there;
            if (height > highest) highest = height, top_x = x, top_y = y;
            if ((x % 4) + (y % 4) != 0 || x < 3 || y < 3 || x > source.columns - 4 || y > source.rows - 4) continue;
            bool rim = false; // beside nothing it is not cubic
            for (const int d : {-3, 3}) rim = rim || std::isnan(at(x + d, y)) || std::isnan(at(x, y + d));
            if (!rim) worst = std::max(worst, std::abs(height - ground.height_m(lon_lat(x, y))));
        }
    // A cell off on the hill's slope is 20 m, or 1 m on the plain; a cell that is twice as wide bends cubics by 1 m.
    if (!(worst <= 2)) return say("heights are off by", worst, 0);
    const double cell = source.spacing_m[0] / ground.s;
    if (!(cell > 0.5 && cell < 2)) return say("metres between samples", source.spacing_m[0], ground.s);
    if (const double is = there * source.spacing_m[0] * source.spacing_m[1]; !(std::abs(is / area_m2 - 1) < 0.04))
        return say("square metres of ground", is, area_m2);
    const double top_m = ground.plain_m(ground.top()) + hill_m;
    if (!(std::abs(highest - top_m) < 4)) return say("top of the hill", highest, top_m);
    const double reach = 1.5 * std::max(ground.s, source.spacing_m[0]);
    const Place top = ground.plane.from(ground.middle, lon_lat(top_x, top_y));
    if (!(std::hypot(top.x - ground.top().x, top.y - ground.top().y) < reach))
        return fmt::format("the hill lies {:.0f} m east and {:.0f} m north instead of {:.0f}, {:.0f}", top.x, top.y,
                           ground.top().x, ground.top().y);
    // As a mesh has it: metres of the pack alone.
    const Place seen =
        pack_m({source.crs_origin[0] + top_x * source.crs_step[0], source.crs_origin[1] - top_y * source.crs_step[1]});
    const double far = std::hypot(ground.top().x, ground.top().y);
    if (!(std::abs(std::hypot(seen.x, seen.y) - far) < reach + 0.006 * far))
        return say("metres from the middle to the hill", std::hypot(seen.x, seen.y), far);
    const Place east = pack_m(plane.to_crs(ground.plane.beside(ground.middle, {30 * ground.s, 0})));
    const Place north = pack_m(plane.to_crs(ground.plane.beside(ground.middle, {0, 30 * ground.s})));
    for (const Place& along : {east, north})
        if (const double metre = std::hypot(along.x, along.y) / (30 * ground.s); !(std::abs(metre - 1) < 0.007))
            return say("a metre of ground is", metre, 1);
    if (!(east.x * north.y - east.y * north.x > 0)) return "it is mirrored";
    // East is to the right, but in maps around a pole.
    if (std::abs(ground.middle.y) < 45 && !(east.x > std::abs(east.y))) return say("east points along x", east.x, 1);
    return {};
}

Outcome try_crs(const Listed& listed, std::mt19937& random, const std::string& folder) {
    const auto within = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    const double in_x = within(-0.5, 1.5), in_y = within(-0.5, 1.5), s = std::exp2(within(0, 9));
    const bool names_unit = within(0, 1) < 0.7;
    const Place middle{listed.west + in_x * (listed.east - listed.west),
                       listed.south + in_y * (listed.north - listed.south)};
    const std::string code = written_code(listed.code);
    const Plane plane(code, is_swapped(code));
    Outcome outcome;
    if (!plane.ok()) return outcome;
    const Ground ground{plane, middle, s};
    const Place at = plane.to_crs(middle);
    const Place right = plane.to_crs(plane.beside(middle, {s, 0})), up = plane.to_crs(plane.beside(middle, {0, s}));
    const double cell2 = std::abs((right.x - at.x) * (up.y - at.y) - (right.y - at.y) * (up.x - at.x));
    const double step = std::sqrt(cell2); // a cell of s metres of ground, as a square
    const Place back = plane.from(middle, plane.to_degrees(at)), top = plane.to_crs(plane.beside(middle, ground.top()));
    const double margin_x = columns / 2 - 6, margin_y = rows / 2 - 6; // cells: outside of the field is no hill
    if (!(step > 0) || !(std::hypot(back.x, back.y) < 0.01 * s) || !(std::abs(top.x - at.x) < margin_x * step) ||
        !(std::abs(top.y - at.y) < margin_y * step))
        return outcome;
    Raster field = raster(columns, rows, [&](int i, int j) {
        return ground.height_m(
            plane.to_degrees({at.x + (i - columns / 2) * step, at.y - (j - rows / 2) * step})); // NOLINT: whole halves
    });
    if (!std::all_of(field.values.begin(), field.values.end(), [](double v) { return v > 0 && v < 2000; }))
        return outcome;
    outcome.able = true;
    field.geotransform = {at.x - columns / 2.0 * step, step, 0, at.y + rows / 2.0 * step, 0, -step};
    field.crs = code;
    if (names_unit) field.more = [](GDALDataset& file) { file.GetRasterBand(1)->SetUnitType("m"); };
    const double unit_m = plane.unit_m;
    if (!names_unit) // who is asked says that heights are in the unit of the CRS
        for (double& height : field.values) height /= std::abs(unit_m - 1) > 0.01 ? unit_m : 1;
    const std::string tif = write(field, folder + "/hill.tif"), pack = folder + "/hill.fjell";
    Recipe recipe;
    for (int attempt = 0; attempt < 3; ++attempt) {
        try {
            const auto opened = open_source({tif}, read_options(recipe));
            outcome.reprojected = !opened->facts.reprojected_from.empty();
            BakeOptions options = small_bake(5);
            options.threads = 1;
            (void)bake(*opened, options, pack);
            outcome.wrong = compare(pack, ground, columns * rows * s * s);
            return outcome;
        } catch (const Failure& failure) {
            outcome.refused = true;
            outcome.wrong = failure.what();
            const Recipe before = recipe;
            apply_remedy(failure.what(), recipe);
            if (recipe == before) return outcome;
        }
    }
    return outcome;
}

} // namespace

TEST_CASE("a hill on a plane has its place, its size and its height in a pack, in any CRS of EPSG's") {
    const GdalMessages quiet;
    const unsigned seed = Catch::rngSeed() ? Catch::rngSeed() : std::random_device()();
    std::vector<Listed> all = all_of_epsg();
    REQUIRE(all.size() > 4000);
    std::shuffle(all.begin(), all.end(), std::mt19937(seed));
    const TemporaryFolder folder;
    const auto count = rounds<std::size_t>(12, 400); // all take two minutes
    std::size_t able = 0, refused = 0, reprojected = 0;
    for (std::size_t i = 0; i < std::min(count, all.size()); ++i) {
        std::mt19937 random(seed + static_cast<unsigned>(i));
        const Outcome o = try_crs(all[i], random, folder.path.string());
        able += o.able, refused += o.refused, reprojected += o.reprojected;
        INFO("--rng-seed " << seed << ", number " << i << ": " << all[i].code << " " << all[i].name);
        CHECK(o.wrong == "");
    }
    WARN("--rng-seed " << seed << ": " << able << " of " << count << " CRSs that PROJ can do, " << reprojected
                       << " reprojected, " << refused << " asked about");
    CHECK(able > count / 2);
}
