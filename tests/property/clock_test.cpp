// The host's clock: whatever its numbers are and however long it has run, morphing goes as in the first second.
#include <catch2/catch.hpp>

#include <cstring>

#include "support/cut_scene.h"
#include "support/rounds.h"

using namespace fjell;
using namespace fjell::test;

namespace {

constexpr int frames_a_round = 40, updates_to_settle = 120, updates_between = 230;

// One host of the same flight. Between rounds the eye rests: until the cut has settled alike, then as the hosts differ.
struct Host {
    const char* name;
    double (*begins_s)(int round);
    Cut cut;
    std::vector<MorphVertex> copy; // what a renderer has that uploads slots that were written
    CutReport report;

    Host(const char* host, double (*times)(int), const Terrain& terrain)
        : name(host), begins_s(times), cut(terrain, ample_cut(terrain)), copy(cut.state().budget.vertices) {}

    void update(const View& view, const CutSettings& settings) {
        report = cut.update({&view, 1}, settings);
        const CutMesh mesh = cut_mesh(cut.cut);
        const CutChanges changes = cut_take_changes(cut.cut);
        for_each_run(changes.vertex_bits, changes.vertex_words, [&](std::uint32_t first, std::uint32_t count) {
            std::copy_n(mesh.morph.begin() + first, count, copy.begin() + first);
        });
    }
    void rest(const View& view, CutSettings settings, int round) {
        settings.max_work = unlimited_work;
        for (int frame = frames_a_round; frame < frames_a_round + updates_to_settle; ++frame) {
            settings.now_s = begins_s(round) + frame / 20.0;
            update(view, settings);
        }
        const double from_s = settings.now_s, to_s = begins_s(round + 1);
        for (int i = 1; i <= updates_between; ++i) {
            settings.now_s = i < updates_between ? from_s + (to_s - from_s) * i / updates_between : to_s;
            update(view, settings);
        }
    }
};

std::string difference(const Terrain& terrain, Host& a, Host& b) {
    const CutMesh x = cut_mesh(a.cut.cut), y = cut_mesh(b.cut.cut);
    if (std::memcmp(x.mesh.indices.data(), y.mesh.indices.data(), x.mesh.indices.size_bytes()) != 0) return "triangles";
    if (a.report.vertices != b.report.vertices || a.report.work != b.report.work) return "vertices or items";
    if (a.report.morphing != b.report.morphing) return "how many morph";
    // In ticks of 2^-14 s times are exact, and so is what follows from them.
    for (const TileRange& range : a.cut.mesh().tiles)
        for (std::uint32_t i = range.first_index; i < range.first_index + range.index_count; ++i) {
            const std::uint32_t slot = x.mesh.indices[i];
            if (std::memcmp(&x.mesh.vertices[slot], &y.mesh.vertices[slot], sizeof(MeshVertex)) != 0) return "vertices";
            if (std::memcmp(&b.copy[slot], &y.morph[slot], sizeof(MorphVertex)) != 0) return "a renderer's copy";
            const float drawn_m = morphed_height_m(terrain, x.mesh.vertices[slot], x.morph[slot], x.frame);
            if (drawn_m != morphed_height_m(terrain, y.mesh.vertices[slot], b.copy[slot], y.frame)) return "heights";
        }
    return {};
}

} // namespace

TEST_CASE("48 hours of 60 Hz time and 30 days of Unix time behave like the first second") {
    Random random(471);
    const int rounds_flown = rounds(6, 56);
    std::uint64_t morphing = 0;
    for (const Morph morph : {Morph::error, Morph::time}) {
        const auto pack = rich_terrain(random, 65, 6);
        const Terrain& terrain = pack.terrain;
        // Rounds of a host that has just started; of one whose clock comes round in the middle of each, 56 times in
        // 48 hours; and of one that counts from 1970 and rests for 15 hours at a time.
        Host hosts[] = {{"first", [](int round) { return 18.0 * round; }, terrain},
                        {"48 hours", [](int round) { return round == 0 ? 0.0 : 3072.0 * round - 0.25; }, terrain},
                        {"Unix", [](int round) { return 1.7e9 + 46'800.0 * round; }, terrain}};
        CutSettings settings;
        settings.max_error_px = 0.5;
        settings.morph = morph;
        for (int round = 0; round < rounds_flown; ++round) {
            View view = random_view(random, terrain); // a jump
            settings.morph_s = round % 3 ? 0.25 : 0.1;
            const double step_m = 0.2 * terrain.spacing_x_m();
            const auto page =
                static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(terrain.pages_per_tile()) - 1));
            for (int frame = 0; frame < frames_a_round; ++frame) {
                view = moved(random, view, step_m);
                settings.max_work = frame % 4 ? 60 : unlimited_work;
                for (Host& host : hosts) {
                    settings.now_s = host.begins_s(round) + frame / 60.0;
                    bool released = false;
                    if (frame == 10) REQUIRE(cut_release_page(host.cut.cut, 0, page, released).ok()); // morphs out
                    if (frame == 30) (void)cut_cancel_release(host.cut.cut, 0, page);
                    host.update(view, settings);
                    CAPTURE(host.name, round, frame, static_cast<int>(morph));
                    REQUIRE(difference(terrain, hosts[0], host) == "");
                }
                morphing += hosts[0].report.morphing;
            }
            for (Host& host : hosts) {
                host.rest(view, settings, round);
                CAPTURE(host.name, round);
                REQUIRE(host.report.converged);
                REQUIRE(check_cut(host.cut) == "");
                REQUIRE(difference(terrain, hosts[0], host) == "");
            }
        }
    }
    REQUIRE(morphing > 1000);
}

TEST_CASE("a clock that runs backwards stands, and one of any size is taken") {
    Random random(472);
    const auto pack = rich_terrain(random, 33, 5);
    Cut cut(pack.terrain, ample_cut(pack.terrain));
    const View view = random_view(random, pack.terrain);
    CutSettings settings;
    settings.max_error_px = 0.5;
    settings.morph = Morph::time;
    settings.max_work = 20;
    for (const double now_s : {0.0, 1.0, -1e300, 1e300, 1e18, -5.0, 3.0, 3.2, 3.4, 3.6}) {
        const float before_s = cut_mesh(cut.cut).frame.now_s;
        settings.now_s = now_s;
        (void)cut.update({&view, 1}, settings);
        REQUIRE(check_cut(cut) == "");
        const float age_s = morph_age_s(cut_mesh(cut.cut).frame.now_s, before_s);
        REQUIRE((age_s >= 0 && age_s <= 16));
    }
    settings.max_work = unlimited_work;
    CutReport report;
    for (int frame = 0; frame < 60; ++frame) {
        settings.now_s += 0.1;
        report = cut.update({&view, 1}, settings);
    }
    REQUIRE(report.converged);
}
