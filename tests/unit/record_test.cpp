// The scales that a vertex' numbers count on: errors and radii only ever round up, heights do not depend on their page.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <vector>

#include "shared/record.h"
#include "shared/tree.h"

using namespace fjell;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// The scale that the baker makes for a nesting of mu (ErrorStage::choose_scale).
ErrorScale baker_scale(float floor_m, double mu, int tile_log2) {
    const double wish = std::ceil(std::log1p(mu) / std::log(1.05) - 1e-6);
    const auto steps = static_cast<std::uint32_t>(std::clamp(wish, 1.0, 64.0 / tile_log2));
    const double ratio = std::max(std::pow(1 + mu, 1.0 / steps), 1.05) * (1 + 0x1p-20);
    return ErrorScale::make(floor_m, static_cast<float>(ratio), steps);
}

// What the baker accepts as nesting, with floors of fine and of coarse terrain.
template <typename Visit>
void for_each_scale(const Visit& visit) {
    for (const double mu : {0.001, 0.01, 0.049, 0.05, 0.051, 0.1, 0.1025, 0.25, 0.5, 0.75, 1.0})
        for (const float floor_m : {1e-8f, 0.0005f, 0.3f, 1000.0f})
            for (int log2 = min_tile_log2; log2 <= max_tile_log2; ++log2) {
                const double stored = static_cast<float>(mu); // as in the pack's header
                INFO("mu " << mu << ", floor " << floor_m << " m, l = " << log2);
                visit(baker_scale(floor_m, stored, log2), stored);
            }
}

// Values on, just below, just above and between the codes', below the first one and beyond the last.
std::vector<double> probes(const std::vector<double>& codes) {
    std::vector<double> values{0, -1, 0x1p-1074, codes.back() * 1.001, codes.back() * 1e6, infinity};
    for (std::size_t i = 0; i < codes.size(); ++i) {
        values.insert(values.end(),
                      {codes[i], std::nextafter(codes[i], -infinity), std::nextafter(codes[i], infinity)});
        if (i > 0)
            for (const double part : {0.01, 0.5, 0.99})
                values.push_back(codes[i - 1] + part * (codes[i] - codes[i - 1]));
    }
    return values;
}

// The first code that is not below a value; the last one when there is none.
std::size_t search(const std::vector<double>& codes, double value) {
    std::size_t code = 0;
    while (code + 1 < codes.size() && !(codes[code] >= value)) ++code;
    return code;
}

} // namespace

TEST_CASE("error codes begin with none and the floor, and each is its ratio above the one before") {
    for_each_scale([](const ErrorScale& scale, double) {
        REQUIRE(scale.metres[0] == 0);
        REQUIRE(scale.metres[1] > 0);
        int not_above = 0, off = 0;
        for (int code = 1; code < 256; ++code) {
            not_above += !(scale.metres[code] > scale.metres[code - 1]);
            off += !std::isfinite(scale.metres[code]);
            // Two roundings to float: the step's and that of the step compared with.
            if (code > 2) {
                const double step =
                                 static_cast<double>(scale.metres[code]) / static_cast<double>(scale.metres[code - 1]),
                             first = static_cast<double>(scale.metres[2]) / static_cast<double>(scale.metres[1]);
                off += std::abs(step / first - 1) > 0x1.01p-23;
            }
        }
        REQUIRE(not_above == 0);
        REQUIRE(off == 0);
    });
    REQUIRE(baker_scale(0.25f, 0.05, 10).metres[1] == 0.25f);
}

TEST_CASE("an error's code is the smallest that is not below it") {
    for_each_scale([](const ErrorScale& scale, double) {
        const std::vector<double> codes(std::begin(scale.metres), std::end(scale.metres));
        int wrong = 0;
        for (const double value : probes(codes)) wrong += scale.code_up(value) != search(codes, value);
        REQUIRE(wrong == 0);
        REQUIRE(scale.code_up(0) == 0);
        REQUIRE(scale.code_up(static_cast<double>(scale.metres[1]) / 2) == 1);
        REQUIRE(scale.code_up(infinity) == 255);
    });
}

