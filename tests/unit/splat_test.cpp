// Splat maps: their rules, and what is baked of them.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "baker/check/verify_maps.h"
#include "baker/maps/splat.h"
#include "baker/maps/wetness.h"
#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "fjell/texture.h"
#include "raster.h"
#include "support/splat_rules.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

namespace {

using NamedShares = std::map<std::string, double>;

std::string rules_refusal(const std::string& rules) {
    try {
        (void)parse_splat(rules, "rules.json");
    } catch (const io::Failure& failure) {
        CHECK(failure.exit_code == 1);
        return failure.what();
    }
    return "taken";
}

// A pack's texel as weights of names, 1 in all.
class SplatMip {
public:
    SplatMip(const Pack& pack, std::uint32_t tile, std::uint32_t mip)
        : side_((1u << pack.header.splat_log2) >> mip),
          texels_(chunk_raw_bytes(pack.header, {ChunkKind::splat, tile, mip})) {
        REQUIRE(read_chunk(pack, {ChunkKind::splat, tile, mip}, texels_).ok());
        std::vector<std::byte> text(pack.header.layer_bytes);
        REQUIRE(read_chunk(pack, {ChunkKind::layers, 0, 0}, text).ok());
        names_ = io::layer_names({reinterpret_cast<const char*>(text.data()), text.size()});
    }
    [[nodiscard]] std::uint32_t side() const { return side_; }
    [[nodiscard]] NamedShares at(std::uint32_t x, std::uint32_t y) const {
        NamedShares shares;
        for (std::size_t k = 0; k < splat_layers; ++k) {
            const std::byte* const pair = texels_.data() + (std::size_t{y} * side_ + x) * splat_texel_bytes + 2 * k;
            if (pair[0] != std::byte{0})
                shares[names_.at(std::to_integer<std::size_t>(pair[1]))] += std::to_integer<int>(pair[0]) / 255.0;
        }
        return shares;
    }

private:
    std::uint32_t side_;
    std::vector<std::byte> texels_;
    std::vector<std::string> names_;
};

double trapezoid(double value, double low, double high, double soft) {
    return std::clamp((value - low) / soft + 0.5, 0.0, 1.0) * std::clamp((high - value) / soft + 0.5, 0.0, 1.0);
}

// The rules of the test below, straight from the guide's words, at one sample.
NamedShares shares_by_hand(const Dem& dem, int x, int y) {
    const auto at = [&](int u, int v) {
        return static_cast<double>(dem.at(std::clamp(u, 0, dem.columns - 1), std::clamp(v, 0, dem.rows - 1)));
    };
    const auto rise = [&](int dx, int dy, double spacing) {
        const int before = (dx ? std::max(x - 1, 0) : std::max(y - 1, 0)),
                  after = dx ? std::min(x + 1, dem.columns - 1) : std::min(y + 1, dem.rows - 1);
        return ((dx ? at(after, y) : at(x, after)) - (dx ? at(before, y) : at(x, before))) /
               ((after - before) * spacing) * (dx + dy);
    };
    const double east = rise(1, 0, dem.spacing_m[0]), south = rise(0, 1, dem.spacing_m[1]);
    const double slope = std::atan(std::hypot(east, south)) * 180 / 3.14159265358979;
    double azimuth = std::atan2(-east, south) * 180 / 3.14159265358979; // water runs against the rise; south is -north
    if (azimuth < 0) azimuth += 360;
    const double bend =
        500 * ((2 * at(x, y) - at(x - 2, y) - at(x + 2, y)) / (4 * dem.spacing_m[0] * dem.spacing_m[0]) +
               (2 * at(x, y) - at(x, y - 2) - at(x, y + 2)) / (4 * dem.spacing_m[1] * dem.spacing_m[1]));
    const double off_east = std::abs(azimuth - 80); // from 10 to 150 degrees
    NamedShares s{{"grass", 1}};
    const auto lay = [&](const char* name, double share) {
        for (auto& [other, left] : s) left *= 1 - share;
        s[name] += share;
    };
    lay("soil", 0.6 * trapezoid(off_east > 180 ? 360 - off_east : off_east, -1e9, 70, 30) * std::min(slope / 2, 1.0));
    lay("scree", trapezoid(bend, -1e9, -1, 4));
    lay("rock", trapezoid(slope, 25, 1e9, 12));
    lay("snow", trapezoid(at(x, y), 400, 900, 150) * 0.9);
    return s;
}

constexpr const char* evaluated_rules = R"({"rules": [{"layer": "grass"},
  {"layer": "soil", "aspect_deg": [10, 150], "aspect_soft_deg": 30, "opacity": 0.6},
  {"layer": "scree", "curvature_per_km": [null, -1], "curvature_soft_per_km": 4},
  {"layer": "rock", "slope_deg": [25, null], "slope_soft_deg": 12, "ragged": 0},
  {"layer": "snow", "height_m": [400, 900], "height_soft_m": 150, "ragged": 0, "opacity": 0.9}]})";

