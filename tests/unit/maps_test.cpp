// Maps of tiles: every texel from the whole terrain alone, whatever the tile, and every mip from the one before.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "baker/check/verify_maps.h"
#include "support/map_scene.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

namespace {

double bumps(int x, int y) {
    return (x * 7919 + y * 104729) % 97 + 0.3 * x;
}

Ramp grey_ramp() {
    return {{{0, {0, 0, 0}}, {255, {255, 255, 255}}}, false, {{20, 60, {{0, {250, 20, 0}}}}}};
}

MapPlan plan_of(const Tree& tree, std::uint32_t colour, std::uint32_t normal) {
    MapPlan plan;
    plan.tree = tree;
    plan.spacing_m[0] = 10;
    plan.spacing_m[1] = 20;
    plan.colour_log2 = colour;
    plan.normal_log2 = normal;
    plan.ramp = grey_ramp();
    return plan;
}

std::array<std::uint8_t, 4> speckles(int x, int y) {
    const std::uint32_t v =
        (static_cast<std::uint32_t>(x) * 374761393u + static_cast<std::uint32_t>(y) * 668265263u) * 2654435761u;
    return {static_cast<std::uint8_t>(v >> 8), static_cast<std::uint8_t>(v >> 16), static_cast<std::uint8_t>(v >> 24),
            static_cast<std::uint8_t>(v % 3 ? 255 : 60)};
}

// Texels of the shared column (or row) of neighbours, equal before they are compressed.
void require_equal_borders(const MapPlan& plan, const Maps& maps, MapKind kind) {
    const auto tiles_x = static_cast<std::uint32_t>(plan.tree.tiles_x),
               tiles_y = static_cast<std::uint32_t>(plan.tree.tiles_y);
    const std::size_t n = channels(kind);
    int compared = 0;
    for (std::uint32_t m = 0; m < maps.of(kind).size(); ++m) {
        const auto& tiles = maps.of(kind)[m];
        const auto side = static_cast<std::size_t>(plan.texels(kind, m, 0).columns);
        for (std::uint32_t tile = 0; tile < tiles_x * tiles_y; ++tile) {
            const Texels& here = tiles[tile].texels;
            REQUIRE(tiles[tile].blocks.size() == side * side / (kind == MapKind::colour ? 2 : 1));
            if (here.empty()) continue;
            for (std::size_t i = 0; i < side; ++i)
                for (std::size_t c = 0; c < n; ++c, ++compared) {
                    if (tile % tiles_x + 1 < tiles_x)
                        REQUIRE(here[(i * side + side - 1) * n + c] == tiles[tile + 1].texels[i * side * n + c]);
                    if (tile / tiles_x + 1 < tiles_y)
                        REQUIRE(here[((side - 1) * side + i) * n + c] == tiles[tile + tiles_x].texels[i * n + c]);
                }
        }
    }
    REQUIRE(compared > 0);
}

double light(const MipTexels& mip, std::size_t i) {
    return mip.texels[i] / 65535.0;
}

} // namespace

TEST_CASE("neighbouring tiles compute equal texels on their border, in every mip") {
    // Texels are kept of the last near mip and of the far ones: 2 looks at mip 0, 3 at mip 1, 4 at mip 2, 6 at 2 to 4.
    for (const std::uint32_t log2 : {2u, 3u, 4u, 6u})
        for (const Tree& tree : {Tree{4, 3, 2}, Tree{2, 2, 3}, Tree{6, 2, 2}, Tree::covering(39, 21, 4)}) {
            MapPlan plan = plan_of(tree, log2, log2);
            const Maps maps = all_maps(plan, bumps);
            require_equal_borders(plan, maps, MapKind::colour);
            require_equal_borders(plan, maps, MapKind::normal);
            for (const int width : {7, 49, 211}) {
                const MemoryImage image(width, width * 2 / 3 + 1, tree, speckles);
                plan.image = &image;
                require_equal_borders(plan, all_maps(plan, bumps), MapKind::colour);
                const MemoryImage part({width, width, {-3.3, -2.7}, {1.3, 0.9}}, speckles);
                plan.image = &part;
                require_equal_borders(plan, all_maps(plan, bumps), MapKind::colour);
            }
        }
}

