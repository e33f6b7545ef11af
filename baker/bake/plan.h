// What is fixed once all heights were measured: scales, maps and the pack's header.
#pragma once

#include <optional>

#include "baker/bake/checkpoint.h"
#include "baker/bake/context.h"
#include "baker/heights/scales.h"
#include "baker/maps/maps.h"
#include "fjell/pack.h"
#include "shared/page.h"

namespace fjell::baker {

struct BakePlan {
    HeightScale height_scale;
    Scales scales;
    LeafErrors leaf;
    MapPlan maps;
    PackHeader header{}; // without the largest error and what write_pack fills in
};

// found: of the stages up to `measure`. given: the height scale, where it is not to be chosen. Throws Failure for a
// terrain that no pack can hold and for a ramp that is none.
[[nodiscard]] BakePlan make_plan(const BakeContext& context, const CheckpointState& found,
                                 const std::optional<HeightScale>& given = {});

// All of the summary but times and sizes. header: with the largest error.
[[nodiscard]] BakeSummary summary_of(const BakeContext& context, const CheckpointState& found,
                                     const PackHeader& header);

} // namespace fjell::baker