// Weights over the samples of every (1 << stride)-th column of a tent at a texel's place.
std::vector<std::pair<int, double>> tent_taps(double place, double radius, int last) {
    std::vector<std::pair<int, double>> taps;
    double all = 0;
    for (int i = std::max(static_cast<int>(std::ceil(place - radius)), 0);
         i <= std::min(static_cast<int>(place + radius), last); ++i)
        if (const double w = radius - std::abs(i - place); w > 0) taps.push_back({i, w}), all += w;
    for (auto& tap : taps) tap.second /= all;
    return taps;
}

} // namespace

TEST_CASE("rules of splat maps that cannot be are refused in one line with file, line and rule") {
    CHECK(rules_refusal(splat_rules) == "taken");
    const auto rule = [](const std::string& text) {
        return rules_refusal("{\n  // comment [ {\n  \"rules\": [\n    {\"layer\": \"a\"},\n    {" + text + "}\n]}");
    };
    const auto says = [](const std::string& line, const std::string& begin) {
        CAPTURE(line, begin);
        CHECK(line.find("rules.json:5: rule 1" + begin) == 0);
        CHECK(line.find('\n') == std::string::npos);
        CHECK(line.find("; docs/guides/materials.md has rules that work") != std::string::npos);
    };
    says(rule(R"("slope_deg": [3, 4])"), ": names no layer; give \"layer\"");
    says(rule(R"("layer": "")"), ": \"layer\" must name a material in 1 to 31 characters");
    says(rule(R"("layer": "b", "colour": 1)"), " (b): unknown field \"colour\"");
    says(rule(R"("layer": "b", "slope_deg": [40, 30])"), " (b): \"slope_deg\" must be two numbers in 0..90, the lower");
    says(rule(R"("layer": "b", "opacity": 2)"), " (b): \"opacity\" must be a number in 0..1");
    says(rule(R"("layer": "b", "aspect_soft_deg": 20)"), " (b): \"aspect_soft_deg\" is of no use without");
    says(rule(R"("classes": "c.tif")"), " (c.tif): a raster of classes needs \"layers\"");
    says(rule(R"("classes": "c.tif", "layers": {"70000": "b"})"), " (c.tif): class \"70000\" must be a whole number");
    says(rule(R"("painted": "p.png", "colours": {"red": "b"})"), " (p.png): colour \"red\" must be #rrggbb");
    says(rule(R"("painted": "p.png")"), " (p.png): an image needs either");
    says(rule(R"("layer": "b", "classes": "c.tif")"), ": \"layer\", \"classes\" and \"painted\" exclude each other");
    std::string many = "{\"rules\": [";
    for (int i = 0; i < 17; ++i) many += "{\"layer\": \"m" + std::to_string(i) + "\"},\n";
    many.resize(many.size() - 2);
    CHECK(rules_refusal(many + "]}").find("rules.json:17: rule 16: \"m16\" would be the 17th material") == 0);
    CHECK(rules_refusal("{\"rules\": []}").find("rules.json: \"rules\" must be a list of 1 to 32 rules") == 0);
}

