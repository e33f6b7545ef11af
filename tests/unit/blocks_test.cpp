// Block compression: how far a texel may be off, whatever the block.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include <stb_dxt.h>

#include "fjell/texture.h"
#include "shared/block_codes.h"

using namespace fjell;

namespace {

// One row of blocks, planar, `channels` of them.
struct Strip {
    std::size_t blocks;
    std::vector<std::uint8_t> plane[3];

    explicit Strip(std::size_t count) : blocks(count) {
        for (auto& p : plane) p.resize(count * 16);
    }
    std::uint8_t& at(std::size_t c, std::size_t x, std::size_t y) { return plane[c][y * blocks * 4 + x]; }
    [[nodiscard]] std::vector<std::byte> bc1() const {
        ColourRows rows{};
        for (std::size_t y = 0; y < 4; ++y)
            for (std::size_t c = 0; c < 3; ++c) rows.rows[y][c] = plane[c].data() + y * blocks * 4;
        std::vector<std::byte> to(blocks * colour_block_bytes);
        encode_bc1(rows, blocks, to.data());
        return to;
    }
    [[nodiscard]] std::vector<std::byte> bc5() const {
        NormalRows rows{};
        for (std::size_t y = 0; y < 4; ++y)
            for (std::size_t c = 0; c < 2; ++c) rows.rows[y][c] = plane[c].data() + y * blocks * 4;
        std::vector<std::byte> to(blocks * normal_block_bytes);
        encode_bc5(rows, blocks, to.data());
        return to;
    }
};

// Decodes one block to 16 texels.
std::vector<std::uint8_t> colours(const std::vector<std::byte>& bytes, std::size_t block) {
    std::vector<std::uint8_t> rgb(48);
    (void)decode_colour(std::span(bytes).subspan(block * 8, 8), 4, rgb);
    return rgb;
}
std::vector<std::uint8_t> normals(const std::vector<std::byte>& bytes, std::size_t block) {
    std::vector<std::uint8_t> xz(32);
    (void)decode_normal(std::span(bytes).subspan(block * 16, 16), 4, xz);
    return xz;
}

Strip noise(std::size_t blocks, int amplitude, unsigned seed) {
    Strip s(blocks);
    std::mt19937 random(seed);
    for (std::size_t b = 0; b < blocks; ++b)
        for (std::size_t c = 0; c < 3; ++c) {
            const int base = static_cast<int>(random() % 256);
            for (std::size_t i = 0; i < 16; ++i)
                s.at(c, 4 * b + i % 4, i / 4) = static_cast<std::uint8_t>(std::clamp(
                    base + static_cast<int>(random() % static_cast<unsigned>(2 * amplitude + 1)) - amplitude, 0, 255));
        }
    return s;
}

} // namespace

TEST_CASE("a normal's code is off by at most a fourteenth of its block's range, and a rounding") {
    for (const int amplitude : {0, 1, 3, 20, 127, 255}) {
        Strip s = noise(101, amplitude, 5);
        const auto bytes = s.bc5();
        for (std::size_t b = 0; b < s.blocks; ++b) {
            const auto xz = normals(bytes, b);
            for (std::size_t c = 0; c < 2; ++c) {
                int low = 255, high = 0;
                for (std::size_t i = 0; i < 16; ++i) {
                    low = std::min<int>(low, s.at(c, 4 * b + i % 4, i / 4));
                    high = std::max<int>(high, s.at(c, 4 * b + i % 4, i / 4));
                }
                for (std::size_t i = 0; i < 16; ++i)
                    REQUIRE(std::abs(xz[2 * i + c] - s.at(c, 4 * b + i % 4, i / 4)) <= (high - low) / 14.0 + 0.5);
            }
        }
    }
}