TEST_CASE("flat ground has normals that are straight up, exactly, in every mip") {
    const MapPlan plan = plan_of({5, 2, 2}, 4, 5);
    const Maps maps = all_maps(plan, [](int, int) { return 1234.567; });
    for (std::uint32_t m = 0; m < maps.normal.size(); ++m)
        for (const MipTexels& mip : maps.normal[m])
            for (const std::uint8_t v : decoded(MapKind::normal, mip, 32 >> m)) REQUIRE(v == 128);
}

TEST_CASE("an inclined plane has its own normal everywhere, rim included, to a code") {
    for (const auto& [east, south] : {std::pair{0.5, 0.0}, {0.0, -0.25}, {-2.0, 1.0}, {3.0, 4.0}}) {
        const MapPlan plan = plan_of({4, 2, 2}, 0, 5);
        const Maps maps =
            all_maps(plan, [e = east, s = south](int x, int y) { return 1000 + e * 10 * x + s * 20 * y; });
        const double up = 1 / std::sqrt(1 + east * east + south * south);
        for (std::uint32_t m = 0; m < 4; ++m)
            for (const MipTexels& mip : maps.normal[m]) {
                const auto codes = decoded(MapKind::normal, mip, 32 >> m);
                for (std::size_t i = 0; i < codes.size(); i += 2) {
                    REQUIRE(std::abs(normal_component(codes[i]) + east * up) <= 0.502 / 127);
                    REQUIRE(std::abs(normal_component(codes[i + 1]) + south * up) <= 0.502 / 127);
                }
            }
    }
}

TEST_CASE("every mip of normals is a tent over the one before, the first over the samples' own") {
    const Tree tree{3, 2, 2};
    const MapPlan plan = plan_of(tree, 0, 5);
    const Maps maps = all_maps(plan, bumps);
    // The whole terrain at once, in doubles.
    int width = tree.columns();
    std::vector<double> grid;
    for (int y = 0; y < width; ++y)
        for (int x = 0; x < width; ++x) {
            const int w = std::max(x - 1, 0), e = std::min(x + 1, width - 1), n = std::max(y - 1, 0),
                      s = std::min(y + 1, width - 1);
            const double east = (bumps(e, y) - bumps(w, y)) / (e - w) / 10,
                         south = (bumps(x, s) - bumps(x, n)) / (s - n) / 20;
            grid.push_back(-east / std::sqrt(1 + east * east + south * south));
        }
    for (std::uint32_t m = 0; m < 4; ++m) {
        const int cells = (32 >> m) - 1, next = 2 * cells + 1;
        const double step = (width - 1.0) / (next - 1), radius = std::max(step, 1.0);
        std::vector<double> coarse;
        for (int j = 0; j < next; ++j)
            for (int i = 0; i < next; ++i) {
                double sum = 0, weights = 0;
                for (int y = 0; y < width; ++y)
                    for (int x = 0; x < width; ++x) {
                        const double a = 1 - std::abs(x - i * step) / radius, b = 1 - std::abs(y - j * step) / radius;
                        if (a <= 0 || b <= 0) continue;
                        sum += a * b * grid[static_cast<std::size_t>(y * width + x)];
                        weights += a * b;
                    }
                coarse.push_back(sum / weights);
            }
        for (int tile = 0; tile < 4 && m >= 2; ++tile)
            for (int j = 0; j <= cells; ++j)
                for (int i = 0; i <= cells; ++i) {
                    const auto at = static_cast<std::size_t>(j * (cells + 1) + i);
                    const double v = (maps.normal[m][static_cast<std::size_t>(tile)].texels[2 * at] - 32768) / 32767.0;
                    REQUIRE(
                        v ==
                        Approx(coarse[static_cast<std::size_t>((tile / 2 * cells + j) * next + tile % 2 * cells + i)])
                            .margin(4e-5)); // floats on the way, and 16 bits a mip
                }
        grid = coarse;
        width = next;
    }
}