TEST_CASE("a baked splat map shows what its rules say of each texel's place, evaluated by themselves") {
    Random random(31);
    for (const int spacing : {1, 2, 4}) {
        Dem dem;
        dem.columns = 97, dem.rows = 81;
        dem.spacing_m[0] = 30, dem.spacing_m[1] = 25;
        for (int y = 0; y < dem.rows; ++y)
            for (int x = 0; x < dem.columns; ++x)
                dem.heights_m.push_back(static_cast<float>(
                    450 + 90 * std::sin(0.21 * x) + 110 * std::cos(0.15 * y + 0.06 * x) + uniform(random, 0, 4)));
        const RulesFile rules(evaluated_rules);
        BakeOptions options = small_bake(5);
        options.max_texture_log2 = 6;
        options.layers_path = rules.path();
        options.splat_spacing = spacing;
        const auto loaded = bake_and_load(dem, options);
        const Pack& pack = loaded.pack;
        CHECK(pack.header.features == pack_has_splat);
        const MapsReport report = check_maps(pack);
        CAPTURE(spacing, report.first);
        CHECK(report.ok());
        CHECK(1u << pack.header.splat_log2 == 32u / static_cast<unsigned>(spacing));
        double most = 0;
        std::size_t compared = 0, mixed = 0;
        for (const std::uint32_t tile : {0u, 5u, 8u}) {
            const SplatMip mip(pack, tile, 0);
            for (std::uint32_t j = 0; j < mip.side(); ++j)
                for (std::uint32_t i = 0; i < mip.side(); ++i) {
                    // Texels stand on the tile's borders and evenly between them; points are every spacing-th sample.
                    const double step = 32.0 / (mip.side() - 1);
                    const auto axis = [&](std::uint32_t first, std::uint32_t at, int samples) {
                        return std::min(first * 32 + at * step, samples - 1.0) / spacing;
                    };
                    const double px = axis(tile % pack.header.tiles_x, i, dem.columns),
                                 py = axis(tile / pack.header.tiles_x, j, dem.rows);
                    const double radius = step / spacing;
                    NamedShares wanted;
                    for (const auto& [y, wy] : tent_taps(py, radius, (dem.rows - 2) / spacing + 1))
                        for (const auto& [x, wx] : tent_taps(px, radius, (dem.columns - 2) / spacing + 1))
                            for (const auto& [name, share] : shares_by_hand(dem, std::min(x * spacing, dem.columns - 1),
                                                                            std::min(y * spacing, dem.rows - 1)))
                                wanted[name] += wx * wy * share;
                    std::vector<double> in_order;
                    for (const auto& [name, share] : wanted) in_order.push_back(share);
                    std::ranges::sort(in_order, std::greater());
                    const NamedShares found = mip.at(i, j);
                    double sum = 0;
                    for (const auto& [name, share] : found) sum += share;
                    CHECK(sum == Approx(1)); // the first rule covers all
                    // What a fifth material had goes to the four others; then half a step of rounding, twice for the
                    // largest, which takes up the rest, and what floats differ by.
                    const double hidden = in_order.size() > 4 ? in_order[4] : 0;
                    for (const auto& [name, share] : wanted) {
                        if (!found.contains(name)) {
                            CHECK(share <= hidden + 3.0 / 255);
                            continue;
                        }
                        most = std::max(most, std::abs(found.at(name) - share / (1 - hidden)));
                        ++compared;
                    }
                    mixed += found.size() > 1;
                }
        }
        CHECK(most < 2.6 / 255);
        CHECK(compared > 300);
        CHECK(mixed > 100);
    }
}