TEST_CASE("a block of one colour is off by two codes at most, as are its neighbours in a strip") {
    std::mt19937 random(3);
    Strip s(256);
    for (std::size_t b = 0; b < 256; ++b)
        for (std::size_t c = 0; c < 3; ++c) {
            const auto v = static_cast<std::uint8_t>(c == 0 ? b : random() % 256);
            for (std::size_t i = 0; i < 16; ++i) s.at(c, 4 * b + i % 4, i / 4) = v;
        }
    const auto bytes = s.bc1();
    for (std::size_t b = 0; b < 256; ++b) {
        const auto rgb = colours(bytes, b);
        for (std::size_t i = 0; i < 48; ++i) REQUIRE(std::abs(rgb[i] - s.at(i % 3, 4 * b, 0)) <= 2);
    }
}

TEST_CASE("a block does not depend on those beside it") {
    const Strip all = noise(77, 30, 9);
    const auto bc1 = all.bc1(), bc5 = all.bc5();
    for (const std::size_t b : {0u, 31u, 32u, 76u}) {
        Strip one(1);
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t i = 0; i < 16; ++i) one.at(c, i % 4, i / 4) = all.plane[c][i / 4 * 77 * 4 + 4 * b + i % 4];
        CHECK(std::memcmp(one.bc1().data(), bc1.data() + 8 * b, 8) == 0);
        CHECK(std::memcmp(one.bc5().data(), bc5.data() + 16 * b, 16) == 0);
    }
}

TEST_CASE("colours lose no more than with libstb's slower encoder, on average") {
    for (const int amplitude : {2, 10, 60}) {
        const Strip s = noise(2000, amplitude, 12);
        const auto ours = s.bc1();
        double our_error = 0, their_error = 0;
        for (std::size_t b = 0; b < s.blocks; ++b) {
            std::uint8_t rgba[64], theirs[8];
            for (std::size_t i = 0; i < 64; ++i)
                rgba[i] = i % 4 == 3 ? 255 : s.plane[i % 4][i / 16 * s.blocks * 4 + 4 * b + i / 4 % 4];
            stb_compress_dxt_block(theirs, rgba, 0, STB_DXT_NORMAL);
            std::vector<std::byte> bytes(8);
            std::memcpy(bytes.data(), theirs, 8);
            const auto a = colours(ours, b), t = colours(bytes, 0);
            for (std::size_t i = 0; i < 48; ++i) {
                const int v = rgba[i / 3 * 4 + i % 3];
                our_error += (a[i] - v) * (a[i] - v);
                their_error += (t[i] - v) * (t[i] - v);
            }
        }
        CHECK(our_error <= 1.02 * their_error);
    }
}

TEST_CASE("decoders follow the formats' definitions") {
    // Two colours and the thirds between; three and black when the first word is not the larger.
    const auto block = [](std::initializer_list<int> list) {
        std::vector<std::byte> bytes;
        for (const int v : list) bytes.push_back(static_cast<std::byte>(v));
        return bytes;
    };
    const auto first = [](const std::vector<std::uint8_t>& v, std::size_t n) {
        return std::vector<int>(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(n));
    };
    // 0xf800 red, 0x001f blue; codes 0, 1, 2, 3.
    CHECK(first(colours(block({0x00, 0xf8, 0x1f, 0x00, 0b11100100, 0, 0, 0}), 0), 12) ==
          std::vector<int>{255, 0, 0, 0, 0, 255, 170, 0, 85, 85, 0, 170});
    CHECK(first(colours(block({0x1f, 0x00, 0x00, 0xf8, 0b11100100, 0, 0, 0}), 0), 12) ==
          std::vector<int>{0, 0, 255, 255, 0, 0, 127, 0, 127, 0, 0, 0});
    // Codes 0..7 in 3 bits each: 0b111'110'101'100'011'010'001'000.
    const auto eight = normals(block({240, 100, 0x88, 0xc6, 0xfa, 0, 0, 0, 100, 240, 0x88, 0xc6, 0xfa, 0, 0, 0}), 0);
    CHECK(first(eight, 16) ==
          std::vector<int>{240, 100, 100, 240, 220, 128, 200, 156, 180, 184, 160, 212, 140, 0, 120, 255});
    CHECK(normal_component(128) == 0);
    CHECK(normal_component(255) == 1);
    CHECK(normal_component(1) == -1);
    CHECK(normal_component(0) == -1);
}
