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

} // namespace fjell::baker
