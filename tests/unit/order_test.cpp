// Where vertices lie in pages, against what shared/order.h promises and the thesis' own formulas; and the recursion's
// shortcut to the same places.
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "fjell/pages.h"
#include "recursive/locate.h"
#include "shared/order.h"
#include "shared/terrain_data.h"

using namespace fjell;

namespace {

constexpr const char* order_names[] = {"planar", "hierarchical Z", "linear"};
constexpr PageOrder level_orders[] = {PageOrder::planar, PageOrder::hierarchical_z};

std::string title(const PageLayout& layout) {
    return std::string(order_names[static_cast<int>(layout.order)]) + ", l = " + std::to_string(layout.tile_log2);
}

// Tiles of all sizes up to 2^11, in the given orders.
template <typename Orders, typename Visit>
void for_each_layout(const Orders& orders, const Visit& visit) {
    for (const PageOrder order : orders)
        for (int log2 = 1; log2 <= 11; ++log2) {
            const PageLayout layout{log2, order};
            INFO(title(layout));
            visit(layout);
        }
}
template <typename Visit>
void for_each_layout(const Visit& visit) {
    for_each_layout(std::array{PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear}, visit);
}

// All vertices of a tile, or those of every stride-th row and the last.
template <typename Visit>
void for_each_vertex(const PageLayout& layout, std::uint32_t stride, const Visit& visit) {
    const std::uint32_t side = layout.side();
    for (std::uint32_t y = 0;; y = std::min(y + stride, side)) {
        for (std::uint32_t x = 0; x <= side; ++x) visit(x, y);
        if (y == side) break;
    }
}

template <typename Visit>
void for_each_record(const PageLayout& layout, const Visit& visit) {
    for (std::uint32_t page = 0; page < layout.pages_per_tile(); ++page)
        for (std::uint32_t index = 0; index < layout.page_vertices(page); ++index) visit(PagePlace{page, index});
}

bool is_corner(const PageLayout& layout, SampleIndex c) {
    return Tree{layout.tile_log2, 1, 1}.is_corner(c);
}
SampleIndex to_coord(std::uint32_t x, std::uint32_t y) {
    return {static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)};
}
PagePlace place_of(const PageLayout& layout, SampleIndex c) {
    return layout.place(static_cast<std::uint32_t>(c.column), static_cast<std::uint32_t>(c.row));
}
// Places in the order of page, then index.
std::uint32_t number(PagePlace at) {
    return at.page * max_page_vertices + at.index;
}

// Places that are outside the pages, taken before, or do not lead back.
std::uint32_t count_wrong_places(const PageLayout& layout, std::uint32_t stride) {
    std::uint32_t wrong = 0;
    std::vector<bool> taken(layout.pages_per_tile() * max_page_vertices);
    for_each_vertex(layout, stride, [&](std::uint32_t x, std::uint32_t y) {
        const PagePlace at = layout.place(x, y);
        if (at.page >= layout.pages_per_tile() || at.index >= layout.page_vertices(at.page) || taken[number(at)]) {
            ++wrong;
            return;
        }
        taken[number(at)] = true;
        wrong += layout.coord(at) != to_coord(x, y);
    });
    return wrong;
}

// The closed square of cells of a step page: where its position says that it lies.
struct Square {
    std::int32_t west, north, east, south;
};
Square square_of(const PageLayout& layout, std::uint32_t page) {
    const std::int32_t cells = std::int32_t{32} << (layout.page_step_log2(page) + 1);
    const SampleIndex at = layout.page_position(page);
    return {at.column * cells, at.row * cells, (at.column + 1) * cells, (at.row + 1) * cells};
}

