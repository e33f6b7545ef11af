// Locks: along them what is drawn keeps their errors, in any view; elsewhere nothing changes.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "support/ground_truth.h"
#include "support/program.h"
#include "support/rounds.h"
#include "support/shard_scene.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;
using nlohmann::json;

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();
using Place = std::array<double, 2>; // columns and rows

struct Lock {
    std::string kind; // Point, LineString, Polygon
    std::vector<Place> places;
    double width_m = 0, error_m = no_limit, error_px = no_limit;
};

// Lines that cross themselves, polygons that do, and what lies beside the terrain: as maps have them.
Lock random_lock(Random& random, const baker::Dem& dem) {
    constexpr const char* kinds[] = {"Point", "LineString", "Polygon"};
    Lock lock;
    lock.kind = kinds[pick(random, 0, 2)];
    const int count = lock.kind == "Point" ? 1 : pick(random, 3, 8);
    for (int i = 0; i < count; ++i)
        lock.places.push_back({uniform(random, -0.1, 1.1) * dem.columns, uniform(random, -0.1, 1.1) * dem.rows});
    if (lock.kind == "Polygon") lock.places.push_back(lock.places[0]);
    if (pick(random, 0, 1) != 0) lock.width_m = uniform(random, 0, 4 * dem.spacing_m[0]);
    const int which = pick(random, 0, 3);
    if (which != 1) lock.error_m = pick(random, 0, 2) == 0 ? 0 : std::exp2(uniform(random, -6, 4));
    if (which <= 1) lock.error_px = std::exp2(uniform(random, -6, 0));
    return lock;
}

std::string geojson(const std::vector<Lock>& locks, const baker::Dem& dem) {
    json features = json::array();
    for (const Lock& lock : locks) {
        json places = json::array();
        for (const Place& p : lock.places) places.push_back({p[0] * dem.spacing_m[0], -p[1] * dem.spacing_m[1]});
        json properties = json::object();
        if (lock.width_m > 0) properties["width_m"] = lock.width_m;
        if (lock.error_m != no_limit) properties["error_m"] = lock.error_m;
        if (lock.error_px != no_limit) properties["error_px"] = lock.error_px;
        json where = lock.kind == "Point" ? places[0] : lock.kind == "Polygon" ? json::array({places}) : places;
        features.push_back({{"type", "Feature"},
                            {"properties", properties},
                            {"geometry", {{"type", lock.kind}, {"coordinates", where}}}});
    }
    return json{{"type", "FeatureCollection"}, {"features", features}}.dump();
}

bool inside(const std::vector<Place>& ring, Place p) {
    bool in = false;
    for (std::size_t i = 1; i < ring.size(); ++i) {
        const Place a = ring[i - 1], b = ring[i];
        if ((a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) in = !in;
    }
    return in;
}

// Somewhere that the lock holds.
Place place_on(Random& random, const Lock& lock, const baker::Dem& dem) {
    if (lock.kind == "Polygon" && pick(random, 0, 2) != 0)
        for (int n = 0; n < 20; ++n)
            if (const Place p{uniform(random, 0, dem.columns - 1), uniform(random, 0, dem.rows - 1)};
                inside(lock.places, p))
                return p;
    const std::size_t i = lock.places.size() == 1
                              ? 0
                              : static_cast<std::size_t>(pick(random, 1, static_cast<int>(lock.places.size()) - 1));
    const Place a = lock.places[i == 0 ? 0 : i - 1], b = lock.places[i];
    const double t = uniform(random, 0, 1), around = uniform(random, 0, 6.3),
                 off_m = uniform(random, 0, lock.width_m / 2);
    return {a[0] + t * (b[0] - a[0]) + std::cos(around) * off_m / dem.spacing_m[0],
            a[1] + t * (b[1] - a[1]) + std::sin(around) * off_m / dem.spacing_m[1]};
}

struct Locked {
    TemporaryFolder folder;
    baker::Dem dem;
    std::vector<Lock> locks;
    baker::BakeOptions options;
};

void make(Random& random, Locked& scene) {
    const int log2 = pick(random, 1, 6);
    scene.dem = random_dem(random, pick(random, 3, 130), pick(random, 3, 130),
                           static_cast<Shape>(pick(random, 0, static_cast<int>(Shape::count) - 1)));
    for (double& spacing : scene.dem.spacing_m) spacing = uniform(random, 0.5, 30);
    if (pick(random, 0, 3) == 0) add_random_holes(random, scene.dem, log2);
    for (int n = pick(random, 1, 4); n > 0; --n) scene.locks.push_back(random_lock(random, scene.dem));
    scene.locks.push_back({"Point", {{1, 1}}, 0, 0.1, no_limit}); // so that some lie on it
    spit(scene.folder / "locks.json", geojson(scene.locks, scene.dem));
    scene.options = small_bake(log2, pick(random, 0, 2) == 0 ? 0.2 : 0.05);
    scene.options.order = static_cast<PageOrder>(pick(random, 0, 2));
    scene.options.region_cells = 1 << pick(random, 1, 6); // several regions, whose borders must agree
    scene.options.locks_path = scene.folder / "locks.json";
}

bool all_void(const baker::Dem& dem) {
    return baker::void_count(dem) == dem.heights_m.size();
}

} // namespace

