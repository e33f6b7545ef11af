// Pages that come and go, and the three orders: the same mesh whatever the order, the target of invariant 7 whatever is
// missing.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fjell/measure.h"
#include "shared/terrain_data.h"
#include "support/cut_scene.h"
#include "support/mesh_check.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"
#include "view/wanted.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Loads a random subset, from coarse to fine as pages ask for, then takes some away again, coarse ones too.
void load_some(Random& random, const Pack& pack, Terrain& terrain) {
    const double share = uniform(random, 0, 1.1), keep = uniform(random, 0.3, 1.1);
    for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile)
        for (std::uint32_t page = 0; page < terrain.pages_per_tile(); ++page) {
            if (uniform(random, 0, 1) > share) continue;
            const Status s = load_page(pack, terrain, tile, page);
            if (s.code == StatusCode::out_of_slots) return;
            REQUIRE((s.ok() || s.code == StatusCode::coarser_page_first));
        }
    for (std::uint32_t tile = 0; tile < terrain.tile_count(); ++tile)
        for (std::uint32_t page = 0; page < terrain.pages_per_tile(); ++page)
            if (uniform(random, 0, 1) > keep) (void)unload_page(terrain, tile, page);
}

// The target, level by level, straight from its definition: wanted, all pages that hold it loaded, parents in it.
class Target {
public:
    Target(const Terrain& full, const Terrain& paged, const View& view, double error_px)
        : full_(full), columns_(data_of(full).tree.grid_columns()),
          in_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(data_of(full).tree.grid_rows()), true) {
        for (std::uint32_t tile = 0; tile < paged.tile_count(); ++tile)
            for (std::uint32_t page = 0; page < paged.pages_per_tile(); ++page)
                if (data_of(paged).page_table[tile * paged.pages_per_tile() + page].slot == no_index)
                    absent(tile, page);
        const Reach reach = make_reach(view, error_px);
        for (int level = 0; level < 2 * data_of(full).tree.tile_log2; ++level) {
            const std::int32_t step = 1 << (data_of(full).tree.tile_log2 - 1 - level / 2);
            for (std::int32_t y = 0; y < data_of(full).tree.grid_rows(); y += step)
                for (std::int32_t x = 0; x < columns_; x += step) decide({x, y}, level, reach);
        }
    }
    [[nodiscard]] bool in(SampleIndex c) const { return in_[at(c)]; }

private:
    void absent(std::uint32_t tile, std::uint32_t page) {
        const SampleIndex corner{static_cast<std::int32_t>(tile % full_.header().tiles_x) * data_of(full_).tree.side(),
                                 static_cast<std::int32_t>(tile / full_.header().tiles_x) * data_of(full_).tree.side()};
        for (std::uint32_t i = 0; i < data_of(full_).pages.page_vertices(page); ++i) {
            const SampleIndex c = corner + data_of(full_).pages.coord({page, i});
            if (!data_of(full_).tree.is_corner(c)) in_[at(c)] = false;
        }
    }
    void decide(SampleIndex c, int level, const Reach& reach) {
        if (data_of(full_).tree.is_corner(c) || data_of(full_).tree.level(c) != level || !in_[at(c)]) return;
        const TerrainData::Vertex v = data_of(full_).vertex(c);
        const SampleIndex s = data_of(full_).tree.sample(c);
        bool in = wanted(reach, full_.x_m(s.column), v.height_m, full_.z_m(s.row), v.error_m, v.radius_m);
        for (const SampleIndex parent : diamond(data_of(full_).tree, c).apexes)
            in = in && (!data_of(full_).tree.contains(parent) || in_[at(parent)]);
        in_[at(c)] = in;
    }
    [[nodiscard]] std::size_t at(SampleIndex c) const {
        return static_cast<std::size_t>(c.row) * static_cast<std::size_t>(columns_) +
               static_cast<std::size_t>(c.column);
    }
    const Terrain& full_;
    std::int32_t columns_;
    std::vector<bool> in_;
};

} // namespace