TEST_CASE("a parent's least error is 1 + mu times its child's or more, and no error asks for none") {
    for_each_scale([](const ErrorScale& scale, double mu) {
        int below = 0, pairs = 0;
        for (std::uint32_t child = 0; child < 256 && scale.above(child) < 256; ++child, ++pairs)
            below += static_cast<double>(scale.metres[scale.above(child)]) <
                     (1 + mu) * static_cast<double>(scale.metres[child]);
        REQUIRE(below == 0);
        REQUIRE(pairs + static_cast<int>(scale.nesting_steps) == 256);
        REQUIRE(scale.above(0) == 0);
    });
}

TEST_CASE("radius codes begin with the level's unit, ascend, and leave the highest bit to holes") {
    const RadiusScale scale = RadiusScale::make();
    REQUIRE(scale.factor[0] == 1);
    REQUIRE(std::end(scale.factor) - std::begin(scale.factor) == void_bit);
    for (std::size_t code = 1; code < radius_codes; ++code) REQUIRE(scale.factor[code] > scale.factor[code - 1]);
    for (std::uint32_t radius = 0; radius < 256; ++radius)
        REQUIRE(is_void({0xffff, 0xff, static_cast<std::uint8_t>(radius)}) == (radius >= radius_codes));
}

TEST_CASE("a radius' code is the smallest that is not below it, in whatever unit") {
    const RadiusScale scale = RadiusScale::make();
    // Of short and long levels, and some that round in every product.
    for (const float unit_m : {1e-3f, 0.1f, 1.0f, 1.4142135f, 42.42f, 12345.678f, 1e8f}) {
        INFO("unit " << unit_m << " m");
        std::vector<double> codes;
        for (const float factor : scale.factor) codes.push_back(static_cast<double>(unit_m * factor));
        REQUIRE(std::adjacent_find(codes.begin(), codes.end(), std::greater_equal<>()) == codes.end());
        int wrong = 0;
        for (const double value : probes(codes)) wrong += scale.code_up(unit_m, value) != search(codes, value);
        REQUIRE(wrong == 0);
    }
}

TEST_CASE("a height step is one height, bit for bit, from whichever page's base it is counted") {
    for (const HeightScale height_scale :
         {HeightScale{0, 1}, {-431.7f, 0.1f}, {8848.86f, 0.0005f}, {-0.3f, 1e-6f}, {1e5f, 3.7f}})
        for (const std::int32_t steps :
             {0, 1, 3, 1000, 65535, 65536, 1234567, max_height_steps - 65535, max_height_steps - 1, max_height_steps}) {
            // Each operation rounded by itself to float: no fused multiply-add, no wider type in between.
            const volatile float count = static_cast<float>(steps);
            const volatile float above_base_m = count * height_scale.quantum_m;
            const volatile float expected_m = height_scale.base_m + above_base_m;
            REQUIRE(static_cast<std::int32_t>(count) == steps);
            int wrong = 0;
            for (std::int32_t offset = 0; offset <= std::min(steps, 65535); ++offset) {
                const std::int32_t base = steps - offset;
                const VertexRecord record{static_cast<std::uint16_t>(offset), 0, 0};
                wrong += height_scale.height_m(base + record.height) != expected_m;
            }
            REQUIRE(wrong == 0);
        }
}

TEST_CASE("more height steps are never less height") {
    for (const HeightScale height_scale : {HeightScale{0, 1}, {-431.7f, 0.1f}, {8848.86f, 0.0005f}}) {
        int falls = 0;
        for (std::int32_t steps = 1; steps <= max_height_steps; steps += steps < 65536 ? 1 : 4099)
            falls += height_scale.height_m(steps) < height_scale.height_m(steps - 1);
        REQUIRE(falls == 0);
    }
}
