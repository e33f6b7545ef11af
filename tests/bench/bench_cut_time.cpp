// bench_cut's frames that their time ends: does it hold, what is claimed meanwhile, and how soon does the mesh stand?
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "bench/cut_scenes.h"
#include "fjell/measure.h"

namespace fjell::bench {

using test::worked_us;

namespace {

// Claims above so many times the threshold say what no mesh exceeds, as of this one nothing better is known
// (cut/error_bound.cpp).
constexpr double coarse_thresholds = 256;

void report_ranks(benchmark::State& state, const std::vector<double>& us, const std::string& of) {
    state.counters[of + "p50_us"] = rank(us, 0.5);
    state.counters[of + "p99_us"] = rank(us, 0.99);
    state.counters[of + "p9999_us"] = rank(us, 0.9999);
    state.counters[of + "max_us"] = rank(us, 1);
}

// A random place every 500 frames, turning, 300 us a frame: does a frame ever take longer than a loop that does nothing
// for as long? By the thread's own time, in turns. Then the same frames again, by what they had visited: what a frame
// takes in each of three runs is the frame's, what it takes in one of them is the machine's.
class Teleports {
public:
    static constexpr int frames = 100'000;

    explicit Teleports(double offscreen_factor) {
        settings_.max_error_px = 2;
        settings_.offscreen_factor = offscreen_factor;
    }

