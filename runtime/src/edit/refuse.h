// What makes a stamp be refused: packs have codes for ground like their own.
#pragma once

#include "edit/state.h"

namespace fjell::edit {

// The steepest ground, as a difference between neighbours, whose spheres and errors have codes anywhere, if its heights
// are within the pack's.
[[nodiscard]] double steepest_of_codes(const EditsData& e);

// Have all levels codes for the rim of a hole, on flat ground at least?
[[nodiscard]] bool rims_have_codes(const PackHeader& header);

// Have all spheres and errors codes while a stamp's ground comes, piece by piece, and then? unknown: ask again when
// is_at_rest(), for codes may be larger than they need be. at_once: if its pieces come together.
enum class Fit { yes, no, unknown };
[[nodiscard]] Fit fits_codes(EditsData& e, const Change& change, bool& at_once);
// Are all vertices around these places loaded, and all errors measured?
[[nodiscard]] bool is_at_rest(const EditsData& e, const Rect& places);

} // namespace fjell::edit
