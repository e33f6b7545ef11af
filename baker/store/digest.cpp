#include "baker/store/digest.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "compiler.h"

namespace fjell::baker {

namespace {

// The last steps of splitmix64: every bit of the argument moves about half of the result's.
constexpr std::uint64_t scrambled(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

constexpr std::size_t block_words = 256;
constexpr std::array<std::uint64_t, block_words> in_block = [] {
    std::array<std::uint64_t, block_words> all{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = scrambled(i) << 1;
    return all;
}();

std::uint64_t word_at(const std::byte* bytes) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes, sizeof word);
    return word;
}

// Words of one block from its first on; odd factors, or a word's highest bit would not count.
void add_words(std::uint64_t block, std::size_t first, std::span<const std::byte> bytes, Digest& sum) {
    const std::uint64_t factor = scrambled(~block) | 1;
    Digest part;
    for (std::size_t i = 0; i < bytes.size() / 8; ++i) {
        const std::uint64_t word = word_at(bytes.data() + 8 * i), by = factor + in_block[first + i];
        part.forwards += word * by;
        part.backwards += byte_swapped(word) * by;
    }
    sum += part;
}

} // namespace

Digest digest_of(std::uint64_t offset, std::span<const std::byte> bytes) {
    Digest sum;
    while (!bytes.empty()) {
        const std::uint64_t block = offset / 8 / block_words;
        const std::size_t word = offset / 8 % block_words, within = offset % 8;
        std::size_t taken = std::min(bytes.size(), (block_words - word) * 8) / 8 * 8;
        if (within != 0 || taken == 0) { // a part of a word: the rest of it is another piece's
            std::array<std::byte, 8> padded{};
            taken = std::min(bytes.size(), 8 - within);
            std::copy_n(bytes.begin(), taken, padded.begin() + static_cast<std::ptrdiff_t>(within));
            add_words(block, word, padded, sum);
        } else {
            add_words(block, word, bytes.first(taken), sum);
        }
        bytes = bytes.subspan(taken);
        offset += taken;
    }
    return sum;
}

} // namespace fjell::baker
