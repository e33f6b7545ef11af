#include "baker/bake/plan.h"

#include <algorithm>

#include <fmt/format.h>

namespace fjell::baker {

namespace {

MapPlan plan_maps(const BakeContext& context, const CheckpointState& found) {
    const HeightStatistics& heights = found.heights;
    MapPlan maps;
    maps.tree = context.tree;
    std::copy_n(context.source.spacing_m, 2, maps.spacing_m);
    maps.colour_log2 = context.colour_log2;
    maps.normal_log2 = context.normal_log2;
    maps.horizon_log2 = context.horizon_log2;
    maps.splat_log2 = context.splat_log2;
    const std::string& path = context.options.ramp_path;
    const double least_m = static_cast<double>(heights.least_m), most_m = static_cast<double>(heights.most_m);
    maps.ramp = path.empty() ? default_ramp(least_m, most_m) : absolute(read_ramp(path), least_m, most_m);
    maps.image = context.image.get();
    maps.paint = context.source.paint();
    maps.smooth = smooth_ground(context.tree.columns(), context.tree.rows(), maps.spacing_m, found.native_quantum_m,
                                found.heights);
    return maps;
}

PackHeader make_header(const BakeContext& context, const HeightStatistics& heights, const BakePlan& plan) {
    PackHeader h{};
    const Tree& tree = context.tree;
    const HeightSource& source = context.source;
    h.columns = static_cast<std::uint32_t>(tree.columns());
    h.rows = static_cast<std::uint32_t>(tree.rows());
    h.tiles_x = static_cast<std::uint32_t>(tree.tiles_x);
    h.tiles_y = static_cast<std::uint32_t>(tree.tiles_y);
    h.tile_log2 = static_cast<std::uint32_t>(tree.tile_log2);
    h.order = context.options.order;
    h.estimate = context.options.estimate;
    h.nesting = static_cast<float>(context.options.nesting);
    std::copy_n(source.spacing_m, 2, h.spacing_m);
    std::copy_n(source.crs_origin, 2, h.crs_origin);
    for (const int axis : {0, 1}) h.crs_step[axis] = std::clamp(source.crs_step[axis], 0.0, 1e9);
    h.base_m = plan.height_scale.base_m;
    h.quantum_m = plan.height_scale.quantum_m;
    std::int32_t least = 0, most = 0;
    quantise(&heights.least_m, 1, plan.height_scale, &least);
    quantise(&heights.most_m, 1, plan.height_scale, &most);
    h.min_m = plan.height_scale.height_m(least);
    h.max_m = plan.height_scale.height_m(most);
    h.height_steps = static_cast<std::uint32_t>(most);
    h.error_floor_m = plan.scales.floor_m;
    h.error_ratio = plan.scales.ratio;
    h.error_nesting_steps = plan.scales.nesting_steps;
    std::copy_n(plan.scales.level_radius_m, 2 * tree.tile_log2, h.level_radius_m);
    h.voids = heights.voids;
    h.colour_log2 = plan.maps.colour_log2;
    h.normal_log2 = plan.maps.normal_log2;
    h.horizon_log2 = plan.maps.horizon_log2;
    h.splat_log2 = plan.maps.splat_log2;
    h.layer_bytes = static_cast<std::uint32_t>(context.splat.stored_names().size());
    h.crs_bytes = static_cast<std::uint32_t>(source.crs_wkt.size());
    return h;
}

// What a reader would refuse is refused before the work.
void check_header(const BakeContext& context, const PackHeader& header) {
    const Status s = check_ranges(header);
    if (s.ok()) return;
    throw Failure(
        1, fmt::format("no pack can hold this terrain: its {} is out of range ({} x {} samples, {} m apart, heights "
                       "{:.6g}..{:.6g} m in steps of {:.3g} m); change --spacing, --zscale or --zoffset, or cut the "
                       "height field",
                       s.field, header.columns, header.rows, context.source.spacing_m[0], header.base_m, header.max_m,
                       header.quantum_m));
}

} // namespace

BakePlan make_plan(const BakeContext& context, const CheckpointState& found, const std::optional<HeightScale>& given) {
    const HeightSource& source = context.source;
    BakePlan plan;
    plan.height_scale = given ? *given
                              : choose_height_scale(found.heights, {{source.spacing_m[0], source.spacing_m[1]},
                                                                    found.native_quantum_m,
                                                                    context.options.quantum_m,
                                                                    context.tree.side()});
    // The stored float is what readers test against.
    const double nesting = static_cast<double>(static_cast<float>(context.options.nesting));
    plan.scales = choose_scales({context.tree,
                                 {source.spacing_m[0], source.spacing_m[1]},
                                 plan.height_scale,
                                 found.heights,
                                 nesting,
                                 context.options.room_for_holes,
                                 context.options.room_for_locks || context.locks.in_metres(),
                                 context.locks.sharpest()});
    plan.leaf = LeafErrors(plan.scales.errors, plan.height_scale.quantum_m);
    plan.maps = plan_maps(context, found);
    plan.header = make_header(context, found.heights, plan);
    check_header(context, plan.header);
    return plan;
}

BakeSummary summary_of(const BakeContext& context, const CheckpointState& found, const PackHeader& header) {
    BakeSummary s;
    s.columns = context.tree.columns();
    s.rows = context.tree.rows();
    s.tree = context.tree;
    std::copy_n(header.spacing_m, 2, s.spacing_m);
    s.quantum_m = header.quantum_m;
    s.min_m = header.min_m;
    s.max_m = header.max_m;
    constexpr double fine_m = 0.01; // a centimetre
    if (context.options.quantum_m == 0 && header.quantum_m > std::max(found.native_quantum_m, fine_m) &&
        header.quantum_m <= least_quantum_m(found.heights) * 1.001)
        s.quantum_range_m = found.heights.tile_range_m;
    s.max_error_m = header.max_error_m;
    s.ground_error_m = header.voids || !context.locks.empty() ? found.ground_error_m : header.max_error_m;
    s.voids = header.voids;
    s.crs_wkt = context.source.crs_wkt;
    s.source = context.source.facts;
    if (context.image) s.images = context.image->accounts;
    s.locks = context.locks.account();
    s.always_drawn = found.always_drawn;
    s.heights = found.heights;
    s.smooth = smooth_ground(context.tree.columns(), context.tree.rows(), context.source.spacing_m,
                             found.native_quantum_m, found.heights);
    s.on_scale = found.on_scale != 0;
    if (s.always_drawn != 0) s.locks += fmt::format("; {} vertices are always drawn", s.always_drawn);
    s.lowest = found.lowest;
    s.highest = found.highest;
    return s;
}

} // namespace fjell::baker
