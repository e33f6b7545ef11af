// The stages of a bake, in the order in which bake.cpp runs them (docs/notes/baking.md): from stores and the plan,
// which they only read, to stores and the spool, which they fill. Each is cut into units that read what earlier stages
// made and write places of their own, so that threads, memory and the order of units change nothing in the result, and
// a stage that was interrupted runs again from its beginning. All throw Failure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "baker/bake/bake.h"
#include "baker/bake/context.h"
#include "baker/bake/plan.h"
#include "baker/bake/region_stores.h"
#include "baker/maps/horizon.h"
#include "baker/maps/wetness.h"
#include "baker/pack/chunk_spool.h"
#include "baker/read/source.h"
#include "baker/store/store.h"

namespace fjell::baker {

// ---- heights

// has_ground(window, its heights, floats from row to row): asked of every piece of what was read into a store that
// reads as void where nobody has written (Store::unwritten_is_void). Pieces without are not written.
using HasGround = std::function<bool(const Window& piece, const float* heights, std::ptrdiff_t stride)>;
[[nodiscard]] ReadStatistics read_windows(const BakeContext& context, Store<float>& heights,
                                          const HasGround& has_ground = {});
struct ReadResult {
    SourceProperties properties;
    bool has_voids = false; // samples without height: NaN in the store
};
// all: of the whole terrain.
[[nodiscard]] ReadResult read_result(const BakeContext& context, const ReadStatistics& all);

// Only for heights with voids. marks: 1 where there was none; not written where the store does not exist.
struct FilledStores {
    Store<float>& heights;
    Store<std::uint8_t>& marks;
};
// The marks of a window alone.
void mark_voids(const BakeContext& context, const Store<float>& raw, const Window& window, Store<std::uint8_t>& marks);
inline constexpr std::uint64_t fill_piece_bytes = std::uint64_t{24} << 20; // that a thread takes which fills
void fill_heights(const BakeContext& context, const Store<float>& raw, const SourceProperties& properties,
                  const FilledStores& out);

[[nodiscard]] HeightStatistics measure_heights(const BakeContext& context, const HeightStores& heights);

// ---- maps: chunks of all mips, and texels of those that the next mip is made from

using TexelStore = Store<std::uint16_t>; // columns * channels by rows of a mip of all tiles
[[nodiscard]] TexelStore open_texels(const BakeContext& context, const MapPlan& maps, MapKind kind, std::uint32_t mip);

struct NearMapsOutput {
    TexelStore &colour, &normal; // the last near mip; not written where there is no further one
    ChunkSink& spool;
};
void make_near_maps(const BakeContext& context, const BakePlan& plan, const HeightStores& heights,
                    const NearMapsOutput& out);

struct FarMipInput {
    MapKind kind;
    std::uint32_t mip;
    const TexelStore& finer; // of mip - 1
};
struct FarMipOutput {
    TexelStore& texels; // of this mip; not written where it does not exist
    ChunkSink& spool;
};
// 16-bit texels of a window into the store of their mip.
void store_texels(TexelStore& store, const Window& at, MapKind kind, const Texels& texels);

// ---- horizon maps: levels of the heights (horizon.h) in one store, then near mips

[[nodiscard]] Store<float> open_levels(const BakeContext& context);
void make_levels(const BakeContext& context, const HeightStores& heights, Store<float>& levels);
[[nodiscard]] HorizonLevels levels_of(const BakeContext& context);

// Part of a level into rows of `to`, `stride` floats apart. From any thread.
using LevelReader = std::function<void(int level, const Window& w, float* to, std::ptrdiff_t stride)>;
// The window's rows follow each other.
using LevelWriter = std::function<void(const Window& w, const float* from)>;
[[nodiscard]] LevelReader levels_in(const BakeContext& context, const Store<float>& levels); // keeps the reference
// A window of a level, which is 1 at least, from the one below it. read: also of level 0, the heights.
void make_level(const BakeContext& context, int level, const Window& window, const LevelReader& read,
                const LevelWriter& write);

struct HorizonInput {
    const HeightStores& heights;
    const LevelReader& read_level; // 1 at least
};
struct HorizonOutput {
    TexelStore& texels; // the last near mip; not written where there is no further one
    ChunkSink& spool;
};
void make_near_horizons(const BakeContext& context, const BakePlan& plan, const HorizonInput& in,
                        const HorizonOutput& out);

// ---- splat maps: near mips, from the heights, rasters and a coarse grid of all of them

// Sums of the heights of squares of samples, which are cells of the grid of wetness or parts of one.
struct SquareSums {
    Window at; // of squares
    std::vector<double> sums;
};
// Of what is baked here.
[[nodiscard]] SquareSums sum_squares(const BakeContext& context, const Store<float>& heights);
// squares: of all of the terrain. Or from Wetness::index().
[[nodiscard]] Wetness make_wetness(const BakeContext& context, const SquareSums& all);
[[nodiscard]] Wetness found_wetness(const BakeContext& context, std::vector<float> index);

// What a tile's splat map is made from.
[[nodiscard]] SplatGround splat_ground(const BakeContext& context, const BakePlan& plan, const Wetness* wetness);

struct SplatOutput {
    TexelStore& texels; // as of HorizonOutput
    ChunkSink& spool;
};
// wetness: null: no rule asks for it.
void make_near_splat(const BakeContext& context, const BakePlan& plan, const HeightStores& heights,
                     const Wetness* wetness, const SplatOutput& out);

void make_far_mip(const BakeContext& context, const BakePlan& plan, const FarMipInput& in, const FarMipOutput& out);

// ---- vertices: errors, radii and pages, step by step from the finest one

struct FinestStepOutput {
    UnsaturatedStores& unsaturated; // of all coarser steps
    StepStores& step;
    MixedStores& mixed;
    ChunkSink& spool;
};
struct FinestStepResult {
    float ground_error_m = 0;       // the largest error on the ground of all steps: UnsaturatedError::on_ground
    std::uint64_t always_drawn = 0; // vertices of this step
    bool on_scale = true;           // all heights are whole height steps, bit for bit
};
[[nodiscard]] FinestStepResult make_finest_step(const BakeContext& context, const BakePlan& plan,
                                                const HeightStores& heights, const FinestStepOutput& out);

// The unsaturated errors of coarser steps alone, of terrain without holes and locks.
void measure_unsaturated(const BakeContext& context, const BakePlan& plan, const HeightStores& heights,
                         UnsaturatedStores& out);

struct CoarserStepInput {
    int z; // log2 of the step, at least 1
    bool holes;
    const UnsaturatedStores& unsaturated;
    const StepStores& finer;               // made by step z - 1
    const HeightStores* heights = nullptr; // where that has left codes alone
};
struct CoarserStepOutput {
    StepStores& step;   // not written where it does not exist
    MixedStores& mixed; // what finer steps wrote to it stays
    ChunkSink& spool;
};
// Returns the step's vertices that are always drawn: that locks keep in every mesh, or what these ask for; 0 without.
std::uint64_t make_coarser_step(const BakeContext& context, const BakePlan& plan, const CoarserStepInput& in,
                                const CoarserStepOutput& out);

// Pages of several steps, corners and the CRS. Returns the largest error in metres.
[[nodiscard]] float make_mixed_pages(const BakeContext& context, const BakePlan& plan, const MixedStores& mixed,
                                     ChunkSink& spool);

// ---- the pack

// Puts it together beside its place and renames it. Counts its bytes in the summary.
void write_pack(const BakeContext& context, const PackHeader& header, const ChunkSource& chunks, BakeSummary& summary);

// What a pack says of its making (pack/notes.h); and the bytes of its chunks, by kind, into the summary.
// Of this program and all of its options: two bakes of the same heights with the same number give the same pack.
[[nodiscard]] std::uint64_t options_hash(const BakeContext& context);
[[nodiscard]] std::string notes_of(const BakeContext& context, const BakeSummary& summary);
void count_bytes(const PackHeader& header, const std::vector<ChunkEntry>& entries, BakeSummary& summary);

} // namespace fjell::baker
