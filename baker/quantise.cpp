// Quantise first, then measure errors on the quantised surface: what it differs from the original by is half a quantum,
// which every bound allows for (DESIGN invariant 3, section 5).
#include "baker/bake.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace fjell::baker {

namespace {

constexpr double page_steps = 65535;
constexpr double lattice_steps = max_lattice_steps - 65536;
constexpr double finest_quantum_m = 1e-6; // less is noise of the source's own floats

// The largest difference of heights within one tile: its coarsest page spans all of it.
double largest_tile_range(const Dem& dem, const Tree& tree) {
    double largest = 0;
    for (std::int32_t ty = 0; ty < tree.tiles_y; ++ty)
        for (std::int32_t tx = 0; tx < tree.tiles_x; ++tx) {
            const Coord from{tx * tree.side(), ty * tree.side()},
                to = tree.sample({from.x + tree.side(), from.y + tree.side()});
            float least = HUGE_VALF, most = -HUGE_VALF;
            for (std::int32_t y = from.y; y <= to.y; ++y) {
                const float* const row =
                    dem.heights_m.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(dem.columns);
                const auto [a, b] = std::minmax_element(row + from.x, row + to.x + 1);
                least = std::min(least, *a);
                most = std::max(most, *b);
            }
            largest = std::max(largest, static_cast<double>(most) - least);
        }
    return largest;
}

} // namespace

Lattice choose_lattice(const Dem& dem, const Tree& tree, double asked_m) {
    const auto [least, most] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    const double base = *least, range = static_cast<double>(*most) - base;
    // Rounded up, so that the highest sample still has a step.
    const double needed = std::max(largest_tile_range(dem, tree) / page_steps, range / lattice_steps) * (1 + 0x1p-22);
    const auto lattice = [&](double quantum) {
        return Lattice{static_cast<float>(base), std::nextafter(static_cast<float>(quantum), HUGE_VALF)};
    };
    if (asked_m > 0) {
        if (asked_m < std::max(needed, finest_quantum_m))
            throw Failure(2,
                          fmt::format("--quantum {} m is too small for these heights; give at least {:.3g}, or smaller "
                                      "tiles",
                                      asked_m, std::max(needed, finest_quantum_m)));
        return {static_cast<float>(base), static_cast<float>(asked_m)};
    }
    if (dem.native_quantum_m > 0 && needed <= dem.native_quantum_m)
        return {static_cast<float>(base), static_cast<float>(dem.native_quantum_m)};
    if (range == 0) return {static_cast<float>(base), 1.0f};
    const double of_use = std::min({0.01, dem.spacing_m[0] / 100, dem.spacing_m[1] / 100});
    return lattice(std::max({needed, of_use, finest_quantum_m}));
}

std::vector<std::int32_t> quantise(const Dem& dem, const Lattice& lattice) {
    std::vector<std::int32_t> steps(dem.heights_m.size());
    const double base = lattice.base_m, per_metre = 1 / static_cast<double>(lattice.quantum_m);
    for (std::size_t i = 0; i < steps.size(); ++i)
        steps[i] = static_cast<std::int32_t>(
            std::clamp(std::round((dem.heights_m[i] - base) * per_metre), 0.0, static_cast<double>(max_lattice_steps)));
    return steps;
}

} // namespace fjell::baker