    // Within budget_us a frame; 0: as far as frames were visited before. between: after each frame.
    template <typename Between>
    void fly(double budget_us, const Between& between) {
        const CutInMemory in_memory(terrain_, cut_budget);
        const LiveCut cut = in_memory.cut;
        settings_.max_time_us = budget_us;
        std::uint32_t seed = 1;
        const auto random = [&] { return (seed = seed * 1664525 + 1013904223) / 4294967296.0; };
        std::vector<View> views = flight_views(terrain_, 0.25, 1);
        for (std::size_t frame = 0; frame < frames; ++frame) {
            View& view = views[0];
            if (frame % 500 == 0) {
                view.eye_m = {random() * terrain_.x_m(4096), 0, random() * terrain_.z_m(4096)};
                view.eye_m.y = data_of(terrain_).ground_m(view.eye_m.x, view.eye_m.z) + 400;
            }
            view.eye_m = view.eye_m + Vec3{12, 0, -9};
            const double angle = static_cast<double>(frame) * 0.005;
            view.forward = {std::sin(angle), 0, std::cos(angle)}, view.up = {0, 1, 0};
            settings_.visits = budget_us > 0 ? unlimited_work : visits_[frame];
            CutReport report;
            const double start = worked_us();
            if (!update_cut(cut, views, settings_, report).ok()) std::abort();
            const double us = worked_us() - start;
            if (budget_us > 0) {
                visits_.push_back(report.visits);
                changes_.push_back(report.activations + report.deactivations);
                least_us_.push_back(us);
            } else if (changes_[frame] != report.activations + report.deactivations) {
                std::abort(); // not the same frame
            } else {
                least_us_[frame] = std::min(least_us_[frame], us);
            }
            between(us, report);
        }
    }
    [[nodiscard]] const std::vector<double>& least_us() const { return least_us_; }

private:
    const Terrain& terrain_ = mountains().pack.terrain;
    CutSettings settings_;
    std::vector<std::uint32_t> visits_, changes_;
    std::vector<double> least_us_;
};

void teleport_budget(benchmark::State& state, double offscreen_factor) {
    constexpr double budget_us = 300;
    Teleports teleports(offscreen_factor);
    std::vector<double> us, spin_us, claim_us;
    double converged = 0;
    for (auto _ : state) {
        teleports.fly(budget_us, [&](double frame_us, const CutReport& report) {
            us.push_back(frame_us);
            converged += report.converged;
            if (report.error_bound_px > coarse_thresholds * report.threshold_px) claim_us.push_back(report.output_us);
            const double start = worked_us();
            for (const Clock::time_point begin = Clock::now(); us_since(begin) < budget_us;) {
            }
            spin_us.push_back(worked_us() - start);
        });
        for (int again = 0; again < 2; ++again) teleports.fly(0, [](double, const CutReport&) {});
    }
    report_ranks(state, us, "");
    report_ranks(state, spin_us, "spin_");
    report_ranks(state, teleports.least_us(), "least_");
    state.counters["p9999_over_spin"] = rank(us, 0.9999) / rank(spin_us, 0.9999);
    state.counters["converged"] = converged / Teleports::frames;
    state.counters["coarse_output_p50_us"] = rank(claim_us, 0.5);
    state.counters["coarse_output_p99_us"] = rank(claim_us, 0.99);
}

// A flight of a quarter of a cell a frame that turns, and jumps to a random place every 500 frames: how long do frames
// take with a limit of time, without one, and when the mesh is found anew in each?
void jumps(benchmark::State& state, double budget_us) {
    constexpr std::size_t frames = 10'000, frames_a_jump = 500;
    const Scene& scene = mountains();
    const Terrain& t = scene.pack.terrain;
    std::uint32_t seed = 1;
    const auto random = [&] { return (seed = seed * 1664525 + 1013904223) / 4294967296.0; };
    Vec3 eye_m = flight_views(t, 0.25, 1)[0].eye_m;
    std::vector<View> views;
    for (std::size_t frame = 0; frame < frames; ++frame) {
        if (frame % frames_a_jump == frames_a_jump / 2) // the mesh that is there at first is that of the first place
            eye_m = {(0.1 + 0.8 * random()) * t.x_m(4096), 0, (0.1 + 0.8 * random()) * t.z_m(4096)};
        eye_m = eye_m + Vec3{12, 0, -9};
        eye_m.y = data_of(t).ground_m(eye_m.x, eye_m.z) + 400;
        const double angle = static_cast<double>(frame) * 0.005;
        views.push_back(make_view(eye_m, {std::sin(angle), -0.15, std::cos(angle)}, {0, 1, 0}, 0.7853981633974483, 1280,
                                  960, 10, 1e6));
    }
    const auto report = [&](const std::vector<double>& us, const std::string& of) {
        for (const auto& [name, share] : {std::pair{"p50", 0.5}, {"p90", 0.9}, {"p99", 0.99}, {"p999", 0.999}})
            state.counters[of + "_" + name + "_us"] = rank(us, share);
        state.counters[of + "_worst_us"] = rank(us, 1);
    };
    const auto fly = [&](double offscreen_factor, double limit_us, const std::string& name) {
        const CutInMemory in_memory(t, cut_budget);
        const LiveCut cut = in_memory.cut;
        CutSettings settings;
        settings.max_error_px = scene.error_px;
        settings.hysteresis = 0.04; // as the profiles have it
        settings.offscreen_factor = offscreen_factor;
        CutReport now;
        (void)rebuild_cut(cut, {&views[0], 1}, settings, now);
        settings.max_time_us = limit_us;
        std::vector<double> us;
        double converged = 0;
        for (const View& each : views) {
            const double start = worked_us();
            if (!update_cut(cut, {&each, 1}, settings, now).ok()) std::abort();
            us.push_back(worked_us() - start);
            converged += now.converged;
            (void)cut_take_changes(cut);
        }
        report(us, name);
        state.counters[name + "_converged_share"] = converged / static_cast<double>(frames);
    };
    for (auto _ : state) {
        fly(1, budget_us, "limited");
        fly(8, budget_us, "limited_offscreen");
        fly(1, 0, "unlimited");
        std::vector<double> us;
        for (const View& each : views) {
            const double start = worked_us();
            if (!scene.lean->refine(each, scene.error_px, true).whole) std::abort();
            us.push_back(worked_us() - start);
        }
        report(us, "lean");
    }
    state.counters["limit_us"] = budget_us;
}

// What an update without a limit takes beside the two ways that it has: a rebuild, and to follow, which it must when
// visits are given. Threshold factors of 0.5 and 2 in turns, or so many cells a frame, fewer than a jump has; by the
// thread's own time.
void follow_or_build(benchmark::State& state, double cells, bool thresholds) {
    const Scene& scene = mountains();
    const std::vector<View> views = flight_views(scene.pack.terrain, cells, 24);
    const CutInMemory chosen(scene.pack.terrain, cut_budget), followed(scene.pack.terrain, cut_budget),
        built(scene.pack.terrain, cut_budget);
    std::vector<double> us[3];
    for (auto _ : state)
        for (std::size_t i = 0; i < views.size(); ++i) {
            CutSettings settings;
            settings.max_error_px = thresholds && i % 2 == 1 ? scene.error_px / 2 : scene.error_px;
            settings.hysteresis = 0.04; // as the profiles have it
            const auto timed = [&](std::vector<double>& into, const CutInMemory& of, auto&& update) {
                CutReport report;
                const double start = worked_us();
                if (!update(of.cut, std::span(&views[i], 1), settings, report).ok()) std::abort();
                if (i != 0) into.push_back(worked_us() - start);
                (void)cut_take_changes(of.cut);
            };
            timed(us[0], chosen, update_cut);
            timed(us[2], built, rebuild_cut);
            if (i != 0) settings.visits = unlimited_work - 1;
            timed(us[1], followed, update_cut);
        }
    state.counters["chosen_p50_us"] = rank(us[0], 0.5);
    state.counters["followed_p50_us"] = rank(us[1], 0.5);
    state.counters["built_p50_us"] = rank(us[2], 0.5);
}

// A cell a frame in less time than that takes: what does the mesh claim to keep, and what does it cost to say so?
void lag(benchmark::State& state, double budget_us) {
    const Scene& scene = mountains();
    const Terrain& t = scene.pack.terrain;
    const CutInMemory in_memory(t, cut_budget);
    const LiveCut cut = in_memory.cut;
    CutSettings settings;
    settings.max_error_px = scene.error_px;
    std::vector<double> claimed_px, output_us;
    double coarse = 0;
    for (auto _ : state) {
        const std::vector<View> views = flight_views(t, 1, 600);
        CutReport report;
        (void)rebuild_cut(cut, {&views[0], 1}, settings, report);
        settings.max_time_us = budget_us;
        for (const View& view : views) {
            (void)update_cut(cut, {&view, 1}, settings, report);
            claimed_px.push_back(report.error_bound_px);
            output_us.push_back(report.output_us);
            coarse += report.error_bound_px > coarse_thresholds * settings.max_error_px;
        }
    }
    state.counters["claimed_p50_px"] = rank(claimed_px, 0.5);
    state.counters["claimed_p90_px"] = rank(claimed_px, 0.9);
    state.counters["coarse_share"] = coarse / static_cast<double>(claimed_px.size());
    state.counters["output_p50_us"] = rank(output_us, 0.5);
}

// Of the vertices that a view will show in the end, the share that a mesh has.
class Visible {
public:
    Visible(const Terrain& terrain, const View& view, double error_px)
        : columns_(static_cast<std::size_t>(data_of(terrain).tree.columns())),
          flags_(columns_ * static_cast<std::size_t>(data_of(terrain).tree.rows())) {
        const CutInMemory in_memory(terrain, cut_budget);
        const LiveCut cut = in_memory.cut;
        CutSettings settings;
        settings.max_error_px = error_px;
        CutReport report;
        (void)rebuild_cut(cut, {&view, 1}, settings, report);
        const Frustum frustum = make_frustum(view);
        for_each_vertex(cut_mesh(cut).mesh, [&](const MeshVertex& v) {
            const Vec3 p = Vec3{terrain.x_m(v.column), v.height_m, terrain.z_m(v.row)} - view.eye_m;
            bool inside = true;
            for (int i = 0; i < 6; ++i) inside = inside && dot(frustum.normal[i], p) >= frustum.offset[i];
            std::uint8_t& flag = flags_[at(v)];
            count_ += inside && flag == 0;
            flag = inside;
        });
    }
    [[nodiscard]] double share(const MeshView& mesh) const {
        std::vector<std::uint8_t> left = flags_;
        std::size_t found = 0;
        for_each_vertex(mesh, [&](const MeshVertex& v) { found += std::exchange(left[at(v)], std::uint8_t{0}); });
        return static_cast<double>(found) / static_cast<double>(count_);
    }
    [[nodiscard]] std::size_t count() const { return count_; }

private:
    template <typename Visit>
    static void for_each_vertex(const MeshView& mesh, const Visit& visit) {
        for (const TileRange& range : mesh.tiles)
            for (std::uint32_t i = range.first_index; i < range.first_index + range.index_count; ++i)
                visit(mesh.vertices[mesh.indices[i]]);
    }
    [[nodiscard]] std::size_t at(const MeshVertex& v) const {
        return static_cast<std::size_t>(v.row) * columns_ + static_cast<std::size_t>(v.column);
    }
    std::size_t columns_, count_ = 0;
    std::vector<std::uint8_t> flags_;
};

// Teleports in succession with so much time or so many items a frame, each from the mesh that the last one left: how
// much of what the view will show stands after five frames, after how many does 99% of it, and what does an item take?
void teleport_recovery(benchmark::State& state, CutSettings settings) {
    const Scene& scene = mountains();
    const Terrain& t = scene.pack.terrain;
    const CutInMemory in_memory(t, cut_budget);
    const LiveCut cut = in_memory.cut;
    settings.max_error_px = scene.error_px;
    std::vector<double> frames_to_99;
    double after_five = 0, us = 0, items = 0;
    constexpr int teleports = 8;
    for (auto _ : state)
        for (int n = 0; n < teleports; ++n) {
            View view = flight_views(t, 0.25, 1)[0];
            view.eye_m.x = t.x_m(1024 + 2048 * (n % 2)), view.eye_m.z = t.z_m(700 + 380 * n);
            view.eye_m.y = data_of(t).ground_m(view.eye_m.x, view.eye_m.z) + 400;
            const Visible whole(t, view, settings.max_error_px);
            state.counters["visible_vertices"] = static_cast<double>(whole.count());
            CutReport report;
            int frame = 1;
            for (; frame <= 200; ++frame) {
                const auto start = Clock::now();
                (void)update_cut(cut, {&view, 1}, settings, report);
                us += us_since(start), items += report.work;
                const double share = whole.share(cut_mesh(cut).mesh);
                if (frame == 5) after_five += share / teleports;
                if (share >= 0.99) break;
            }
            frames_to_99.push_back(frame);
            if (frame < 5) after_five += 1.0 / teleports;
        }
    state.counters["frames_to_99"] = rank(frames_to_99, 0.5);
    state.counters["share_after_5"] = after_five;
    state.counters["ns_an_item"] = us * 1000 / items;
    state.counters["frames_to_99_worst"] = rank(frames_to_99, 1);
}

// Teleports to random places: what is claimed at once and what is wrong then, for how many frames the claim stays that
// coarse, and how far the first finer one is from what is true. Truth: every sample of the terrain, measured.
void teleport_claims(benchmark::State& state, double budget_us) {
    const Terrain& t = mountains().pack.terrain;
    const CutInMemory in_memory(t, cut_budget);
    const LiveCut cut = in_memory.cut;
    std::uint32_t seed = 1;
    const auto random = [&] { return (seed = seed * 1664525 + 1013904223) / 4294967296.0; };
    View view = flight_views(t, 0.25, 1)[0];
    CutSettings settings;
    settings.max_error_px = mountains().error_px;
    CutReport report;
    std::vector<double> coarse, at_once_px, before_px, claimed_px, ratio;
    (void)rebuild_cut(cut, {&view, 1}, settings, report);
    settings.max_time_us = budget_us;
    for (auto _ : state)
        for (int jump = 0; jump < 8; ++jump) {
            view.eye_m = {(0.15 + 0.7 * random()) * t.x_m(4096), 0, (0.15 + 0.7 * random()) * t.z_m(4096)};
            view.eye_m.y = data_of(t).ground_m(view.eye_m.x, view.eye_m.z) + 400;
            (void)update_cut(cut, {&view, 1}, settings, report);
            const Frustum frustum = make_frustum(view);
            before_px.push_back(measure_error(t, cut_mesh(cut).mesh, view, &frustum).max_px);
            at_once_px.push_back(report.error_bound_px);
            int frames = 0;
            for (; report.error_bound_px > coarse_thresholds * settings.max_error_px; ++frames)
                (void)update_cut(cut, {&view, 1}, settings, report);
            const double true_px = measure_error(t, cut_mesh(cut).mesh, view).max_px;
            if (true_px > report.error_bound_px) return state.SkipWithError("a claim was too low");
            coarse.push_back(frames);
            claimed_px.push_back(report.error_bound_px);
            ratio.push_back(report.error_bound_px / true_px);
        }
    state.counters["coarse_frames"] = rank(coarse, 0.5);
    state.counters["coarse_frames_worst"] = rank(coarse, 1);
    state.counters["claim_at_once_px"] = rank(at_once_px, 0.5);
    state.counters["claim_at_once_px_worst"] = rank(at_once_px, 1);
    state.counters["wrong_before_px"] = rank(before_px, 0.5);
    state.counters["first_claim_px"] = rank(claimed_px, 0.5);
    state.counters["claim_over_truth"] = rank(ratio, 0.5);
    state.counters["claim_over_truth_worst"] = rank(ratio, 1);
}

} // namespace

void declare_frames_that_time_ends() {
    declare("jumps", [](benchmark::State& s) { jumps(s, 1000); });
    for (const double cells : {10.0, 16.0})
        declare("follow-or-build/" + std::to_string(cells).substr(0, 4),
                [=](benchmark::State& s) { follow_or_build(s, cells, false); });
    declare("follow-or-build/thresholds", [](benchmark::State& s) { follow_or_build(s, 0.1, true); });
    declare("lag-1500us", [](benchmark::State& s) { lag(s, 1500); });
    declare("lag-500us", [](benchmark::State& s) { lag(s, 500); });
    declare("teleport-300us/all-around", [](benchmark::State& s) { teleport_budget(s, 1); });
    declare("teleport-300us/offscreen-8", [](benchmark::State& s) { teleport_budget(s, 8); });
    declare("teleport-2ms", [](benchmark::State& s) { teleport_recovery(s, {.max_time_us = 2000}); });
    declare("teleport-20000-items", [](benchmark::State& s) { teleport_recovery(s, {.max_work = 20'000}); });
    declare("teleport-5000-items", [](benchmark::State& s) { teleport_recovery(s, {.max_work = 5'000}); });
    declare("teleport-claims/2ms", [](benchmark::State& s) { teleport_claims(s, 2000); });
    declare("teleport-claims/300us", [](benchmark::State& s) { teleport_claims(s, 300); });
}

} // namespace fjell::bench