// Vertices for which the recursion's arithmetic gives another place than the layout's, or another unit of radii than
// its level's.
template <PageOrder O>
std::uint32_t count_wrong_locations(int log2, std::uint32_t stride) {
    TerrainData terrain;
    terrain.tree = {log2, 1, 1};
    terrain.pages = {log2, O};
    for (int level = 0; level < 2 * log2; ++level) terrain.header.level_radius_m[level] = static_cast<float>(level + 1);
    std::array<std::array<LevelPlane, 3>, max_tile_log2> planes{};
    for (int z = 0; z < log2; ++z)
        planes[static_cast<std::size_t>(z)] = {make_level_plane(terrain, z, VertexKind::centre),
                                               make_level_plane(terrain, z, VertexKind::side_x),
                                               make_level_plane(terrain, z, VertexKind::side_y)};
    // Every page in the slot of its own number, but the second one, which is not loaded.
    const std::uint32_t capacity = terrain.pages.page_capacity();
    const auto base_of = [](std::uint32_t page) { return static_cast<std::int32_t>(7 * page); };
    std::vector<StepPageEntry> entries(entries_per_tile(terrain.pages), StepPageEntry{no_index, -1});
    for (std::uint32_t page = 0; page < terrain.pages.pages_per_tile(); ++page)
        set_step_page(terrain, page, {page == 1 ? no_index : page * capacity, base_of(page)}, entries.data());
    std::uint32_t wrong = 0;
    for (auto& step : planes)
        for (LevelPlane& plane : step) plane.pages = entries.data() + plane.first;
    for_each_vertex(terrain.pages, stride, [&](std::uint32_t x, std::uint32_t y) {
        const SampleIndex c = to_coord(x, y);
        if (terrain.tree.is_corner(c)) return;
        const LevelPlane& plane =
            planes[static_cast<std::size_t>(Tree::step_log2(c))][static_cast<std::size_t>(Tree::kind(c))];
        const Located found = locate<O>(plane, pack_xy(x, y));
        const PagePlace place = terrain.pages.place_as<O>(x, y);
        wrong += found.loaded != (place.page != 1) || found.base != base_of(place.page);
        wrong += found.loaded && found.index != place.page * capacity + place.index;
        wrong += plane.unit_m != static_cast<float>(terrain.tree.level(c) + 1);
    });
    return wrong;
}

// The thesis' Z-index, bit by bit.
std::uint32_t z_index(std::uint32_t x, std::uint32_t y) {
    std::uint32_t m = 0;
    for (unsigned bit = 0; bit < 12; ++bit) m |= (x >> bit & 1) << 2 * bit | (y >> bit & 1) << (2 * bit + 1);
    return m;
}

} // namespace

TEST_CASE("every vertex has a place of its own in a page of its tile, and the place leads back to it") {
    for_each_layout([](const PageLayout& layout) { REQUIRE(count_wrong_places(layout, 1) == 0); });
    // The largest tiles: every seventh row.
    for (const PageOrder order : {PageOrder::planar, PageOrder::hierarchical_z, PageOrder::linear})
        REQUIRE(count_wrong_places({max_tile_log2, order}, 7) == 0);
}

TEST_CASE("no page is empty or larger than a slot, and the largest one fills its slot") {
    for_each_layout([](const PageLayout& layout) {
        std::uint32_t least = max_page_vertices, most = 0;
        for (std::uint32_t page = 0; page < layout.pages_per_tile(); ++page) {
            least = std::min(least, layout.page_vertices(page));
            most = std::max(most, layout.page_vertices(page));
        }
        REQUIRE(least > 0);
        REQUIRE(most == layout.page_capacity());
        REQUIRE(most <= max_page_vertices);
    });
}

TEST_CASE("what a page holds of others lies on its south or east border, and the page beyond owns it") {
    for_each_layout(level_orders, [](const PageLayout& layout) {
        std::uint32_t records = 0, copies = 0, wrong = 0;
        for_each_record(layout, [&](PagePlace at) {
            ++records;
            const SampleIndex c = layout.coord(at);
            const PagePlace owner = place_of(layout, c);
            wrong += layout.coord(owner) != c;
            if (owner == at) return;
            ++copies;
            if (at.page == 0 || owner.page == 0 ||
                layout.page_step_log2(owner.page) != layout.page_step_log2(at.page)) {
                ++wrong;
                return;
            }
            const Square square = square_of(layout, at.page);
            const bool east = c.column == square.east, south = c.row == square.south;
            wrong += east == south;
            wrong += layout.page_position(owner.page) != layout.page_position(at.page) + SampleIndex{east, south};
        });
        REQUIRE(wrong == 0);
        REQUIRE(records == layout.tile_vertices() + copies);
        // 32 for each border between two of the n x n pages of a step.
        std::uint32_t expected = 0;
        for (int z = layout.tile_log2 - 6; z >= 0; --z) {
            const std::uint32_t n = 1u << (layout.tile_log2 - 6 - z);
            expected += 32 * 2 * n * (n - 1);
        }
        REQUIRE(copies == expected);
    });
}

TEST_CASE("linear order is the tile's rows one after the other, and holds nothing twice") {
    for_each_layout(std::array{PageOrder::linear}, [](const PageLayout& layout) {
        std::uint32_t records = 0, wrong = 0;
        for_each_record(layout, [&](PagePlace at) {
            ++records;
            wrong += place_of(layout, layout.coord(at)) != at;
        });
        REQUIRE(records == layout.tile_vertices());
        std::uint32_t next = 0;
        for_each_vertex(layout, 1,
                        [&](std::uint32_t x, std::uint32_t y) { wrong += number(layout.place(x, y)) != next++; });
        for (std::uint32_t page = 0; page < layout.pages_per_tile(); ++page) wrong += layout.page_step_log2(page) != -1;
        REQUIRE(wrong == 0);
    });
}