TEST_CASE("along locks no view draws ground farther off than they allow, and packs with them keep their promises",
          "[locks]") {
    Random random(20261129);
    std::size_t in_metres = 0, in_pixels = 0, needed = 0;
    for (int round = 0; round < rounds(40, 1000); ++round) {
        Locked scene;
        make(random, scene);
        if (all_void(scene.dem)) continue;
        const auto pack = bake_and_load(scene.dem, scene.options);
        const Terrain& terrain = pack.terrain;
        CAPTURE(round, scene.dem.columns, scene.dem.rows, scene.options.tile_log2, terrain.has_voids());
        const baker::VerifyReport report = baker::verify(terrain, nullptr, &pack.pack);
        REQUIRE(report.first == "");
        // Heights that are drawn are floats: a product and a sum are rounded.
        const double float_m = 0x1p-22 * (std::abs(static_cast<double>(terrain.header().max_m)) +
                                          std::abs(static_cast<double>(terrain.header().min_m)));
        const double diagonal_m =
            std::hypot((scene.dem.columns - 1) * scene.dem.spacing_m[0], (scene.dem.rows - 1) * scene.dem.spacing_m[1]);
        Recursive method(terrain, ample_budget(terrain));
        for (int n = 0; n < 4; ++n) {
            const View view = random_view(random, terrain);
            RefineSettings settings;
            settings.max_error_px = std::exp2(uniform(random, -2, 5));
            settings.cull = false;
            (void)method.update(view, settings);
            for (int sample = 0; sample < 60; ++sample) {
                const Lock& lock =
                    scene.locks[static_cast<std::size_t>(pick(random, 0, static_cast<int>(scene.locks.size()) - 1))];
                const Place p = place_on(random, lock, scene.dem);
                if (p[0] < 0 || p[1] < 0 || p[0] > scene.dem.columns - 1 || p[1] > scene.dem.rows - 1) continue;
                const TruePlane ground = true_plane(terrain, p[0], p[1]);
                const double shown_m = drawn_m(method.mesh(), p[0], p[1]);
                if (ground.hole || std::isnan(shown_m)) continue; // beside a hole nothing is drawn
                const double off_m = std::abs(shown_m - at(ground, p[0], p[1])),
                             rounding = 2 * rounding_m(terrain) + float_m;
                const double dx = p[0] * scene.dem.spacing_m[0] - view.eye_m.x, dy = shown_m - view.eye_m.y,
                             dz = p[1] * scene.dem.spacing_m[1] - view.eye_m.z;
                const double px_m = std::sqrt(dx * dx + dy * dy + dz * dz) / focal_length_px(view);
                CAPTURE(lock.kind, lock.width_m, lock.error_m, lock.error_px, settings.max_error_px, p[0], p[1], off_m,
                        px_m);
                const bool tiny = settings.max_error_px * px_m > diagonal_m / 50; // the whole terrain is on the screen
                if (!tiny) REQUIRE(off_m <= lock.error_m + rounding);
                REQUIRE(off_m <= std::min(lock.error_px, 1.0) * settings.max_error_px * px_m * (1 + 1e-6) + rounding);
                in_metres += !tiny && lock.error_m != no_limit;
                in_pixels += lock.error_px != no_limit;
                needed +=
                    !tiny && settings.max_error_px * px_m > 10 * lock.error_m; // which the view alone would not ask for
            }
        }
    }
    CHECK(in_metres > rounds<std::size_t>(1500, 40000));
    CHECK(in_pixels > rounds<std::size_t>(1000, 25000));
    CHECK(needed > rounds<std::size_t>(500, 10000));
}

