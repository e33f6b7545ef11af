// Where packs of a set meet: every map and every vertex is compared there as it is within one pack.
#include <catch2/catch.hpp>

#include "baker/check/verify.h"
#include "baker/check/verify_maps.h"
#include "support/control_rules.h"
#include "support/set_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr std::int32_t samples = 4 * 32 + 1; // tiles of 32 cells, four a side

baker::Dem square_field() {
    Random random(2201);
    baker::Dem dem = random_dem(random, samples, samples, Shape::fractal);
    dem.spacing_m[0] = dem.spacing_m[1] = 30;
    return dem;
}
// With all kinds of maps.
baker::BakeOptions options(const RulesFile& rules) {
    baker::BakeOptions o = small_bake(5);
    o.max_texture_log2 = 5;
    o.quantum_m = 0.1;
    o.horizon_spacing = 2;
    o.layers_path = rules.path();
    return o;
}

// A set of 2 x 2 packs of which each of two may be another bake's.
struct Mixed {
    explicit Mixed(const baker::Dem& dem, const baker::BakeOptions& of_all) { set_of(dem, of_all, "set"); }
    void set_of(const baker::Dem& dem, const baker::BakeOptions& how, const std::string& name) const {
        (void)baker::bake(dem, how, folder / (name + ".fjell"));
        (void)baker::split_pack(folder / (name + ".fjell"), folder / name, {2, 2});
    }
    // The pack to the north-east is that of another bake. set.json no longer says which it must be.
    void replace(const baker::Dem& dem, const baker::BakeOptions& how) const {
        set_of(dem, how, "other");
        spit(folder / "set/1-0.fjell", slurp(folder / "other/1-0.fjell"));
        io::SetFile index = io::parse_set_file(slurp(set + "/set.json"), "set");
        for (io::SetFilePack& pack : index.packs) pack.has_hash = false;
        spit(set + "/set.json", io::set_file_text(index));
    }
    TemporaryFolder folder;
    const std::string set = folder / "set";
};

} // namespace

TEST_CASE("where packs of a set meet as many texels and vertices are compared as within one pack, and agree") {
    const RulesFile rules;
    const Mixed mixed(square_field(), options(rules));
    const io::PackFile set(mixed.set), whole(mixed.folder / "set.fjell");
    REQUIRE(set.packs() == 4);
    const baker::MapsReport maps = baker::check_maps(set), of_whole = baker::check_maps(whole);
    CHECK(maps.first == "");
    CHECK(maps.ok());
    CHECK(maps.border_texels == of_whole.border_texels);
    CHECK(maps.border_texels > 0);
    const baker::VerifyReport report = baker::verify(set, nullptr);
    CHECK(report.first == "");
    CHECK(report.ok());
    CHECK(report.samples_compared == baker::verify(whole, nullptr).samples_compared);
}

TEST_CASE("packs whose borders differ are a set, and verify finds the seam, in the mesh and in each kind of map") {
    const RulesFile rules;
    const baker::Dem dem = square_field();
    const auto seam = [&](const baker::Dem& other, const baker::BakeOptions& how) {
        const Mixed mixed(dem, options(rules));
        mixed.replace(other, how);
        const io::PackFile set(mixed.set);
        return std::pair{baker::verify(set, nullptr), baker::check_maps(set)};
    };
    const auto raised = [&](std::int32_t x, std::int32_t y, float by_m) {
        baker::Dem other = dem;
        other.heights_m[other.index(x, y)] += by_m;
        return other;
    };
    const baker::MapsReport sound = seam(dem, options(rules)).second;
    {
        // A sample on the border of two packs, but no tile's corner, which the set itself would refuse.
        const auto [report, maps] = seam(raised(64, 17, 1), options(rules));
        CHECK(report.border_mismatches > 0);
    }
    {
        const auto [report, maps] = seam(raised(65, 17, 300), options(rules)); // beside it: slopes differ there
        CHECK(maps.normal_border_most > 2 * sound.normal_border_most);
        CHECK(maps.border_violations > 0);
    }
    {
        const auto [report, maps] = seam(raised(70, 17, 200), options(rules)); // stands over the horizon
        CHECK(maps.horizon_border_most > 2 * sound.horizon_border_most);
        CHECK(maps.border_violations > 0);
    }
    {
        baker::BakeOptions how = options(rules);
        how.ramp_path = rules.beside("ramp.json");
        spit(how.ramp_path, R"({"stops": [{"height_m": 0, "rgb": [255, 0, 0]}, {"height_m": 1, "rgb": [250, 0, 0]}]})");
        const auto [report, maps] = seam(dem, how);
        CHECK(report.ok());
        CHECK(maps.border_violations > 0);
        CHECK(maps.first.find("colour map") == 0);
    }
    {
        std::string text = control_rules;
        text.replace(text.find("0.7"), 3, "0.1");
        const RulesFile other(text);
        const auto [report, maps] = seam(dem, options(other));
        CHECK(report.ok());
        CHECK(maps.border_violations > 0);
        CHECK(maps.first.find("control map") == 0);
    }
}
