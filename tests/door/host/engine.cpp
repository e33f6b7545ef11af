#include "engine.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

#include <fjell/fjell.h>
#include <fjell/io/failure.h>
#include <fjell/io/load.h>
#include <fjell/io/pack_file.h>
#include <fjell/io/stream_reader.h>

static_assert(FJELL_VERSION >= FJELL_MAKE_VERSION(0, 3, 0));

namespace {

struct Free {
    void operator()(std::byte* bytes) const { std::free(bytes); }
};
using Owner = std::vector<std::unique_ptr<std::byte, Free>>; // outlives what lies in it

std::span<std::byte> allocate(Owner& owner, std::size_t bytes) {
    const std::size_t rounded = (bytes + 63) / 64 * 64;
    owner.emplace_back(static_cast<std::byte*>(std::aligned_alloc(64, rounded)));
    return {owner.back().get(), rounded};
}

int fail(const char* what, fjell::Status status) {
    std::fprintf(stderr, "game: %s: %s: %s\n", what, status.field, fjell::message(status.code));
    return 1;
}

fjell::View a_view() {
    return fjell::make_view({100, 4000, 100}, {1, -0.5, 1}, {0, 1, 0}, 1, 1280, 720, 1, 1e5);
}

void say(const char* how, const fjell::Terrain& terrain, const fjell::CutReport& report) {
    const fjell::GroundHeight ground = fjell::ground_height(terrain, 1234.5, 2345.25);
    std::printf("%s: %u triangles, converged %d, %.9g m high\n", how, report.triangles, report.converged,
                ground.height_m);
}

int load(const char* path) {
    Owner owner;
    const fjell::io::LoadedPack file = fjell::io::load_pack(path, fjell::io::LoadTerrain::no);
    fjell::Terrain terrain;
    fjell::Status s = fjell::load_terrain(file.pack, allocate(owner, fjell::terrain_bytes(file.pack.header)), terrain);
    if (!s.ok()) return fail("terrain", s);
    const fjell::CutBudget budget{};
    fjell::LiveCut cut;
    s = fjell::create_cut(terrain, budget, allocate(owner, fjell::cut_bytes(terrain, budget)), cut);
    if (!s.ok()) return fail("cut", s);
    const fjell::View view = a_view();
    fjell::CutReport report;
    s = fjell::update_cut(cut, {&view, 1}, {}, report);
    if (!s.ok()) return fail("view", s);
    say("loaded", terrain, report);
    return report.converged ? 0 : 1;
}

int stream(const char* path) {
    Owner owner;
    const fjell::io::PackFile file(path);
    fjell::Terrain terrain;
    const std::size_t bytes = fjell::terrain_bytes(file.pack().header);
    fjell::Status s = fjell::create_terrain(file.pack(), file.corners(), {}, allocate(owner, bytes), terrain);
    if (!s.ok()) return fail("terrain", s);
    const fjell::CutBudget budget{};
    fjell::LiveCut cut;
    s = fjell::create_cut(terrain, budget, allocate(owner, fjell::cut_bytes(terrain, budget)), cut);
    if (!s.ok()) return fail("cut", s);
    const fjell::StreamBudget streaming{};
    fjell::Stream stream;
    s = fjell::create_stream(file.pack(), terrain, cut, streaming,
                             allocate(owner, fjell::stream_bytes(file.pack(), terrain, streaming)), stream);
    if (!s.ok()) return fail("stream", s);
    const fjell::io::StreamReader reader(stream, file);
    const fjell::View view = a_view();
    fjell::CutReport report;
    fjell::StreamReport streamed;
    for (int frame = 0; frame < 30'000 && !(streamed.converged && streamed.maps_converged && report.converged);
         ++frame) {
        s = fjell::update_stream(stream, {&view, 1}, {}, {.now_s = frame / 60.0}, streamed);
        if (!s.ok()) return fail("stream", s);
        s = fjell::update_cut(cut, {&view, 1}, {}, report);
        if (!s.ok()) return fail("view", s);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    say("streamed", terrain, report);
    return streamed.converged && report.converged ? 0 : 1;
}

} // namespace

int play(const char* pack) {
    std::printf("fjell %s\n", FJELL_VERSION_STRING);
#if defined(__cpp_exceptions)
    try { // what a library throws is caught in another
        const fjell::io::PackFile none("/nowhere/none.fjell");
        return 1;
    } catch (const fjell::io::Failure& failure) {
        if (failure.exit_code != 1) return 1;
    }
#endif
    const int code = load(pack);
    return code != 0 ? code : stream(pack);
}
