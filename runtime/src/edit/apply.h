// Stamps applied, piece by piece, and what keeps the bound meanwhile.
#pragma once

#include "edit/state.h"

namespace fjell::edit {

// As `refusals` in edits.cpp names them.
enum class Refusal : std::uint32_t { none, blocks, span, bound, number, paint, no_maps, locks };

// Has a stamp to wait: for pages, or until all is measured around it?
[[nodiscard]] bool is_held(const EditsData& e, Waiting& w);

// Does a stamp await a page of these places, whose vertices are of this step? A stream loads them whether a view wants
// them or not: from far away none would, and what has changed would never be seen.
[[nodiscard]] bool awaits_pages(const EditsData& e, const Rect& places, int step_log2);

// The next piece of a stamp whose pages are loaded. First all are looked at, so that what is refused changes nothing.
// Returns true when the stamp is done: applied, refused, or on its way (Waiting::moves). samples: grows by those whose
// heights have changed.
[[nodiscard]] bool apply_piece(EditsData& e, Waiting& w, double now_s, Refusal& refusal, std::uint32_t& samples);

// The same of a stamp that locks, or unlocks: it changes errors alone, and waits for no pages.
[[nodiscard]] bool lock_piece(EditsData& e, Waiting& w, Refusal& refusal);

// A step of a stamp that is on its way. True: it has come. One that cannot take a step, for its pages or for errors
// around it, takes it later. If its last step has no codes even then, because others have come beside it, it stays
// where it is, and that is the refusal.
[[nodiscard]] bool move_on(EditsData& e, Moving& m, double now_s, Refusal& refusal, std::uint32_t& samples);

} // namespace fjell::edit
