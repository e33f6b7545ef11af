// Where texels of a tile lie on a height field.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>

#include "baker/outlets/texel_places.h"
#include "support/rounds.h"
#include "support/terrain_fixture.h"

using namespace fjell::baker;
using namespace fjell::test;

TEST_CASE("texels lie where they should to a share of a texel, whatever window they are asked for in") {
    Random random(48);
    int asked = 0, texels = 0;
    for (int round = 0; round < rounds(30, 300); ++round) {
        // Curved, or hardly; with a seam, as fields have that go around the globe, and an end.
        const double curve = std::exp2(uniform(random, -24, -6)), seam = uniform(random, -400, 400),
                     end = uniform(random, 0, 600), wide = uniform(random, 0.1, 30);
        const auto exact = [&](double x, double y) -> TexelPlaces::Place {
            if (x > end) return {};
            return std::array{wide * (x + curve * y * y) + (x > seam ? 1000 : 0), wide * (y + curve * x * y)};
        };
        const double accuracy = std::exp2(uniform(random, -12, -4));
        const Window window{pick(random, -300, 300), pick(random, -300, 300), pick(random, 1, 90), pick(random, 1, 90)};
        CAPTURE(round, curve, seam, end, accuracy, window.x, window.y, window.columns, window.rows);
        const auto counting = [&](double x, double y) {
            ++asked;
            return exact(x, y);
        };
        const TexelPlaces places(window, accuracy, counting);
        const TexelPlaces beside({window.x - 40, window.y - 30, 90, 70}, accuracy, exact);
        double worst = 0;
        int missing = 0, different = 0;
        for (int y = window.y; y < window.y + window.rows; ++y)
            for (int x = window.x; x < window.x + window.columns; ++x) {
                const TexelPlaces::Place is = places.at(x, y), should = exact(x, y);
                ++texels;
                missing += is.has_value() != should.has_value();
                if (is && should)
                    worst = std::max(worst, std::hypot((*is)[0] - (*should)[0], (*is)[1] - (*should)[1]) / wide);
                if (x < window.x + 50 && y < window.y + 40) different += is != beside.at(x, y);
            }
        CHECK(missing == 0);
        CHECK(different == 0);
        CHECK(worst <= 1.5 * accuracy); // it is measured in the middle, and along sides of twice the size of a texel
    }
    CHECK(asked < texels); // those that are curved are all asked for
}

TEST_CASE("where places are smooth few of them are asked for") {
    int asked = 0;
    const TexelPlaces places({0, 0, 256, 256}, 1.0 / 64, [&](double x, double y) -> TexelPlaces::Place {
        ++asked;
        return std::array{x + 1e-7 * y * y, y};
    });
    CHECK(places.at(255, 255).has_value());
    CHECK(asked == 33 * 33 + 32 * 32);
}