TEST_CASE("the same height field gives the same mesh in every order") {
    Random random(51);
    for (int round = 0; round < rounds(10, 40); ++round) {
        const int log2 = pick(random, 1, 8);
        baker::Dem dem = random_dem(random, pick(random, 2, 300), pick(random, 2, 200), Shape::fractal);
        if (pick(random, 0, 2) == 0) add_random_holes(random, dem, log2);
        std::vector<io::LoadedPack> packs;
        for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear}) {
            baker::BakeOptions options = small_bake(log2);
            options.order = order;
            packs.push_back(bake_and_load(dem, options));
        }
        for (int frame = 0; frame < 3; ++frame) {
            const View view = random_view(random, packs[0].terrain);
            RefineSettings settings;
            settings.max_error_px = random_threshold(random);
            settings.cull = pick(random, 0, 1) == 1;
            settings.topology = pick(random, 0, 1) ? Topology::strip : Topology::triangles;
            std::vector<std::vector<Triangle>> meshes;
            for (const io::LoadedPack& pack : packs) {
                Recursive method(pack.terrain, ample_budget(pack.terrain));
                (void)method.update(view, settings);
                meshes.push_back(triangles_of(method.mesh()));
            }
            REQUIRE(meshes[0] == meshes[1]);
            REQUIRE(meshes[0] == meshes[2]);
        }
        std::size_t wrong = 0;
        for (std::int32_t y = 0; y < dem.rows; y += 3)
            for (std::int32_t x = 0; x < dem.columns; ++x) {
                const auto a = data_of(packs[0].terrain).vertex({x, y});
                for (const auto& other :
                     {data_of(packs[1].terrain).vertex({x, y}), data_of(packs[2].terrain).vertex({x, y})})
                    wrong += a.steps != other.steps || a.error_m != other.error_m || a.radius_m != other.radius_m ||
                             a.hole != other.hole;
            }
        REQUIRE(wrong == 0);
    }
}

TEST_CASE("missing pages make coarser terrain, exactly the target, and never a crack") {
    Random random(52);
    std::size_t incomplete = 0, refined = 0;
    for (int round = 0; round < rounds(30, 120); ++round) {
        const bool large = round % 30 >= 27; // one in each order
        const int log2 = large ? pick(random, 6, 9) : pick(random, 1, 8);
        baker::Dem dem = random_dem(random, pick(random, 2, large ? 1000 : 300), pick(random, 2, large ? 700 : 150),
                                    pick(random, 0, 1) ? Shape::fractal : Shape::noise);
        if (pick(random, 0, 3) == 0) add_random_holes(random, dem, log2);
        baker::BakeOptions options = small_bake(log2);
        options.order = static_cast<PageOrder>(round % 3);
        const auto pack = bake_and_load(std::move(dem), options);
        TerrainBudget slots;
        if (pick(random, 0, 2) == 0)
            slots.page_slots = static_cast<std::uint32_t>(pick(random, 1, static_cast<int>(pack.terrain.page_count())));
        PagedTerrain paged(pack.pack, slots);
        Recursive method(paged.terrain, ample_budget(pack.terrain));
        for (int frame = 0; frame < 5; ++frame) {
            load_some(random, pack.pack, paged.terrain);
            incomplete += paged.terrain.pages_missing() != 0;
            const View view = random_view(random, pack.terrain);
            RefineSettings settings;
            settings.max_error_px = random_threshold(random);
            settings.cull = false;
            settings.topology = pick(random, 0, 1) ? Topology::strip : Topology::triangles;
            CAPTURE(round, frame, log2, settings.max_error_px, paged.terrain.pages_missing(),
                    pack.terrain.page_count());
            (void)method.update(view, settings);
            const std::vector<Triangle> triangles = triangles_of(method.mesh());
            if (!pack.terrain.has_voids()) REQUIRE(check_mesh(pack.terrain, method.mesh()) == "");
            std::vector<bool> used(data_of(pack.terrain).tree.columns() *
                                   static_cast<std::size_t>(data_of(pack.terrain).tree.rows()));
            const auto at = [&](SampleIndex c) {
                return static_cast<std::size_t>(c.row) *
                           static_cast<std::size_t>(data_of(pack.terrain).tree.columns()) +
                       static_cast<std::size_t>(c.column);
            };
            for (const Triangle& t : triangles)
                for (const SampleIndex c : t) used[at(c)] = true;
            if (pack.terrain.has_voids()) continue; // what is left out of a mesh is not looked for in it
            std::size_t wrong = 0;
            const Target target(pack.terrain, paged.terrain, view, settings.max_error_px);
            for (std::int32_t y = 0; y < data_of(pack.terrain).tree.rows() - 1; ++y)
                for (std::int32_t x = 0; x < data_of(pack.terrain).tree.columns() - 1; ++x) {
                    wrong += used[at({x, y})] != target.in({x, y});
                    refined += used[at({x, y})];
                }
            REQUIRE(wrong == 0);
            // With culling it is the same, less what cannot be seen.
            settings.cull = true;
            (void)method.update(view, settings);
            REQUIRE(check_mesh(pack.terrain, method.mesh()) == "");
        }
    }
    REQUIRE(incomplete > rounds<std::size_t>(25, 100));
    REQUIRE(refined > rounds<std::size_t>(2'500, 10'000));
}

