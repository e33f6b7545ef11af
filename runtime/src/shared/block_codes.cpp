// BC1. Colours of a block lie close to a line: its direction is the principal axis of their covariance (power iteration
// from the covariance's column of most variance, which is never at right angles to it), its ends the outermost
// projections. With the texels' indices k / 3 known, the ends that minimise the squared error solve
//     | sum (3-k)^2   sum k(3-k) | |a|       | sum (3-k) p |
//     | sum k(3-k)    sum k^2    | |b| = 3 * | sum k p     |
// Rounded to 5-6-5 bits they may miss a nearly constant block by 4 codes where its colour has an end-point pair whose
// two-to-one mix is within 1; so that is the other candidate, and the one with less squared error is stored.
//
// BC5's halves. The extremes of a block are its end points, six values lie between at equal distances: the nearest is
// within 1/14 of the range, and rounding to bytes adds a half.
#include "shared/block_codes.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <type_traits>

#include "shared/compiler.h"

namespace fjell {

namespace {

constexpr std::size_t lanes = 32;
using Floats = float[lanes];
using Ints = std::int32_t[lanes];
using Words = std::uint32_t[lanes];

// Texels 0..3 of a row of each block, one block a lane: four bytes of a word, the lowest first.
template <typename Lanes>
FJELL_ALWAYS_INLINE inline void split_row(const std::uint8_t* row, std::size_t blocks, Lanes& a, Lanes& b, Lanes& c,
                                          Lanes& d) {
    for (std::size_t l = 0; l < blocks; ++l) {
        std::int32_t word;
        std::memcpy(&word, row + 4 * l, sizeof word);
        a[l] = static_cast<std::remove_extent_t<Lanes>>(word & 0xff);
        b[l] = static_cast<std::remove_extent_t<Lanes>>(word >> 8 & 0xff);
        c[l] = static_cast<std::remove_extent_t<Lanes>>(word >> 16 & 0xff);
        d[l] = static_cast<std::remove_extent_t<Lanes>>(word >> 24 & 0xff);
    }
}

// ---- BC1 ---------------------------------------------------------------------------------------------------------

struct Colours {
    Floats p[16][3];
    Floats mean[3];
    Floats axis[3];
    Floats ends[2][3]; // the low one first; 0..255, later quantised to what a reader sees
    Ints packed[2];    // 5-6-5
    Floats index[16];  // 0..3 from the low end
    Floats spread;     // squared distances from the mean
    Floats error;
    Words codes; // of the low end 0, then 2, 3, and 1 of the high one
};

FJELL_CLONES void split_colours(const std::uint8_t* row, std::size_t blocks, std::size_t c, Floats (*to)[3]) {
    split_row(row, blocks, to[0][c], to[1][c], to[2][c], to[3][c]);
}

FJELL_CLONES void find_mean(Colours& s) {
    for (int c = 0; c < 3; ++c) {
        for (std::size_t l = 0; l < lanes; ++l) s.mean[c][l] = 0;
        for (int i = 0; i < 16; ++i)
            for (std::size_t l = 0; l < lanes; ++l) s.mean[c][l] += s.p[i][c][l];
        for (std::size_t l = 0; l < lanes; ++l) s.mean[c][l] *= 0.0625f;
    }
}

FJELL_CLONES void find_axis(Colours& s) {
    Floats rr = {}, rg = {}, rb = {}, gg = {}, gb = {}, bb = {};
    for (int i = 0; i < 16; ++i)
        for (std::size_t l = 0; l < lanes; ++l) {
            const float r = s.p[i][0][l] - s.mean[0][l], g = s.p[i][1][l] - s.mean[1][l],
                        b = s.p[i][2][l] - s.mean[2][l];
            rr[l] += r * r, rg[l] += r * g, rb[l] += r * b, gg[l] += g * g, gb[l] += g * b, bb[l] += b * b;
        }
    for (std::size_t l = 0; l < lanes; ++l) {
        s.spread[l] = rr[l] + gg[l] + bb[l];
        float x = gg[l] >= bb[l] ? rg[l] : rb[l], y = gg[l] >= bb[l] ? gg[l] : gb[l],
              z = gg[l] >= bb[l] ? gb[l] : bb[l];
        const float second = gg[l] >= bb[l] ? gg[l] : bb[l];
        x = rr[l] >= second ? rr[l] : x, y = rr[l] >= second ? rg[l] : y, z = rr[l] >= second ? rb[l] : z;
        s.axis[0][l] = x, s.axis[1][l] = y, s.axis[2][l] = z;
    }
    for (int round = 0; round < 3; ++round)
        for (std::size_t l = 0; l < lanes; ++l) {
            const float x = s.axis[0][l], y = s.axis[1][l], z = s.axis[2][l];
            const float u = rr[l] * x + rg[l] * y + rb[l] * z, v = rg[l] * x + gg[l] * y + gb[l] * z,
                        w = rb[l] * x + gb[l] * y + bb[l] * z;
            const float scale = 1 / (std::abs(u) + std::abs(v) + std::abs(w) + 1e-20f);
            s.axis[0][l] = u * scale, s.axis[1][l] = v * scale, s.axis[2][l] = w * scale;
        }
}

FJELL_CLONES void find_ends(Colours& s) {
    Floats low, high;
    for (std::size_t l = 0; l < lanes; ++l) low[l] = high[l] = 0; // the mean lies between
    for (int i = 0; i < 16; ++i)
        for (std::size_t l = 0; l < lanes; ++l) {
            const float t = (s.p[i][0][l] - s.mean[0][l]) * s.axis[0][l] +
                            (s.p[i][1][l] - s.mean[1][l]) * s.axis[1][l] + (s.p[i][2][l] - s.mean[2][l]) * s.axis[2][l];
            s.index[i][l] = t;
            low[l] = t < low[l] ? t : low[l];
            high[l] = t > high[l] ? t : high[l];
        }
    for (std::size_t l = 0; l < lanes; ++l) {
        const float length = s.axis[0][l] * s.axis[0][l] + s.axis[1][l] * s.axis[1][l] + s.axis[2][l] * s.axis[2][l];
        const float per = length > 0 ? 1 / length : 0;
        for (int c = 0; c < 3; ++c) {
            s.ends[0][c][l] = s.mean[c][l] + s.axis[c][l] * (low[l] * per);
            s.ends[1][c][l] = s.mean[c][l] + s.axis[c][l] * (high[l] * per);
        }
        high[l] = high[l] > low[l] ? 3 / (high[l] - low[l]) : 0;
    }
    for (int i = 0; i < 16; ++i)
        for (std::size_t l = 0; l < lanes; ++l)
            s.index[i][l] = static_cast<float>(nearest<std::int32_t>((s.index[i][l] - low[l]) * high[l]));
}

FJELL_CLONES void improve_ends(Colours& s) {
    Floats aa = {}, ab = {}, bb = {}, x[3] = {}, y[3] = {};
    for (int i = 0; i < 16; ++i)
        for (std::size_t l = 0; l < lanes; ++l) {
            const float k = s.index[i][l], j = 3 - k, r = s.p[i][0][l], g = s.p[i][1][l], b = s.p[i][2][l];
            aa[l] += j * j, ab[l] += j * k, bb[l] += k * k;
            x[0][l] += j * r, x[1][l] += j * g, x[2][l] += j * b;
            y[0][l] += k * r, y[1][l] += k * g, y[2][l] += k * b;
        }
    for (int c = 0; c < 3; ++c)
        for (std::size_t l = 0; l < lanes; ++l) {
            const float determinant = aa[l] * bb[l] - ab[l] * ab[l]; // whole numbers: 0 when all indices are the same
            const float per = 3 / (determinant > 0 ? determinant : 1);
            const float a = (bb[l] * x[c][l] - ab[l] * y[c][l]) * per, b = (aa[l] * y[c][l] - ab[l] * x[c][l]) * per;
            s.ends[0][c][l] = determinant > 0 ? a : s.ends[0][c][l];
            s.ends[1][c][l] = determinant > 0 ? b : s.ends[1][c][l];
        }
}

FJELL_CLONES void quantise_ends(Colours& s) {
    for (int e = 0; e < 2; ++e)
        for (int c = 0; c < 3; ++c) {
            const int shift = c == 1 ? 2 : 3, down = c == 1 ? 4 : 2, place = c == 0 ? 11 : c == 1 ? 5 : 0;
            const float per = c == 1 ? 63.0f / 255 : 31.0f / 255;
            for (std::size_t l = 0; l < lanes; ++l) {
                float v = s.ends[e][c][l];
                v = v < 0 ? 0 : v;
                v = v > 255 ? 255 : v;
                const auto q = nearest<std::int32_t>(v * per);
                s.packed[e][l] = c == 0 ? q << place : s.packed[e][l] | q << place;
                s.ends[e][c][l] = static_cast<float>(q << shift | q >> down);
            }
        }
}

// Indices for the quantised ends, and the squared error they leave.
FJELL_CLONES void choose_indices(Colours& s) {
    Floats q[3], per;
    for (std::size_t l = 0; l < lanes; ++l) {
        for (int c = 0; c < 3; ++c) q[c][l] = s.ends[1][c][l] - s.ends[0][c][l];
        const float length = q[0][l] * q[0][l] + q[1][l] * q[1][l] + q[2][l] * q[2][l];
        per[l] = 3 / (length > 0 ? length : 1); // without length every projection is 0
        s.error[l] = 0;
        s.codes[l] = 0;
    }
    for (int i = 0; i < 16; ++i)
        for (std::size_t l = 0; l < lanes; ++l) {
            const float a = s.p[i][0][l] - s.ends[0][0][l], b = s.p[i][1][l] - s.ends[0][1][l],
                        c = s.p[i][2][l] - s.ends[0][2][l];
            float t = (a * q[0][l] + b * q[1][l] + c * q[2][l]) * per[l];
            t = t < 0 ? 0 : t;
            t = t > 3 ? 3 : t;
            const auto k = nearest<std::int32_t>(t);
            const float part = static_cast<float>(k) * (1.0f / 3);
            const float u = a - q[0][l] * part, v = b - q[1][l] * part, w = c - q[2][l] * part;
            s.error[l] += u * u + v * v + w * w;
            const std::int32_t code = k == 0 ? 0 : k == 3 ? 1 : k + 1;
            s.codes[l] |= static_cast<std::uint32_t>(code) << (2 * i);
        }
}

// For each 8-bit value the two codes whose two-to-one mix, as readers compute it, is nearest; of these the closest
// pair.
struct Mixes {
    struct Pair {
        std::uint8_t heavy = 0, light = 0, value = 0;
    };
    std::array<Pair, 256> of5, of6;