TEST_CASE("wetness grows along a valley, is least on its ridges, and a pit does not end it") {
    WetnessGrid grid{41, 61, 0, {30, 30}};
    std::vector<float> heights;
    for (int y = 0; y < grid.rows; ++y)
        for (int x = 0; x < grid.columns; ++x)
            heights.push_back(static_cast<float>(8 * std::abs(x - 20) - 3 * y + (x == 20 && y == 30 ? -40 : 0)));
    const Wetness wetness(grid, heights);
    for (const int y : {10, 20, 40, 50}) {
        CHECK(wetness.of_cell(20, y) > wetness.of_cell(10, y) + 2);
        CHECK(wetness.of_cell(20, y) > wetness.of_cell(20, y / 2));
        CHECK(wetness.of_cell(3, y) < 8);
    }
    CHECK(wetness.at(20, 40) == wetness.of_cell(20, 40)); // a cell a sample: nothing between
    // All that falls on the terrain above a row leaves through it: the areas of a row add up.
    for (const int samples : {1024, 1025, 5000}) {
        const WetnessGrid large = wetness_grid(samples, samples / 2, {10, 20});
        CHECK(large.columns <= max_wetness_cells);
        CHECK(large.columns << large.factor_log2 >= samples);
        CHECK(large.spacing_m[1] == 20 * (1 << large.factor_log2));
    }
}

TEST_CASE("rules of content for splat maps are taken, and name materials of content, or water") {
    const std::filesystem::path content = FJELL_SOURCE_DIR "/content/materials";
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(content / "splat")) {
        CAPTURE(entry.path().string());
        ++files;
        for (const std::string& name : read_splat(entry.path().string()).names) {
            CAPTURE(name);
            CHECK((name == "water" || std::filesystem::exists(content / (name + ".json"))));
        }
    }
    CHECK(files >= 2);
}

