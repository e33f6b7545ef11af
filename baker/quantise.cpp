// Quantise first, then measure errors as original heights minus quantised surface (DESIGN section 5).
#include "baker/bake.h"

#include <algorithm>
#include <cmath>

namespace fjell::baker {

namespace {
constexpr double lattice_steps = 65535;
constexpr float finest_quantum_m = 1e-6f; // a micrometre; less is noise of the source's own floats
} // namespace

Lattice choose_lattice(const Dem& dem) {
    const auto [least, most] = std::minmax_element(dem.heights_m.begin(), dem.heights_m.end());
    const double base = *least, range = static_cast<double>(*most) - base;
    if (dem.native_quantum_m > 0 && range <= dem.native_quantum_m * lattice_steps)
        return {static_cast<float>(base), static_cast<float>(dem.native_quantum_m)};
    if (range == 0) return {static_cast<float>(base), 1.0f};
    // Rounded up, so that the highest sample still has a step.
    const float quantum = std::nextafter(static_cast<float>(range / lattice_steps), HUGE_VALF);
    return {static_cast<float>(base), std::max(quantum, finest_quantum_m)};
}

std::vector<std::uint16_t> quantise(const Dem& dem, const Lattice& lattice) {
    std::vector<std::uint16_t> steps(dem.heights_m.size());
    const double base = lattice.base_m, per_metre = 1 / static_cast<double>(lattice.quantum_m);
    for (std::size_t i = 0; i < steps.size(); ++i) {
        const double step = std::round((dem.heights_m[i] - base) * per_metre);
        steps[i] = static_cast<std::uint16_t>(std::clamp(step, 0.0, lattice_steps));
    }
    return steps;
}

} // namespace fjell::baker
