// The whole stream at once: the frame's thread, the reader's, and queries of two more, begun and ended at any moment.
// Means most under the tsan preset.
#include <catch2/catch.hpp>

#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "fjell/gltf/snapshot.h"
#include "fjell/io/live_terrain.h"
#include "fjell/io/stream_reader.h"
#include "fjell/query.h"
#include "shared/terrain_data.h"
#include "stream/requests.h"
#include "support/ground_truth.h"
#include "support/rounds.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

#if defined(FJELL_SANITIZED)
constexpr int checked_every = 40;
int least_grounds() {
    return 4;
}
#else
constexpr int checked_every = 25;
int least_grounds() {
    return rounds(4, 10);
}
#endif

struct Ground {
    TemporaryFolder folder;
    io::LoadedPack pack;
    io::PackFile file;
    Ground(Random& random, PageOrder order) : pack(make(random, order)), file(pack.path) {}
    io::LoadedPack make(Random& random, PageOrder order) const {
        baker::Dem dem = random_dem(random, pick(random, 260, 400), pick(random, 260, 400), Shape::noise);
        baker::BakeOptions options = small_bake(pick(random, 6, 8));
        options.order = order;
        options.max_texture_log2 = 5;
        (void)baker::bake(std::move(dem), options, folder / "pack.fjell");
        return io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes);
    }
};