    Mixes() : of5(make(5)), of6(make(6)) {}
    static std::array<Pair, 256> make(int bits) {
        std::array<Pair, 256> all;
        const auto expand = [&](int q) { return bits == 5 ? q << 3 | q >> 2 : q << 2 | q >> 4; };
        for (int v = 0; v < 256; ++v) {
            int best = 1 << 20;
            for (int a = 0; a < 1 << bits; ++a)
                for (int b = std::max(a - 3, 0); b < std::min(a + 4, 1 << bits); ++b) {
                    const int mixed = (2 * expand(a) + expand(b)) / 3;
                    const int cost = std::abs(mixed - v) * 16 + std::abs(a - b);
                    if (cost >= best) continue;
                    best = cost;
                    all[static_cast<std::size_t>(v)] = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b),
                                                        static_cast<std::uint8_t>(mixed)};
                }
        }
        return all;
    }
};

// Squared error of one colour for the whole block: the spread around the mean and 16 |mean - value|^2.
void try_one_colour(Colours& s, std::size_t l) {
    static const Mixes mixes;
    const Mixes::Pair* pair[3];
    float error = s.spread[l];
    for (int c = 0; c < 3; ++c) {
        pair[c] = &(c == 1 ? mixes.of6 : mixes.of5)[nearest<std::size_t>(s.mean[c][l])];
        const float off = s.mean[c][l] - static_cast<float>(pair[c]->value);
        error += 16 * off * off;
    }
    if (error >= s.error[l]) return;
    s.packed[0][l] = pair[0]->heavy << 11 | pair[1]->heavy << 5 | pair[2]->heavy;
    s.packed[1][l] = pair[0]->light << 11 | pair[1]->light << 5 | pair[2]->light;
    s.codes[l] = 0xaaaa'aaaau; // everywhere two parts of the first
}

