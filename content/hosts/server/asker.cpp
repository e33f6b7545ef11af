#include "asker.h"

#include <cstdio>
#include <ctime>
#include <random>

namespace server {

namespace {

constexpr int batch = 256;
constexpr double around_m = 40, eyes_m = 1.8, far_m = 300;
constexpr double rounding_m = 1e-6;

double thread_s() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

// The promise of every answer: the full resolution is within its error.
void check(Answers& answers, const Shared& shared, const char* what, fjell::Vec3 at, double error_m, bool finest) {
    const fjell::GroundHeight full = fjell::ground_height(shared.whole.terrain(), at.x, at.z);
    if (full.hole) return; // a coarser answer may not know of it
    ++answers.checked;
    answers.finest += finest;
    const double off_m = std::abs(at.y - full.height_m);
    if (off_m <= error_m + rounding_m || !answers.broken.empty()) return;
    char text[200];
    std::snprintf(text, sizeof text, "%s at x %.2f, z %.2f is %.3f m off the full-resolution ground and says %.3f m",
                  what, at.x, at.z, off_m, error_m);
    answers.broken = text;
}

struct Places {
    double x_m[batch], z_m[batch];
};

void heights(Answers& answers, const Shared& shared, const fjell::Terrain& terrain, const Places& at) {
    fjell::GroundHeight found[batch];
    const double started = thread_s();
    for (int i = 0; i < batch; ++i) found[i] = fjell::ground_height(terrain, at.x_m[i], at.z_m[i]);
    answers.height_s += thread_s() - started;
    answers.heights += batch;
    for (int i = 0; i < batch; i += 8) {
        const fjell::GroundHeight& g = found[i];
        if (g.inside && !g.hole)
            check(answers, shared, "a height", {at.x_m[i], g.height_m, at.z_m[i]}, double(g.error_m), g.finest);
    }
}

// From where a walker's eyes may be to another place, some of them over the horizon.
void rays(Answers& answers, const Shared& shared, const fjell::Terrain& terrain, const Places& at) {
    constexpr int count = batch / 4;
    fjell::Vec3 from[count], to[count];
    for (int i = 0; i < count; ++i) {
        from[i] = {at.x_m[i], 0, at.z_m[i]};
        const fjell::GroundHeight g = fjell::ground_height(terrain, from[i].x, from[i].z);
        from[i].y = g.height_m + eyes_m;
        to[i] = fjell::Vec3{at.x_m[batch - 1 - i], g.height_m - 10, at.z_m[batch - 1 - i]} - from[i];
    }
    fjell::GroundHit found[count];
    const double started = thread_s();
    for (int i = 0; i < count; ++i) found[i] = fjell::cast_ray(terrain, from[i], to[i], far_m);
    answers.ray_s += thread_s() - started;
    answers.rays += count;
    for (int i = 0; i < count; i += 4)
        if (found[i].hit)
            check(answers, shared, "a hit", found[i].position_m, double(found[i].error_m), found[i].finest);
}

} // namespace

void ask(const Shared& shared, int thread, Answers& answers) {
    std::mt19937 random(static_cast<unsigned>(thread));
    std::uniform_real_distribution<double> away_m(-around_m, around_m);
    for (int round = 0; !shared.stop; ++round) {
        const std::uint32_t tick = shared.tick;
        for (int zone = 0; zone < zones; ++zone) {
            if ((zone + round + thread) % 2 != 0) continue; // every thread asks about every zone, in every other tick
            const fjell::Terrain& terrain = shared.zone[std::size_t(zone)].ground.terrain();
            Places at;
            for (int i = 0; i < batch; ++i) {
                const fjell::Vec3 walker = walker_at(terrain, zone, i % zone_walkers, tick * tick_s);
                at.x_m[i] = walker.x + away_m(random);
                at.z_m[i] = walker.z + away_m(random);
            }
            heights(answers, shared, terrain, at);
            rays(answers, shared, terrain, at);
        }
        if (!shared.stop) shared.tick.wait(tick);
    }
}

} // namespace server
