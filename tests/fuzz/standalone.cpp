// Runs a fuzz target without libFuzzer: every seed as it is, then ROUNDS mutations of random seeds, always the same
// ones. This is what `./dev test` runs under sanitizers; `./dev test --long` explores with libFuzzer.
//
// fuzz_X ROUNDS SEED_FILE...
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<std::uint8_t>;

void mutate(Bytes& bytes, std::mt19937& random) {
    const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
    for (std::size_t n = 1 + below(6); n > 0 && !bytes.empty(); --n) {
        const std::size_t at = below(10) < 7 ? below(bytes.size()) : below(std::min<std::size_t>(bytes.size(), 300));
        switch (below(6)) {
        case 0: bytes[at] ^= static_cast<std::uint8_t>(1u << below(8)); break;
        case 1: bytes[at] = static_cast<std::uint8_t>(below(256)); break;
        case 2: bytes[at] = below(2) ? 0xff : 0; break;
        case 3: bytes.resize(at); break;
        case 4:
            bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint8_t>(below(256)));
            break;
        case 5: bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at)); break;
        }
    }
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 3) return std::fprintf(stderr, "usage: %s ROUNDS SEED_FILE...\n", argv[0]), 2;
    std::vector<Bytes> seeds;
    for (int i = 2; i < argc; ++i) {
        std::ifstream file(argv[i], std::ios::binary);
        seeds.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
        if (seeds.back().empty()) return std::fprintf(stderr, "%s: no such seed, or empty\n", argv[i]), 2;
        (void)LLVMFuzzerTestOneInput(seeds.back().data(), seeds.back().size());
    }
    std::mt19937 random(1);
    const long rounds = std::strtol(argv[1], nullptr, 10);
    for (long round = 0; round < rounds; ++round) {
        Bytes bytes = seeds[static_cast<std::size_t>(round) % seeds.size()];
        mutate(bytes, random);
        (void)LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    }
    std::printf("%zu seeds, %ld mutations: nothing broke\n", seeds.size(), rounds);
    return 0;
}
