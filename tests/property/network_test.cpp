// Heights along networks of lines, and how lines become one: against slow and simple yardsticks.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "baker/vectors/network.h"
#include "baker/vectors/profile.h"
#include "fjell/io/failure.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell;
using namespace fjell::baker;
using namespace fjell::test;

namespace {

struct RandomGraph {
    std::vector<double> ground_m;
    std::vector<HeightLimit> limits;
    std::vector<Flow> flows;
};
RandomGraph random_graph(Random& random) {
    RandomGraph g;
    const int places = pick(random, 1, 24);
    for (int i = 0; i < places; ++i) g.ground_m.push_back(uniform(random, -50, 50));
    for (int i = pick(random, 0, 3 * places); i > 0; --i) {
        const auto a = static_cast<std::uint32_t>(pick(random, 0, places - 1)),
                   b = static_cast<std::uint32_t>(pick(random, 0, places - 1));
        g.limits.push_back({a, b, pick(random, 0, 9) ? uniform(random, 0, 20) : 0});
        g.flows.push_back({a, b});
    }
    return g;
}

// Of all pairs of places, by Floyd and Warshall.
std::vector<std::vector<double>> distances(const RandomGraph& g) {
    const std::size_t n = g.ground_m.size();
    std::vector all(n, std::vector(n, std::numeric_limits<double>::infinity()));
    for (std::size_t i = 0; i < n; ++i) all[i][i] = 0;
    for (const HeightLimit& l : g.limits) all[l.a][l.b] = all[l.b][l.a] = std::min(all[l.a][l.b], l.most_m);
    for (std::size_t k = 0; k < n; ++k)
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < n; ++j) all[i][j] = std::min(all[i][j], all[i][k] + all[k][j]);
    return all;
}

double apart_m(const Place& a, const Place& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1]);
}

} // namespace

TEST_CASE("limited heights keep every limit, and none that do are nearer to the ground") {
    Random random(11);
    constexpr double rounding_m = 1e-11; // of sums of 25 numbers below 100
    for (int round = 0; round < rounds(200, 5000); ++round) {
        const RandomGraph g = random_graph(random);
        const std::vector<double> heights_m = limited_heights(g.ground_m, g.limits);
        const auto far_m = distances(g);
        double least_m = 0, off_m = 0; // half of what a pair of places differs by more than it may
        for (std::size_t i = 0; i < heights_m.size(); ++i) {
            off_m = std::max(off_m, std::abs(heights_m[i] - g.ground_m[i]));
            for (std::size_t j = 0; j < heights_m.size(); ++j)
                least_m = std::max(least_m, 0.5 * (std::abs(g.ground_m[i] - g.ground_m[j]) - far_m[i][j]));
        }
        for (const HeightLimit& l : g.limits)
            REQUIRE(std::abs(heights_m[l.a] - heights_m[l.b]) <= l.most_m + rounding_m);
        REQUIRE(std::abs(off_m - least_m) <= rounding_m);
    }
    CHECK(limited_heights({}, {}).empty());
}

TEST_CASE("a river's bed is the lowest of all that lies upstream, around circles too") {
    Random random(12);
    for (int round = 0; round < rounds(200, 5000); ++round) {
        const RandomGraph g = random_graph(random);
        std::vector<double> expected = g.ground_m;
        for (bool changed = true; changed;) {
            changed = false;
            for (const Flow& f : g.flows)
                if (expected[f.from] < expected[f.to]) expected[f.to] = expected[f.from], changed = true;
        }
        REQUIRE(river_beds(g.ground_m, g.flows) == expected);
    }
}

TEST_CASE("without its bumps a line has its ends' heights, and less of a short wave than of a long one") {
    const auto left_of = [](double wave) {
        std::vector<double> ground_m;
        std::vector<Neighbours> pairs;
        for (std::uint32_t i = 0; i <= 400; ++i) {
            ground_m.push_back(std::sin(2 * 3.14159265 * i / wave) + 0.1 * i);
            if (i > 0) pairs.push_back({i - 1, i, 1.0});
        }
        const std::vector<double> smooth_m = without_bumps(ground_m, pairs, 30);
        CHECK((smooth_m.front() == ground_m.front() && smooth_m.back() == ground_m.back()));
        double most = 0;
        for (std::uint32_t i = 150; i < 250; ++i) most = std::max(most, std::abs(smooth_m[i] - 0.1 * i));
        return most;
    };
    CHECK(left_of(10) < 0.01);
    CHECK(left_of(300) > 0.95);
    CHECK(without_bumps(std::vector<double>{1, 5}, {}, 30) == std::vector<double>{1, 5});
}

