// Vertices of 16 bytes and indices of 2 (fjell/compact.h): what they round, to which side, and which budgets they fit.
#include <catch2/catch.hpp>

#include <cmath>
#include <random>
#include <vector>

#include "fjell/compact.h"
#include "support/rounds.h"

using namespace fjell;

namespace {

CompactVertex compact(const MeshVertex& vertex, const MorphVertex& morph) {
    CompactVertex made{};
    compact_vertices({&vertex, 1}, {&morph, 1}, {&made, 1});
    return made;
}

// As terrain.glsl and morphed_height_m() have it, in doubles.
double morphed(double distance_m, double error_m, double radius_m, const MorphView& view) {
    const double start_m = radius_m + error_m * double{view.start_per_error},
                 full_m = radius_m + error_m * double{view.full_per_error};
    return std::clamp((start_m - distance_m) / (start_m - full_m), 0.0, 1.0);
}

} // namespace

TEST_CASE("a compact vertex is never drawn farther from its full height than the cut thinks, nor nearer than is said") {
    std::mt19937 random(11);
    const auto among = [&](double least, double most) { // evenly by ratio
        return least * std::pow(most / least, std::uniform_real_distribution<>(0, 1)(random));
    };
    double largest_share = 0;
    for (int round = 0; round < fjell::test::rounds(20'000, 1'000'000); ++round) {
        const double nesting = among(0.01, 0.5);
        const auto full_per_error = static_cast<float>(among(50, 5000));
        const MorphView view{0, 0, 0, full_per_error * static_cast<float>((1 + nesting) * (1 + nesting)),
                             full_per_error};
        // From the least that is told apart: below it, all of the error is less than a millimetre.
        const auto error_m = static_cast<float>(among(0x1p-10, 4000)), radius_m = static_cast<float>(among(0.1, 1e5));
        const auto height_m = static_cast<float>(among(1, 8000));
        const double rise_m = double{error_m} * std::uniform_real_distribution<>(-1, 1)(random);
        const MorphVertex morph{static_cast<float>(double{height_m} + rise_m), error_m, radius_m, activated_long_ago_s};
        const double morph_from_m = double{morph.morph_from_m} - double{height_m};
        const CompactVertex made = compact({3, 4, height_m}, morph);

        CHECK(made.height_m == height_m);
        const double error = double{compact_length_m(made.error)}, radius = double{compact_length_m(made.radius)};
        REQUIRE(error >= double{error_m});
        REQUIRE(error <= double{error_m} * (1 + 0x1p-11));
        REQUIRE(radius >= double{radius_m});
        REQUIRE(radius <= double{radius_m} * (1 + 0x1p-11));
        const double rise = double{compact_rise_m(made.rise)};
        REQUIRE(std::abs(rise) <= std::abs(morph_from_m));
        REQUIRE(std::abs(rise - morph_from_m) <= std::max(std::abs(morph_from_m) * 0x1p-10, 0x1p-14));

        const double start_m = radius + error * double{view.start_per_error},
                     end_m = double{radius_m} + double{error_m * full_per_error};
        const double distance_m = among(end_m * 0.9, start_m * 1.1);
        const double full = morphed(distance_m, double{error_m}, double{radius_m}, view);
        const double drawn = morphed(distance_m, error, radius, view);
        CHECK(drawn >= full - 1e-9); // doubles
        // In shares of the threshold: full_per_error is the pixels that a metre covers a metre away, over the
        // threshold.
        const double off_m = std::abs(rise * (1 - drawn) - morph_from_m * (1 - full));
        const double share = off_m * double{full_per_error} / distance_m;
        const double rounded = 0x1p-14 * double{full_per_error} / distance_m; // the least half
        largest_share = std::max(largest_share, (share - rounded) / compact_share(view));
        REQUIRE(share <= compact_share(view) * (1 + 1e-9) + rounded);
    }
    INFO("largest " << largest_share << " of what is said");
    CHECK(largest_share > 0.5); // or it says too much
}

TEST_CASE("a compact vertex starts to morph by time no earlier than the cut says, and up to two steps later") {
    for (std::uint32_t tick = 0; tick < 1024u << 14; tick += 97) { // steps of the cut's clock
        const float activated_s = static_cast<float>(tick) * 0x1p-14f;
        const CompactVertex made =
            compact({}, {.morph_from_m = 0, .error_m = 1, .radius_m = 1, .activated_s = activated_s});
        REQUIRE(made.activated != compact_activated_long_ago);
        const float late_s = static_cast<float>(made.activated) / compact_steps_s - activated_s;
        const float late_turned_s = late_s < -morph_clock_s / 2 ? late_s + morph_clock_s : late_s;
        REQUIRE(late_turned_s >= 0);
        REQUIRE(late_turned_s < compact_late_s);
    }
    CHECK(
        compact({}, {.morph_from_m = 0, .error_m = 1, .radius_m = 1, .activated_s = activated_long_ago_s}).activated ==
        compact_activated_long_ago);
}

TEST_CASE("what a compact vertex cannot hold becomes the nearest that it can") {
    const auto made = [](const MeshVertex& vertex, float morph_from_m, float error_m) {
        return compact(vertex, {morph_from_m, error_m, 0, activated_long_ago_s});
    };
    // A vertex that morphs out has an error without end: it has arrived, by distance.
    const CompactVertex out = made({70'000, 65'535, 1}, 1e6f, 1e30f);
    CHECK(out.column == 70'000 - 65'536);
    CHECK(out.row == 65'535);
    CHECK(compact_length_m(out.error) > 4e6f);
    CHECK(compact_length_m(out.radius) == 0x1p-10f);
    CHECK(compact_rise_m(out.rise) == 65'504.0f);
    CHECK(compact_rise_m(made({0, 0, 0}, -0x1p-15f, 0).rise) == 0);
    CHECK(compact_rise_m(made({0, 0, 3}, 2.5f, 0).rise) == -0.5f);
}

TEST_CASE("arrays are made compact as far as the shortest of them goes") {
    const std::vector<MeshVertex> vertices(5, MeshVertex{1, 2, 3});
    const std::vector<MorphVertex> morphs(4, MorphVertex{3, 1, 1, activated_long_ago_s});
    std::vector<CompactVertex> made(6, CompactVertex{});
    compact_vertices(vertices, morphs, made);
    CHECK(made[3].column == 1);
    CHECK(made[4].column == 0);
    compact_vertices(vertices, {}, made);
    const std::vector<std::uint32_t> indices{0, 65'535, 65'537};
    std::vector<std::uint16_t> small(2);
    compact_indices(indices, small);
    CHECK(small == std::vector<std::uint16_t>{0, 65'535});
}

TEST_CASE("indices take 16 bits as long as these name every slot of the budget") {
    CHECK(index_bytes({.vertices = 65'536}) == 2);
    CHECK(index_bytes({.vertices = 65'537}) == 4);
    CHECK(compact_share({}) == 0); // without morphing
}
