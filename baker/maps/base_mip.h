// Mip 0 of the maps before block compression: colours from an image or a ramp, normals from heights.
#pragma once

#include "baker/maps/image.h"
#include "baker/maps/maps.h"
#include "baker/maps/tent.h"

namespace fjell::baker {

struct SampleAxes {
    TentAxis axes[2];
};
// From samples to the texels of mip 0.
[[nodiscard]] SampleAxes sample_axes(const MapPlan& plan, MapKind kind);

// Heights as they are, and the ground that slopes are taken from.
struct GroundWindows {
    HeightWindow heights, shape;
};
// Linear light, three channels.
[[nodiscard]] TexelPlanes base_colours(const MapPlan& plan, const GroundWindows& ground, const Window& texels,
                                       ImageReader* reader);
// East and south components of the unit normals.
[[nodiscard]] TexelPlanes base_normals(const MapPlan& plan, const HeightWindow& shape, const Window& texels);

} // namespace fjell::baker
