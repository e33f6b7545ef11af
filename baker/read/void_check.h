// What the user has to decide about heights that were read: implausible ones, voids, and numbers that look like voids.
#pragma once

#include <cstdint>
#include <string>

#include "baker/read/gdal_file.h"
#include "baker/read/options.h"
#include "baker/read/source.h"

namespace fjell::baker {

struct VoidCheck {
    std::string names; // of what was read, for messages
    NoData nodata = NoData::automatic;
    bool no_others = false;    // DeclaredVoids::no_others
    std::uint64_t samples = 0; // of the terrain
    bool warped = false;       // corners of what was reprojected are no one's fault
    Scaling scaling{};         // from numbers to metres
};

// Throws Failure 1 for implausible heights and for voids that the options refuse, and where there is no height at all;
// 2 for heights that no pack takes.
void refuse_voids(const ReadStatistics& statistics, const VoidCheck& check);
// Throws Failure 1 for numbers that look like voids; what may be ground and is only worth a line goes to `properties`.
void tell_voids(const VoidFindings& found, const VoidCheck& check, SourceProperties& properties);

} // namespace fjell::baker
