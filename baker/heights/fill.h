// Heights for voids, interpolated from what surrounds them: to be ground, or to give a hole's rim its slopes and
// colours.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "baker/store/store.h"

namespace fjell::baker {

// Filled heights are anchor_m plus whole quanta, so that a DEM with a step of its own keeps it; quantum_m 0: any.
struct FillStep {
    double quantum_m = 0, anchor_m = 0;
};

// Copies raw to out, and every NaN becomes a smooth continuation of the finite heights around it: a membrane, found
// from coarse to fine on a pyramid of means, with a fixed number of sweeps. A filled height depends on its place alone,
// not on how the work is cut. At least one height must be finite. make: a store for a level of the pyramid, 1/3 of raw
// in all; they are removed. O(samples), about 24 MB a thread.
struct FillInput {
    const Store<float>& raw;
    FillStep step;
    int threads = 1;
    std::function<Store<float>(const std::string& name, std::int64_t columns, std::int64_t rows)> make;
};
void fill_voids(const FillInput& input, Store<float>& out);

// ---- the same by parts, for shards: windows are of a level, whose sizes are halved and rounded up from level to level

// Means of what is there in each 2 x 2 of the finer level, NaN for none. True where voids are left.
bool halve_heights(const Store<float>& fine, const Window& window, int threads, Store<float>& coarse);
// A level's window filled, from its means and the coarser level, which is filled. Reads fill_halo places around it, and
// of the coarser level what seen_coarser says.
inline constexpr std::int32_t fill_halo = 16;
void fill_level(const Store<float>& level, const Store<float>& coarse, const FillStep& step, const Window& window,
                int threads, Store<float>& out);
[[nodiscard]] Window seen_coarser(const Window& window, const Window& level, const Window& coarse);

} // namespace fjell::baker
