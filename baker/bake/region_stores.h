// What stages hand each other over the whole terrain, and what a region reads and writes of it.
//
// Places of step 2^z: every 2^z-th of the height scale grid's columns and rows, both ends included.
#pragma once

#include <cstdint>

#include "baker/bake/context.h"
#include "baker/errors/step.h"
#include "baker/heights/region.h"
#include "baker/store/store.h"

namespace fjell::baker {

// Samples, finite everywhere, and which of them are holes (1); that store does not exist where there are none.
struct HeightStores {
    const Store<float>& heights;
    const Store<std::uint8_t>& holes;
};

// What a centre hands on to the coarser step.
struct CentreRecord {
    std::int32_t steps = 0;
    std::uint8_t error = 0, radius = 0;
    std::uint16_t unused = 0;
    friend bool operator==(const CentreRecord&, const CentreRecord&) = default;
};
static_assert(sizeof(CentreRecord) == 8, "CentreRecord lies in a work file");
struct CentreCodes {
    std::uint8_t error = 0, radius = 0;
};

// What step 2^z leaves to the next one: the heights of its places, in height steps, the highest bit a hole; and its own
// centres. Of the finest step, where samples lie in memory and stay until the next step is made, only what samples do
// not say: room that is touched for the first time takes longer than quantising them again.
struct StepStores {
    Store<std::uint32_t> places; // of step 2^(z + 1)
    Store<CentreRecord> centres; // one a square of side 2^(z + 1)
    Store<CentreCodes> codes;    // of the same squares; instead of both
    [[nodiscard]] bool exist() const { return places.exists() || codes.exists(); }
    void remove();
};
// samples: what is used of it; no area: all.
[[nodiscard]] StepStores open_step(const BakeContext& context, int z, const Window& samples = {});
[[nodiscard]] StepStores open_step_codes(const BakeContext& context); // of the finest step

// Codes of errors before they are saturated, at places of step 2^z: what each region has measured inside of itself, so
// that the southern and eastern borders, which the neighbours measure too, lie apart: south has a row for each row of
// regions, east one for each column of them, along y.
struct UnsaturatedStores {
    Store<std::uint8_t> inside, south, east;
    int z = 1;
    void remove();
};
[[nodiscard]] UnsaturatedStores open_unsaturated(const BakeContext& context, int z = 1);
// Columns and rows of the places of step 2^z of the whole terrain.
[[nodiscard]] Window places_of(const Tree& tree, int z);

// Vertices whose pages hold several steps, at places of step 2^mixed_log2: error code, radius code and void_bit; and
// heights as in StepStores.
struct MixedStores {
    Store<std::uint16_t> records;
    Store<std::uint32_t> heights;
    void remove();
};
[[nodiscard]] MixedStores open_mixed(const BakeContext& context);

// Of the records of steps from 2^first to 2^last; with_rest: and of all places that no vertex owns, which stay zero.
// What an interrupted stage may have written of further steps does not count.
[[nodiscard]] Digest records_digest(const BakeContext& context, const MixedStores& stores, int first, int last,
                                    bool with_rest);

inline constexpr std::uint32_t hole_flag = 0x80000000u; // of stored heights

// ---- what a region reads, from twice square (-1, -1) of it on, as errors/step.h wants it

[[nodiscard]] QuantisedHeights load_heights(const BakeContext& context, const HeightScale& scale,
                                            const HeightStores& stores, const Region& region);
// What step z has of the step before: its own places, and the finer centres. holes: null: there are none.
struct FinerInput {
    VertexPlanes<std::int32_t>& steps;
    VertexPlanes<std::uint8_t>* holes;
    FinerCentres& centres;
};
// tile_log2: of the tree.
void load_finer(const StepStores& finer, const Region& region, int z, int tile_log2, const Scales& scales,
                const FinerInput& out);
// The same of step 1, from the codes of the finest step and the samples.
void load_finest(const BakeContext& context, const StepStores& finest, const HeightStores& stores, const Region& region,
                 const Scales& scales, const FinerInput& out);
// The larger of what the regions on both sides of a border have measured.
void load_unsaturated(const BakeContext& context, const UnsaturatedStores& stores, std::int64_t region_index, int z,
                      VertexPlanes<std::uint8_t>& error);

// ---- what a region writes

void store_unsaturated(const BakeContext& context, std::int64_t region_index, const Patch<std::uint8_t>& errors,
                       UnsaturatedStores& stores);

// A step of a region with its errors saturated and its radii.
struct StepResult {
    const Region& region;
    const StepInput& step;
    const Radii& radii;
    const VertexPlanes<std::uint8_t>* holes; // null: none
};
void store_step(const StepResult& result, StepStores& stores);
// For steps of at least 2^mixed_log2.
void store_mixed(const StepResult& result, int mixed_log2, MixedStores& stores);

} // namespace fjell::baker