TEST_CASE("whichever single page is missing, and whatever the order, there is no crack") {
    Random random(55);
    for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear}) {
        baker::BakeOptions options = small_bake(7);
        options.order = order;
        const auto pack = bake_and_load(random_dem(random, 257, 257, Shape::noise), options);
        PagedTerrain paged(pack.pack, {});
        const auto load_all = [&] {
            for (std::uint32_t tile = 0; tile < pack.terrain.tile_count(); ++tile)
                for (std::uint32_t page = 0; page < pack.terrain.pages_per_tile(); ++page)
                    REQUIRE(load_page(pack.pack, paged.terrain, tile, page).ok());
        };
        Recursive method(paged.terrain, ample_budget(pack.terrain));
        for (std::uint32_t tile = 0; tile < pack.terrain.tile_count(); ++tile)
            for (std::uint32_t page = 0; page < pack.terrain.pages_per_tile(); ++page) {
                load_all();
                (void)unload_page(paged.terrain, tile, page);
                const View view = random_view(random, pack.terrain);
                RefineSettings settings;
                settings.max_error_px = std::pow(10.0, uniform(random, -2.5, -0.5)); // all of it, nearly
                settings.cull = pick(random, 0, 1) == 1;
                (void)method.update(view, settings);
                CAPTURE(static_cast<int>(order), tile, page, settings.max_error_px);
                REQUIRE(check_mesh(pack.terrain, method.mesh()) == "");
            }
    }
}

TEST_CASE("a page asks for the coarser pages over it, and slots run out by name") {
    Random random(53);
    baker::Dem dem = random_dem(random, 257, 257, Shape::fractal);
    const auto pack = bake_and_load(std::move(dem), small_bake(8));
    const std::uint32_t last = pack.terrain.pages_per_tile() - 1;
    REQUIRE(pack.terrain.pages_per_tile() == 1 + 1 + 4 + 16);
    PagedTerrain paged(pack.pack, {3});
    CHECK(load_page(pack.pack, paged.terrain, 0, last).code == StatusCode::coarser_page_first);
    CHECK(load_page(pack.pack, paged.terrain, 0, 0).ok());
    CHECK(load_page(pack.pack, paged.terrain, 0, 0).ok());
    CHECK(load_page(pack.pack, paged.terrain, 0, 1).ok());
    CHECK(load_page(pack.pack, paged.terrain, 0, last).code == StatusCode::coarser_page_first);
    CHECK(load_page(pack.pack, paged.terrain, 0, 5).ok());
    const Status full = load_page(pack.pack, paged.terrain, 0, last);
    CHECK(full.code == StatusCode::out_of_slots);
    CHECK(std::string(full.field) == "TerrainBudget::page_slots");
    CHECK(load_page(pack.pack, paged.terrain, 0, last + 1).code == StatusCode::out_of_range);
    CHECK(load_page(pack.pack, paged.terrain, 1, 0).code == StatusCode::out_of_range);
    CHECK(paged.terrain.pages_missing() == pack.terrain.page_count() - 3);
    (void)unload_page(paged.terrain, 0, 0);
    (void)unload_page(paged.terrain, 0, 0);
    CHECK(paged.terrain.pages_missing() == pack.terrain.page_count() - 2);
}

TEST_CASE("pages that went and came back hold the same records") {
    Random random(54);
    for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear}) {
        baker::BakeOptions options = small_bake(7);
        options.order = order;
        const auto pack = bake_and_load(random_dem(random, 200, 150, Shape::noise), options);
        PagedTerrain paged(pack.pack, {});
        for (int round = 0; round < 6; ++round) load_some(random, pack.pack, paged.terrain);
        for (std::uint32_t tile = 0; tile < pack.terrain.tile_count(); ++tile)
            for (std::uint32_t page = 0; page < pack.terrain.pages_per_tile(); ++page)
                REQUIRE(load_page(pack.pack, paged.terrain, tile, page).ok());
        REQUIRE(paged.terrain.pages_missing() == 0);
        for (std::int32_t y = 0; y < 150; ++y)
            for (std::int32_t x = 0; x < 200; ++x) {
                const auto a = data_of(pack.terrain).vertex({x, y}), b = data_of(paged.terrain).vertex({x, y});
                REQUIRE((a.steps == b.steps && a.error_m == b.error_m && a.radius_m == b.radius_m));
            }
    }
}
