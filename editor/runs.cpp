#include "editor/runs.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

namespace fjell::editor {

namespace {

double mean_of(std::span<const session::FrameEntry> frames, double (*value)(const session::FrameEntry&)) {
    double sum = 0;
    for (const session::FrameEntry& f : frames) sum += value(f);
    return frames.empty() ? 0 : sum / static_cast<double>(frames.size());
}

double rank_of(std::span<const session::FrameEntry> frames, double share, double (*value)(const session::FrameEntry&)) {
    std::vector<double> values(frames.size());
    std::ranges::transform(frames, values.begin(), value);
    const auto n = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(n, 1) - 1);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

double update_of(const session::FrameEntry& f) {
    return f.update_us;
}

FlownPlace place_of(std::span<const session::FrameEntry> frames, std::span<const session::Pose> poses,
                    std::size_t first) {
    const auto dearest = static_cast<std::size_t>(
        std::distance(frames.begin(), std::ranges::max_element(frames, {}, &session::FrameEntry::update_us)));
    FlownPlace place;
    place.pose = poses[dearest];
    place.frame = static_cast<std::uint32_t>(first + dearest);
    place.update_us = static_cast<float>(frames[dearest].update_us);
    place.vertices = frames[dearest].vertices;
    for (const session::FrameEntry& f : frames) {
        place.error_px = std::max(place.error_px, static_cast<float>(f.error_bound_px));
        place.exhausted |= f.exhausted;
        place.measured_px = std::max(place.measured_px, static_cast<float>(f.verified_px.value_or(-1)));
    }
    return place;
}

// Of the nearest place that has one.
void spread_measured(std::vector<FlownPlace>& places) {
    std::vector<std::size_t> measured;
    for (std::size_t i = 0; i < places.size(); ++i)
        if (places[i].measured_px >= 0) measured.push_back(i);
    std::size_t at = 0;
    for (std::size_t i = 0; i < places.size() && !measured.empty(); ++i) {
        const auto away = [&](std::size_t from) { return from > i ? from - i : i - from; };
        while (at + 1 < measured.size() && away(measured[at + 1]) < away(measured[at])) ++at;
        places[i].measured_px = places[measured[at]].measured_px;
    }
}

std::vector<std::uint16_t> worst_of(const FlownRun& run, float (*value)(const FlownPlace&), double above) {
    std::vector<std::uint16_t> order(run.places.size());
    std::iota(order.begin(), order.end(), std::uint16_t{0});
    std::ranges::stable_sort(order, std::greater{}, [&](std::uint16_t i) { return value(run.places[i]); });
    const int apart = static_cast<int>(run.places.size() / 50);
    std::vector<std::uint16_t> worst;
    for (const std::uint16_t i : order) {
        if (worst.size() == worst_places || static_cast<double>(value(run.places[i])) <= above) break;
        const auto near = [&](std::uint16_t other) { return std::abs(int{i} - int{other}) < std::max(apart, 1); };
        if (std::ranges::none_of(worst, near)) worst.push_back(i);
    }
    return worst;
}

} // namespace

std::size_t FlownRun::place_at(double share) const {
    if (places.empty()) return 0;
    const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(places.size() - 1);
    return static_cast<std::size_t>(std::lround(at));
}

FlownRun make_run(std::span<const session::FrameEntry> frames, std::span<const session::Pose> poses) {
    FlownRun run;
    if (frames.size() < 2) return run;
    run.error_px = frames.front().error_px_requested;
    frames = frames.subspan(1);
    poses = poses.subspan(1);
    run.frames = frames.size();
    run.p50_us = rank_of(frames, 0.5, update_of);
    run.p99_us = rank_of(frames, 0.99, update_of);
    run.max_us = rank_of(frames, 1, update_of);
    run.error_p99_px = rank_of(frames, 0.99, [](const session::FrameEntry& f) { return f.error_bound_px; });
    run.vertices = mean_of(frames, [](const session::FrameEntry& f) { return static_cast<double>(f.vertices); });
    run.converged = mean_of(frames, [](const session::FrameEntry& f) { return f.converged ? 1.0 : 0.0; });
    const std::size_t count = std::min(frames.size(), most_places);
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t first = i * frames.size() / count, end = (i + 1) * frames.size() / count;
        run.places.push_back(
            place_of(frames.subspan(first, end - first), poses.subspan(first, end - first), first + 1));
    }
    spread_measured(run.places);
    run.worst[0] = worst_of(
        run, [](const FlownPlace& p) { return p.update_us; }, 0);
    run.worst[1] = worst_of(
        run, [](const FlownPlace& p) { return p.error_px; }, run.error_px * (1 + 1e-6));
    return run;
}

void Runs::add(std::shared_ptr<const FlownRun> run) {
    all.insert(all.begin(), std::move(run));
    if (all.size() > most_runs) all.pop_back();
    chosen.reset(); // which counts from the latest
}

void Runs::forget(std::size_t run) {
    all.erase(all.begin() + static_cast<std::ptrdiff_t>(run));
    chosen.reset();
}

} // namespace fjell::editor
