#include "baker/vectors/profile.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <utility>

namespace fjell::baker {

namespace {

// What lies beside each place: entries first[place] to first[place + 1].
struct Beside {
    std::vector<std::uint32_t> first, to;
    std::vector<double> by; // as long as `to`, or empty
};

template <typename Pair, typename Ends, typename Weight>
Beside beside(std::size_t places, std::span<const Pair> pairs, bool both_ways, const Ends& ends, const Weight& weight) {
    Beside all;
    all.first.assign(places + 2, 0);
    for (const Pair& pair : pairs) {
        const auto [a, b] = ends(pair);
        ++all.first[a + 2];
        if (both_ways) ++all.first[b + 2];
    }
    std::partial_sum(all.first.begin(), all.first.end(), all.first.begin());
    all.to.resize(all.first.back()), all.by.resize(all.first.back());
    for (const Pair& pair : pairs) {
        const auto [a, b] = ends(pair);
        all.to[all.first[a + 1]] = b, all.by[all.first[a + 1]++] = weight(pair);
        if (both_ways) all.to[all.first[b + 1]] = a, all.by[all.first[b + 1]++] = weight(pair);
    }
    return all;
}

// The largest heights that keep the limits and are nowhere above `most_m`: Dijkstra's method from all places at once.
std::vector<double> largest_below(std::vector<double> most_m, const Beside& limits) {
    using Entry = std::pair<double, std::uint32_t>;
    std::vector<Entry> entries(most_m.size());
    for (std::uint32_t i = 0; i < most_m.size(); ++i) entries[i] = {most_m[i], i};
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue(std::greater<>(), std::move(entries));
    while (!queue.empty()) {
        const auto [height_m, at] = queue.top();
        queue.pop();
        if (height_m > most_m[at]) continue; // it has come down since
        for (std::uint32_t i = limits.first[at]; i < limits.first[at + 1]; ++i)
            if (const double there_m = height_m + limits.by[i]; there_m < most_m[limits.to[i]]) {
                most_m[limits.to[i]] = there_m;
                queue.emplace(there_m, limits.to[i]);
            }
    }
    return most_m;
}

} // namespace

std::vector<double> limited_heights(std::span<const double> ground_m, std::span<const HeightLimit> limits) {
    const Beside graph = beside(
        ground_m.size(), limits, true, [](const HeightLimit& l) { return std::pair(l.a, l.b); },
        [](const HeightLimit& l) { return l.most_m; });
    std::vector<double> upside_down(ground_m.size());
    std::ranges::transform(ground_m, upside_down.begin(), std::negate<>());
    std::vector<double> low = largest_below({ground_m.begin(), ground_m.end()}, graph);
    const std::vector<double> high = largest_below(std::move(upside_down), graph); // but for its sign
    for (std::size_t i = 0; i < low.size(); ++i) low[i] = 0.5 * (low[i] - high[i]);
    return low;
}

std::vector<double> without_bumps(std::span<const double> ground_m, std::span<const Neighbours> pairs,
                                  double length_m) {
    std::vector<double> heights(ground_m.begin(), ground_m.end());
    if (pairs.empty() || !(length_m > 0)) return heights;
    const Beside graph = beside(
        ground_m.size(), pairs, true, [](const Neighbours& p) { return std::pair(p.a, p.b); },
        [](const Neighbours& p) { return 1 / std::max(p.distance_m, 1e-9); });
    double long_m = 0;
    for (const Neighbours& pair : pairs) long_m += pair.distance_m;
    // A pass adds half a square of the distance between places to the variance of what is averaged over.
    constexpr int most_passes = 1000;
    const double apart_m = std::max(long_m / static_cast<double>(pairs.size()), 1e-9),
                 wide = 0.25 * length_m / apart_m; // a bump of a length lies within two deviations to either side
    const int passes = static_cast<int>(std::min(2 * wide * wide, double{most_passes}));
    std::vector<double> next(heights.size());
    for (int pass = 0; pass < passes; ++pass) {
        for (std::size_t at = 0; at < heights.size(); ++at) {
            double sum = 0, weights = 0;
            for (std::uint32_t i = graph.first[at]; i < graph.first[at + 1]; ++i)
                sum += graph.by[i] * heights[graph.to[i]], weights += graph.by[i];
            // The ends of roads stay: whoever drives on finds the ground there.
            const bool end = graph.first[at + 1] - graph.first[at] < 2;
            next[at] = end ? heights[at] : 0.5 * (heights[at] + sum / weights);
        }
        std::swap(heights, next);
    }
    return heights;
}

std::vector<double> river_beds(std::span<const double> most_m, std::span<const Flow> flows) {
    const Beside graph = beside(
        most_m.size(), flows, false, [](const Flow& f) { return std::pair(f.from, f.to); },
        [](const Flow&) { return 0.0; });
    // From the lowest place on, each gives its height to all downstream that has none yet: that had a lower one.
    std::vector<std::uint32_t> order(most_m.size()), open;
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return most_m[i]; });
    std::vector<double> beds(most_m.size());
    std::vector<bool> done(most_m.size());
    for (const std::uint32_t lowest : order) {
        if (done[lowest]) continue;
        done[lowest] = true;
        open.assign(1, lowest);
        while (!open.empty()) {
            const std::uint32_t at = open.back();
            open.pop_back();
            beds[at] = most_m[lowest];
            for (std::uint32_t i = graph.first[at]; i < graph.first[at + 1]; ++i)
                if (!done[graph.to[i]]) done[graph.to[i]] = true, open.push_back(graph.to[i]);
        }
    }
    return beds;
}

} // namespace fjell::baker
