// What a pack promises, checked by the verifier, and the verifier checked by planted faults.
#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>

#include "baker/bake/context.h"
#include "baker/check/verify.h"
#include "shared/terrain_data.h"
#include "support/dem.h"
#include "support/rounds.h"
#include "support/splat_rules.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

VertexRecord& record_of(io::LoadedPack& pack, SampleIndex c) {
    const Terrain& t = pack.terrain;
    const std::int32_t side = data_of(t).tree.side(), tx = std::min(c.column / side, data_of(t).tree.tiles_x - 1),
                       ty = std::min(c.row / side, data_of(t).tree.tiles_y - 1);
    const PagePlace at = data_of(t).pages.place(static_cast<std::uint32_t>(c.column - tx * side),
                                                static_cast<std::uint32_t>(c.row - ty * side));
    const PageEntry page =
        data_of(t)
            .page_table[static_cast<std::uint32_t>(ty * data_of(t).tree.tiles_x + tx) * t.pages_per_tile() + at.page];
    return const_cast<VertexRecord&>(data_of(t).records[page.slot * data_of(t).page_capacity + at.index]);
}

PageBound bound_of(const io::LoadedPack& pack, std::uint32_t tile, std::uint32_t page) {
    return pack.pack.entry(chunk_index(pack.pack.header, {ChunkKind::geometry, tile, page})).bound;
}

// A page's bound in the directory, changed in place.
template <typename Change>
void change_bound(io::LoadedPack& pack, std::uint32_t tile, std::uint32_t page, const Change& change) {
    const std::uint64_t chunk = chunk_index(pack.pack.header, {ChunkKind::geometry, tile, page});
    ChunkEntry entry = pack.pack.entry(chunk);
    change(entry.bound);
    std::memcpy(const_cast<std::byte*>(pack.pack.directory) + chunk * sizeof entry, &entry, sizeof entry);
}

} // namespace

TEST_CASE(
    "errors and spheres nest and bound the original heights, and bounds hold pages, whatever the terrain and tiling") {
    Random random(11);
    int coarse_heights = 0, holed = 0, cut_off = 0;
    for (int round = 0; round < rounds(75, 300); ++round) {
        const int log2 = pick(random, 1, 7);
        const std::int32_t columns = pick(random, 2, 150), rows = pick(random, 2, 150);
        const auto shape = static_cast<Shape>(round % static_cast<int>(Shape::count));
        baker::Dem dem = random_dem(random, columns, rows, shape);
        if (pick(random, 0, 2) == 0) add_random_holes(random, dem, log2);
        baker::BakeOptions options = small_bake(log2, std::pow(10.0, uniform(random, -3, 0)));
        options.order = static_cast<PageOrder>(pick(random, 0, 2));
        options.estimate = pick(random, 0, 3) ? ErrorEstimate::max : ErrorEstimate::midpoint;
        const auto pack = bake_and_load(dem, options);
        const baker::VerifyReport report = baker::verify(pack.terrain, &dem, &pack.pack);
        CAPTURE(round, log2, columns, rows, static_cast<int>(shape), report.first);
        REQUIRE(report.ok());
        coarse_heights += bound_shift(pack.pack.header) > 0;
        holed += pack.terrain.has_voids();
        cut_off += data_of(pack.terrain).tree.cut_x > 0 || data_of(pack.terrain).tree.cut_y > 0;
        REQUIRE(report.true_error_checked == (options.estimate == ErrorEstimate::max));
        REQUIRE(report.vertices >= dem.heights_m.size());
    }
    CHECK(coarse_heights > rounds(4, 20)); // bounds of heights that count on more than one height scale step
    CHECK(holed > rounds(12, 50));
    CHECK(cut_off > rounds(45, 200));
}

