// Memory of a bake: what buffers share, and what stores in memory begin with.
#include <algorithm>
#include <random>
#include <thread>
#include <vector>

#include <sys/resource.h>

#include <catch2/catch.hpp>

#include "baker/store/memory.h"
#include "support/rounds.h"

namespace {

using namespace fjell::baker;

constexpr std::size_t kb = 1024;

struct Taken {
    std::byte* at;
    std::size_t bytes;
    std::byte mark;
    [[nodiscard]] bool intact() const {
        return std::all_of(at, at + bytes, [&](std::byte b) { return b == mark; });
    }
};

// Takes and gives back at random, and looks whether anyone else has written to what it holds.
bool lives_alone(unsigned seed, int steps) {
    std::mt19937 random(seed);
    std::vector<Taken> held;
    bool intact = true;
    const auto give = [&](std::size_t i) {
        intact = intact && held[i].intact();
        give_kept(held[i].at);
        held[i] = held.back();
        held.pop_back();
    };
    for (int step = 0; step < steps; ++step) {
        if (held.size() < 12 && random() % 3 != 0) {
            const std::size_t bytes = least_kept_bytes + random() % (256 * kb);
            const auto mark = static_cast<std::byte>(random());
            held.push_back({take_kept(bytes), bytes, mark});
            std::fill_n(held.back().at, bytes, mark);
        } else if (!held.empty()) {
            give(random() % held.size());
        }
    }
    while (!held.empty()) give(held.size() - 1);
    return intact;
}

[[maybe_unused]] long faults() {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_minflt;
}

} // namespace

TEST_CASE("memory of buffers is one's own on any thread, and joined again when all of it is given back") {
    const std::size_t before = release_kept();
    std::vector<char> alone(4);
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < alone.size(); ++t)
        threads.emplace_back([&, t] { alone[t] = lives_alone(t, fjell::test::rounds(200, 2000)); });
    for (std::thread& thread : threads) thread.join();
    CHECK(std::count(alone.begin(), alone.end(), char{1}) == 4);
    CHECK(release_kept() == before); // a piece that had not been joined would hold its range
}

#ifndef FJELL_SANITIZED // where all memory is malloc's
TEST_CASE("a buffer takes what the last one of its size gave back, without a page of the system's") {
    constexpr std::size_t count = 1024 * kb;
    const auto work = [] {
        Buffer<std::int32_t> a(count), b(count / 2);
        std::fill(a.begin(), a.end(), 1);
        std::fill(b.begin(), b.end(), 2);
        return reinterpret_cast<std::uintptr_t>(a.data());
    };
    const std::uintptr_t first = work();
    const long before = faults();
    const std::uintptr_t second = work();
    const long more = faults() - before;
    CHECK(second == first);
    CHECK(more < 100); // 1,536 pages are touched; the system may have taken back a few
}
#endif

TEST_CASE("large buffers begin at multiples of 64 bytes, as vectors of instructions like them") {
    const Buffer<char> large(least_kept_bytes + 1), other(least_kept_bytes + 77);
    CHECK(reinterpret_cast<std::uintptr_t>(large.data()) % 64 == 0);
    CHECK(reinterpret_cast<std::uintptr_t>(other.data()) % 64 == 0);
}

TEST_CASE("memory of a store is zero at first, whoever had it before") {
    for (const std::size_t bytes : {std::size_t{1}, 100 * kb, 5000 * kb})
        for (int round = 0; round < 3; ++round) {
            const ZeroedMemory memory(bytes);
            REQUIRE(memory.size() == bytes);
            REQUIRE(std::all_of(memory.data(), memory.data() + bytes, [](std::byte b) { return b == std::byte{0}; }));
            std::fill_n(memory.data(), bytes, std::byte{255});
        }
    CHECK(ZeroedMemory(0).data() == nullptr);
}
