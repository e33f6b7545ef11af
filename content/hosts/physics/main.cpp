// Bodies on ground that is streamed: 200 of them roll over a pack for a simulated minute, with Bullet.
//   physics PACK [SECONDS [PAGES]]
//   physics PACK --dig            a crater under a body, which falls to its floor
//   physics PACK --times VIEWS    prints what a step costs, as many as frames are flown (content/hosts/times)
// Every contact is compared with the full-resolution surface. Nothing depends on a clock: the same pack gives the same
// figures, but for the times. Exit code 1: a promise is broken; 2: usage; 3: the pack or a budget is at fault.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <string_view>

#include <btBulletDynamicsCommon.h>

#include <fjell/fjell.h>

#include "../ground/streamed_ground.h"
#include "../times/times.h"
#include "bodies.h"
#include "check.h"
#include "dig.h"
#include "patches.h"

namespace {

using namespace physics;

int fail(int code, const std::string& why) {
    std::fprintf(stderr, "physics: %s\n", why.c_str());
    return code;
}

constexpr int steps_per_s = 60;
constexpr double step_s = 1.0 / steps_per_s;
constexpr double accuracy_m = 0.1;   // ground that is off by less carries bodies
constexpr int requests_per_step = 2; // how fast the disk is

// In this order they are made; in the other order they end.
struct Scene {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    Origin origin;
    Patches patches;
    Bodies bodies;
    Check check;

    Scene(const fjell::Terrain& terrain, const fjell::Terrain& whole, float good_m)
        : origin{{terrain.extent_x_m() / 2, terrain.header().min_m, terrain.extent_z_m() / 2}},
          patches(world, terrain, origin, good_m), bodies(world, terrain, origin), check(whole, origin) {}
    // A wind from the west that turns a little, so that all go on and pages come and go under them.
    void blow(double now_s) {
        constexpr double turn_s = 20, wind_m_s2 = 3;
        const double angle = 0.5 * std::sin(now_s * 2 * std::numbers::pi / turn_s);
        world.setGravity(
            btVector3(btScalar(wind_m_s2 * std::cos(angle)), -9.81f, btScalar(wind_m_s2 * std::sin(angle))));
        bodies.wake();
    }
};

// One step of both: the bodies', and the stream's.
fjell::Status step(Scene& scene, ground::StreamedGround& ground, double now_s, Measured& times) {
    scene.bodies.hold_or_release(scene.patches);
    scene.blow(now_s);
    scene.world.stepSimulation(btScalar(step_s), 0);
    times.done(times_draw);
    scene.check.contacts(scene.world);
    scene.bodies.look(scene.check, step_s);

    fjell::View views[fjell::max_cut_views];
    scene.bodies.views(views, accuracy_m);
    times.pause();
    fjell::Status s = ground.update(views, now_s);
    times.done(times_update);
    ground.answer(requests_per_step); // a game's loader does this on a thread of its own
    times.pause();
    scene.patches.follow(ground.report().pages_inserted != 0);
    times.done(times_upload);
    for (const fjell::StreamFailure& failure : fjell::stream_failures(ground.stream())) // bodies there are held
        std::fprintf(stderr, "physics: tile %u: %s\n", failure.id.tile, fjell::message(failure.code));
    return s;
}

void print(Scene& scene, const ground::StreamedGround& ground) {
    int through = 0, never = 0;
    double rolled_m = 0;
    for (const Body& body : scene.bodies.all()) {
        through += body.through;
        never += !body.placed;
        rolled_m += body.rolled_m;
    }
    PatchCounts counts = scene.patches.counts();
    std::nth_element(counts.us.begin(), counts.us.begin() + long(counts.us.size() / 2), counts.us.end());
    const std::size_t bodies = scene.bodies.all().size();
    std::printf(
        "%zu bodies rolled %.0f m on average; %d fell through holes, %d were never placed, held for %llu steps\n",
        bodies, rolled_m / double(bodies), through, never, (unsigned long long)scene.bodies.held_steps());
    std::printf("%llu contacts, off by %.0f%% of what is allowed at most; no body under the ground\n",
                (unsigned long long)scene.check.contact_count(), 100 * scene.check.worst_share());
    std::printf("patches: %llu made, %llu made again, %llu dropped; %.1f us each from loaded pages (median)\n",
                (unsigned long long)counts.made, (unsigned long long)counts.remade, (unsigned long long)counts.dropped,
                counts.us.empty() ? 0.0 : double(counts.us[counts.us.size() / 2]));
    std::printf("pages: %llu came, %llu went, room for %u of %u\n", (unsigned long long)ground.came(),
                (unsigned long long)ground.went(), ground.terrain().page_slots(), ground.terrain().page_count());
}

int dig_one(ground::StreamedGround& ground, ground::Yardstick& whole, float good_m) {
    const Dug dug = dig(ground, whole, accuracy_m, good_m);
    if (!dug.broken.empty()) return fail(1, dug.broken);
    std::printf("a body fell %.0f mm into a crater of 4000 mm, and rests on its floor; contacts are off by %.0f%% of "
                "what is allowed at most; %d patches were read again\n",
                1000 * dug.fell_m, 100 * dug.share, dug.patches);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2 || argc > 4) return fail(2, "usage: physics PACK [SECONDS [PAGES]]");
    Measured times;
    const bool measured = argc == 4 && argv[2] == std::string_view("--times");
    if (const char* wrong = measured ? times_read(&times, argv[3]) : nullptr) return fail(2, wrong);
    const bool digs = argc == 3 && argv[2] == std::string_view("--dig");
    const int seconds = measured || digs ? 1 : argc > 2 ? std::atoi(argv[2]) : 60;
    const int pages = measured ? 160 : argc > 3 ? std::atoi(argv[3]) : 160;
    const unsigned steps = measured ? times.flown() : unsigned(std::max(seconds, 0) * steps_per_s);
    if (seconds < 1 || pages < 1) return fail(2, "SECONDS and PAGES are whole numbers from 1 on");
    game::PackOnDisk file;
    ground::StreamedGround ground;
    ground::Yardstick whole;
    if (std::string error = file.open(argv[1]); !error.empty()) return fail(3, error);
    if (std::string error = ground.create(file, std::uint32_t(pages)); !error.empty()) return fail(3, error);
    if (std::string error = whole.create(file); !error.empty()) return fail(3, error);

    const double half_quantum_m = double(file.pack().header.quantum_m) / 2;
    if (digs) return dig_one(ground, whole, float(accuracy_m + half_quantum_m));
    Scene scene(ground.terrain(), whole.terrain(), float(accuracy_m + half_quantum_m));
    for (unsigned i = 0; i < steps; ++i) {
        times.start(i);
        if (fjell::Status s = step(scene, ground, i * step_s, times); !s.ok()) return fail(3, ground::text_of(s));
        if (!scene.check.broken().empty()) return fail(1, scene.check.broken());
    }
    const char* const parts[] = {"update", "patches", "simulate", nullptr};
    if (measured)
        times_print(&times, 0, parts);
    else
        print(scene, ground);
    return 0;
}