TEST_CASE("a constant image gives constant mips of the same colour") {
    const Tree tree{4, 2, 1};
    for (int v = 0; v < 256; v += 3) {
        MapPlan plan = plan_of(tree, 5, 0);
        const MemoryImage image(37, 23, tree, [v](int, int) {
            return std::array<std::uint8_t, 4>{static_cast<std::uint8_t>(v), static_cast<std::uint8_t>(255 - v),
                                               static_cast<std::uint8_t>(v / 2), 255};
        });
        plan.image = &image;
        const Maps maps = all_maps(plan, bumps);
        for (std::uint32_t m = 0; m < 4; ++m) {
            const auto rgb = decoded(MapKind::colour, maps.colour[m][1], 32 >> m);
            const int given[3] = {v, 255 - v, v / 2};
            for (std::size_t i = 0; i < rgb.size(); ++i) // two codes: BC1's
                REQUIRE(std::abs(rgb[i] - given[i % 3]) <= 2);
        }
    }
}

TEST_CASE("black and white average in light, not in code values") {
    const Tree tree{6, 1, 1};
    MapPlan plan = plan_of(tree, 4, 0);
    const MemoryImage image(256, 256, tree, [](int x, int y) {
        const auto v = static_cast<std::uint8_t>((x + y) % 2 ? 255 : 0);
        return std::array<std::uint8_t, 4>{v, v, v, 255};
    });
    plan.image = &image;
    const Maps maps = all_maps(plan, bumps);
    for (std::size_t i = 0; i < maps.colour[2][0].texels.size(); ++i)
        CHECK(light(maps.colour[2][0], i) == Approx(0.5).margin(0.04)); // a tent's 17 pixels a side are odd
}

TEST_CASE("an image lies with its outer edge on the outermost samples, and beyond the rim its nearest colour") {
    const Tree tree = Tree::covering(25, 33, 4); // half of the eastern tile lies beyond
    MapPlan plan = plan_of(tree, 4, 0);
    // Linear in light: red rises from west to east, green from north to south.
    const MemoryImage image(240, 320, tree, [](int x, int y) {
        return std::array<std::uint8_t, 4>{srgb_of_light()[x * 65535 / 239], srgb_of_light()[y * 65535 / 319], 0, 255};
    });
    plan.image = &image;
    const Maps maps = all_maps(plan, bumps);
    for (int tile = 0; tile < 4; ++tile)
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i) {
                const auto at = static_cast<std::size_t>(3 * (4 * j + i));
                const auto& mip = maps.colour[2][static_cast<std::size_t>(tile)];
                const double u = std::min((i / 3.0 + tile % 2) * 16 / 24, 1.0), v = (j / 3.0 + tile / 2) / 2;
                // The tents of three mips reach past the rim, and are cut there: at most a third of their widths.
                CHECK(light(mip, at) == Approx(u).margin(0.1));
                CHECK(light(mip, at + 1) == Approx(v).margin(0.1));
                if (i == 3 && tile % 2 == 1) CHECK(light(mip, at) > 0.97);
            }
}

TEST_CASE("where an image has no pixels the ramp shows") {
    const Tree tree{4, 2, 1};
    MapPlan plan = plan_of(tree, 2, 0);
    plan.ramp = Ramp{{{0, {0, 255, 0}}, {1, {0, 255, 0}}}, false, {}};
    // Over the western tile only, and transparent in its northern half.
    const MemoryImage image({160, 160, {0, 0}, {10, 10}}, [](int, int y) {
        return std::array<std::uint8_t, 4>{255, 0, 0, static_cast<std::uint8_t>(y < 80 ? 0 : 255)};
    });
    plan.image = &image;
    const Maps maps = all_maps(plan, bumps);
    const auto& west = maps.colour[0][0];
    CHECK(light(west, 3 * 1) == Approx(0).margin(1e-4)); // row 0
    CHECK(light(west, 3 * 1 + 1) == Approx(1).margin(1e-4));
    CHECK(light(west, 3 * 13) == Approx(1).margin(1e-4)); // row 3
    CHECK(light(west, 3 * 13 + 1) == Approx(0).margin(1e-4));
    CHECK(light(maps.colour[0][1], 3 * 14) == Approx(0).margin(1e-4)); // east of it
    CHECK(light(maps.colour[0][1], 3 * 14 + 1) == Approx(1).margin(1e-4));
}

