// The guide's loader (content/hosts/game) on a real stream: it sleeps while nothing is wanted, loses nothing, and stops
// at any moment.
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "hosts/game/loader.h"
#include "support/patience.h"
#include "support/stream_scene.h"

using namespace fjell;
using namespace fjell::test;

namespace {

struct LoaderScene {
    LoaderScene() : pack(make()), on(pack.pack, 1u << 20) { REQUIRE(file.open((folder / "pack.fjell").c_str()) == ""); }
    io::LoadedPack make() {
        Random random(8);
        (void)baker::bake(random_dem(random, 513, 385, Shape::fractal), small_bake(7), folder / "pack.fjell");
        return io::load_pack(folder / "pack.fjell", io::LoadTerrain::yes);
    }
    StreamReport update() {
        const View view = view_from_above(pack.terrain, 1);
        return on.update({&view, 1}, {.max_error_px = 0.001}, {.now_s = 0.01 * ++frame});
    }
    // A frame after the other until all is there.
    void settle(game::Loader& loader) {
        StreamReport report;
        for (const Patience patience; !(report.converged && report.maps_converged) && patience.left();) {
            report = update();
            loader.wake();
        }
        REQUIRE(report.converged);
        REQUIRE(report.failed == 0);
        REQUIRE(report.in_flight == 0);
    }
    TemporaryFolder folder;
    io::LoadedPack pack;
    game::PackOnDisk file;
    Streamed on;
    int frame = 0;
};

std::set<std::string> thread_names() {
    std::set<std::string> names;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task"))
        names.insert(task.path().filename());
    return names;
}

// Waits until a thread has slept at twenty looks in succession. One that spins never does.
bool falls_asleep(const std::string& thread) {
    int asleep = 0;
    for (const Patience patience; asleep < 20 && patience.left();) {
        std::ifstream file("/proc/self/task/" + thread + "/stat");
        std::string line;
        std::getline(file, line);
        asleep = line.find(") S ") != std::string::npos ? asleep + 1 : 0;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return asleep == 20;
}

} // namespace

TEST_CASE("the guide's loader sleeps while nothing is wanted, and reads all that is") {
    LoaderScene scene;
    const std::set<std::string> others = thread_names();
    game::Loader loader(scene.on.stream, scene.file);
    std::string own;
    for (const std::string& thread : thread_names())
        if (others.count(thread) == 0) own = thread;
    CHECK(falls_asleep(own)); // before the first update
    scene.settle(loader);
    CHECK(scene.on.paged.terrain.pages_missing() == 0);
    CHECK(falls_asleep(own)); // and after the last
}

TEST_CASE("the guide's loader stops at any moment, and the next one finds nothing lost") {
    LoaderScene scene;
    for (int round = 0; round < 50; ++round) {
        std::optional<game::Loader> loader;
        loader.emplace(scene.on.stream, scene.file);
        for (int i = 0; i < round % 4; ++i) {
            (void)scene.update();
            loader->wake();
        }
    }
    for (int i = 0; i < 2'000; ++i) const game::Loader at_once(scene.on.stream, scene.file);
    game::Loader last(scene.on.stream, scene.file);
    scene.settle(last);
    CHECK(scene.on.paged.terrain.pages_missing() == 0);
}