TEST_CASE("page 0 holds exactly the coarsest grid of 33 x 33 samples, or all of a small tile, and first its corners") {
    for_each_layout(level_orders, [](const PageLayout& layout) {
        const std::uint32_t cells = std::min(layout.side(), 32u), apart = layout.side() / cells;
        REQUIRE(layout.page_vertices(0) == (cells + 1) * (cells + 1));
        REQUIRE(layout.page_step_log2(0) == -1);
        std::uint32_t wrong = 0;
        std::vector<bool> seen(layout.page_vertices(0));
        for (std::uint32_t y = 0; y <= cells; ++y)
            for (std::uint32_t x = 0; x <= cells; ++x) {
                const PagePlace at = layout.place(x * apart, y * apart);
                if (at.page != 0 || at.index >= seen.size()) {
                    ++wrong;
                    continue;
                }
                seen[at.index] = true;
                wrong += is_corner(layout, to_coord(x * apart, y * apart)) != (at.index < 4);
            }
        REQUIRE(wrong == 0);
        REQUIRE(std::count(seen.begin(), seen.end(), true) == static_cast<std::ptrdiff_t>(seen.size()));
    });
}

TEST_CASE("a page is the closed square of 64 x 64 cells of its step: all vertices of that step and no others") {
    constexpr std::uint32_t expected = 32 * 32 + 2 * 32 * 33;
    for_each_layout(level_orders, [](const PageLayout& layout) {
        std::uint32_t wrong = 0;
        for (std::uint32_t page = 1; page < layout.pages_per_tile(); ++page) {
            const int z = layout.page_step_log2(page);
            const Square square = square_of(layout, page);
            std::vector<bool> seen(65 * 65);
            std::uint32_t found = 0;
            for (std::uint32_t index = 0; index < layout.page_vertices(page); ++index) {
                const SampleIndex c = layout.coord({page, index});
                if (c.column < square.west || c.column > square.east || c.row < square.north || c.row > square.south ||
                    is_corner(layout, c) || Tree::step_log2(c) != z) {
                    ++wrong;
                    continue;
                }
                const auto column = static_cast<std::size_t>((c.column - square.west) >> z),
                           row = static_cast<std::size_t>((c.row - square.north) >> z), at = row * 65 + column;
                found += !seen[at];
                seen[at] = true;
            }
            wrong += found != expected;
        }
        REQUIRE(wrong == 0);
    });
}

TEST_CASE("pages of coarser steps come first, and a page's number, its step and its position say the same") {
    for_each_layout(level_orders, [](const PageLayout& layout) {
        std::uint32_t pages = 1, wrong = 0;
        for (int z = layout.tile_log2 - 6; z >= 0; --z) {
            const std::uint32_t first = pages, n = 1u << (layout.tile_log2 - 6 - z);
            for (std::uint32_t by = 0; by < n; ++by)
                for (std::uint32_t bx = 0; bx < n; ++bx, ++pages) {
                    const std::uint32_t page = layout.page_at(z, bx, by);
                    wrong += page < first || page >= first + n * n;
                    wrong += layout.page_step_log2(page) != z || layout.page_position(page) != to_coord(bx, by);
                    wrong += page != first + (layout.order == PageOrder::planar ? by * n + bx : z_index(bx, by));
                }
        }
        REQUIRE(wrong == 0);
        REQUIRE(pages == layout.pages_per_tile());
        for (std::uint32_t page = 1; page < pages; ++page) {
            const SampleIndex at = layout.page_position(page);
            wrong += layout.page_at(layout.page_step_log2(page), static_cast<std::uint32_t>(at.column),
                                    static_cast<std::uint32_t>(at.row)) != page;
        }
        REQUIRE(wrong == 0);
    });
}

TEST_CASE("a host finds the page that a vertex is read from, and the page of a step over any place") {
    for_each_layout([](const PageLayout& layout) {
        PackHeader header{};
        header.tile_log2 = static_cast<std::uint32_t>(layout.tile_log2);
        header.order = layout.order;
        REQUIRE(pages_per_tile(header) == layout.pages_per_tile());
        for (std::uint32_t page = 0; page < layout.pages_per_tile(); ++page)
            REQUIRE(page_step_log2(header, page) == layout.page_step_log2(page));
        bool right = true;
        for_each_vertex(layout, 7, [&](std::uint32_t x, std::uint32_t y) {
            const std::uint32_t page = layout.place(x, y).page;
            right = right && page_of(header, x, y) == page;
            const int z = layout.page_step_log2(page);
            if (z >= 0) right = right && page_at(header, static_cast<std::uint32_t>(z), x, y) == page;
        });
        CHECK(right);
        const std::uint32_t none = header.tile_log2 - std::min(header.tile_log2, 5u); // steps of page 0 begin here
        for (const std::uint32_t z : {none, none + 1, 31u, ~0u}) CHECK(page_at(header, z, 0, 0) == 0);
    });
}