// What a disk does, in the reader's thread: late, failing, or bringing what is not the pack's.
struct Disk {
    const io::PackFile& file;
    std::atomic<bool> sound{false};
    std::mutex lock{}; // of random
    Random random{7};
    int roll(int least, int most) {
        const std::lock_guard hold(lock);
        return pick(random, least, most);
    }
    std::atomic<std::uint64_t> reads{0}, failed{0}, damaged{0};
    int read(std::uint64_t offset, std::span<std::byte> to) {
        ++reads;
        // 0 to 500 ms at a thousandth of their length, and now and then in full a frame's.
        if (!sound) std::this_thread::sleep_for(std::chrono::microseconds(roll(0, roll(0, 40) ? 500 : 16'000)));
        const int error = file.read(offset, to);
        const int dice = sound ? 99 : roll(0, 99);
        if (dice < 5) return ++failed, EIO;
        if (dice < 10) ++damaged, to[to.size() / 3] ^= std::byte{1};
        return error;
    }
};

// Threads that ask for heights and rays until they are told to end; what is wrong is counted, because Catch2 belongs
// to the first thread.
struct Askers {
    const Terrain &full, &paged;
    std::atomic<bool> done{false};
    std::atomic<std::uint64_t> answers{0}, wrong{0}, hits{0};
    std::vector<std::thread> threads;

    Askers(const Terrain& whole, const Terrain& streamed, int count, unsigned seed) : full(whole), paged(streamed) {
        for (int i = 0; i < count; ++i)
            threads.emplace_back([this, own = Random(seed + static_cast<unsigned>(i))]() mutable {
                while (!done.load(std::memory_order_relaxed)) ask(own);
            });
    }
    ~Askers() {
        done = true;
        for (std::thread& thread : threads) thread.join();
    }
    Askers(const Askers&) = delete;
    Askers& operator=(const Askers&) = delete;

    void ask(Random& random) {
        const PackHeader& h = full.header();
        const auto place = [&] {
            return Vec3{uniform(random, 0, data_of(full).tree.columns() - 1), 0,
                        uniform(random, 0, data_of(full).tree.rows() - 1)};
        };
        // As in query_threads_test.cpp: what floats may lose of the error, and doubles of the rest.
        const double slack = rounding_m(full) + 0x1p-22 * static_cast<double>(h.max_error_m);
        const Vec3 at_cell = place(), to = place();
        const double x = at_cell.x * h.spacing_m[0], z = at_cell.z * h.spacing_m[1];
        const GroundHeight height = ground_height(paged, x, z);
        wrong += !(std::abs(height.height_m - at(true_plane(full, at_cell.x, at_cell.z), at_cell.x, at_cell.z)) <=
                   static_cast<double>(height.error_m) + slack);
        const Vec3 origin{x, static_cast<double>(h.max_m) + 10, z};
        const Vec3 target{to.x * h.spacing_m[0], static_cast<double>(h.min_m), to.z * h.spacing_m[1]};
        const GroundHit hit = cast_ray(paged, origin, target - origin, 1e9);
        if (hit.hit) {
            const double u = hit.position_m.x / h.spacing_m[0], v = hit.position_m.z / h.spacing_m[1];
            const double loss = slack + 0x1p-40 * h.height_steps *
                                            static_cast<double>(data_of(full).height_scale.quantum_m) *
                                            (data_of(full).tree.columns() + data_of(full).tree.rows());
            wrong += !(std::abs(hit.position_m.y - at(true_plane(full, u, v), u, v)) <=
                       static_cast<double>(hit.error_m) + loss);
            ++hits;
        }
        ++answers;
    }
};

std::uint64_t wrong_pages(const Terrain& is, const Terrain& should_be) {
    std::uint64_t wrong = 0;
    for (std::uint32_t page = 0; page < is.page_count(); ++page) {
        const PageEntry p = data_of(is).page_table[page], q = data_of(should_be).page_table[page];
        if (p.slot == no_index) continue;
        const std::size_t bytes = data_of(is).pages.page_vertices(page % is.pages_per_tile()) * sizeof(VertexRecord);
        wrong += p.base != q.base ||
                 std::memcmp(data_of(is).records + std::size_t{p.slot} * data_of(is).page_capacity,
                             data_of(should_be).records + std::size_t{q.slot} * data_of(should_be).page_capacity,
                             bytes) != 0;
    }
    return wrong;
}

struct Seen {
    std::uint64_t answers = 0, hits = 0, failures = 0, removed = 0, mips = 0, converged = 0, stops = 0;

    bool enough() const {
        return answers > 100 && hits > 50 && failures > 20 && removed > 20 && mips > 50 && converged > 0 && stops > 20;
    }
};

// One life of a stream: a flight with readers that come and go, then either an end in the midst of it or a rest.
void live(Random& random, const Ground& ground, bool rests, Seen& seen) {
    const Terrain& full = ground.pack.terrain;
    const auto tiles = static_cast<int>(full.tile_count()), pages = static_cast<int>(full.page_count());
    StreamBudget budget;
    budget.page_requests = static_cast<std::uint32_t>(pick(random, 1, 40));
    budget.map_requests = static_cast<std::uint32_t>(pick(random, 1, 8));
    budget.decoders = static_cast<std::uint32_t>(pick(random, 1, 4));
    const auto slots =
        static_cast<std::uint32_t>(pick(random, std::min(tiles + 2, pages), std::min(tiles + pages / 2, pages)));
    Streamed on(ground.pack.pack, slots, budget);
    Disk disk{ground.file};
    std::optional<Askers> askers;
    askers.emplace(full, on.paged.terrain, pick(random, 1, 2), random());
    std::optional<io::StreamReader> reader;
    const auto start_reader = [&](bool any) {
        io::StreamReaderOptions options;
        options.threads = static_cast<std::uint32_t>(pick(random, 1, 5)); // more than decoders, too
        if (any && pick(random, 0, 4) == 0) options.latency_s = pick(random, 0, 1) ? 1e6 : 0.002; // never, or a little
        reader.emplace(
            on.stream, [&](std::uint64_t offset, std::span<std::byte> to) { return disk.read(offset, to); }, options);
    };
    const auto stop_reader = [&] {
        if (!reader) return;
        reader.reset();
        ++seen.stops;
        // Everything that it took has been answered.
        for (std::uint32_t i = 0; i < on.state().request_count; ++i)
            REQUIRE(phase_of(on.state().requests[i]) != Phase::in_flight);
    };
    View view = random_view(random, full);
    CutSettings cut;
    cut.max_error_px = std::pow(10.0, uniform(random, 0.5, 2));
    StreamSettings settings;
    std::uint64_t bytes_seen = 0;
    const auto frame = [&] {
        settings.now_s += 1.0 / 60;
        const StreamReport stream = on.update({&view, 1}, cut, settings);
        for (const PageArrival& a : stream_page_arrivals(on.stream)) seen.removed += a.event == PageEvent::removed;
        seen.failures += stream_failures(on.stream).size();
        for (const MapCommand& c : stream_map_commands(on.stream)) { // as a renderer would: all of them
            for (const std::byte b : c.blocks) bytes_seen += static_cast<std::uint64_t>(b);
            seen.mips += c.upload_mips;
        }
        return stream;
    };
    const int frames = pick(random, 1, rests ? 150 : 60);
    for (int i = 0; i < frames; ++i) {
        if (pick(random, 0, 15) == 0) stop_reader();
        if (!reader && pick(random, 0, 2) == 0) start_reader(true);
        if (pick(random, 0, 20) == 0) (void)stream_retry_failed(on.stream);
        if (pick(random, 0, 12) == 0) view = random_view(random, full);
        if (pick(random, 0, 30) == 0)
            askers.reset(), askers.emplace(full, on.paged.terrain, pick(random, 1, 2), random());
        view = moved(random, view, random_step_m(random, full));
        cut.max_work = pick(random, 0, 2) ? unlimited_work : static_cast<std::uint32_t>(pick(random, 0, 99));
        (void)frame();
        const CutReport report = on.cut.update({&view, 1}, cut);
        if (i % checked_every == 0) {
            REQUIRE(check_stream(on) == "");
            REQUIRE(check_frame(on.cut, full, report, cut) == "");
        }
        if (pick(random, 0, 2) == 0) std::this_thread::sleep_for(std::chrono::microseconds(pick(random, 0, 800)));
        seen.answers += askers->answers.exchange(0), seen.hits += askers->hits.exchange(0);
        REQUIRE(askers->wrong == 0);
    }
    if (!rests) return; // everything ends here as it stands: reader, askers, stream
    stop_reader();
    disk.sound = true;
    start_reader(false);
    cut.max_work = unlimited_work;
    (void)frame(); // takes over the last failures
    (void)stream_retry_failed(on.stream);
    CutReport report;
    for (int quiet = 0; quiet < 3;) {
        const StreamReport stream = frame();
        report = on.cut.update({&view, 1}, cut);
        const bool still =
            stream_page_arrivals(on.stream).empty() &&
            stream.in_flight + stream.pages_left + stream.mips_left + stream.mips_uploaded + stream.pages_evicting == 0;
        quiet = still ? quiet + 1 : 0;
        if (quiet == 3) {
            seen.converged += stream.converged;
            REQUIRE((stream.converged || (stream.exhausted & stream_page_slots) != 0));
            REQUIRE(report.converged == stream.converged);
        } else {
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
    }
    REQUIRE(askers->wrong == 0);
    REQUIRE(check_stream(on) == "");
    REQUIRE(check_frame(on.cut, full, report, cut) == "");
    REQUIRE(wrong_pages(on.paged.terrain, full) == 0);
    stop_reader();
}

} // namespace

TEST_CASE(
    "reader, frames and queries at once: answers keep their bounds, meshes are whole, and all ends at any moment") {
    Random random(811);
    Seen seen;
    // How much happens in a round is the scheduler's to say: at least so many, and on until everything was seen.
    const int grounds = least_grounds();
    for (int round = 0; round < grounds || (!seen.enough() && round < 10 * grounds); ++round) {
        const Ground ground(random, round % 3 == 0 ? PageOrder::hierarchical_z : PageOrder::planar);
        for (int life = 0; life < 3; ++life) {
            CAPTURE(round, life);
            live(random, ground, life == 2, seen);
        }
    }
    CAPTURE(seen.answers, seen.hits, seen.failures, seen.removed, seen.mips, seen.converged, seen.stops);
    CHECK(seen.enough());
}

TEST_CASE("a terrain in one object is updated by one thread, asked by two, exported by one, and ends at any moment") {
    Random random(733);
    const Ground ground(random, PageOrder::planar);
    std::uint64_t asked = 0;
    std::atomic<std::uint64_t> exports{0};
    for (int run = 0; run < rounds(3, 10); ++run) {
        io::LiveTerrain terrain(ground.file.path(), {.page_slots = 40, .cut = {30'000, 60'000, 64, 1}});
        std::atomic<bool> stop{false};
        std::atomic<std::uint64_t> answers{0};
        const auto ask = [&](unsigned seed) {
            Random places(seed);
            while (!stop) {
                const double x_m = uniform(places, 0, terrain.terrain().extent_x_m());
                const double z_m = uniform(places, 0, terrain.terrain().extent_z_m());
                answers += std::isfinite(ground_height(terrain.terrain(), x_m, z_m).height_m);
            }
        };
        std::vector<std::jthread> threads;
        for (unsigned i = 0; i < 2; ++i) threads.emplace_back(ask, 734 + i);
        std::jthread exporter;
        View view = random_view(random, terrain.terrain());
        for (int frame = 0; frame < 20 * (run + 1); ++frame) {
            if (frame % 10 == 0) view = random_view(random, terrain.terrain());
            (void)terrain.update({&view, 1}, frame / 60.0);
            (void)terrain.take_map_commands();
            if (frame % 10 == 5 && terrain.frame().mesh.mesh.tiles.size() > 0) { // one at a time
                exporter = std::jthread([&terrain, &exports, path = ground.file.path() + ".glb",
                                         snapshot = gltf::take_snapshot(terrain, view)] {
                    exports += gltf::write_snapshot(terrain, snapshot, path).tiles;
                });
            }
        }
        while (answers == 0) std::this_thread::yield(); // they may not have had their turn yet
        stop = true;
        threads.clear();
        asked += answers;
    }
    CHECK(asked > 0);
    CHECK(exports > 0);
}