TEST_CASE("lines become short links that lie on them, within the terrain, joined where they meet") {
    Random random(13);
    for (int round = 0; round < rounds(40, 800); ++round) {
        const NetworkOptions options{uniform(random, 20, 100), uniform(random, 20, 100), uniform(random, 0.5, 3), 0.2};
        NetworkOptions snap = options;
        snap.snap_m = 0.25 * options.step_m;
        std::vector<std::vector<Place>> lines;
        for (int i = pick(random, 1, 5); i > 0; --i) {
            std::vector<Place>& line = lines.emplace_back();
            for (int k = pick(random, 1, 6); k > 0; --k)
                line.push_back({uniform(random, -20, 120), uniform(random, -20, 120)});
            if (pick(random, 0, 3) == 0) line.push_back(line.front()); // a ring
            if (pick(random, 0, 5) == 0) line.push_back({std::nan(""), 3}), line.push_back({5, 5});
        }
        const Network n = make_network(lines, snap);
        CAPTURE(round, n.stations.size(), n.links.size());
        double long_m = 0, drawn_m = 0;
        for (const auto& line : lines)
            for (const auto& piece : clipped(line, options.width_m, options.height_m))
                for (std::size_t i = 1; i < piece.size(); ++i) drawn_m += apart_m(piece[i - 1], piece[i]);
        int wrong = 0;
        for (const Link& l : n.links) {
            const Place &a = n.stations[l.from], &b = n.stations[l.to];
            long_m += l.length_m;
            wrong += std::abs(l.length_m - apart_m(a, b)) > 1e-9 || l.length_m > options.step_m + 2 * snap.snap_m;
            for (const Place& at : {a, b})
                wrong +=
                    at[0] < -1e-9 || at[0] > options.width_m + 1e-9 || at[1] < -1e-9 || at[1] > options.height_m + 1e-9;
            // Its middle lies on the line that it says it is of, but for what joining has moved its ends by.
            double off_m = std::numeric_limits<double>::infinity();
            const std::vector<Place>& line = lines[l.line];
            const Place middle = between(a, b, 0.5);
            for (std::size_t i = 1; i < line.size(); ++i) {
                const Place &p = line[i - 1], &q = line[i];
                const double squared = apart_m(p, q) * apart_m(p, q);
                const double share = std::clamp(
                    ((middle[0] - p[0]) * (q[0] - p[0]) + (middle[1] - p[1]) * (q[1] - p[1])) / squared, 0.0, 1.0);
                if (squared > 0) off_m = std::min(off_m, apart_m(middle, between(p, q, share)));
            }
            wrong += !(off_m <= 2 * snap.snap_m);
        }
        REQUIRE(wrong == 0);
        CHECK(long_m <= drawn_m + 1e-6 + 2 * snap.snap_m * static_cast<double>(n.links.size()));
        // No two links cross but at a station of both, unless an end of one has been joined to where it nearly lay.
        int crossings = 0;
        for (std::size_t i = 0; i < n.links.size(); ++i)
            for (std::size_t j = i + 1; j < n.links.size(); ++j) {
                const Link &a = n.links[i], &b = n.links[j];
                if (a.from == b.from || a.from == b.to || a.to == b.from || a.to == b.to) continue;
                const auto side = [&](const Link& l, std::uint32_t s) {
                    const Place &p = n.stations[l.from], &q = n.stations[l.to], &at = n.stations[s];
                    return (q[0] - p[0]) * (at[1] - p[1]) - (q[1] - p[1]) * (at[0] - p[0]);
                };
                const double from = side(a, b.from), to = side(a, b.to);
                if (!(from * to < 0 && side(b, a.from) * side(b, a.to) < 0)) continue;
                double off_m = std::min(std::abs(from), std::abs(to)) / a.length_m;
                for (const std::uint32_t end : {a.from, a.to})
                    off_m = std::min(off_m, std::abs(side(b, end)) / b.length_m);
                crossings += off_m > snap.snap_m;
            }
        CHECK(crossings == 0);
    }
}

