// Stamps applied, piece by piece; and what keeps the bound afterwards.
#pragma once

#include "edit/state.h"

namespace fjell::edit {

enum class Refusal : std::uint32_t { none, blocks, span, bound, number }; // as `refusals` in edits.cpp names them

// Are all vertices at these places loaded?
[[nodiscard]] bool all_loaded(const TerrainData& t, const Rect& places);

// The next piece of a stamp whose pages are loaded. First all are looked at, so that what is refused changes nothing.
// Returns true when the stamp is done: applied, or refused.
[[nodiscard]] bool apply_piece(EditsData& e, Waiting& w, Refusal& refusal, std::uint32_t& samples);

// Measures the next vertex whose error may be larger than it need be. False: nothing is left that can be measured.
// may_go_on: asked before each.
template <typename MayGoOn>
[[nodiscard]] bool measure_next(EditsData& e, const MayGoOn& may_go_on);
// Pages have come since: what could not be measured is tried again.
void retry_unmeasured(EditsData& e);

enum class Measuring { nothing, item, done };
// An item at most.
[[nodiscard]] Measuring measure_item(EditsData& e);
// What has been measured since is told to those who follow.
void flush_measured(EditsData& e);
[[nodiscard]] bool has_area_to_measure(const EditsData& e);

template <typename MayGoOn>
bool measure_next(EditsData& e, const MayGoOn& may_go_on) {
    return has_area_to_measure(e) && may_go_on() && measure_item(e) != Measuring::nothing;
}

// What errors of vertices around these places may have grown by, in metres, whatever was loaded then.
[[nodiscard]] double growth_m(const EditsData& e, const Rect& places);

// A page of the pack is about to be loaded: its heights as they are edited. arrays: decoded, errors not yet derived.
// True: some are; then restore_bounds() once its records are in place.
[[nodiscard]] bool restore_heights(EditsData& e, std::uint32_t tile, std::uint32_t page, PageArrays& arrays);
void restore_bounds(EditsData& e, std::uint32_t tile, std::uint32_t page);

} // namespace fjell::edit
