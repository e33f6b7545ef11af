// Where errors may be larger than they need be, and are measured again: what update_edits() does with the time left.
#pragma once

#include "edit/state.h"

namespace fjell::edit {

// The ground at these places has changed: errors of vertices of this step (its log2) and larger ones are to be
// measured, and spheres from 2^radii_z on to be worked out; or no_radii.
void push_area(EditsData& e, const Rect& places, int z, int radii_z);

[[nodiscard]] bool has_area_to_measure(const EditsData& e);
// One item: a vertex, or an area's spheres. There is one (has_area_to_measure()).
void measure_next(EditsData& e);
// Areas that want pages are tried again when some have come.
void retry_unmeasured(EditsData& e);
// What has been measured is told to those who follow.
void flush_measured(EditsData& e);

} // namespace fjell::edit