// The larger word first, which tells readers that there are four colours; codes are 0, 2, 3, 1 from the first.
void store_colours(const Colours& s, std::size_t blocks, std::byte* to) {
    for (std::size_t l = 0; l < blocks; ++l, to += 8) {
        auto a = static_cast<std::uint16_t>(s.packed[0][l]), b = static_cast<std::uint16_t>(s.packed[1][l]);
        std::uint32_t codes = s.codes[l];
        if (a < b) {
            std::swap(a, b);
            codes ^= 0x5555'5555u;
        }
        if (a == b) codes = 0;
        std::memcpy(to, &a, 2);
        std::memcpy(to + 2, &b, 2);
        std::memcpy(to + 4, &codes, 4);
    }
}

// ---- BC5 and BC4
// ---------------------------------------------------------------------------------------------------------

FJELL_CLONES void split_values(const std::uint8_t* row, std::size_t blocks, Ints* to) {
    split_row(row, blocks, to[0], to[1], to[2], to[3]);
}

FJELL_CLONES void encode_values(const Ints (&p)[16], Ints& low, Ints& high, Words (&codes)[2]) {
    Floats per;
    for (std::size_t l = 0; l < lanes; ++l) {
        low[l] = high[l] = p[0][l];
        codes[0][l] = codes[1][l] = 0;
    }
    for (int i = 1; i < 16; ++i)
        for (std::size_t l = 0; l < lanes; ++l) {
            low[l] = p[i][l] < low[l] ? p[i][l] : low[l];
            high[l] = p[i][l] > high[l] ? p[i][l] : high[l];
        }
    for (std::size_t l = 0; l < lanes; ++l) per[l] = high[l] > low[l] ? 7 / static_cast<float>(high[l] - low[l]) : 0;
    for (int i = 0; i < 16; ++i)
        for (std::size_t l = 0; l < lanes; ++l) {
            const auto k = nearest<std::int32_t>(static_cast<float>(p[i][l] - low[l]) * per[l]);
            // From the low end 0..7 to the stored order: high, low, then down from the high end.
            const std::int32_t code = k == 0 ? 1 : (8 - k) & 7;
            const std::int32_t stored = k == 7 ? 0 : code;
            codes[i / 8][l] |= static_cast<std::uint32_t>(stored) << (3 * (i % 8));
        }
}

