// What a stamp makes of one sample.
#pragma once

#include "edit/state.h"

namespace fjell::edit {

// Samples that a stamp may change, within the terrain.
[[nodiscard]] Rect samples_of(const TerrainData& t, const Stamp& stamp);

// Can it change a sample in this part of them? Told by distances; may say yes where it does not.
[[nodiscard]] bool may_change(const TerrainData& t, const Stamp& stamp, const Rect& samples);

// What the sample's neighbourhood looks like to a stamp: heights in metres.
struct Surroundings {
    double height_m; // now
    double pack_m;   // in the pack
    double mean_m;   // of it and its eight neighbours, for `smooth`
};
// The new height in metres; NaN: as it is.
[[nodiscard]] double stamped_m(const TerrainData& t, const Stamp& stamp, SampleIndex sample, const Surroundings& now);

[[nodiscard]] Status check_stamp(const Stamp& stamp);

} // namespace fjell::edit