TEST_CASE("in planar order a page's centres come first, then both kinds of sides, each row by row") {
    for_each_layout(std::array{PageOrder::planar}, [](const PageLayout& layout) {
        std::uint32_t wrong = 0;
        std::array<std::int32_t, 4> before{};
        for_each_record(layout, [&](PagePlace at) {
            const SampleIndex c = layout.coord(at);
            if (is_corner(layout, c)) return;
            const std::array<std::int32_t, 4> now{-Tree::step_log2(c), static_cast<std::int32_t>(Tree::kind(c)), c.row,
                                                  c.column};
            if (at.index != 0 && at.index != 4) wrong += now <= before;
            before = now;
        });
        REQUIRE(wrong == 0);
    });
}

TEST_CASE("hierarchical Z-order is the thesis': inside a level, i - (i >> 2) - 1 of the Z-index without its zeros") {
    for_each_layout(std::array{PageOrder::hierarchical_z}, [](const PageLayout& layout) {
        struct Numbered {
            std::int32_t zeros = -1;
            std::uint32_t number = 0;
        };
        // Sorted by place: what the formula says of the vertex there. The last row and column are not the Z-field's.
        std::vector<Numbered> at(layout.pages_per_tile() * max_page_vertices);
        for_each_vertex(layout, 1, [&](std::uint32_t x, std::uint32_t y) {
            if (x == layout.side() || y == layout.side() || (x | y) == 0) return;
            const std::uint32_t m = z_index(x, y);
            std::int32_t zeros = 0;
            while ((m >> 2 * zeros & 3) == 0) ++zeros;
            const std::uint32_t i = m >> 2 * zeros;
            at[number(layout.place(x, y))] = {zeros, i - (i >> 2) - 1};
        });
        std::uint32_t wrong = 0, next = 0;
        std::int32_t zeros = layout.tile_log2;
        for (const Numbered& v : at) {
            if (v.zeros < 0) continue;
            if (v.zeros != zeros) { // the next level: four times as many Zs, three vertices each
                wrong += v.zeros != zeros - 1;
                wrong += zeros < layout.tile_log2 && next != 3u << 2 * (layout.tile_log2 - 1 - zeros);
                zeros = v.zeros;
                next = 0;
            }
            wrong += v.number != next++;
        }
        REQUIRE(wrong == 0);
        REQUIRE(zeros == 0);
        REQUIRE(next == 3u << 2 * (layout.tile_log2 - 1));
    });
}

TEST_CASE("a tile's last row and column in hierarchical Z-order are the thesis' binary trees") {
    for_each_layout(std::array{PageOrder::hierarchical_z}, [](const PageLayout& layout) {
        for (const bool row : {true, false}) {
            std::vector<std::pair<std::uint32_t, std::uint32_t>> tree; // place, coordinate
            for (std::int32_t c = 1, n = 1 << layout.tile_log2; c < n; ++c)
                tree.emplace_back(number(place_of(layout, row ? SampleIndex{c, n} : SampleIndex{n, c})), c);
            std::sort(tree.begin(), tree.end());
            std::uint32_t wrong = 0, next = 0;
            int zeros = layout.tile_log2 - 1;
            for (const auto& [place, c] : tree) {
                if (next == 1u << (layout.tile_log2 - 1 - zeros)) --zeros, next = 0;
                wrong += std::countr_zero(c) != zeros || c >> (zeros + 1) != next++;
            }
            REQUIRE(wrong == 0);
        }
    });
}

TEST_CASE("on its way down the recursion finds every vertex where the layout places it") {
    for (int log2 = 1; log2 <= max_tile_log2; ++log2) {
        INFO("l = " << log2);
        const std::uint32_t stride = log2 <= 9 ? 1 : 7;
        REQUIRE(count_wrong_locations<PageOrder::planar>(log2, stride) == 0);
        REQUIRE(count_wrong_locations<PageOrder::hierarchical_z>(log2, stride) == 0);
        REQUIRE(count_wrong_locations<PageOrder::linear>(log2, stride) == 0);
    }
}
