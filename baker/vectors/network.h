// Lines of a map as a network: cut to a terrain, divided into short links, joined where they share a place.
//
// Pure: metres east and south of the terrain's first sample, and nothing of heights. Lines that cross are joined where
// they do, a line that ends on another is joined to it, and so are places that are nearer than `snap_m`. There are no
// bridges. O(n log n) for n stations where lines lie apart; memory: some 150 bytes a station. Deterministic.
// Failure: io::Failure 1 for more than most_stations.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace fjell::baker {

using Place = std::array<double, 2>; // metres east, and south
[[nodiscard]] inline Place between(const Place& a, const Place& b, double share) {
    return {a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])};
}

struct Link {
    std::uint32_t from = 0, to = 0; // stations, in the direction of the line
    std::uint32_t line = 0;         // of those given
    double length_m = 0;
};

struct Network {
    std::vector<Place> stations;
    std::vector<Link> links; // no two have both ends and their direction in common
};
inline constexpr std::size_t most_stations = std::size_t{1} << 23;

struct NetworkOptions {
    double width_m = 0, height_m = 0; // of the terrain, from 0 on
    double step_m = 1;                // a link is no longer
    double snap_m = 0.25;             // less than a third of that
};
// A place that is not finite ends its line; another begins behind it.
[[nodiscard]] Network make_network(std::span<const std::vector<Place>> lines, const NetworkOptions& options);

// Leaves out the links between `gone` stations, one of their ends or both, and all stations without a link.
void leave_out(Network& network, const std::vector<bool>& gone);

// What of a line lies on the terrain, in pieces of two places or more.
[[nodiscard]] std::vector<std::vector<Place>> clipped(std::span<const Place> line, double width_m, double height_m);

// Two stations nearer to each other than `near_m` by a way that is not along the network: beside a bend, a crossing, or
// another line. Of one station to at most 96 others, which only lines that are drawn over each other have.
struct NearPair {
    std::uint32_t a = 0, b = 0;
    double distance_m = 0;
    double along_m = 0; // by the network; infinite: more than twice near_m
};
void near_pairs(const Network& network, double near_m, const std::function<void(const NearPair&)>& found);

// As few of a line's places as leave it within `off_m`.
[[nodiscard]] std::vector<Place> simplified(std::span<const Place> line, double off_m);

} // namespace fjell::baker