TEST_CASE("a pack does not depend on threads, memory or how the work is cut") {
    Random random(12);
    for (int round = 0; round < rounds(10, 40); ++round) {
        const int log2 = pick(random, 1, 7);
        baker::Dem dem = random_dem(random, pick(random, 2, 300), pick(random, 2, 300),
                                    static_cast<Shape>(round % static_cast<int>(Shape::count)));
        if (round % 2) add_random_holes(random, dem, log2);
        baker::BakeOptions options = small_bake(log2);
        if (log2 >= 5) options.horizon_spacing = 4; // small tiles look far around themselves
        const RulesFile rules;
        if (round % 3 != 0) options.layers_path = rules.path();
        if (round % 3 == 1) options.max_texture_log2 = 6;
        options.order = static_cast<PageOrder>(pick(random, 0, 2));
        options.estimate = pick(random, 0, 3) ? ErrorEstimate::max : ErrorEstimate::midpoint;
        options.region_cells = 512; // all at once
        const auto whole = bake_and_load(dem, options);
        options.region_cells = 1 << pick(random, 1, 8);
        options.threads = pick(random, 2, 7);
        if (pick(random, 0, 1)) options.checkpoint_s = 1; // in files
        const auto pieces = bake_and_load(dem, options);
        CAPTURE(round, log2, dem.columns, dem.rows, options.region_cells);
        REQUIRE(whole.file == pieces.file);
        const baker::VerifyReport report = baker::verify(pieces.terrain, &dem);
        CAPTURE(report.first);
        REQUIRE(report.ok());
    }
}

TEST_CASE("a bake has at most as much on the disk as work_bytes says, and its documented bytes a sample") {
    Random random(19);
    for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear})
        for (const bool holes : {false, true}) {
            const bool horizons = holes && order == PageOrder::planar;
            baker::Dem dem = random_dem(random, 513, 385, Shape::noise); // hardly to be compressed
            if (holes) add_random_holes(random, dem, 7);
            const TemporaryFolder folder;
            baker::BakeOptions options;
            options.tile_log2 = 7;
            options.order = order;
            options.horizon_spacing = horizons ? 2 : 0;
            const RulesFile rules;
            if (horizons) options.layers_path = rules.path();
            options.checkpoint_s = 0; // in files
            std::uint64_t most = 0;
            options.progress = [&](const char* stage, std::uint64_t, std::uint64_t) {
                if (stage == std::string("write")) return; // the pack takes the other stores' room
                std::uint64_t now = 0;
                for (const auto& file : std::filesystem::directory_iterator(folder / "pack.fjell.work"))
                    now += file.file_size();
                most = std::max(most, now);
            };
            const baker::BakeSummary summary = baker::bake(dem, options, folder / "pack.fjell");
            // Colours have half the samples' density, normals all of it.
            const std::uint64_t bytes =
                baker::work_bytes(summary.tree, order, {6, 7, horizons ? 6u : 0u, horizons ? 6u : 0u});
            CAPTURE(static_cast<int>(order), holes, most, bytes);
            CHECK(most <= bytes);
            CHECK(most > bytes * 7 / 10);
        }
    // What docs/notes/baking.md says, of tiles of 512 cells.
    const Tree tree = Tree::covering(4097, 4097, 9);
    const auto a_sample = [&](PageOrder order) {
        return static_cast<double>(baker::work_bytes(tree, order, {8, 9, 0})) / (4097.0 * 4097.0);
    };
    CHECK(a_sample(PageOrder::planar) == Approx(13.6).margin(0.1));
    CHECK(a_sample(PageOrder::linear) == Approx(20.6).margin(0.1));
}

