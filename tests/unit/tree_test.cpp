// The vertex tree against explicit bisection: the arithmetic of shared/tree.h must describe the very triangles that
// splitting produces.
#include <catch2/catch.hpp>

#include <map>
#include <set>

#include "shared/tree.h"

using namespace fjell;

namespace {

struct Less {
    bool operator()(SampleIndex a, SampleIndex b) const { return a.row != b.row ? a.row < b.row : a.column < b.column; }
};

// What bisection knows of a vertex: who was at the right angles of the triangles it split.
struct Seen {
    std::set<SampleIndex, Less> apexes, ends;
    int level = 0;
};
using Book = std::map<SampleIndex, Seen, Less>;

void bisect(Book& book, SampleIndex apex, SampleIndex left, SampleIndex right, int level) {
    if (((left.column + right.column) | (left.row + right.row)) & 1) return;
    const SampleIndex m{(left.column + right.column) / 2, (left.row + right.row) / 2};
    Seen& seen = book[m];
    seen.apexes.insert(apex);
    seen.ends.insert(left);
    seen.ends.insert(right);
    seen.level = level;
    bisect(book, m, apex, left, level + 1);
    bisect(book, m, right, apex, level + 1);
}

Book bisect_all(const Tree& tree) {
    Book book;
    const std::int32_t n = tree.side();
    for (std::int32_t ty = 0; ty < tree.tiles_y; ++ty)
        for (std::int32_t tx = 0; tx < tree.tiles_x; ++tx) {
            const SampleIndex nw{tx * n, ty * n}, ne{nw.column + n, nw.row}, sw{nw.column, nw.row + n},
                se{nw.column + n, nw.row + n};
            bisect(book, ne, nw, se, 0);
            bisect(book, sw, se, nw, 0);
        }
    return book;
}

} // namespace

TEST_CASE("levels, diamonds and children are those of explicit bisection, across tile borders too") {
    for (int log2 = 1; log2 <= 7; ++log2)
        for (const auto& [tiles_x, tiles_y] : {std::pair{1, 1}, {3, 2}, {2, 3}}) {
            if (log2 == 7 && tiles_x > 1) continue;
            const Tree tree{log2, tiles_x, tiles_y};
            const Book book = bisect_all(tree);
            std::size_t corners = 0;
            std::map<SampleIndex, std::set<SampleIndex, Less>, Less> parents_of;
            for (std::int32_t y = 0; y < tree.rows(); ++y)
                for (std::int32_t x = 0; x < tree.columns(); ++x) {
                    const SampleIndex v{x, y};
                    if (tree.is_corner(v)) {
                        ++corners;
                        REQUIRE_FALSE(book.contains(v));
                        continue;
                    }
                    const Seen& seen = book.at(v);
                    REQUIRE(tree.level(v) == seen.level);
                    const Diamond d = diamond(tree, v);
                    std::set<SampleIndex, Less> apexes;
                    for (const SampleIndex a : d.apexes)
                        if (tree.contains(a)) apexes.insert(a);
                    REQUIRE(apexes == seen.apexes);
                    REQUIRE(std::set<SampleIndex, Less>{d.ends[0], d.ends[1]} == seen.ends);
                    const Children kids = children(v);
                    REQUIRE(kids.count == (seen.level == 2 * log2 - 1 ? 0 : 4));
                    for (int k = 0; k < kids.count; ++k)
                        if (tree.contains(kids.at[k])) parents_of[kids.at[k]].insert(v);
                }
            REQUIRE(corners == static_cast<std::size_t>((tiles_x + 1) * (tiles_y + 1)));
            // Children are the reverse of parents; only roots have corners instead.
            for (const auto& [v, seen] : book) {
                std::set<SampleIndex, Less> expected;
                for (const SampleIndex a : seen.apexes)
                    if (!tree.is_corner(a)) expected.insert(a);
                REQUIRE(parents_of[v] == expected);
            }
        }
}
