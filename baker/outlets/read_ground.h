// All heights of a source at once, for files that are written whole.
//
// O(samples); memory: 4 bytes a sample, 9 while holes are filled. Deterministic for any number of threads. Throws
// Failure: 1 the source, 3 too little memory.
#pragma once

#include <cstdint>

#include "baker/bake/bake.h"
#include "baker/read/array_source.h"
#include "baker/read/source.h"
#include "baker/store/store.h"

namespace fjell::baker {

struct Ground {
    std::int32_t columns = 0, rows = 0;
    double spacing_m[2] = {1, 1};
    double quantum_m = 0;       // the step that heights are multiples of, from anchor_m; 0: not known
    double anchor_m = 0;        // a height on that step
    float min_m = 0, max_m = 0; // of ground that was read
    std::uint64_t holes = 0;    // samples without a height: NaN, or filled
    Store<float> heights_m;     // row by row, from the north-west

    [[nodiscard]] const float* row(std::int64_t y) const {
        return reinterpret_cast<const float*>(heights_m.in_memory()) + y * columns;
    }
    [[nodiscard]] HeightArray array() const; // of the heights, in place
};

enum class GroundHoles : std::uint8_t { as_source, fill, refuse }; // as_source: NaN, unless --nodata fills them

[[nodiscard]] Ground read_ground(const HeightSource& source, GroundHoles holes, int threads, const Progress& progress);

} // namespace fjell::baker