TEST_CASE("a pack verified tile by tile from its file is found to be what it is when it is loaded whole") {
    Random random(17);
    for (int round = 0; round < rounds(10, 40); ++round) {
        const int log2 = pick(random, 1, 6);
        baker::Dem dem = random_dem(random, pick(random, 2, 150), pick(random, 2, 150),
                                    static_cast<Shape>(round % static_cast<int>(Shape::count)));
        if (round % 2) add_random_holes(random, dem, log2);
        baker::BakeOptions options = small_bake(log2);
        options.order = static_cast<PageOrder>(round % 3);
        options.estimate = round % 4 ? ErrorEstimate::max : ErrorEstimate::midpoint;
        const TemporaryFolder folder;
        (void)baker::bake(dem, options, folder / "pack.fjell");
        const io::PackFile file(folder / "pack.fjell");
        const auto loaded = io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes);
        baker::Dem other = dem; // a fault that only the original heights tell
        const auto at = static_cast<std::size_t>(pick(random, 0, dem.columns * dem.rows - 1));
        const bool told = dem.voids.empty() || !dem.voids[at];
        other.heights_m[at] += 1e5f;
        for (const baker::Dem* against : {&dem, &other}) {
            const baker::VerifyReport whole = baker::verify(loaded.terrain, against);
            for (const std::size_t row_bytes : {std::size_t{0}, std::size_t{1} << 30}) {
                const baker::DemSource source(*against);
                const baker::VerifyReport tiles = baker::verify(file, &source, row_bytes);
                CAPTURE(round, log2, dem.columns, dem.rows, row_bytes, tiles.first);
                REQUIRE(tiles.ok() == (against == &dem || !told));
                REQUIRE(tiles.first == whole.first);
                REQUIRE(tiles.vertices == whole.vertices);
                REQUIRE(tiles.samples_compared == whole.samples_compared);
                REQUIRE(tiles.height_mismatches == whole.height_mismatches);
                REQUIRE(tiles.true_error_violations == whole.true_error_violations);
                REQUIRE(tiles.worst_excess_m == whole.worst_excess_m);
                REQUIRE(tiles.rim_violations == 0);
            }
        }
        REQUIRE(baker::verify(file, nullptr).ok());
    }
}

TEST_CASE("integer heights are stored without loss") {
    Random random(13);
    baker::Dem dem = random_dem(random, 65, 65, Shape::noise);
    for (float& h : dem.heights_m) h = static_cast<float>(pick(random, -400, 8848));
    dem.native_quantum_m = 1;
    const auto pack = bake_and_load(dem, small_bake(4));
    for (std::int32_t y = 0; y < 65; ++y)
        for (std::int32_t x = 0; x < 65; ++x) REQUIRE(data_of(pack.terrain).height_m({x, y}) == dem.at(x, y));
}

TEST_CASE("heights that no height scale can hold exactly are off by at most half a quantum") {
    Random random(14);
    const baker::Dem dem = random_dem(random, 65, 65, Shape::noise);
    const auto pack = bake_and_load(dem, small_bake(4));
    const double half = data_of(pack.terrain).height_scale.quantum_m * 0.5;
    const auto [least, most] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    // Half a quantum, and the rounding of a float of this size.
    const double ulp = std::max(std::abs(*least), std::abs(*most)) * 0x1p-23;
    for (std::int32_t y = 0; y < 65; ++y)
        for (std::int32_t x = 0; x < 65; ++x)
            REQUIRE(std::abs(static_cast<double>(data_of(pack.terrain).height_m({x, y})) - dem.at(x, y)) <= half + ulp);
}

TEST_CASE("the mid-point estimate is never above the true one, and breaks the true bound somewhere") {
    Random random(15);
    const baker::Dem dem = random_dem(random, 129, 129, Shape::fractal);
    baker::BakeOptions options = small_bake(6);
    const auto full = bake_and_load(dem, options);
    options.estimate = ErrorEstimate::midpoint;
    auto middle = bake_and_load(dem, options);
    for (std::int32_t y = 0; y < 129; ++y)
        for (std::int32_t x = 0; x < 129; ++x)
            REQUIRE(data_of(middle.terrain).vertex({x, y}).error_m <= data_of(full.terrain).vertex({x, y}).error_m);
    data_of(middle.terrain).header.estimate = ErrorEstimate::max; // claim what does not hold
    REQUIRE(baker::verify(middle.terrain, nullptr).true_error_violations > 0);
}

