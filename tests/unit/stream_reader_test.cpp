// Our I/O thread on a real stream: what it hands in is the pack, whatever reads do, and it stops at any moment.
#include <catch2/catch.hpp>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <optional>
#include <thread>

#include "fjell/io/stream_reader.h"
#include "shared/terrain_data.h"
#include "support/patience.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

struct Scene {
    explicit Scene(std::uint32_t seed, std::uint32_t page_slots = 1u << 20, const StreamBudget& budget = {})
        : pack(make(seed)), file(pack.path), on(pack.pack, page_slots, budget) {}
    io::LoadedPack make(std::uint32_t seed) {
        Random random(seed);
        baker::BakeOptions options = small_bake(7);
        (void)baker::bake(random_dem(random, 513, 385, Shape::fractal), options, folder / "pack.fjell");
        return io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes);
    }
    // One frame: a view from above at a threshold that wants every page; none lies beyond the rim.
    StreamReport update() {
        const View view = view_from_above(pack.terrain, 1);
        CutSettings cut;
        cut.max_error_px = 0.001;
        StreamSettings settings;
        settings.now_s = 0.01 * ++frame;
        const StreamReport report = on.update({&view, 1}, cut, settings);
        for (const StreamFailure& f : stream_failures(on.stream)) failures.push_back(f);
        return report;
    }
    // Until the stream has all that it wants, or nothing more can come.
    StreamReport settle() {
        for (;;) {
            const StreamReport r = update();
            if (r.converged && r.maps_converged) return r;
            if (r.in_flight == 0 && r.pages_left == 0 && r.mips_left == 0 && r.pages_inserted == 0 &&
                r.mips_uploaded == 0 && r.pages_evicting == 0 && ++quiet > 2)
                return r;
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
    }
    [[nodiscard]] std::uint64_t wrong_pages() const {
        std::uint64_t wrong = 0;
        const TerrainData &a = data_of(on.paged.terrain), &b = data_of(pack.terrain);
        for (std::uint32_t page = 0; page < a.page_count(); ++page) {
            const PageEntry p = a.page_table[page], q = b.page_table[page];
            if (p.slot == no_index) continue;
            const std::size_t bytes = a.pages.page_vertices(page % a.pages_per_tile) * sizeof(VertexRecord);
            wrong += p.base != q.base || std::memcmp(a.records + std::size_t{p.slot} * a.page_capacity,
                                                     b.records + std::size_t{q.slot} * b.page_capacity, bytes) != 0;
        }
        return wrong;
    }

    TemporaryFolder folder;
    io::LoadedPack pack;
    io::PackFile file;
    Streamed on;
    std::vector<StreamFailure> failures;
    int frame = 0, quiet = 0;
};

} // namespace

TEST_CASE("what is wanted comes, as it is in the pack, and is counted") {
    Scene scene(1);
    const io::StreamReader reader(scene.on.stream, scene.file);
    const StreamReport r = scene.settle();
    CHECK(r.converged);
    CHECK(r.failed == 0);
    CHECK(scene.on.paged.terrain.pages_missing() == 0);
    CHECK(scene.wrong_pages() == 0);
    const io::StreamReaderCounters c = reader.counters();
    CHECK(c.pages == scene.pack.terrain.page_count());
    CHECK(c.pages == r.pages_read);
    CHECK(c.mips == r.mips_read);
    CHECK(c.bytes == r.bytes_read);
    CHECK(c.reads > 0);
    CHECK(c.errors + c.damaged == 0);
    CHECK(c.read_s > 0);
    CHECK(c.provide_s > 0);
}

TEST_CASE("several threads read side by side, and what comes is the pack's all the same") {
    Scene scene(6, 1u << 20, {.decoders = 4});
    std::atomic<int> reading{0}, most{0};
    std::atomic<bool> first{true};
    const auto read = [&](std::uint64_t offset, std::span<std::byte> to) {
        const int now = ++reading;
        for (int before = most; before < now && !most.compare_exchange_weak(before, now);) {
        }
        // The first one lasts until there is another beside it.
        const bool waits = first.exchange(false);
        for (const Patience patience; waits && most < 2 && patience.left();) {
        }
        const int error = scene.file.read(offset, to);
        --reading;
        return error;
    };
    const io::StreamReader reader(scene.on.stream, read, {.threads = 4});
    const StreamReport r = scene.settle();
    CHECK(r.converged);
    CHECK(r.failed == 0);
    CHECK(most >= 2);
    CHECK(scene.on.paged.terrain.pages_missing() == 0);
    CHECK(scene.wrong_pages() == 0);
    const io::StreamReaderCounters c = reader.counters();
    CHECK(c.pages == scene.pack.terrain.page_count());
    CHECK(c.bytes == r.bytes_read);
}

