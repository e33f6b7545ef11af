// What edits have made of the pack's heights, block by block: what a page is given again when it comes back.
#pragma once

#include "edit/state.h"

namespace fjell::edit {

// What samples of a row become: `count` of them, from `first` on. There are blocks for those that change, or room for
// them (missing_blocks()).
struct RowAfter {
    const std::int32_t* steps;
    const bool* holes;
};
void remember(EditsData& e, SampleIndex first, std::int32_t count, const Cell* before, const RowAfter& after);
// What a sample is in the pack, if it has been edited; otherwise false.
struct InPack {
    std::int32_t steps;
    bool hole;
};
[[nodiscard]] bool find_in_pack(const EditsData& e, SampleIndex sample, InPack& pack);

// Are samples of the block at a place, in blocks, edited?
[[nodiscard]] bool has_block_at(const EditsData& e, std::int32_t x, std::int32_t y);

// Would blocks and loaded pages still span fewer than 65,536 steps, if heights of samples at these places were in
// `heights`, and the pack's in `pack`?
[[nodiscard]] bool spans_fit(const EditsData& e, const Rect& places, const StepRange& heights, const StepRange& pack);
// How many blocks there are not yet of the samples that differ between e.piece and e.window, at these places.
[[nodiscard]] std::uint32_t missing_blocks(EditsData& e, const Rect& places);

// What errors of vertices around these places may be larger by than the pack says, in metres.
[[nodiscard]] double growth_m(const EditsData& e, const Rect& places);
// Has any ground there become a hole, or any hole ground?
[[nodiscard]] bool has_changed_holes(const EditsData& e, const Rect& places);

// A page of the pack is about to be loaded: its heights as they are edited, its errors and spheres as large as they may
// be by now, errors where there are locks as large as these may ask for. arrays: decoded, errors not yet derived.
// False: nothing near it is edited, or locked. Otherwise bound_derived() once they are, and nest_over_page() once its
// records are in place: what is above it nests over it again, and all is measured later.
[[nodiscard]] bool restore_page(const EditsData& e, std::uint32_t tile, std::uint32_t page, PageArrays& arrays);
void bound_derived(const EditsData& e, std::uint32_t tile, std::uint32_t page, PageArrays& arrays);
void nest_over_page(EditsData& e, std::uint32_t tile, std::uint32_t page);

} // namespace fjell::edit