TEST_CASE("the verifier notices every kind of fault") {
    Random random(16);
    const baker::Dem dem = random_dem(random, 65, 65, Shape::fractal);
    const auto fresh = [&] { return bake_and_load(dem, small_bake(4)); };
    {
        auto pack = fresh();
        record_of(pack, {8, 8}).error = 0; // a root
        const auto report = baker::verify(pack.terrain, nullptr);
        CHECK(report.nesting_violations > 0);
        CHECK(report.true_error_violations > 0);
        CHECK(report.first.find("(8, 8)") != std::string::npos);
    }
    {
        auto pack = fresh();
        VertexRecord& r = record_of(pack, {20, 20});
        r.radius = static_cast<std::uint8_t>(r.radius / 2);
        CHECK(baker::verify(pack.terrain, nullptr).sphere_violations > 0);
    }
    {
        auto pack = fresh();
        VertexRecord& r = record_of(pack, {7, 7});
        r.height = static_cast<std::uint16_t>(r.height ^ 0x4000);
        CHECK(baker::verify(pack.terrain, &dem).height_mismatches == 1);
    }
    {
        auto pack = fresh();
        VertexRecord& r = record_of(pack, {7, 7}); // ground that becomes a hole
        r.radius = static_cast<std::uint8_t>(r.radius | void_bit);
        data_of(pack.terrain).header.voids = 1;
        const auto report = baker::verify(pack.terrain, &dem);
        CHECK(report.height_mismatches == 1);
        CHECK(report.rim_violations > 0);
    }
    {
        auto pack = fresh();
        const_cast<std::uint32_t&>(data_of(pack.terrain).corners[6]) += 1;
        CHECK(baker::verify(pack.terrain, nullptr).border_mismatches == 4); // as each of its tiles has it
    }
    {
        auto pack = fresh();
        VertexRecord& r = record_of(pack, {16, 5}); // on a border: found in the western tile only
        r.error = static_cast<std::uint8_t>(r.error + 1);
        CHECK(baker::verify(pack.terrain, nullptr).border_mismatches > 0);
    }
    CHECK(baker::verify(fresh().terrain, &dem).ok());
}

namespace {

// How far ground is from any triangle over it that could be drawn, by bisection.
double worst_on_ground_m(const Terrain& terrain, SampleIndex apex, SampleIndex left, SampleIndex right) {
    if (((left.column + right.column) | (left.row + right.row)) & 1) return 0;
    const TerrainData& t = data_of(terrain);
    const SampleIndex a = t.tree.sample(apex), b = t.tree.sample(left), c = t.tree.sample(right);
    double worst = 0;
    const double bx = b.column - a.column, by = b.row - a.row, cx = c.column - a.column, cy = c.row - a.row,
                 area = bx * cy - by * cx;
    const auto hole = [&](SampleIndex s) { return t.vertex(s).hole; };
    const auto height = [&](SampleIndex s) { return static_cast<double>(t.height_m(s)); };
    const auto [x0, x1] = std::minmax({a.column, b.column, c.column});
    const auto [y0, y1] = std::minmax({a.row, b.row, c.row});
    for (std::int32_t y = y0; area != 0 && y <= y1; ++y)
        for (std::int32_t x = x0; x <= x1; ++x) {
            const double v = ((x - a.column) * cy - (y - a.row) * cx) / area,
                         w = ((y - a.row) * bx - (x - a.column) * by) / area;
            if (v < 0 || w < 0 || v + w > 1 || hole({x, y}) || hole(a) || hole(b) || hole(c)) continue;
            const double plane = height(a) + v * (height(b) - height(a)) + w * (height(c) - height(a));
            worst = std::max(worst, std::abs(height({x, y}) - plane));
        }
    const SampleIndex middle{(left.column + right.column) / 2, (left.row + right.row) / 2};
    return std::max(
        {worst, worst_on_ground_m(terrain, middle, apex, left), worst_on_ground_m(terrain, middle, right, apex)});
}

} // namespace

