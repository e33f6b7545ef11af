// A pack with stamps baked from what they reach: the pack that a bake of all of it gives, byte for byte.
#include <filesystem>
#include <fstream>

#include "baker/bake/bake.h"
#include "baker/bake/inputs.h"
#include "baker/check/verify.h"
#include "baker/check/verify_maps.h"
#include "baker/read/edited_source.h"
#include "baker/read/pack_source.h"
#include "io/stamps.h"
#include "source_check.h"
#include "support/dem.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

namespace {

std::vector<io::TimedStamp> any_stamps(Random& random, const PackHeader& h) {
    std::vector<io::TimedStamp> all;
    const double wide = h.spacing_m[0] * (h.columns - 1), high = h.spacing_m[1] * (h.rows - 1);
    const double relief = std::max<double>(h.max_m - h.min_m, h.quantum_m * 20);
    const double x = uniform(random, -0.05, 1.05) * wide, z = uniform(random, -0.05, 1.05) * high;
    if (pick(random, 0, 2) == 0) { // a single sample, which may be no centre of any step
        io::KeptStamp kept;
        kept.plain.shape = StampShape::raise;
        kept.plain.x_m = std::round(x / h.spacing_m[0]) * h.spacing_m[0];
        kept.plain.z_m = std::round(z / h.spacing_m[1]) * h.spacing_m[1];
        kept.plain.radius_m = static_cast<float>(std::min(h.spacing_m[0], h.spacing_m[1]) * 0.4);
        kept.plain.amount_m = static_cast<float>(relief * uniform(random, -0.05, 0.05));
        return {{0, kept}};
    }
    for (int i = pick(random, 1, 3); i > 0; --i) {
        io::KeptStamp kept;
        Stamp& s = kept.plain;
        constexpr StampShape shapes[] = {StampShape::raise, StampShape::level,  StampShape::crater,
                                         StampShape::noise, StampShape::smooth, StampShape::paint};
        s.shape = shapes[pick(random, 0, 5)];
        s.radius_m = static_cast<float>(h.spacing_m[0] * std::pow(10.0, uniform(random, 0, 1.4)));
        s.falloff_m = s.radius_m * static_cast<float>(uniform(random, 0, 1));
        s.x_m = x + uniform(random, -40, 40) * h.spacing_m[0], s.z_m = z + uniform(random, -40, 40) * h.spacing_m[1];
        if (s.shape == StampShape::raise || s.shape == StampShape::crater || s.shape == StampShape::noise)
            s.amount_m = static_cast<float>(relief * uniform(random, -0.03, 0.03));
        if (s.shape == StampShape::level) s.height_m = static_cast<float>(uniform(random, h.min_m, h.max_m));
        if (s.shape == StampShape::noise) s.wavelength_m = static_cast<float>(h.spacing_m[0] * uniform(random, 1, 20));
        all.push_back({0, kept});
    }
    return all;
}

std::string slurp_bytes(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

} // namespace

TEST_CASE("a pack with stamps is baked from what they reach, and is the pack that a bake of all gives") {
    Random random(45);
    int equal = 0, sound = 0;
    std::uint64_t kept_bytes = 0;
#ifdef FJELL_SANITIZED // there a bake takes fifty times as long
    const int all_rounds = 3;
#else
    const int all_rounds = rounds(12, 150);
#endif
    for (int round = 0; round < all_rounds; ++round) {
        const int log2 = pick(random, 1, 8);
        const TemporaryFolder folder;
        Dem dem = random_dem(random, pick(random, 20, 600), pick(random, 20, 600),
                             static_cast<Shape>(round % static_cast<int>(Shape::count)));
        BakeOptions options = small_bake(log2);
        options.region_cells = pick(random, 0, 2) ? 16 << pick(random, 0, 4) : 256;
        if (pick(random, 0, 7) == 0) options.horizon_spacing = 4;
        if (pick(random, 0, 2) == 0) options.order = PageOrder::hierarchical_z;
        if (pick(random, 0, 3) == 0) options.estimate = ErrorEstimate::midpoint;
        options.threads = pick(random, 1, 3);
        options.keep_unchanged = false;
        std::string pack = folder / "rounded.fjell";
        BakeSummary was = bake(dem, options, pack);
        if (pick(random, 0, 3) != 0) { // one that was baked from what it holds
            pack = folder / "whole.fjell";
            was = bake(PackSource(folder / "rounded.fjell"), options, pack);
        }
        const auto stamps = any_stamps(random, PackSource(pack).header());
        CAPTURE(round, log2, dem.columns, dem.rows, options.region_cells, was.on_scale, io::write_stamps(stamps));
        const auto source = [&] { return edited_source(std::make_unique<PackSource>(pack), stamps, "stamps"); };
        const std::string all = folder / "all.fjell", some = folder / "some.fjell";
        const BakeSummary of_all = bake(*source(), options, all);
        options.keep_unchanged = true;
        const BakeSummary of_some = bake(*source(), options, some);
        CHECK(of_all.kept_bytes == 0);
        if (was.on_scale || !of_some.kept_nothing.empty()) {
            const bool same = slurp_bytes(some) == slurp_bytes(all);
            REQUIRE(same);
        }
        if (!of_some.kept_nothing.empty()) continue;
        kept_bytes += of_some.kept_bytes;
        (was.on_scale ? equal : sound) += 1;
        if (was.on_scale) continue;
        // What was baked from finer heights is kept; the pack keeps its promises, and has the heights of a flight.
        const io::PackFile file(some);
        const VerifyReport report = verify(file, source().get());
        CAPTURE(report.nesting_violations, report.sphere_violations, report.border_mismatches, report.rim_violations,
                report.bound_violations, report.height_mismatches, report.true_error_violations);
        CAPTURE(report.first);
        REQUIRE(report.ok());
        REQUIRE(check_maps(file).ok());
        const std::vector<float> is = read_whole(PackSource(some)).heights_m, asked = read_whole(*source()).heights_m;
        REQUIRE(is == asked);
    }
    if (all_rounds < 12) return; // too few to count
    CHECK(equal > rounds(3, 40));
    CHECK(sound >= rounds(1, 15));
    CHECK(kept_bytes > rounds(100'000, 2'000'000));
}

TEST_CASE("a bake of all that was interrupted goes on, though stamps reach only a part") {
    Random random(46);
    const TemporaryFolder folder;
    const std::string pack = folder / "pack.fjell", out = folder / "out.fjell", whole = folder / "whole.fjell";
    BakeOptions options = small_bake(4);
    options.keep_unchanged = false;
    (void)bake(random_dem(random, 150, 120, Shape::fractal), options, pack);
    io::KeptStamp kept;
    kept.plain.shape = StampShape::smooth;
    const PackHeader h = PackSource(pack).header();
    kept.plain.x_m = h.spacing_m[0] * 70, kept.plain.z_m = h.spacing_m[1] * 60;
    kept.plain.radius_m = static_cast<float>(h.spacing_m[0] * 5);
    const auto source = [&] { return edited_source(std::make_unique<PackSource>(pack), {{0, kept}}, "stamps"); };
    (void)bake(*source(), options, whole);
    options.checkpoint_s = 5; // on the disk, though it would fit the memory
    options.progress = [](const char* stage, std::uint64_t, std::uint64_t) {
        if (stage == std::string("steps")) throw io::Failure(130, "no more");
    };
    REQUIRE_THROWS_WITH(bake(*source(), options, out), Catch::Contains("the same command goes on"));
    options.progress = {};
    options.keep_unchanged = true;
    const BakeSummary said = bake(*source(), options, out);
    CHECK(said.resumed);
    CHECK(said.kept_nothing.find("goes on") != std::string::npos);
    const bool same = slurp_bytes(out) == slurp_bytes(whole);
    CHECK(same);
}