TEST_CASE("classes and paint lie where their rasters lie, warped or stretched, and nothing is mixed of two classes") {
    Dem dem;
    dem.columns = dem.rows = 65;
    dem.heights_m.assign(65 * 65, 10);
    dem.spacing_m[0] = dem.spacing_m[1] = 10;
    dem.crs_origin[0] = 500'000, dem.crs_origin[1] = 5'000'000;
    dem.crs_step[0] = dem.crs_step[1] = 10;
    OGRSpatialReference utm;
    utm.importFromEPSG(32633);
    char* text = nullptr;
    utm.exportToWkt(&text);
    dem.crs_wkt = text;
    CPLFree(text);
    // Classes 7 in the west, 300 in the east, 9, which no table has, in the south: 20 m a pixel, of the whole terrain.
    Raster classes{34, 34, {}, GDT_UInt16, 1, {499'980, 20, 0, 5'000'020, 0, -20}, "EPSG:32633", {}};
    for (int y = 0; y < 34; ++y)
        for (int x = 0; x < 34; ++x) classes.values.push_back(y >= 25 ? 9 : x < 16 ? 7 : 300);
    const auto baked = [&](const std::string& rules) {
        const RulesFile file(rules);
        Raster elsewhere = classes;
        (void)write(classes, file.beside("classes.tif"));
        elsewhere.geotransform.clear(), elsewhere.crs.clear();
        (void)write(elsewhere, file.beside("stretched.tif"));
        // Red, green, blue over thirds of the width.
        Raster paint{96, 96, {}, GDT_Byte, 3, {}, "", {}};
        paint.values.assign(96 * 96, 0);
        paint.more = [](GDALDataset& to) {
            for (int band = 0; band < 3; ++band) {
                std::vector<std::uint8_t> values;
                for (int i = 0; i < 96 * 96; ++i)
                    values.push_back(static_cast<std::uint8_t>(i % 96 / 32 == band ? 250 : 4));
                REQUIRE(to.GetRasterBand(band + 1)->RasterIO(GF_Write, 0, 0, 96, 96, values.data(), 96, 96, GDT_Byte, 0,
                                                             0, nullptr) == CE_None);
            }
        };
        (void)write(paint, file.beside("paint.tif"));
        Raster wide = classes;
        wide.columns = 17, wide.rows = 68, wide.geotransform.clear(), wide.crs.clear();
        (void)write(wide, file.beside("wide.tif"));
        Raster two = classes;
        two.bands = 2, two.more = [](GDALDataset& to) {
            to.GetRasterBand(1)->SetDescription("cover"), to.GetRasterBand(2)->SetDescription("certainty");
        };
        (void)write(two, file.beside("two.tif"));
        BakeOptions options = small_bake(5);
        options.max_texture_log2 = 6;
        options.layers_path = file.path();
        return bake_and_load(dem, options);
    };
    const auto share = [&](const io::LoadedPack& pack, double east, double south) {
        const double at_x = east * 64, at_y = south * 64;
        const auto tile = static_cast<std::uint32_t>(at_y / 32) * 2 + static_cast<std::uint32_t>(at_x / 32);
        const SplatMip mip(pack.pack, tile, 0);
        const auto texel = [&](double at) {
            return static_cast<std::uint32_t>(std::fmod(at, 32) / 32 * (mip.side() - 1) + 0.5);
        };
        return mip.at(texel(at_x), texel(at_y));
    };
    for (const char* const name : {"classes.tif", "stretched.tif"}) {
        CAPTURE(name);
        const auto pack = baked(std::string(R"({"rules": [{"layer": "grass"}, {"classes": ")") + name +
                                R"(", "layers": {"7": "rock", "300": "snow"}}]})");
        CHECK(share(pack, 0.2, 0.4) == NamedShares{{"rock", 1}});
        CHECK(share(pack, 0.8, 0.4) == NamedShares{{"snow", 1}});
        CHECK(share(pack, 0.4, 0.9) == NamedShares{{"grass", 1}});
        CHECK(check_maps(pack.pack).ok());
    }
    const auto alone = baked(R"({"rules": [{"classes": "classes.tif", "layers": {"7": "rock"}, "opacity": 0.5}]})");
    CHECK(share(alone, 0.8, 0.4).empty()); // no rule covers it: its colour map stays
    CHECK(share(alone, 0.2, 0.4).at("rock") == Approx(0.5).margin(0.003));
    const auto painted =
        baked(R"({"rules": [{"painted": "paint.tif", "colours": {"#ff0000": "rock", "#00ff00": "grass"}}]})");
    CHECK(share(painted, 0.15, 0.5) == NamedShares{{"rock", 1}});
    CHECK(share(painted, 0.45, 0.5) == NamedShares{{"grass", 1}});
    CHECK(share(painted, 0.85, 0.5).empty());
    const auto weights = baked(R"({"rules": [{"painted": "paint.tif", "channels": ["rock", null, "snow"]}]})");
    CHECK(share(weights, 0.15, 0.5).at("rock") == Approx(250.0 / 255).margin(0.003));
    CHECK(share(weights, 0.85, 0.5).at("snow") == Approx(250.0 / 255).margin(0.003));
    const auto line = [&](const std::string& rule) {
        return refusal([&] { (void)baked("{\"rules\": [{" + rule + "}]}"); });
    };
    const Refusal oblong = line(R"("classes": "wide.tif", "layers": {"7": "rock"})");
    CHECK(oblong.says("wide.tif: has 17 x 68 pixels and no georeference"));
    CHECK(oblong.says("gdal_translate -a_srs -a_ullr"));
    for (const char* const rule :
         {R"("classes": "two.tif", "layers": {"7": "rock"})", R"("painted": "two.tif", "channels": ["rock"])"}) {
        CHECK(line(rule).says("two.tif: has 2 bands, 1 \"cover\", 2 \"certainty\"; give a raster with the one that "));
        CHECK(line(rule).says("gdal_translate -b N"));
    }
}