TEST_CASE("a read that fails is told once, the rest comes, and asked again, all of it") {
    Scene scene(2);
    std::atomic<bool> failing{true};
    std::atomic<std::uint64_t> calls{0};
    const io::StreamReader reader(scene.on.stream, [&](std::uint64_t offset, std::span<std::byte> to) {
        return failing && ++calls % 5 == 0 ? ENXIO : scene.file.read(offset, to);
    });
    StreamReport r = scene.settle();
    const io::StreamReaderCounters c = reader.counters();
    CHECK_FALSE(r.converged);
    CHECK(c.errors > 3);
    CHECK(c.last_error == ENXIO);
    CHECK(scene.failures.size() == c.errors);
    for (const StreamFailure& f : scene.failures) CHECK(f.code == StatusCode::unreadable);
    CHECK(scene.on.paged.terrain.pages_missing() > 0);
    CHECK(scene.wrong_pages() == 0);
    failing = false;
    (void)stream_retry_failed(scene.on.stream);
    scene.quiet = 0;
    r = scene.settle();
    CHECK(r.converged);
    CHECK(scene.on.paged.terrain.pages_missing() == 0);
    CHECK(scene.wrong_pages() == 0);
}

TEST_CASE("bytes that are not the pack's are found out and do no harm") {
    Scene scene(3);
    std::uint64_t calls = 0; // the reader's thread alone
    const io::StreamReader reader(scene.on.stream, [&](std::uint64_t offset, std::span<std::byte> to) {
        const int error = scene.file.read(offset, to);
        if (++calls % 4 == 0) to[to.size() / 2] ^= std::byte{16};
        return error;
    });
    (void)scene.settle();
    const io::StreamReaderCounters c = reader.counters();
    CHECK(c.damaged > 3);
    CHECK(scene.failures.size() == c.damaged);
    for (const StreamFailure& f : scene.failures) CHECK(f.code == StatusCode::corrupt);
    CHECK(scene.wrong_pages() == 0);
}

TEST_CASE("a reader stops at any moment, and the next one finds nothing lost") {
    Scene scene(4);
    Random random(44);
    for (int round = 0; round < 60; ++round) {
        io::StreamReaderOptions options;
        if (round % 3 == 1) options.latency_s = 1e6; // would not come within any test's time
        if (round % 3 == 2) options.bytes_per_s = 1e-3;
        std::optional<io::StreamReader> reader;
        reader.emplace(scene.on.stream, scene.file, options);
        for (int frame = pick(random, 0, 3); frame > 0; --frame) (void)scene.update();
        std::this_thread::sleep_for(std::chrono::microseconds(pick(random, 0, 300)));
        reader.reset();
        REQUIRE(check_stream(scene.on) == "");
    }
    const io::StreamReader reader(scene.on.stream, scene.file);
    const StreamReport r = scene.settle();
    CHECK(r.converged);
    CHECK(r.failed == 0);
    CHECK(scene.on.paged.terrain.pages_missing() == 0);
    CHECK(scene.wrong_pages() == 0);
}

TEST_CASE("a slower disk is waited for: nothing comes before its time") {
    Scene scene(5);
    io::StreamReaderOptions options;
    options.latency_s = 0.002;
    options.bytes_per_s = 2e6;
    const auto start = std::chrono::steady_clock::now();
    const io::StreamReader reader(scene.on.stream, scene.file, options);
    CHECK(scene.settle().converged);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const io::StreamReaderCounters c = reader.counters();
    // A lower bound only: how much longer it takes is the machine's affair.
    CHECK(seconds >= static_cast<double>(c.bytes) / options.bytes_per_s);
    CHECK(seconds >= static_cast<double>(c.reads) * options.latency_s);
}
