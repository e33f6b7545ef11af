// Stages that make errors, radii and pages: the finest step with the heights at hand, then step by step to the roots.
#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "baker/bake/stages.h"
#include "baker/errors/unsaturated.h"
#include "baker/pack/encode_page.h"

namespace fjell::baker {

namespace {

// A region's part of a step.
struct StepExtents {
    Coord square; // the first one
    std::int32_t nx, ny;
};
StepExtents extents_of(const Region& region, int z) {
    return {{region.first.x >> (z + 1), region.first.y >> (z + 1)},
            (region.last.x - region.first.x) >> (z + 1),
            (region.last.y - region.first.y) >> (z + 1)};
}

// What a region takes at its largest: its patch, split into planes, with codes, and the finer centres.
std::uint64_t region_bytes(std::int32_t cells, int z) {
    const double places = (cells >> z) + 16.0;
    return static_cast<std::uint64_t>(places * places * (z == 0 ? 16 : 40)) + (std::uint64_t{1} << 20);
}

UnitLoop loop_over_regions(const BakeContext& context, const char* name, int z) {
    const std::uint64_t count = context.region_count();
    return {name, count, context.workers_for(region_bytes(context.regions.cells(), z)),
            context.samples() / static_cast<double>(count) / (1 << (2 * z))};
}

std::uint8_t largest(const VertexPlane<std::uint8_t>& plane, std::int32_t columns, std::int32_t rows) {
    std::uint8_t most = 0;
    for (std::int32_t j = 0; j < rows; ++j)
        for (std::int32_t i = 0; i < columns; ++i) most = std::max(most, plane.row(j)[i]);
    return most;
}

// Vertices of the finest step at the rim and beside holes, one by one. Returns the step's largest error on the ground.
std::uint8_t correct_leaves(const BakeContext& context, const BakePlan& plan, const QuantisedHeights& heights,
                            const StepInput& step) {
    const Tree& tree = context.tree;
    const Region all = {{0, 0}, {tree.grid_columns() - 1, tree.grid_rows() - 1}};
    const UnsaturatedInput input{heights,
                                 all,
                                 plan.scales,
                                 plan.leaf,
                                 context.options.estimate,
                                 {context.source.spacing_m[0], context.source.spacing_m[1]}};
    const bool rim = straddles_rim(tree, {2 * (step.square.x + step.nx) + 1, 1}) ||
                     straddles_rim(tree, {1, 2 * (step.square.y + step.ny) + 1});
    if (!rim && !heights.has_voids())
        return std::max({largest(step.error.side_x, step.nx, step.ny + 1),
                         largest(step.error.side_y, step.nx + 1, step.ny),
                         largest(step.error.centre, step.nx, step.ny)});
    std::uint8_t worst = 0;
    const auto correct = [&](VertexPlane<std::uint8_t>& plane, std::int32_t columns, std::int32_t rows, Coord offset) {
        for (std::int32_t j = 0; j < rows; ++j)
            for (std::int32_t i = 0; i < columns; ++i) {
                const Coord v{2 * (step.square.x + i) + offset.x, 2 * (step.square.y + j) + offset.y};
                bool irregular = straddles_rim(tree, v);
                for (std::int32_t y = v.y - 1; !irregular && heights.has_voids() && y <= v.y + 1; ++y)
                    for (std::int32_t x = v.x - 1; x <= v.x + 1; ++x) irregular = irregular || heights.is_void({x, y});
                UnsaturatedError e{plane.row(j)[i], plane.row(j)[i]};
                if (irregular) e = unsaturated_error(input, v);
                plane.row(j)[i] = e.code;
                worst = std::max(worst, e.on_ground);
            }
    };
    correct(step.error.side_x, step.nx, step.ny + 1, {1, 0});
    correct(step.error.side_y, step.nx + 1, step.ny, {0, 1});
    correct(step.error.centre, step.nx, step.ny, {1, 1});
    return worst;
}

// The pages that hold nothing but this step; none in linear order and of steps that are smaller than a page.
void append_pages(const BakeContext& context, const BakePlan& plan, const StepResult& result, ChunkSink& spool) {
    const StepInput& in = result.step;
    const std::int32_t n = context.tree.side() >> (in.z + 1); // squares of a tile
    if (context.options.order == Order::linear || n < static_cast<std::int32_t>(page_squares)) return;
    ChunkBatch batch;
    context.regions.for_each_tile(result.region, [&](std::uint32_t tile, Coord corner) {
        const std::int32_t i0 = (corner.x >> (in.z + 1)) - in.square.x, j0 = (corner.y >> (in.z + 1)) - in.square.y;
        const auto pages = static_cast<std::uint32_t>(n) / page_squares;
        for (std::uint32_t py = 0; py < pages; ++py)
            for (std::uint32_t px = 0; px < pages; ++px) {
                const StepPageInput input{in.steps,
                                          in.error,
                                          result.holes,
                                          result.radii,
                                          i0 + static_cast<std::int32_t>(px * page_squares),
                                          j0 + static_cast<std::int32_t>(py * page_squares),
                                          in.z == 0 ? &plan.leaf : nullptr,
                                          plan.scales.errors,
                                          plan.header,
                                          in.z};
                const EncodedPage page = encode_step_page(input);
                batch.add_page({ChunkKind::geometry, tile, context.pages.page_at(in.z, px, py)}, page);
            }
    });
    spool.append(std::move(batch));
}

struct StepOutput {
    StepStores& step;
    MixedStores& mixed;
    ChunkSink& spool;
};

// From unsaturated errors to what a step leaves.
void finish_step(const BakeContext& context, const BakePlan& plan, const Region& region, const StepInput& step,
                 const VertexPlanes<std::uint8_t>* holes, const StepOutput& out) {
    saturate_errors(step);
    Radii radii;
    nest_radii(step, radii);
    const StepResult result{region, step, radii, holes};
    append_pages(context, plan, result, out.spool);
    if (out.step.exist()) store_step(result, out.step);
    if (step.z >= context.mixed_log2) store_mixed(result, context.mixed_log2, out.mixed);
}

} // namespace

float make_finest_step(const BakeContext& context, const BakePlan& plan, const HeightStores& heights,
                       const FinestStepOutput& out) {
    const double spacing_m[2] = {context.source.spacing_m[0], context.source.spacing_m[1]};
    std::vector<std::uint8_t> worst(context.region_count());
    context.run_units(loop_over_regions(context, "errors", 0), [&](std::uint64_t u) {
        const std::int64_t index = context.region_at(u);
        const Region region = context.regions.at(index);
        const auto [square, nx, ny] = extents_of(region, 0);
        std::optional<QuantisedHeights> ground = load_heights(context, plan.height_scale, heights, region);
        VertexPlanes<std::int32_t> steps(nx, ny);
        split_planes(ground->steps, steps);
        VertexPlanes<std::uint8_t> error(nx, ny), holes;
        const StepInput step{plan.scales, context.tree, {spacing_m[0], spacing_m[1]}, 0, square, nx, ny, steps, error};
        leaf_errors(step, plan.leaf);
        worst[u] = correct_leaves(context, plan, *ground, step);
        if (out.unsaturated.inside.exists()) {
            Patch<std::uint8_t> errors;
            const std::uint8_t of_coarser = unsaturated_errors(
                {*ground, region, plan.scales, plan.leaf, context.options.estimate, {spacing_m[0], spacing_m[1]}},
                errors);
            worst[u] = std::max(worst[u], of_coarser);
            store_unsaturated(context, index, errors, out.unsaturated);
        }
        const bool has_holes = ground->has_voids();
        if (has_holes) {
            holes = VertexPlanes<std::uint8_t>(nx, ny);
            split_planes(ground->voids, holes);
        }
        ground.reset(); // the largest of what a region takes
        finish_step(context, plan, region, step, has_holes ? &holes : nullptr, {out.step, out.mixed, out.spool});
    });
    return plan.scales.errors.metres[*std::max_element(worst.begin(), worst.end())];
}

void make_coarser_step(const BakeContext& context, const BakePlan& plan, const CoarserStepInput& in,
                       const CoarserStepOutput& out) {
    context.run_units(loop_over_regions(context, "steps", in.z), [&](std::uint64_t u) {
        const std::int64_t index = context.region_at(u);
        const Region region = context.regions.at(index);
        const auto [square, nx, ny] = extents_of(region, in.z);
        VertexPlanes<std::int32_t> steps(nx, ny);
        VertexPlanes<std::uint8_t> error(nx, ny), holes;
        if (in.holes) holes = VertexPlanes<std::uint8_t>(nx, ny);
        load_unsaturated(context, in.unsaturated, index, in.z, error);
        FinerCentres finer(nx, ny);
        const FinerInput from_finer{steps, in.holes ? &holes : nullptr, finer};
        if (in.finer.codes.exists())
            load_finest(context, in.finer, *in.heights, region, plan.scales, from_finer);
        else
            load_finer(in.finer, region, in.z, context.tree.tile_log2, plan.scales, from_finer);
        const StepInput step{plan.scales, context.tree, {context.source.spacing_m[0], context.source.spacing_m[1]},
                             in.z,        square,       nx,
                             ny,          steps,        error,
                             &finer};
        finish_step(context, plan, region, step, in.holes ? &holes : nullptr, {out.step, out.mixed, out.spool});
    });
}

namespace {

void append_corners(const BakeContext& context, const BakePlan& plan, const MixedStores& mixed, ChunkSink& spool) {
    const auto columns = static_cast<std::int32_t>(mixed.heights.columns());
    std::vector<std::uint32_t> corners, row(static_cast<std::size_t>(columns));
    const std::int32_t step = context.tree.side() >> context.mixed_log2;
    for (std::int32_t y = 0; y < mixed.heights.rows(); y += step) {
        mixed.heights.read({0, y, columns, 1}, row.data(), columns);
        for (std::size_t x = 0; x < row.size(); x += static_cast<std::size_t>(step))
            corners.push_back((row[x] & ~hole_flag) | (row[x] & hole_flag ? corner_void_bit : 0));
    }
    ChunkBatch batch;
    batch.add({ChunkKind::corners, 0, 0}, std::as_bytes(std::span(corners)), context.options.compression);
    const std::string layers = context.control.stored_names();
    if (!layers.empty())
        batch.add({ChunkKind::layers, 0, 0}, std::as_bytes(std::span(layers)), context.options.compression);
    if (plan.header.crs_bytes)
        batch.add({ChunkKind::crs, 0, 0}, std::as_bytes(std::span(context.source.crs_wkt)),
                  context.options.compression);
    spool.append(std::move(batch));
}

} // namespace

float make_mixed_pages(const BakeContext& context, const BakePlan& plan, const MixedStores& mixed, ChunkSink& spool) {
    const Tree& tree = context.tree;
    const int z = context.mixed_log2;
    const std::uint32_t pages = context.options.order == Order::linear ? context.pages.pages_per_tile() : 1;
    const std::int32_t places = (tree.side() >> z) + 1; // of a tile, a side
    const std::uint64_t place_count = static_cast<std::uint64_t>(places) * static_cast<std::uint64_t>(places);
    std::vector<std::uint8_t> worst(context.tile_count(), 0);
    context.run_units(
        {"root pages", context.tile_count(), context.workers_for(place_count * 8), static_cast<double>(place_count)},
        [&](std::uint64_t u) {
            const std::uint32_t tile = context.tile_at(u);
            const auto t = static_cast<std::int32_t>(tile);
            const Window w{t % tree.tiles_x * (places - 1), t / tree.tiles_x * (places - 1), places, places};
            std::vector<std::uint16_t> records(w.area());
            std::vector<std::uint32_t> steps(w.area());
            mixed.records.read(w, records.data(), places);
            mixed.heights.read(w, steps.data(), places);
            const auto vertex = [&](Coord c) {
                const std::size_t at = static_cast<std::size_t>(c.y >> z) * static_cast<std::size_t>(places) +
                                       static_cast<std::size_t>(c.x >> z);
                const bool corner = ((c.x | c.y) & (tree.side() - 1)) == 0;
                const auto error = static_cast<std::uint8_t>(corner ? 0 : records[at] & 0xff);
                const auto hole = static_cast<std::uint8_t>(steps[at] & hole_flag ? void_bit : 0);
                const auto radius = static_cast<std::uint8_t>(corner ? 0 : records[at] >> 8 & ~void_bit);
                return MixedPageVertex{static_cast<std::int32_t>(steps[at] & ~hole_flag), error,
                                       static_cast<std::uint8_t>(radius | hole)};
            };
            for (const std::uint16_t r : records) worst[u] = std::max(worst[u], static_cast<std::uint8_t>(r & 0xff));
            ChunkBatch batch;
            for (std::uint32_t page = 0; page < pages; ++page) {
                const EncodedPage encoded = encode_mixed_page(plan.header, page, vertex);
                batch.add_page({ChunkKind::geometry, tile, page}, encoded);
            }
            spool.append(std::move(batch));
        });
    append_corners(context, plan, mixed, spool);
    return plan.scales.errors.metres[*std::max_element(worst.begin(), worst.end())];
}

} // namespace fjell::baker