TEST_CASE("the largest error that a bake tells of is one of ground, holes or not, and no vertex' own is larger") {
    Random random(19);
    int holed = 0;
    for (int round = 0; round < rounds(25, 200); ++round) {
        const int log2 = pick(random, 1, 5);
        baker::Dem dem = random_dem(random, pick(random, 2, 70), pick(random, 2, 70), Shape::fractal);
        if (pick(random, 0, 3)) add_random_holes(random, dem, log2);
        const TemporaryFolder folder;
        const baker::BakeSummary told = baker::bake(dem, small_bake(log2), folder / "p.fjell");
        const io::LoadedPack pack = io::load_pack(folder / "p.fjell", io::LoadTerrain::yes);
        const Tree& tree = data_of(pack.terrain).tree;
        double worst = 0;
        for (std::int32_t y = 0; y < tree.grid_rows() - 1; y += tree.side())
            for (std::int32_t x = 0; x < tree.grid_columns() - 1; x += tree.side()) {
                const SampleIndex nw{x, y}, ne{x + tree.side(), y}, sw{x, y + tree.side()},
                    se{x + tree.side(), y + tree.side()};
                worst = std::max(
                    {worst, worst_on_ground_m(pack.terrain, ne, nw, se), worst_on_ground_m(pack.terrain, sw, se, nw)});
            }
        CAPTURE(round, log2, dem.columns, dem.rows, told.voids, told.max_error_m);
        holed += told.voids > 0;
        CHECK(told.ground_error_m >= worst * (1 - 1e-6));
        CHECK(told.ground_error_m <= told.max_error_m);
        // Rounded up to a code, and the finest centres a code above their sides: two steps of 5%; or the least code.
        const double least = pack.pack.header.error_floor_m;
        if (told.voids > 0) CHECK(told.ground_error_m <= std::max(worst * 1.1026, 1.06 * least));
    }
    CHECK(holed > 5);
}

TEST_CASE("the verifier notices a bound that does not hold, and one that is wider than its page") {
    Random random(18);
    int at_end = 0;
    baker::BakeOptions options = small_bake(7);
    for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear}) {
        options.order = order;
        auto pack = bake_and_load(random_dem(random, 200, 150, Shape::fractal), options);
        REQUIRE(baker::verify(pack.terrain, nullptr, &pack.pack).ok());
        const std::uint32_t pages = pack.terrain.pages_per_tile();
        REQUIRE(pages > 4);
        for (const std::uint32_t page : {0u, 1u, pages - 1}) {
            const auto violations = [&](std::int32_t low, std::int32_t high, std::int32_t error, std::int32_t radius) {
                const PageBound before = bound_of(pack, 1, page);
                change_bound(pack, 1, page, [&](PageBound& b) {
                    b.low = static_cast<std::uint16_t>(b.low + low);
                    b.high = static_cast<std::uint16_t>(b.high + high);
                    b.error = static_cast<std::uint8_t>(b.error + error);
                    b.radius = static_cast<std::uint8_t>(b.radius + radius);
                });
                const baker::VerifyReport report = baker::verify(pack.terrain, nullptr, &pack.pack);
                change_bound(pack, 1, page, [&](PageBound& b) { b = before; });
                const std::string place = "page " + std::to_string(page) + " of tile 1";
                CHECK((report.ok() || report.first.find(place) != std::string::npos));
                return report.bound_violations;
            };
            CAPTURE(static_cast<int>(order), page);
            for (const std::int32_t by : {-1, 1}) {
                CHECK(violations(by, 0, 0, 0) == 1);
                CHECK(violations(0, by, 0, 0) == 1);
                CHECK(violations(0, 0, by, 0) == 1);
                // Of linear order's pages some have no radius as large as the root's unit: code 0.
                const std::int32_t radius = bound_of(pack, 1, page).radius + by;
                if (radius >= 0 && radius < static_cast<std::int32_t>(radius_codes))
                    CHECK(violations(0, 0, 0, by) == 1);
                else
                    ++at_end;
            }
            CHECK(violations(0, 0, 0, 0) == 0);
        }
        CHECK(baker::verify(pack.terrain, nullptr, &pack.pack).ok());
    }
    CHECK(at_end < 4);
}
