// Places with less detail, as the baker reads them: the same however they are read, and flat as the mesh is.
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "baker/bake/bake.h"
#include "baker/read/coarse_source.h"
#include "shared/terrain_data.h"
#include "source_check.h"
#include "support/dem.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;
using nlohmann::json;

namespace {

using Ring = std::vector<std::array<double, 2>>; // columns and rows

struct CoarseArea {
    Ring ring;
    double detail_m;
};

std::string geojson(const std::vector<CoarseArea>& areas, const Dem& dem) {
    json features = json::array();
    for (const CoarseArea& area : areas) {
        json places = json::array();
        for (const auto& p : area.ring) places.push_back({p[0] * dem.spacing_m[0], -p[1] * dem.spacing_m[1]});
        features.push_back({{"type", "Feature"},
                            {"properties", {{"detail_m", area.detail_m}}},
                            {"geometry", {{"type", "Polygon"}, {"coordinates", json::array({places})}}}});
    }
    return json{{"type", "FeatureCollection"}, {"features", features}}.dump();
}

Ring rectangle(double x0, double y0, double x1, double y1) {
    return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}, {x0, y0}};
}

bool is_near(const Ring& ring, double x, double y) { // inside, or nearly
    bool in = false;
    for (std::size_t i = 1; i < ring.size(); ++i) {
        const auto &a = ring[i - 1], &b = ring[i];
        if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) in = !in;
        const double dx = b[0] - a[0], dy = b[1] - a[1],
                     t = std::clamp(((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
        if (std::hypot(x - a[0] - t * dx, y - a[1] - t * dy) < 1e-3) return true;
    }
    return in;
}

std::unique_ptr<HeightSource> coarse_of(const Dem& dem, const std::string& path) {
    return coarse_source(std::make_unique<DemSource>(dem), path, {});
}

} // namespace

TEST_CASE("places with less detail are the same in whatever windows they are read, and other ground is as it was") {
    Random random(45);
    const TemporaryFolder folder;
    const std::string path = folder / "coarse.geojson";
    std::size_t changed = 0, kept = 0;
    for (int round = 0; round < rounds(30, 300); ++round) {
        Dem dem = random_dem(random, pick(random, 20, 300), pick(random, 20, 300),
                             static_cast<Shape>(round % static_cast<int>(Shape::count)));
        if (pick(random, 0, 2) == 0) add_random_holes(random, dem, 5);
        std::vector<CoarseArea> areas;
        for (int n = pick(random, 1, 3); n > 0; --n) {
            Ring ring;
            for (int i = pick(random, 3, 8); i > 0; --i)
                ring.push_back({uniform(random, -0.1, 1.1) * dem.columns, uniform(random, -0.1, 1.1) * dem.rows});
            ring.push_back(ring[0]);
            areas.push_back({ring, dem.spacing_m[0] * std::exp2(uniform(random, 1, 6))});
        }
        areas.push_back({rectangle(1, 1, 18.5, 18.5), dem.spacing_m[0] * 4}); // so that there is one
        dem.spacing_m[1] = dem.spacing_m[0];
        spit(path, geojson(areas, dem));
        const auto source = coarse_of(dem, path);
        CAPTURE(round, dem.columns, dem.rows, source->facts.coarse);
        const Field whole = read_whole(*source), before = read_whole(DemSource(dem));
        ReadStatistics statistics;
        if (round < 4) check_windows(*source);
        const auto reader = source->reader();
        for (int n = 0; n < 20; ++n) {
            const int x = pick(random, 0, dem.columns - 1), y = pick(random, 0, dem.rows - 1);
            const Window w{x, y, pick(random, 1, dem.columns - x), pick(random, 1, dem.rows - y)};
            CAPTURE(w.x, w.y, w.columns, w.rows);
            REQUIRE(same_bits(*reader, *source, whole, w, statistics));
        }
        std::size_t others = 0;
        for (std::size_t i = 0; i < whole.heights_m.size(); ++i) {
            const float a = before.heights_m[i], b = whole.heights_m[i];
            if (std::memcmp(&a, &b, sizeof a) == 0) {
                ++kept;
                continue;
            }
            ++changed;
            const auto x = static_cast<double>(i % static_cast<std::size_t>(dem.columns)),
                       y = static_cast<double>(i / static_cast<std::size_t>(dem.columns));
            others += std::none_of(areas.begin(), areas.end(),
                                   [&](const CoarseArea& area) { return is_near(area.ring, x, y); });
        }
        CHECK(others == 0);
        CHECK(whole.statistics.voids.count == before.statistics.voids.count);
    }
    CHECK(changed > rounds<std::size_t>(50'000, 500'000));
    CHECK(kept > rounds<std::size_t>(100'000, 1'000'000));
}

TEST_CASE("where detail was left out finer vertices have no error, and the pack keeps its promises") {
    Random random(46);
    const TemporaryFolder folder;
    const std::string path = folder / "coarse.geojson";
    std::size_t flat = 0, rough = 0;
    for (int round = 0; round < rounds(6, 40); ++round) {
        Dem dem = random_dem(random, 257, 257, Shape::fractal);
        const int log2 = pick(random, 1, 3), side = 1 << log2;
        dem.spacing_m[1] = dem.spacing_m[0];
        spit(path, geojson({{rectangle(30, 40, 200, 190), dem.spacing_m[0] * side * 1.5}}, dem));
        const auto source = coarse_of(dem, path);
        CAPTURE(round, side, source->facts.coarse);
        const std::string pack = folder / "coarse.fjell";
        (void)bake(*source, small_bake(pick(random, log2 + 1, 7)), pack);
        const io::LoadedPack loaded = io::load_pack(pack, io::LoadTerrain::yes);
        const TerrainData& t = data_of(loaded.terrain);
        REQUIRE(verify(loaded.terrain, source.get()).ok());
        // Squares in the middle, two from those that keep their detail: what these ask for nests no further.
        const int margin = 3 * side;
        float most_m = 0;
        for (std::int32_t y = 40 + margin; y <= 190 - margin; ++y)
            for (std::int32_t x = 30 + margin; x <= 200 - margin; ++x)
                if (x % side != 0 || y % side != 0) most_m = std::max(most_m, t.vertex({x, y}).error_m), ++flat;
        CHECK(most_m <= 2 * t.header.quantum_m); // heights are rounded to steps, and errors nest
        for (std::int32_t x = 1; x < 257; x += 2) rough += t.vertex({x, 20}).error_m > 2 * t.header.quantum_m;
    }
    CHECK(flat > rounds<std::size_t>(50'000, 500'000));
    CHECK(rough > rounds<std::size_t>(200, 2'000));
}
