// Raw numbers of a band to heights in metres, NaN where there is none, and counts of what they are (options.h: voids,
// implausible ones).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "baker/read/gdal_file.h"
#include "baker/read/options.h"
#include "baker/read/source.h"

namespace fjell::baker {

struct Decoding {
    Scaling scaling;
    bool whole = false;      // raw numbers are whole by their type
    bool all_ground = false; // a finite number that is no void is a height, however implausible
    struct Void {
        double number, slack; // raw numbers this close to it are voids
    };
    std::vector<Void> voids;
};

// count raw numbers of one row to heights; valid: 0 marks voids, null: all valid. A height is implausible only when it
// is so both as the file has it and as asked: 16-bit counts become plausible by --zscale, and exaggerated heights were
// plausible before. raw and to may be the same. Vectorised where nothing is void or implausible. O(count).
void decode_row(const float* raw, const std::uint8_t* valid, float* to, std::size_t count, const Decoding& decoding,
                const RowPlace& place, ReadStatistics& statistics);
void decode_row(const double* raw, const std::uint8_t* valid, float* to, std::size_t count, const Decoding& decoding,
                const RowPlace& place, ReadStatistics& statistics);

} // namespace fjell::baker