TEST_CASE("a terrain with locks has the errors of one without where none of its triangles reach them", "[locks]") {
    Random random(20261130);
    std::size_t alike = 0, raised = 0;
    for (int round = 0; round < rounds(20, 300); ++round) {
        Locked scene;
        make(random, scene);
        if (all_void(scene.dem)) continue;
        const auto with = bake_and_load(scene.dem, scene.options);
        scene.options.locks_path.clear();
        const auto without = bake_and_load(scene.dem, scene.options);
        const TerrainData &a = data_of(with.terrain), &b = data_of(without.terrain);
        if (a.header.error_floor_m != b.header.error_floor_m) continue; // locks needed room for their codes
        const baker::Locks locks(scene.folder / "locks.json", {}, baker::DemSource(scene.dem));
        const baker::Window all{0, 0, a.tree.grid_columns(), a.tree.grid_rows()};
        std::vector<baker::LockCodes> codes = locks.over(all, a.errors);
        REQUIRE(codes.size() == all.area());
        const auto near = [&](SampleIndex v) { // what children of children reach
            const std::int32_t s = 5 << Tree::step_log2(v);
            for (std::int32_t y = std::max(v.row - s, 0); y <= std::min(v.row + s, all.rows - 1); ++y)
                for (std::int32_t x = std::max(v.column - s, 0); x <= std::min(v.column + s, all.columns - 1); ++x) {
                    const auto& at = codes[static_cast<std::size_t>(y) * static_cast<std::size_t>(all.columns) +
                                           static_cast<std::size_t>(x)];
                    if (at.allowed != baker::LockCodes::any || at.raise != 0) return true;
                }
            return false;
        };
        for (std::int32_t y = 0; y < all.rows; ++y)
            for (std::int32_t x = 0; x < all.columns; ++x) {
                if (a.tree.is_corner({x, y})) continue;
                const int more = a.vertex({x, y}).error_code - b.vertex({x, y}).error_code;
                CAPTURE(round, x, y);
                REQUIRE(more >= 0);
                raised += more > 0;
                if (near({x, y})) continue;
                REQUIRE(more == 0);
                ++alike;
            }
    }
    CHECK(alike > rounds<std::size_t>(5000, 100000));
    CHECK(raised > rounds<std::size_t>(5000, 100000));
}

TEST_CASE("threads, files, memory and shards make the same pack with locks", "[locks]") {
    Random random(20261131);
    for (int round = 0; round < rounds(1, 6); ++round) {
        const TemporaryFolder folder;
        const baker::Dem dem = random_dem(random, pick(random, 520, 700), pick(random, 300, 600), Shape::fractal);
        std::vector<Lock> locks;
        for (int n = 0; n < 5; ++n) locks.push_back(random_lock(random, dem));
        locks.push_back({"LineString", {{10, 10}, {500, 200}}, 3, 0.01, no_limit});
        spit(folder / "locks.json", geojson(locks, dem));
        baker::BakeOptions options;
        options.tile_log2 = pick(random, 6, 8);
        options.locks_path = folder / "locks.json";
        const Job job(dem, options);
        const baker::ShardPlan plan = job.plan(pick(random, 2, 6), "plan");
        run_all(job, plan, random, true);
        CHECK((job.merged(plan) == job.whole));
        options.threads = 2;
        options.checkpoint_s = 0;
        baker::bake(baker::DemSource(dem), options, folder / "files.fjell");
        CHECK((io::read_file(folder / "files.fjell") == job.whole));
    }
}