TEST_CASE("a mirrored image gives mirrored mips") {
    const Tree tree{4, 1, 1};
    for (const int width : {7, 16, 90}) {
        MapPlan plan = plan_of(tree, 4, 0);
        const MemoryImage image(width, width, tree, [](int x, int y) { return speckles(x, y); });
        const MemoryImage turned(width, width, tree,
                                 [width](int x, int y) { return speckles(width - 1 - x, width - 1 - y); });
        plan.ramp = Ramp{{{0, {9, 9, 9}}}, false, {}};
        plan.image = &image;
        const Maps a = all_maps(plan, bumps);
        plan.image = &turned;
        const Maps b = all_maps(plan, bumps);
        const Texels &p = a.colour[2][0].texels, &q = b.colour[2][0].texels;
        for (std::size_t i = 0; i < 16; ++i)
            for (std::size_t c = 0; c < 3; ++c) // sums in the other order: a unit at a tie
                CHECK(std::abs(p[3 * i + c] - q[3 * (15 - i) + c]) <= 1);
    }
}

TEST_CASE("the samples that a tile's maps read are few more than its own, and lie within the terrain") {
    const MapPlan plan = plan_of(Tree::covering(3000, 2000, 9), 8, 9);
    for (std::uint32_t tile = 0; tile < 6 * 4; ++tile) {
        const Window w = heights_for_maps(plan, tile);
        REQUIRE(w.x >= 0);
        REQUIRE(w.y >= 0);
        REQUIRE(w.x + w.columns <= 3000);
        REQUIRE(w.y + w.rows <= 2000);
        // Tents of 2, 4 and 8 samples, one for the difference, on both sides.
        REQUIRE(w.columns <= 513 + 2 * 17);
    }
}

TEST_CASE("a pack's maps are verified, and a spoilt one is noticed") {
    Dem dem; // smooth: in a rough block compression may explain anything
    dem.columns = 193;
    dem.rows = 129;
    dem.spacing_m[0] = dem.spacing_m[1] = 30;
    for (int y = 0; y < dem.rows; ++y)
        for (int x = 0; x < dem.columns; ++x)
            dem.heights_m.push_back(static_cast<float>(600 + 300 * std::sin(x * 0.03) + 280 * std::cos(y * 0.021)));
    BakeOptions options = small_bake(6);
    options.max_texture_log2 = 6;
    const auto pack = bake_and_load(dem, options);
    const MapsReport report = check_maps(pack.pack);
    INFO(report.first);
    CHECK(report.ok());
    CHECK(report.border_texels > 0);
    CHECK(report.texels > 6 * (32 * 32 + 16 * 16));
    // Take another tile's maps for tile 1.
    for (const ChunkKind kind : {ChunkKind::colour, ChunkKind::normal}) {
        auto directory = std::vector<std::byte>(
            pack.pack.directory, pack.pack.directory + pack.pack.header.directory_count * sizeof(ChunkEntry));
        const auto swap = [&](ChunkId a, ChunkId b) {
            const auto at = [&](ChunkId id) {
                return directory.data() + chunk_index(pack.pack.header, id) * sizeof(ChunkEntry);
            };
            std::swap_ranges(at(a), at(a) + sizeof(ChunkEntry), at(b));
        };
        Pack spoilt = pack.pack;
        swap({kind, 1, 0}, {kind, 4, 0});
        spoilt.directory = directory.data();
        const MapsReport noticed = check_maps(spoilt);
        INFO(noticed.first);
        CHECK(noticed.border_violations > 0);
        CHECK(noticed.mip_violations > 0);
        CHECK(noticed.first.find("of tile 1, mip 0: texel") != std::string::npos);
    }
}
