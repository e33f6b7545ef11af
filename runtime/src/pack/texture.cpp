#include "fjell/texture.h"

#include <bit>
#include <cstring>

#include "fjell/pack.h"

namespace fjell {

namespace {

template <typename T>
T load(const std::byte* from) {
    T value;
    std::memcpy(&value, from, sizeof value);
    return value;
}

struct Rgb {
    std::uint8_t c[3];
};

// 5 or 6 bits to 8: the highest ones again below.
Rgb expand(std::uint32_t c) {
    const std::uint32_t r = c >> 11, g = (c >> 5) & 63, b = c & 31;
    return {{static_cast<std::uint8_t>(r << 3 | r >> 2), static_cast<std::uint8_t>(g << 2 | g >> 4),
             static_cast<std::uint8_t>(b << 3 | b >> 2)}};
}

void colours_of(const std::byte* block, Rgb (&palette)[4]) {
    const std::uint32_t first = load<std::uint16_t>(block), second = load<std::uint16_t>(block + 2);
    const Rgb a = palette[0] = expand(first), b = palette[1] = expand(second);
    for (int c = 0; c < 3; ++c) {
        const int p = a.c[c], q = b.c[c];
        palette[2].c[c] = static_cast<std::uint8_t>(first > second ? (2 * p + q) / 3 : (p + q) / 2);
        palette[3].c[c] = static_cast<std::uint8_t>(first > second ? (p + 2 * q) / 3 : 0);
    }
}

void values_of(const std::byte* block, std::uint8_t (&palette)[8]) {
    const int a = palette[0] = load<std::uint8_t>(block), b = palette[1] = load<std::uint8_t>(block + 1);
    palette[6] = 0;
    palette[7] = 255;
    const int parts = a > b ? 7 : 5;
    for (int i = 1; i < parts; ++i) // to the nearest
        palette[i + 1] = static_cast<std::uint8_t>((2 * ((parts - i) * a + i * b) + parts) / (2 * parts));
}

Status check(std::uint32_t side, std::size_t stored, std::size_t block_bytes, std::size_t texels,
             std::size_t texel_bytes) {
    if (side < 4 || side > 1u << max_texture_log2 || !std::has_single_bit(side))
        return {StatusCode::out_of_range, "side"};
    if (stored != blocks_of(side) * block_bytes) return {StatusCode::out_of_range, "blocks"};
    if (texels != std::size_t{side} * side * texel_bytes) return {StatusCode::out_of_range, "texels"};
    return {};
}

} // namespace

Status decode_colour(std::span<const std::byte> blocks, std::uint32_t side, std::span<std::uint8_t> rgb) {
    if (Status s = check(side, blocks.size(), colour_block_bytes, rgb.size(), 3); !s.ok()) return s;
    const std::byte* block = blocks.data();
    for (std::uint32_t y = 0; y < side; y += 4)
        for (std::uint32_t x = 0; x < side; x += 4, block += colour_block_bytes) {
            Rgb palette[4];
            colours_of(block, palette);
            const auto codes = load<std::uint32_t>(block + 4);
            for (std::uint32_t i = 0; i < 16; ++i)
                std::memcpy(&rgb[((y + i / 4) * std::size_t{side} + x + i % 4) * 3], palette[(codes >> 2 * i) & 3].c,
                            3);
        }
    return {};
}

Status decode_normal(std::span<const std::byte> blocks, std::uint32_t side, std::span<std::uint8_t> xz) {
    if (Status s = check(side, blocks.size(), normal_block_bytes, xz.size(), 2); !s.ok()) return s;
    const std::byte* block = blocks.data();
    for (std::uint32_t y = 0; y < side; y += 4)
        for (std::uint32_t x = 0; x < side; x += 4)
            for (std::uint32_t part = 0; part < 2; ++part, block += 8) {
                std::uint8_t palette[8];
                values_of(block, palette);
                const std::uint64_t codes = load<std::uint64_t>(block) >> 16;
                for (std::uint32_t i = 0; i < 16; ++i)
                    xz[((y + i / 4) * std::size_t{side} + x + i % 4) * 2 + part] = palette[(codes >> 3 * i) & 7];
            }
    return {};
}

Status decode_horizon(std::span<const std::byte> blocks, std::uint32_t side, std::span<std::uint8_t> codes) {
    if (Status s = check(side, blocks.size(), horizon_block_bytes, codes.size(), horizon_planes); !s.ok()) return s;
    const std::byte* block = blocks.data();
    for (std::uint32_t y = 0; y < horizon_planes_across * side; y += 4)
        for (std::uint32_t x = 0; x < horizon_planes_across * side; x += 4, block += 8) {
            const std::uint32_t plane = y / side * horizon_planes_across + x / side;
            std::uint8_t palette[8];
            values_of(block, palette);
            const std::uint64_t stored = load<std::uint64_t>(block) >> 16;
            for (std::uint32_t i = 0; i < 16; ++i) {
                const std::size_t texel = (y % side + i / 4) * std::size_t{side} + x % side + i % 4;
                codes[texel * horizon_planes + plane] = palette[(stored >> 3 * i) & 7];
            }
        }
    return {};
}

} // namespace fjell