// stride: bytes from block to block.
void store_values(const Ints& low, const Ints& high, const Words (&codes)[2], std::size_t blocks, std::size_t stride,
                  std::byte* to) {
    for (std::size_t l = 0; l < blocks; ++l, to += stride) {
        // All indices are 1 where both ends are the same: also right.
        const std::uint64_t word = static_cast<std::uint64_t>(high[l]) | static_cast<std::uint64_t>(low[l]) << 8 |
                                   static_cast<std::uint64_t>(codes[0][l]) << 16 |
                                   static_cast<std::uint64_t>(codes[1][l]) << 40;
        std::memcpy(to, &word, 8);
    }
}

} // namespace

void encode_bc1(const ColourRows& from, std::size_t blocks, std::byte* to) {
    Colours s{};
    for (std::size_t first = 0; first < blocks; first += lanes) {
        const std::size_t count = std::min(lanes, blocks - first);
        for (std::size_t i = 0; i < 16; i += 4)
            for (std::size_t c = 0; c < 3; ++c) split_colours(from.rows[i / 4][c] + 4 * first, count, c, &s.p[i]);
        find_mean(s);
        find_axis(s);
        find_ends(s);
        improve_ends(s);
        quantise_ends(s);
        choose_indices(s);
        for (std::size_t l = 0; l < count; ++l) try_one_colour(s, l);
        store_colours(s, count, to + 8 * first);
    }
}

void encode_bc5(const NormalRows& from, std::size_t blocks, std::byte* to) {
    Ints p[16] = {}, low, high;
    Words codes[2];
    for (std::size_t first = 0; first < blocks; first += lanes) {
        const std::size_t count = std::min(lanes, blocks - first);
        for (std::size_t c = 0; c < 2; ++c) {
            for (std::size_t i = 0; i < 16; i += 4) split_values(from.rows[i / 4][c] + 4 * first, count, p + i);
            encode_values(p, low, high, codes);
            store_values(low, high, codes, count, 16, to + 16 * first + 8 * c);
        }
    }
}

void encode_bc4(const std::uint8_t* const (&rows)[4], std::size_t blocks, std::byte* to) {
    Ints p[16] = {}, low, high;
    Words codes[2];
    for (std::size_t first = 0; first < blocks; first += lanes) {
        const std::size_t count = std::min(lanes, blocks - first);
        for (std::size_t i = 0; i < 16; i += 4) split_values(rows[i / 4] + 4 * first, count, p + i);
        encode_values(p, low, high, codes);
        store_values(low, high, codes, count, 8, to + 8 * first);
    }
}

} // namespace fjell