TEST_CASE("pairs beside each other are all that are near, but not along a straight line") {
    Random random(14);
    for (int round = 0; round < rounds(20, 300); ++round) {
        std::vector<std::vector<Place>> lines(2);
        for (std::vector<Place>& line : lines)
            for (int k = 0; k < 4; ++k) line.push_back({uniform(random, 0, 25), uniform(random, 0, 25)});
        const Network n = make_network(lines, {30, 30, 1, 0.25});
        std::vector along_m(n.stations.size(), std::vector(n.stations.size(), std::numeric_limits<double>::infinity()));
        for (const Link& l : n.links)
            along_m[l.from][l.to] = along_m[l.to][l.from] = std::min(along_m[l.from][l.to], l.length_m);
        for (std::size_t k = 0; k < n.stations.size(); ++k)
            for (std::size_t i = 0; i < n.stations.size(); ++i)
                for (std::size_t j = 0; j < n.stations.size(); ++j)
                    if (i != j) along_m[i][j] = std::min(along_m[i][j], along_m[i][k] + along_m[k][j]);
        constexpr double near_m = 3;
        std::size_t expected = 0, found = 0;
        for (std::size_t i = 0; i < n.stations.size(); ++i)
            for (std::size_t j = 0; j < i; ++j) {
                const double distance_m = apart_m(n.stations[i], n.stations[j]);
                expected += distance_m < near_m && along_m[i][j] > 1.001 * distance_m;
            }
        std::vector<NearPair> pairs;
        near_pairs(n, near_m, [&](const NearPair& pair) { pairs.push_back(pair); });
        for (const NearPair& p : pairs) {
            const double by_network_m = along_m[p.a][p.b];
            found += by_network_m > 1.001 * p.distance_m;
            CHECK((by_network_m > 2 * near_m ? std::isinf(p.along_m) : std::abs(p.along_m - by_network_m) < 1e-9));
        }
        CHECK((found == expected && pairs.size() == expected));
    }
}

TEST_CASE("lines that meet by a little, or cross, share a place; too many are refused") {
    // One ends 0.2 m short of another, a third crosses both, and the first two share an end with a fourth.
    const std::vector<std::vector<Place>> lines{{{10, 10}, {30, 10}}, {{20, 25}, {20, 10.2}}, {{10, 30}, {30, 5}}};
    const Network n = make_network(lines, {40, 40, 1, 0.25});
    std::vector<int> degree(n.stations.size());
    for (const Link& l : n.links) ++degree[l.from], ++degree[l.to];
    CHECK(std::ranges::count(degree, 1) == 5); // five of six ends lead nowhere
    CHECK(std::ranges::count(degree, 3) == 1);
    CHECK(std::ranges::count(degree, 4) == 2);
    const std::vector<std::vector<Place>> endless{{{0, 0}, {1e7, 0}}};
    REQUIRE_THROWS_AS(make_network(endless, {1e8, 1e8, 0.5, 0.1}), io::Failure);
    CHECK(make_network(std::vector<std::vector<Place>>{{}, {{1, 1}}, {{50, 50}, {60, 60}}}, {40, 40, 1, 0.25})
              .stations.empty());
}

TEST_CASE("a simplified line is within its bound of every place of the line") {
    Random random(15);
    std::vector<Place> line;
    for (int i = 0; i < 2000; ++i) line.push_back({i * 0.1, std::sin(i * 0.01) * 20 + uniform(random, -0.05, 0.05)});
    const std::vector<Place> few = simplified(line, 0.2);
    CHECK((few.size() < 100 && few.front() == line.front() && few.back() == line.back()));
    for (const Place& at : line) {
        double off_m = 1e9;
        for (std::size_t i = 1; i < few.size(); ++i) {
            const double squared = apart_m(few[i - 1], few[i]) * apart_m(few[i - 1], few[i]);
            const double share = std::clamp(((at[0] - few[i - 1][0]) * (few[i][0] - few[i - 1][0]) +
                                             (at[1] - few[i - 1][1]) * (few[i][1] - few[i - 1][1])) /
                                                squared,
                                            0.0, 1.0);
            off_m = std::min(off_m, apart_m(at, between(few[i - 1], few[i], share)));
        }
        REQUIRE(off_m <= 0.2 + 1e-9);
    }
    // A ring, whose ends are one place.
    const std::vector<Place> ring{{0, 0}, {5, 0}, {5, 5}, {0, 5}, {0, 0}};
    CHECK(simplified(ring, 0.1).size() == 5);
}
