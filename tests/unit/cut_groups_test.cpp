// The live cut's tables against the tree's own arithmetic (shared/tree.h).
#include <catch2/catch.hpp>

#include <algorithm>
#include <vector>

#include "cut/groups.h"

using namespace fjell;

namespace {

constexpr SampleIndex offset_of(Bearing b) {
    constexpr SampleIndex offsets[] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    return offsets[static_cast<int>(b)];
}

} // namespace

TEST_CASE("sites, parents and children are those of the tree") {
    const Tree tree{5, 3, 2, 0, 0};
    const auto side = tree.side();
    for (std::int32_t y = 0; y < tree.grid_rows(); ++y)
        for (std::int32_t x = 0; x < tree.grid_columns(); ++x) {
            const SampleIndex c{x, y};
            if (tree.is_corner(c)) continue;
            const Site site = site_at(c);
            REQUIRE(site_coord(site) == c);
            const Children expected = children(c);
            for (int d = 0; d < expected.count; ++d) {
                const Site child = child_site(site, d);
                REQUIRE(site_coord(child) == expected.at[d]);
                REQUIRE(child.kind == Tree::kind(expected.at[d]));
                if (tree.contains(expected.at[d])) REQUIRE(site_at(expected.at[d]).i == child.i);
                // The child knows v as that parent, and v it as that child.
                const int n = parent_number(site.kind, d);
                REQUIRE(site_coord(parent_site(child, n)) == c);
                REQUIRE(child_number(parent_bearing(child, n)) == d);
            }
            const Diamond split = diamond(tree, c);
            const bool root = site.kind == VertexKind::centre && 2 << site.z == side;
            for (int n = 0; n < 2; ++n) {
                const SampleIndex apex = root ? split.apexes[n] : site_coord(parent_site(site, n));
                REQUIRE(std::count(std::begin(split.apexes), std::end(split.apexes), apex) == 1);
                if (root) continue;
                const SampleIndex offset = offset_of(parent_bearing(site, n));
                REQUIRE(apex == c + SampleIndex{offset.column << site.z, offset.row << site.z});
            }
        }
}

TEST_CASE("the two halves of a split lie on either side of it, counter-clockwise") {
    for (int b = 0; b < 8; ++b) {
        const auto bearing = static_cast<Bearing>(b);
        const bool of_side = b < 4; // its parents lie along the axes; its own children at quadrants
        const SampleIndex p = offset_of(bearing);
        const auto direction = [&](int d) {
            return of_side ? SampleIndex{d & 1 ? 1 : -1, d & 2 ? 1 : -1}
                           : offset_of(static_cast<Bearing>(d)); // west, east, north, south
        };
        const Halves h = halves(bearing);
        // y points south: counter-clockwise from above is a negative turn.
        const auto turn = [&](SampleIndex d) { return p.column * d.row - p.row * d.column; };
        CHECK(turn(direction(h.first)) < 0);
        CHECK(turn(direction(h.second)) > 0);
        for (const int d : {int{h.first}, int{h.second}})
            CHECK(p.column * direction(d).column + p.row * direction(d).row > 0); // beside the parent, not opposite
    }
}

TEST_CASE("every place of a page belongs to one lane of one group") {
    for (int log2 = 1; log2 <= 9; ++log2) {
        const PageLayout pages{log2, PageOrder::planar};
        for (std::uint32_t shape = 0; shape < (pages.pages_per_tile() > 1 ? 2u : 1u); ++shape) {
            const PageShape groups = make_page_shape(pages, shape == 0);
            REQUIRE(groups.count <= max_page_groups);
            std::vector<int> seen(pages.page_vertices(shape));
            for (std::uint32_t n = 0; n < groups.count; ++n) {
                const GroupShape& b = groups.groups[n];
                for (std::uint32_t lane = 0; lane < b.lanes; ++lane) {
                    const std::uint32_t place = b.first + b.stride * lane;
                    REQUIRE(place < seen.size());
                    ++seen[place];
                    const SampleIndex c = pages.coord({shape, place});
                    const Site site = site_at(c);
                    REQUIRE(site.kind == b.kind);
                    REQUIRE(site.i == b.i0 + (b.along_y ? 0 : static_cast<int>(lane)));
                    REQUIRE(site.j == b.j0 + (b.along_y ? static_cast<int>(lane) : 0));
                }
            }
            const std::uint32_t corners = shape == 0 ? 4 : 0; // in no group
            CHECK(std::count(seen.begin(), seen.end(), 1) == static_cast<std::ptrdiff_t>(seen.size() - corners));
        }
    }
}
