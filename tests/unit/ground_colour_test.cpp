// What layers make of the ground's colours on the CPU: what maps and rules say, and what stays as it is.
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "fjell/gl/ground_colour.h"
#include "fjell/texture.h"

using namespace fjell;

namespace {

// Materials of one colour each: grey blocks, and the records' means, which colours are multiples of.
struct FlatMaterials {
    std::vector<std::byte> blocks;
    io::Materials materials;

    FlatMaterials() {
        materials.side_log2 = 4;
        for (const auto& [name, r, g, b] : {std::tuple{"red", 0.5f, 0.1f, 0.1f}, {"blue", 0.1f, 0.1f, 0.5f}}) {
            io::MaterialRecord& record = materials.records.emplace_back();
            std::strcpy(record.name, name);
            record.mean[0] = r, record.mean[1] = g, record.mean[2] = b;
        }
        // BC3: alpha from two equal ends, and a colour of 5-6-5 bits that is the mean of every texel.
        for (std::uint32_t mip = 0; mip < materials.mips(); ++mip)
            for (const std::uint16_t colour : {std::uint16_t{0xbacb}, std::uint16_t{0x5ad7}})
                for (std::size_t block = 0; block < materials.mip_bytes(mip) / 16; ++block) {
                    std::array<std::uint8_t, 16> bytes{128, 128};
                    std::memcpy(&bytes[8], &colour, 2);
                    std::memcpy(&bytes[10], &colour, 2);
                    const auto* const first = reinterpret_cast<const std::byte*>(bytes.data());
                    blocks.insert(blocks.end(), first, first + bytes.size());
                }
        materials.colour = materials.normal = blocks;
    }
};

using Texels = std::array<std::uint8_t, 12>; // 2 x 2
constexpr Texels map_colours{40, 120, 60, 40, 120, 60, 40, 120, 60, 40, 120, 60};

std::array<std::byte, 32> splat_of(std::array<std::uint8_t, 8> texel) {
    std::array<std::byte, 32> splat;
    for (std::size_t i = 0; i < splat.size(); ++i) splat[i] = std::byte{texel[i % 8]};
    return splat;
}

struct Painted {
    bool done;
    Texels rgb;
};
Painted paint(const gl::GroundColour& ground, std::array<std::uint8_t, 8> splat) {
    const std::array<std::byte, 32> bytes = splat_of(splat);
    Painted painted{false, map_colours};
    gl::GroundTexels texels{2};
    texels.splat = bytes;
    texels.splat_side = 2;
    texels.rgb = painted.rgb;
    painted.done = ground.paint(texels);
    return painted;
}

bool near(const Texels& a, std::array<int, 3> b) {
    for (std::size_t i = 0; i < a.size(); ++i)
        if (std::abs(a[i] - b[i % 3]) > 3) return false;
    return true;
}

} // namespace

TEST_CASE("splat maps say what ground is painted with, and what stays as its map has it") {
    const FlatMaterials flat;
    const std::vector<std::string> names{"blue", "red"}; // not in the materials' order
    gl::GroundColour ground;
    ground.set(flat.materials, {}, names, {.tint = 0}, 1);
    // The colours that the blocks have.
    CHECK(near(paint(ground, {255, 1, 0, 0, 0, 0, 0, 0}).rgb, {189, 89, 90}));
    CHECK(near(paint(ground, {255, 0, 0, 0, 0, 0, 0, 0}).rgb, {90, 89, 189}));
    // What shows more lies over what shows less; a little of it does not show through.
    CHECK(near(paint(ground, {240, 1, 15, 0, 0, 0, 0, 0}).rgb, {189, 89, 90}));
    CHECK(paint(ground, {0, 0, 0, 0, 0, 0, 0, 0}).rgb == map_colours);
    // Half covered: half of the light of either.
    const Texels half = paint(ground, {128, 1, 0, 0, 0, 0, 0, 0}).rgb;
    CHECK(half[0] > 125);
    CHECK(half[0] < 150);
    CHECK(half[1] > 100);
    CHECK(half[1] < 112);
    // At tint 1 a material has its own light and shade, and the map's colour.
    ground.set(flat.materials, {}, names, {.tint = 1}, 1);
    const Texels tinted = paint(ground, {255, 1, 0, 0, 0, 0, 0, 0}).rgb;
    CHECK(tinted[1] > tinted[0]);
    CHECK(tinted[1] > tinted[2]);
}

TEST_CASE("water of a splat map keeps its map's colour, whatever the materials are") {
    const FlatMaterials flat;
    const std::vector<std::string> names{"water", "red"};
    gl::GroundColour ground;
    ground.set(flat.materials, {}, names, {.tint = 0}, 1);
    CHECK(paint(ground, {255, 0, 0, 0, 0, 0, 0, 0}).rgb == map_colours);
    CHECK(near(paint(ground, {255, 1, 0, 0, 0, 0, 0, 0}).rgb, {189, 89, 90}));
}

TEST_CASE("rules say what ground is painted with by its height and slope") {
    const FlatMaterials flat;
    const std::array rules{gl::LayerRule{.material = 0},
                           gl::LayerRule{.material = 1, .height_m = {100, gl::open_height_m}}};
    gl::GroundColour ground;
    ground.set(flat.materials, rules, {}, {.tint = 0}, 1);
    Texels rgb = map_colours;
    const std::array<float, 4> height_m{50, 50, 150, 150}, slope_deg{};
    REQUIRE(ground.paint({2, 0, 0, 1, 1, {}, 0, height_m, slope_deg, rgb}));
    CHECK(rgb[0] > rgb[2]); // red in the north
    CHECK(rgb[6] < rgb[8]); // blue in the south
}

TEST_CASE("what cannot be painted is refused, and nothing changes") {
    const FlatMaterials flat;
    const std::array rules{gl::LayerRule{}};
    gl::GroundColour ground;
    CHECK_FALSE(paint(ground, {255, 1, 0, 0, 0, 0, 0, 0}).done); // nothing was set
    const std::vector<std::string> names{"red", "moss"};
    CHECK_THROWS_WITH(ground.set(flat.materials, {}, names, {}, 1), Catch::Contains("\"moss\""));
    CHECK_THROWS_WITH(ground.set(flat.materials, rules, {}, {.tint = 2}, 1), Catch::Contains("LayerSettings::tint"));
    ground.set(flat.materials, rules, {}, {}, 1);
    Texels rgb = map_colours;
    const std::array<float, 4> four{};
    const std::array<std::byte, 24> splat{};
    CHECK_FALSE(ground.paint({2, 0, 0, 1, 1, {}, 0, std::span(four).first(3), four, rgb}));
    CHECK_FALSE(ground.paint({2, 0, 0, 1, 1, splat, 2, four, four, rgb}));
    CHECK_FALSE(ground.paint({3, 0, 0, 1, 1, {}, 0, four, four, rgb}));
    CHECK(rgb == map_colours);
}
