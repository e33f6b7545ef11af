// Radii of vertices on ground that has been edited: as a bake has them (baker/errors/step.cpp), for a few vertices.
#pragma once

#include "edit/state.h"

namespace fjell::edit {

[[nodiscard]] RadiusTerms radius_terms(const TerrainData& t);
// What ways along the ground, and heights, may be longer by where they are floats.
struct Pads {
    double ground_m, height_m;
};
[[nodiscard]] Pads pads_of(const PackHeader& header, const Tree& tree);

// Radii of all vertices whose spheres may depend on heights at `changed`, of all steps. Where something below a vertex
// is not loaded, its radius is raised by what heights have moved by at most: by_m. Returns whether all was loaded.
// Notes as changes those that differ and lie farther away than followers of changed heights look: blocks share codes.
// O(places changed, and some hundreds a step).
[[nodiscard]] bool nest_radii(EditsData& e, const Ground& ground, const Rect& changed, double by_m);
// The same of pages that have come: of all vertices of 2^from_z and larger steps that may depend on `places`, all of
// which are noted.
[[nodiscard]] bool nest_radii_of_pages(EditsData& e, const Rect& places, int from_z, Missing& missing);

// Raises the radius of one vertex to what those of its children that are loaded ask for.
void contain_children(const EditsData& e, const Ground& ground, const Plane& plane, std::int32_t i, std::int32_t j);

// For those who follow (TerrainData::changed_ground). step_log2: heights_changed, or of the vertices that have changed.
void push_change(EditsData& e, const Rect& places, int step_log2, bool holes = false);

} // namespace fjell::edit
