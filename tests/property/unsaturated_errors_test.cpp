// The error stage's fast loops against the slow ways to say the same.
#include <catch2/catch.hpp>

#include "baker/errors/triangle_scan.h"
#include "baker/errors/unsaturated.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::test;

namespace {

// Noise of any range that one tile may have, with flat stretches in it.
baker::QuantisedHeights random_ground(Random& random, const Tree& tree) {
    const std::int32_t columns = tree.grid_columns(), rows = tree.grid_rows();
    baker::QuantisedHeights ground{tree, {-2, -2, columns + 8, rows + 8}, {}};
    const int most = 1 << pick(random, 0, 16), base = pick(random, 0, max_height_steps - 65536);
    for (std::int32_t& h : ground.steps.values) h = base + (pick(random, 0, 3) ? pick(random, 0, most - 1) : most / 2);
    return ground;
}

} // namespace

TEST_CASE("errors by themselves are what every sample under every triangle says") {
    Random random(61);
    for (int round = 0; round < 120; ++round) {
        const int log2 = pick(random, 1, 7);
        const std::int32_t side = 1 << log2;
        // Cut off anywhere: squeezed triangles at the rim.
        const Tree tree = Tree::covering(pick(random, 2, 3 * side), pick(random, 2, 3 * side), log2);
        baker::QuantisedHeights ground = random_ground(random, tree);
        baker::HeightStatistics heights;
        heights.least_m = 0, heights.most_m = 1e6f, heights.tile_range_m = 65535;
        heights.step_m[0] = heights.step_m[1] = 65535;
        const baker::Scales scales = baker::choose_scales({tree, {30, 20}, {0, 1}, heights, 0.05});
        const LeafErrors leaf(scales.errors, 1);
        const auto at = [&](std::int32_t tiles) { return pick(random, 0, tiles - 1); };
        const SampleIndex first{at(tree.tiles_x) * side, at(tree.tiles_y) * side};
        const baker::Region region{first,
                                   {first.column + side * pick(random, 1, tree.tiles_x - first.column / side),
                                    first.row + side * pick(random, 1, tree.tiles_y - first.row / side)}};
        for (const ErrorEstimate estimate : {ErrorEstimate::max, ErrorEstimate::midpoint}) {
            const baker::UnsaturatedInput input{ground, region, scales, leaf, estimate, {30, 20}};
            baker::Patch<std::uint8_t> codes;
            baker::unsaturated_errors(input, codes);
            for (std::int32_t y = region.first.row; y <= region.last.row; y += 2)
                for (std::int32_t x = region.first.column; x <= region.last.column; x += 2) {
                    if (tree.is_corner({x, y})) continue;
                    CAPTURE(round, log2, x, y, region.first.column, region.last.column, static_cast<int>(estimate));
                    REQUIRE(*codes.at(x / 2, y / 2) == baker::unsaturated_error(input, {x, y}).code);
                }
        }
    }
}

TEST_CASE("rows of vertices are measured alike with and without vectors") {
    Random random(62);
    std::vector<std::int32_t> heights(300 * 300 + baker::scan_slack);
    for (std::int32_t& h : heights) h = pick(random, 0, 65535);
    for (int round = 0; round < 400; ++round) {
        const int z = pick(random, 1, 6);
        const std::int32_t s = 1 << z, count = pick(random, 1, (290 - 2 * s) / (2 * s));
        baker::VertexRow row{heights.data() + 300 * pick(random, s, 299 - s) + s, 300, s, count,
                             static_cast<VertexKind>(pick(random, 0, 2))};
        row.before = pick(random, 0, 1) != 0;
        row.after = pick(random, 0, 1) != 0;
        row.falling = pick(random, 0, 1) != 0;
        row.alternate = pick(random, 0, 1) != 0;
        std::vector<std::int32_t> fast(static_cast<std::size_t>(count)), slow(fast);
        baker::scan_row(row, fast.data());
        baker::scan_row_scalar(row, slow.data());
        CAPTURE(round, z, static_cast<int>(row.kind));
        REQUIRE(fast == slow);
    }
}
