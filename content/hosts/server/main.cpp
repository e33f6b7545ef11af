// A server without graphics: 64 focus points walk over a pack that is streamed around them; 8 threads ask for heights
// and rays meanwhile, and tiles of a navigation mesh follow some of the walkers.
//   server PACK [TICKS [PAGES]]
//   server PACK --dig            a crater under a walker, and the tiles of the navigation mesh that it touches
//   server PACK --times VIEWS    prints what a tick costs, as many as frames are flown (content/hosts/times)
// Exit code 1: a promise is broken; 2: usage; 3: the pack or a budget is at fault.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include <fjell/fjell.h>

#include "../times/times.h"
#include "asker.h"
#include "dig.h"
#include "navmesh.h"
#include "zones.h"

namespace {

using namespace server;

constexpr int threads = 8;
constexpr std::chrono::milliseconds tick_ms(10); // of ours: ten times as fast as the walkers'
constexpr double reach_m = 60, accuracy_m = 0.2;
constexpr int nav_tiles_a_tick = 2;

int fail(int code, const std::string& why) {
    std::fprintf(stderr, "server: %s\n", why.c_str());
    return code;
}

std::string create(Shared& shared, Navmesh& navmesh, const game::PackOnDisk& file, std::uint32_t pages) {
    for (Zone& zone : shared.zone) {
        if (std::string error = zone.ground.create(file, pages); !error.empty()) return error;
        zone.loader = std::make_unique<game::Loader>(zone.ground.stream(), file);
    }
    count_memory();
    if (std::string error = navmesh.create(shared.zone[0].ground.terrain()); !error.empty()) return error;
    return shared.whole.create(file);
}

// The ground of one zone for a tick: never waits for the loader, nor for those who ask.
fjell::Status update(Zone& zone, int index, double now_s) {
    fjell::View views[zone_walkers];
    const fjell::Terrain& terrain = zone.ground.terrain();
    for (int i = 0; i < zone_walkers; ++i) {
        fjell::Vec3 at = walker_at(terrain, index, i, now_s);
        at.y = fjell::ground_height(terrain, at.x, at.z).height_m;
        views[i] = ground::focus(at, reach_m, accuracy_m);
    }
    const fjell::Status s = zone.ground.update(views, now_s);
    zone.loader->wake();
    for (const fjell::StreamFailure& failure : fjell::stream_failures(zone.ground.stream())) // coarser there
        std::fprintf(stderr, "server: tile %u: %s\n", failure.id.tile, fjell::message(failure.code));
    return s;
}

std::string run(Shared& shared, Navmesh& navmesh, int ticks, Measured& times) {
    auto next = std::chrono::steady_clock::now();
    for (int tick = 1; tick <= ticks && navmesh.broken().empty(); ++tick) {
        ++shared.tick;
        const double now_s = shared.now_s();
        shared.tick.notify_all(); // the threads ask while the streams are updated
        times.start(unsigned(tick - 1));
        for (int i = 0; i < zones; ++i) {
            Zone& zone = shared.zone[std::size_t(i)];
            if (fjell::Status s = update(zone, i, now_s); !s.ok()) return ground::text_of(s);
            navmesh.want(zone.ground.terrain(), walker_at(zone.ground.terrain(), i, 0, now_s));
        }
        times.done(times_update);
        navmesh.tick(nav_tiles_a_tick, shared.whole.terrain());
        times.done(times_upload);
        std::this_thread::sleep_until(next += tick_ms);
    }
    return "";
}

void print(const Shared& shared, const Navmesh& navmesh, const std::array<Answers, threads>& answers) {
    Answers all;
    for (const Answers& a : answers) {
        all.heights += a.heights, all.rays += a.rays, all.checked += a.checked, all.finest += a.finest;
        all.height_s += a.height_s, all.ray_s += a.ray_s;
    }
    std::uint64_t came = 0, went = 0;
    std::size_t bytes = 0;
    int stand = 0;
    for (int i = 0; i < zones; ++i) {
        const ground::StreamedGround& ground = shared.zone[std::size_t(i)].ground;
        came += ground.came(), went += ground.went(), bytes += ground.bytes();
        fjell::Vec3 at = walker_at(ground.terrain(), i, 0, shared.now_s());
        at.y = fjell::ground_height(ground.terrain(), at.x, at.z).height_m;
        stand += navmesh.stands(at, ground.terrain().spacing_x_m());
    }
    const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
    std::printf("memory: %.1f MB for %d terrains of %u pages; Recast and Detour %.1f MB at most\n", double(bytes) / 1e6,
                zones, shared.zone[0].ground.terrain().page_slots(), double(most_bytes()) / 1e6);
    std::printf("pages: %llu came, %llu went\n", number(came), number(went));
    std::printf("%d threads: %.2f M heights/s and %.3f M rays/s a thread, of its processor time\n", threads,
                double(all.heights) / all.height_s / 1e6, double(all.rays) / all.ray_s / 1e6);
    std::printf("%llu answers compared, %llu of the full resolution; none further off than it said\n",
                number(all.checked), number(all.finest));
    std::printf("navigation: %llu tiles made, %llu made again, %llu dropped; %d of %d walkers stand on one\n",
                number(navmesh.made()), number(navmesh.remade()), number(navmesh.dropped()), stand, zones);
}

int dig_one(Shared& shared, Navmesh& navmesh) {
    Dug dug = dig(shared.zone[0], shared.whole, navmesh);
    if (!dug.broken.empty()) return fail(1, dug.broken);
    std::sort(dug.ms.begin(), dug.ms.end());
    std::printf("a crater of 28 m touched %d of %d tiles; %d were made again, in %.1f ms each (median)\n", dug.touched,
                dug.tiles, dug.again, dug.ms[dug.ms.size() / 2]);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2 || argc > 4) return fail(2, "usage: server PACK [TICKS [PAGES]]");
    Measured times;
    const bool measured = argc == 4 && argv[2] == std::string_view("--times");
    if (const char* wrong = measured ? times_read(&times, argv[3]) : nullptr) return fail(2, wrong);
    const bool digs = argc == 3 && argv[2] == std::string_view("--dig");
    const int ticks = digs ? 1 : measured ? int(times.flown()) : argc > 2 ? std::atoi(argv[2]) : 300;
    const int pages = measured ? 100 : argc > 3 ? std::atoi(argv[3]) : 100;
    if (ticks < 1 || pages < 1) return fail(2, "TICKS and PAGES are whole numbers from 1 on");
    game::PackOnDisk file;
    if (std::string error = file.open(argv[1]); !error.empty()) return fail(3, error);
    Shared shared;
    Navmesh navmesh;
    if (std::string error = create(shared, navmesh, file, std::uint32_t(pages)); !error.empty()) return fail(3, error);

    if (digs) return dig_one(shared, navmesh);

    std::array<Answers, threads> answers;
    std::array<std::thread, threads> askers;
    for (int i = 0; i < threads; ++i)
        askers[std::size_t(i)] = std::thread([&, i] { ask(shared, i, answers[std::size_t(i)]); });
    const std::string error = run(shared, navmesh, ticks, times);
    shared.stop = true;
    ++shared.tick;
    shared.tick.notify_all();
    for (std::thread& asker : askers) asker.join();
    if (!error.empty()) return fail(3, error);
    if (!navmesh.broken().empty()) return fail(1, navmesh.broken());
    for (const Answers& a : answers)
        if (!a.broken.empty()) return fail(1, a.broken);
    const char* const parts[] = {"update", "navmesh", nullptr, nullptr};
    if (measured)
        times_print(&times, 0, parts);
    else
        print(shared, navmesh, answers);
    return 0;
}
